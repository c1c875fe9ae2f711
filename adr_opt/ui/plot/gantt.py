"""The timeline as a Gantt chart."""

from __future__ import annotations

from typing import Any

from ...common.constants import DAY_S
from ...plan.palette import COLOURS, LABELS, PHASES
from ...plan.plan import Plan
from ...plan.routes import routes_of, several
from ...problem.instance import Instance
from .axes import label, plain
from .segments import segments


def gantt(ax: Any, instance: Instance, plan: Plan) -> Any:
    """Add one row per leg, its phases as bars against time [days]; the first leg is on top.

    Where there are several chasers, the first leg of each has its name beside the destination.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    instance : Instance
    plan : Plan

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    InputError
        The plan belongs to another instance.
    """
    found = segments(instance, plan)
    for phase in PHASES:
        bars = [segment for segment in found if segment.phase == phase]
        if bars:
            ax.barh(
                [bar.leg for bar in bars],
                [bar.duration_s / DAY_S for bar in bars],
                left=[bar.start_s / DAY_S for bar in bars],
                color=COLOURS[phase], label=LABELS[phase],
            )  # fmt: skip
    if plan.legs:
        names = [plain(leg.destination) for leg in plan.legs]
        for flown in routes_of(instance, plan) if several(instance) else ():
            for number, leg in flown.legs[:1]:
                names[number - 1] = plain(f"{flown.chaser.name}: {leg.destination}")
        ax.set_yticks(range(1, len(names) + 1), labels=names)
        ax.set_ylim(len(names) + 0.5, 0.5)
    label(ax, "days since the epoch", "destination")
    return ax
