"""Check of low-thrust legs: whether their arcs can be flown as stated, and lead to the target."""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator

import numpy as np
import numpy.typing as npt

from ...common.constants import MU_M3_S2
from ...kernels.legs.co_elliptic import TransferRule
from ...plan.plan import Leg, LowThrustArc
from ...problem.drives import Drive, since_j2000_s
from ...problem.instance import Instance
from .drift_ends import Ends, ends_of
from .figures import check_times
from .low_thrust_form import (
    WINDOWS_DEG,
    Steered,
    laps_at,
    node_to_turn,
    places_of,
    settled,
    shadows_of,
)
from .low_thrust_windows import steered_in, with_shape
from .violation import LOW_THRUST_TOLERANCE_M_S, TIME_TOLERANCE_S, Violation

FloatArray = npt.NDArray[np.float64]

FIGURE_M_S, NODE_M_S, LAPS = 1e-3, 2e-2, 1e-3
"""Tolerances on changes of size and inclination, of the node [m/s], and on laps."""

ANGLE_DEG = 1e-3
"""Tolerance on angles of arcs [deg]."""

TIMES = 1e-5
"""Tolerance on the durations of arcs, as a share of the leg."""

SMALL_M_S = 1.0
"""Change of plane below which its place is not checked: without a change, any place will do."""


def check_low_thrust(
    instance: Instance,
    ends: tuple[FloatArray, FloatArray],
    rule: TransferRule,
    drive: Drive | None,
    number: int,
    leg: Leg,
    free: float,
) -> Generator[Violation, None, tuple[float, float]]:
    """Check that the arcs of a low-thrust leg lead to its target, for the heaviest of its class.

    A leg need not be the cheapest of all laps; it has to take what its arcs do.

    Parameters
    ----------
    ends : (columns + 1,) float64, (columns,) float64
        The origin as it is left, with the rate of its node after that, and the destination.
    drive : Drive or None
        Of the chaser.
    """
    as_stated = leg.arrival_s, leg.delta_v_m_s
    if drive is None:
        yield Violation(number, "kind", "is a low-thrust leg, but its chaser has no low thrust")
        return as_stated
    if not (yield from check_times(instance, number, leg, free)):
        return as_stated
    yield from _check_arcs(instance, ends, rule, drive, number, leg)
    return as_stated


def _check_arcs(
    instance: Instance,
    ends: tuple[FloatArray, FloatArray],
    rule: TransferRule,
    drive: Drive,
    number: int,
    leg: Leg,
) -> Iterator[Violation]:
    """Check that the arcs of a leg lead to its target, with the ΔV and in the time of the leg."""
    arcs = leg.manoeuvres or ()
    if len(arcs) != 2:
        yield Violation(number, "manoeuvres", "must have two arcs")
        return
    for off, most, what in _errors(instance, ends, rule, drive, leg, (arcs[0], arcs[1])):
        if not abs(off) <= most:
            yield Violation(number, "manoeuvres", f"{what} {off:.6g}")
            return


def _errors(
    instance: Instance,
    ends: tuple[FloatArray, FloatArray],
    rule: TransferRule,
    drive: Drive,
    leg: Leg,
    arcs: tuple[LowThrustArc, LowThrustArc],
) -> Iterator[tuple[float, float, str]]:
    """Errors of a leg's arcs, each with its tolerance and the beginning of its message."""
    nearer = ends_of(*ends, rule, leg.departure_s, leg.arrival_s)
    one, other = arcs
    for arc in arcs:
        known = min(WINDOWS_DEG, key=lambda window: abs(window - arc.window_deg))
        yield arc.window_deg - known, ANGLE_DEG, f"the nearest window is {known:g}°; off by [deg]"
    yield other.window_deg - one.window_deg, ANGLE_DEG, "the windows of both arcs differ by [deg]"
    yield one.start_s - leg.departure_s, TIME_TOLERANCE_S, "the first arc begins late by [s]"
    met = leg.arrival_s - nearer.approach
    yield other.end_s - met, TIME_TOLERANCE_S, "the second arc ends late by [s]"
    yield min(other.start_s - one.end_s, 0.0), TIME_TOLERANCE_S, "the arcs overlap by [s]"
    start, end = math.sqrt(MU_M3_S2 / nearer.radius_i), math.sqrt(MU_M3_S2 / nearer.radius_j)
    sizes = start - end - one.size_m_s - other.size_m_s
    yield sizes, FIGURE_M_S, "the change of size is incomplete by [m/s]"
    speed = start - one.size_m_s
    slowest, fastest = math.sqrt(MU_M3_S2 / rule.max_radius), math.sqrt(MU_M3_S2 / rule.min_radius)
    beyond = max(slowest - speed, speed - fastest, 0.0)
    yield beyond, FIGURE_M_S, "the drift orbit is beyond the altitude limits by [m/s]"
    tilts = [math.radians(arc.inclination_deg) for arc in arcs]
    left = nearer.inclination_j - nearer.inclination_i - sum(tilts)
    yield nearer.speed * left, FIGURE_M_S, "the change of inclination is incomplete by [m/s]"
    nodes = [math.radians(arc.raan_deg) for arc in arcs]
    times = one.end_s - one.start_s, other.end_s - other.start_s
    wanted = float(node_to_turn(nearer, times, speed, nearer.speed * tilts[0]))
    turns = round((sum(nodes) - wanted) / (2.0 * math.pi))
    still = wanted + 2.0 * math.pi * turns - sum(nodes)
    yield (nearer.speed * nearer.sine * still, NODE_M_S, "the node's change is incomplete by [m/s]")
    whole = nearer._replace(
        node=nearer.node + 2.0 * math.pi * turns,
        ahead=nearer.ahead + nearer.cosine * 2.0 * math.pi * turns,
    )
    laps = float(laps_at(whole, times, speed))
    yield laps - round(laps), LAPS, "the laps differ from a whole number by"
    yield from _costs(
        _steered(instance, ends, rule, drive, leg, whole, one.window_deg), whole, leg, arcs
    )


def _costs(
    steered: Steered, whole: Ends, leg: Leg, arcs: tuple[LowThrustArc, LowThrustArc]
) -> Iterator[tuple[float, float, str]]:
    """Errors of the ΔV, places and durations of arcs, recomputed from their changes."""
    forms = []
    for arc in arcs:
        tilt = whole.speed * math.radians(arc.inclination_deg)
        along = whole.speed * whole.sine * math.radians(arc.raan_deg)
        forms.append(math.hypot(arc.size_m_s, steered.turn * math.hypot(tilt, along)))
        if math.hypot(tilt, along) > SMALL_M_S:
            place = math.degrees(math.atan2(along, tilt))
            off = math.remainder(arc.argument_of_latitude_deg - place, 360.0)
            yield off, ANGLE_DEG, "the place of thrust is off by [deg]"
    both = sum(forms)
    form = with_shape(both, steered.shape, arcs[0].size_m_s, arcs[1].size_m_s)
    total = 4.0 * whole.speed * math.sin(min(0.25 * form / whole.speed, 0.5 * math.pi))
    costs = [total * (part / both if both > 0.0 else 0.5) for part in forms]
    for arc, cost in zip(arcs, costs, strict=True):
        yield arc.delta_v_m_s - cost, LOW_THRUST_TOLERANCE_M_S, "ΔV of an arc is off by [m/s]"
    stated = math.fsum(arc.delta_v_m_s for arc in arcs) - leg.delta_v_m_s
    yield stated, FIGURE_M_S, "the arcs' ΔV exceeds the leg's by [m/s]"
    times = tuple(arc.end_s - arc.start_s for arc in arcs)
    needed, _ = settled((times[0], times[1]), steered, costs[0], costs[1])
    for time, least in zip(times, needed, strict=True):
        yield (time - least, TIMES * whole.span, "the times of an arc and its thrust differ by [s]")


def _steered(
    instance: Instance,
    ends: tuple[FloatArray, FloatArray],
    rule: TransferRule,
    drive: Drive,
    leg: Leg,
    whole: Ends,
    window_deg: float,
) -> Steered:
    """Places of thrust of a leg with one width of windows."""
    shadows, rates = shadows_of(
        ends, whole, since_j2000_s(instance.epoch), leg.departure_s, leg.arrival_s
    )
    places, part = places_of(whole, rates, (rule.min_radius, rule.max_radius))
    turn, shares, shape = steered_in(math.radians(window_deg), whole, places, part, shadows)
    mass_kg = drive.heaviest_kg if leg.mass_class_kg is None else leg.mass_class_kg
    return Steered(turn, shares, shape, drive.thrust_n / mass_kg, drive.exhaust_m_s, 0.0)
