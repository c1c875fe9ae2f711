"""Pricing of columns: by beams, and by label setting that finds all or proves that none exists."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from adr_opt.common.stop import Stop
from adr_opt.mission.mission import Mission

from ..beams.beams import beam_search
from ..beams.varied_beams import varied
from ..labels.label_search import LabelSearch
from ..walks.walks import WalkBound
from .subset_rows import SubsetRows

MOST_PLANS = 200
"""Maximum number of routes taken from one label search."""

SHARES = (0.4, 0.0)
"""First threshold of quick searches, between the least useful worth and the best walk's: fewer
routes take fewer labels."""

WIDTH = 200
"""Width of beams."""


def by_beam(
    mission: Mission, multipliers: np.ndarray, rng: np.random.Generator, stop: Stop
) -> tuple[int, ...]:
    """A route over targets whose worth exceeds their multipliers."""
    worths = mission.planning_prizes - multipliers
    worths[: mission.instance.first_target] = 0.0
    worths[mission.instance.first_target :][
        worths[mission.instance.first_target :] <= 0.0
    ] = -np.inf
    layer, settings, seed = varied(mission.offering(worths), WIDTH, rng)
    return tuple(int(j) for j in beam_search(layer, settings, seed=seed, stop=stop)[0])


class LabelPricing:
    """Label searches for routes of one type with positive reduced worth.

    Parameters
    ----------
    bound : WalkBound
        Of the kind; its values are overwritten.
    start : int
        Number of the kind there.

    Attributes
    ----------
    most_worth : float
        After :meth:`search`: no route is worth more, less the multipliers.
    remembered : (bodies, words) int64
        Of what walks need to remember for that.
    """

    def __init__(self, bound: WalkBound, start: int) -> None:
        self._routes = LabelSearch(bound, start=start)
        # Remembers all, and lets a label dominate another one whatever that remembers.
        self._quick = LabelSearch(bound, start=start)
        self._quick.neighbourhood[:], self._quick.compared[:] = -1, 0
        self.most_worth = math.inf
        self.remembered = np.zeros_like(self._routes.neighbourhood)
        self._cuts, self._cut_prices = SubsetRows(), np.empty(0)

    def cut(self, cuts: SubsetRows, prices: np.ndarray) -> None:
        """Make routes pay for cuts from now on.

        Parameters
        ----------
        cuts : SubsetRows
            Their memories grow as routes are found that pay too little.
        prices : (cuts,) float64
        """
        self._cuts, self._cut_prices = cuts, prices
        priced = cuts.priced(prices)
        self._routes.cut(priced)
        self._quick.cut(priced)

    @property
    def labels_made(self) -> int:
        """Total number of labels."""
        return self._routes.labels_made + self._quick.labels_made

    @property
    def searches(self) -> int:
        """Number of searches."""
        return self._routes.searches + self._quick.searches

    def quickly(
        self,
        multipliers: np.ndarray,
        least: float,
        most_labels: int,
        enough: Callable[[], bool],
        is_new: Callable[[tuple[int, ...]], bool],
    ) -> list[tuple[int, ...]]:
        """Some of the routes of :meth:`search`, by few labels that prove nothing.

        Of walks to a body only the best are gone on with, not one for each memory: what is found
        are routes, and where none is found there may be some all the same.
        """
        routes = self._quick
        most = routes.use(multipliers) - routes.total
        for share in SHARES:
            threshold = routes.total + least + share * max(most - least, 0.0)
            finished, _, _, _ = routes.search(threshold, most_labels, enough)
            if not finished:
                return []
            if found := [route for route in routes.plans(MOST_PLANS) if is_new(route)]:
                return found
        return []

    def search(
        self,
        multipliers: np.ndarray,
        least: float,
        most_labels: int,
        enough: Callable[[], bool],
        is_new: Callable[[tuple[int, ...]], bool],
    ) -> tuple[bool, list[tuple[int, ...]]]:
        """Routes whose worth minus multipliers exceeds ``least``.

        Parameters
        ----------
        multipliers : (bodies,) float64
        least : float
        most_labels : int
            Maximum number of labels; beyond it, give up.
        enough : callable
            Whether to give up.
        is_new : callable
            Whether a route is of use.

        Returns
        -------
        finished : bool
            False if it gave up.
        routes : list of tuple of int
            Of use, best first. None if it finished means that walks that repeat targets are all
            that is left, or nothing.
        """
        routes = self._routes
        value = routes.use(multipliers) - routes.total
        self.most_worth, self.remembered = value, np.zeros_like(routes.neighbourhood)
        if value < least:
            return True, []
        while True:
            threshold, remembered = routes.total + least, routes.neighbourhood.copy()
            finished, value, _, grown = routes.search(threshold, most_labels, enough)
            if not finished:
                return False, []
            most_worth = max(value - routes.total, least)
            if most_worth < self.most_worth:
                self.most_worth, self.remembered = most_worth, remembered
            plans = routes.plans(MOST_PLANS)
            found = [route for route in plans if is_new(route)]
            if value >= threshold and not found and self._cut_prices.any():
                grown += sum(self._cuts.remember(route, self._cut_prices) for route in plans)
                routes.cut(self._cuts.priced(self._cut_prices))
            if value < threshold or found or grown == 0:
                return True, found
