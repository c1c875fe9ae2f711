"""Plan and refine in turns, over connections corrected by refined legs, until the plan holds."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

from ...common.card import Shown
from ...common.errors import InputError
from ...common.progress import Progress, silent
from ...common.stop import Stop
from ...judge.admit import MODEL_TANK, admit_made
from ...judge.check.violation import DELTA_V_TOLERANCE_M_S
from ...legs.corrections import Corrections
from ...mission.problem import AnyProblem, Problem, problem_of
from ...mission.result import Result
from ...plan.plan import Plan
from ...plan.refined_plan import Freedom, Gravity, RefinedLeg, RefinedPlan
from ...plan.routes import routes_of
from ...problem.support import refuse
from ...run.front import DEFAULT_METHOD, DEFAULT_TIME_LIMIT_S, RunOptions, run, spec_of
from ...run.methods import BOUNDS, PLANNERS
from ..flight.flyable import REFINED
from ..flight.tanks import tanks_of
from .all_legs import Wanted, refined_again
from .lessons import Lessons, Unsafe
from .reported import opened
from .troubles import beginning, troubles

MOST_ROUNDS = 10
"""Default maximum number of rounds."""


@dataclass(frozen=True)
class Round:
    """One plan of the loop, with the outcome of its refinement.

    Attributes
    ----------
    number : int
        From 1.
    corrections : Corrections
        Of the connections that were planned with.
    objective : float
        Of the plan.
    planned_delta_v_m_s, flown_delta_v_m_s : float
        Of the legs that were refined, holding beside ephemerides included [m/s].
    troubles : tuple of str
        Why the refined plan does not hold; nothing if it does.
    refined : RefinedPlan
        That plan.
    """

    number: int
    corrections: Corrections
    objective: float
    planned_delta_v_m_s: float
    flown_delta_v_m_s: float
    troubles: tuple[str, ...]
    refined: RefinedPlan

    @property
    def corrected_delta_v_m_s(self) -> float:
        """Expected cost of the same legs by the corrected connections [m/s]."""
        return math.fsum(
            self.corrections.corrected(
                leg.origin, leg.destination, leg.kind, leg.planned_delta_v_m_s
            )
            + leg.planned_removal_m_s
            for leg in self.refined.legs
        )

    def to_dict(self) -> dict[str, Any]:
        """The round as plain data, with corrections in words."""
        return {
            "number": self.number,
            "corrections": str(self.corrections),
            "objective": self.objective,
            "planned_delta_v_m_s": self.planned_delta_v_m_s,
            "corrected_delta_v_m_s": self.corrected_delta_v_m_s,
            "flown_delta_v_m_s": self.flown_delta_v_m_s,
            "troubles": list(self.troubles),
        }

    def __str__(self) -> str:
        outcome = "it holds" if not self.troubles else "; ".join(self.troubles)
        expected = f", corrected {self.corrected_delta_v_m_s:.1f} m/s" if self.corrections else ""
        return (
            f"round {self.number}: prize {self.objective:g}, planned with "
            f"{self.planned_delta_v_m_s:.1f} m/s{expected}, flown with "
            f"{self.flown_delta_v_m_s:.1f} m/s: {outcome}"
        )


@dataclass(frozen=True, repr=False)
class RefinedResult(Shown):
    """The best plan found that holds when refined, or the reason why there is none.

    Attributes
    ----------
    result : Result
        Result of the last round, with the plan that is kept; its bound holds for the connections of
        that round, as a note says.
    refined : RefinedPlan or None
        The plan, refined.
    rounds : tuple of Round
    reason : str
        Why the plan does not hold, or why there is none; empty if it holds.
    """

    result: Result
    refined: RefinedPlan | None
    rounds: tuple[Round, ...]
    reason: str

    @property
    def holds(self) -> bool:
        """Whether a plan holds."""
        return not self.reason

    @property
    def plan(self) -> Plan | None:
        """The plan, in terms of the instance: its ΔV is that of the model."""
        return self.result.plan


class _Best:
    """The best plan so far that holds: by prize, then by flown ΔV."""

    def __init__(self) -> None:
        self.kept: tuple[Plan, RefinedPlan] | None = None

    def hear(self, found: tuple[Plan, RefinedPlan] | None) -> None:
        if found is not None and (self.kept is None or _rank(*found) > _rank(*self.kept)):
            self.kept = found


def _rank(plan: Plan, refined: RefinedPlan) -> tuple[float, float]:
    return plan.objective, -refined.flown_delta_v_m_s


def solve_refined(  # noqa: PLR0913
    instance: AnyProblem,
    method: str = DEFAULT_METHOD,
    *,
    gravity: Gravity | None = None,
    freedom: Freedom | None = None,
    ephemerides: bool = False,
    rounds: int = MOST_ROUNDS,
    spend_savings: bool = False,
    time_limit: float = DEFAULT_TIME_LIMIT_S,
    stop: Stop | None = None,
    progress: Progress = silent,
    jobs: int | None = None,
    bound: str | None = None,
    margin: float = 0.0,
    told: Callable[[Round], None] = lambda one: None,
    unsafe: Callable[[RefinedPlan], Sequence[Unsafe]] = lambda refined: (),
    options: dict[str, Any] | None = None,
    **arguments: Any,
) -> RefinedResult:
    """Plan a mission such that the plan holds when refined.

    The plan is refined. If a tank does not suffice for its refined legs, or a leg cannot be
    refined, the mean excess of refined legs corrects all connections, the remainder those of their
    pairs (:class:`.lessons.Lessons`), and the mission is planned again. Connections never cost less
    than the model states, so each plan is one of the instance; and each plan is new, since one that
    broke a tank breaks it over the corrected connections as well. Rounds end with the first plan
    that holds. If it is ``unsafe``, connections that lead to the conflict are barred, and the
    mission is planned again. The beginning of an earlier plan that holds is kept if it collects
    more.

    Parameters
    ----------
    instance, method, progress
        As in :func:`adr_opt.solve`.
    gravity, freedom, ephemerides
        As in :func:`.refine`.
    rounds : int
        Maximum number of times that the mission is planned.
    spend_savings : bool
        Let connections become cheaper than in the model, and plan again even after a first plan
        that holds. The plan may break the tank of the model, as :func:`adr_opt.check` counts it;
        refined, it holds.
    time_limit : float
        Wall time of each round's planning [s].
    stop : Stop, optional
        A further criterion of each planning; once it leaves no time, rounds end too.
    jobs : int, optional
        Threads to plan with, if the planner takes any, and to refine with.
    bound : str, optional
        As in :func:`adr_opt.solve`, in each round. After the first round, bounds hold for the
        corrected connections.
    margin : float
        Share of each tank held in reserve, also of flown ΔV.
    told : callable
        Called with each round.
    unsafe : callable
        Finds the times at which a refined plan that holds must not be flown, such as conjunctions
        (:func:`adr_opt.analysis.screening.avoiding`).
    options : mapping, optional
        Options of the planner.
    **arguments
        ``seed``, ``iterations``, ``start``, ``repair`` and ``memory_gib`` as in
        :func:`adr_opt.solve`; ``building`` and ``sizing`` as in :func:`adr_opt.run.front.run`.

    Raises
    ------
    InputError
        As of :func:`adr_opt.solve` and :func:`.refine`.
    """
    if rounds < 1:
        raise InputError(f"rounds = {rounds}: must be at least 1")
    mission = problem_of(instance)
    refuse(mission.instance, REFINED)
    if ephemerides:
        opened(mission.instance)  # what is wrong with them is said before planning
    lessons, best, history = Lessons(mission.instance, spend_savings), _Best(), list[Round]()

    able = [spec_of(method), *([spec_of(bound, BOUNDS)] if bound else [])]
    planning_jobs = jobs if any(one.uses_cores for one in able) else None
    kept_back = mission.with_margin(margin or mission.margin)
    hearing = {name: arguments.pop(name) for name in ("building", "sizing") if name in arguments}
    wanted = RunOptions(
        time_limit,
        jobs=planning_jobs,
        bound=bound,
        margin=margin,
        options=options or {},
        **arguments,
    )

    def over() -> bool:
        return stop is not None and stop.remaining_s() <= 0.0

    refining = Wanted(gravity, freedom, jobs, None, over, lambda done, total: None, ephemerides)
    known: dict[Hashable, RefinedLeg] = {}
    while True:
        here = mission.corrected(lessons.corrections) if history else mission
        result = run(PLANNERS, here, method, wanted, stop=stop, progress=progress, **hearing)
        if result.plan is None:
            reason = f"round {len(history) + 1} found no plan: {method} ended with {result.status}"
            return _ended(mission, result, best, tuple(history), reason)
        plan = result.plan
        admitted = admit_made(mission.instance, plan, excused=MODEL_TANK if spend_savings else ())
        refined = refined_again(admitted, refining, known)
        failing = troubles(kept_back, refined)
        conflicts = () if failing else unsafe(refined)
        wrong = (*failing, *(each.said for each in conflicts))
        history.append(
            Round(
                len(history) + 1,
                here.connecting.corrections,
                plan.objective,
                refined.planned_delta_v_m_s,
                refined.flown_delta_v_m_s + refined.holding_m_s,
                wrong,
                refined,
            )
        )
        told(history[-1])
        barred = {each.leg for each in conflicts}
        shorter = beginning(kept_back, plan, refined, barred) if wrong else (plan, refined)
        best.hear(None if wrong and shorter and unsafe(shorter[1]) else shorter)
        done = not wrong and (len(history) > 1 or not spend_savings)
        if done:
            return _ended(mission, result, best, tuple(history), "")
        stuck = bool(conflicts) and not lessons.avoid(plan, conflicts)
        if over() or stuck or len(history) == rounds:
            why = "interrupted" if over() else f"none within {len(history)} rounds"
            reason = f"no plan held: {why}; the last one: {'; '.join(wrong)}" if wrong else ""
            return _ended(mission, result, best, tuple(history), reason, refined)
        if failing or spend_savings:
            lessons.learn(plan, refined)


def sequences(problem: Problem, plan: Plan) -> tuple[tuple[int, ...], ...]:
    """Body numbers of a plan in order, for each chaser of the instance."""
    flown = {route.chaser.name: route.legs for route in routes_of(problem.instance, plan)}
    return tuple(
        tuple(mission.numbers(leg.destination for _, leg in flown[mission.chaser.name]).tolist())
        for mission in problem.missions
    )


def _ended(
    mission: Problem,
    result: Result,
    best: _Best,
    rounds: tuple[Round, ...],
    reason: str,
    refined: RefinedPlan | None = None,
) -> RefinedResult:
    """The result with the best plan that holds, or else that of the last round."""
    if best.kept is None:
        return RefinedResult(result, refined, rounds, reason)
    plan, kept = best.kept
    if plan is not result.plan:
        # It may be none of the connections of the last round: their bound is for the notes.
        routes = sequences(mission, plan)
        result = replace(
            result,
            objective=plan.objective,
            upper_bound=math.inf,
            status=plan.status,
            sequence=tuple(chain.from_iterable(routes)),
            routes=routes,
            notes=tuple(dict.fromkeys((*result.notes, *plan.notes))),
        )
    over = [
        tank
        for tank in tanks_of(mission.instance, kept)
        if tank.planned_delta_v_m_s > tank.budget_m_s + DELTA_V_TOLERANCE_M_S
    ]
    if over:
        worst = max(over, key=lambda tank: tank.planned_delta_v_m_s - tank.budget_m_s)
        said = (
            f"by the model a tank needs {worst.planned_delta_v_m_s:.1f} m/s, and has "
            f"{worst.budget_m_s:g}"
        )
        plan = plan.replace(notes=(*plan.notes, f"{said}; refined, the plan holds"))
        kept = kept.made_of(plan)
    return RefinedResult(replace(result, plan=plan), kept, rounds, "")
