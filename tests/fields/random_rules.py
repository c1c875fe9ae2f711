"""Random tiny missions in which every rule is on or off."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from fields import eccentric

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M
from adr_opt.legs.service_limits import services_s
from adr_opt.problem.bodies import Station, Target
from adr_opt.problem.capture_windows import windows_from
from adr_opt.problem.chasers import AnyTank, AtStation, Chaser, InOrbit, Tank, TankByMass
from adr_opt.problem.given import among, of_rows
from adr_opt.problem.instance import Instance
from adr_opt.problem.numbering import Numbering
from adr_opt.problem.orbit import Orbit
from adr_opt.problem.settings import KeepOutZone, MissionSettings, Objective, TransferSettings

DAY_S = 86400.0


def random_mission(seed: int) -> Instance:
    """A few targets, with windows, zones, prizes, stations, starts and ends drawn by the seed."""
    rng = np.random.default_rng(seed)
    instance = adr_opt.generate(
        "tiny", int(rng.integers(10)), zones=int(rng.choice([0, 0, 3])), targets=5
    )
    duration = DAY_S * float(rng.uniform(0.3, 0.9))
    return _with_rules(instance, duration, rng)


def drifting_mission(seed: int) -> Instance:
    """The same under J2: short missions, and by turns months in which chasers wait for nodes.

    Grids are coarse, so that all can be enumerated.
    """
    if seed % 2:
        instance = random_mission(seed)
        rng = np.random.default_rng([2, seed])
        spacing = float(rng.choice([0.0, 0.0, 7000.0, 12000.0]))
        return instance.replace(
            dynamics="j2",
            transfer=TransferSettings(
                departure_spacing_s=spacing, delta_v_resolution_m_s=float(rng.choice([0.1, 8.0]))
            ),
        )
    rng = np.random.default_rng([3, seed])
    duration = DAY_S * float(rng.uniform(60.0, 200.0))
    instance = drifting_field(rng, duration)
    if rng.random() < 0.3:
        drawn = zip(rng.uniform(690e3, 990e3, 2), rng.uniform(0.0, duration, 2), strict=True)
        zones = [
            KeepOutZone(
                min_altitude_m=low,
                max_altitude_m=low + 20e3,
                start_s=begin,
                end_s=begin + 0.1 * duration,
            )
            for low, begin in drawn
        ]
        instance = instance.replace(keep_out_zones=tuple(zones))
    return _with_rules(
        instance, duration, rng, tanks=(400.0, 700.0, 1200.0, 2000.0), longest_service_s=4 * DAY_S
    )


def weeks_mission(seed: int) -> Instance:
    """Weeks under J2 on a grid of a day or two, where phases decide what drift legs cost."""
    rng = np.random.default_rng([5, seed])
    duration = DAY_S * float(rng.uniform(16.0, 40.0))
    field = drifting_field(rng, duration)
    rings = {
        name: tuple(
            each.replace(
                orbit=each.orbit.replace(
                    semi_major_axis_m=EARTH_RADIUS_M + float(rng.uniform(720e3, 900e3)),
                    raan_deg=float(rng.uniform(-3.0, 3.0) % 360.0),
                )
            )
            for each in getattr(field, name)
        )
        for name in ("stations", "targets")
    }
    settings = field.transfer.replace(
        drift_step_s=DAY_S * float(rng.choice([1.0, 1.5, 2.0])),
        max_drift_s=duration,
        departure_spacing_s=DAY_S * float(rng.choice([0.5, 1.0])),
    )
    return _with_rules(
        field.replace(transfer=settings, **rings),
        duration,
        rng,
        tanks=(150.0, 300.0, 500.0, 900.0),
        longest_service_s=DAY_S,
    )


def given_mission(seed: int) -> Instance:
    """The same over connections drawn at random; half of them between bodies without an orbit."""
    rng = np.random.default_rng([8, seed])
    return with_given_costs(given_field(seed), rng, orbits=bool(rng.random() < 0.5))


def given_field(seed: int) -> Instance:
    """The same between bodies that have one."""
    instance = random_mission(seed).replace(keep_out_zones=())
    return with_given_costs(instance, np.random.default_rng([9, seed]))


def with_given_costs(
    instance: Instance, rng: np.random.Generator, *, orbits: bool = True
) -> Instance:
    """An instance over connections drawn for its bodies, at odd times or with many at one time."""
    duration = instance.mission.duration_s
    if not orbits:
        instance = instance.replace(
            stations=tuple(each.replace(orbit=None) for each in instance.stations),
            targets=tuple(each.replace(orbit=None) for each in instance.targets),
            mission=MissionSettings(
                duration_s=duration,
                service_s=float(rng.choice([0.0, 1e-3, 1800.0])),
                refuel_revolutions=0.0,
            ),
        )
    regular, whole = rng.random() < 0.5, rng.random() < 0.3
    shortest = float(rng.choice([0.01, 60.0, 1800.0, 1800.0]))
    rows = []
    for i in instance.names:
        for j in instance.names:
            if i == j or rng.random() < 0.15:
                continue
            count = int(rng.integers(1, 16))
            leaves = rng.uniform(0.0, duration, count)
            takes = shortest * (0.25 * duration / shortest) ** rng.random(count)
            costs = rng.uniform(0.0, 300.0, count)
            if regular:
                leaves = duration * rng.integers(0, 7, count) / 7.0
            if whole:
                takes, costs = np.ceil(takes / 1800.0) * 1800.0, np.floor(costs / 50.0) * 50.0
            rows += [(i, j, at, at + t, c) for at, t, c in zip(leaves, takes, costs, strict=True)]
    columns = ("origin", "destination", "departure_s", "arrival_s", "delta_v_m_s")
    given = of_rows(
        {name: [row[at] for row in rows] for at, name in enumerate(columns)}, instance.names
    )
    return instance.with_given(given)


def drifting_field(rng: np.random.Generator, duration_s: float, targets: int = 5) -> Instance:
    """A station and targets that wait months for each other's nodes, on a coarse grid."""
    drawn = adr_opt.generate("tiny", 0, targets=targets)
    return drawn.replace(
        name="drifting",
        dynamics="j2",
        stations=tuple(each.replace(orbit=_orbit(rng)) for each in drawn.stations),
        targets=tuple(each.replace(orbit=_orbit(rng)) for each in drawn.targets),
        mission=MissionSettings(duration_s=duration_s, service_s=DAY_S),
        transfer=TransferSettings(
            min_altitude_m=680e3,
            max_altitude_m=1000e3,
            delta_v_resolution_m_s=float(rng.choice([0.1, 5.0])),
            departure_spacing_s=DAY_S * float(rng.choice([3.0, 7.0])),
            drift_step_s=DAY_S * float(rng.choice([8.0, 12.5])),
            max_drift_s=duration_s * float(rng.choice([0.4, 1.0])),
        ),
    )


def _orbit(rng: np.random.Generator) -> Orbit:
    """One of many at one inclination, with nodes not too far apart."""
    return Orbit(
        semi_major_axis_m=EARTH_RADIUS_M + float(rng.uniform(790e3, 870e3)),
        eccentricity=float(rng.choice([0.0, 1.0]) * rng.uniform(0.0, 0.004)),
        inclination_deg=float(rng.uniform(70.8, 71.2)),
        raan_deg=float(rng.uniform(-9.0, 9.0) % 360.0),
        argument_of_perigee_deg=float(rng.uniform(0.0, 360.0)),
        true_anomaly_deg=float(rng.uniform(0.0, 360.0)),
    )


def _with_rules(
    instance: Instance,
    duration: float,
    rng: np.random.Generator,
    *,
    tanks: tuple[float, ...] = (150.0, 300.0, 500.0, 900.0),
    longest_service_s: float = 9000.0,
) -> Instance:
    """Every rule on or off."""

    def chance(share: float) -> bool:
        return bool(rng.random() < share)

    targets = [
        target.replace(prize=float(rng.choice([0.0, 0.3, 1.0, 1.0, 2.5])))
        for target in instance.targets[: rng.integers(3, 6)]
    ]
    if chance(0.3):
        targets[1] = targets[1].replace(orbit=targets[0].orbit)
    if chance(0.3):
        orbit = targets[2].orbit.replace(inclination_deg=targets[0].orbit.inclination_deg)
        targets[2] = targets[2].replace(orbit=orbit.replace(raan_deg=targets[0].orbit.raan_deg))
    if chance(0.4):
        for number in range(len(targets)):
            if chance(0.4):
                opens = float(rng.uniform(0.0, 0.6)) * duration * chance(0.6)
                closes = float(rng.uniform(opens, duration)) if chance(0.6) else None
                targets[number] = targets[number].replace(window_s=(opens, closes))
    if chance(0.25):
        number = int(rng.integers(len(targets)))
        targets[number] = targets[number].replace(required=True)
    stations = list(instance.stations)
    if chance(0.25):
        there = targets[0].orbit.replace(true_anomaly_deg=77.0)
        stations.append(Station(name="second station", orbit=there))
    chaser = instance.chaser
    changes: dict[str, object] = {}
    if chance(0.2):
        start = stations[0].orbit.replace(true_anomaly_deg=123.0)
        changes["start"] = InOrbit(orbit=start)
        if chance(0.3):
            stations = []
    if stations and chance(0.25):
        changes["end"] = AtStation(station=stations[-1].name)
    if chance(0.2):
        changes["max_targets"] = int(rng.integers(1, 4))
    if chance(0.25):
        begin = float(rng.uniform(0.0, 0.3)) * duration
        changes["available_s"] = (begin, float(rng.uniform(0.7, 1.1)) * duration)
    changes["tank"] = chaser.tank.replace(delta_v_m_s=float(rng.choice(tanks)))
    service = (
        {"service_s": float(rng.uniform(0.0, longest_service_s))}
        if chance(0.3)
        else {"service_revolutions": float(rng.choice([0.0, 0.5, 1.0]))}
    )
    return instance.replace(
        stations=tuple(stations),
        targets=tuple(targets),
        chasers=(begun(chaser.replace(**changes), rng),),
        mission=MissionSettings(duration_s=duration, **service),
        objective=Objective(cost=str(rng.choice(["delta-v", "delta-v", "duration"]))),
    )


def begun(chaser: Chaser, rng: np.random.Generator) -> Chaser:
    """The same with a tank that is not full at the start, or is, where that may be said.

    What is drawn after it does not depend on it.
    """
    (own,) = rng.spawn(1)
    if isinstance(chaser.start, AtStation):
        return chaser.replace(tank=filled(chaser.tank))
    if own.random() < 0.4:
        return chaser.replace(tank=filled(chaser.tank))
    share = float(own.choice([0.0, 0.3, 0.7, 0.9, 1.0]))
    if isinstance(chaser.tank, TankByMass):
        initial = {"initial_propellant_kg": share * chaser.tank.propellant_kg}
    else:
        initial = {"initial_delta_v_m_s": share * chaser.tank.delta_v_m_s}
    return chaser.replace(tank=chaser.tank.replace(**initial))


def filled(tank: AnyTank) -> AnyTank:
    """The same tank, full at the start."""
    if isinstance(tank, TankByMass):
        return tank.replace(initial_propellant_kg=None)
    return tank.replace(initial_delta_v_m_s=None)


def all_filled(instance: Instance) -> Instance:
    """The same with tanks that are full at the start."""
    chasers = (each.replace(tank=filled(each.tank)) for each in instance.chasers)
    return instance.replace(chasers=tuple(chasers))


def started(instance: Instance, seed: int) -> Instance:
    """The same with chasers that start in orbits with some of their ΔV; some tanks by mass."""
    rng = np.random.default_rng([12, seed])
    chasers = []
    for chaser in instance.chasers:
        orbit = instance.targets[int(rng.integers(len(instance.targets)))].orbit
        start = InOrbit(orbit=orbit.replace(true_anomaly_deg=float(rng.uniform(0.0, 360.0))))
        full, share = chaser.tank.delta_v_m_s, float(rng.choice([0.0, 0.2, 0.5, 0.8, 1.0]))
        tank: AnyTank = Tank(delta_v_m_s=full, initial_delta_v_m_s=share * full)
        if rng.random() < 0.3:
            propellant = float(500.0 * np.expm1(full / (9.80665 * 250.0)))
            tank = TankByMass(
                dry_mass_kg=500.0,
                propellant_kg=propellant,
                isp_s=250.0,
                initial_propellant_kg=share * propellant,
            )
        chasers.append(chaser.replace(start=start, tank=tank))
    return instance.replace(chasers=tuple(chasers))


def started_mission(seed: int) -> Instance:
    """A mission of one chaser that starts with part of a tank, by turns of each kind."""
    instance = started((random_mission, drifting_mission, random_mission)[seed % 3](seed), seed)
    if seed % 3 < 2:
        return instance
    instance = instance.replace(keep_out_zones=())
    return with_given_costs(instance, np.random.default_rng([13, seed]))


def by_days(instance: Instance, seed: int) -> Instance:
    """The same by ΔV with a price of a day: none, the default, up to where time alone counts."""
    price = (0.0, None, 5.0, 50.0, 700.0, 1e5)[seed % 6]
    return instance.replace(objective=Objective(time_m_s_per_day=price))


def random_campaign(seed: int, draw: Callable[[int], Instance] = random_mission) -> Instance:
    """The same for two or three chasers, some of them of one kind."""
    rng = np.random.default_rng([4, seed])
    instance = draw(seed)
    chasers = [instance.chaser]
    for number in range(2, int(rng.integers(2, 4)) + 1):
        chaser = chasers[int(rng.integers(len(chasers)))].replace(name=f"chaser-{number}")
        changes: dict[str, object] = {}
        if rng.random() < 0.3:
            share = float(rng.uniform(0.5, 1.5))
            full = share * chaser.tank.delta_v_m_s
            changes["tank"] = filled(chaser.tank).replace(delta_v_m_s=full)
        if rng.random() < 0.25:
            changes["available_s"] = (
                float(rng.uniform(0.0, 0.4)) * instance.mission.duration_s,
                None,
            )
        if rng.random() < 0.25:
            orbit = instance.targets[0].orbit.replace(true_anomaly_deg=200.0)
            changes["start"] = InOrbit(orbit=orbit)
        if rng.random() < 0.25:
            changes["max_targets"] = int(rng.integers(0, 3))
        if rng.random() < 0.2:
            changes["end"] = "anywhere"
        chasers.append(chaser.replace(**changes))
        if changes:
            chasers[-1] = begun(chasers[-1], rng)
    made = _changed(instance, name=f"campaign-{seed}", chasers=tuple(chasers))
    return _regiven(made, rng)


def mixed_campaign(seed: int, draw: Callable[[int], Instance] = random_mission) -> Instance:
    """The same where nearly all chasers differ: in where they start and end, when, and their tanks.

    By turns with prizes that have no common step.
    """
    rng = np.random.default_rng([5, seed])
    instance = draw(seed)
    duration = instance.mission.duration_s
    targets, stations = list(instance.targets), list(instance.stations)
    if rng.random() < 0.4:
        targets = [target.replace(prize=float(rng.uniform(0.1, 2.0))) for target in targets]
    if rng.random() < 0.3:
        number = int(rng.integers(len(targets)))
        targets[number] = targets[number].replace(required=True)
    if rng.random() < 0.4:
        for number in np.flatnonzero(rng.random(len(targets)) < 0.5):
            opens = float(rng.uniform(0.0, 0.5)) * duration
            closes = float(rng.uniform(opens, duration)) if rng.random() < 0.8 else None
            targets[number] = targets[number].replace(window_s=(opens, closes))
    if len(stations) == 1 and rng.random() < 0.6:
        there = targets[-1].orbit.replace(true_anomaly_deg=50.0)
        stations.append(Station(name="station of its own", orbit=there))
    chasers = [_chaser(instance.chaser, stations, targets, duration, rng)]
    for number in range(2, int(rng.choice([2, 3, 3])) + 1):
        if rng.random() < 0.25:
            made = chasers[int(rng.integers(len(chasers)))]
        else:
            made = _chaser(instance.chaser, stations, targets, duration, rng)
        chasers.append(made.replace(name=f"chaser-{number}"))
    made = _changed(
        instance,
        name=f"mixed-{seed}",
        targets=tuple(targets),
        stations=tuple(stations),
        chasers=tuple(chasers),
    )
    return _regiven(made, rng)


def _changed(instance: Instance, **changes: Any) -> Instance:
    """The same with changes; of given connections those between bodies that are still there."""
    if instance.given is not None:
        parts = [changes.get(part, getattr(instance, part)) for part in Numbering.__annotations__]
        instance = instance.with_given(among(instance.given, Numbering(*parts).names))
    return instance.replace(**changes)


def _regiven(instance: Instance, rng: np.random.Generator) -> Instance:
    """Connections for all bodies there are now, where connections are given."""
    if instance.transfer.given is None:
        return instance
    return with_given_costs(instance, rng, orbits=bool(rng.random() < 0.5))


def _chaser(
    usual: Chaser,
    stations: list[Station],
    targets: list[Target],
    duration_s: float,
    rng: np.random.Generator,
) -> Chaser:
    """One with a start, an end, a tank, a time and a number of targets of its own."""
    changes: dict[str, object] = {"end": "anywhere", "max_targets": None}
    if stations and rng.random() < 0.5:
        changes["start"] = AtStation(station=stations[int(rng.integers(len(stations)))].name)
    elif not stations or rng.random() < 0.6:
        orbit = targets[int(rng.integers(len(targets)))].orbit
        changes["start"] = InOrbit(orbit=orbit.replace(true_anomaly_deg=rng.uniform(0.0, 360.0)))
    if stations and rng.random() < 0.2:
        changes["end"] = AtStation(station=stations[int(rng.integers(len(stations)))].name)
    if rng.random() < 0.5:
        changes["max_targets"] = int(rng.integers(0, 4))
    if rng.random() < 0.5:
        begin = float(rng.uniform(0.0, 0.4)) * duration_s
        end = float(rng.uniform(0.5, 1.1)) * duration_s if rng.random() < 0.6 else None
        changes["available_s"] = (begin, end)
    share = float(rng.uniform(0.4, 1.6))
    full = share * usual.tank.delta_v_m_s
    changes["tank"] = filled(usual.tank).replace(delta_v_m_s=full)
    return begun(usual.replace(**changes), rng)


def carrying(instance: Instance, seed: int) -> Instance:
    """The same with kits to leave at some targets or all, tanks by mass or not, and launches."""
    rng = np.random.default_rng([8, seed])
    share = float(rng.choice([0.5, 1.0]))
    targets = tuple(
        target.replace(removal="kit" if rng.random() < share else "visit")
        for target in instance.targets
    )
    chasers = []
    for chaser in instance.chasers:
        changes: dict[str, object] = {}
        if rng.random() < 0.7:
            changes["kits"] = int(rng.integers(0, 5))
        if rng.random() < 0.75:
            dry, isp = float(rng.uniform(100.0, 600.0)), float(rng.uniform(60.0, 320.0))
            ratio = np.expm1(chaser.tank.delta_v_m_s / (isp * 9.80665))
            changes["tank"] = {
                "dry_mass_kg": dry,
                "isp_s": isp,
                "propellant_kg": dry * float(ratio * rng.uniform(0.9, 1.5)),
            }
            changes["kit_mass_kg"] = dry * float(rng.choice([0.0, 0.05, 0.2, 0.5, 4.0]))
        if rng.random() < 0.25:
            changes["start"] = "anywhere"
        chasers.append(begun(chaser.replace(**changes), rng))
    if len(chasers) > 1 and rng.random() < 0.4:
        chasers[1] = chasers[0].replace(name=chasers[1].name)
    return _changed(
        instance, name=f"{instance.name}-with-kits", targets=targets, chasers=tuple(chasers)
    )


def priced(instance: Instance, seed: int) -> Instance:
    """The same by expense: what chasers carry and cost, each part of it or not."""
    rng = np.random.default_rng([10, seed])
    chasers = []
    for chaser in instance.chasers:
        fixed = float(rng.choice([0.0, 20.0, 200.0]))
        prices = {"fixed": fixed}
        if isinstance(chaser.tank, TankByMass):
            scale = 100.0 / (chaser.tank.propellant_kg + 1.0)
            prices["per_kg"] = scale * float(rng.choice([0.0, 0.5, 2.0]))
            prices["per_kg_squared"] = scale**2 * float(rng.choice([0.0, 0.01, 0.1]))
        plain = chaser.replace(tank=filled(chaser.tank))
        chasers.append(begun(plain.replace(expense=None if rng.random() < 0.1 else prices), rng))
    if len(chasers) > 1 and rng.random() < 0.4:
        chasers[1] = chasers[0].replace(name=chasers[1].name)
    if all(chaser.expense is None for chaser in chasers):
        chasers[0] = chasers[0].replace(expense={})
    return _changed(
        instance,
        name=f"{instance.name}-priced",
        chasers=tuple(chasers),
        objective=Objective(cost="expense"),
    )


def limited(instance: Instance, seed: int) -> Instance:
    """The same with stations that run empty, and launches that lie apart."""
    rng = np.random.default_rng([11, seed])
    by_mass = all(isinstance(chaser.tank, TankByMass) for chaser in instance.chasers)
    stations = []
    for station in instance.stations:
        changes: dict[str, object] = {}
        if rng.random() < 0.6:
            changes["max_refuellings"] = int(rng.integers(0, 4))
        if by_mass and rng.random() < 0.6:
            most = max(chaser.tank.propellant_kg for chaser in instance.chasers)
            changes["max_propellant_kg"] = float(rng.uniform(0.0, 2.0)) * most
        stations.append(station.replace(**changes))
    mission = instance.mission
    if rng.random() < 0.7:
        apart = float(rng.uniform(0.0, 0.5)) * mission.duration_s
        mission = mission.replace(launch_separation_s=apart)
    return instance.replace(
        name=f"{instance.name}-limited", stations=tuple(stations), mission=mission
    )


def towing(instance: Instance, seed: int) -> Instance:
    """The same with some targets towed down, by chasers whose tanks are by mass, and no zones."""
    rng = np.random.default_rng([10, seed])
    share = float(rng.choice([0.3, 0.6, 1.0]))
    targets = tuple(
        target.replace(
            removal="tow" if rng.random() < share else target.removal,
            mass_kg=float(rng.choice([5.0, 100.0, 1000.0, 8000.0]) * rng.uniform(0.5, 2.0)),
        )
        for target in instance.targets
    )
    chasers = []
    for chaser in instance.chasers:
        tank = chaser.tank
        if isinstance(tank, Tank):
            dry, isp = float(rng.uniform(100.0, 600.0)), float(rng.uniform(60.0, 320.0))
            ratio = float(np.expm1(tank.delta_v_m_s / (isp * 9.80665)))
            tank = TankByMass(dry_mass_kg=dry, propellant_kg=1.2 * dry * ratio, isp_s=isp)
        chasers.append(begun(chaser.replace(tank=tank), rng))
    lowest = min(target.orbit.semi_major_axis_m for target in targets) - EARTH_RADIUS_M
    altitude = lowest - float(rng.choice([1e3, 10e3, 40e3, 150e3]) * rng.uniform(0.5, 1.5))
    altitude = max(altitude, instance.transfer.min_altitude_m)
    return instance.replace(
        name=f"{instance.name}-with-tows",
        targets=targets,
        chasers=tuple(chasers),
        mission=instance.mission.replace(disposal={"circle_m": altitude}),
        keep_out_zones=(),
    )


def falling(instance: Instance, seed: int) -> Instance:
    """The same with prizes of some targets or all that fall with time, in up to three steps."""
    rng = np.random.default_rng([12, seed])
    share = float(rng.choice([0.5, 1.0]))
    duration_s = instance.mission.duration_s

    def levels(target: Target) -> tuple[tuple[float, float], ...] | None:
        if rng.random() >= share:
            return None
        times = np.unique(rng.uniform(0.0, 0.9, int(rng.integers(1, 4)))) * duration_s
        prizes = target.prize + np.cumsum(rng.choice([0.0, 0.2, 0.5, 1.0], times.size))[::-1]
        return tuple(zip(times.tolist(), np.round(prizes, 6).tolist(), strict=True))

    rounded = [target.replace(prize=round(target.prize, 2)) for target in instance.targets]
    targets = tuple(target.replace(prize_until=levels(target)) for target in rounded)
    return instance.replace(name=f"{instance.name}-falling", targets=targets)


def falling_field(seed: int) -> Instance:
    """A mission of one chaser without cargo whose prizes fall, by turns of each kind."""
    draws = random_mission, drifting_mission, given_mission
    return falling(draws[seed % 3](seed // 3), seed)


def falling_mission(seed: int) -> Instance:
    """The same, by turns with tows or kits."""
    if seed % 4 == 3:
        return falling(towing_mission(seed // 4), seed)
    return falling_field(seed) if seed % 4 else carrying(falling_field(seed), seed)


def falling_campaign(seed: int) -> Instance:
    """A campaign with falling prizes, by turns with cargo, limited stations and expenses."""
    draw, part = (random_campaign, mixed_campaign)[seed % 2], (random_mission, drifting_mission)
    instance = draw(seed // 2, part[seed % 3 > 0])
    if seed % 4 == 1:
        instance = carrying(instance, seed)
    if seed % 5 == 1:
        instance = limited(instance, seed)
    if seed % 5 == 2:
        instance = priced(instance, seed)
    return falling(instance, seed)


def towing_mission(seed: int) -> Instance:
    """A mission of one chaser that tows, by turns in two-body motion and under J2."""
    return towing((random_mission, drifting_mission)[seed % 3 > 0](seed // 2), seed)


def disposing(instance: Instance, seed: int) -> Instance:
    """The same with eccentric objects, some left by their perigee alone, or for a time at most.

    By turns heavy ones have to come down under control.
    """
    rng, targets = np.random.default_rng([16, seed]), []
    least_m = EARTH_RADIUS_M + instance.transfer.min_altitude_m
    for target in instance.targets:
        orbit = target.orbit
        if target.removal == "tow" and rng.random() < 0.7:
            e = min(float(rng.choice([1e-3, 5e-3, 0.02])), 1.0 - least_m / orbit.semi_major_axis_m)
            orbit = orbit.replace(eccentricity=max(0.9 * e, 0.0))
        own = {"perigee_m": float(rng.uniform(20e3, 600e3))} if rng.random() < 0.5 else None
        if own and seed % 4 == 3:
            own = {"perigee_m": 0.1 * own["perigee_m"]}
        targets.append(target.replace(orbit=orbit, disposal=own))
    years = float(rng.choice([0.3, 5.0])) if rng.random() < 0.3 else None
    kg = float(rng.choice([0.0, 300.0])) if seed % 4 == 3 else None
    mission = instance.mission.replace(max_lifetime_years=years, max_uncontrolled_kg=kg)
    name = f"{instance.name}-disposed-of"
    return instance.replace(name=name, targets=tuple(targets), mission=mission)


def disposing_mission(seed: int) -> Instance:
    """A mission of one chaser with tows to circles and to perigees."""
    return disposing(towing_mission(seed), seed)


def disposing_campaign(seed: int) -> Instance:
    """A campaign with tows to circles and to perigees, by turns with kits or expenses."""
    draw = drifting_mission if seed % 2 else random_mission
    made = (random_campaign, mixed_campaign)[seed % 3 == 2](seed // 2, draw)
    made = disposing(towing(carrying(made, seed) if seed % 4 < 2 else made, seed), seed)
    return priced(made, seed) if seed % 5 == 1 else made


def hurried_mission(seed: int) -> Instance:
    """A mission that policies play, of a chaser that is there for a part of it."""
    instance = adr_opt.generate("tiny", seed, targets=4)
    until = float(np.random.default_rng([13, seed]).uniform(0.4, 0.9))
    available_s = 0.0, until * instance.mission.duration_s
    return instance.replace(chasers=(instance.chaser.replace(available_s=available_s),))


def visiting(instance: Instance, seed: int) -> Instance:
    """The same with few visits between refuellings, for each chaser or some."""
    rng = np.random.default_rng([14, seed])
    chasers = [
        chaser.replace(max_visits_between_refuels=int(rng.choice([1, 1, 1, 2, 3])))
        if at == 0 or rng.random() < 0.7
        else chaser
        for at, chaser in enumerate(instance.chasers)
    ]
    return instance.replace(name=f"{instance.name}-visiting", chasers=tuple(chasers))


def visiting_field(seed: int) -> Instance:
    """A mission of one chaser with few visits between refuellings, by turns of each kind."""
    draws = random_mission, drifting_mission, given_mission
    return visiting(draws[seed % 3](seed // 3), seed)


def visiting_mission(seed: int) -> Instance:
    """The same, by turns with tows or prizes that fall."""
    draws = towing_mission, falling_mission
    return visiting_field(seed) if seed % 5 < 3 else visiting(draws[seed % 5 - 3](seed), seed)


def visiting_campaign(seed: int) -> Instance:
    """A campaign with few visits between refuellings, by turns with all that campaigns may have."""
    draw = (random_campaign, mixed_campaign, falling_campaign)[seed % 3]
    instance = draw(seed // 3)
    if seed % 4 == 1:
        instance = carrying(instance, seed)
    if seed % 5 == 1:
        instance = limited(instance, seed)
    if seed % 5 == 2:
        instance = priced(instance, seed)
    return visiting(instance, seed)


def visiting_hurried(seed: int) -> Instance:
    """A mission that policies play, with few visits between refuellings."""
    return visiting(hurried_mission(seed), seed)


def reserving(instance: Instance, seed: int) -> Instance:
    """The same with a part of each tank, or of some, kept for the chasers' own disposal."""
    rng = np.random.default_rng([17, seed])
    chasers = [
        chaser.replace(end_of_life_m_s=float(rng.uniform(0.05, 0.6)) * (tank - spent))
        if (at == 0 or rng.random() < 0.7) and tank > spent
        else chaser
        for at, chaser in enumerate(instance.chasers)
        for tank, spent in ((chaser.tank.delta_v_m_s, chaser.spent_m_s),)
    ]
    return instance.replace(name=f"{instance.name}-reserving", chasers=tuple(chasers))


def reserving_mission(seed: int) -> Instance:
    """A mission of one chaser that keeps a reserve, by turns of each kind, and with tows."""
    draws = random_mission, drifting_mission, given_mission, towing_mission, falling_mission
    return reserving(draws[seed % 5](seed // 5), seed)


def reserving_campaign(seed: int) -> Instance:
    """A campaign whose chasers keep reserves, by turns with tows, kits, expenses and limits."""
    drawn = (mixed_campaign, disposing_campaign, random_campaign)[seed % 3](seed // 3)
    if seed % 4 == 1:
        drawn = priced(carrying(drawn, seed), seed)
    return reserving(limited(drawn, seed) if seed % 5 == 1 else drawn, seed)


def captured(instance: Instance, seed: int) -> Instance:
    """The same with several windows of most targets, by turns in a file, and short captures."""
    rng, targets = np.random.default_rng([16, seed]), []
    windows: dict[str, np.ndarray] = {}
    stays_s = services_s(instance)[instance.first_target :].tolist()
    for target, stay_s in zip(instance.targets, stays_s, strict=True):
        edges = rng.uniform(0.0, instance.mission.duration_s, 2 * int(rng.integers(1, 7)))
        if rng.random() < 0.2:
            edges = np.array([0.0, instance.mission.duration_s])
        intervals = np.sort(edges).reshape(-1, 2)
        capture_s = float(rng.uniform(0.0, 0.8)) * stay_s if rng.random() < 0.8 else None
        windows[target.name] = intervals
        plain = target.replace(window_s=(0.0, None), capture_s=capture_s)
        targets.append(plain if seed % 4 == 0 else plain.replace(windows_s=windows_from(intervals)))
    name = f"{instance.name}-captured"
    made = instance.replace(name=name, targets=tuple(targets))
    return made.with_windows(windows) if seed % 4 == 0 else made


def captured_field(seed: int) -> Instance:
    """A mission of one chaser whose targets have windows, by turns of each kind."""
    draws = random_mission, drifting_mission, given_mission
    return captured(draws[seed % 3](seed // 3), seed)


def captured_mission(seed: int) -> Instance:
    """The same, by turns with tows, prizes that fall or few visits between refuellings."""
    draws = towing_mission, falling_mission, visiting_field
    return captured_field(seed) if seed % 5 < 2 else captured(draws[seed % 5 - 2](seed), seed)


def captured_campaign(seed: int) -> Instance:
    """A campaign whose targets have windows, by turns with all that campaigns may have."""
    return captured(visiting_campaign(seed) if seed % 2 else mixed_campaign(seed), seed)


def freely(instance: Instance, seed: int) -> Instance:
    """The same on ellipses, with legs by free burns and without zones."""
    return eccentric(instance, 0.01, [15, seed]).replace(
        name=f"{instance.name}-free",
        keep_out_zones=(),
        transfer=instance.transfer.replace(burns="free"),
    )


def free_mission(seed: int) -> Instance:
    """A mission with legs by free burns, by turns in each dynamics and of several chasers."""
    return freely((random_mission, drifting_mission, random_campaign)[seed % 3](seed // 3), seed)


def rounding(instance: Instance, seed: int) -> Instance:
    """The same with safety ellipses, and with time for them."""
    rng = np.random.default_rng([4, seed])
    instance = instance.with_limits(duration_s=2.5 * instance.mission.duration_s)
    transfer = instance.transfer.replace(
        approach="safety-ellipse",
        keep_out_m=float(rng.uniform(50.0, 600.0)),
        approach_revolutions=int(rng.integers(1, 4)),
        inspection_revolutions=int(rng.choice([0, 0, 2])),
    )
    return instance.replace(transfer=transfer)


def rounding_mission(seed: int) -> Instance:
    """A mission of a day or two whose targets are approached on safety ellipses."""
    return rounding((random_mission, drifting_mission)[seed % 2](seed), seed)


def full_mission(seed: int) -> Instance:
    """Free burns, safety ellipses and tows to circles and perigees at once, by turns a campaign."""
    draw = disposing_campaign if seed % 3 == 2 else disposing_mission
    instance = freely(draw(seed // 3), seed)
    instance = instance.with_limits(duration_s=2.0 * instance.mission.duration_s)
    at_once = instance.transfer.replace(max_drift_s=0.0)
    return rounding(instance.replace(transfer=at_once), seed)


def launching(instance: Instance, seed: int) -> Instance:
    """The same with chasers launched into circles, by turns by a launcher that lifts little."""
    rng, chasers = np.random.default_rng([17, seed]), []
    orbits = [target.orbit for target in instance.targets]
    for at, chaser in enumerate(instance.chasers):
        if at and rng.random() < 0.3:
            chasers.append(chaser)
            continue
        orbit, tank = orbits[int(rng.integers(len(orbits)))], chaser.tank
        launch = {
            "altitude_m": float(rng.uniform(650e3, 850e3)),
            "inclination_deg": orbit.inclination_deg + float(rng.choice([0.0, 0.3])),
        }
        if isinstance(tank, TankByMass) and rng.random() < 0.7:
            most_kg = tank.dry_mass_kg + float(rng.uniform(0.2, 1.4)) * tank.propellant_kg
            launch["launcher"] = ((6e5, most_kg + 50.0), (9e5, most_kg))
        chasers.append(chaser.replace(start={"launch": launch}))
    return instance.replace(name=f"{instance.name}-launched", chasers=tuple(chasers))


def launched_mission(seed: int) -> Instance:
    """A mission of one chaser or several that are launched into orbits, with kits or tows."""
    draw = random_campaign if seed % 2 else lambda seed, draw: draw(seed)
    made = draw(seed, lambda seed: drifting_mission(seed // 2))
    if seed % 5 < 3:
        made = carrying(made, seed) if seed % 5 < 2 else towing(made, seed)
    return launching(made, seed)


DRAWS: dict[str, Callable[[int], Instance]] = {
    "random": random_mission,
    "drifting": drifting_mission,
    "given": given_mission,
    "rounding": rounding_mission,
    "towing": towing_mission,
    "disposing": disposing_mission,
    "falling": falling_mission,
    "campaign": random_campaign,
    "mixed": mixed_campaign,
    "hurried": hurried_mission,
    "carrying": lambda seed: carrying(random_campaign(seed), seed),
    "priced": lambda seed: priced(carrying(random_campaign(seed), seed), seed),
    "limited": lambda seed: limited(carrying(random_campaign(seed), seed), seed),
    "visiting": visiting_mission,
    "visiting field": visiting_field,
    "visiting campaign": visiting_campaign,
    "visiting hurried": visiting_hurried,
    "captured field": captured_field,
    "captured": captured_mission,
    "captured campaign": captured_campaign,
    "reserving": reserving_mission,
    "reserving campaign": reserving_campaign,
    "free": free_mission,
    "full": full_mission,
    "launched": launched_mission,
    "free hurried": lambda seed: freely(hurried_mission(seed), seed),
}
"""All kinds of drawn fields that enumeration can tell the best plan of."""
