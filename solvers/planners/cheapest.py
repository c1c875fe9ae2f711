"""The least cost at the best prize: the next task of engines once prizes are proven."""

from __future__ import annotations

from collections.abc import Callable

from adr_opt.common.stop import Stop
from adr_opt.mission.problem import Problem
from adr_opt.mission.result import Result

from ..progress.gap import GapTracker
from ..proof.least_end import prove_end

Over = Callable[[], bool]
Bounded = tuple[float, dict[str, float]]


def cheapest(
    problem: Problem,
    certificate: GapTracker,
    stop: Stop,
    prove: Callable[[Over], Bounded],
    again: Callable[[Problem, Stop], Result],
    *,
    by_rounds: bool,
) -> tuple[float | None, dict[str, float]]:
    """Lower the cost of a plan whose prizes are proven, and prove a bound on it.

    Parameters
    ----------
    problem : Problem
    certificate : GapTracker
        With the plan, if there is one; told of cheaper ones.
    stop : Stop
    prove : callable
        Proves the least ΔV or expense until it is told that it is over: the bound, and counters.
    again : callable
        Plans a shorter mission exactly, where the cost is the end.
    by_rounds : bool
        Ask the criterion itself once a round; otherwise its time alone counts.

    Returns
    -------
    bound : float or None
        No plan that collects as much costs less; None where nothing was asked.
    counters : dict
    """

    def over() -> bool:
        enough = by_rounds and stop(certificate.incumbent, certificate.bound)
        return enough or stop.remaining_s() <= 0.0

    if not certificate.proven or certificate.routes is None or (by_rounds and over()):
        return None, {}
    if problem.instance.objective.cost != "duration":
        # Of several chasers the last step would take a route's worth for its greatest.
        knows = problem.falls is None or problem.alone is not None
        return prove(over) if knows else (None, {})
    if by_rounds and stop.remaining_s() == float("inf"):
        return None, {}  # it asks for whole plans, not for rounds
    return prove_end(
        problem, certificate, stop, again, lambda found: certificate.offer(*found.routes)
    )
