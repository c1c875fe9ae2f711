"""The first guess of a leg's thrust: what its plan says."""

from __future__ import annotations

import math

import numpy as np

from ...kernels.orbits import mean_thrusting, primer
from ...kernels.orbits.short_periods import Array
from ...plan.plan import LowThrustArc
from .thrust_shapes import middles, with_shapes
from .thrust_task import Programme, ThrustTask

FASTER = 1.02
"""Time of thrust aimed at, over that of the plan."""

LEAST_THRESHOLD, LARGEST_THRESHOLD = 0.25, 0.9
"""Limits of thresholds: where the primer vector is short it turns fast, and thrust is worth little.
"""

ALMOST_ALL = 0.9
"""Share of the sunlit revolution from which on thrust is on in all of it."""

ABOVE_SHORTEST = 0.05
"""Least distance of a threshold from the shortest primer vector: nearer to it windows change too
much with the law."""

HALVINGS = 30
LENGTHS = 72
"""Number of halvings of a threshold, and of places at which the shortest primer is looked for."""


def first_guess(
    task: ThrustTask, arcs: tuple[LowThrustArc, ...], *, shaped: bool = False
) -> Programme:
    """The programme that both arcs of a plan amount to, with thrust at the best places.

    Parameters
    ----------
    task : ThrustTask
    arcs : (2,) LowThrustArc
    shaped : bool, optional
        Whether laws make up for the eccentricity.
    """
    steered = np.zeros((2, 5))
    sine = math.sin(task.target[3])
    for law, arc in zip(steered, arcs, strict=True):
        half = math.radians(arc.window_deg)
        plane = task.speed * half / math.sin(half)
        law[2] = arc.size_m_s
        law[3] = plane * math.radians(arc.inclination_deg)
        law[4] = plane * sine * math.radians(arc.raan_deg)
        size = float(np.linalg.norm(law))
        law[2] = law[2] if size > 0.0 else 1.0
        law *= max(arc.delta_v_m_s, 1e-3) / max(size, 1e-9 if size > 0.0 else 1.0)
    if shaped:
        steered = with_shapes(task, arcs, steered)
    guess = Programme(steered.ravel(), np.full(2, LEAST_THRESHOLD), arcs[1].start_s)
    return _matched(task, guess, arcs)


def _matched(task: ThrustTask, programme: Programme, arcs: tuple[LowThrustArc, ...]) -> Programme:
    """The same with thresholds with which arcs take about as long as in the plan.

    Where thrust is on at the best places only, it is as slow as windows of the plan are, and
    cheaper.
    """
    spans = task.arcs(programme).spans
    thresholds = np.zeros(2)
    for number, (arc, orbit) in enumerate(zip(arcs, middles(task, arcs), strict=True)):
        wanted = FASTER * spans[number] / max(arc.end_s - arc.start_s, 1.0)
        law = programme.laws[number]
        thresholds[number] = _threshold(
            law, orbit.mean, wanted, task.push.since_j2000 + orbit.time_s
        )
    return Programme(programme.steered, thresholds, programme.second_s)


def _threshold(law: Array, mean: Array, wanted: float, since_j2000: float) -> float:
    """Threshold with which thrust is on for a share of the revolution, if it can be."""
    longest = float(primer.peak(law))
    low, high = LEAST_THRESHOLD, LARGEST_THRESHOLD
    if mean_thrusting.share_on(mean, law, low * longest, since_j2000) * ALMOST_ALL <= wanted:
        return low
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        share = mean_thrusting.share_on(mean, law, middle * longest, since_j2000)
        low, high = (middle, high) if share > wanted else (low, middle)
    places = np.linspace(0.0, math.tau, LENGTHS, endpoint=False)
    shortest = min(float(primer.length(law, place)) for place in places)
    return low if low > shortest / longest + ABOVE_SHORTEST else LEAST_THRESHOLD
