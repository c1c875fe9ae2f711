"""Check of legs over given connections, by search among the rows."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np
import numpy.typing as npt

from ...common.constants import SLACK_S
from ...plan.leg_kinds import GIVEN
from ...plan.plan import Leg
from ...problem.given import Given
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


def _alike(given: Given, leg: Leg) -> tuple[IntArray, BoolArray, BoolArray, IntArray]:
    """Rows between the bodies of a leg; which leave and which land with it; those that are it."""
    known = {name: at for at, name in enumerate(given.names)}
    i, j = known.get(leg.origin, -1), known.get(leg.destination, -1)
    # Rows are in order of origins, and those of an origin in order of destinations.
    first, last = np.searchsorted(given.origin, [i, i + 1])
    rows = first + np.flatnonzero(given.destination[first:last] == j)
    leaves = np.abs(given.departure[rows] - leg.departure_s) <= TIME_TOLERANCE_S
    lands = np.abs(given.arrival[rows] - leg.arrival_s) <= TIME_TOLERANCE_S
    costs = np.abs(given.cost[rows] - leg.delta_v_m_s) <= DELTA_V_TOLERANCE_M_S
    return rows, leaves, lands, rows[leaves & lands & costs]


def is_exception(given: Given | None, leg: Leg) -> bool:
    """Whether a leg is a given connection, and all rows that it may be are exceptions."""
    if given is None or given.exception is None or leg.kind != GIVEN.name:
        return False
    same = _alike(given, leg)[3]
    return bool(same.size and given.exception[same].all())
