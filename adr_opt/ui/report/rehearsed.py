"""The page of rehearsals: fans over time, losses, tanks and gaps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...analysis.rehearse.rehearsals import Rehearsals
from ...common.wording import counted
from ..plot.chart import Chart
from ..plot.studies import delta_v_fan, delta_v_spread, prize_fan, visits_spread
from .charts import drawn
from .plain import page, row, section, table_of
from .tables import Column, table
from .text import NOTHING, fixed, number

MOST_TARGETS = 25
"""Maximum number of lost targets in the table."""

REASONS = {
    "capture": "no try at the capture succeeded",
    "gone": "the target was gone",
    "dry": "a tank ran dry",
    "late": "a service did not end in time",
    "delta-v": "the next leg could not be afforded",
    "duration": "there was no connection in time",
    "capacity": "no kit was left, or the maximum number of targets was reached",
    "left-out": "the policy left it out",
    "rules": "the policy chose an illegal leg",
}
"""Reasons of losses, in words."""


def rehearsed_page(made: Rehearsals, told: Mapping[str, Any]) -> str:
    """The HTML of the page.

    Parameters
    ----------
    made : Rehearsals
        At least one.
    told : mapping
        The answer of ``rehearse``: :meth:`.Rehearsals.to_dict`, and bounds and gaps if there are.
    """
    parts = [
        section(
            "Prize over time",
            "The bands hold the stated shares of all rehearsals.",
            drawn(prize_fan(made), "Prize over time"),
        ),
        section("ΔV over time", "", drawn(delta_v_fan(made), "ΔV over time")),
        section("Distributions", "", _spreads(made) + _distributions(told)),
        section(
            "Losses", "Mean number of targets that a rehearsal loses, by reason.", _losses(told)
        ),
        section("Targets most often lost", "", _targets(told)),
        section("Tanks", "ΔV left at the end of each tank, in m/s.", _tanks(told)),
    ]
    if told.get("bounds"):
        parts.insert(
            2,
            section(
                "Bounds on every policy",
                "Gaps with their 95 % confidence intervals.",
                _bounds(told),
            ),
        )
    under = (
        f"{counted(len(made.outcomes), 'rehearsal')} by {made.policy}, seeds from "
        f"{told['seed']} · planned prize {number(made.plan.objective, 3)}"
    )
    return page("Rehearsals", made.instance.name, under, parts)


def _spreads(made: Rehearsals) -> str:
    """Charts of the spread between rehearsals."""
    charts: dict[str, tuple[Chart, set[Any]]] = {
        "Visits": (visits_spread(made), {len(each.course) for each in made.outcomes}),
        "ΔV": (delta_v_spread(made), {each.delta_v_m_s for each in made.outcomes}),
    }
    return "".join(
        f"<h3>{name}</h3>{drawn(chart, f'{name} of rehearsals')}"
        for name, (chart, ends) in charts.items()
        if len(ends) > 1
    )


def _distributions(told: Mapping[str, Any]) -> str:
    rows = []
    for key, name in (("prize", "prize"), ("last_day", "last day"), ("delta_v_m_s", "ΔV m/s")):
        rows.append(row((("", name), *_summary(told[key]))))
    for key, name in _SHARES.items():
        if told[key] is not None:
            rows.append(row((("", name), ("n", _share(told[key])), *[("n", "")] * 6)))
    return table("Distributions", [("figure", ""), *_HEADINGS], rows)


_SHARES = {
    "required_met": "all required met",
    "returned": "ended where planned",
    "as_planned": "as planned, but for captures",
}

_TITLES = "mean", "± standard error", "5 %", "25 %", "median", "75 %", "95 %"
_HEADINGS = tuple((title, "n") for title in _TITLES)


def _summary(of: Mapping[str, Any]) -> list[tuple[str, str]]:
    values = [of["mean"], of["standard_error"], *of["quantiles"].values()]
    return [("n", NOTHING if value is None else number(value, 4)) for value in values]


def _share(of: Mapping[str, Any]) -> str:
    return f"{fixed(100.0 * of['share'], 1)} %"


def _losses(told: Mapping[str, Any]) -> str:
    columns: list[Column] = [
        ("reason", "", lambda reason, mean: REASONS.get(reason, str(reason))),
        ("targets", "n", lambda reason, mean: fixed(mean, 3)),
    ]
    return table_of("Losses", columns, told["losses"].items())


def _targets(told: Mapping[str, Any]) -> str:
    columns: list[Column] = [
        ("target", "", lambda each: each["target"]),
        ("lost in", "n", _share),
        ("most often because", "", lambda each: REASONS.get(next(iter(each["reasons"])), "")),
    ]
    lost = ((each,) for each in told["lost_targets"][:MOST_TARGETS])
    return table_of("Targets most often lost", columns, lost)


def _tanks(told: Mapping[str, Any]) -> str:
    rows = [
        row(
            (
                ("", each["chaser"]),
                *(("n", str(each[name])) for name in ("tank", "flown")),
                ("n", _share(each["dry"])),
                *_summary(each["left_m_s"]),
            )
        )
        for each in told["tanks"]
    ]
    headings = (("chaser", ""), ("tank", "n"), ("flown", "n"), ("ran dry", "n"), *_HEADINGS)
    return table("Tanks", headings, rows)


def _bounds(told: Mapping[str, Any]) -> str:
    names = {"perfect": "perfect information", "penalised": "with penalties for the luck of draws"}
    columns: list[Column] = [
        ("bound", "", lambda name, of, gap: name),
        ("mean", "n", lambda name, of, gap: number(of["mean"], 4)),
        ("± standard error", "n", lambda name, of, gap: _error(of["standard_error"])),
        ("gap", "n", lambda name, of, gap: _percent(gap["gap"])),
        (
            "interval",
            "n",
            lambda name, of, gap: f"{_percent(gap['low'])} to {_percent(gap['high'])}",
        ),
    ]
    items = ((name, told["bounds"][key], told["gaps"][key]) for key, name in names.items())
    return table_of("Bounds on every policy", columns, items)


def _error(value: float | None) -> str:
    return NOTHING if value is None else number(value, 3)


def _percent(value: float | None) -> str:
    return NOTHING if value is None else f"{fixed(100.0 * value, 2)} %"
