"""Parameters that several verbs share."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from ...common.errors import InputError

if TYPE_CHECKING:
    from ...run.methods import Planner

Function = TypeVar("Function", bound=Callable[..., Any])

# Paths are plain strings: the sentences about files come from where files are read and written.
instance_argument = click.argument("instance_path", metavar="INSTANCE")
plan_argument = click.argument("plan_path", metavar="PLAN")
json_option = click.option(
    "--json", "as_json", is_flag=True, help="Print one JSON object and nothing else."
)
cluster_option = click.option(
    "--cluster",
    metavar="dask://HOST:PORT",
    help="Work on the workers of a Dask scheduler, in the place of --jobs.",
)
quiet_option = click.option("--quiet", is_flag=True, help="No messages and no progress.")


def run_options(function: Function) -> Function:
    """The options of a verb that runs a method."""
    for option in reversed(
        (
            click.option(
                "--seed", type=int, default=0, show_default=True, help="Same seed, same result."
            ),
            click.option(
                "--iterations", type=int, metavar="N", help="Most iterations, as the method counts."
            ),
            click.option(
                "--margin",
                type=float,
                default=0.0,
                metavar="SHARE",
                help="Share of each tank to keep back, as 0.1 for a tenth.",
            ),
            click.option("--jobs", type=int, metavar="N", help="Cores to use; 0 for all."),
            click.option("--start", "start_path", metavar="PLAN", help="A plan to begin from."),
            click.option(
                "--option",
                "assignments",
                multiple=True,
                metavar="NAME=VALUE",
                help="An option of the method, see 'methods'; may be repeated.",
            ),
        )
    ):
        function = option(function)
    return function


def parse_assignments(method: Planner, assignments: Iterable[str]) -> dict[str, Any]:
    """The values of ``--option NAME=VALUE``, by the types of the method's defaults.

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
    """Raise :class:`InputError` before any work if the result could not be written to ``out``.

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


def is_same_file(one: str, other: str) -> bool:
    """Whether two paths lead to one file, which links may hide and which need not exist."""
    first, second = Path(one), Path(other)
    if first.exists() and second.exists():
        return first.samefile(second)
    return first.resolve() == second.resolve()
