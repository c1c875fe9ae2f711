"""The page of a study of designs: the Pareto front, a table, and the plan behind each point."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from ...analysis.design.designs import shown
from ...analysis.design.results import DesignPoint, DesignStudy
from ...analysis.trade.axes import KINDS
from ...common.constants import DAY_S
from ...common.wording import counted
from ...plan.plan import Leg
from ...plan.routes import routes_of
from ...sources.worth.answer import figure
from ..plot.fronts import MILLION, anchor, designs_chart
from . import plain
from .charts import drawn
from .plain import page, section
from .tables import Column, table_of
from .text import NOTHING, escape, fixed, number

CAPTION = "Avoided against euros"

NOTE = (
    "A dot for each design: the worth that its plan avoids, as a set, against the plan's cost; it "
    "links to the plan. The line joins the designs that no other dominates. The ring above a dot "
    "is the bound on all plans of that design."
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


Tell = Callable[[int, DesignPoint], str]
"""Function that writes a cell, from the place of a design and its point."""


def design_columns(study: DesignStudy) -> dict[str, Tell]:
    """Columns of a table of designs: varied limits and results, as texts."""

    def _varied(at_axis: int) -> Tell:
        return lambda at, point: shown(*point.design.values[at_axis])

    return {
        "design": lambda at, point: str(at + 1),
        **{
            f"{axis.kind} {KINDS[axis.kind].unit}".rstrip(): _varied(at_axis)
            for at_axis, axis in enumerate(study.axes)
        },
        "planned": lambda at, point: figure(point.floor) if point.plan else NOTHING,
        "avoided": lambda at, point: figure(point.worth) if point.plan else NOTHING,
        "at most": lambda at, point: figure(point.bound) if _bounded(point) else NOTHING,
        "gap": lambda at, point: f"{point.gap:.1%}" if _has_gap(point) else NOTHING,
        "M€": lambda at, point: fixed(point.euros / MILLION, 2) if point.plan else NOTHING,
        "per M€": lambda at, point: _unless_nan(point.per_million),
        "launches used": lambda at, point: str(point.launches),
        "removals": lambda at, point: str(point.removals),
        "front": lambda at, point: "yes" if at in study.front else "",
        "s": lambda at, point: fixed(point.runtime_s, 1),
    }


def _bounded(point: DesignPoint) -> bool:
    return math.isfinite(point.bound)


def _has_gap(point: DesignPoint) -> bool:
    return point.plan is not None and math.isfinite(point.gap)


def _unless_nan(value: float) -> str:
    return NOTHING if math.isnan(value) else fixed(value, 2)


def _unit(study: DesignStudy) -> str:
    return study.rating.unit or "prize"


def _table(study: DesignStudy) -> str:
    def _linked(at: int, point: DesignPoint) -> str:
        return f'<a href="#{anchor(at)}">{at + 1}</a>'

    def _escaped(tell: Tell) -> Tell:
        return lambda at, point: escape(tell(at, point))

    texts = {title: _escaped(tell) for title, tell in design_columns(study).items()}
    columns: list[Column] = [
        (title, "n", tell) for title, tell in (texts | {"design": _linked}).items()
    ]
    points = enumerate(study.points)
    return table_of("Designs", columns, points, lambda at, point: f'data-design="{at + 1}"')


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


def _legs(study: DesignStudy, at: int, point: DesignPoint) -> str:
    """A row for each leg of a plan, with the worth of its target."""
    assert point.plan is not None
    rated = study.rating.worths is not None
    columns: list[Column | bool] = [
        ("chaser", "", lambda chaser, leg: chaser),
        ("to", "", lambda chaser, leg: leg.destination),
        ("kind", "", lambda chaser, leg: leg.kind),
        ("departs day", "n", lambda chaser, leg: fixed(leg.departure_s / DAY_S, 1)),
        ("done day", "n", lambda chaser, leg: fixed(leg.done_s / DAY_S, 1)),
        ("ΔV m/s", "n", lambda chaser, leg: number(leg.spent_m_s, 1)),
        ("floor" if rated else "prize", "n", lambda _, leg: _worths(study, point, leg)[0]),
        rated and ("alone", "n", lambda _, leg: _worths(study, point, leg)[1]),
    ]
    legs = (
        (flown.chaser.name, leg)
        for flown in routes_of(point.instance, point.plan)
        for _, leg in flown.legs
    )
    return plain.table_of(f"Legs of design {at + 1}", columns, legs)


def _worths(study: DesignStudy, point: DesignPoint, leg: Leg) -> tuple[str, ...]:
    """Floor and worth alone of a leg's target, or its prize."""
    worths, body = study.rating.worths, leg.destination
    if body in point.instance.station_names:
        return (NOTHING,) if worths is None else (NOTHING, NOTHING)
    floor = figure(study.rating.floor_of(point.instance, [body]))
    return (floor,) if worths is None else (floor, figure(worths.of_set([body])))
