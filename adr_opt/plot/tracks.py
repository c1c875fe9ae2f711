"""The flown plan with no more points than a picture needs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..instance import Instance
from ..kernels.constants import EARTH_RADIUS_M, MU_M3_S2
from ..plan import Plan
from ..trajectory import Arc, LegPath, body_states, sample
from ..trajectory.kepler import Array

STEP_S = 60.0
MOST_STEPS = 1e6
LEVEL_M = 1.0
"""An arc whose altitude changes by less is drawn as a level line."""

POINTS_OF_A_RING = 91


@dataclass(frozen=True)
class Track:
    """One arc, ready to be drawn.

    Attributes
    ----------
    leg : int
        Number of the leg, from 1.
    phase : str
        One of :data:`adr_opt.plot.PHASES`.
    times_s : (n,) float64
        Since the epoch [s].
    altitudes_m : (n,) float64
        Distances from the centre of the Earth, less its radius [m].
    around_m : (m, 3) float64
        Positions over at most one revolution: the next would be drawn over them [m].
    """

    leg: int
    phase: str
    times_s: Array
    altitudes_m: Array
    around_m: Array


def tracks(instance: Instance, plan: Plan) -> tuple[Track, ...]:
    """Fly a plan (:func:`adr_opt.trajectory.sample`) and thin out what it passes.

    Raises
    ------
    InputError
        The plan belongs to another instance or cannot be flown.
    """
    total_s = sum(max(0.0, leg.end_s - leg.ready_s) for leg in plan.legs)
    flown = sample(instance, plan, max(STEP_S, total_s / MOST_STEPS))
    return tuple(_track(path, arc, instance.station_names) for path, arc in flown.arcs())


def _track(path: LegPath, arc: Arc, stations: tuple[str, ...]) -> Track:
    phase = arc.phase
    if phase == "service" and path.leg.destination in stations:
        phase = "refuelling"
    altitudes = np.linalg.norm(arc.positions_m, axis=1) - EARTH_RADIUS_M
    level = np.ptp(altitudes) < LEVEL_M
    ends = [0, -1]
    radius, speed = np.linalg.norm(arc.positions_m[0]), np.linalg.norm(arc.velocities_m_s[0])
    period = 2.0 * np.pi * np.sqrt((2.0 / radius - speed**2 / MU_M3_S2) ** -3.0 / MU_M3_S2)
    # one sample more, so that the ring closes
    within = np.searchsorted(arc.times_s, arc.times_s[0] + period) + 1
    return Track(
        path.number,
        phase,
        arc.times_s[ends] if level else arc.times_s,
        altitudes[ends] if level else altitudes,
        arc.positions_m[:within],
    )


def ring(instance: Instance, body: str) -> Array:
    """One revolution of a body on the circle that is planned with, shape (points, 3) [m]."""
    radius = instance.body_orbits[instance.names.index(body)].semi_major_axis_m
    period = 2.0 * np.pi * np.sqrt(radius**3 / MU_M3_S2)
    return body_states(instance, body, np.linspace(0.0, period, POINTS_OF_A_RING))[0]


def joined(parts: Iterator[Array] | list[Array]) -> Array:
    """Arrays one after the other with a row of NaN after each: lines with gaps between them."""
    rows = []
    for part in parts:
        rows += [part, np.full((1, *part.shape[1:]), np.nan)]
    return np.concatenate(rows) if rows else np.empty(0)
