"""Keep-out zones crossed by a leg, from its burns alone (docs/model.md section 6).

For :mod:`.verdict`. The timetable forbids sequences by the clock of half ellipses; here the
burns are followed in two-body motion from where the chaser leaves, by Kepler's equation, so that an
error in one of the two shows.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2
from ...plan.plan import Leg
from ...problem.instance import Instance
from ...problem.orbit import Orbit
from ...problem.settings import KeepOutZone

MARGIN_M, MARGIN_S = 1.0, 1e-2
"""Depth inside a zone from which a leg is reported: more than the tolerance on burns [m]."""

SAMPLES = 24
"""Number of sampled times per arc, ends included.

A half ellipse has its extremes at its ends, and a phasing circle is round."""

KEPLER_STEPS = 12

Vector = npt.NDArray[np.float64]


def crossed(instance: Instance, leg: Leg) -> Iterator[int]:
    """Zones, numbered from 0, that a leg enters while they are active.

    Waiting and service are exempt, and the approach counts as on the target's orbit. A leg without
    the two burns of an approach, or with burns that leave no orbit, gives nothing: `check` has
    other things to say about it.
    """
    if not instance.keep_out_zones or len(leg.burns) < 2:
        return
    orbits = dict(zip(instance.names, instance.body_orbits, strict=True))
    stretches = list(_stretches(orbits[leg.origin], leg, instance.oblateness_m2))
    arrival = orbits[leg.destination].semi_major_axis_m
    begins = next((burn.time_s for burn in leg.burns if burn.phase == "approach"), math.inf)
    ends = leg.burns[-1].time_s
    for number, zone in enumerate(instance.keep_out_zones):
        if _meets(zone, begins, ends, np.array([arrival])) or any(
            _meets(zone, times[0], times[-1], radii) for times, radii in _open(zone, stretches)
        ):
            yield number


def _meets(zone: KeepOutZone, begins: float, ends: float, radii: Vector) -> bool:
    """Whether motion between two radii meets a zone in time and altitude."""
    low, high = radii.min() - EARTH_RADIUS_M, radii.max() - EARTH_RADIUS_M
    return bool(
        begins <= zone.end_s - MARGIN_S
        and ends >= zone.start_s + MARGIN_S
        and low <= zone.max_altitude_m - MARGIN_M
        and high >= zone.min_altitude_m + MARGIN_M
    )


class ZonedArc:
    """Motion from a state until the next burn: two-body, or mean with J2."""

    def __init__(
        self, position: Vector, velocity: Vector, begins: float, ends: float, oblateness: float
    ) -> None:
        self.position, self.velocity, self.begins, self.ends = position, velocity, begins, ends
        self.radius = float(np.linalg.norm(position))
        self.a = 1.0 / (2.0 / self.radius - float(velocity @ velocity) / MU_M3_S2)
        self.e_cos = 1.0 - self.radius / self.a
        self.e_sin = float(position @ velocity) / math.sqrt(MU_M3_S2 * abs(self.a))
        momentum = np.cross(position, velocity)
        cosine = momentum[2] / math.sqrt(momentum @ momentum)
        strength = 1.5 * oblateness / self.a**2
        self.pace = 1.0 + strength * (4.0 * cosine * cosine - 1.0)
        self.node_rate = -strength * cosine * math.sqrt(MU_M3_S2 / abs(self.a) ** 3)

    @property
    def is_ellipse(self) -> bool:
        """Whether the motion is elliptic, with an eccentricity that a leg may have."""
        return self.a > 0.0 and math.hypot(self.e_cos, self.e_sin) < 0.9

    def turned(self, times: Vector) -> Vector:
        """Eccentric anomaly relative to the start, by Newton's method."""
        mean: Vector = (times - self.begins) * self.pace * math.sqrt(MU_M3_S2 / self.a**3)
        x = mean.copy()
        for _ in range(KEPLER_STEPS):
            sine, cosine = np.sin(x), np.cos(x)
            value = x - self.e_cos * sine + self.e_sin * (1.0 - cosine) - mean
            x -= value / (1.0 - self.e_cos * cosine + self.e_sin * sine)
        return x

    def radii(self, times: Vector) -> Vector:
        """Distance from the centre of the Earth [m]."""
        x = self.turned(times)
        radii: Vector = self.a * (1.0 - self.e_cos * np.cos(x) + self.e_sin * np.sin(x))
        return radii

    def state_at_end(self) -> tuple[Vector, Vector]:
        """Position and velocity at the next burn, by Lagrange coefficients, rotated."""
        end = np.array([self.ends])
        x, r = float(self.turned(end)[0]), float(self.radii(end)[0])
        share = 1.0 - math.cos(x)
        gone = self.pace * (self.ends - self.begins)
        g = gone - math.sqrt(self.a**3 / MU_M3_S2) * (x - math.sin(x))
        f_rate = -math.sqrt(MU_M3_S2 * self.a) / (r * self.radius) * math.sin(x)
        angle = self.node_rate * (self.ends - self.begins)
        return (
            _turned(
                (1.0 - self.a / self.radius * share) * self.position + g * self.velocity, angle
            ),
            _turned(f_rate * self.position + (1.0 - self.a / r * share) * self.velocity, angle),
        )


def _turned(vector: Vector, angle: float) -> Vector:
    """A vector rotated about the axis of the Earth."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1], vector[2]])


def _stretches(origin: Orbit, leg: Leg, oblateness: float) -> Iterator[ZonedArc]:
    """The motion between the burns, up to the approach."""
    position, velocity = _state(origin, leg.burns[0].time_s, oblateness)
    for burn, following in zip(leg.burns, leg.burns[1:], strict=False):
        if burn.phase == "approach" or following.time_s < burn.time_s:
            return
        stretch = ZonedArc(
            position,
            velocity + np.array(burn.delta_v_m_s),
            burn.time_s,
            following.time_s,
            oblateness,
        )
        if not stretch.is_ellipse:
            return
        yield stretch
        position, velocity = stretch.state_at_end()


def _open(zone: KeepOutZone, stretches: list[ZonedArc]) -> Iterator[tuple[Vector, Vector]]:
    """Times and radii of the arcs while a zone is active."""
    for stretch in stretches:
        begins = max(stretch.begins, zone.start_s + MARGIN_S)
        ends = min(stretch.ends, zone.end_s - MARGIN_S)
        if begins <= ends:
            times = np.linspace(begins, ends, SAMPLES)
            yield times, stretch.radii(times)


def _state(orbit: Orbit, time_s: float, oblateness: float) -> tuple[Vector, Vector]:
    """Position and velocity on the planning circle of a body."""
    radius, inclination, raan, latitude = orbit.circular_elements()
    motion = math.sqrt(MU_M3_S2 / radius**3)
    tilt, square = math.cos(inclination), 1.0 - orbit.eccentricity**2
    strength = 0.75 * oblateness / (radius * square) ** 2
    faster = 5.0 * tilt**2 - 1.0 + math.sqrt(square) * (3.0 * tilt**2 - 1.0)
    u = latitude + motion * (1.0 + strength * faster) * time_s
    raan -= 2.0 * strength * motion * tilt * time_s
    node = np.array([math.cos(raan), math.sin(raan), 0.0])
    ahead = np.array([-math.sin(raan) * tilt, math.cos(raan) * tilt, math.sin(inclination)])
    outward = math.cos(u) * node + math.sin(u) * ahead
    forward = math.cos(u) * ahead - math.sin(u) * node
    return radius * outward, radius * motion * forward
