"""ΔV leg by leg: what the plan counts with, and what its burns add up to."""

from __future__ import annotations

from typing import Any

from ...fly.flight.flyable import refuse_foreign
from ...plan.palette import COLOURS
from ...plan.plan import Plan
from ...problem.instance import Instance
from .axes import label

PLANNED, BURNED, REFINED = COLOURS["phasing"], COLOURS["terminal"], COLOURS["co-elliptic"]
BAR = 0.4


def leg_delta_v(ax: Any, instance: Instance, plan: Plan) -> Any:
    """Add two bars per leg: its planned ΔV and the sum of its burns [m/s].

    They differ by what is set aside for eccentricity, and where a leg drifts: then the plan counts
    with a closed form. Where connections are given there are no burns to be shown.

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
    refuse_foreign(instance, plan)
    legs = range(1, len(plan.legs) + 1)
    planned = [leg.delta_v_m_s for leg in plan.legs]
    burned = [leg.burns_delta_v_m_s for leg in plan.legs]
    if instance.transfer.given is not None:
        ax.bar(legs, planned, BAR, color=PLANNED, label="given")
        label(ax, "leg", "ΔV [m/s]")
        return ax
    ax.bar([n - BAR / 2 for n in legs], planned, BAR, color=PLANNED, label="planned")
    ax.bar([n + BAR / 2 for n in legs], burned, BAR, color=BURNED, label="burns")
    label(ax, "leg", "ΔV [m/s]")
    return ax
