"""The first guess of a leg's thrust, from its plan.

Thrust along the orbit on its sunlit side alone makes it eccentric. What both arcs do of that, and
what is left to be done of the leg's own change, is told to first order by the means of
docs/model.md section 11.3, in which the square of the primer vector stands for its length. Laws
with shapes also turn and shrink the eccentricity.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...common.constants import OBLATENESS_M2
from ...kernels.orbits import mean_thrusting, primer, sunlight
from ...kernels.orbits.ephemeris import secular_rates
from ...kernels.orbits.short_periods import Array
from ...kernels.orbits.thrusting import ThrustArcs
from ...plan.plan import LowThrustArc
from .thrust_task import Programme, ThrustTask

NOTHING = ThrustArcs(np.empty((0, 5)), np.empty(0), np.empty(0), np.empty(0))

PLACES = 180
"""Number of places on a revolution over which to average."""


class Middle(NamedTuple):
    """The orbit of an arc halfway through it.

    Attributes
    ----------
    mean : (6,) float64
        Mean elements of the leg's end next to it, with the node of that time.
    time_s : float
        Since the mission's epoch [s].
    """

    mean: Array
    time_s: float


def middles(task: ThrustTask, arcs: tuple[LowThrustArc, ...]) -> tuple[Middle, ...]:
    """Orbits of both arcs of a plan."""
    found = []
    ends = (task.origin, task.start_s), (task.target, task.end_s)
    for arc, (mean, time_s) in zip(arcs, ends, strict=True):
        middle = 0.5 * (arc.start_s + arc.end_s)
        moved, _, _ = mean_thrusting.fly(mean, 0.0, abs(middle - time_s), task.push, NOTHING)
        there = mean.copy()
        there[4] += math.copysign(1.0, middle - time_s) * (moved[4] - mean[4])
        found.append(Middle(there, middle))
    return tuple(found)


def with_shapes(task: ThrustTask, arcs: tuple[LowThrustArc, ...], laws: Array) -> Array:
    """Laws of the same ΔV that also match the eccentricity, shape (2, 5) [m/s].

    Parameters
    ----------
    task : ThrustTask
    arcs : (2,) LowThrustArc
        Of the plan.
    laws : (2, 5) float64
        Without A and B [m/s].
    """
    orbits = middles(task, arcs)
    rates = [_perigee_rate(orbit.mean) for orbit in orbits]
    drifting = 0.5 * (rates[0] + rates[1])
    turns = [
        _turned(rate * (task.end_s - orbit.time_s))
        for rate, orbit in zip((drifting, rates[1]), orbits, strict=True)
    ]
    effects = [_effects(task, orbit) for orbit in orbits]
    pumped = [effect[0, 1:] * law[2] for effect, law in zip(effects, laws, strict=True)]
    carried = _turned(drifting * (task.end_s - task.start_s)) @ task.origin[1:3]
    left = task.speed * (task.target[1:3] - carried)
    left -= sum(turn @ each for turn, each in zip(turns, pumped, strict=True))
    sizes = np.linalg.norm(laws, axis=1)
    total = float(sizes.sum())
    shaped = laws.copy()
    for law, effect, turn, each, size in zip(shaped, effects, turns, pumped, sizes, strict=True):
        change = each + (size / total if total > 0.0 else 0.5) * (turn.T @ left)
        law[2], law[0], law[1] = np.linalg.solve(effect, np.r_[law[2], change])
        length = float(np.linalg.norm(law))
        law *= size / length if length > 0.0 else 1.0
    return shaped


def _perigee_rate(mean: Array) -> float:
    return float(secular_rates(mean[0], 0.0, mean[3], OBLATENESS_M2)[1])


def _turned(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s], [s, c]])


def _effects(task: ThrustTask, orbit: Middle) -> Array:
    """Mean changes of size and eccentricity by C, A and B over the sunlit places, shape (3, 3)."""
    places = np.linspace(0.0, math.tau, PLACES, endpoint=False)
    since = task.push.since_j2000 + orbit.time_s
    if not math.isnan(since):
        dark = sunlight.shadow(orbit.mean[0], orbit.mean[3], orbit.mean[4], since)
        away = np.abs(np.remainder(places - dark.middle + math.pi, math.tau) - math.pi)
        places = places[away >= dark.half]
    c, s = np.cos(places), np.sin(places)
    along = np.stack([np.ones_like(c), 2.0 * c, 2.0 * s])
    outward = np.stack([np.zeros_like(c), s, -c])
    found: Array = (along @ along.T + outward @ outward.T) / places.size
    return found


FASTER = 1.02
"""Ratio of the intended time of thrust to the planned one."""

LEAST_THRESHOLD, LARGEST_THRESHOLD = 0.25, 0.9
"""Limits of thresholds: where the primer vector is short it turns fast, and thrust is worth little.
"""

ALMOST_ALL = 0.9
"""Share of the sunlit revolution above which thrust is on throughout it."""

ABOVE_SHORTEST = 0.05
"""Least distance of a threshold from the shortest primer vector: nearer to it windows change too
much with the law."""

HALVINGS = 30
LENGTHS = 72
"""Number of halvings of a threshold, and of places at which the shortest primer is looked for."""


def first_guess(
    task: ThrustTask, arcs: tuple[LowThrustArc, ...], *, shaped: bool = False
) -> Programme:
    """The programme equivalent to both arcs of a plan, with thrust at the best places.

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
    """A programme with thresholds at which arcs last about as long as in the plan.

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
    """Threshold at which thrust is on for a share of the revolution, if possible."""
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
