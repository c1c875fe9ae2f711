"""The page of ``scenario``: both futures over time, and the removals of each campaign."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from ...analysis.scenario.futures import Scenario
from ...analysis.scenario.settings import KINDS
from ...common.wording import counted
from ...sources.worth.answer import figure
from ..plot.studies import scenario_chart
from .charts import drawn
from .plain import page, row, section, table_of
from .tables import Column, table
from .text import NOTHING, fixed

CURVES = (
    ("objects", "Objects", "objects in orbit"),
    ("fragments", "Fragments of drawn events", "fragments of 10 cm and more"),
    ("catastrophic", "Expected catastrophic collisions of pairs", "a year"),
    (
        "fragment_catastrophic",
        "Expected catastrophic collisions with fragments of drawn events",
        "a year",
    ),
    ("expected_fragments_before", "Fragments expected so far", "fragments made, in expectation"),
)
"""Numbers of a year, titles of their sections and of their axes."""

DIFFERENCES = {
    "catastrophic": "catastrophic collisions of pairs, expected",
    "fragment_catastrophic": "catastrophic collisions with fragments of drawn events, expected",
    "expected_fragments": "fragments made, expected",
    "collisions": "collisions drawn",
    "explosions": "explosions drawn",
    "decayed": "objects come down",
    "removed": "objects removed",
}

ASSUMED = (
    "A study of campaigns, beside models of the environment and not in their place. Left out: "
    "what is below 10 cm, collisions of fragments with each other, the spread of fragments about "
    "the altitude of their event, dodging, disposal after missions, the solar cycle, and the pull "
    "of Sun and Moon. Objects are passive, nodes and perigees random for encounters. A campaign "
    "finds out on arrival that an object has broken up."
)

NOTHING_DRAWN = "There are none in any year."

WITH_NONE = "No campaign took place."


def scenario_page(made: Scenario, told: Mapping[str, Any]) -> str:
    """The HTML of the page.

    Parameters
    ----------
    made : Scenario
    told : mapping
        Its answer, see :func:`adr_opt.analysis.scenario.scenario_answer`.
    """
    settings = made.start.settings
    parts = [_curve(told, *curve) for curve in CURVES]
    parts += [
        section(
            "Sums over the years",
            "Means over seeds and standard errors. Both cases share seeds, so differences scatter "
            "less than the values themselves.",
            _sums(told),
        ),
        section("Campaigns", *_campaigns(told)),
        section("Removals by altitude", "Means over seeds.", _by_shell(made)),
        section("Assumptions", ASSUMED, ""),
    ]
    under = (
        f"{counted(settings.years, 'year')} from {told['epoch'][:10]} · "
        f"{counted(settings.seeds, 'future')} · {settings.activity} solar activity"
        + ("" if settings.drag else ", no drag")
    )
    title = f"{told['objects']} objects, with campaigns and without"
    return page("Scenario", title, under, parts)


def _curve(told: Mapping[str, Any], name: str, title: str, axis: str) -> str:
    chart = scenario_chart(told, name, axis)
    return (
        section(title, NOTHING_DRAWN, "")
        if chart is None
        else section(title, "", drawn(chart, title))
    )


def _value(pair: Mapping[str, Any]) -> str:
    mean, error = pair["mean"], pair["standard_error"]
    return figure(mean) if error is None else f"{figure(mean)} ± {error:.2g}"


def _sums(told: Mapping[str, Any]) -> str:
    cases = ("without", "with", "difference")
    rows = (
        row((("", said), *(("n", _value(told["sums"][case][name])) for case in cases)))
        for name, said in DIFFERENCES.items()
    )
    headings = (("sum", ""), *((case, "n") for case in cases))
    return table("Sums over the years", headings, rows)


def _campaigns(told: Mapping[str, Any]) -> tuple[str, str]:
    flown = [each for each in told["campaigns"] if each["flown"]]
    if not flown:
        return WITH_NONE, ""
    columns: list[Column] = [
        ("year", "n", lambda each: str(each["year"])),
        ("flown", "n", lambda each: str(each["flown"])),
        ("lost", "n", lambda each: str(each["failed"])),
        ("planned anew", "n", lambda each: str(each["replanned"])),
        ("captured", "n", lambda each: str(each["captured"])),
        ("missed", "n", lambda each: str(each["missed"])),
        ("fragment-years", "n", lambda each: figure(each["avoided"])),
        ("of the first seed", "", lambda each: _objects(each["of_first_seed"])),
    ]
    note = (
        "Sums over seeds; fragment-years are the floors of what was captured, counted at the year "
        "of the campaign. Of the first seed the objects, in order of time."
    )
    return note, table_of("Campaigns", columns, ((each,) for each in flown))


def _objects(attempts: list[Mapping[str, Any]]) -> str:
    said = (
        each["object"] if each["succeeded"] else f"{each['object']} (missed)" for each in attempts
    )
    return "; ".join(said) or NOTHING


def _by_shell(made: Scenario) -> str:
    shells = made.start.settings.shells
    counts = np.zeros((shells.count + 2, len(KINDS)))
    for each in made.futures:
        for record in each["with"]:
            for _, kind, shell in record.removed:
                counts[shell, kind] += 1.0 / len(made.futures)
    edges = shells.edges_km
    names = [
        f"below {edges[0]:g}",
        *(f"{low:g}–{high:g}" for low, high in pairwise(edges.tolist())),
        f"above {edges[-1]:g}",
    ]
    rows = (
        row((("", names[shell]), *(("n", fixed(value, 2)) for value in counts[shell])))
        for shell in range(len(counts))[::-1]
        if counts[shell].any()
    )
    headings = (("altitude km", ""), *((kind, "n") for kind in KINDS))
    return table("Removals by altitude", headings, rows)
