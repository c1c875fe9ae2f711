"""Arguments and options of verbs: constructors by type, and those shared by several verbs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from inspect import signature
from typing import Any, TypeVar

import click

from . import complete

Record = TypeVar("Record")
Function = TypeVar("Function", bound=Callable[..., Any])


def word(
    sign: str, metavar: str, text: str, name: str = "", **more: Any
) -> Callable[[Function], Function]:
    """An option with a value; ``metavar`` describes it, and ``name`` is its parameter if given."""
    names = (sign, name) if name else (sign,)
    more.setdefault("shell_complete", complete.BY_METAVAR.get(metavar))
    return click.option(*names, metavar=metavar, help=text, **more)


number = partial(word, type=float)
count = partial(word, type=int)
many = partial(word, multiple=True)
"""A repeatable option."""


def file(sign: str, text: str, name: str = "", **more: Any) -> Callable[[Function], Function]:
    """An option that names a file, as a plain string: errors are raised on reading or writing."""
    return word(sign, "FILE", text, name, **more)


def choice(
    sign: str, values: Sequence[str], text: str, name: str = "", **more: Any
) -> Callable[[Function], Function]:
    """An option with one of some values."""
    names = (sign, name) if name else (sign,)
    return click.option(*names, type=click.Choice(values), help=text, **more)


def flag(sign: str, text: str, name: str = "") -> Callable[[Function], Function]:
    """An option without a value."""
    return click.option(*((sign, name) if name else (sign,)), is_flag=True, help=text)


def together(*options: Callable[[Any], Any]) -> Callable[[Function], Function]:
    """Several options combined, in the order in which ``--help`` lists them."""

    def add(function: Function) -> Function:
        for option in reversed(options):
            function = option(function)
        return function

    return add


def taken(kind: type[Record], given: dict[str, Any]) -> Record:
    """Move a verb's option values into a record, out of the given arguments."""
    return kind(**{name: given.pop(name) for name in signature(kind).parameters})


files = click.argument(
    "files", nargs=-1, required=True, metavar="FILE...", shell_complete=complete.files
)
instance = click.argument("instance_path", metavar="INSTANCE", shell_complete=complete.files)
plan = click.argument("plan_path", metavar="PLAN", shell_complete=complete.files)
as_json = flag("--json", "Print one JSON object and nothing else.", name="as_json")
cluster = word(
    "--cluster", "dask://HOST:PORT", "Use the workers of a Dask scheduler instead of --jobs."
)
quiet = flag("--quiet", "No messages and no progress.")
spoken = together(as_json, quiet)
"""How a verb speaks."""
method = word(
    "--method",
    "NAME",
    "Planner; 'methods' lists them and the default.",
    shell_complete=complete.planners,
)
satcat = file("--satcat", "satcat.tsv of the General Catalog, for masses and sizes.", "satcat_path")
measures = file(
    "--table", "CSV file with columns object,mass,size, preferred to others.", "table_path"
)
activity = choice(
    "--activity",
    ("low", "mean", "high"),
    "Solar activity, which sets the density of the atmosphere.",
    default="mean",
    show_default=True,
)
page = file("--page", "HTML file to write.", "page_path")
uncertainty = partial(file, "--uncertainty", "Uncertainty file.", "uncertainty_path")
errors = file("--errors", "CSV file of covariances and radii, for probabilities.", "errors_path")
time_limit = partial(number, "--time-limit", "S")
cores = partial(count, "--jobs", "N", "Number of cores; 0 for all.")
processes = count("--jobs", "N", "Number of processes; 0 for all cores.", default=1)
exclude = many(
    "--exclude", "PATTERN", "Names to leave out, such as manoeuvring satellites; repeatable."
)
skip_bad = flag("--skip-bad", "Skip bad rows, and count them.")


def seeded(text: str) -> Callable[[Function], Function]:
    """The seed of what a verb draws."""
    return click.option("--seed", type=int, default=0, show_default=True, help=text)


seed = seeded("Seed; equal seeds, equal results.")


approach = choice(
    "--approach", ("half-lap", "safety-ellipse"), "Kind of approach to targets; default half-lap."
)
burns = choice(
    "--burns",
    ("sequence", "free"),
    "Burns by which legs are priced; default sequence, or free if an imported orbit is eccentric.",
)
keep_out = number("--keep-out", "M", "Keep-out radius of a safety ellipse; default 200.")


def fitting_options(usual: str) -> Callable[[Function], Function]:
    """The options of tanks, kits and tows; ``usual`` describes the default ΔV of a tank."""
    return together(
        number("--delta-v", "M_S", f"ΔV of a full tank; {usual}."),
        number("--dry-mass", "KG", "For a tank by mass: mass without propellant."),
        number("--propellant", "KG", "For a tank by mass: propellant when full."),
        number("--isp", "S", "For a tank by mass: specific impulse."),
        count("--kits", "K", "Each target needs a kit; at most K aboard."),
        number("--kit-mass", "KG", "Mass of a kit; default 0."),
        number("--kit-isp", "S", "Specific impulse of kits, sized to reach the disposal orbit."),
        number("--tow", "KG", "Mass of each target; targets are towed."),
        number(
            "--disposal-altitude", "KM", "Altitude of the circular orbit that targets are towed to."
        ),
        number("--disposal-perigee", "KM", "Altitude to which perigees are lowered instead."),
        number("--max-lifetime", "YEARS", "Longest lifetime after release; no default."),
        number("--max-uncontrolled", "KG", "Heavier targets re-enter under control; no default."),
    )
