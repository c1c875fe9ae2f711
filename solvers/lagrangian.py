"""An upper bound by Lagrangian relaxation, tightened by ng-routes (MODEL section 7)."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Iterable

import numpy as np

from adr_opt.errors import InputError
from adr_opt.mission import Mission
from adr_opt.planner import Progress
from adr_opt.result import Result, certify
from adr_opt.stop import Stop
from adr_opt.stop.proven import TOLERANCE

from .completion import WalkBound
from .multipliers import Descent
from .ng_routes import NgRoutes

ROUNDING = 1e-6
"""A bound this little below a whole number counts as that number."""

MARGIN = 1e-3
"""Plans worth a whole number are asked for from this much below; more than the rounding."""

STEP = 0.01
"""Where prizes are not whole, ask for a plan worth so much less than the bound (relative)."""

FIRST_EVALUATIONS, FIRST_LABELS = 3, 200_000
"""Effort of the first round, in evaluations of the bound and in labels of a search."""

SMALL = 1e-3
"""Multipliers so small are not halved but dropped [greatest prizes]."""

GROWTH = 4
"""Each round of searches may make so many times the labels of the one before."""

ROOM_BYTES = 1.5e9
"""Memory that the values of all states may take; ΔV slots are widened to fit."""


class _State:
    """Incumbent and bound, and who is told of them."""

    def __init__(
        self, mission: Mission, start: Iterable[int] | None, stop: Stop, progress: Progress
    ) -> None:
        self._mission = mission
        self._stop = stop
        self._progress = progress
        self.sequence: tuple[int, ...] | None = None
        self.incumbent = -math.inf
        self.bound = math.inf
        self._ended = False
        if start is not None:
            self.offer(tuple(int(j) for j in start))

    def offer(self, sequence: tuple[int, ...]) -> None:
        """A sequence that may be the best plan so far."""
        timing = self._mission.time(sequence)
        if timing.made == len(sequence) and timing.objective > self.incumbent:
            self.incumbent, self.sequence = timing.objective, sequence
            self._progress(self.incumbent, self.bound)

    def lower(self, bound: float) -> None:
        """A bound that was proven; whole prizes round it down."""
        if self._mission.has_whole_prizes:
            bound = math.floor(bound + ROUNDING)
        bound = max(bound, self.incumbent)
        if bound < self.bound:
            self.bound = bound
            self._progress(self.incumbent, self.bound)

    @property
    def proven(self) -> bool:
        return self.incumbent >= self.bound - TOLERANCE * max(1.0, abs(self.bound))

    def enough(self) -> bool:
        """Asks ``stop``, once per iteration."""
        self._ended = self._ended or self._stop(self.incumbent, self.bound)
        return self._ended

    def is_over(self) -> bool:
        """Whether nothing is left to do, or it was enough."""
        return self.proven or self._ended

    @property
    def threshold(self) -> float:
        """What to ask for next: more than the incumbent, at most the bound."""
        if self._mission.has_whole_prizes:
            value = min(self.bound, math.ceil((1.0 - STEP) * self.bound - ROUNDING))
            return max(value, self.incumbent + 1.0) - MARGIN
        return max(
            (1.0 - STEP) * self.bound,
            self.incumbent + 0.5 * TOLERANCE * max(1.0, abs(self.bound)),
        )


def _search(state: _State, routes: NgRoutes, multipliers: np.ndarray, most_labels: int) -> bool:
    """Ask for plans worth less and less until one is found or the labels are too many.

    Returns
    -------
    done : bool
        There is nothing left to ask for.
    """
    routes.use(multipliers)
    while not state.proven:
        threshold = state.threshold
        finished, value, plan, grown = routes.search(threshold, most_labels, state.enough)
        if not finished:
            return False
        if plan is not None:
            state.offer(tuple(int(j) for j in plan))
        # Every plan left out of the search is worth less than the threshold.
        state.lower(max(value, threshold))
        if state.proven or state.enough():
            return state.proven
        if value >= threshold and grown == 0:
            if not multipliers.any():
                return True
            # Plans reach the threshold only by multipliers of targets that they leave out.
            small = SMALL * routes.greatest_prize
            multipliers = np.where(multipliers > small, 0.5 * multipliers, 0.0)
            routes.use(multipliers)
    return True


def lagrangian(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[int] | None = None,
    jobs: int = 0,
    delta_v_slot_m_s: float = 20.0,
    most_labels: int = 8_000_000,
) -> Result:
    """No plan is worth more than this.

    Rounds of two parts. Multipliers of "each target at most once" are moved so that the best walk
    of the time-expanded network is worth little (:mod:`solvers.completion`,
    :mod:`solvers.multipliers`). Then plans worth a little less than the bound are asked for
    (:mod:`solvers.ng_routes`): if there are none, the bound comes down. If the answer is a plan
    that meets the bound, it is optimal and is returned. Every value on the way is a valid bound
    and the least is kept; the trivial one is the sum of all prizes. Where all prizes are whole
    numbers the bound is rounded down, because the objective is whole.

    Deterministic but for the time limit. An iteration is one evaluation of the bound, one search,
    or :data:`solvers.ng_routes.EFFORT` labels of a search. Ends by itself when the bound is met,
    or when it can do no more.

    Parameters
    ----------
    mission : Mission
    seed : int
        Not used.
    stop, progress
    start : sequence of int, optional
        A plan: bodies in order. The bound may prove it optimal.
    jobs : int
        Threads, 0 for all cores. The result does not depend on it.
    delta_v_slot_m_s : float
        Slot of ΔV [m/s]: a finer one gives a tighter bound and takes longer.
    most_labels : int
        Most labels of a search.

    Raises
    ------
    InputError
        An option is out of range.
    """
    if not (math.isfinite(delta_v_slot_m_s) and delta_v_slot_m_s > 0.0):
        raise InputError(
            f"option delta_v_slot_m_s = {delta_v_slot_m_s!r} of method 'lagrangian': must be > 0"
        )
    if jobs < 0:
        raise InputError(f"option jobs = {jobs} of method 'lagrangian': must be ≥ 0")
    if most_labels < 1:
        raise InputError(f"option most_labels = {most_labels} of method 'lagrangian': must be ≥ 1")
    began = time.perf_counter()
    state = _State(mission, start, stop, progress)
    state.lower(mission.total_prize)
    counters: dict[str, float] = {"evaluations": 0, "searches": 0, "labels": 0}
    if not state.proven and not state.enough():
        slot = _affordable_slot(mission, delta_v_slot_m_s)
        bound = WalkBound(mission, slot, jobs or os.cpu_count() or 1)
        counters["delta_v_slot_m_s"] = slot
        descent, routes = Descent(bound), NgRoutes(bound)
        evaluations, labels = FIRST_EVALUATIONS, min(FIRST_LABELS, most_labels)
        while not state.is_over():
            for _ in range(evaluations):
                if descent.done:
                    break
                descent.step()
                state.lower(descent.value)
                if state.proven or state.enough():
                    break
            if state.is_over():
                break
            if _search(state, routes, descent.multipliers, labels):
                break
            if labels == most_labels and descent.done:
                break
            evaluations *= 2
            labels = min(GROWTH * labels, most_labels)
        bound.close()
        counters |= {
            "evaluations": descent.evaluations,
            "searches": routes.searches,
            "labels": routes.labels_made,
        }
    notes = ["the bound is rounded down: all prizes are whole"] if mission.has_whole_prizes else []
    return certify(
        mission,
        "lagrangian",
        state.sequence,
        seed=seed,
        runtime_s=time.perf_counter() - began,
        upper_bound=state.bound,
        counters=counters,
        notes=notes,
    )


def _affordable_slot(mission: Mission, slot: float) -> float:
    """The slot asked for, widened until the values of all states fit into memory."""
    events = mission.timetable.entries + len(mission.names)
    budget = mission.rules.budget
    while slot < budget and 8.0 * events * (budget / slot + 16.0) > ROOM_BYTES:
        slot *= 2.0
    return slot
