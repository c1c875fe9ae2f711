"""Selection and order of the pairs in a timetable: nearest first.

A chaser hardly ever flies to a target that a hundred others are nearer than. So where time or
memory is short of the timetable of all pairs, it is that of the nearest destinations of every body.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.spatial import KDTree

from ..common.constants import MU_M3_S2
from ..kernels.orbits import elements
from ..kernels.orbits.ephemeris import EPOCH_S, planes_drift
from ..kernels.tables.timetable_making import WAVE, Pairs
from ..problem.instance import Instance

FloatArray = npt.NDArray[np.float64]


def all_pairs(bodies: int) -> Pairs:
    """All pairs, in the order of numbers."""
    others = np.arange(bodies - 1)[None, :] + (np.arange(bodies - 1) >= np.arange(bodies)[:, None])
    return Pairs(np.arange(bodies), others.astype(np.int32))


def connected_pairs(instance: Instance, near: int) -> Pairs:
    """All pairs; of given connections those that have any, at most ``near`` per body."""
    bodies = len(instance.names)
    if near >= bodies - 1:
        return all_pairs(bodies)
    return Pairs(np.arange(bodies), _given_near(instance, near).astype(np.int32))


def begun(pairs: Pairs, built: int) -> Pairs:
    """Pairs of the waves begun when a number of pairs has been built."""
    waves = max(1, math.ceil(built / max(1, pairs.origins.size * WAVE)))
    return Pairs(pairs.origins, pairs.near[:, : waves * WAVE])


def nearest_pairs(instance: Instance, first: Sequence[str], ranks: int) -> Pairs:
    """Pairs in the order in which planners need them.

    Parameters
    ----------
    instance : Instance
    first : sequence of str
        Bodies that are wanted before all others; the others come in order of their distance from
        where chasers start. The nearest of each are found by :func:`places_of`.
    ranks : int
        Number of destinations of each body.

    Returns
    -------
    Pairs
        Stations and required targets are the first destinations of all, and targets without a
        prize the last.
    """
    bodies = len(instance.names)
    ranks, middle_s = min(ranks, bodies - 1), 0.5 * instance.mission.duration_s
    given = instance.given is not None
    near = _given_near(instance, ranks) if given else _near(instance, ranks, middle_s)
    return Pairs(np.array(_from_start(instance, first)), near.astype(np.int32))


class Neighbours(NamedTuple):
    """Destinations of each body that searches examine.

    Attributes
    ----------
    near : (periods, bodies, ranks) int32
        The nearest first, in each of some periods of a mission.
    period_s : float
        How long each is [s].
    """

    near: npt.NDArray[np.int32]
    period_s: float


PERIODS = 12
"""Number of periods per mission for which near bodies are determined, where nodes drift."""


def neighbours(instance: Instance, ranks: int) -> Neighbours:
    """Nearest destinations of each body in the middle of each period."""
    periods = PERIODS if planes_drift(instance.oblateness_m2) else 1
    ranks = min(ranks, len(instance.names) - 1)
    length_s = max(instance.mission.duration_s, 1.0) / periods
    middles = [(number + 0.5) * length_s for number in range(periods)]
    near = np.stack([_near(instance, ranks, middle).astype(np.int32) for middle in middles])
    return Neighbours(near, length_s)


def _from_start(instance: Instance, first: Sequence[str]) -> list[int]:
    """All bodies: stations and starts, then preferred ones, then by ΔV from a start.

    Targets without a prize are last.
    """
    wanted = set(first)
    unwanted = [name not in wanted for name in instance.names]
    fixed = range(instance.first_target)
    if instance.given is None:
        places = places_of(instance, 0.5 * instance.mission.duration_s)
        away = [np.linalg.norm(places - places[home], axis=1) for home in set(instance.starts)]
    else:
        costs = _given_costs(instance)
        away = [costs.from_body(home, len(instance.names)) for home in set(instance.starts)]
    nearest = np.min(np.stack(away), axis=0)
    order = np.lexsort((nearest, _is_worthless(instance), np.array(unwanted)))
    return [*fixed, *(int(body) for body in order if body not in fixed)]


def _is_worthless(instance: Instance) -> npt.NDArray[np.bool_]:
    """Mask of targets without a prize."""
    worthless = [
        target.greatest_prize == 0.0 and not target.required for target in instance.targets
    ]
    return np.array([*(False for _ in range(instance.first_target)), *worthless])


def places_of(instance: Instance, time_s: float) -> FloatArray:
    """Points whose distances approximate the ΔV between bodies, shape (bodies, 7) [m/s].

    The normal of the plane times the speed (a turn costs v Δ), half the relative height times the
    speed (a Hohmann transfer costs v Δa / 2a), and half the eccentricity vector times the speed.
    Where nodes drift planes are as they are at a time.
    """
    orbits = instance.orbits()
    node = elements.nodes(orbits, time_s)
    inclination, radius = elements.inclinations(orbits, time_s), elements.radii(orbits, time_s)
    middle = float(np.median(radius))
    speed = math.sqrt(MU_M3_S2 / middle)
    normal = np.stack(
        [
            np.sin(inclination) * np.sin(node),
            -np.sin(inclination) * np.cos(node),
            np.cos(inclination),
        ],
        axis=1,
    )
    across = np.stack([np.cos(node), np.sin(node), np.zeros_like(node)], axis=1)
    ahead = np.cross(normal, across)
    perigee = elements.perigees(orbits, EPOCH_S)
    shape = np.cos(perigee)[:, None] * across + np.sin(perigee)[:, None] * ahead
    half = 0.5 * speed
    return np.concatenate(
        [
            speed * normal,
            (half / middle * radius)[:, None],
            half * elements.eccentricities(orbits, time_s)[:, None] * shape,
        ],
        axis=1,
    )


def _near(instance: Instance, ranks: int, time_s: float) -> npt.NDArray[np.int64]:
    """Destinations of each body, nearest first at a time, shape (bodies, ranks)."""
    places, bodies, first = places_of(instance, time_s), len(instance.names), instance.first_target
    stations, worthless = len(instance.stations), _is_worthless(instance)
    # Stations are near to all, and so is what must be serviced; what is worth nothing, or is the
    # start of a chaser, to none.
    wanted = np.arange(bodies) < stations
    wanted[first:] = [target.required for target in instance.targets]
    some = np.flatnonzero(~wanted & ~worthless & (np.arange(bodies) >= first))
    count = min(ranks + 1, some.size)
    rest = np.setdiff1d(np.arange(bodies), some)
    rest = np.concatenate([rest[wanted[rest]], rest[~wanted[rest]]])
    always = int(wanted.sum())
    found = np.empty((bodies, 0), dtype=np.int64)
    if count:
        found = some[KDTree(places[some]).query(places, k=np.arange(1, count + 1), workers=-1)[1]]
    everything = np.concatenate(
        [np.tile(rest[:always], (bodies, 1)), found, np.tile(rest[always:], (bodies, 1))], axis=1
    )
    # Without itself, which is among the first of its own row.
    itself = everything == np.arange(bodies)[:, None]
    order = np.argsort(itself, axis=1, kind="stable")
    near: npt.NDArray[np.int64] = np.take_along_axis(everything, order, axis=1)[:, :ranks]
    return near


class _GivenCosts(NamedTuple):
    """Least given cost of each pair that has connections, in the order of the pairs.

    Attributes
    ----------
    origin, destination : (pairs,) int64
    cost : (pairs,) float64
        [m/s].
    """

    origin: npt.NDArray[np.int64]
    destination: npt.NDArray[np.int64]
    cost: FloatArray

    def from_body(self, home: int, bodies: int) -> FloatArray:
        """Cost from a body to each; +inf without a connection."""
        found = np.full(bodies, math.inf)
        mine = self.origin == home
        found[self.destination[mine]] = self.cost[mine]
        return found


def _given_costs(instance: Instance) -> _GivenCosts:
    """Least given costs of an instance whose connections are given."""
    given = instance.given
    assert given is not None
    number = {name: body for body, name in enumerate(instance.names)}
    named = np.array([number.get(name, -1) for name in given.names], dtype=np.int64)
    origin, destination = named[np.array(np.divmod(given.pairs.pair, max(named.size, 1)))]
    known = (origin >= 0) & (destination >= 0)
    return _GivenCosts(origin[known], destination[known], given.pairs.least[known])


def _given_near(instance: Instance, ranks: int) -> npt.NDArray[np.int64]:
    """Destinations of each body, nearest first by given costs, shape (bodies, ranks).

    Stations come first, targets without a prize after the others, and those without a connection
    last, where nothing is to be built.
    """
    bodies, (origin, destination, cost) = len(instance.names), _given_costs(instance)
    worthless = _is_worthless(instance)[destination]
    kind = np.where(destination < len(instance.stations), 0, 1 + worthless)
    order = np.lexsort((destination, cost, kind, origin))
    origin, destination = origin[order], destination[order]
    begin = np.searchsorted(origin, np.arange(bodies + 1))
    near = np.empty((bodies, ranks), dtype=np.int64)
    for i in range(bodies):
        there = destination[begin[i] : begin[i + 1]]
        others = np.ones(bodies, dtype=np.bool_)
        others[there] = others[i] = False
        near[i] = np.concatenate([there, np.flatnonzero(others)])[:ranks]
    return near
