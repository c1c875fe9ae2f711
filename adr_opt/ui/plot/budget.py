"""Remaining ΔV against time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...plan.palette import STATION, chaser_colours
from ...plan.plan import Plan
from ...plan.routes import Flown, routes_of, several
from ...problem.instance import Instance
from .chart import DAYS, Chart, ChartAxis, Line, Marks, days
from .draw import draw

LEFT = "ΔV left"


@dataclass(frozen=True)
class Budget:
    """Remaining ΔV as a step function, with every burn and every refuelling.

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
    """Remaining ΔV after every burn of a plan, by name of the chaser.

    The cost of matching eccentricity vectors has no burn; it is taken with the last one of a leg.
    A drift costs what its closed form says, and its burns take their shares of that.
    """
    plan.instance.refuse_other(instance)
    return {flown.chaser.name: _of_chaser(instance, flown) for flown in routes_of(instance, plan)}


def budget(instance: Instance, plan: Plan) -> Budget:
    """Remaining ΔV after every burn, for an instance with one chaser."""
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


def budget_chart(instance: Instance, plan: Plan) -> Chart:
    """Remaining ΔV [m/s] against days: a line per chaser, and a mark at every refuelling."""
    colours, found = chaser_colours(instance), budgets(instance, plan)
    lines = [
        Line(
            name=name if several(instance) else LEFT,
            colour=colours[name],
            step=True,
            x=days(course.times_s),
            y=course.left_m_s,
            legs=course.legs,
            of=list(zip(course.legs, course.times_s, strict=True)),
        )
        for name, course in found.items()
    ]
    stops = [
        (course.times_s[at], course.left_m_s[at], course.legs[at], colours[name])
        for name, course in found.items()
        for at, refuelled in enumerate(course.refuelled)
        if refuelled
    ]
    times_s, left_m_s, legs, whose = zip(*stops, strict=True) if stops else ((),) * 4
    marks = Marks(
        name="refuelling",
        colour=STATION,
        symbol="triangle-up",
        size=10.0,
        colours=whose if several(instance) else (),
        x=days(times_s),
        y=left_m_s,
        legs=legs,
        of=list(zip(legs, times_s, strict=True)),
    )
    return Chart((*lines, marks), DAYS, ChartAxis(f"{LEFT} [m/s]"))


def delta_v_left(ax: Any, instance: Instance, plan: Plan) -> Any:
    """Add remaining ΔV [m/s] against time [days], with refuellings marked; a line per chaser."""
    return draw(ax, budget_chart(instance, plan))
