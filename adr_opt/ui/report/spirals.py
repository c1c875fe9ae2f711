"""Arcs of chasers with low thrust, by which the page moves them.

A plan of low thrust states orbits, and not where on them a chaser is: laps are many, and a small
change of the drift orbit turns it to any place. On the page a chaser leaves from where its origin
is and drifts by what it takes to meet its target, at most half a revolution in all.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import groupby
from typing import Any

import numpy as np

from ...common.constants import MU_M3_S2
from ..plot.thrust_arcs import SpiralArc

STEERED = "drift"
"""Phase in which the argument of latitude is turned to that of the target."""

SAME_RAD = 1e-6
"""Difference of arguments of latitude up to which a chaser is at a body."""


def spirals(arcs: Iterable[SpiralArc], latitude: float | None) -> list[list[Any]]:
    """Arcs of a chaser, in order of time, as lists for the script of the page.

    ``latitude`` is the argument of latitude of its origin where its first arc begins [rad]; None if
    it is launched to its first target.

    Each list has the number of the leg, phase, begin and end [s], speed of the circular orbit and
    its rate [m/s, m/s²], inclination, node and argument of latitude with their rates [rad, rad/s],
    and middle and half width of the windows of thrust [rad], or None. The argument of latitude
    moves by v³/μ, and by its rate in addition.
    """
    made: list[list[Any]] = []
    for _, group in groupby(arcs, key=lambda arc: arc.leg):
        mine = list(group)
        extra = _steering(mine, latitude)
        for arc in mine:
            latitude, line = _line(arc, latitude, extra)
            made.append(line)
    return made


def turned_rad(arc: SpiralArc) -> float:
    """How far the argument of latitude moves on circles along an arc: the integral of v³/μ."""
    first, last = arc.speeds_m_s
    cubes = last**3 + last**2 * first + last * first**2 + first**3
    return float(_duration_s(arc) * cubes / (4.0 * MU_M3_S2))


def _duration_s(arc: SpiralArc) -> float:
    return float(arc.times_s[-1] - arc.times_s[0])


def _line(arc: SpiralArc, latitude: float | None, extra_rad_s: float) -> tuple[float, list[Any]]:
    """The argument of latitude at the end of an arc, and its list."""
    duration_s, rate = _duration_s(arc), extra_rad_s if arc.phase == STEERED else 0.0
    begin = latitude or 0.0
    if arc.latitudes_rad is not None:
        rate = float(np.ptp(arc.latitudes_rad) - turned_rad(arc)) / duration_s
        if latitude is None or not _leaves(arc, latitude):
            begin = float(arc.latitudes_rad[0])
    changes = [
        value
        for pair in (arc.speeds_m_s, arc.inclinations_rad, np.radians(arc.nodes_deg))
        for value in (float(pair[0]), float(pair[1] - pair[0]) / duration_s)
    ]
    window = [None, None] if arc.window_rad is None else arc.window_rad.tolist()
    line = [
        arc.leg,
        arc.phase,
        float(arc.times_s[0]),
        float(arc.times_s[-1]),
        *changes,
        math.fmod(begin, 2.0 * math.pi),
        rate,
        *window,
    ]
    return begin + turned_rad(arc) + rate * duration_s, line


def _leaves(arc: SpiralArc, latitude: float) -> bool:
    """Whether a chaser waits where a tow has left it, which is at no body."""
    if arc.phase != "wait" or arc.latitudes_rad is None:
        return False
    return abs(_away(float(arc.latitudes_rad[0]), latitude)) > SAME_RAD


def _steering(arcs: list[SpiralArc], latitude: float | None) -> float:
    """Rate that turns a chaser on its drift orbit so that it meets its target [rad/s]."""
    steered_s = math.fsum(_duration_s(arc) for arc in arcs if arc.phase == STEERED)
    at = next((at for at, arc in enumerate(arcs) if arc.phase == "thrust"), None)
    if at is None or not steered_s:
        return 0.0
    for arc in arcs[:at]:
        latitude, _ = _line(arc, latitude, 0.0)
    here = latitude or 0.0
    for arc in arcs[at:]:
        if arc.latitudes_rad is not None:
            return _away(float(arc.latitudes_rad[0]), here) / steered_s
        here += turned_rad(arc)
    return 0.0


def _away(to: float, since: float) -> float:
    """Angle from one direction to another, within half a turn [rad]."""
    return math.remainder(to - since, 2.0 * math.pi)
