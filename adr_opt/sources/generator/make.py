"""Instances from a family and a seed, or from a name."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

from ...common.constants import HOUR_S
from ...common.errors import InputError
from ...plan.kit_sizes import with_sized_kits
from ...problem.bodies import Station, Target
from ...problem.chasers import AnyTank, AtStation, Chaser, InOrbit, Start, Tank
from ...problem.disposal import Disposal
from ...problem.instance import Instance
from ...problem.orbit import Orbit
from ...problem.settings import (
    ApproachName,
    BurnsName,
    KeepOutZone,
    MissionSettings,
    TransferSettings,
)
from ...problem.transfer_sizes import transfers_for
from .families import FAMILIES, Family, family
from .stream import LARGEST_SEED, Uniform, stream

FLEET_PURPOSE = 100
"""First stream of additional stations and starts, which leave the field of a seed unchanged."""


def stations_of(kind: Family, seed: int, count: int) -> tuple[Station, ...]:
    """The station of a family, and additional ones at random target positions."""
    if kind.station is None or count == 0:
        return ()
    uniform = stream(seed, FLEET_PURPOSE + kind.purpose)
    orbits = [kind.station, *(kind.draw_target(uniform) for _ in range(count - 1))]
    return tuple(
        Station(name="station" if number == 1 else f"station-{number}", orbit=orbit)
        for number, orbit in enumerate(orbits, start=1)
    )


def chasers_of(
    kind: Family, seed: int, count: int, first: Orbit | None, stations: tuple[Station, ...]
) -> tuple[Chaser, ...]:
    """Identical chasers: at stations in turn, or in their own orbits, the first of which is given.

    Or those that the family draws.
    """
    if kind.draw_chaser is not None:
        return tuple(kind.draw_chaser(number) for number in range(count))
    uniform = stream(seed, 2 * FLEET_PURPOSE + kind.purpose)
    tank = Tank(delta_v_m_s=kind.delta_v_m_s)
    return tuple(
        Chaser(
            name="chaser" if count == 1 else f"chaser-{number + 1}",
            start=_start(kind, number, first, stations, uniform),
            tank=tank,
        )
        for number in range(count)
    )


def _start(
    kind: Family, number: int, first: Orbit | None, stations: tuple[Station, ...], uniform: Uniform
) -> Start:
    if first is None:
        return AtStation(station=stations[number % len(stations)].name)
    if number == 0 or kind.draw_start is None:
        return InOrbit(orbit=first)
    return InOrbit(orbit=kind.draw_start(uniform))


ZONES_PURPOSE = 1
"""Number of the stream: zones leave the field of a seed unchanged."""

ZONE_ALTITUDE_KM = (680.0, 830.0)
ZONE_THICKNESS_KM = (10.0, 25.0)
ZONE_LENGTH_H = (6.0, 24.0)


def draw_zones(seed: int, count: int, duration_s: float) -> tuple[KeepOutZone, ...]:
    """Keep-out zones within 680–830 km, 10–25 km thick, 6–24 h long (docs/model.md section 6)."""
    uniform = stream(seed, ZONES_PURPOSE)
    zones = []
    for _ in range(count):
        thickness = uniform(*ZONE_THICKNESS_KM)
        bottom = uniform(ZONE_ALTITUDE_KM[0], ZONE_ALTITUDE_KM[1] - thickness)
        length = HOUR_S * uniform(*ZONE_LENGTH_H)
        start = uniform(0.0, max(0.0, duration_s - length))
        zones.append(
            KeepOutZone(
                min_altitude_m=round(1e3 * bottom, 3),
                max_altitude_m=round(1e3 * (bottom + thickness), 3),
                start_s=round(start, 3),
                end_s=round(start + length, 3),
            )
        )
    return tuple(zones)


SUFFIX = "-fitted"
"""Suffix of the names of modified instances, which are not in the library."""


def fitted(  # noqa: PLR0913
    instance: Instance,
    *,
    tank: AnyTank | None = None,
    kits: int | None = None,
    kit_mass_kg: float | None = None,
    kit_isp_s: float | None = None,
    towed_kg: float | None = None,
    disposal: Disposal | None = None,
    max_lifetime_years: float | None = None,
    max_uncontrolled_kg: float | None = None,
    burns: BurnsName | None = None,
    approach: ApproachName | None = None,
    keep_out_m: float | None = None,
) -> Instance:
    """The instance with other tanks or transfers, with kits or tows; unchanged without arguments.

    Parameters
    ----------
    instance : Instance
    tank, kits, kit_mass_kg, kit_isp_s, towed_kg, disposal, max_lifetime_years
    max_uncontrolled_kg, burns, approach, keep_out_m
        As :func:`adr_opt.generate` takes them.

    Raises
    ------
    InputError
        Kits and tows together, one of them said by half, or masses in a tank that is counted in ΔV.
    """
    if kits is not None and towed_kg is not None:
        raise InputError("a target takes a kit or is towed; give kits or a mass to tow")
    if (towed_kg is None and kit_isp_s is None) != (disposal is None):
        raise InputError("a tow needs a mass and a disposal orbit; give both or none")
    for what, limit, unit in (
        ("lifetime", max_lifetime_years, "years"),
        ("most uncontrolled", max_uncontrolled_kg, "kg"),
    ):
        if limit is not None and disposal is None:
            raise InputError(f"{what} = {limit:g} {unit}: nothing is released; choose a tow")
    carried = instance.chasers[0].kits is not None
    if kit_mass_kg is not None and kits is None and (not carried or towed_kg is not None):
        raise InputError(f"kit mass = {kit_mass_kg:g} kg: there are no kits; give their number")
    of_chasers: dict[str, Any] = {}
    of_targets: dict[str, Any] = {}
    if tank is not None:
        of_chasers["tank"] = tank
    if kits is not None:
        of_chasers["kits"], of_targets["removal"] = kits, "kit"
    if kit_mass_kg is not None:
        of_chasers["kit_mass_kg"] = kit_mass_kg
    if towed_kg is not None:
        of_chasers |= {"kits": None, "kit_mass_kg": 0.0}
        of_targets |= {"removal": "tow", "mass_kg": towed_kg}
    of_transfers = {"burns": burns, "approach": approach, "keep_out_m": keep_out_m}
    transfer = instance.transfer.replace(
        **{name: value for name, value in of_transfers.items() if value is not None}
    )
    if not of_chasers and not of_targets and transfer == instance.transfer:
        return instance
    mission = instance.mission
    if disposal is not None:
        mission = mission.replace(
            disposal=None if towed_kg is None else disposal,
            max_lifetime_years=max_lifetime_years,
            max_uncontrolled_kg=max_uncontrolled_kg,
        )
    made = instance.replace(
        name=f"{instance.name}{SUFFIX}",
        chasers=tuple(chaser.replace(**of_chasers) for chaser in instance.chasers),
        targets=tuple(target.replace(**of_targets) for target in instance.targets),
        mission=mission,
        transfer=transfer,
    )
    return made if kit_isp_s is None else with_sized_kits(made, kit_isp_s, disposal)


EPOCH = datetime(2026, 1, 1, tzinfo=UTC)
MOST = 10**6
"""Maximum number of targets and of zones."""

MOST_CHASERS = 100
"""Maximum number of chasers and of stations."""

NAME = re.compile(
    r"(?P<family>[a-z-]+)-(?P<seed>\d{3,})(?:-n(?P<targets>\d+))?(?:-c(?P<chasers>\d+))?"
    r"(?:-s(?P<stations>\d+))?(?:-z(?P<zones>\d+))?"
)


def generate(  # noqa: PLR0913
    name: str,
    seed: int,
    *,
    targets: int | None = None,
    zones: int = 0,
    chasers: int | None = None,
    stations: int | None = None,
    tank: AnyTank | None = None,
    kits: int | None = None,
    kit_mass_kg: float | None = None,
    kit_isp_s: float | None = None,
    towed_kg: float | None = None,
    disposal: Disposal | None = None,
    max_lifetime_years: float | None = None,
    max_uncontrolled_kg: float | None = None,
    burns: BurnsName | None = None,
    approach: ApproachName | None = None,
    keep_out_m: float | None = None,
) -> Instance:
    """Draw an instance.

    Parameters
    ----------
    name : str
        A family of :data:`FAMILIES`.
    seed : int
        Not negative.
    targets : int, optional
        Number of targets, instead of the family's.
    zones : int
        Number of keep-out zones to draw; they do not change the field.
    chasers, stations : int, optional
        Numbers of chasers and of stations, instead of the family's. Further stations are drawn like
        targets; all chasers are alike and start at the stations in turn, or each in an orbit of its
        own. They do not change the field.
    tank : Tank or TankByMass, optional
        Of each chaser, instead of the family's.
    kits : int, optional
        Each target takes a kit; this is the maximum number aboard each chaser.
    kit_mass_kg : float, optional
        Of each kit; needs a tank by mass [kg].
    kit_isp_s : float, optional
        Specific impulse of kits that lead to the orbit of disposal, for which they carry the
        propellant beside their mass [s].
    towed_kg : float, optional
        Instead of kits: each target has this mass [kg] and is towed; needs a tank by mass.
    disposal : DisposalCircle or DisposalPerigee, optional
        The orbit to which targets are towed.
    max_lifetime_years : float, optional
        Longest time that released targets may stay in orbit [years].
    max_uncontrolled_kg : float, optional
        Mass above which they have to re-enter under control [kg].
    burns : {"sequence", "free"}, optional
        Burns that set the price of short legs; by default those of the sequence.
    approach : {"half-lap", "safety-ellipse"}, optional
        Approach of every transfer; by default half a lap.
    keep_out_m : float, optional
        Distance that a safety ellipse keeps [m].

    Raises
    ------
    InputError
        Unknown family, a number out of range, or contradictory kits and tows.
    """
    kind = family(name)
    for what, value, most in (("seed", seed, LARGEST_SEED), ("zones", zones, MOST)):
        if not 0 <= value <= most:
            raise InputError(f"{what} = {value}: must be between 0 and {most}")
    if targets is not None and not 0 <= targets <= MOST:
        raise InputError(f"targets = {targets}: must be between 0 and {MOST}")
    if chasers is not None and not 1 <= chasers <= MOST_CHASERS:
        raise InputError(f"chasers = {chasers}: must be between 1 and {MOST_CHASERS}")
    fewest = 0 if kind.station is None else 1
    most = 0 if kind.station is None else MOST_CHASERS
    if stations is not None and not fewest <= stations <= most:
        raise InputError(
            f"stations = {stations}: must be between {fewest} and {most} in the family {name}"
        )
    uniform = stream(seed, kind.purpose)
    low, high = kind.targets
    count = low
    if high > low:
        count = min(high, int(uniform(low, high + 1)))
    if targets is not None:
        count = targets
    width = max(3, len(str(count)))
    suffix = f"-n{count}" if targets is not None else ""
    suffix += "" if chasers in (None, kind.chasers) else f"-c{chasers}"
    suffix += "" if stations in (None, fewest) else f"-s{stations}"
    suffix += f"-z{zones}" if zones else ""
    start = None if kind.draw_start is None else kind.draw_start(uniform)
    there = stations_of(kind, seed, fewest if stations is None else stations)
    objects = tuple(
        _target(kind, f"debris-{number:0{width}d}", kind.draw_target(uniform))
        for number in range(1, count + 1)
    )
    drawn = Instance(
        name=f"{kind.name}-{seed:03d}{suffix}",
        epoch=EPOCH,
        dynamics="j2" if kind.drifts else "two-body",
        stations=there,
        targets=objects,
        chasers=chasers_of(kind, seed, chasers or kind.chasers, start, there),
        mission=_mission(kind),
        transfer=_transfers(kind, [each.orbit for each in objects if each.orbit is not None]),
        keep_out_zones=draw_zones(seed, zones, kind.duration_s),
    )
    return fitted(
        drawn,
        tank=tank,
        kits=kits,
        kit_mass_kg=kit_mass_kg,
        kit_isp_s=kit_isp_s,
        towed_kg=towed_kg,
        disposal=disposal,
        max_lifetime_years=max_lifetime_years,
        max_uncontrolled_kg=max_uncontrolled_kg,
        burns=burns,
        approach=approach,
        keep_out_m=keep_out_m,
    )


def _target(kind: Family, name: str, orbit: Orbit) -> Target:
    mass_kg = None if kind.mass_kg is None else kind.mass_kg(orbit)
    return Target(name=name, orbit=orbit, prize=1.0, mass_kg=mass_kg, removal=kind.removal)


def _transfers(kind: Family, orbits: Sequence[Orbit]) -> TransferSettings:
    if kind.transfer is not None:
        return kind.transfer
    return transfers_for(kind.duration_s, orbits=orbits) if kind.drifts else TransferSettings()


def _mission(kind: Family) -> MissionSettings:
    if kind.service_s is None:
        return MissionSettings(duration_s=kind.duration_s)
    return MissionSettings(
        duration_s=kind.duration_s,
        service_revolutions=None,
        service_s=kind.service_s,
        disposal=kind.disposal,
    )


def family_of(name: str) -> str:
    """The family at the beginning of an instance's name."""
    found = NAME.fullmatch(name)
    return "" if found is None else found["family"]


def by_name(name: str) -> Instance:
    """The instance from :func:`generate` by its name, such as ``nominal-042`` or ``cloud-003-z6``.

    Raises
    ------
    InputError
        It is no such name.
    """
    found = NAME.fullmatch(name)
    if found is None or found["family"] not in FAMILIES:
        raise InputError(
            f"instance {name!r} is not the name of a generated instance; use FAMILY-SEED such "
            f"as nominal-042, with one of the families {', '.join(FAMILIES)}"
        )
    counts: dict[str, Any] = {
        what: int(found[what])
        for what in ("targets", "zones", "chasers", "stations")
        if found[what] is not None
    }
    made = generate(found["family"], int(found["seed"]), **counts)
    if made.name != name:
        raise InputError(f"instance {name!r}: write it as {made.name!r}")
    return made
