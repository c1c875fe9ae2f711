"""Cards of studies of designs, and of their points."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ...common.card import Card, CardTable
from ...common.wording import counted

if TYPE_CHECKING:
    from ...analysis.design import DesignPoint, DesignStudy


def of_study(study: DesignStudy) -> Card:
    """The card of a study; on a page, with its points."""
    varied = " and ".join(
        f"{axis.kind} ({counted(len(axis.values), 'value')})" for axis in study.axes
    )
    facts = (
        varied,
        f"{len(study.points)} of {counted(study.wanted, 'design')}",
        f"{len(study.front)} on the front",
        f"{study.runtime_s:.3g} s",
    )
    front = study.front
    rows = [
        (point.design.title, *_worths(point), _millions(point), "yes" if at in front else "")
        for at, point in enumerate(study.points)
    ]
    heads = ("design", "planned", "avoided", "at most", "M€", "front")
    return Card("DesignStudy", f"of {study.instance.name!r}", facts, (), (CardTable(heads, rows),))


def of_point(point: DesignPoint) -> Card:
    """The card of a point."""
    _, worth, bound = _worths(point)
    facts = (
        f"{worth} avoided of at most {bound}",
        f"{_millions(point)} million euros",
        counted(point.launches, "launch", "launches"),
        counted(point.removals, "removal"),
    )
    return Card("DesignPoint", f"at {point.design.title}", facts)


def _worths(point: DesignPoint) -> tuple[str, str, str]:
    values = [f"{value:,.6g}" for value in (point.floor, point.worth)]
    return values[0], values[1], f"{point.bound:,.6g}" if math.isfinite(point.bound) else "–"


def _millions(point: DesignPoint) -> str:
    return f"{point.euros / 1e6:,.2f}"
