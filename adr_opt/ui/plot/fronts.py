"""Charts of fronts: what plans collect against limits, and against euros."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from ...analysis.trade.axes import KINDS
from ...plan.palette import CHASERS
from .chart import Chart, ChartAxis, Line, Link, Marks, draw

if TYPE_CHECKING:
    from ...analysis.design.results import DesignStudy
    from ...analysis.trade.points import Tradeoff


class Spot(NamedTuple):
    """A point of a study: its place across, what its plan collects, the bound, and a link.

    It collects −inf without a plan.
    """

    x: float
    y: float
    bound: float
    of: Link | None = None


def tradeoff_chart(made: Tradeoff, kind: str) -> Chart:
    """Prizes of the best plans against a limit, with bands up to the bounds or the sum of prizes.

    There is a line for each combination of the values of the other axes.
    """
    others = [axis.kind for axis in made.axes if axis.kind != kind]
    most = math.fsum(target.greatest_prize for target in made.instance.targets)
    rows = {
        named(others, values): [
            Spot(point.value(kind) / KINDS[kind].scale, point.prize, min(point.upper_bound, most))
            for point in row
        ]
        for values, row in made.along(kind).items()
    }
    return bands_chart(rows, KINDS[kind].title)


def bands_chart(rows: Mapping[str, Sequence[Spot]], title: str) -> Chart:
    """Rows of plans with bands up to their bounds, against a limit of some title."""
    lines = []
    for at, (name, row) in enumerate(rows.items()):
        there = [spot for spot in row if math.isfinite(spot.y)]
        lines.append(
            Line(
                name=name if len(rows) > 1 else "plans, and up to the bound",
                colour=CHASERS[at % len(CHASERS)],
                width=2.0,
                dots=True,
                x=[spot.x for spot in there],
                y=[spot.y for spot in there],
                below=[spot.bound for spot in there],
                of=[spot.of for spot in there],
            )
        )
    return Chart(tuple(lines), ChartAxis(title), ChartAxis("prize"))


def named(kinds: Iterable[str], values: Iterable[float]) -> str:
    """Limits and their values, in SI units."""
    pairs = ((KINDS[kind], value) for kind, value in zip(kinds, values, strict=True))
    return ", ".join(f"{kind.name} {value / kind.scale:,g} {kind.unit}" for kind, value in pairs)


def tradeoff(ax: Any, made: Tradeoff, kind: str | None = None) -> Any:
    """Add prizes of the best plans, with a band up to the bounds; a line for each value of others.

    Where nothing is proven the band reaches up to all prizes.

    Parameters
    ----------
    made : Tradeoff
    kind : {"delta-v", "propellant", "duration", "thrust", "isp"}, optional
        What goes along the axis; the first that is varied by default.
    """
    return draw(ax, tradeoff_chart(made, kind or made.axes[0].kind))


MILLION = 1e6

FRONT, PLANS, BOUNDS = "Pareto front", "avoided by the plan of a design", "no plan avoids more"


def anchor(at: int) -> str:
    """Name of a design's section on a page, by its place in the study."""
    return f"design-{at + 1}"


def designs_chart(study: DesignStudy) -> Chart:
    """Worth of the chosen sets against euros: a dot for each design, and one for its bound."""
    spots = {
        at: Spot(
            point.euros / MILLION,
            point.worth,
            point.bound,
            Link(f"#{anchor(at)}", f"{at + 1}: {point.design.title}"),
        )
        for at, point in enumerate(study.points)
        if point.plan is not None
    }
    unit = study.rating.unit
    title = f"{unit} avoided" if unit else "prize"
    return front_chart([spots[at] for at in study.front], list(spots.values()), title)


def front_chart(front: Sequence[Spot], there: Sequence[Spot], title: str) -> Chart:
    """Designs with plans against million euros, and the front of the best of them."""
    x = [spot.x for spot in there]
    series = (
        Line(
            name=FRONT,
            colour=CHASERS[0],
            width=2.0,
            step=True,
            x=[spot.x for spot in front],
            y=[spot.y for spot in front],
        ),
        Marks(
            name=PLANS,
            colour=CHASERS[0],
            x=x,
            y=[spot.y for spot in there],
            of=[spot.of for spot in there],
        ),
        Marks(
            name=BOUNDS,
            colour=CHASERS[1],
            symbol="circle-open",
            size=7.0,
            x=x,
            y=[spot.bound for spot in there],
        ),
    )
    return Chart(series, ChartAxis("million euros"), ChartAxis(title))
