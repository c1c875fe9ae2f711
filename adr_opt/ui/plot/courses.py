"""Plots along the courses of chasers: altitude, nodes, and the path in space."""

from __future__ import annotations

from typing import Any

from ...plan.plan import Plan
from ...problem.instance import Instance
from .draw import draw
from .heights import altitude_chart
from .nodes import nodes_chart
from .space import drawn_in_space, path_lines
from .strands import DrawnArc
from .thrust_arcs import thrust_arcs
from .tracks import tracks


def arcs_of(instance: Instance, plan: Plan) -> tuple[DrawnArc, ...]:
    """A plan ready to be drawn: flown, or with low thrust read off its arcs.

    Raises
    ------
    InputError
        The plan belongs to another instance, or leads nowhere.
    """
    return thrust_arcs(instance, plan) if instance.has_low_thrust else tracks(instance, plan)


def altitude(ax: Any, instance: Instance, plan: Plan) -> Any:
    """Add the chaser's altitude [km] against time [days], one colour per phase.

    Raises
    ------
    InputError
        The plan belongs to another instance or cannot be flown.
    """
    found = arcs_of(instance, plan)
    return draw(ax, altitude_chart(instance, plan, found, by_chaser=False))


def nodes(ax: Any, instance: Instance, plan: Plan | None = None) -> Any:
    """Add RAAN [deg] against time [days], relative to the bodies' common drift.

    Targets are thin lines. With a plan, those that it visits differ from the others, and thick
    lines, one colour per phase, follow the chaser: on a drift orbit its node crosses to the next.

    Raises
    ------
    InputError
        The plan belongs to another instance or cannot be flown.
    """
    if plan is not None:
        plan.instance.refuse_other(instance)
    found = () if plan is None else arcs_of(instance, plan)
    return draw(ax, nodes_chart(instance, plan, found, by_chaser=False))


def path(ax: Any, instance: Instance, plan: Plan) -> Any:
    """Add the chaser's path in the inertial frame [km], one colour per phase.

    Raises
    ------
    InputError
        The plan belongs to another instance or cannot be flown.
    """
    found = arcs_of(instance, plan)
    return drawn_in_space(ax, path_lines(instance, plan, found, 1.1, by_chaser=False))
