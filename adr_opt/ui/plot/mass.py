"""Masses of chasers against time: falling along arcs of thrust and tows."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from ...plan.cargo import Aboard
from ...plan.palette import chaser_colours
from ...plan.plan import Leg, Plan
from ...plan.routes import Flown, routes_of
from ...problem.chasers import TankByMass
from ...problem.instance import Instance
from .chart import DAYS, Chart, ChartAxis, Line, days
from .draw import draw

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
