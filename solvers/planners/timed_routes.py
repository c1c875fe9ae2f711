"""Planning where arrivals are all that matters: functions of time, and ends of given connections.

The route engine first, for as much work as it gains by (:mod:`..routes.route_engine`). Then, for
one chaser and a number of targets whose sets fit an integer, the proof by sets of targets
(:mod:`..timed_tours`), which begins from that plan. What time the proof leaves is the engine's;
where `auto` looks at all routes, which succeeds for few targets only, that is a part in any case.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from adr_opt.common.memory import available_bytes
from adr_opt.common.progress import Progress
from adr_opt.common.stop import Stop
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.mission.result import Result

from ..progress.gap import GapTracker
from ..progress.halting import ShareOfTime
from ..proof.proof import ProofOptions
from ..routes.engine_rounds import EngineRounds
from ..timed_tours.earliest_end import LABEL_BYTES, EarliestEnd
from ..timed_tours.orienteering import Orienteering
from ..timed_tours.tour import MOST_TARGETS, TimedTour, sequence_of, tour_of

WIDTHS = (100, 1_000, 10_000, 100_000)
"""Labels of a layer that go on in the searches before that of all labels."""

OF_LISTS = 0.3
"""Share of the remaining time for the proof over given connections, which seldom succeeds."""

OF_ROUTES = 0.5
"""Share of the remaining time in `auto` for the proof over all routes."""

MEMORY_SHARE = 0.4
"""Share of free memory that labels may take."""


def plan(
    method: str,
    problem: Problem,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[Iterable[int]] | None,
    options: ProofOptions,
) -> Result:
    """The best plan so far and, of one chaser, its proof: both of the prizes and of the cost.

    A tour of all targets that ends first is a question of its own, asked first where it may be the
    answer (:mod:`..timed_tours.earliest_end`).

    Parameters
    ----------
    method : str
        Whose result it is.
    problem : Problem
        With functions of time, or one that :attr:`~.Problem.asks_for_least_end`.
    seed, stop, progress, start, options
        As planners take them.
    """
    certificate = GapTracker(problem, progress)
    if start is not None:
        certificate.offer(*start)
    searching = EngineRounds(problem, certificate, seed, stop, options.cores)
    searching.at_first()
    mission, cost_bound, counters = problem.alone, None, {"labels": 0}
    proves = mission is not None and len(mission.instance.targets) <= MOST_TARGETS
    if mission is not None and proves:
        room = int(min(MEMORY_SHARE * available_bytes() / LABEL_BYTES, 2**30))
        within: Stop = stop if mission.has_functions else ShareOfTime(stop, OF_LISTS)
        proof = _Proof(mission, certificate, within, room)
        tour = tour_of(mission)
        if tour is not None and mission.total_worth > 0.0:
            cost_bound = proof.earliest_end(tour, options.cores)
        if not proof.answered:
            cost_bound = proof.all_routes(1.0 if method == "exact" else OF_ROUTES)
        counters["labels"] = proof.labels
        if not (proof.complete or stop.remaining_s() <= 0.0):
            searching.until()
    else:
        searching.until()
    if cost_bound is not None:
        cost_bound = min(cost_bound, certificate.cost)
    return certificate.result(
        method,
        seed=seed,
        counters={**counters, **searching.counters},
        cost_bound=cost_bound,
        upper_bound=certificate.bound if proves else certificate.stated,
        otherwise=tuple(() for _ in problem.missions),
    )


class _Proof:
    """Searches by sets of targets that share an incumbent.

    Attributes
    ----------
    answered : bool
        Whether nothing is left to be asked.
    complete : bool
        Whether no better plan exists.
    labels : int
    """

    def __init__(self, mission: Mission, certificate: GapTracker, stop: Stop, room: int) -> None:
        self._mission, self._certificate, self._stop, self._room = mission, certificate, stop, room
        self.answered, self.complete, self.labels = False, False, 0

    def _over(self) -> bool:
        return self._stop.remaining_s() <= 0.0

    def earliest_end(self, tour: TimedTour, jobs: int) -> float | None:
        """Search the tour of all targets that ends first; returns what no plan ends before [s]."""
        mission, certificate = self._mission, self._certificate
        every = mission.total_worth
        known_s = certificate.cost if certificate.incumbent >= every else np.inf
        search = EarliestEnd(tour, self._over, jobs=jobs, most_labels=self._room, known_s=known_s)
        offered: object = None
        for _ in search.rounds():
            if search.order is not None and search.order is not offered:
                offered = search.order
                certificate.offer(sequence_of(mission, tour, search.order))
            if self._stop(certificate.incumbent, certificate.bound) and not search.proven:
                break
        self.labels += search.labels
        self.complete = search.proven
        if search.order is not None or certificate.incumbent >= every:
            self.answered = True
            certificate.lower(every)
            return search.bound_s
        required = all(target.required for target in mission.instance.targets)
        if search.proven and required:
            self.answered = True
            certificate.lower(-np.inf)
        elif not search.proven and (required or self._over()):
            self.answered = True
        return None

    def all_routes(self, share: float) -> float | None:
        """Search all routes; returns what no plan worth as much costs less than, if known."""
        mission, certificate = self._mission, self._certificate
        within = ShareOfTime(self._stop, share)
        search = Orienteering(mission, lambda: within.remaining_s() <= 0.0)
        for width in (*WIDTHS, None):
            found = search.search(
                self._room, width, known=(certificate.incumbent, certificate.cost)
            )
            self.labels += found.labels
            if found.sequence is not None:
                certificate.offer(found.sequence)
            if found.whole:
                self.complete = True
                certificate.lower(found.worth)
                return certificate.cost if certificate.routes is not None else None
            asked = self._stop(certificate.incumbent, certificate.bound)
            if asked or within.remaining_s() <= 0.0:
                break
        return None
