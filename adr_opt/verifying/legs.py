"""The legs that one chaser may fly, as plain arrays: the rules of a mission, read once more."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..chasers import AtStation, Chaser
from ..checking.tow import towed_bodies
from ..connections import Connecting
from ..errors import InputError
from ..instance import Instance
from ..kernels.constants import SLACK_S
from ..kernels.orbits import LATITUDE_RATE
from .cargo import Cargo, cargo_of

FloatArray = npt.NDArray[np.float64]

LEAST_S = 1e-4
"""Walks are gone through in order of time, so legs take some: far more than the slack [s]."""


class Legs(NamedTuple):
    """Legs by pair of bodies, each pair's in order of the end of their stay, then of ΔV.

    Attributes
    ----------
    first : (bodies² + 1,) int64
        First leg of each pair, number origin · bodies + destination.
    pair : (legs,) int64
    departure, end, delta_v : (legs,) float64
        [s], end of service, or of the tow that follows it [s], [m/s].
    cheapest : (legs,) float64
        Least ΔV of the leg and those of its pair that end later [m/s].
    is_station, may_end : (bodies,) bool
        Where tanks are filled, and where the chaser may end.
    home : int
        Where it begins.
    starts : (starts,) int64
        That, and the targets that it may be launched onto.
    ready : (bodies,) float64
        Since when, at each of these [s].
    cargo : Cargo
    begun : (most kits + 1,) float64
        What there is in the tank at the start, with so many kits: a full one where the first leg
        pays for what it lacks [m/s].
    most_targets : int
        So many services are to be counted.
    shortest : float
        Least time from departure to the end of the stay [s].
    """

    first: npt.NDArray[np.int64]
    pair: npt.NDArray[np.int64]
    departure: FloatArray
    end: FloatArray
    delta_v: FloatArray
    cheapest: FloatArray
    is_station: npt.NDArray[np.bool_]
    may_end: npt.NDArray[np.bool_]
    home: int
    starts: npt.NDArray[np.int64]
    ready: FloatArray
    cargo: Cargo
    begun: FloatArray
    most_targets: int
    shortest: float


def legs_of(instance: Instance, chaser: Chaser, connecting: Connecting) -> Legs:
    """The legs of a chaser that end in time and that its tank can pay for."""
    names, first_target = instance.names, instance.first_target
    bodies, stations = len(names), len(instance.stations)
    service, tows = services_s(instance), np.zeros(bodies)
    towed = towed_bodies(instance, instance.orbits())
    for name, tow in towed.items():
        tows[names.index(name)] = tow.time_s
    begin, over = chaser.available_s
    last = min(instance.mission.duration_s, math.inf if over is None else over)
    opens, closes = np.full(bodies, -math.inf), np.full(bodies, last)
    for body, target in enumerate(instance.targets, start=first_target):
        opened, closed = target.window_s
        opens[body] = opened
        closes[body] = min(last, math.inf if closed is None else closed)
    cargo = cargo_of(instance, chaser, towed)
    # In two-body motion no connection is left out; elsewhere what saves no more than the
    # resolution is no part of the instance.
    resolution = connecting.planning_resolution_m_s
    for body, station in enumerate(instance.stations):
        if station.max_refuellings == 0:
            closes[body] = -math.inf
    home = names.index(chaser.start_name)
    columns: list[tuple[FloatArray, FloatArray, FloatArray]] = []
    sizes = np.zeros(bodies * bodies + 1, dtype=np.int64)
    for i in range(bodies):
        for j in range(bodies):
            if not _may_follow(i, j, home, stations, first_target):
                continue
            if chaser.is_launched and i == home:  # it begins at its first target
                continue
            found = connecting.of_pair(i, j, resolution)
            served = np.maximum(found.arrival, opens[j]) + service[j]
            end = served + tows[j]
            fits = (served <= closes[j] + SLACK_S) & (end <= last + SLACK_S)
            fits &= found.departure >= begin - SLACK_S
            fits &= found.delta_v <= cargo.full[0]  # a tank is worth most with nothing aboard
            order = np.lexsort((found.delta_v[fits], end[fits]))
            columns.append(
                (found.departure[fits][order], end[fits][order], found.delta_v[fits][order])
            )
            sizes[i * bodies + j + 1] = order.size
    departure, end, delta_v = (
        np.concatenate([np.empty(0), *parts]) for parts in zip(*columns, strict=True)
    )
    first = np.cumsum(sizes)
    cheapest = delta_v.copy()
    for low, high in pairwise(first):
        cheapest[low:high] = np.minimum.accumulate(cheapest[low:high][::-1])[::-1]
    may_end = np.ones(bodies, dtype=np.bool_)
    if isinstance(chaser.end, AtStation):
        may_end[:] = [name == chaser.end.station for name in names]
    pair = np.repeat(np.arange(bodies * bodies), np.diff(first))
    most = _most_targets(instance, chaser)
    starts, ready = np.array([home]), np.full(bodies, begin)
    begun = cargo.full if connecting.spent_m_s(home) else cargo.begun
    if chaser.is_launched:
        begun = cargo.begun  # no leg leads onto the first target
        served = np.maximum(begin - SLACK_S, opens) + service
        ready = served + tows
        in_time = (served <= closes + SLACK_S) & (ready <= last + SLACK_S)
        in_time &= np.arange(bodies) >= first_target
        starts = np.append(starts, np.flatnonzero(in_time)[: bodies if most else 0])
    shortest = float(np.min(end - departure, initial=math.inf))
    if shortest < LEAST_S:
        raise InputError(f"not yet verifiable: there are legs that take {shortest:g} s")
    return Legs(
        first, pair, departure, end, delta_v, cheapest, np.arange(bodies) < stations, may_end,
        home, starts, ready, cargo, begun, most, shortest,
    )  # fmt: skip


def services_s(instance: Instance) -> FloatArray:
    """How long a chaser stays at each body [s]."""
    mission, service = instance.mission, np.zeros(len(instance.names))
    for body, row in enumerate(instance.orbits()):
        at_target = body >= instance.first_target
        if at_target and mission.service_s is not None:
            service[body] = mission.service_s
            continue
        revolutions = mission.service_revolutions if at_target else mission.refuel_revolutions
        if revolutions:  # a body without an orbit has no period, and none is asked for
            service[body] = revolutions * 2.0 * math.pi / float(row[LATITUDE_RATE])
    return service


def _may_follow(i: int, j: int, home: int, stations: int, first_target: int) -> bool:
    """Whether any chaser goes from one body to another: to a station only from a target.

    Nobody goes to an orbit where chasers start, or leaves from that of another one.
    """
    if i == j or (stations <= i < first_target and i != home):
        return False
    return i >= first_target if j < stations else j >= first_target


def _most_targets(instance: Instance, chaser: Chaser) -> int:
    """So many targets it may service; all of them where the kits that it takes along say it."""
    limits = [len(instance.targets), chaser.max_targets]
    if all(target.removal == "kit" for target in instance.targets):
        if chaser.kit_mass_kg > 0.0:
            return len(instance.targets)
        limits.append(chaser.kits)
    return min(limit for limit in limits if limit is not None)
