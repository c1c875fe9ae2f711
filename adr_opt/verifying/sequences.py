"""All ways to go from a body to another one that leave soon after a time, by `check`'s physics."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..checking.eccentric import Sequence, matching_cost
from ..checking.flight import Physics, drift_cost
from ..instance import Instance
from ..kernels import keep_out, orbits, precession, transfer
from ..plan import Leg

MOST_STEPS, CLOSE_S = 60, 1e-6
"""Steps of the fixed point of a sequence where planes drift, and when it is found [s]."""

STEADY_RAD = 0.02
"""Sequences that carry their line of nodes further are not looked at: those of one event leave far
apart there, and connections have only the cheapest of those that arrive together [rad]."""

NEAREST_RAD = 1e-4
"""Nor are those between planes that are nearer at the departure, whose line of nodes the flight
itself makes: of objects in one plane, say, one of which was towed [rad]."""


class Way(NamedTuple):
    """A transfer: when it leaves and arrives [s], and what it costs [m/s]."""

    departure: float
    arrival: float
    delta_v: float


def ways_after(instance: Instance, physics: Physics, i: int, j: int, time: float) -> Iterator[Way]:
    """All transfers that leave at the next event after a time, of given ones all rows after it.

    Where events are kept apart, which of them are left is no matter of physics: then there are none
    of those, and only those that drift.
    """
    if physics.given is not None:
        rows = physics.given.of_pair(instance.names[i], instance.names[j])
        yield from (Way(*row) for row in np.transpose(rows).tolist() if row[0] >= time)
        return
    settings = instance.transfer
    if settings.departure_spacing_s == 0.0:
        yield from _short(instance, physics, i, j, time)
    if instance.dynamics == "j2" and settings.max_drift_s > 0.0 and not instance.keep_out_zones:
        step = settings.drift_step_s
        leaves = math.ceil(time / step) * step
        for number in range(1, int(settings.max_drift_s / step + 1e-9) + 1):
            lands = leaves + number * step
            if lands > instance.mission.duration_s:
                break
            cost, _ = drift_cost(
                physics.left[i], physics.elements[j], physics.rule, _leg(leaves, lands)
            )
            yield Way(leaves, lands, cost)


def _leg(leaves: float, lands: float) -> Leg:
    """A leg that is nothing but its times [s]."""
    return Leg(
        kind="drift", origin="i", destination="j", ready_s=leaves, departure_s=leaves,
        arrival_s=lands, end_s=lands, delta_v_m_s=0.0, delta_v_left_m_s=0.0, phasing_revolutions=0,
        burns=(),
    )  # fmt: skip


def _short(instance: Instance, physics: Physics, i: int, j: int, time: float) -> Iterator[Way]:
    """The co-elliptic sequences of the next crossing of the line of nodes."""
    rule = physics.rule
    pair = transfer.prepare(physics.left[i], physics.elements[j], 0.0, rule)
    lap = 2.0 * math.pi / pair.rate_j
    approach = rule.approach_revolutions * lap
    for laps in range(rule.max_phasing_revolutions + 1):
        low = pair.shortest + laps * pair.shortest_lap
        high = pair.longest + laps * pair.longest_lap
        seen = -math.inf
        for turn in range(int((high - low) / lap) + 3):
            flight = low + turn * lap
            if instance.dynamics == "j2":
                found = _drifting(pair, rule, laps, time, flight)
            else:
                found = _fixed(pair, rule, laps, time, flight)
            if found is None:
                continue
            departure, met, radius, theta = found
            if not low <= met - departure <= high or met - seen < 0.5 * lap:
                continue
            seen = met
            if keep_out.is_blocked(pair, rule, laps, radius, departure):
                continue
            arrival = met + approach
            sequence = Sequence(departure, arrival, laps, radius, theta)
            turned = 4.0 * math.sin(0.5 * theta) ** 2
            circles = float(transfer.turned_delta_v(pair, rule, laps, radius, turned, 0.0))
            ends = physics.left[i], physics.elements[j]
            yield Way(
                departure, arrival, max(circles, matching_cost(*ends, rule, departure, sequence))
            )


def _fixed(
    pair: transfer.Pair, rule: transfer.TransferRule, laps: int, time: float, flight: float
) -> tuple[float, float, float, float] | None:
    """Departure, arrival at the stand-off [s], phasing radius [m] and turn of a sequence [rad]."""
    half_turns = math.ceil((pair.phase_i + pair.rate_i * time) / math.pi)
    departure = (half_turns * math.pi - pair.phase_i) / pair.rate_i
    behind = math.pi * (half_turns + 1) + rule.standoff / pair.radius_j
    behind -= pair.phase_j + pair.rate_j * (departure + flight)
    met = departure + flight + math.remainder(behind, 2.0 * math.pi) / pair.rate_j
    radius = transfer.phasing_radius(pair, rule, laps, met - departure)
    return departure, met, radius, pair.theta


def _drifting(
    pair: transfer.Pair, rule: transfer.TransferRule, laps: int, time: float, flight: float
) -> tuple[float, float, float, float] | None:
    """The same where nodes drift, by a fixed point; None where none is found."""
    departure, met = time, time + flight
    half_turns: int | None = None
    for _ in range(MOST_STEPS):
        radius = float(transfer.phasing_radius(pair, rule, laps, met - departure))
        apart = pair.lag + pair.lag_rate * departure
        apart += precession.carried(pair, rule, laps, radius, met - departure)
        alpha_i, alpha_j, theta = orbits.relative_node(
            pair.inclination_i, 0.0, pair.inclination_j, apart
        )
        past = (pair.latitude_i + pair.rate_i * departure - alpha_i) / math.pi
        if half_turns is None:
            half_turns = math.ceil(past)
            left = departure + (half_turns - past) * math.pi / pair.rate_i
        else:
            # The node that was left for may be counted a whole turn away by now.
            left = departure + math.remainder(half_turns - past, 2.0) * math.pi / pair.rate_i
        if not math.isfinite(left):
            return None  # no phasing orbit takes so long
        crossing = round((pair.latitude_i + pair.rate_i * left - alpha_i) / math.pi)
        behind = alpha_j + math.pi * (crossing + 1) + rule.standoff / pair.radius_j
        behind -= pair.latitude_j + pair.rate_j * met
        there = met + math.remainder(behind, 2.0 * math.pi) / pair.rate_j
        step = abs(left - departure) + abs(there - met)
        departure, met = left, there
        if step < CLOSE_S:
            still, _, angle = orbits.relative_node(
                pair.inclination_i, 0.0, pair.inclination_j, pair.lag + pair.lag_rate * departure
            )
            is_steady = abs(math.remainder(alpha_i - still, math.pi)) < STEADY_RAD
            is_steady &= angle > NEAREST_RAD
            return (departure, met, radius, theta) if is_steady else None
    return None
