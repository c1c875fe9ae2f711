"""The page of a study of designs: the Pareto front, a table, and the plan behind each point."""

from __future__ import annotations

import math
from collections.abc import Mapping

from ...analysis.design.designs import shown
from ...analysis.design.point import DesignPoint
from ...analysis.design.results import DesignStudy
from ...analysis.trade.axes import KINDS
from ...common.constants import DAY_S
from ...common.wording import counted
from ...plan.plan import Leg
from ...plan.routes import routes_of
from ...sources.worth.answer import figure
from ..plot.studies import MILLION, anchor, designs_chart
from . import tables
from .charts import drawn
from .plain import page, row, section
from .tables import table
from .text import NOTHING, escape, fixed, number

CAPTION = "Avoided against euros"

NOTE = (
    "A dot for each design: what its plan avoids, as a set, against what the plan costs; it leads "
    "to the plan. The line joins the designs that no other one beats in both. The ring above a dot "
    "is what no plan of that design can exceed."
)

THREE = (
    "Planned: the sum of floors, which add up, and with which plans are made. Avoided: what "
    "removing the chosen objects as a set avoids, where pairs within the set count once. At most: "
    "proven with worths alone, for any plan of the design."
)

OF_PRIZES = "Prizes of the instance add up: what is planned is what is collected."

Links = Mapping[int, Mapping[str, str]]
"""Files of designs, by their place: addresses relative to the page, by what they are."""


def designs_page(study: DesignStudy, links: Links | None = None) -> str:
    """The HTML of the page.

    Parameters
    ----------
    study : DesignStudy
    links : mapping, optional
        Files behind each point.
    """
    rated = study.rating.worths is not None
    notes = [THREE if rated else OF_PRIZES, f"Prices in euros: {study.prices}."]
    if study.total:
        notes.append(
            f"All pairs of the catalogue together are worth {figure(study.total)} {_unit(study)}."
        )
    if study.rating.left_out:
        count = counted(len(study.rating.left_out), "target")
        notes.append(f"Left out, as no worth is known: {count}.")
    parts = [
        section(CAPTION, NOTE, drawn(designs_chart(study), CAPTION)),
        section("Designs", " ".join(notes), _table(study)),
    ]
    parts += [
        _behind(study, at, point, (links or {}).get(at, {}))
        for at, point in enumerate(study.points)
    ]
    under = (
        f"{len(study.points)} of {counted(study.wanted, 'design')} · {len(study.front)} on the "
        f"front · {study.runtime_s:.1f} s"
    )
    return page("Designs", study.instance.name, under, parts)


def headings(study: DesignStudy) -> tuple[str, ...]:
    """Headings of a table of designs: what is varied, and results."""
    varied = [f"{axis.kind} {KINDS[axis.kind].unit}".rstrip() for axis in study.axes]
    return ("design", *varied, *RESULTS)


RESULTS = (
    "planned",
    "avoided",
    "at most",
    "gap",
    "M€",
    "per M€",
    "launches used",
    "removals",
    "front",
    "s",
)


def cells(study: DesignStudy, at: int) -> tuple[str, ...]:
    """A design as texts, under :func:`headings`."""
    point, front = study.points[at], study.front
    there = point.plan is not None
    return (
        str(at + 1),
        *(shown(kind, value) for kind, value in point.design.values),
        figure(point.floor) if there else NOTHING,
        figure(point.worth) if there else NOTHING,
        figure(point.bound) if math.isfinite(point.bound) else NOTHING,
        f"{point.gap:.1%}" if there and math.isfinite(point.gap) else NOTHING,
        fixed(point.euros / MILLION, 2) if there else NOTHING,
        NOTHING if math.isnan(point.per_million) else fixed(point.per_million, 2),
        str(point.launches),
        str(point.removals),
        "yes" if at in front else "",
        fixed(point.runtime_s, 1),
    )


def _unit(study: DesignStudy) -> str:
    return study.rating.unit or "prize"


def _table(study: DesignStudy) -> str:
    rows = []
    for at in range(len(study.points)):
        number_of, *others = (escape(text) for text in cells(study, at))
        link = f'<a href="#{anchor(at)}">{number_of}</a>'
        rows.append(
            tables.row((("n", text) for text in (link, *others)), f'data-design="{at + 1}"')
        )
    return table("Designs", [(title, "n") for title in headings(study)], rows)


def _behind(study: DesignStudy, at: int, point: DesignPoint, files: Mapping[str, str]) -> str:
    """The plan behind a point."""
    title = f"Design {at + 1}: {point.design.title}"
    if point.plan is None:
        cheap = point.bound == 0.0 and point.design.value("budget") is not None
        said = "No launch is within the budget." if cheap else "No plan was found."
        return f'<div id="{anchor(at)}">{section(title, said, "")}</div>'
    said = (
        f"{figure(point.worth)} {_unit(study)} avoided for {fixed(point.euros / MILLION, 2)} "
        f"million euros, with {counted(point.launches, 'launch', 'launches')} and "
        f"{counted(point.removals, 'removal')}; at most {figure(point.bound)}."
    )
    linked = " · ".join(
        f'<a href="{escape(address)}">{escape(what)}</a>' for what, address in files.items()
    )
    more = f"<p>{linked}</p>" if linked else ""
    return f'<div id="{anchor(at)}">{section(title, said, more + _legs(study, at, point))}</div>'


LEGS = ("chaser", "to", "kind", "departs day", "done day", "ΔV m/s")
KINDS_OF_LEGS = ("", "", "", "n", "n", "n", "n", "n")
"""Headings of the table of a plan's legs, and classes of its columns."""


def _legs(study: DesignStudy, at: int, point: DesignPoint) -> str:
    """A row for each leg of a plan, with the worth of its target."""
    assert point.plan is not None
    rows = [
        row(
            zip(
                KINDS_OF_LEGS,
                (*_leg(flown.chaser.name, leg), *_worths(study, point, leg)),
                strict=False,
            )
        )
        for flown in routes_of(point.instance, point.plan)
        for _, leg in flown.legs
    ]
    last = ("prize",) if study.rating.worths is None else ("floor", "alone")
    titles = (*LEGS, *last)
    return table(f"Legs of design {at + 1}", list(zip(titles, KINDS_OF_LEGS, strict=False)), rows)


def _leg(chaser: str, leg: Leg) -> tuple[str, ...]:
    return (
        chaser,
        leg.destination,
        leg.kind,
        fixed(leg.departure_s / DAY_S, 1),
        fixed(leg.done_s / DAY_S, 1),
        number(leg.spent_m_s, 1),
    )


def _worths(study: DesignStudy, point: DesignPoint, leg: Leg) -> tuple[str, ...]:
    """Floor and worth alone of a leg's target, or its prize."""
    worths, body = study.rating.worths, leg.destination
    if body in point.instance.station_names:
        return (NOTHING,) if worths is None else (NOTHING, NOTHING)
    floor = figure(study.rating.floor_of(point.instance, [body]))
    return (floor,) if worths is None else (floor, figure(worths.of_set([body])))
