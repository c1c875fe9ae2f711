"""The earliest end of a tour of all targets, and its proof.

Multipliers make relaxed tours do every target once on average, by steps that are rounded to the
nearest. Then steps are rounded down, so that the relaxation is a bound, and bands of steps are
narrowed to what can still end before the best known tour. Layers of labels are searched with that
bound: the most promising labels alone for a better tour, all of them for the proof.

After Lera-Romero, Miranda-Bront and Soulignac, INFORMS Journal on Computing 34(6), 2022, whose
bounds are functions of time where these are steps, and whose labels are extended both ways.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.kernels.core.compile import kernel

from .layers import LayerSearch, Outcome, windows_of
from .memories import NearMemories, memories_of
from .relaxation import (
    NEVER,
    UNITS,
    Relaxation,
    TimeSteps,
    bound_units,
    level,
    lower,
    narrowed,
    relaxed,
    steps_of,
    whole_bands,
)
from .tour import TimedTour, deadlines, last_end


@kernel
def _fill(steps, memories, multipliers, values):
    """Fill the values of all places and steps, from the last step back; each leg takes a step."""
    places, size = values.shape[0], values.shape[2] - 1
    for step in range(steps.total, -1, -1):
        for place in range(places):
            row = values[place, step]
            for memory in range(size):
                row[memory] = steps.ends[place, step]
            row[size] = NEVER
            for j in range(multipliers.size):
                then = max(step + 1, np.int64(steps.after[place, j, step]))
                if j == place or then > steps.total:
                    continue
                source = values[j, then]
                onward, charge = memories.onward[place, j], np.int32(multipliers[j])
                lower(row, source, onward, charge)
            level(row)


@kernel
def _visits(steps, memories, multipliers, values):
    """Number of services of each target in the best relaxed tour."""
    count = np.zeros(multipliers.size, np.int64)
    place, step, memory = np.int64(multipliers.size), np.int64(0), np.int64(0)
    while True:
        value, found = values[place, step, memory], np.int64(-1)
        for j in range(multipliers.size):
            then = max(step + 1, np.int64(steps.after[place, j, step]))
            if j == place or then > steps.total:
                continue
            after = np.int64(memories.onward[place, j, memory])
            if values[j, then, after] + multipliers[j] == value:
                found = np.int64(j)
                step, memory = then, after
                break
        if found < 0:
            return count
        count[found] += 1
        place = found


def evaluated(
    steps: TimeSteps,
    memories: NearMemories,
    multipliers: npt.NDArray[np.int64],
    room: npt.NDArray[np.int32] | None = None,
) -> tuple[int, npt.NDArray[np.int64], npt.NDArray[np.int32]]:
    """Value [units] and services of the best relaxed tour, and its storage for reuse."""
    targets = multipliers.size
    shape = targets + 1, steps.total + 1, memories.onward.shape[2] + 1
    if room is None or room.shape != shape:
        room = np.empty(shape, dtype=np.int32)
    _fill(steps, memories, multipliers, room)
    least = int(room[targets, 0, 0])
    value = NEVER if least >= NEVER else least - int(multipliers.sum())
    return value, _visits(steps, memories, multipliers, room), room


TOLERANCE = 5e-7
"""Relative improvement below which the search ends."""


Whole = npt.NDArray[np.int64]


class Stage(NamedTuple):
    """Effort of one stage.

    Attributes
    ----------
    steps, finer : int
        Number of steps for multipliers, and into how many each is divided for the bound.
    size : int
        Number of neighbours remembered.
    evaluations : int
        Of multipliers.
    width : int
        Labels kept of a layer.
    """

    steps: int
    finer: int
    size: int
    evaluations: int
    width: int


STAGES = (
    Stage(500, 1, 4, 60, 3_000),
    Stage(400, 2, 5, 80, 10_000),
    Stage(600, 2, 6, 100, 20_000),
    Stage(700, 4, 8, 40, 30_000),
)
"""The stages, with ever finer time steps and larger memories."""

NARROWING_SIZE = 3
"""Number of neighbours remembered when bands of steps are narrowed."""

FIRST_STEP, NEXT_STEP, SMALLEST_STEP, PATIENCE, SHORTER, LEAST_GAIN = 1.0, 0.3, 2e-3, 5, 1.5, 1e-4
"""Subgradient steps as shares of the gap: first, in later stages, and last; number of steps without
a least gain before a reduction, that gain, and the factor of the reduction."""

SHARES = (0.3, 0.45, 0.65, 1.0)
"""Shares of the gap searched with all labels, in order."""

LABEL_BYTES = 80
"""Memory of a label while its layer is extended [bytes]."""


class EarliestEnd:
    """Search and proof of the earliest end of a tour.

    Parameters
    ----------
    tour : TimedTour
    over : callable
        Whether the time is over.
    jobs : int
        Threads.
    most_labels : int
        Maximum number of labels in a layer.
    known_s : float
        End of a known tour, +inf for none [s].

    Attributes
    ----------
    order : (targets,) int64 or None
        The best tour found.
    end_s, bound_s : float
        Its end, and what no tour ends before; +inf where there is none [s].
    labels : int
    """

    def __init__(
        self,
        tour: TimedTour,
        over: Callable[[], bool],
        *,
        jobs: int,
        most_labels: int,
        known_s: float = math.inf,
    ) -> None:
        self._tour, self._over, self._jobs, self._most_labels = tour, over, jobs, most_labels
        self._latest_s = float(last_end(tour, tour.targets + 1))
        self.order: npt.NDArray[np.int64] | None = None
        self.end_s, self.bound_s, self.labels = known_s, tour.ready, 0
        self._multipliers: npt.NDArray[np.float64] = np.zeros(tour.targets)  # [s]

    @property
    def proven(self) -> bool:
        """Whether no tour ends earlier, or none in time."""
        return self.bound_s >= self._below()

    def _below(self) -> float:
        """End below which tours are sought [s]."""
        if math.isinf(self.end_s):
            return self._latest_s
        return self.end_s - TOLERANCE * abs(self.end_s)

    def rounds(self) -> Iterator[None]:
        """Rounds of work, as an iterator that pauses after each."""
        if self._latest_s <= self._tour.ready:
            self.bound_s = self._latest_s
            return
        for stage in STAGES:
            if self._over() or self.proven:
                return
            until = self._below()
            self._climb(stage, until)
            relaxation = self._bound(stage, until)
            yield
            if not (self.proven or self._over()):
                yield from self._beam(relaxation, until, stage)
        if not self._over():
            yield from self._whole(relaxation, until)

    def _units(self, relaxation: Relaxation, time_s: float) -> int:
        """Units of a time, rounded down."""
        return math.floor((time_s - self._tour.ready) / relaxation.steps.unit)

    def _climb(self, stage: Stage, until: float) -> None:
        """Improve the multipliers by steps along subgradients."""
        tour, unit = self._tour, (until - self._tour.ready) / UNITS
        memories = memories_of(tour, min(stage.size, tour.targets), until)
        most = math.floor((until - tour.ready) / unit)
        best = np.round(self._multipliers / unit).astype(np.int64)
        near = steps_of(tour, until, stage.steps, nearest=True)
        walks: npt.NDArray[np.int32] | None = None

        def free(multipliers: Whole) -> tuple[int, Whole]:
            nonlocal walks
            value, count, walks = evaluated(near, memories, multipliers, walks)
            return value, count

        best = self._ascended(free, best, most, stage.evaluations)
        self._multipliers = np.asarray(best * unit, dtype=np.float64)

    def _ascended(
        self, evaluate: Callable[[Whole], tuple[int, Whole]], start: Whole, most: int, number: int
    ) -> Whole:
        """Multipliers after a number of steps along subgradients, the best of them."""
        multipliers, best, best_value, fruitless = start, start, -NEVER, 0
        best_count = np.ones_like(start)
        share = NEXT_STEP if self._multipliers.any() else FIRST_STEP
        for _ in range(number):
            if self._over() or share < SMALLEST_STEP:
                break
            value, count = evaluate(multipliers)
            if value >= NEVER or (count == 1).all():
                return multipliers
            fruitless = 0 if value > best_value + LEAST_GAIN * most else fruitless + 1
            if value > best_value:
                best, best_value, best_count = multipliers, value, count
            if fruitless >= PATIENCE:
                share, fruitless, multipliers = share / SHORTER, 0, best
                count, value = best_count, best_value
            gradient = count - 1
            way = share * max(most - value, 1) / int(gradient @ gradient)
            multipliers = multipliers + np.round(way * gradient).astype(np.int64)
        return best

    def _bound(self, stage: Stage, until: float) -> Relaxation:
        """Bound by the relaxation, in ever finer steps restricted to the relevant bands."""
        tour, bands = self._tour, whole_bands(self._tour.targets, stage.steps)
        parts = ((1, NARROWING_SIZE), (stage.finer, NARROWING_SIZE), (stage.finer, stage.size))
        for number, (finer, size) in enumerate(parts):
            steps = steps_of(tour, until, stage.steps * finer)
            room = self._most_labels * LABEL_BYTES
            while size > 1 and 4 * bands.rows * ((1 << size) + 1) > room:
                size -= 1
            memories = memories_of(tour, min(size, tour.targets), until)
            multipliers = np.round(self._multipliers / steps.unit).astype(np.int64)
            made = relaxed(steps, memories, bands, multipliers, self._jobs)
            self._raise(made, until)
            if number + 1 < len(parts):
                most = self._units(made, until)
                bands = narrowed(made, most, stage.finer if number == 0 else 1)
        return made

    def _raise(self, relaxation: Relaxation, until: float) -> None:
        """Raise the bound to that of a relaxation."""
        units = bound_units(relaxation)
        least = until if units >= NEVER else self._tour.ready + units * relaxation.steps.unit
        self.bound_s = max(self.bound_s, min(least, until))

    def _search(self, relaxation: Relaxation, until: float) -> LayerSearch:
        windows = windows_of(deadlines(self._tour, until))
        return LayerSearch(self._tour, relaxation, windows, self._over)

    def _adopt(self, outcome: Outcome) -> None:
        """Adopt a better tour."""
        self.labels += outcome.labels
        if outcome.order is not None and outcome.end_s < self.end_s:
            self.order, self.end_s = outcome.order, outcome.end_s

    def _beam(self, relaxation: Relaxation, until: float, stage: Stage) -> Iterator[None]:
        """Search the most promising labels, with growing numbers until a tour is found."""
        width, search = stage.width, self._search(relaxation, until)
        while not self._over():
            most = self._units(relaxation, self._below())
            outcome = search.search(most, self._most_labels, width)
            self._adopt(outcome)
            if outcome.whole:
                self.bound_s = max(self.bound_s, min(until, self._below()))
            yield
            if outcome.whole or math.isfinite(self.end_s) or outcome.labels == 0:
                return
            if 10 * width > self._most_labels:
                return
            width *= 10

    def _whole(self, relaxation: Relaxation, until: float) -> Iterator[None]:
        """Search all labels of tours that end within growing shares of the gap."""
        search = self._search(relaxation, until)
        for share in SHARES:
            if self._over() or self.proven:
                return
            below = self._below()
            within = self.bound_s + share * (below - self.bound_s)
            if share == SHARES[-1] or below - self.bound_s < 0.01 * below:
                within = below
            outcome = search.search(self._units(relaxation, within), self._most_labels)
            self._adopt(outcome)
            if not outcome.whole:
                return
            # Of the tours that end by then the best one is known.
            self.bound_s = max(self.bound_s, min(within, self._below()))
            yield
