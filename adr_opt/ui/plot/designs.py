"""What designs avoid and what none can exceed, against euros, with the Pareto front."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...plan.palette import CHASERS
from .chart import Chart, ChartAxis, Line, Link, Marks

if TYPE_CHECKING:
    from ...analysis.design.results import DesignStudy

MILLION = 1e6

FRONT, PLANS, BOUNDS = "Pareto front", "avoided by the plan of a design", "no plan avoids more"


def anchor(at: int) -> str:
    """Name of a design's section on a page, by its place in the study."""
    return f"design-{at + 1}"


def designs_chart(study: DesignStudy) -> Chart:
    """Worth of the chosen sets against euros: a dot for each design, and one for its bound."""
    points, front = study.points, study.front
    there = [at for at, point in enumerate(points) if point.plan is not None]
    euros = [points[at].euros / MILLION for at in there]
    links = [Link(f"#{anchor(at)}", f"{at + 1}: {points[at].design.title}") for at in there]
    series = (
        Line(
            name=FRONT,
            colour=CHASERS[0],
            width=2.0,
            step=True,
            x=[points[at].euros / MILLION for at in front],
            y=[points[at].worth for at in front],
        ),
        Marks(
            name=PLANS, colour=CHASERS[0], x=euros, y=[points[at].worth for at in there], of=links
        ),
        Marks(
            name=BOUNDS,
            colour=CHASERS[1],
            symbol="circle-open",
            size=7.0,
            x=euros,
            y=[points[at].bound for at in there],
        ),
    )
    unit = study.rating.unit
    return Chart(
        series, ChartAxis("million euros"), ChartAxis(f"{unit} avoided" if unit else "prize")
    )
