"""Parameters shared by several verbs."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...common.errors import InputError, MissingExtra
from ...common.wording import counted
from . import param

if TYPE_CHECKING:
    from ...judge.admit import Admitted
    from ...plan.plan import Plan
    from ...plan.refined_plan import RefinedPlan
    from ...run.methods import Planner


run_options = param.together(
    param.seed,
    param.count("--iterations", "N", "Maximum number of iterations, as defined by the method."),
    param.number(
        "--margin", "SHARE", "Share of each tank to hold in reserve, such as 0.1.", default=0.0
    ),
    param.cores(),
    param.word("--start", "PLAN", "Plan to start from.", name="start_path"),
    param.many(
        "--option",
        "NAME=VALUE",
        "Option of the method, see 'methods'; repeatable.",
        name="assignments",
    ),
)
"""The options of a verb that runs a method."""


def admitted_plan(instance_path: str, plan_path: str, *, unjudged: bool = False) -> Admitted[Plan]:
    """The plan given to a verb, once judged, with its instance.

    Raises
    ------
    InputError
        As of :func:`adr_opt.judge.admit.admit`.
    """
    from ...judge.admit import admit
    from ...plan.plan import Plan
    from ...problem.instance import load

    instance, plan = load(instance_path), Plan.load(plan_path)
    with about(plan_path):
        return admit(instance, plan, unjudged=unjudged)


def admitted_refined(
    instance_path: str, refined_path: str, *, unjudged: bool = False, excused: Collection[str] = ()
) -> Admitted[RefinedPlan]:
    """The refined plan given to a verb, once judged, with its instance."""
    from ...judge.admit import admit
    from ...plan.refined_plan import RefinedPlan
    from ...problem.instance import load

    instance, refined = load(instance_path), RefinedPlan.load(refined_path)
    with about(refined_path):
        return admit(instance, refined, unjudged=unjudged, excused=excused)


unjudged_option = param.flag(
    "--unjudged", "Accept a plan with violations; its figures are then marked as unjudged."
)


def say_unjudged(admitted: Admitted[Any], path: str, *, quiet: bool) -> None:
    """Say that a plan with violations was accepted."""
    from .output import say

    if not admitted.holds:
        count = counted(len(admitted.violations), "violation")
        say(f"{path}: unjudged: {count}, the first: {admitted.violations[0]}", unless=quiet)


@contextmanager
def about(path: str) -> Iterator[None]:
    """Prefix an :class:`InputError` with the file that it concerns.

    A package that is missing is no fault of the file.
    """
    try:
        yield
    except MissingExtra:
        raise
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def parse_assignments(method: Planner, assignments: Iterable[str]) -> dict[str, Any]:
    """Values of ``--option NAME=VALUE``, by the types of the method's defaults.

    Raises
    ------
    InputError
        Not of that form, given twice, no such option, or not a value of its type.
    """
    from ...common.options import parsed
    from ...run.methods import options_of

    kind = options_of(method)
    values: dict[str, Any] = {}
    for assignment in assignments:
        name, sign, text = assignment.partition("=")
        name = name.strip()
        if not sign or not name:
            raise InputError(f"--option {assignment!r}: give it as NAME=VALUE")
        if name in values:
            raise InputError(f"--option {name} is given twice; give it once")
        values[name] = parsed(kind, name, text.strip())
    return values


def check_out(out: str | None, *inputs: str | None, results: Iterable[str | None] = ()) -> None:
    """Raise :class:`InputError` in advance if the result could not be written to ``out``.

    ``inputs`` are what the call reads, and ``results`` what else it writes; these need not be there
    yet.
    """
    from ...common.files import check_writable

    if out is None:
        return
    check_writable(out)
    for paths, known in ((inputs, "the input"), (results, "the name of another result, too")):
        if any(path is not None and is_same_file(out, path) for path in paths):
            raise InputError(f"{out}: this is {known}; name another file for the result")


def check_outs(results: Sequence[str | None], *inputs: str | None) -> None:
    """Check several results as :func:`check_out` does; no two may be the same file."""
    for at, path in enumerate(results):
        check_out(path, *inputs, results=results[at + 1 :])


def is_same_file(one: str, other: str) -> bool:
    """Whether two paths lead to the same file, which may be linked or absent."""
    first, second = Path(one), Path(other)
    if first.exists() and second.exists():
        return first.samefile(second)
    return first.resolve() == second.resolve()
