"""Comparison of a leg's stated figures and burns with the recomputed ones."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence

import numpy as np
import numpy.typing as npt

from ...common.constants import SLACK_S
from ...plan.plan import Leg
from ...problem.instance import Instance
from .violation import DELTA_V_TOLERANCE_M_S, TIME_TOLERANCE_S, Violation


def check_costs(
    delta_v: float, shape: float, number: int, leg: Leg, tolerance: float = DELTA_V_TOLERANCE_M_S
) -> Iterator[Violation]:
    """Check ΔV, and its share for matching eccentricities, against recomputed values [m/s]."""
    if abs(leg.delta_v_m_s - delta_v) > tolerance:
        yield Violation(
            number, "cost", f"delta_v_m_s = {leg.delta_v_m_s!r}, but it costs {delta_v!r}"
        )
    if abs(leg.eccentricity_delta_v_m_s - shape) > tolerance:
        yield Violation(
            number,
            "eccentricity",
            f"eccentricity_delta_v_m_s = {leg.eccentricity_delta_v_m_s!r}, but it is {shape!r}",
        )


def check_burns(
    number: int,
    leg: Leg,
    times: npt.NDArray[np.float64],
    vectors: npt.NDArray[np.float64],
    phases: Sequence[str],
) -> Iterator[Violation]:
    """Check the burns against the sequence: phases, times [s] and vectors [m/s]."""
    stated_phases = [burn.phase for burn in leg.burns]
    expected_phases = list(phases)
    if stated_phases != expected_phases:
        yield Violation(
            number, "burns", f"phases are {stated_phases}, but should be {expected_phases}"
        )
        return
    for which, burn in enumerate(leg.burns):
        late = abs(burn.time_s - times[which])
        off = float(np.linalg.norm(np.array(burn.delta_v_m_s) - vectors[which]))
        if late > TIME_TOLERANCE_S or off > DELTA_V_TOLERANCE_M_S:
            yield Violation(
                number,
                "burns",
                f"burn {which + 1} ({burn.phase}) is off by {late:.3g} s and {off:.3g} m/s",
            )


def check_times(
    instance: Instance, number: int, leg: Leg, free: float
) -> Generator[Violation, None, bool]:
    """Check that a leg takes no longer than drifts may, and leaves when the chaser is free [s]."""
    span, longest = leg.arrival_s - leg.departure_s, instance.transfer.max_drift_s
    if not 0.0 < span <= longest + TIME_TOLERANCE_S:
        yield Violation(
            number, "drift", f"drifts for {span!r} s, but may drift for at most {longest!r} s"
        )
        return False
    if leg.departure_s < free - SLACK_S:
        yield Violation(number, "departure", "leaves before the chaser is ready")
        return False
    return True
