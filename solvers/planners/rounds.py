"""Rounds of a planner: a search and a concurrent proof, each round with more effort."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing, nullcontext
from typing import Any, Protocol

from adr_opt.common.stop import Stop

from ..progress.gap import GapTracker
from ..proof.concurrent_proof import ConcurrentProof

Task = Callable[[], None]


class Search(Protocol):
    """The searching half of a planner."""

    def beside(self, prover: Any, rounds: int) -> Task | None:
        """Work of the second thread in the coming round; None if there is none."""

    def advance(self, prover: Any, rounds: int) -> None:
        """Work of this thread in a round."""

    def meet(self, prover: Any) -> None:
        """Called once both threads have finished the round."""


def run(
    tracker: GapTracker,
    search: Search,
    prover: ConcurrentProof[Any] | None,
    *,
    stop: Stop,
    within: Stop | None = None,
    cores: int,
    until_done: bool = False,
) -> int:
    """Run rounds until the plan is proven optimal or the stopping criterion is met.

    Parameters
    ----------
    tracker : GapTracker
    search : Search
    prover : ConcurrentProof or None
        Closed in the end.
    stop : Stop
        Asked once a round.
    within : Stop, optional
        A further limit, of time alone.
    cores : int
        With one, the threads take turns.
    until_done : bool
        End when the proof can do no more.

    Returns
    -------
    int
        How many rounds that took.
    """

    def is_over() -> bool:
        return (
            (until_done and (prover is None or prover.done))
            or tracker.proven
            or stop(tracker.incumbent, tracker.bound)
            or (within is not None and within.remaining_s() <= 0.0)
        )

    rounds = 0
    with nullcontext() if prover is None else closing(prover), ThreadPoolExecutor(1) as threads:
        while not is_over():
            rounds += 1
            if prover is not None and not prover.done:
                prover.fetch()
            task = search.beside(prover, rounds)
            advancing: Future[None] | None = None
            if task is not None and cores > 1:
                advancing = threads.submit(task)
            elif task is not None:
                task()
            search.advance(prover, rounds)
            if advancing is not None:
                advancing.result()
            search.meet(prover)
            if prover is not None:
                prover.deliver()
    return rounds
