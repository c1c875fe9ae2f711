"""``solve``: plan a mission."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from ...common.errors import InputError
from ...common.wording import proof_words
from . import complete, param
from .bars import wanted
from .certificates import certificate_option, check_certificate, save_certificate
from .flown import flight_line, flown_plan, no_fly_option, refined_plan
from .output import emit, emit_rich, say, say_doubts, terminal_width
from .parameters import check_out, parse_assignments, run_options
from .refine import Refining, refine_options, run_refined, save_refined, tell_refined
from .work import say_notes, work

if TYPE_CHECKING:
    from ...common.progress import Progress
    from ...common.stop import Stop
    from ...fly.refine.loop import RefinedResult
    from ...mission.result import Result
    from ...plan.plan import Plan
    from ...problem.instance import Instance
    from ...run.run_options import RunOptions


@dataclass(frozen=True)
class Uncertain:
    """Request for a plan of an uncertain mission.

    Attributes
    ----------
    confidence : float or None
        Of ``--confidence``; None if it is not given.
    expected : bool
        Whether ``--expected`` is.
    uncertainty_path : str or None
    """

    confidence: float | None
    expected: bool
    uncertainty_path: str | None

    @property
    def option(self) -> str:
        """The option that requests a plan of an uncertain mission; empty if none."""
        if self.confidence is not None:
            return "--confidence"
        return "--expected" if self.expected else ""

    def check(self, others: dict[str, bool]) -> None:
        """Refuse options that exclude each other.

        Parameters
        ----------
        others : mapping of str to bool
            Options that do not go with it, and whether each is given.

        Raises
        ------
        InputError
            One of the two is missing, or another option is given.
        """
        if self.option and self.uncertainty_path is None:
            raise InputError(f"{self.option} needs --uncertainty; give both")
        if self.uncertainty_path is not None and not self.option:
            raise InputError("--uncertainty needs --confidence or --expected; give one of them")
        both = {"--expected": self.expected and self.confidence is not None}
        for other, is_given in (both | others).items():
            if self.option and is_given:
                raise InputError(f"{other} excludes {self.option}; leave one of them out")


uncertain_options = param.together(
    param.number(
        "--confidence", "C", "Required probability that the plan holds; with --uncertainty."
    ),
    param.flag(
        "--expected", "Maximise the mean prize when the plan is followed; with --uncertainty."
    ),
    param.uncertainty(),
)
"""The options of plans of uncertain missions."""


def run_uncertain(
    instance: Instance,
    method: str,
    uncertain: Uncertain,
    given: RunOptions,
    *,
    as_json: bool,
    quiet: bool,
) -> Result:
    """Plan an uncertain mission, and print the notes."""
    from ...analysis.robust.expected import expected
    from ...analysis.robust.robust import robust
    from ...problem.uncertainty import Uncertainty

    assert uncertain.uncertainty_path is not None
    uncertainty = Uncertainty.load(uncertain.uncertainty_path)
    how: dict[str, Any] = {
        "time_limit": given.time_limit,
        "seed": given.seed,
        "jobs": given.jobs,
        **given.options,
    }

    def made(stop: Stop, progress: Progress) -> Result:
        how.update(stop=stop, progress=progress)
        if uncertain.confidence is None:
            return expected(instance, uncertainty, method, **how).result
        confidence, bound = uncertain.confidence, given.bound
        return robust(instance, uncertainty, confidence, method, bound=bound, **how).result

    result = work(made, live=wanted(as_json, quiet), quiet=quiet)
    say_notes(result, quiet)
    return result


@click.command("solve")
@param.instance
@param.method
@param.time_limit("Wall-clock limit, timetable included; default 10 s.")
@run_options
@param.number(
    "--memory",
    "GIB",
    "Maximum memory for the timetable; beyond it, only the nearest pairs are used; default 2 GiB.",
    name="memory_gib",
)
@param.file("--policy", "Short for --option policy=FILE.")
@param.word("--decode", "HOW", "Short for --option decode=HOW.")
@param.flag("--repair", "Keep the legal beginning of an illegal --start.")
@param.word(
    "--bound",
    "NAME",
    "Bound to run beside the planner.",
    name="bound_name",
    shell_complete=complete.bounds,
)
@param.file("--out", "Plan file to write.")
@certificate_option
@refine_options
@uncertain_options
@no_fly_option
@param.spoken
def command(
    instance_path: str,
    method: str | None,
    time_limit: float | None,
    seed: int,
    iterations: int | None,
    margin: float,
    jobs: int | None,
    start_path: str | None,
    assignments: tuple[str, ...],
    memory_gib: float | None,
    policy: str | None,
    decode: str | None,
    repair: bool,
    bound_name: str | None,
    out: str | None,
    certificate_path: str | None,
    no_fly: bool,
    as_json: bool,
    quiet: bool,
    **asked: Any,
) -> int:
    """Plan the mission of INSTANCE and show its timeline.

    After the time limit, the plan is flown in mean motion on the true orbits: the last line gives
    the ΔV of its legs and the remainder of each tank.

    Ctrl-C stops with the best plan so far; a second one aborts. Exit status 1: no plan, or with
    --refine none that holds.
    """
    from ...analysis.grids import grid_advice
    from ...judge.admit import admit_made
    from ...mission.problem import problem_of
    from ...plan.plan import Plan
    from ...problem.instance import load
    from ...run import front
    from ...run.methods import BOUNDS, PLANNERS
    from .bars import wanted
    from .work import emit_result, run_method, say_notes, work

    method = method or front.DEFAULT_METHOD
    time_limit = front.DEFAULT_TIME_LIMIT_S if time_limit is None else time_limit
    if bound_name is not None:
        front.method_of(bound_name, BOUNDS)
    if repair and start_path is None:
        raise InputError("--repair needs a start plan, but none is given; give one with --start")
    for name, value in (("policy", policy), ("decode", decode)):
        if value is not None:
            assignments = (*assignments, f"{name}={value}")
    options = parse_assignments(front.method_of(method), assignments)
    instance = load(instance_path)
    say_doubts(instance, quiet=quiet)
    start = None if start_path is None else Plan.load(start_path)
    check_out(out, instance_path)
    refining, uncertain = param.taken(Refining, asked), param.taken(Uncertain, asked)
    check_certificate(
        certificate_path,
        instance,
        method,
        bound_name,
        instance_path,
        start_path,
        margin=margin,
        out=out,
        refine=refining.refine,
    )
    refining.check(instance_path, out)
    uncertain.check(
        {
            "--refine": refining.refine,
            "--certificate": certificate_path is not None,
            "--start": start is not None,
            "--margin": margin > 0.0,
            "--iterations": iterations is not None,
            "--memory": memory_gib is not None,
            "--bound": uncertain.expected and bound_name is not None,
        }
    )
    given = front.RunOptions(
        time_limit, seed, start, repair, jobs, iterations, bound_name, margin, memory_gib, options
    )
    looped: RefinedResult | None = None
    problem = problem_of(instance)
    if refining.refine:
        looped = work(
            lambda stop, progress: run_refined(
                instance, method, refining, progress, quiet, stop=stop, wanted=given
            ),
            live=wanted(as_json, quiet),
            quiet=quiet,
        )
        result = looped.result
        say_notes(result, quiet)
    elif uncertain.option:
        result = run_uncertain(instance, method, uncertain, given, as_json=as_json, quiet=quiet)
    else:
        result = run_method(PLANNERS, problem, method, given, as_json=as_json, quiet=quiet)
    if result.plan is None:
        if looped is not None and as_json:
            tell_refined(looped, as_json)
        elif as_json:
            emit_result(instance, margin, result)
        why = f"{method} ended with status {result.status}" if looped is None else looped.reason
        say(f"no plan: {why}", unless=quiet)
        if certificate_path is not None and result.status == "infeasible":
            save_certificate(certificate_path, instance, result, quiet)
        return 1
    plan = result.plan
    if looped is not None:
        looped = refined_plan(instance, looped)
        plan = looped.plan or plan
    else:
        admitted = admit_made(instance, plan)
    unsaved = _first_trouble(partial(_save_plan, plan, out, quiet))
    is_kept = out is not None and unsaved is None
    others = _first_trouble(
        *(() if looped is None else (partial(save_refined, looped, refining.refined_out, quiet),)),
        *(
            ()
            if certificate_path is None
            else (partial(save_certificate, certificate_path, instance, result, quiet),)
        ),
    )
    not_written = unsaved or others
    if not quiet and looped is None and problem.has_timetable:
        advice = grid_advice(problem, plan)
        if advice is not None:
            say(f"note: {advice}")
    if not as_json:
        from .timeline import by_chaser, summary, timelines

        emit_rich(*timelines(instance, plan, terminal_width()))
        for sentence in by_chaser(instance, plan):
            emit(sentence)
        emit(summary(instance, plan))
    if looped is not None:
        tell_refined(looped, as_json)
    elif not no_fly:
        # The plan is safe by now, whatever becomes of its flight.
        plan, flight = flown_plan(admitted)
        if plan.flown is not None and is_kept:
            lacking = _first_trouble(partial(_save_plan, plan, out, quiet=True))
            if lacking is not None and not quiet:
                say(f"the plan is written, but without the outcome of its flight: {lacking}")
        if not as_json:
            emit(flight_line(flight))
    if (as_json and looped is None) or (not_written is not None and not is_kept):
        emit(plan.to_json())
    if not_written is not None:
        # It may have taken hours: what cannot be kept is at least said.
        place = f"in {out}" if is_kept else "on standard output instead"
        raise InputError(f"{not_written}; the plan is {place}")
    failed = result.status == "infeasible" if looped is None else not looped.holds
    return 1 if failed else 0


def _save_plan(plan: Plan, out: str | None, quiet: bool) -> None:
    if out is None:
        return
    plan.save(out)
    say(
        f"wrote {out}: objective {plan.objective:g}, {proof_words(plan.status, plan.cost_status)}",
        unless=quiet,
    )


def _first_trouble(*steps: Callable[[], None]) -> InputError | None:
    """Run all steps, and raise the first error at the end."""
    trouble: InputError | None = None
    for step in steps:
        try:
            step()
        except InputError as error:
            trouble = trouble or error
    return trouble
