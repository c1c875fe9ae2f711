"""Check of legs over given connections, by search among the rows, or by the function of a pair."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np
import numpy.typing as npt

from ...common.constants import SLACK_S
from ...plan.leg_kinds import GIVEN
from ...plan.plan import Leg
from ...problem.given import Given
from ...problem.given_functions import Function
from .violation import DELTA_V_TOLERANCE_M_S, TIME_TOLERANCE_S, Violation

IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]


def check_given(
    given: Given, number: int, leg: Leg, free: float
) -> Generator[Violation, None, tuple[float, float]]:
    """Check that a leg is a row between its bodies that leaves no earlier than the chaser is free.

    Returns when the chaser arrives and the cost, to go on from: of the row, but as stated where
    there is none.
    """
    as_stated = leg.arrival_s, leg.delta_v_m_s
    if leg.kind != GIVEN.name or leg.burns:
        yield Violation(
            number,
            "given",
            f"is {leg.kind!r} with {len(leg.burns)} burns, but given connections are of kind "
            "'given' and have none",
        )
    if leg.phasing_revolutions or leg.eccentricity_delta_v_m_s:
        yield Violation(
            number, "given", "states revolutions or a share of eccentricity; must be 0 if given"
        )
    functions = given.functions
    function = None if functions is None else functions.of_pair(leg.origin, leg.destination)
    if function is not None:
        return (yield from _by_function(function, number, leg, free))
    rows, leaves, lands, same = _alike(given, leg)
    if not same.size:
        ends = f"from {leg.origin!r} to {leg.destination!r}"
        if not leaves.any():
            yield Violation(
                number, "departure", f"no given connection {ends} leaves at {leg.departure_s!r}"
            )
        elif not (leaves & lands).any():
            yield Violation(
                number,
                "arrival",
                f"no given connection {ends} leaves at {leg.departure_s!r} and arrives at "
                f"{leg.arrival_s!r}",
            )
        else:
            cost = float(given.cost[rows[leaves & lands]].min())
            yield Violation(
                number, "cost", f"delta_v_m_s = {leg.delta_v_m_s!r}, but it costs {cost!r}"
            )
        return as_stated
    # Of rows within the tolerances that is meant which is nearest to what is stated.
    off = np.abs(given.arrival[same] - leg.arrival_s) + np.abs(given.cost[same] - leg.delta_v_m_s)
    off += np.abs(given.departure[same] - leg.departure_s)
    row = int(same[int(np.argmin(off))])
    if given.departure[row] < free - SLACK_S:
        yield Violation(number, "departure", "leaves before the chaser is ready")
    return float(given.arrival[row]), float(given.cost[row])


def _by_function(
    function: Function, number: int, leg: Leg, free: float
) -> Generator[Violation, None, tuple[float, float]]:
    """Check that a leg arrives and costs as the function of its pair says.

    Returns when the chaser arrives and the cost, as :func:`check_given` does.
    """
    ends = f"from {leg.origin!r} to {leg.destination!r}"
    first, last = float(function.departure[0]), float(function.departure[-1])
    if not first - TIME_TOLERANCE_S <= leg.departure_s <= last + TIME_TOLERANCE_S:
        yield Violation(
            number,
            "departure",
            f"legs {ends} leave from {first!r} to {last!r}, not at {leg.departure_s!r}",
        )
        return leg.arrival_s, leg.delta_v_m_s
    # Within the tolerance of a jump either arrival may be meant.
    early, late = (
        _arrival(function, leg.departure_s + shift)
        for shift in (-TIME_TOLERANCE_S, TIME_TOLERANCE_S)
    )
    arrival = _arrival(function, leg.departure_s)
    if not early - TIME_TOLERANCE_S <= leg.arrival_s <= late + TIME_TOLERANCE_S:
        yield Violation(
            number,
            "arrival",
            f"leaving {ends} at {leg.departure_s!r} arrives at {arrival!r}, not at "
            f"{leg.arrival_s!r}",
        )
        arrival = leg.arrival_s
    elif abs(arrival - leg.arrival_s) > TIME_TOLERANCE_S:
        arrival = leg.arrival_s
    if abs(leg.delta_v_m_s - function.cost) > DELTA_V_TOLERANCE_M_S:
        yield Violation(
            number, "cost", f"delta_v_m_s = {leg.delta_v_m_s!r}, but it costs {function.cost!r}"
        )
        return arrival, leg.delta_v_m_s
    if leg.departure_s < free - SLACK_S:
        yield Violation(number, "departure", "leaves before the chaser is ready")
    return arrival, function.cost


def _arrival(function: Function, departure_s: float) -> float:
    """Arrival for a departure by the function of a pair; at a jump, the earlier one [s]."""
    after = int(np.searchsorted(function.departure, departure_s, side="left"))
    if after in (0, function.departure.size):
        return float(function.arrival[min(after, function.departure.size - 1)])
    leaves, lands = (
        function.departure[after - 1 : after + 1],
        function.arrival[after - 1 : after + 1],
    )
    return float(np.interp(departure_s, leaves, lands))


def _alike(given: Given, leg: Leg) -> tuple[IntArray, BoolArray, BoolArray, IntArray]:
    """Given rows between a leg's bodies: with its departure, with its arrival, and with both."""
    known = {name: at for at, name in enumerate(given.names)}
    i, j = known.get(leg.origin, -1), known.get(leg.destination, -1)
    # Rows are in order of origins, and those of an origin in order of destinations.
    first, last = np.searchsorted(given.origin, [i, i + 1])
    rows = first + np.flatnonzero(given.destination[first:last] == j)
    leaves = np.abs(given.departure[rows] - leg.departure_s) <= TIME_TOLERANCE_S
    lands = np.abs(given.arrival[rows] - leg.arrival_s) <= TIME_TOLERANCE_S
    costs = np.abs(given.cost[rows] - leg.delta_v_m_s) <= DELTA_V_TOLERANCE_M_S
    return rows, leaves, lands, rows[leaves & lands & costs]
