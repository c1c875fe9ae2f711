"""A controlled re-entry as flown: its trajectory after a burn, and its ground track."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2
from ...kernels.legs.burns import half_ellipse_speeds
from ...kernels.orbits.coast import coast
from ...kernels.orbits.gravity import FIELDS
from ...problem.geodetic import above, upward
from ...problem.instance import Instance
from ...problem.sun import greenwich
from .casualties import Array

ENTRY_M = 120e3
"""Height at which the atmosphere begins to brake [m]."""

STEP_S = 20.0
"""Spacing of points on the ground track [m]."""

BURN_ERROR = 0.01
"""Relative error of the burn that sets the length of the corridor."""

HALF_WIDTH_M = 100e3
"""Half width of the corridor, for wind and the cross-track spread of debris [m]."""

_NO_MATRIX = np.empty((0, 0))


@dataclass(frozen=True)
class Reentry:
    """A burn after which an object re-enters within a revolution, drag neglected.

    Attributes
    ----------
    burn_s, entry_s : float
        Times of the burn, and of the entry at a height of 120 km [s].
    burn_m_s : float
        [m/s].
    track : tuple of (time_s, latitude_deg, longitude_deg, height_m)
        From the burn to the ground, or to the perigee where that is above it.
    entry : (float, float)
        Geodetic latitude and longitude of the entry [deg].
    earliest, latest : (float, float) or None
        The same with a burn too large and too small by the assumed error; None where it is then no
        entry within the revolution.
    left, right : tuple of (float, float)
        Edges of the corridor beside the track.
    """

    burn_s: float
    entry_s: float
    burn_m_s: float
    track: tuple[tuple[float, float, float, float], ...]
    entry: tuple[float, float]
    earliest: tuple[float, float] | None
    latest: tuple[float, float] | None
    left: tuple[tuple[float, float], ...]
    right: tuple[tuple[float, float], ...]


def _moved(state: Array, time_s: float, gravity: str = "j4") -> Array:
    """A state after some time in the gravity of the Earth."""
    after = state.copy()
    coast(after, time_s, FIELDS[gravity], _NO_MATRIX)
    return after


def to_apogee(state: Array) -> tuple[float, Array]:
    """Time to the next apogee [s], and the state there, on the ellipse of a state of plans.

    That is one of mean motion, whose harmonics would only be counted twice.
    """
    axis = 1.0 / (2.0 / np.linalg.norm(state[:3]) - state[3:] @ state[3:] / MU_M3_S2)
    revolution = math.tau * math.sqrt(axis**3 / MU_M3_S2)
    steps = max(2, math.ceil(revolution / STEP_S))
    states = [state]
    for _ in range(steps):
        states.append(_moved(states[-1], revolution / steps, "two-body"))
    at = int(np.argmax([np.linalg.norm(each[:3]) for each in states]))
    return at * revolution / steps, states[at]


def lowering(state: Array, perigee_m: float) -> Array:
    """The burn against the motion at an apogee that leads to a perigee radius, (3,) [m/s]."""
    speed = float(np.linalg.norm(state[3:]))
    slower = speed - half_ellipse_speeds(float(np.linalg.norm(state[:3])), perigee_m)[0]
    burn: Array = -max(slower, 0.0) / speed * state[3:]
    return burn


def reentry(instance: Instance, burn_s: float, before: Array, burn: Array) -> Reentry | None:
    """The re-entry after a burn; None if there is none within a revolution.

    Parameters
    ----------
    instance : Instance
    burn_s : float
        Time of the burn [s].
    before : (6,) float64
        State before it, in the instance's frame [m, m/s].
    burn : (3,) float64
        [m/s].
    """
    tracks = [_track(instance, burn_s, before, burn * (1.0 + off)) for off in (0.0, *_OFF)]
    track, entries = tracks[0], [_entry(track) for track in tracks]
    if entries[0] is None:
        return None
    entry_s, *entry = entries[0]
    edges = [_beside(track, side) for side in (-HALF_WIDTH_M, HALF_WIDTH_M)]
    early, late = (None if each is None else (each[1], each[2]) for each in entries[1:])
    return Reentry(
        burn_s=burn_s,
        entry_s=entry_s,
        burn_m_s=float(np.linalg.norm(burn)),
        track=tuple((float(t), float(a), float(b), float(h)) for t, a, b, h in track),
        entry=(entry[0], entry[1]),
        earliest=early,
        latest=late,
        left=edges[0],
        right=edges[1],
    )


_OFF = BURN_ERROR, -BURN_ERROR


def _track(instance: Instance, burn_s: float, before: Array, burn: Array) -> Array:
    """Times, geodetic latitudes and longitudes [deg], and heights, down to the ground."""
    state, time_s, rows = before.copy(), burn_s, list[Array]()
    state[3:] += burn
    while True:
        rows.append(_below(instance, time_s, state[:3]))
        sinks = state[:3] @ state[3:] < 0.0 or len(rows) < 3
        if rows[-1][3] <= 0.0 or not sinks:
            return np.array(rows)
        state, time_s = _moved(state, STEP_S), time_s + STEP_S


def _below(instance: Instance, time_s: float, position: Array) -> Array:
    """A row of the track: above the ellipsoid of WGS 84."""
    angle, rate = greenwich(instance)
    latitude, height = above(position)
    longitude = math.degrees(math.atan2(position[1], position[0]) - angle - rate * time_s)
    return np.array([time_s, latitude, (longitude + 180.0) % 360.0 - 180.0, height])


def _entry(track: Array) -> tuple[float, float, float] | None:
    """Time and place where a track passes the height of entry."""
    passed = np.flatnonzero(track[:, 3] <= ENTRY_M)
    if passed.size == 0 or passed[0] == 0:
        return None
    at = int(passed[0])
    high, low = track[at - 1], track[at]
    share = (high[3] - ENTRY_M) / (high[3] - low[3])
    turn = (low[2] - high[2] + 180.0) % 360.0 - 180.0
    longitude = (high[2] + share * turn + 180.0) % 360.0 - 180.0
    return (
        float(high[0] + share * (low[0] - high[0])),
        float(high[1] + share * (low[1] - high[1])),
        float(longitude),
    )


def _beside(track: Array, side_m: float) -> tuple[tuple[float, float], ...]:
    """Places at a distance to the right of a track, on a sphere."""
    up = upward(track[:, 1], track[:, 2])
    ahead = np.gradient(up, axis=0)
    right = np.cross(ahead, up)
    right /= np.linalg.norm(right, axis=1)[:, None]
    turn = side_m / EARTH_RADIUS_M
    place = math.cos(turn) * up + math.sin(turn) * right
    latitudes = np.degrees(np.arcsin(np.clip(place[:, 2], -1.0, 1.0)))
    longitudes = np.degrees(np.arctan2(place[:, 1], place[:, 0]))
    return tuple(zip(latitudes.tolist(), longitudes.tolist(), strict=True))
