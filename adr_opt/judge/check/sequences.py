"""All transfers between two bodies that leave soon after a time, by the physics of `check`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ...kernels.legs import co_elliptic, precession, zones
from ...kernels.orbits import ephemeris
from ...legs.families.family import Way
from ...problem.drives import Drive
from ...problem.instance import Instance
from .drift import drift_cost
from .eccentric import StatedSequence, short_cost
from .leg import Physics
from .low_thrust_optimum import cost_between

MOST_STEPS, CLOSE_S = 60, 1e-6
"""Maximum number of fixed-point steps where planes drift, and their tolerance [s]."""

STEADY_RAD = 0.2
"""Largest shift of the line of nodes for which a sequence must be present: beyond it, the few
fixed-point steps of planning or flying may not find it [rad]."""

LEAVING_S = 2.0 * 17.0
"""Time before the next piece of a tow from apogee in which no sequence need leave [s]."""

NEAREST_RAD = 1e-4
"""Least angle between planes at departure for which a sequence must be present: below it, the
flight itself makes the line of nodes, as between objects in one plane of which one was towed [rad].
"""


class _Event(NamedTuple):
    """A crossing of the target's plane: time [s], number, and line of nodes [rad]."""

    time: float
    half_turns: int
    alpha_i: float
    alpha_j: float
    theta: float


class _Found(NamedTuple):
    """A sequence.

    Number of the crossing on which it meets the target, k, when it leaves and is at the stand-off
    [s], phasing radius [m], turn and by how much the flight moves the line of nodes [rad].
    """

    crossing: int
    laps: int
    departure: float
    met: float
    radius: float
    theta: float
    moved: float


def ways_after(
    instance: Instance, physics: Physics, drive: Drive | None, i: int, j: int, time: float
) -> Iterator[Way]:
    """Transfers that must be present at the next event after a time; of given ones, all later rows.

    Of low thrust some of them, of chasers with the least and with the largest mass by turns.

    Where events are kept apart, which of them are left is no matter of physics: then there are none
    of those, and only those that drift.
    """
    if physics.given is not None:
        rows = physics.given.of_pair(instance.names[i], instance.names[j])
        yield from (Way(*row) for row in np.transpose(rows).tolist() if row[0] >= time)
        return
    settings = instance.transfer
    if drive is not None:
        yield from _low_thrust(instance, physics, drive, i, j, time)
        return
    if settings.departure_spacing_s == 0.0:
        yield from _short(instance, physics, i, j, time)
    if instance.dynamics == "j2" and settings.max_drift_s > 0.0 and not instance.keep_out_zones:
        step = settings.drift_step_s
        leaves = math.ceil(time / step) * step
        for number in range(1, int(settings.max_drift_s / step + 1e-9) + 1):
            lands = leaves + number * step
            if lands > instance.mission.duration_s:
                break
            left = physics.leaving(i, leaves)
            cost, _ = drift_cost(left, physics.elements[j], physics.rule, leaves, lands)
            yield Way(leaves, lands, cost)


def _low_thrust(
    instance: Instance, physics: Physics, drive: Drive, i: int, j: int, time: float
) -> Iterator[Way]:
    """Low-thrust legs of 1, 2, 4 … steps of the grid from the next time of it on."""
    settings = instance.transfer
    step, number, heavy = settings.drift_step_s, 1, False
    leaves = math.ceil(time / step) * step
    while number * step <= settings.max_drift_s:
        lands = leaves + number * step
        if lands > instance.mission.duration_s:
            break
        ends = physics.left[i], physics.elements[j]
        mass = drive.heaviest_kg if heavy else drive.lightest_kg
        cost = cost_between(instance, ends, physics.rule, drive, leaves, lands, mass)
        if math.isfinite(cost):
            yield Way(leaves, lands, cost)
        number, heavy = 2 * number, not heavy


def _short(instance: Instance, physics: Physics, i: int, j: int, time: float) -> Iterator[Way]:
    """The co-elliptic sequences of the next event that must be present.

    Where planes drift, the flight itself moves the line of nodes a little, so that the sequences of
    an event leave apart, and those that meet the target on one crossing meet it apart. Connections
    have *the cheapest of each crossing*, and sequences of one event count as *leaving together*:
    then one that meets the target on an earlier crossing is as good if it costs no more.
    """
    rule, ends = physics.rule, (physics.leaving(i, time), physics.elements[j])
    pair = co_elliptic.prepare(*ends, 0.0, rule, ephemeris.EPOCH_S)
    approach = rule.approach_revolutions * 2.0 * math.pi / pair.rate_j
    # Where a tow begins at an apogee the chaser is another body after the next one.
    since_s, ends_s = 0.0, math.inf
    if i in physics.pieced:
        towed = physics.pieced[i]
        since_s = towed.time_s  # before which nobody has towed it
        ends_s = towed.begins_s(time) + towed.flight_s + towed.period_s - LEAVING_S
    cheapest: dict[int, tuple[Way, bool]] = {}
    settled = _drifting if instance.dynamics == "j2" else _fixed
    for crossing, laps, departure, met, radius, theta, moved in settled(pair, rule, time):
        if not since_s <= departure <= ends_s:
            continue
        if zones.is_blocked(pair, rule, laps, radius, departure):
            continue
        arrival = met + approach
        sequence = StatedSequence(departure, arrival, laps, radius, theta)
        turned = 4.0 * math.sin(0.5 * theta) ** 2
        circles = float(co_elliptic.turned_delta_v(pair, rule, laps, radius, turned, 0.0))
        delta_v = short_cost(ends, rule, departure, sequence, circles)
        if crossing not in cheapest or delta_v < cheapest[crossing][0].delta_v:
            cheapest[crossing] = Way(departure, arrival, delta_v), moved < STEADY_RAD
    first = math.inf
    for crossing in sorted(cheapest):
        way, is_steady = cheapest[crossing]
        first = min(first, way.departure)
        if is_steady:
            yield way._replace(early=way.departure - first)


def _limits(pair: co_elliptic.Pair, laps: int) -> tuple[float, float]:
    """Limits on the duration of a flight with k revolutions [s]."""
    return pair.shortest + laps * pair.shortest_lap, pair.longest + laps * pair.longest_lap


def _crossings(
    pair: co_elliptic.Pair, rule: co_elliptic.TransferRule, departure: float, met: float
) -> Iterator[tuple[int, int, float]]:
    """Number, k and time of all crossings where the target may be met, and one more on either side.

    They are whole laps from one of them.
    """
    lap = 2.0 * math.pi / pair.rate_j
    for laps in range(rule.max_phasing_revolutions + 1):
        low, high = _limits(pair, laps)
        begin = math.ceil((departure + low - met) / lap) - 1
        end = math.floor((departure + high - met) / lap) + 1
        for crossing in range(begin, end + 1):
            yield crossing, laps, met + crossing * lap


def _fixed(pair: co_elliptic.Pair, rule: co_elliptic.TransferRule, time: float) -> Iterator[_Found]:
    """All sequences of the next event where planes are fixed, which leave at once."""
    half_turns = math.ceil((pair.phase_i + pair.rate_i * time) / math.pi)
    departure = (half_turns * math.pi - pair.phase_i) / pair.rate_i
    behind = math.pi * (half_turns + 1) + rule.standoff / pair.radius_j - pair.phase_j
    for crossing, laps, met in _crossings(pair, rule, departure, behind / pair.rate_j):
        low, high = _limits(pair, laps)
        if low <= met - departure <= high:
            radius = float(co_elliptic.phasing_radius(pair, rule, laps, met - departure))
            yield _Found(crossing, laps, departure, met, radius, pair.theta, 0.0)


def _drifting(
    pair: co_elliptic.Pair, rule: co_elliptic.TransferRule, time: float
) -> Iterator[_Found]:
    """All sequences of the next event where nodes drift, each a fixed point of its line of nodes.

    It begins at the event, and where the target would be met if the flight itself did nothing to
    the line.
    """
    event = _next_event(pair, time)
    if event is None or event.theta < NEAREST_RAD:
        return
    behind = event.alpha_j + math.pi * (event.half_turns + 1) + rule.standoff / pair.radius_j
    behind -= pair.latitude_j
    # Crossings are counted on a clock by which the target turns at the rate of the epoch.
    bend_i, bend_j = (0.5 * each for each in (pair.acceleration_i, pair.acceleration_j))
    begun = event.time + bend_j / pair.rate_j * event.time**2
    for crossing, laps, even in _crossings(pair, rule, begun, behind / pair.rate_j):
        about = _at_angle(pair.rate_j * even, pair.rate_j, bend_j)
        rate_i = pair.rate_i + 2.0 * bend_i * event.time
        rate_j = pair.rate_j + 2.0 * bend_j * about
        departure, met = event.time, about
        for _ in range(MOST_STEPS):
            radius = float(co_elliptic.phasing_radius(pair, rule, laps, met - departure))
            apart = pair.lag + pair.lag_rate * departure
            apart += precession.carried(pair, rule, laps, radius, met - departure)
            alpha_i, alpha_j, theta = ephemeris.relative_node(
                pair.inclination_i, 0.0, pair.inclination_j, apart
            )
            moved_i = math.remainder(alpha_i - event.alpha_i, 2.0 * math.pi)
            moved_j = math.remainder(alpha_j - event.alpha_j, 2.0 * math.pi)
            left, there = event.time + moved_i / rate_i, about + moved_j / rate_j
            if not math.isfinite(left + there):
                break  # no phasing orbit takes so long
            step = abs(left - departure) + abs(there - met)
            departure, met = left, there
            if step < CLOSE_S:
                low, high = _limits(pair, laps)
                if departure >= 0.0 and low <= met - departure <= high:
                    moved = max(abs(moved_i), abs(moved_j))
                    yield _Found(crossing, laps, departure, met, radius, theta, moved)
                break


def _at_angle(angle: float, rate: float, bend: float) -> float:
    """Time at which rate · t + bend · t² is an angle, by Newton's method from bend = 0 [s]."""
    time = angle / rate
    for _ in range(MOST_STEPS if bend else 0):
        step = ((rate + bend * time) * time - angle) / (rate + 2.0 * bend * time)
        time -= step
        if abs(step) < 0.01 * CLOSE_S:
            break
    return time


def _next_event(pair: co_elliptic.Pair, time: float) -> _Event | None:
    """Next crossing of the target's plane; None if none is found."""
    there, half_turns = time, 0
    for step in range(MOST_STEPS):
        alpha_i, alpha_j, theta = ephemeris.relative_node(
            pair.inclination_i, 0.0, pair.inclination_j, pair.lag + pair.lag_rate * there
        )
        gained = (pair.rate_i + 0.5 * pair.acceleration_i * there) * there
        past = (pair.latitude_i + gained - alpha_i) / math.pi
        if step == 0:
            half_turns = math.ceil(past)
        # The node that was left for may be counted a whole turn away by now.
        rate_i = pair.rate_i + pair.acceleration_i * there
        late = math.remainder(half_turns - past, 2.0) * math.pi / rate_i
        there += late
        if abs(late) < CLOSE_S:
            return _Event(there, round(past), alpha_i, alpha_j, theta)
    return None
