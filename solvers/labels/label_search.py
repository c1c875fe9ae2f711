"""Label searches for plans above a threshold, which learn from each other.

The room shared by the Lagrangian bound and by proofs of optimality (docs/model.md section 8). If
the labels of :mod:`.extension` run out before the threshold, no plan reaches it. If not, the best
walks show which targets were visited twice; the bodies in between learn to remember them, and the
search begins again (decremental state space: Righini and Salani 2008). A walk that repeats nothing
is a plan, legal to the last digit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from adr_opt.common.tolerance import ROUNDED
from adr_opt.kernels.rules.resources import kits_alone
from adr_opt.mission.evidence import Cut
from adr_opt.mission.problem import Problem

from ..walks.walks import WalkBound
from .extension import (
    CROWDED,
    EXHAUSTED,
    FULL,
    MOST_PAID,
    PILED,
    CompletionValues,
    LabelQuery,
    RowOrder,
    extend,
)
from .ng_augmentation import WalkThreshold, learn, most_of, path_of, plans_of
from .pending import more_room, pending_room, send
from .row_cuts import CutTolls, remember_cuts, tolls_of, words_for
from .waiting import FINE, Labels, labels_room, larger, room

EFFORT = 200_000
"""Number of extensions between queries of the stopping criterion."""

FIRST_WAITING = 256
"""Initial number of labels that can wait at each body."""

FIRST_BLOCKS = 4096
"""Initial number of blocks of pending labels."""

NOTHING = -(2.0**62)
"""Value of a walk that cannot begin [fine units]."""

LEAST_GAIN, LEAST_NEED = -(2.0**57), -(2**61)
"""Least gain of a service, and least threshold of a search [fine units]."""

ANY_WORTH = -1e300
"""Value below any worth."""

WALKS = 1000
"""Number of walks to learn from after a search."""


def table_of(bound: WalkBound) -> CompletionValues:
    """Completion values of a bound's last evaluation."""
    best, second = bound.values.best, bound.values.second
    return CompletionValues(
        bound.buckets.of_row,
        best.reshape(1, -1),
        second.reshape(1, -1),
        best.shape[1],
        bound.bits,
        bound.width,
        bound.top,
        bound.slot,
    )


class LabelSearch:
    """Label searches with the completion values of a bound, in growing memory.

    Parameters
    ----------
    bound : WalkBound
        Its network and values are used, and its values overwritten.
    start : int
        Number of the mission of the bound whose walks are looked for.
    all_sets : bool
        Tell labels of different sets of targets apart, so that of every set one is found that can
        be visited for what is asked: walks remember all, and none dominates another one but of the
        same targets.

    Attributes
    ----------
    neighbourhood : (bodies, words) int64
        What walks remember at each body; kept from search to search.
    compared : (bodies, words) int64
        What of it tells labels apart there; all of it but in searches that prove nothing.
    greatest_prize : float
    multipliers : (bodies,) float64
        Those in use.
    total : float
        Their sum.
    labels_made, searches : int
    """

    def __init__(self, bound: WalkBound, *, start: int = 0, all_sets: bool = False) -> None:
        self._bound, self._start = bound, start
        self.greatest_prize = bound.greatest_prize
        network = bound.network
        bodies = bound.prize.size
        words = words_for(bodies)
        self.neighbourhood = np.full((bodies, words), -1 if all_sets else 0, dtype=np.int64)
        self.compared = np.full_like(self.neighbourhood, -1)
        self._values = self._reach = table_of(bound)
        # More is set only where ΔV is paid for, see :mod:`solvers.proof.cost`.
        self._reach_unit, self.least_worth = 1.0, ANY_WORTH
        # Of two sets, one of which holds the other, the one has as many and the other no more.
        self._worths = np.where(bound.is_target, float(all_sets), 0.0)
        self._prices = np.zeros(1)
        self.labels_made = 0
        self.searches = 0
        self._last = 0, 0
        self._roots = 1 if bound.loads is None else bound.loads.full.size
        self._rows = RowOrder(
            np.repeat(np.arange(bodies, dtype=np.int32), np.diff(network.start)),
            np.argsort(network.departure, kind="stable"),
        )
        self._timed = network.end.size > 0
        self._labels = labels_room(1 << 16, self.neighbourhood.shape[1], timed=self._timed)
        self._gain = np.zeros(bodies, dtype=np.int64)
        self.total = 0.0
        self.multipliers = np.zeros(bodies)
        self._unit = bound.unit * 2.0**-FINE
        self._cuts: CutTolls | None = None

    def cut(self, cuts: Sequence[Cut], *, forgetful: bool = True) -> None:
        """Make walks pay at second rows of cuts from now on.

        Parameters
        ----------
        cuts : sequence of Cut
            In place of those before.
        forgetful : bool
            Whether walks remember rows within the memory of a cut only.
        """
        bodies = self._gain.size
        words = words_for(bodies, len(cuts))
        if words != self.neighbourhood.shape[1]:
            self.neighbourhood, self.compared = (
                _in_words(masks, bodies, words) for masks in (self.neighbourhood, self.compared)
            )
            self._labels = labels_room(self._labels.row.size, words, timed=self._timed)
        everywhere = frozenset(range(bodies))
        kept = [each if forgetful else each._replace(memory=everywhere) for each in cuts]
        remember_cuts(self.neighbourhood, kept, bodies)
        self._cuts = tolls_of(cuts, bodies, words, self._unit)
        if self._cuts is not None:
            self.compared &= ~self._cuts.bits

    def use(self, multipliers: np.ndarray) -> float:
        """Compute completion values for some multipliers, with the resulting bound."""
        bound = self._bound
        # What is left of rounding to units would count for every target that is left out.
        kept = np.where((multipliers < bound.unit) | ~bound.is_paid, 0.0, multipliers)
        if not bound.holds(kept):
            bound.evaluate(kept, keep=True)
        value, _ = bound.best_from(self._start)
        # A service that takes more off a walk than any walk has may as well take no more.
        gain = np.maximum(np.ceil((bound.prize - kept) / self._unit), LEAST_GAIN)
        self._gain = gain.astype(np.int64)
        self.multipliers, self.total = kept, math.fsum(kept)
        return value + self.total

    def pay(
        self, values: CompletionValues, prices: np.ndarray, reach: WalkBound, least_worth: float
    ) -> None:
        """Make walks pay for ΔV from now on, without multipliers.

        Parameters
        ----------
        values : CompletionValues
            Of the same walks at several prices of worth.
        prices : (kinds,) float64
            These [m/s].
        reach : WalkBound
            In its values nothing is paid.
        least_worth : float
            What a walk has to be worth.
        """
        bound = self._bound
        self._values, self._prices = values, prices
        self._reach, self._reach_unit, self.least_worth = table_of(reach), reach.unit, least_worth
        self._worths = bound.worths
        gain = prices[0] * bound.worths - bound.flown
        self._gain = np.ceil(gain / self._unit).astype(np.int64)
        self.multipliers, self.total = np.zeros(self._gain.size), 0.0

    def _begin(self) -> None:
        """Initial labels: one for each number of kits that may be taken along."""
        bound, labels, roots = self._bound, self._labels, slice(self._roots)
        labels.row[roots], labels.parent[roots] = bound.network.roots[self._start], -1
        labels.memory[roots], labels.left[roots] = 0, bound.tank
        paid = np.floor(bound.constant / self._unit)
        labels.value[roots] = np.where(bound.tank < 0.0, NOTHING, -paid)
        labels.final[roots] = labels.value[roots]  # nothing is flown, and no time paid for
        labels.counts[roots] = kits_alone(np.arange(self._roots))
        labels.came_from[roots], labels.worth[roots] = -1, 0.0

    def _extension(self, need: int) -> Callable[[Labels, np.ndarray], int]:
        """The extension function of one search: takes labels and the cursor."""
        bound = self._bound
        shift = (self._prices - self._prices[0]) / self._unit
        # A walk that is asked for is worth the least at any price; shifts are rounded.
        needs = need + np.floor(shift * self.least_worth).astype(np.int64) - 2
        needs[0] = need
        needs -= math.ceil(min(bound.ahead(self._start) / self._unit, MOST_PAID))
        price = np.broadcast_to(bound.price / self._unit, self._roots).copy()
        search = LabelQuery(
            self._values,
            shift,
            needs,
            self._gain,
            self.neighbourhood,
            self.compared,
            bound.budget,
            bound.loads,
            bound.limits,
            price,
            bool(price.any()),
            bound.time_price / self._unit,
            float(bound.since[self._start]),
            need,
            self._worths,
            self.least_worth,
            self._reach,
            self._reach_unit,
            self._cuts,
            bound.falls,
            self._unit,
        )
        words = self.neighbourhood.shape[1]
        waiting = room(bound.prize.size, words, FIRST_WAITING)
        pending = pending_room(self._rows.body.size, words, FIRST_BLOCKS)
        for label in range(self._roots):
            send(pending, bound.network.roots[self._start], self._labels, label)

        def extend_labels(labels: Labels, cursor: np.ndarray) -> int:
            nonlocal waiting, pending
            while True:
                state = extend(
                    bound.network, self._rows, search, labels, pending, waiting, cursor, EFFORT
                )
                if state == CROWDED:
                    waiting = larger(waiting, words)
                elif state == PILED:
                    pending = more_room(pending, words)
                else:
                    return int(state)

        return extend_labels

    def plans(self, most: int) -> list[tuple[int, ...]]:
        """Plans among the walks of the last finished search, best first.

        Parameters
        ----------
        most : int
            Maximum number of plans, no two of the same targets.
        """
        return [plan for plan, _ in self.valued_plans(most)]

    def valued_plans(self, most: int) -> list[tuple[tuple[int, ...], float]]:
        """The same plans, each with an upper bound on the reduced worth of its set of targets."""
        count, need = self._last
        network, labels = self._bound.network, self._labels
        path = np.empty(self._bound.most_legs + 1, dtype=np.int64)
        at = np.empty(count, dtype=np.int32)
        least = WalkThreshold(need, self.least_worth)
        number = plans_of(network, labels, self._rows.body, count, least, self._gain.size, path, at)
        at = at[:number]
        seen, found = set[frozenset[int]](), list[tuple[tuple[int, ...], float]]()
        for label in at[np.argsort(-labels.final[at], kind="stable")]:
            route = path[: path_of(labels, self._rows.body, label, path)].tolist()
            targets = frozenset(route)
            if targets not in seen:
                seen.add(targets)
                found.append((tuple(route), float(labels.final[label]) * self._unit))
                if len(found) == most:
                    break
        return found

    def search(
        self, threshold: float, most_labels: int, enough: Callable[[], bool]
    ) -> tuple[bool, float, np.ndarray | None, int]:
        """One search for walks worth at least ``threshold``, with its lessons.

        Parameters
        ----------
        threshold : float
        most_labels : int
            Maximum number of labels; beyond it, give up.
        enough : callable
            Asked now and then whether to give up.

        Returns
        -------
        finished : bool
            False if it gave up: then nothing was proven.
        value : float
            If finished, no plan is worth more than the greater one of this and the threshold:
            the value of the best walk plus Σ π, −inf if there is none.
        plan : (moves,) int64 or None
            The best of the walks that visit no target twice: a plan.
        grown : int
            Memories added.
        """
        bound = self._bound
        # A little lower, so that no rounding of sums and of what services are worth counts.
        rounding = ROUNDED * (abs(threshold) + 2.0 * self.total)
        need = math.ceil((threshold - self.total - rounding) / self._unit - 1e-3)
        if need < LEAST_NEED:  # multipliers far beyond all prizes prove nothing
            return False, math.inf, None, 0
        self._begin()
        extend_labels = self._extension(need)
        cursor = np.array([0, self._roots, 0], dtype=np.int64)
        self.searches += 1
        while True:
            labels = self._labels
            state = extend_labels(labels, cursor)
            if state == EXHAUSTED:
                break
            if enough() or cursor[1] >= most_labels:
                self.labels_made += int(cursor[1])
                return False, math.inf, None, 0
            if state == FULL:
                self._labels = labels_room(
                    2 * labels.row.size, labels.memory.shape[1], timed=self._timed
                )
                for new, old in zip(self._labels, labels, strict=True):
                    new[: cursor[1]] = old[: cursor[1]]
        count = int(cursor[1])
        self.labels_made += count
        self._last = count, need
        body, least = self._rows.body, WalkThreshold(need, self.least_worth)
        best = int(most_of(bound.network, labels, body, count, least._replace(value=need - 1)))
        if best < need:
            return True, -math.inf, None, 0
        path = np.empty(bound.most_legs + 1, dtype=np.int64)
        length, grown = learn(
            bound.network, labels, body, count, least, WALKS, self.neighbourhood, path
        )
        sequence = path[:length].copy() if length >= 0 else None
        return True, best * self._unit + self.total, sequence, int(grown)


def _in_words(masks: np.ndarray, bodies: int, words: int) -> np.ndarray:
    """Masks of bodies in another number of words, with no other bits."""
    found = np.zeros((masks.shape[0], words), dtype=np.int64)
    kept = words_for(bodies)
    found[:, :kept] = masks[:, :kept]
    return found


SLOT_M_S, MOST_LABELS = 20.0, 10_000
"""Of the walks that are practised."""


def practise(problem: Problem) -> None:
    """Search walks that pay for a subset-row cut, or for none: short runs may not reach that code.

    Problems without a timetable, or with functions of time, have no such walks.
    """
    mission = problem.missions[0]
    if not mission.has_timetable or mission.has_functions:
        return
    first = problem.instance.first_target
    rows = tuple(range(first, first + 3))
    for cuts in ([], [Cut(rows, frozenset(rows), 0.5)]):
        search = LabelSearch(WalkBound(mission, SLOT_M_S))
        search.cut(cuts)
        search.use(np.zeros(len(mission.names)))
        search.search(search.total, MOST_LABELS, lambda: False)
        search.plans(2)
