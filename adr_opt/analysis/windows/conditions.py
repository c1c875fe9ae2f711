"""Capture windows of targets, from sunlight, the Sun's angle, contacts and files.

The Sun is that of the low-precision formulas of the Astronomical Almanac, the Earth that shades a
sphere. Ground stations stand on the ellipsoid and turn with the mean sidereal time of 1982.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from ...common.constants import EARTH_RADIUS_M
from ...common.errors import InputError
from ...fly.trajectory.bodies import body_states
from ...kernels.orbits.sunlight import sun_directions
from ...problem.capture_windows import joined
from ...problem.frame import OF_DATE, Frame
from ...problem.frame_rotation import rotation
from ...problem.instance import Instance
from ...problem.rules import JUDGED, Follower
from ...problem.sun import J2000, sidereal_angle_rad, sidereal_rate_rad_s
from ...problem.support import followed
from .intervals import Array, common, positive, shrunk
from .stations import GroundStation

SUN_RADIUS_RAD = math.radians(0.2666)
"""Apparent radius of the Sun, yearly mean [rad]."""

STEP_S = 20.0
"""Spacing of samples: several per pass, between which edges and culmination are found [s]."""

FOLLOWS = Follower("capture windows", JUDGED)

Function = Callable[[Array], Array]

States = Callable[[str, Array], tuple[Array, Array]]
"""Positions [m] and velocities [m/s] of a target at times, shape (times, 3) each."""


@dataclass(frozen=True)
class CaptureConditions:
    """Conditions that must hold throughout a capture.

    Attributes
    ----------
    light : bool
        The Sun's whole disc stands above the Earth.
    sun_angle_deg : float
        Least angle of the Sun from the direction in which a chaser approaches, along the velocity
        [deg].
    stations : tuple of GroundStation
        One of them sees the target, if any are given.
    mask_deg : float
        Least elevation at which they do [deg].
    given : mapping of str to (intervals, 2) float64
        Times that other conditions allow, by target [s]; all times for a target that is not named.
    margin_s : float
        By which every interval begins later and ends sooner [s].
    """

    light: bool = False
    sun_angle_deg: float = 0.0
    stations: tuple[GroundStation, ...] = ()
    mask_deg: float = 5.0
    given: Mapping[str, Array] = field(default_factory=dict)
    margin_s: float = 0.0

    def __post_init__(self) -> None:
        for what, value, most in (
            ("sun_angle_deg", self.sun_angle_deg, 180.0),
            ("mask_deg", self.mask_deg, 90.0),
            ("margin_s", self.margin_s, math.inf),
        ):
            if not (0.0 <= value < most):
                raise InputError(f"{what} = {value:g}: must be at least 0 and below {most:g}")


def windows_of(
    instance: Instance, conditions: CaptureConditions, states: States | None = None
) -> dict[str, Array]:
    """Intervals in which each target may be captured, within the mission and its own window.

    Parameters
    ----------
    instance : Instance
    conditions : CaptureConditions
    states : callable, optional
        Motion of targets in the instance's frame, such as that of ephemerides; by default the
        instance's own, on their true ellipses.

    Returns
    -------
    dict of str to (intervals, 2) float64
        By target, ascending [s].

    Raises
    ------
    InputError
        ``given`` names something that is no target.
    MissingExtra
        The axes of the instance are fixed, and astropy is not installed.
    """
    instance = followed(instance, FOLLOWS)
    names = [target.name for target in instance.targets]
    for name in conditions.given:
        if name not in names:
            raise InputError(f"{name!r} is not a target of {instance.name!r}")

    def moved(name: str, times: Array) -> tuple[Array, Array]:
        return body_states(instance, name, times, true_orbits=True)

    sky = _Sky(instance, states or moved)
    found = {}
    for target in instance.targets:
        end_s = instance.mission.duration_s
        left = common(instance.intervals_of(target), np.array([[0.0, end_s]]))
        if target.name in conditions.given:
            left = common(left, conditions.given[target.name])
        for function in sky.conditions(target.name, conditions):
            left = common(left, positive(function, 0.0, end_s, STEP_S))
        if conditions.stations:
            seen = sky.contacts(target.name, conditions)
            left = common(left, joined(positive(each, 0.0, end_s, STEP_S) for each in seen))
        found[target.name] = shrunk(left, conditions.margin_s)
    return found


class _Sky:
    """The Sun and ground stations as seen from the targets of an instance."""

    def __init__(self, instance: Instance, states: States) -> None:
        self._states = states
        frame, epoch = instance.frame, instance.epoch
        fixed = frame is not None and frame.name not in OF_DATE
        matrix = rotation(frame, Frame(name="TEME", axes_epoch=epoch)) if fixed and frame else None
        self._to_date = np.eye(3) if matrix is None else matrix
        self._since_s = (epoch - J2000).total_seconds()
        self._greenwich_rad = sidereal_angle_rad(epoch)

    def conditions(self, name: str, required: CaptureConditions) -> Iterator[Function]:
        """Functions that are positive in sunlight, and at the required angle of the Sun [rad]."""

        def light(times: Array) -> Array:
            positions, _ = self._of_date(name, times)
            radii = np.linalg.norm(positions, axis=1)
            zenith = _angles(positions, sun_directions(self._since_s + times))
            dip = np.arccos(np.minimum(EARTH_RADIUS_M / radii, 1.0))
            height: Array = 0.5 * math.pi - zenith + dip - SUN_RADIUS_RAD
            return height

        def angle(times: Array) -> Array:
            _, velocities = self._of_date(name, times)
            away = _angles(velocities, sun_directions(self._since_s + times))
            return away - math.radians(required.sun_angle_deg)

        if required.light:
            yield light
        if required.sun_angle_deg > 0.0:
            yield angle

    def contacts(self, name: str, required: CaptureConditions) -> Iterator[Function]:
        """Elevation above the mask of each station [rad]."""

        def elevation(times: Array) -> Array:
            positions, _ = self._of_date(name, times)
            turn = self._greenwich_rad + sidereal_rate_rad_s() * times
            cosine, sine = np.cos(turn), np.sin(turn)
            x, y, z = positions.T
            fixed = np.column_stack([cosine * x + sine * y, cosine * y - sine * x, z])
            return 0.5 * math.pi - _angles(fixed - place, up) - math.radians(required.mask_deg)

        for station in required.stations:
            place, up = station.place()
            yield elevation

    def _of_date(self, name: str, times: Array) -> tuple[Array, Array]:
        """Position and velocity in the axes of the equator and the equinox of date."""
        positions, velocities = self._states(name, times)
        return positions @ self._to_date.T, velocities @ self._to_date.T


def _angles(one: Array, other: Array) -> Array:
    """Angles between vectors, of which the second are of unit length [rad]."""
    cosines = np.sum(one * other, axis=1) / np.linalg.norm(one, axis=1)
    angles: Array = np.arccos(np.clip(cosines, -1.0, 1.0))
    return angles
