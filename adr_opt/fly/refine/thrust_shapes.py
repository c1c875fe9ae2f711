"""Laws of a leg's arcs that also turn and shrink the eccentricity, to first order.

Thrust along the orbit on its sunlit side alone makes it eccentric. What both arcs do of that, and
what is left to be done of the leg's own change, is told by the means of docs/model.md section 11.3,
in which the square of the primer vector stands for its length.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...common.constants import OBLATENESS_M2
from ...kernels.orbits import mean_thrusting, sunlight
from ...kernels.orbits.ephemeris import secular_rates
from ...kernels.orbits.short_periods import Array
from ...kernels.orbits.thrusting import ThrustArcs
from ...plan.plan import LowThrustArc
from .thrust_task import ThrustTask

NOTHING = ThrustArcs(np.empty((0, 5)), np.empty(0), np.empty(0), np.empty(0))

PLACES = 180
"""Number of places on a revolution over which means are taken."""


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
    """Laws of as much ΔV that also make up for the eccentricity, shape (2, 5) [m/s].

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
