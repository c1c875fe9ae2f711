"""Planning for one chaser where arrivals are functions of time, by sets of targets."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from adr_opt.common.errors import InputError
from adr_opt.common.memory import available_bytes
from adr_opt.common.progress import Progress
from adr_opt.common.stop import Stop
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.mission.result import Result

from ..progress.gap import GapTracker
from ..proof.proof import ProofOptions
from ..timed_tours.earliest_end import LABEL_BYTES, EarliestEnd
from ..timed_tours.orienteering import MOST_TARGETS, Orienteering
from ..timed_tours.tour import TimedTour, sequence_of, tour_of

WIDTHS = (100, 1_000, 10_000, 100_000)
"""Labels of a layer that go on in the searches before that of all labels."""

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
    """The best plan and its proof, or the best plan so far: both of the prizes and of the cost.

    A tour of all targets that ends first is a question of its own, asked first where it may be the
    answer (:mod:`..timed_tours.earliest_end`).

    Raises
    ------
    InputError
        There are too many targets.
    """
    mission = problem.alone
    assert mission is not None
    targets = len(mission.instance.targets)
    if targets > MOST_TARGETS:
        raise InputError(
            f"arrivals of {mission.instance.name!r} are functions of time, which are planned for "
            f"up to {MOST_TARGETS} targets, and it has {targets}; leave some out"
        )
    certificate = GapTracker(mission, progress)
    if start is not None:
        certificate.offer(*start)
    room = int(min(MEMORY_SHARE * available_bytes() / LABEL_BYTES, 2**30))
    searches = _Searches(mission, certificate, stop, room)
    tour = tour_of(mission)
    cost_bound = None
    if tour is not None and mission.total_worth > 0.0:
        cost_bound = searches.earliest_end(tour, options.cores)
    if not searches.answered:
        cost_bound = searches.all_routes()
    return certificate.result(
        method,
        seed=seed,
        counters={"labels": searches.labels},
        cost_bound=cost_bound,
        upper_bound=certificate.bound,
        otherwise=((),),
    )


class _Searches:
    """Searches that share an incumbent.

    Attributes
    ----------
    answered : bool
        Whether nothing is left to be asked.
    labels : int
    """

    def __init__(self, mission: Mission, certificate: GapTracker, stop: Stop, room: int) -> None:
        self._mission, self._certificate, self._stop, self._room = mission, certificate, stop, room
        self.answered, self.labels = False, 0

    def _over(self) -> bool:
        return self._stop.remaining_s() <= 0.0

    def earliest_end(self, tour: TimedTour, jobs: int) -> float | None:
        """Search the tour of all targets that ends first; returns what no plan ends before [s]."""
        mission, certificate = self._mission, self._certificate
        search = EarliestEnd(tour, self._over, jobs=jobs, most_labels=self._room)
        offered: object = None
        for _ in search.rounds():
            if search.order is not None and search.order is not offered:
                offered = search.order
                certificate.offer(sequence_of(mission, tour, search.order))
            if self._stop(certificate.incumbent, certificate.bound) and not search.proven:
                break
        self.labels += search.labels
        every = mission.total_worth
        if search.order is not None or certificate.incumbent >= every:
            self.answered = True
            certificate.lower(every)
            return min(search.bound_s, certificate.cost)
        required = all(target.required for target in mission.instance.targets)
        if search.proven and required:
            self.answered = True
            certificate.lower(-np.inf)
        elif not search.proven and (required or self._over()):
            self.answered = True
        return None

    def all_routes(self) -> float | None:
        """Search all routes; returns what no plan worth as much costs less than, if known."""
        mission, certificate = self._mission, self._certificate
        search = Orienteering(mission, self._over)
        for width in (*WIDTHS, None):
            found = search.search(self._room, width)
            self.labels += found.labels
            if found.sequence is not None:
                certificate.offer(found.sequence)
            if found.whole:
                certificate.lower(found.worth)
                return certificate.cost if found.sequence is not None else None
            if self._stop(certificate.incumbent, certificate.bound) or self._over():
                break
        return None
