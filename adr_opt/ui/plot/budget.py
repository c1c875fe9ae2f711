"""ΔV and masses: remainders against time, and the cost of each leg."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from ...plan.cargo import Aboard
from ...plan.leg_kinds import GIVEN, LOW_THRUST
from ...plan.palette import STATION, chaser_colours
from ...plan.phases import COLOURS
from ...plan.plan import Leg, Plan
from ...plan.refined_plan import RefinedPlan
from ...plan.routes import Flown, routes_of, several
from ...problem.chasers import TankByMass
from ...problem.instance import Instance
from .chart import DAYS, Chart, ChartAxis, Columns, Line, Marks, days, draw

Knot = tuple[int, float, float]
"""Number of a leg, time [s] and mass [kg]."""


def masses(instance: Instance, plan: Plan) -> dict[str, tuple[Knot, ...]]:
    """Mass of each chaser that has a tank by mass and flies, linear between knots, by its name.

    Propellant and kits included. It falls uniformly along arcs of thrust and tows, at once with
    impulses, which are taken together at the arrival, and where a kit is left behind; it rises
    where the tank is filled.
    """
    plan.instance.refuse_other(instance)
    return {
        flown.chaser.name: tuple(_knots(instance, flown))
        for flown in routes_of(instance, plan)
        if isinstance(flown.chaser.tank, TankByMass) and flown.legs
    }


def _knots(instance: Instance, flown: Flown) -> Iterator[Knot]:
    stages = flown.aboard(instance)
    exhaust_m_s = flown.chaser.tank.exhaust_m_s
    number, first = flown.legs[0]
    yield number, first.ready_s, stages[0].mass_kg or 0.0
    departing = flown.departing_kg(instance)
    for (number, leg), before_kg, after in zip(flown.legs, departing, stages[1:], strict=False):
        for time_s, mass_kg in _of_leg(leg, exhaust_m_s, before_kg, after):
            yield number, time_s, mass_kg


def _of_leg(
    leg: Leg, exhaust_m_s: float, mass_kg: float, after: Aboard
) -> Iterator[tuple[float, float]]:
    """Times and masses from the departure to the end of the tow."""
    if leg.manoeuvres is None:
        yield leg.arrival_s, mass_kg
        mass_kg *= math.exp(-leg.delta_v_m_s / exhaust_m_s)
        yield leg.arrival_s, mass_kg
    for arc in leg.manoeuvres or ():
        yield arc.start_s, mass_kg
        mass_kg *= math.exp(-arc.delta_v_m_s / exhaust_m_s)
        yield arc.end_s, mass_kg
    yield leg.end_s, mass_kg
    done_kg = after.mass_kg or 0.0
    yield leg.end_s, done_kg + after.removal_kg
    if leg.tow is not None:
        yield leg.tow.start_s, done_kg + after.removal_kg
        yield leg.tow.end_s, done_kg


def mass_chart(instance: Instance, plan: Plan) -> Chart:
    """Masses [kg] against days, a line per chaser."""
    colours = chaser_colours(instance)
    lines = [
        Line(
            name=name,
            colour=colours[name],
            x=days([time_s for _, time_s, _ in knots]),
            y=[mass_kg for _, _, mass_kg in knots],
            legs=[leg for leg, _, _ in knots],
            of=[(leg, time_s) for leg, time_s, _ in knots],
        )
        for name, knots in masses(instance, plan).items()
    ]
    return Chart(tuple(lines), DAYS, ChartAxis("mass [kg]"))


def mass(ax: Any, instance: Instance, plan: Plan) -> Any:
    """Add the mass of each chaser [kg] against time [days], propellant and kits included.

    Raises
    ------
    InputError
        The plan belongs to another instance.
    """
    return draw(ax, mass_chart(instance, plan))


PLANNED, BURNED, REFINED = COLOURS["phasing"], COLOURS["terminal"], COLOURS["co-elliptic"]
MENDED = COLOURS["approach"]


def has_burns(plan: Plan) -> bool:
    """Whether a plan's burns can be compared with its costs: it has burns, or no legs."""
    kinds = {leg.kind for leg in plan.legs}
    without = {GIVEN.name, LOW_THRUST.name} & kinds
    return not without or any(leg.impulses for leg in plan.legs)


def costs_chart(plan: Plan, refined: RefinedPlan | None = None) -> Chart:
    """ΔV [m/s] of each leg: planned, in burns and, for a refined plan, as flown.

    Burns are left out where the plan has none. Where legs were refined onto ephemerides, the plan's
    own burns are shown, too, as they lead to where bodies are said to be.
    """
    shown = [("planned", PLANNED, [leg.delta_v_m_s for leg in plan.legs])]
    if has_burns(plan):
        shown.append(("burns", BURNED, [leg.burns_delta_v_m_s for leg in plan.legs]))
    numbers = range(1, len(plan.legs) + 1)
    if refined is not None:
        known = {leg.leg: leg for leg in refined.legs}
        onto = refined.ephemerides is not None
        if onto:
            own = {at: leg.retargeted_delta_v_m_s for at, leg in known.items()}
            shown.append(
                ("burns onto ephemerides", MENDED, [own.get(at, math.nan) for at in numbers])
            )
        flown = {at: leg.flown_delta_v_m_s for at, leg in known.items()}
        name = "refined onto ephemerides" if onto else "refined"
        shown.append((name, REFINED, [flown.get(at, math.nan) for at in numbers]))
    columns = (
        Columns(name=name, colour=colour, x=numbers, y=values, legs=numbers, of=plan.legs)
        for name, colour, values in shown
    )
    return Chart(tuple(columns), ChartAxis("leg", 0), ChartAxis("ΔV [m/s]"))


def leg_delta_v(ax: Any, instance: Instance, plan: Plan) -> Any:
    """Add two bars per leg: its planned ΔV and the sum of its burns [m/s].

    They differ by what is set aside for eccentricity, and where a leg drifts: then the plan counts
    with a closed form. Where connections are given or legs are of low thrust, there are no burns to
    be shown.

    Raises
    ------
    InputError
        The plan belongs to another instance.
    """
    plan.instance.refuse_other(instance)
    return draw(ax, costs_chart(plan))


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


def _of_chaser(instance: Instance, flown: Flown) -> Budget:
    left = flown.aboard(instance)[0].left_m_s
    rows = [(0.0, left, 0, False)]
    for number, leg in flown.legs:
        after_leg = left - leg.delta_v_m_s
        share, burned = 1.0, leg.burns_delta_v_m_s
        aside = leg.eccentricity_delta_v_m_s
        # Free burns take less than those that are planned between circles.
        if (leg.traits.on_time_grid or aside < 0.0) and burned > 0.0:
            share = (leg.delta_v_m_s - max(aside, 0.0)) / burned
        for burn in leg.impulses[:-1]:
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
