"""The least cost at the best prize: the next task of engines once prizes are proven.

Where the cost is the end of the last service, a plan costs less than D exactly if it is a plan of
the same mission with the duration D. So no plan worth as much ends before D if what a mission of
that duration can collect is proven to be less: the question is one about prizes, which all that is
known of them answers, for one chaser and for several, under every rule. The first such question
is asked just below the plan's end. Where the time does not suffice for the answer, durations are
halved for one that is easy to rule out.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from adr_opt.common.errors import InputError
from adr_opt.common.stop import Stop
from adr_opt.mission.problem import Problem
from adr_opt.mission.result import Result

from ..progress.cost_rounds import RELATIVE, least_worth_of
from ..progress.gap import GapTracker
from ..progress.halting import ShareOfTime

Over = Callable[[], bool]
Bounded = tuple[float, dict[str, float]]

JUST_BELOW = 0.9 * RELATIVE
"""Relative distance below the known end at which the first duration is tested, within tolerance."""

SHARE = 0.5
"""Share of the remaining time for each test."""

CLOSE = 0.01
"""Relative gap between excluded and possible ends at which bisection stops."""

LEAST_S = 0.05
"""Least remaining time for another test [s]."""


class _Answered(ShareOfTime):
    """Stops once it is known whether a shorter mission reaches the same worth."""

    def __init__(self, goal: float, stop: Stop) -> None:
        super().__init__(stop, SHARE)
        self._goal = goal

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        return incumbent >= self._goal or bound < self._goal or super().__call__(incumbent, bound)


def _prove_end(
    problem: Problem, certificate: GapTracker, stop: Stop, solve: Callable[[Problem, Stop], Result]
) -> Bounded:
    """Prove the earliest end of plans with at least the incumbent's worth.

    Parameters
    ----------
    problem : Problem
        Whose cost is the end of the last service.
    certificate : GapTracker
        With a plan that is proven to be worth most; told of those that end sooner.
    stop : Stop
        Its time alone counts here.
    solve : callable
        Plans and bounds a problem as far as a stop lets it.

    Returns
    -------
    bound : float
        No plan worth as much ends sooner [s].
    counters : dict
        ``ends_asked``: how many shorter missions were looked at.
    """
    goal = least_worth_of(problem, certificate.incumbent)
    ruled_out, open_from, asked_about = 0.0, math.inf, 0
    while stop.remaining_s() > LEAST_S and certificate.cost > 0.0:
        end = certificate.cost * (1.0 - JUST_BELOW)
        if math.isfinite(open_from):
            open_from = min(open_from, end)
            if open_from - ruled_out <= CLOSE * end:
                break
            end = 0.5 * (ruled_out + open_from)
        try:
            sooner = problem.with_limits(duration_s=end)
        except InputError:
            break  # some chaser is available only later
        asked_about += 1
        found = solve(sooner, _Answered(goal, stop))
        if problem.worth(found.upper_bound) < goal:
            ruled_out = end
            if math.isinf(open_from):
                break
        elif (
            found.plan is None
            or problem.worth(found.objective) < goal
            or not certificate.offer(*found.routes)
        ):
            open_from = end
    return ruled_out, {"ends_asked": asked_about}


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
    return _prove_end(problem, certificate, stop, again)
