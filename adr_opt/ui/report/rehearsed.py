"""The page of rehearsals: fans over time, losses, tanks and gaps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...analysis.rehearse.rehearsals import Rehearsals
from ...common.wording import counted
from ..plot.studies import delta_v_fan, prize_fan
from .charts import drawn
from .plain import page, row, section
from .tables import table
from .text import NOTHING, fixed, number

MOST_TARGETS = 25
"""Maximum number of lost targets in the table."""

REASONS = {
    "capture": "no try at the capture succeeded",
    "gone": "the target was gone",
    "dry": "a tank ran dry",
    "late": "a service did not end in time",
    "delta-v": "the next leg could not be paid",
    "duration": "there was no connection in time",
    "capacity": "no kit was left, or the maximum of targets was reached",
    "left-out": "the policy left it out",
    "rules": "the policy chose a leg that no plan may have",
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
        section("Distributions", "", _distributions(told)),
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

_HEADINGS = (
    ("mean", "n"),
    ("± standard error", "n"),
    ("5 %", "n"),
    ("25 %", "n"),
    ("median", "n"),
    ("75 %", "n"),
    ("95 %", "n"),
)


def _summary(of: Mapping[str, Any]) -> list[tuple[str, str]]:
    values = [of["mean"], of["standard_error"], *of["quantiles"].values()]
    return [("n", NOTHING if value is None else number(value, 4)) for value in values]


def _share(of: Mapping[str, Any]) -> str:
    return f"{fixed(100.0 * of['share'], 1)} %"


def _losses(told: Mapping[str, Any]) -> str:
    rows = [
        row((("", REASONS.get(reason, reason)), ("n", fixed(mean, 3))))
        for reason, mean in told["losses"].items()
    ]
    return table("Losses", (("reason", ""), ("targets", "n")), rows)


def _targets(told: Mapping[str, Any]) -> str:
    rows = [
        row(
            (
                ("", each["target"]),
                ("n", f"{fixed(100.0 * each['share'], 1)} %"),
                ("", REASONS.get(next(iter(each["reasons"])), "")),
            )
        )
        for each in told["lost_targets"][:MOST_TARGETS]
    ]
    headings = (("target", ""), ("lost in", "n"), ("most often because", ""))
    return table("Targets most often lost", headings, rows)


def _tanks(told: Mapping[str, Any]) -> str:
    rows = [
        row(
            (
                ("", each["chaser"]),
                ("n", str(each["tank"])),
                ("n", str(each["flown"])),
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
    rows = []
    for key, name in names.items():
        of, gap = told["bounds"][key], told["gaps"][key]
        rows.append(
            row(
                (
                    ("", name),
                    ("n", number(of["mean"], 4)),
                    (
                        "n",
                        NOTHING
                        if of["standard_error"] is None
                        else number(of["standard_error"], 3),
                    ),
                    ("n", _percent(gap["gap"])),
                    ("n", f"{_percent(gap['low'])} to {_percent(gap['high'])}"),
                )
            )
        )
    headings = (
        ("bound", ""),
        ("mean", "n"),
        ("± standard error", "n"),
        ("gap", "n"),
        ("interval", "n"),
    )
    return table("Bounds on every policy", headings, rows)


def _percent(value: float | None) -> str:
    return NOTHING if value is None else f"{fixed(100.0 * value, 2)} %"
