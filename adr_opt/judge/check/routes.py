"""Check of a plan's routes leg by leg, with an independent clock and tank."""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...common.constants import SLACK_M_S, SLACK_S
from ...kernels.orbits import ephemeris
from ...kernels.orbits.body_rows import launched
from ...plan.launched import as_launched
from ...plan.leg_kinds import GIVEN, LAUNCH
from ...plan.plan import Leg, Plan
from ...problem.chasers import AtStation, Chaser
from ...problem.drives import Drive, drive_of
from ...problem.instance import Instance
from .altitude import Heights
from .leg import Physics, check_transfer
from .lifetime import check_lifetime
from .shared import Drawn, check_apart, launch_times
from .tank import TankLevel
from .tow import check_tow
from .towed import Towed
from .violation import DELTA_V_TOLERANCE_M_S, TIME_TOLERANCE_S, Violation
from .zone_crossings import crossed

FloatArray = npt.NDArray[np.float64]

ALWAYS = np.array([[0.0, math.inf]])

MASS_TOLERANCE = 1e-9
"""Relative tolerance on stated masses."""


class _Bodies:
    """Bodies of an instance by name: their numbers and roles."""

    def __init__(self, instance: Instance) -> None:
        self.number = {name: number for number, name in enumerate(instance.names)}
        self.stations = {station.name for station in instance.stations}
        self.windows = {
            target.name: (instance.intervals_of(target), target.capture_s)
            for target in instance.targets
        }
        self.kits = {target.name for target in instance.targets if target.removal == "kit"}


@dataclass
class _Followed:
    """State of a chaser during the check.

    Attributes
    ----------
    where : str
    free : float
        Since when it is [s].
    arrived : float or None
        When it arrived there [s]; None at the start.
    tank : TankLevel
    chaser : Chaser
    drawn : Drawn
        What stations have given to all chasers.
    since_refuelling : int
        Targets serviced since then.
    targets : int
        Targets serviced.
    """

    where: str
    free: float
    tank: TankLevel
    chaser: Chaser
    drawn: Drawn
    arrived: float | None = None
    since_refuelling: int = 0
    targets: int = 0


def check_routes(instance: Instance, plan: Plan) -> Iterator[Violation]:
    """Check that routes belong to chasers of the instance, with at most one for each."""
    known = [chaser.name for chaser in instance.chasers]
    stated = [route.chaser for route in plan.routes]
    for name in sorted(set(stated) - set(known)):
        yield Violation(None, "chaser", f"{name!r} is not a chaser of the instance")
    for name in sorted({name for name in stated if stated.count(name) > 1}):
        yield Violation(None, "chaser", f"{name!r} has more than one route")


def check_legs(instance: Instance, plan: Plan) -> Iterator[Violation]:
    """Check each chaser's order, times, ΔV and burns, and that targets are serviced only once."""
    bodies, drawn = _Bodies(instance), Drawn(instance)
    physics: dict[Drive | None, Physics] = {}
    launches, in_space = launch_times(instance), as_launched(instance, plan)
    chasers = {chaser.name: chaser for chaser in instance.chasers}
    flown = [(chasers.pop(route.chaser, None), route.legs) for route in plan.routes]
    at_home: list[tuple[Chaser | None, tuple[Leg, ...]]] = [(each, ()) for each in chasers.values()]
    visited: set[str] = set()
    number, whole = 1, True
    for chaser, route in flown + at_home:
        first, number = number, number + len(route)
        if chaser is None:  # unknown, or a second route: said by check_routes
            continue
        kits = len({leg.destination for leg in route} & bodies.kits)
        tank = TankLevel(chaser, kits)
        free = launches.get(chaser.name, chaser.available_s[0])
        now = _Followed(chaser.start_name, free, tank, chaser, drawn)
        if chaser.kits is not None and kits > chaser.kits:
            yield Violation(
                None, "kits", f"{chaser.name!r} leaves {kits} kits, but may carry {chaser.kits}"
            )
        drive = drive_of(chaser, instance.targets)
        if drive not in physics:
            physics[drive] = Physics.of(instance, drive)
        if chaser.launch is not None and route and route[0].destination in bodies.number:
            home, first_target = bodies.number[chaser.name], bodies.number[route[0].destination]
            physics[drive].left[home] = launched(
                physics[drive].elements[home], physics[drive].elements[first_target]
            )
        leads_on = yield from _check_route(
            in_space, bodies, physics[drive], now, visited, first, route
        )
        if leads_on:
            yield from _check_end(plan, now)
        whole = whole and leads_on
    yield from drawn.violations()
    yield from check_apart(instance, plan)
    if not whole or plan.status not in ("optimal", "feasible"):
        return
    for target in instance.targets:
        if target.required and target.name not in visited:
            yield Violation(None, "required", f"{target.name!r} is required, but not visited")


def _check_route(
    instance: Instance,
    bodies: _Bodies,
    physics: Physics,
    now: _Followed,
    visited: set[str],
    first: int,
    route: tuple[Leg, ...],
) -> Generator[Violation, None, bool]:
    """Follow one chaser up to the end of its last leg; returns whether it got there."""
    heights, led_from, oblateness_m2 = Heights(instance), set[str](), instance.oblateness_m2
    targets = {target.name: target for target in instance.targets}
    for at, leg in enumerate(route):
        number, following = first + at, route[at + 1] if at + 1 < len(route) else None
        leads_on = yield from _check_order(bodies, now, visited, number, leg)
        if not leads_on:
            return False
        if abs(leg.ready_s - now.free) > TIME_TOLERANCE_S:
            yield Violation(
                number,
                "ready",
                f"ready_s = {leg.ready_s!r}, but the chaser is free at {now.free!r}",
            )
        yield from _check_mass(now.tank, number, leg)
        i, j = bodies.number[leg.origin], bodies.number[leg.destination]
        arrival, delta_v = yield from check_transfer(
            instance, physics, now.chaser, number, leg, (i, j), now.free
        )
        yield from _check_leg_time(instance, now, number, arrival)
        yield from _check_zones(instance, number, leg)
        towed = physics.towed.get(leg.destination)
        end = yield from _check_service(
            instance, bodies, now, number, leg, arrival, physics.elements[j], towed
        )
        yield from check_tow(towed, number, leg, end, following, oblateness_m2)
        yield from check_lifetime(instance, number, targets.get(leg.destination), towed)
        if instance.given is None and leg.kind != GIVEN.name:
            until = end if leg.tow is None else leg.tow.start_s
            led = leg.kind == LAUNCH.name or leg.origin in led_from
            yield from heights.check(number, leg, arrival, until, led=led)
        led_from |= {leg.destination} & set(physics.towed)
        yield from _check_tank(bodies, now, visited, number, leg, delta_v, towed)
        if leg.destination in bodies.stations:
            now.since_refuelling = 0
        else:
            now.since_refuelling += 1
            now.targets += leg.destination not in visited
            visited.add(leg.destination)
        now.where, now.free = leg.destination, end + (towed.time_s if towed else 0.0)
        now.arrived = arrival
    return True


def _check_order(
    bodies: _Bodies, now: _Followed, visited: set[str], number: int, leg: Leg
) -> Generator[Violation, None, bool]:
    """Check that a leg starts where the chaser is and goes to an allowed body; returns whether.

    Nothing after a leg that leads nowhere has a state to be checked against.
    """
    unknown = [name for name in (leg.origin, leg.destination) if name not in bodies.number]
    if unknown:
        yield Violation(number, "body", f"{unknown[0]!r} is not a body of the instance")
        return False
    if leg.origin != now.where:
        yield Violation(
            number, "chain", f"starts at {leg.origin!r}, but the chaser is at {now.where!r}"
        )
    if leg.destination == leg.origin:
        yield Violation(number, "order", f"goes from {leg.origin!r} to itself")
        return False
    if leg.destination in bodies.stations:
        if now.since_refuelling == 0:
            yield Violation(
                number, "refuelling", "refuels again without a visit to a target in between"
            )
    elif leg.destination not in bodies.windows:
        yield Violation(number, "order", f"{leg.destination!r} is neither a target nor a station")
    else:
        if leg.destination in visited:
            yield Violation(number, "order", f"{leg.destination!r} was visited before")
        most = now.chaser.max_visits_between_refuels
        if most is not None and now.since_refuelling >= most:
            yield Violation(
                number,
                "targets",
                f"{now.chaser.name!r} may visit {most} targets between refuellings",
            )
    return True


def _check_mass(tank: TankLevel, number: int, leg: Leg) -> Iterator[Violation]:
    """Vent the stated propellant, and check that the chaser is then light enough for the leg."""
    if leg.vented_kg is not None:
        if leg.vented_kg > tank.propellant_kg + MASS_TOLERANCE * (tank.mass_kg or 0.0):
            yield Violation(
                number,
                "vented",
                f"vents {leg.vented_kg!r} kg of propellant, but has {tank.propellant_kg!r}",
            )
        tank.vent(leg.vented_kg)
    most = leg.mass_class_kg
    if most is not None and not (tank.mass_kg or math.inf) <= (1.0 + MASS_TOLERANCE) * most:
        truth = "unknown" if tank.mass_kg is None else f"{tank.mass_kg!r} kg"
        yield Violation(
            number,
            "mass-class",
            f"can be flown with a mass of up to {most!r} kg at departure, but it is {truth}",
        )


def _check_leg_time(
    instance: Instance, now: _Followed, number: int, arrival: float
) -> Iterator[Violation]:
    """Check the time from one arrival to the next; the first arrival has none before it."""
    most = instance.transfer.max_leg_s
    if most is not None and now.arrived is not None and arrival > now.arrived + most + SLACK_S:
        yield Violation(
            number,
            "leg-time",
            f"arrives {arrival - now.arrived!r} s after the last arrival, but may take {most!r} s",
        )


def _check_zones(instance: Instance, number: int, leg: Leg) -> Iterator[Violation]:
    """Check that no arc is in an active keep-out zone."""
    for which in crossed(instance, leg):
        zone = instance.keep_out_zones[which]
        yield Violation(
            number,
            "zone",
            f"crosses keep_out_zones[{which}], {zone.min_altitude_m:.0f}–"
            f"{zone.max_altitude_m:.0f} m, while it is closed from {zone.start_s:.0f} s "
            f"to {zone.end_s:.0f} s",
        )


def _check_service(
    instance: Instance,
    bodies: _Bodies,
    now: _Followed,
    number: int,
    leg: Leg,
    arrival: float,
    elements: npt.NDArray[np.float64],
    towed: Towed | None,
) -> Generator[Violation, None, float]:
    """Check the length of a service and its limits; returns its end.

    Where the destination is towed there has to be time for that, too.
    """
    stay = service_s(instance, elements, leg.destination in bodies.stations)
    intervals, capture = bodies.windows.get(leg.destination, (ALWAYS, None))
    capture = stay if capture is None else capture
    # At a closing edge, within the slack, one stay begins at once and another one waits.
    begins = [begin_of(intervals, arrival, capture - slack) for slack in (SLACK_S, -SLACK_S)]
    begin = min(begins, key=lambda begin: abs(leg.end_s - begin - stay))
    end = begin + stay
    closes = max(intervals[intervals[:, 0] <= begin, 1].tolist(), default=-math.inf)
    if abs(leg.end_s - end) > TIME_TOLERANCE_S:
        yield Violation(number, "service", f"end_s = {leg.end_s!r}, but it ends at {end!r}")
    free = end + (towed.time_s if towed else 0.0)
    if leg.tow is not None:
        free = max(free, leg.tow.end_s)
    for rule, ends, last in (
        ("duration", free, instance.mission.duration_s),
        ("availability", free, now.chaser.available_s[1]),
        ("window", begin + capture, closes),
    ):
        if last is not None and ends > last + SLACK_S:
            yield Violation(number, rule, f"ends at {ends!r} s, later than the limit of {last!r} s")
    return end


def begin_of(intervals: FloatArray, arrival: float, capture: float) -> float:
    """Start of a stay: the earliest after arrival whose capture lies within an interval.

    Where there is none, as if the first interval did not end.
    """
    begins = np.maximum(arrival, intervals[:, 0])
    fits = begins + capture <= intervals[:, 1]
    return float(begins[np.argmax(fits)]) if begins.size else arrival


def service_s(instance: Instance, elements: npt.NDArray[np.float64], at_station: bool) -> float:
    """Length of a chaser's stay at a body, in revolutions of the epoch [s]."""
    mission = instance.mission
    if not at_station and mission.service_s is not None:
        return mission.service_s
    revolutions = mission.refuel_revolutions if at_station else mission.service_revolutions
    assert revolutions is not None
    if revolutions == 0.0:  # also of a body without an orbit, which has no period
        return 0.0
    rate = float(ephemeris.latitude_rate_at(elements, ephemeris.EPOCH_S))
    return revolutions * 2.0 * math.pi / rate


def _check_tank(
    bodies: _Bodies,
    now: _Followed,
    visited: set[str],
    number: int,
    leg: Leg,
    delta_v: float,
    towed: Towed | None,
) -> Iterator[Violation]:
    """Check that the ΔV suffices, and the stated remainder."""
    tank = now.tank
    if delta_v > tank.left_m_s + SLACK_M_S:
        yield Violation(
            number, "delta-v", f"needs {delta_v!r} m/s, but only {tank.left_m_s!r} are left"
        )
    tank.burn(delta_v)
    if leg.destination in bodies.stations:
        before = tank.mass_kg
        tank.fill()
        now.drawn.fill(leg.destination, before, tank.mass_kg)
    elif leg.destination in bodies.kits - visited:
        tank.leave_kit()
    elif towed is not None and leg.destination not in visited:
        tank.tow(towed.delta_v_m_s, towed.mass_kg, towed.back_m_s)
        if tank.left_m_s < -SLACK_M_S:
            yield Violation(
                number, "delta-v", f"tows {leg.destination!r}, but has too little ΔV for that"
            )
    left = tank.left_m_s
    if abs(leg.delta_v_left_m_s - left) > DELTA_V_TOLERANCE_M_S:
        yield Violation(
            number,
            "delta-v-left",
            f"delta_v_left_m_s = {leg.delta_v_left_m_s!r}, but {left!r} are left",
        )
    mass = tank.mass_kg
    wrong = leg.mass_kg is not None
    if mass is not None:
        wrong = leg.mass_kg is None or abs(leg.mass_kg - mass) > MASS_TOLERANCE * mass
    if wrong:
        truth = "the tank is not one by mass" if mass is None else f"it is {mass!r}"
        yield Violation(number, "mass", f"mass_kg = {leg.mass_kg!r}, but {truth}")


def _check_end(plan: Plan, now: _Followed) -> Iterator[Violation]:
    """Check that the chaser ends at an allowed body, within its maximum number of targets."""
    chaser = now.chaser
    if chaser.max_targets is not None and now.targets > chaser.max_targets:
        yield Violation(
            None,
            "targets",
            f"{chaser.name!r} visits {now.targets} targets, but may visit {chaser.max_targets}",
        )
    if plan.status not in ("optimal", "feasible"):
        return
    if isinstance(chaser.end, AtStation) and now.where != chaser.end.station:
        yield Violation(
            None,
            "end",
            f"{chaser.name!r} ends at {now.where!r}, but has to end at {chaser.end.station!r}",
        )
