"""The flown plan, thinned out for drawing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...common.constants import EARTH_RADIUS_M
from ...fly.trajectory.bodies import body_states
from ...fly.trajectory.kepler import Array, drift, revolution
from ...fly.trajectory.sampling import LONG_STEP_S, Arc, LegPath, sample
from ...kernels.orbits.ephemeris import period
from ...plan.plan import Plan
from ...problem.instance import Instance
from .strands import POINTS_OF_A_RING, DrawnArc

MOST_STEPS = 1e6
LEVEL_M = 1.0
"""Change of altitude below which an arc is drawn as a level line."""


@dataclass(frozen=True)
class Track(DrawnArc):
    """A flown arc.

    Attributes
    ----------
    first_m, first_m_s : (3,) float64
        Position [m] and velocity within the plane [m/s] at the first of the times.
    pace, node_rate_rad_s : float
        How the orbit goes on from there, as :class:`adr_opt.fly.trajectory.Arc` has it.
    """

    first_m: Array
    first_m_s: Array
    pace: float
    node_rate_rad_s: float


def tracks(instance: Instance, plan: Plan) -> tuple[Track, ...]:
    """Fly a plan (:func:`adr_opt.fly.trajectory.sample`) and thin out its samples.

    Raises
    ------
    InputError
        The plan belongs to another instance or cannot be flown.
    """
    total_s = sum(max(0.0, leg.done_s - leg.ready_s) for leg in plan.legs)
    step_s = total_s / MOST_STEPS
    flown = sample(instance, plan, step_s if step_s > LONG_STEP_S else None)
    return tuple(_track(instance, path, arc) for path, arc in flown.arcs())


def _track(instance: Instance, path: LegPath, arc: Arc) -> Track:
    phase = arc.phase
    if phase == "service" and path.leg.destination in instance.station_names:
        phase = "refuelling"
    altitudes = np.linalg.norm(arc.positions_m, axis=1) - EARTH_RADIUS_M
    level = np.ptp(altitudes) < LEVEL_M
    ends = [0, -1]
    first = arc.positions_m[0], arc.velocities_m_s[0]
    around, lap_s = arc.positions_m, revolution(*first) / arc.pace
    if arc.end_s - arc.start_s > lap_s:
        laps = np.linspace(0.0, lap_s, POINTS_OF_A_RING)
        around = drift(*first, laps, instance.oblateness_m2)[0]
    normal = np.cross(*first)
    node = np.degrees(np.arctan2(normal[0], -normal[1]))
    drifted = np.degrees(arc.node_rate_rad_s) * (arc.end_s - arc.start_s)
    return Track(
        path.number,
        phase,
        arc.times_s[ends] if level else arc.times_s,
        altitudes[ends] if level else altitudes,
        around,
        np.array([node, node + drifted]),
        *first,
        arc.pace,
        arc.node_rate_rad_s,
    )


def ring(instance: Instance, body: str) -> Array:
    """One revolution of a body on its planning circle, shape (points, 3) [m]."""
    lap_s = period(instance.body_orbits[instance.names.index(body)].semi_major_axis_m)
    return body_states(instance, body, np.linspace(0.0, lap_s, POINTS_OF_A_RING))[0]
