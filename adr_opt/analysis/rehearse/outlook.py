"""Mean prizes of planned routes, followed in drawn worlds from any moment on.

Routes are compared in the same worlds, so that what differs between them is the routes' doing and
not the worlds' (docs/model.md section 13.5).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from ...problem.uncertainty import Uncertainty
from ...problem.world import DrawnWorld
from .flight import FlownMission, Situation, flown_on, rehearsed
from .intended import Intended, PlannedHop
from .mission_facts import MissionFacts
from .planned_order import Follow
from .tries import TryWorths

FloatArray = npt.NDArray[np.float64]

WORLDS, FIRST_WORLD = 100, 2 * 10**9
"""Number of worlds in a comparison, and their first seed, far from those of users."""


class Outlook:
    """Expected prizes of followed routes, in worlds that no rehearsal uses.

    Parameters
    ----------
    facts : MissionFacts
    uncertainty : Uncertainty
    """

    def __init__(self, facts: MissionFacts, uncertainty: Uncertainty) -> None:
        self._facts, self._uncertainty = facts, uncertainty
        self._worths = TryWorths(facts.instance, uncertainty)
        # More than all prizes: what is required comes first.
        self._of_required = 1.0 + math.fsum(map(abs, facts.prizes.values()))

    def worths(
        self, now: Situation, routes: Sequence[Sequence[PlannedHop]], worlds: range
    ) -> FloatArray:
        """Prizes collected in each world by following routes from now on.

        Parameters
        ----------
        now : Situation
        routes : sequence of sequence of PlannedHop
            Of each chaser, from where it is or will be.
        worlds : range
            Seeds.

        Returns
        -------
        (worlds,) float64
            Without the luck of captures; and more than all prizes where all that is still required
            is serviced.
        """
        intended = Intended(None, tuple(map(tuple, routes)), ())
        required = self._facts.required - now.closed

        def fly(world: DrawnWorld, policy: Follow) -> FlownMission:
            return flown_on(now, world, policy, self._worths)

        return self._each(worlds, intended, required, fly)

    def of_plan(self, planned: Intended, worlds: range) -> FloatArray:
        """Prizes collected in each world by following a whole plan, shape (worlds,)."""

        def fly(world: DrawnWorld, policy: Follow) -> FlownMission:
            return rehearsed(self._facts, world, policy, planned.kits)

        return self._each(worlds, planned, self._facts.required, fly)

    def prizes(self, worths: FloatArray) -> FloatArray:
        """Prizes of followed routes, without the bonus of required targets, shape (worlds,)."""
        met = worths >= self._of_required
        return worths - met * self._of_required

    def _each(
        self,
        worlds: range,
        planned: Intended,
        required: frozenset[int],
        fly: Callable[[DrawnWorld, Follow], FlownMission],
    ) -> FloatArray:
        found = np.empty(len(worlds))
        for at, seed in enumerate(worlds):
            world = DrawnWorld(self._facts.instance, self._uncertainty, seed)
            flown = fly(world, Follow(self._facts, planned, self._uncertainty))
            is_met = bool(required) and required <= set(flown.serviced)
            found[at] = flown.expected + is_met * self._of_required
        return found


def is_better(worths: FloatArray, others: FloatArray) -> bool:
    """Whether one exceeds another in the same worlds by more than the error of the mean."""
    gain = worths - others
    error = float(gain.std(ddof=1)) / math.sqrt(gain.size)
    return float(gain.mean()) > error
