"""ΔV left against time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...common.constants import DAY_S
from ...fly.flight.flyable import refuse_foreign
from ...plan.palette import STATION, chaser_colours
from ...plan.plan import Plan
from ...plan.routes import Flown, routes_of, several
from ...problem.instance import Instance
from .axes import label, plain


@dataclass(frozen=True)
class Budget:
    """How the ΔV left goes down with every burn and up with every refuelling.

    Attributes
    ----------
    times_s : tuple of float
        When it changes, the epoch first [s].
    left_m_s : tuple of float
        What is left from then on [m/s].
    legs : tuple of int
        The leg of each change; 0 at the epoch.
    refuelled : tuple of bool
        Whether the change is a refuelling.
    """

    times_s: tuple[float, ...]
    left_m_s: tuple[float, ...]
    legs: tuple[int, ...]
    refuelled: tuple[bool, ...]


def budgets(instance: Instance, plan: Plan) -> dict[str, Budget]:
    """ΔV left after every burn of a plan, for each chaser by its name.

    The cost of matching eccentricity vectors has no burn; it is taken with the last one of a leg.
    A drift costs what its closed form says, and its burns take their shares of that.
    """
    refuse_foreign(instance, plan)
    return {flown.chaser.name: _of_chaser(instance, flown) for flown in routes_of(instance, plan)}


def budget(instance: Instance, plan: Plan) -> Budget:
    """The same where there is one chaser."""
    return budgets(instance, plan)[instance.chaser.name]


def _of_chaser(instance: Instance, flown: Flown) -> Budget:
    left = flown.aboard(instance)[0].left_m_s
    rows = [(0.0, left, 0, False)]
    for number, leg in flown.legs:
        after_leg = left - leg.delta_v_m_s
        share, burned = 1.0, leg.burns_delta_v_m_s
        if leg.traits.on_time_grid and burned > 0.0:
            share = (leg.delta_v_m_s - leg.eccentricity_delta_v_m_s) / burned
        for burn in leg.burns[:-1]:
            left -= share * burn.size_m_s
            rows.append((burn.time_s, left, number, False))
        rows.append((leg.arrival_s, after_leg, number, False))
        left = after_leg
        refuelled = leg.destination in instance.station_names
        if refuelled or leg.mass_kg is not None:
            left = leg.delta_v_left_m_s
            rows.append((leg.done_s, left, number, refuelled))
    return Budget(*zip(*rows, strict=True))


def delta_v_left(ax: Any, instance: Instance, plan: Plan) -> Any:
    """Add the ΔV left [m/s] against time [days], refuellings marked; a line for each chaser.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    instance : Instance
    plan : Plan

    Returns
    -------
    matplotlib.axes.Axes
    """
    colours = chaser_colours(instance)
    refuelled = []
    for name, course in budgets(instance, plan).items():
        days = [time / DAY_S for time in course.times_s]
        said = f"ΔV left, {plain(name)}" if several(instance) else "ΔV left"
        ax.step(days, course.left_m_s, where="post", color=colours[name], label=said)
        refuelled += [
            (day, left)
            for day, left, was in zip(days, course.left_m_s, course.refuelled, strict=True)
            if was
        ]
    ax.plot(
        [day for day, _ in refuelled], [left for _, left in refuelled],
        linestyle="none", marker="^", color=STATION, label="refuelling",
    )  # fmt: skip
    label(ax, "days since the epoch", "ΔV left [m/s]")
    return ax
