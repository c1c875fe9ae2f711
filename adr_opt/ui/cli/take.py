"""What verbs take: options by their kinds, and arguments and options that several verbs share."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar

import click

from . import complete

Function = TypeVar("Function", bound=Callable[..., Any])


def word(
    sign: str, metavar: str, text: str, name: str = "", **more: Any
) -> Callable[[Function], Function]:
    """An option that takes what its ``metavar`` says, and is known by ``name`` if not by itself."""
    names = (sign, name) if name else (sign,)
    more.setdefault("shell_complete", complete.BY_METAVAR.get(metavar))
    return click.option(*names, metavar=metavar, help=text, **more)


number = partial(word, type=float)
count = partial(word, type=int)
many = partial(word, multiple=True)
"""One that may be repeated."""


def file(sign: str, text: str, name: str = "", **more: Any) -> Callable[[Function], Function]:
    """An option that names a file, as a plain string: who reads and writes has the sentences."""
    return word(sign, "FILE", text, name, **more)


def flag(sign: str, text: str, name: str = "") -> Callable[[Function], Function]:
    """An option that takes nothing."""
    return click.option(*((sign, name) if name else (sign,)), is_flag=True, help=text)


def together(*options: Callable[[Any], Any]) -> Callable[[Function], Function]:
    """Several options as one, in the order in which ``--help`` lists them."""

    def add(function: Function) -> Function:
        for option in reversed(options):
            function = option(function)
        return function

    return add


instance = click.argument("instance_path", metavar="INSTANCE", shell_complete=complete.files)
plan = click.argument("plan_path", metavar="PLAN", shell_complete=complete.files)
as_json = flag("--json", "Print one JSON object and nothing else.", name="as_json")
cluster = word(
    "--cluster",
    "dask://HOST:PORT",
    "Work on the workers of a Dask scheduler, in the place of --jobs.",
)
quiet = flag("--quiet", "No messages and no progress.")
method = word(
    "--method",
    "NAME",
    "Planner; 'methods' lists them and the default.",
    shell_complete=complete.planners,
)
seed = click.option(
    "--seed", type=int, default=0, show_default=True, help="Same seed, same result."
)
