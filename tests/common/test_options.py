"""Options of methods: what is declared is what is accepted, refused, listed and written down."""

from __future__ import annotations

import math
import runpy
from collections.abc import Iterator
from dataclasses import FrozenInstanceError, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Cli

from adr_opt.common.errors import InputError
from adr_opt.common.options import (
    LARGEST_WHOLE,
    MOST_JOBS,
    Options,
    default_of,
    listed,
    option,
    read,
    rule_of,
)
from adr_opt.run import methods
from adr_opt.run.methods import BOUNDS, PLANNERS, get, names, options_of

KINDS = {
    name: options_of(get(name, group)) for group in (BOUNDS, PLANNERS) for name in names(group)
}
"""The options of every method, by its name."""


def declared() -> Iterator[tuple[str, str]]:
    """Every option of every method."""
    for method, kind in KINDS.items():
        for each in fields(kind):
            yield method, each.name


every_option = pytest.mark.parametrize(("method", "name"), list(declared()))


def edges(method: str, name: str) -> tuple[list[Any], list[Any]]:
    """Values at the limits of an option, and those just outside of them."""
    (each,) = (each for each in fields(KINDS[method]) if each.name == name)
    rule, default = rule_of(each), default_of(each)
    if isinstance(default, bool):
        return [False, True], ["perhaps"]
    if isinstance(default, str):
        return list(rule.choices), ["nonsense"] if rule.choices else []

    def next_to(limit: float, step: int) -> float:
        whole = isinstance(default, int)
        return limit + step if whole else math.nextafter(limit, step * math.inf)

    inside, outside = [], ["much"]
    others = {each.name: default_of(each) for each in fields(KINDS[method])}
    least, most = others.get(rule.least, rule.least), others.get(rule.most, rule.most)
    if most is None:
        most = LARGEST_WHOLE if isinstance(default, int) else math.nextafter(math.inf, 0.0)
    if least is not None:
        inside, outside = [*inside, least], [*outside, next_to(least, -1)]
    if rule.above is not None:
        inside, outside = [*inside, next_to(rule.above, 1)], [*outside, rule.above]
    outside = [*outside, next_to(most, 1)] if most < math.inf else outside
    return [*inside, most], outside if isinstance(default, int) else [*outside, math.nan]


@pytest.mark.parametrize("method", KINDS)
def test_the_defaults_are_valid_and_explained(method: str) -> None:
    """The defaults of every method pass as values, and each option says what it means."""
    kind = KINDS[method]
    assert read(kind, vars(kind())) == kind()
    for each in fields(kind):
        assert rule_of(each).doc.endswith("."), each.name


@every_option
def test_the_limits_may_be_reached(method: str, name: str) -> None:
    """The values at the limits of an option are accepted, also by those that it limits."""
    rules = {each.name: rule_of(each) for each in fields(KINDS[method])}
    limited = [other for other, rule in rules.items() if name in (rule.least, rule.most)]
    for value in edges(method, name)[0]:
        values = dict.fromkeys((name, *limited), value)
        assert vars(read(KINDS[method], values)).items() >= values.items()


@every_option
def test_what_is_just_outside_is_refused(cli: Cli, tiny_file: Path, method: str, name: str) -> None:
    """A value outside of the limits of an option is refused in one sentence that names all."""
    verb = "solve" if method in names(PLANNERS) else "bound"
    for value in edges(method, name)[1]:
        shown = repr(value)
        call = verb, tiny_file, "--method", method, "--option", f"{name}={value}"
        outcome = cli(*call, "--quiet")  # says when it compiles
        assert outcome.status == 2, value
        assert outcome.out == ""
        assert outcome.err.count("\n") == 1
        assert f"option {name} = {shown} of method {method!r}: " in outcome.err
        assert any(word in outcome.err for word in (": give ", ": must be ", ": use one of "))


@pytest.mark.parametrize(
    ("method", "option", "most"),
    [
        ("beam", "width", 10**6),
        ("mcts", "simulations", 10**6),
        ("mcts", "depth", 10**9),
        ("local-search", "width", 10**6),
        ("exact", "jobs", 1024),
        ("exact", "most_labels", 10**9),
    ],
)
def test_options_beyond_any_use(method: str, option: str, most: int) -> None:
    """A number that no memory or no kernel could hold is refused with the largest there is."""
    for value in (most + 1, 10**20, -(10**20)):
        with pytest.raises(InputError, match=f"{option} = {value} of .* at most {most}"):
            read(KINDS[method], {option: value})


def test_one_option_may_limit_another() -> None:
    """A limit that is another option is that option's value, and the sentence says it."""
    assert read(KINDS["ortools"], {"shortest_window": 12, "longest_window": 12})
    with pytest.raises(InputError, match=r"longest_window = 10 .* at least shortest_window = 12"):
        read(KINDS["ortools"], {"shortest_window": 12})


@dataclass(frozen=True)
class Some(Options, method="some"):
    """Options of all types."""

    whole: int = option(3, "A whole number.", least=1)
    share: float = option(0.5, "A share.", least=0.0, most=1.0)
    fast: bool = option(False, "Whether to hurry.")
    word: str = option("a", "A word.", choices=("a", "b"))


def test_values_have_the_types_of_the_defaults() -> None:
    """Numbers of the right kind are made the type of the default; anything else is refused."""
    some = Some(whole=np.int32(4), share=1, fast=np.True_, word="b")
    assert [type(value) for value in vars(some).values()] == [int, float, bool, str]
    for values in (
        {"whole": 2.0},
        {"whole": "2"},
        {"share": "0.5"},
        {"share": None},
        {"share": 10**400},
        {"fast": "yes"},
        {"fast": 2},
        {"fast": np.ones(2)},
        {"word": 1},
    ):
        with pytest.raises(InputError, match=r"option \w+ = .* of method 'some': give "):
            Some(**values)
    with pytest.raises(FrozenInstanceError):
        some.whole = 5


def test_the_parameters_of_a_function_are_options_too() -> None:
    """A method that declares parameters with defaults gets a class of options made of them."""
    given: dict[str, Any] = {}

    def plain(  # noqa: PLR0913
        mission,
        *,
        seed,
        stop,
        progress,
        start=None,
        depth=5,
        seen=[],  # noqa: B006
        limit=math.inf,
        most=10**12,
        what=None,
        jobs=0,
        options="none",
    ):
        """Remember what it is given."""
        given.update(depth=depth, seen=seen, limit=limit, most=most, jobs=jobs, options=options)

    method = methods._with_options("plain", plain)
    kind = options_of(method)
    expected = ["depth", "seen", "limit", "most", "what", "jobs", "options"]
    assert [each.name for each in fields(kind)] == expected
    known = methods.spec_of_function("plain", plain)
    assert known.starts
    assert known.uses_cores
    assert method.__doc__ == plain.__doc__
    chosen = read(kind, {"depth": 7, "limit": math.nan, "jobs": 2})
    method(None, seed=0, stop=None, progress=None, options=chosen)
    assert math.isnan(given.pop("limit"))
    assert given == {"depth": 7, "seen": [], "most": 10**12, "jobs": 2, "options": "none"}
    for values in ({"depth": 0.5}, {"depth": LARGEST_WHOLE + 1}, {"jobs": MOST_JOBS + 1}):
        with pytest.raises(InputError, match=r"option \w+ = .* of method 'plain'"):
            read(kind, values)
    with pytest.raises(InputError, match="'width' of method 'plain' is unknown; use one of: depth"):
        read(kind, {"width": 1})


def test_the_page_lists_what_is_declared() -> None:
    """What the site adds to docs/options.md has each option of each method of this project."""
    listing = Path(__file__).parents[2] / "docs" / "list_options.py"
    shown = runpy.run_path(str(listing))["tables"]()
    for name, kind in KINDS.items():
        _, found, section = shown.partition(f"### `{name}`\n")
        assert found
        for row in listed(kind):
            assert f"| `{row['name']}` |" in section.partition("\n##")[0]
