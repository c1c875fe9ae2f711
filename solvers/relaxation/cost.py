"""Least ΔV at the best prize: the relaxation with walks that pay for what they use.

Of the plans worth at least P, which costs least? With a price λ on worth and multipliers ρ_j ≥ 0 on
"target j at most once", all in m/s, every such plan costs at least

    λ P − Σ ρ_j − max over walks [ Σ over services (λ worth_j − ρ_j) − ΔV ] ,

since it is a walk, is worth P or more, and leaves the ρ of what it does not visit. The walks are
those of :mod:`.walks`, times exact; a leg pays the least ΔV that any leg between the same bodies in
as many slots costs. Labels pay exactly, and are also dropped when their worth can no longer reach
P, by the values of a sweep in which nothing is paid.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress

import numpy as np
import numpy.typing as npt

from adr_opt.mission import Mission

from .multipliers import Descent
from .routes import Routes
from .walks import LARGEST, TimeIsOver, WalkBound

FloatArray = npt.NDArray[np.float64]

RELATIVE = 1e-6
"""A cost is the least if it exceeds the bound by no more than this share of it."""

GREATEST_TANKS = 2.0
"""Most that a service is worth to a walk [tanks]."""

FIRST_EVALUATIONS, FIRST_LABELS, GROWTH = 24, 2_000_000, 4
"""Effort of the first round, and how that of the next ones grows."""

PARTS = 25
"""Steps of ΔV in a slot: what a leg pays is known to a step."""

LEAST_SHARE = 1.0 / 8.0
"""Of the gap, asked for at least before more labels are allowed."""


class PricedBound(WalkBound):
    """Walks that pay for their ΔV.

    Parameters
    ----------
    mission, delta_v_slot_m_s, jobs, over
        As of :class:`WalkBound`.

    Attributes
    ----------
    reach : (before + buckets·width,) float32
        Most worth that is still to be had from each state.
    least_worth : float
        P, to be set before anything is evaluated.
    """

    def __init__(
        self, mission: Mission, delta_v_slot_m_s: float, jobs: int, over: Callable[[], bool]
    ) -> None:
        super().__init__(mission, delta_v_slot_m_s, jobs=jobs, over=over, parts=PARTS)
        super().evaluate(np.zeros(self.prize.size))
        self.reach = ((self.values.best >> self.bits) * self.unit).astype(np.float32) + 1e-3
        self.least_worth = 0.0
        self.worths = np.array(mission.rules.prize)
        self.price = 1.0
        self.greatest_prize = GREATEST_TANKS * max(self.budget, 1.0)
        room = LARGEST / (1 << self.bits) / self.most_legs / self.greatest_prize
        self.unit = 2.0 ** -math.floor(math.log2(room))
        most = LARGEST // (1 << self.bits) // 2
        self.toll = np.minimum(np.floor(self.buckets.least / self.unit), most).astype(np.int32)

    @property
    def dimensions(self) -> int:
        """Multipliers, and the price of worth behind them."""
        return self.prize.size + 1

    @property
    def radius(self) -> float:
        """How far a step of the multipliers may go [m/s]."""
        return 0.25 * self.greatest_prize

    def allowed(self, point: FloatArray) -> FloatArray:
        """The nearest point at which the bound can be evaluated."""
        most = self.greatest_prize / max(1e-12, float(self.worths.max(initial=0.0)))
        point = np.clip(point, 0.0, self.greatest_prize)
        point[:-1][~self.is_target] = 0.0
        point[-1] = min(point[-1], most)
        return point

    def first_point(self) -> FloatArray:
        """Where the descent begins: no multipliers, and a mean leg's price."""
        point = np.zeros(self.dimensions)
        mean = float(self.worths[self.worths > 0.0].mean()) if self.worths.any() else 1.0
        point[-1] = 0.2 * self.budget / mean
        return self.allowed(point)

    def at(self, point: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """Minus the bound on the cost at a point, the point, and the slope there."""
        self.prize = point[-1] * self.worths
        value, rounded = self.evaluate(point[:-1], keep=True)
        slope = np.empty(self.dimensions)
        slope[:-1] = 1.0 - np.bincount(self.walk, minlength=self.prize.size)
        slope[:-1][~self.is_target] = 0.0
        slope[-1] = float(self.worths[self.walk].sum()) - self.least_worth
        return value - point[-1] * self.least_worth, np.append(rounded, point[-1]), slope


class CostProof:
    """Rounds of bound and search for the least ΔV of plans that are worth enough.

    Parameters
    ----------
    mission : Mission
    least_worth : float
        P: what a plan has to be worth.
    offer : callable
        Takes a sequence of bodies that may be a plan of less cost.
    cost : callable
        Least cost known [m/s].
    over : callable
        Whether the time is over.
    jobs : int
        Threads.
    delta_v_slot_m_s : float
    most_labels : int
        Most labels of a search.

    Attributes
    ----------
    bound : float
        No plan worth as much costs less [m/s].
    done : bool
        Nothing is left to do.
    """

    def __init__(
        self,
        mission: Mission,
        least_worth: float,
        offer: Callable[[npt.NDArray[np.int64]], object],
        cost: Callable[[], float],
        over: Callable[[], bool],
        *,
        jobs: int,
        delta_v_slot_m_s: float,
        most_labels: int,
    ) -> None:
        self._offer, self._cost, self._over = offer, cost, over
        self._walks = PricedBound(mission, delta_v_slot_m_s, jobs, over)
        # A little less, so that no rounding of a sum of prizes counts.
        self._walks.least_worth = least_worth * (1.0 - 1e-9)
        self._routes = Routes(self._walks)
        self._routes.least_worth = least_worth - 1e-9 * max(1.0, abs(least_worth))
        self._routes.reach = self._walks.reach
        self._descent = Descent(self._walks)
        self._evaluations = FIRST_EVALUATIONS
        self._labels, self._most_labels = min(FIRST_LABELS, most_labels), most_labels
        self._share = 1.0
        self.bound = 0.0
        self.done = self.proven

    @property
    def proven(self) -> bool:
        """Whether the cost known is the least."""
        return self._cost() <= self.bound * (1.0 + RELATIVE) + RELATIVE

    def advance(self) -> None:
        """One round: steps of the multipliers, then a search."""
        with suppress(TimeIsOver):
            for _ in range(self._evaluations):
                if self._descent.done or self.proven or self._over():
                    break
                self._descent.step()
                self.bound = max(self.bound, -self._descent.value)
            if not self.proven and not self._over():
                self._search()
        self._evaluations *= 2
        self.done = self.proven or (
            self._descent.done and self._labels == self._most_labels and self._share <= LEAST_SHARE
        )

    def _search(self) -> None:
        """Ask for plans that cost no more than a share of the gap above the bound."""
        walks, routes = self._walks, self._routes
        point = np.array(self._descent.multipliers)
        while not self.proven and not self._over():
            most = self.bound + self._share * (self._cost() - self.bound)
            if self._share == 1.0:
                most = self._cost() - 0.5 * RELATIVE * self._cost()
            walks.prize = point[-1] * walks.worths
            routes.use(point[:-1])
            before, known = self._cost(), point[-1] * walks.least_worth
            finished, value, plan, grown = routes.search(known - most, self._labels, self._over)
            if not finished:
                if self._share > LEAST_SHARE:
                    self._share *= 0.5
                    continue
                self._labels = min(GROWTH * self._labels, self._most_labels)
                self._share = 1.0
                return
            # Every plan left out costs more than what was asked for.
            self.bound = min(max(self.bound, min(most, known - value)), self._cost())
            if plan is not None:
                self._offer(plan)
            if value == -math.inf:
                self._share = min(1.0, 2.0 * self._share)
            elif grown == 0 and self._cost() >= before:
                if not point[:-1].any():
                    return
                point[:-1] = np.where(point[:-1] > 1.0, 0.5 * point[:-1], 0.0)

    def close(self) -> None:
        """End the threads."""
        self._walks.close()

    @property
    def counters(self) -> dict[str, float]:
        """What was done so far."""
        return {
            "cost_evaluations": self._descent.evaluations,
            "cost_searches": self._routes.searches,
            "cost_labels": self._routes.labels_made,
        }
