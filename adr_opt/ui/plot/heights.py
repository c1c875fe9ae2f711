"""Altitude against time."""

from __future__ import annotations

from typing import Any

from ...common.constants import DAY_S
from ...plan.palette import COLOURS, LABELS, PHASES, ZONE
from ...plan.plan import Plan
from ...problem.instance import Instance
from .axes import KM_M, label
from .tracks import joined, tracks


def altitude(ax: Any, instance: Instance, plan: Plan) -> Any:
    """Add the chaser's altitude [km] against time [days], one colour per phase.

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
        The plan belongs to another instance or cannot be flown.
    """
    found = tracks(instance, plan)
    for phase in PHASES:
        of_phase = [track for track in found if track.phase == phase]
        if of_phase:
            ax.plot(
                joined([track.times_s for track in of_phase]) / DAY_S,
                joined([track.altitudes_m for track in of_phase]) / KM_M,
                color=COLOURS[phase], linewidth=1.4, label=LABELS[phase],
            )  # fmt: skip
    label(ax, "days since the epoch", "altitude [km]")
    return ax


def keep_out_zones(ax: Any, instance: Instance) -> Any:
    """Add the keep-out zones as shaded boxes, altitude [km] against time [days].

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    instance : Instance

    Returns
    -------
    matplotlib.axes.Axes
    """
    for number, zone in enumerate(instance.keep_out_zones):
        ax.fill_between(
            [zone.start_s / DAY_S, zone.end_s / DAY_S],
            zone.min_altitude_m / KM_M, zone.max_altitude_m / KM_M,
            color=ZONE, alpha=0.25, linewidth=0.8,
            label="keep-out zone" if number == 0 else None,
        )  # fmt: skip
    label(ax, "days since the epoch", "altitude [km]")
    return ax
