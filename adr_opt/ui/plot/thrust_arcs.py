"""Courses of chasers with low thrust, from the arcs of their legs and the spirals of tows.

Legs of low thrust have no burns. Along an arc of thrust speed and inclination change uniformly
(docs/model.md section 11), and the node by what is thrust and by what drifts meanwhile. Where one
arc ends and the other begins is the drift orbit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2
from ...common.errors import InputError
from ...kernels.orbits import elements, ephemeris
from ...plan.after_tows import leaving_orbits
from ...plan.plan import Leg, LowThrustArc, Plan
from ...plan.routes import Flown, routes_of
from ...problem.drives import Drive, drive_of
from ...problem.instance import Instance
from .gantt import Segment, segments
from .strands import POINTS_OF_A_RING, Array, DrawnArc, joined

PIECES = 12
"""Number of pieces in which an arc of thrust or a tow is drawn."""

POINTS_OF_A_WINDOW = 16

DRAWN_AROUND = {"thrust": PIECES // 3, "tow": PIECES // 2, "drift": 1}
"""Stride of the pieces of a phase that are drawn around the Earth; all pieces would hide each
other, and phases at a body are points."""


class Circles(NamedTuple):
    """Circular orbits over time: speeds [m/s], inclinations and nodes [rad], shape (times,)."""

    speeds: Array
    inclinations: Array
    nodes: Array


@dataclass(frozen=True)
class SpiralArc(DrawnArc):
    """A piece of a course along which speed, inclination and node change uniformly.

    Attributes
    ----------
    speeds_m_s, inclinations_rad : (2,) float64
        Of the circular orbit at the first and the last of the times.
    latitudes_rad : (2,) float64 or None
        Arguments of latitude there, without a jump, of the body that the chaser is at; None if it
        is under way.
    window_rad : (2,) float64 or None
        Middle and half width of one of the two windows in which thrust is on, but for the shadow;
        None without thrust.
    """

    speeds_m_s: Array
    inclinations_rad: Array
    latitudes_rad: Array | None
    window_rad: Array | None


def thrust_arcs(instance: Instance, plan: Plan) -> tuple[SpiralArc, ...]:
    """Courses of all chasers with low thrust.

    Positions of thrust are those of its windows alone, with no regard to the shadow.

    Raises
    ------
    InputError
        The plan belongs to another instance, or an arc leads to no orbit.
    """
    phases = segments(instance, plan)
    found: list[SpiralArc] = []
    for flown in routes_of(instance, plan):
        drive = drive_of(flown.chaser, instance.targets)
        if drive is not None:
            found += _of_chaser(instance, drive, flown, phases)
    return tuple(found)


def _of_chaser(
    instance: Instance, drive: Drive, flown: Flown, phases: tuple[Segment, ...]
) -> Iterator[SpiralArc]:
    there, leaving = instance.orbits(), leaving_orbits(instance, drive)
    for number, leg in flown.legs:
        for name in (leg.origin, leg.destination):
            if name not in instance.names:
                raise InputError(f"leg {number}: {name!r} is not a body of the instance")
        # A chaser that is launched has no orbit before, and no phase that would ask for it.
        origin = leaving[instance.names.index(leg.origin)]
        destination = there[instance.names.index(leg.destination)]
        course = _Course(instance, leg, origin, destination)
        for segment in phases:
            if segment.leg == number:
                yield from course.drawn(segment, number)


class _Course:
    """Orbits of a chaser along a leg and the tow after it.

    Parameters
    ----------
    instance : Instance
    leg : Leg
    origin, destination : (columns,) float64
        Rows of the bodies, the origin as it is left.
    """

    def __init__(self, instance: Instance, leg: Leg, origin: Array, destination: Array) -> None:
        self._instance, self._leg = instance, leg
        self._origin, self._destination = origin, destination

    def drawn(self, segment: Segment, number: int) -> Iterator[SpiralArc]:
        """Pieces of a phase to draw: several for thrust and tows, one for all others."""
        changes = segment.phase in ("thrust", "tow")
        times = np.linspace(segment.start_s, segment.end_s, 1 + (PIECES if changes else 1))
        orbits = self._orbits(segment, times)
        if not np.all(np.isfinite(orbits.speeds) & (orbits.speeds > 0.0)):
            raise InputError(f"leg {number}: its arcs do not lead to a closed orbit")
        body = self._body(segment)
        for at in range(times.size - 1):
            ends = slice(at, at + 2)
            yield SpiralArc(
                number,
                segment.phase,
                times[ends],
                MU_M3_S2 / orbits.speeds[ends] ** 2 - EARTH_RADIUS_M,
                self._around(segment, at, Circles(*(part[at] for part in orbits))),
                np.degrees(orbits.nodes[ends]),
                orbits.speeds[ends],
                orbits.inclinations[ends],
                None if body is None else elements.latitudes(body, times[ends]),
                self._window(segment),
            )

    def _around(self, segment: Segment, at: int, circle: Circles) -> Array:
        """Positions at the begin of a piece of a phase, shape (points, 3) [m]."""
        body = self._body(segment)
        if body is not None:
            return _positions(circle, np.atleast_1d(elements.latitudes(body, segment.start_s)))
        if at % DRAWN_AROUND[segment.phase]:
            return np.empty((0, 3))
        if segment.phase != "thrust":
            return _positions(circle, np.linspace(0.0, 2.0 * np.pi, POINTS_OF_A_RING))
        return _windows(circle, self._arc(segment))

    def _window(self, segment: Segment) -> Array | None:
        """Window in which a phase thrusts; a tow thrusts all around."""
        if segment.phase == "tow":
            return np.array([0.0, 0.5 * np.pi])
        if segment.phase != "thrust":
            return None
        arc = self._arc(segment)
        return np.radians([arc.argument_of_latitude_deg, arc.window_deg])

    def _arc(self, segment: Segment) -> LowThrustArc:
        """The arc of a phase of thrust."""
        first, second = self._arcs()
        return first if segment.start_s < second.start_s else second

    def _arcs(self) -> tuple[LowThrustArc, LowThrustArc]:
        """Both arcs of a leg with thrust."""
        first, second = self._leg.manoeuvres or ()
        return first, second

    def _body(self, segment: Segment) -> Array | None:
        """Row of the body at which a phase is spent; None if it is under way."""
        if segment.phase in DRAWN_AROUND:
            return None
        leaves = segment.phase == "wait" and segment.end_s <= self._leg.leaves_s
        return self._origin if leaves else self._destination

    def _orbits(self, segment: Segment, times: Array) -> Circles:
        body = self._body(segment)
        if body is not None:
            return _on(body, times)
        if segment.phase == "tow":
            return self._towed(times)
        first, second = self._arcs()
        start = _on(self._origin, np.array([first.start_s]))
        if segment.phase == "thrust" and segment.start_s < second.start_s:
            return self._thrust(start, first, times)
        ramp = np.linspace(first.start_s, first.end_s, PIECES + 1)
        between = np.array([first.end_s, second.start_s])
        drifts = self._drift(self._thrust(start, first, ramp), between)
        return drifts if segment.phase == "drift" else self._thrust(drifts, second, times)

    def _thrust(self, start: Circles, arc: LowThrustArc, times: Array) -> Circles:
        """Orbits at times from the begin to the end of an arc."""
        share = np.linspace(0.0, 1.0, times.size)
        speeds = start.speeds[-1] - arc.size_m_s * share
        tilts = start.inclinations[-1] + math.radians(arc.inclination_deg) * share
        nodes = start.nodes[-1] + self._drifted(speeds, tilts, times)
        return Circles(speeds, tilts, nodes + math.radians(arc.raan_deg) * share)

    def _drift(self, start: Circles, times: Array) -> Circles:
        speeds, tilts = np.full(times.size, start.speeds[-1]), np.full(times.size, start[1][-1])
        return Circles(speeds, tilts, start.nodes[-1] + self._drifted(speeds, tilts, times))

    def _towed(self, times: Array) -> Circles:
        """Orbits on the spiral of a tow, along which the speed changes uniformly."""
        start = _on(self._destination, times[:1])
        low_m = EARTH_RADIUS_M + self._instance.circle_m(self._leg.destination)
        speeds = np.linspace(start.speeds[0], math.sqrt(MU_M3_S2 / low_m), times.size)
        tilts = np.full(times.size, start.inclinations[0])
        return Circles(speeds, tilts, start.nodes[0] + self._drifted(speeds, tilts, times))

    def _drifted(self, speeds: Array, tilts: Array, times: Array) -> Array:
        """Drift of the node since the first of some times, by the trapezoidal rule [rad]."""
        oblateness = self._instance.oblateness_m2
        rates = np.array(
            [
                ephemeris.node_rate(MU_M3_S2 / speed**2, tilt, oblateness)
                if speed > 0.0
                else np.nan
                for speed, tilt in zip(speeds, tilts, strict=True)
            ]
        )
        steps = 0.5 * (rates[1:] + rates[:-1]) * np.diff(times)
        return np.concatenate([[0.0], np.cumsum(steps)])


def _on(row: Array, times: Array) -> Circles:
    """The orbit of a body at times."""
    radii, tilts = elements.radii(row, times), elements.inclinations(row, times)
    whole = np.zeros(times.size)
    return Circles(np.sqrt(MU_M3_S2 / radii) + whole, tilts + whole, elements.nodes(row, times))


def _windows(circle: Circles, arc: LowThrustArc) -> Array:
    """Positions within both windows of an arc, with a gap in between, shape (points, 3) [m]."""
    middle, half = np.radians([arc.argument_of_latitude_deg, arc.window_deg])
    angles = np.linspace(middle - half, middle + half, POINTS_OF_A_WINDOW)
    return joined([_positions(circle, angles), _positions(circle, angles + np.pi)])[:-1]


def _positions(circle: Circles, latitudes: Array) -> Array:
    speed, tilt, node = circle
    ascending = np.array([np.cos(node), np.sin(node), 0.0])
    ahead = np.array([-np.sin(node) * np.cos(tilt), np.cos(node) * np.cos(tilt), np.sin(tilt)])
    directions: Array = np.outer(np.cos(latitudes), ascending) + np.outer(np.sin(latitudes), ahead)
    return directions * (MU_M3_S2 / speed**2)
