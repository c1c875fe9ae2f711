"""What the plain rules need to know of a mission, read from its instance."""

from __future__ import annotations

import math
from collections import defaultdict
from itertools import product

from plain_rules import Place, Tank, Tow, World

from adr_opt.common.constants import SLACK_M_S
from adr_opt.mission.mission import Mission
from adr_opt.problem.bodies import Target
from adr_opt.problem.chasers import Chaser, Expense, TankByMass
from adr_opt.problem.disposal import DisposalCircle
from adr_opt.problem.instance import Instance
from adr_opt.problem.orbit import Orbit

LONGEST_HALF_S = 4000.0
"""Half an ellipse between circles takes less [s]; a tow that waits for an apogee takes longer."""


def revolution_s(orbit: Orbit | None, dynamics: str) -> float:
    """Nodal period of a body: mean elements, secular rates.

    See docs/model.md section 1.

    0 without an orbit, where nothing is counted in it.
    """
    if orbit is None:
        return 0.0
    a, e, cosine = (
        orbit.semi_major_axis_m,
        orbit.eccentricity,
        math.cos(math.radians(orbit.inclination_deg)),
    )
    n = math.sqrt(398600.4418e9 / a**3)
    if dynamics == "two-body":
        return 2.0 * math.pi / n
    strength = 0.75 * 1.08262668e-3 * (6378137.0 / (a * (1.0 - e * e))) ** 2 * n
    perigee = strength * (5.0 * cosine**2 - 1.0)
    anomaly = n + strength * math.sqrt(1.0 - e * e) * (3.0 * cosine**2 - 1.0)
    return 2.0 * math.pi / (perigee + anomaly)


def tow_of(target: Target, instance: Instance) -> Tow:
    """A tow: half an ellipse between two circles, or from the apogee of an ellipse."""
    orbit, disposal, mu = target.orbit, instance.disposal_of(target), 398600.4418e9
    assert orbit is not None
    assert target.mass_kg is not None
    size, e = orbit.semi_major_axis_m, orbit.eccentricity
    is_circle = isinstance(disposal, DisposalCircle)
    if is_circle and 0.5 * math.sqrt(mu / size) * e < 1.0:
        e, wait_s = 0.0, 0.0
    else:
        wait_s = anomalistic_s(orbit, instance.dynamics)
    top = size * (1.0 + e)

    def at_top(other: float) -> float:
        """Speed at the apogee with another apsis, from the momentum of the ellipse [m/s]."""
        return math.sqrt(2.0 * mu / (1.0 / top + 1.0 / other)) / top

    if not is_circle:
        low = min(6378137.0 + disposal.perigee_m, size * (1.0 - e))
        kept = max(low, 6378137.0 + instance.transfer.min_altitude_m)
        docked, back = at_top(size * (1.0 - e)) - at_top(low), at_top(kept) - at_top(low)
        return Tow(wait_s, docked + back, target.mass_kg, back)
    low = 6378137.0 + disposal.circle_m
    first = abs(at_top(size * (1.0 - e)) - at_top(low))
    second = abs(at_top(low) * top / low - math.sqrt(mu / low))
    ellipse = orbit.replace(semi_major_axis_m=0.5 * (top + low), eccentricity=0.0)
    time_s = wait_s + 0.5 * revolution_s(ellipse, instance.dynamics)
    return Tow(time_s, first + second, target.mass_kg)


def anomalistic_s(orbit: Orbit, dynamics: str) -> float:
    """From perigee to perigee, by the secular rate of the mean anomaly [s]."""
    a, e = orbit.semi_major_axis_m, orbit.eccentricity
    n = math.sqrt(398600.4418e9 / a**3)
    if dynamics == "j2":
        square = 1.0 - e * e
        tilt = 3.0 * math.cos(math.radians(orbit.inclination_deg)) ** 2 - 1.0
        n *= 1.0 + 0.75 * 1.08262668e-3 * (6378137.0 / (a * square)) ** 2 * math.sqrt(square) * tilt
    return 2.0 * math.pi / n


def price_of_time(instance: Instance) -> float:
    """Price of a second of a chaser beyond its ΔV: as stated, or one resolution per mission."""
    if instance.objective.cost != "delta-v":
        return 0.0
    if instance.objective.time_m_s_per_day is not None:
        return instance.objective.time_m_s_per_day / 86400.0
    if instance.given is not None:
        return 0.0
    return instance.transfer.delta_v_resolution_m_s / instance.mission.duration_s


def launch_s(mission: Mission) -> float:
    """Since when a chaser may fly: launches in their order if they are so long apart [s]."""
    instance, last = mission.instance, -math.inf
    apart = instance.mission.launch_separation_s
    for chaser in instance.chasers:
        since = chaser.available_s[0]
        if chaser.start == "anywhere" and apart is not None:
            since = last = max(since, last + apart)
        if chaser == mission.chaser:
            return since
    raise AssertionError("no chaser of the instance")


def places_of(instance: Instance) -> tuple[Place, ...]:
    """Stations, starts that lend an orbit, and targets, in the order of names."""
    places, settings = [], instance.mission
    for number, orbit in enumerate(instance.known_orbits):
        turn_s = revolution_s(orbit, instance.dynamics)
        if number < len(instance.stations):
            station = instance.stations[number]
            most, most_kg = station.max_refuellings, station.max_propellant_kg
            place = Place(
                "station",
                stay_s=settings.refuel_revolutions * turn_s,
                refuellings=math.inf if most is None else most,
                propellant_kg=math.inf if most_kg is None else most_kg,
            )
        elif number < instance.first_target:
            place = Place("start")
        else:
            target = instance.targets[number - instance.first_target]
            windows = instance.intervals_of(target).tolist()
            falls = target.prize_until or ()
            stay_s = settings.service_s
            if stay_s is None:
                stay_s = (settings.service_revolutions or 0.0) * turn_s
            place = Place(
                "target",
                stay_s=stay_s,
                windows_s=tuple((opens_s, closes_s) for opens_s, closes_s in windows),
                capture_s=stay_s if target.capture_s is None else target.capture_s,
                takes_kit=target.removal == "kit",
                tow=tow_of(target, instance) if target.removal == "tow" else None,
                prizes=(*falls, (math.inf, target.prize)) if falls else (),
            )
        places.append(place)
    return tuple(places)


def tank_of(chaser: Chaser, margin: float, most_kits: int) -> Tank:
    """The tank with what is kept back of it; what is lacking at the start is ΔV of a whole tank.

    For its own disposal a chaser keeps ΔV, or the propellant that gives it that when it is empty.
    """
    tank, kit_kg, kept_m_s = chaser.tank, chaser.kit_mass_kg, chaser.end_of_life_m_s or 0.0
    full, at_start = [], []
    if not isinstance(tank, TankByMass):
        usable = (tank.delta_v_m_s - kept_m_s) * (1.0 - margin) + SLACK_M_S
        initial = tank.delta_v_m_s if tank.initial_delta_v_m_s is None else tank.initial_delta_v_m_s
        each = most_kits + 1
        return Tank((usable,) * each, (usable - (tank.delta_v_m_s - initial),) * each)
    exhaust_m_s, propellant_kg = 9.80665 * tank.isp_s, tank.propellant_kg
    initial_kg = propellant_kg if tank.initial_propellant_kg is None else tank.initial_propellant_kg
    dry_kg = tank.dry_mass_kg * math.exp(kept_m_s / exhaust_m_s)
    kept_kg = dry_kg - tank.dry_mass_kg
    propellant_kg, initial_kg = propellant_kg - kept_kg, initial_kg - kept_kg
    lifted_kg = math.inf
    if chaser.launch is not None and chaser.launch.launcher is not None:
        (low_m, low_kg), (high_m, high_kg) = chaser.launch.launcher
        share = (chaser.launch.altitude_m - low_m) / (high_m - low_m)
        lifted_kg = low_kg + share * (high_kg - low_kg)
    for kits in range(most_kits + 1):
        empty_kg = dry_kg + kits * kit_kg
        first_kg = min(initial_kg, lifted_kg - empty_kg)
        delta_v = exhaust_m_s * math.log((empty_kg + propellant_kg) / empty_kg)
        full.append(empty_kg * math.exp(delta_v * (1.0 - margin) / exhaust_m_s))
        at_start.append(full[-1] * (empty_kg + first_kg) / (empty_kg + propellant_kg))
    return Tank(tuple(full), tuple(at_start), exhaust_m_s, dry_kg, kit_kg)


def world_of(mission: Mission) -> World:
    """What a chaser meets."""
    instance, chaser = mission.instance, mission.chaser
    wanted = sum(target.removal == "kit" for target in instance.targets)
    most_kits = wanted if chaser.kits is None else min(chaser.kits, wanted)
    tank, paid = tank_of(chaser, mission.margin, most_kits), chaser.expense or Expense()
    cost = instance.objective.cost
    until_s = chaser.available_s[1]
    return World(
        places=places_of(instance),
        tank=tank,
        start=instance.names.index(chaser.start_name),
        end=None if isinstance(chaser.end, str) else instance.names.index(chaser.end.station),
        since_s=launch_s(mission),
        until_s=min(instance.mission.duration_s, math.inf if until_s is None else until_s),
        most_targets=math.inf if chaser.max_targets is None else chaser.max_targets,
        most_between_refuels=chaser.max_visits_between_refuels or math.inf,
        cost="mass" if cost == "expense" and tank.dry_kg > 0.0 else cost,
        per_s=price_of_time(instance),
        expense=(paid.fixed, paid.per_kg, paid.per_kg_squared),
    )


Pairs = tuple[tuple[tuple[int, int], tuple[tuple[float, ...], ...]], ...]
"""Of pairs of bodies with connections, their departures, arrivals and ΔV."""


def legs_of(mission: Mission) -> Pairs:
    """All connections of all pairs: those of the model, or all that are given, useless or not."""
    instance, given, found = mission.instance, mission.instance.given, defaultdict(list)
    if given is not None:
        numbers = [instance.names.index(n) if n in instance.names else -1 for n in given.names]
        rows = given.origin, given.destination, given.departure, given.arrival, given.cost
        for origin, destination, *leg in zip(*(row.tolist() for row in rows), strict=True):
            found[numbers[origin], numbers[destination]].append(tuple(leg))
    # Where planes drift, or a tow ends once a revolution, connections are listed: what saves no
    # more than the resolution is then no part of the problem.
    places = places_of(instance) if given is None else ()
    waits = any(place.tow and place.tow.time_s > LONGEST_HALF_S for place in places)
    drifts = given is None and (instance.dynamics == "j2" or waits)
    resolution = instance.transfer.delta_v_resolution_m_s if drifts else 0.0
    for i, j in product(range(len(instance.names)), repeat=2):
        if given is None or i in instance.launches or j in instance.launches:
            pair = mission.timetable.connections(i, j, resolution_m_s=resolution)
            columns = pair.departure, pair.arrival, pair.delta_v
            found[i, j] = list(zip(*(column.tolist() for column in columns), strict=True))
    return tuple((pair, tuple(legs)) for pair, legs in found.items() if legs)
