"""Corrections of the model learned from refined legs."""

from __future__ import annotations

import math
from collections.abc import Iterable
from statistics import LinearRegression, linear_regression

from ...legs.corrections import Corrections
from ...plan.leg_kinds import leg_kinds
from ...plan.plan import Leg, Plan
from ...plan.refined_plan import RefinedLeg, RefinedPlan
from .all_legs import INTERRUPTED

Key = tuple[str, str, str]
Cost = tuple[float, float]
"""Planned and flown ΔV [m/s]."""

LEAST_FACTOR = 0.1
"""Lower limit of cost factors, so that no transfer becomes free."""

MOST_OF_A_LINE = 4
"""Number of drift legs from which a line is fitted to their costs; below it, the mean excess."""


class Lessons:
    """Costs of the legs refined so far, against their plans.

    All connections of a kind are corrected by what its legs cost in the mean. For short ones that
    is a factor. For those that drift it is an addition as well: the model does not know their
    phase, and to close that within a day or two costs what it costs, however small the rest is.
    Those of a pair that has been flown cost what the dearest of its legs did, against the mean;
    they are left out if no trajectory was found. So a plan costs from then on at least what its
    legs were flown with.

    Parameters
    ----------
    spend_savings : bool
        Whether connections may become cheaper than the model says. Where flown legs save ΔV they
        do so by burns that the model does not know; a plan that counts on it may be one that
        ``check`` refuses.
    """

    def __init__(self, spend_savings: bool = False) -> None:
        self._savings = spend_savings
        self._legs: dict[Key, set[Cost]] = {}

    @staticmethod
    def _key(leg: Leg | RefinedLeg) -> Key:
        return leg.origin, leg.destination, leg.kind

    def learn(self, plan: Plan, refined: RefinedPlan) -> None:
        """Record the refined costs of a plan's legs."""
        for leg in refined.legs:
            costs = leg.planned_delta_v_m_s, leg.flown_delta_v_m_s
            self._legs.setdefault(self._key(leg), set()).add(costs)
        for missing in refined.missing:
            if missing.reason != INTERRUPTED:
                lost = plan.legs[missing.leg - 1]
                self._legs.setdefault(self._key(lost), set()).add((lost.delta_v_m_s, math.inf))

    @property
    def corrections(self) -> Corrections:
        """Corrections derived from the recorded costs."""
        least = LEAST_FACTOR if self._savings else 1.0
        factors: dict[str, float] = {}
        additions: dict[str, float] = {}
        for kind in leg_kinds():
            own = [costs for key, costs in self._legs.items() if key[2] == kind.name]
            legs = [cost for costs in own for cost in costs]
            legs = sorted(cost for cost in legs if math.isfinite(cost[1]))
            if legs:
                factors[kind.name], additions[kind.name] = _line(
                    legs, least, drifts=kind.on_time_grid
                )
        means = Corrections({}, factors, additions)
        shares = {
            key: max(
                0.0 if self._savings else 1.0 / means.of_kind(key[2])[0],
                max(flown / means.corrected(*key, planned) for planned, flown in costs),
            )
            for key, costs in self._legs.items()
        }
        return Corrections(shares, factors, additions)


def _line(legs: list[Cost], least: float, *, drifts: bool) -> tuple[float, float]:
    """Factor, not below the least, and non-negative offset of the legs' mean cost."""
    planned, flown = zip(*legs, strict=True)
    factor = max(least, math.fsum(flown) / math.fsum(planned))
    if not drifts:
        return factor, 0.0
    line = _regression(planned, flown) if len(set(planned)) >= MOST_OF_A_LINE else None
    if line is not None and line.slope >= least and line.intercept >= 0.0:
        return line.slope, line.intercept
    excess = (math.fsum(flown) - math.fsum(planned)) / len(legs)
    return (1.0, excess) if excess > 0.0 else (factor, 0.0)


def _regression(planned: Iterable[float], flown: Iterable[float]) -> LinearRegression:
    return linear_regression(tuple(planned), tuple(flown))
