"""Rules that bind one chaser, read from the instance once more."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import SLACK_S
from ...legs.connection_finder import ConnectionFinder
from ...problem.chasers import AtStation, Chaser
from ...problem.drives import drive_of
from ...problem.instance import Instance
from ..check.routes import service_s
from ..check.towed import towed_bodies
from .cargo import Cargo, StayCounts, cargo_of, counting_of
from .openings import Openings, openings_of

FloatArray = npt.NDArray[np.float64]


class Terms(NamedTuple):
    """Where a chaser may be, when, and with which resources.

    Attributes
    ----------
    names : tuple of str
        Of the bodies.
    home : int
        Where it begins.
    may_follow : (bodies, bodies) bool
        Whether legs lead from one body (row) to another one.
    begin, last : float
        From when it is there, and until when [s].
    openings : tuple of Openings
        When services may begin, by body.
    service, tows : (bodies,) float64
        How long they are, and the tows that follow them [s].
    is_station, may_end : (bodies,) bool
        Where tanks are filled, and where the chaser may end.
    starts : (starts,) int64
        Its home, and the targets that it may be launched onto.
    ready : (bodies,) float64
        Since when, at each of these [s].
    cargo : Cargo
    begun : (most kits + 1,) float64
        What there is in the tank at the start, with so many kits: a full one where the first leg
        pays for what it lacks [m/s].
    counting : StayCounts
    """

    names: tuple[str, ...]
    home: int
    may_follow: npt.NDArray[np.bool_]
    begin: float
    last: float
    openings: tuple[Openings, ...]
    service: FloatArray
    tows: FloatArray
    is_station: npt.NDArray[np.bool_]
    may_end: npt.NDArray[np.bool_]
    starts: npt.NDArray[np.int64]
    ready: FloatArray
    cargo: Cargo
    begun: FloatArray
    counting: StayCounts

    @property
    def bodies(self) -> int:
        """Number of bodies."""
        return len(self.names)


def terms_of(instance: Instance, chaser: Chaser, connecting: ConnectionFinder) -> Terms:
    """The rules of a chaser."""
    names, first_target = instance.names, instance.first_target
    bodies, stations = len(names), len(instance.stations)
    service, tows = services_s(instance), np.zeros(bodies)
    towed = towed_bodies(instance, instance.orbits(), drive_of(chaser, instance.targets))
    for name, tow in towed.items():
        tows[names.index(name)] = tow.time_s
    begin, over = chaser.available_s
    last = min(instance.mission.duration_s, math.inf if over is None else over)
    openings = openings_of(instance, service)
    cargo, home = cargo_of(instance, chaser, towed), names.index(chaser.start_name)
    may_follow = _may_follow(bodies, home, stations, first_target)
    if chaser.is_launched:  # it begins at its first target
        may_follow[home] = False
    may_end = np.ones(bodies, dtype=np.bool_)
    if isinstance(chaser.end, AtStation):
        may_end[:] = [name == chaser.end.station for name in names]
    counting = counting_of(instance, chaser)
    starts, ready = np.array([home]), np.full(bodies, begin)
    begun = cargo.full if connecting.spent_m_s(home) else cargo.begun
    if chaser.is_launched:
        begun = cargo.begun  # no leg leads onto the first target
        served = [float(opening.begins(begin - SLACK_S)) for opening in openings]
        ready = np.array(served) + service + tows
        in_time = ready <= last + SLACK_S
        in_time &= np.arange(bodies) >= first_target
        in_time &= np.all(counting.adds <= counting.most[:, None], axis=0)
        starts = np.append(starts, np.flatnonzero(in_time))
    return Terms(
        names,
        home,
        may_follow,
        begin,
        last,
        openings,
        service,
        tows,
        np.arange(bodies) < stations,
        may_end,
        starts,
        ready,
        cargo,
        begun,
        counting,
    )


def flown_from(
    i: int, terms: Terms, connecting: ConnectionFinder
) -> Iterator[tuple[int, FloatArray, FloatArray, FloatArray]]:
    """Legs that continue from a body in time and within a tank, by destination.

    Yields
    ------
    destination : int
    departure, end, delta_v : (legs,) float64
        In order of departure; the end is that of the service, or of the tow that follows it [s],
        [s], [m/s].
    """
    # In two-body motion no connection is left out; elsewhere what saves no more than the
    # resolution is no part of the instance.
    resolution = connecting.planning_resolution_m_s
    for j in np.flatnonzero(terms.may_follow[i]).tolist():
        found = connecting.of_pair(i, j, resolution)
        end = terms.openings[j].begins(found.arrival) + terms.service[j] + terms.tows[j]
        fits = end <= terms.last + SLACK_S
        fits &= found.departure >= terms.begin - SLACK_S
        fits &= found.delta_v <= terms.cargo.full[0]  # a tank is worth most with nothing aboard
        yield j, found.departure[fits], end[fits], found.delta_v[fits]


def services_s(instance: Instance) -> FloatArray:
    """Length of a chaser's stay at each body [s]."""
    rows, first = instance.orbits(), instance.first_target
    return np.array([service_s(instance, row, body < first) for body, row in enumerate(rows)])


def _may_follow(bodies: int, home: int, stations: int, first_target: int) -> npt.NDArray[np.bool_]:
    """Mask of allowed moves from one body (row) to another: to a station only from a target.

    Nobody goes to an orbit where chasers start, or leaves from that of another one.
    """
    body = np.arange(bodies)
    is_target, is_station = body >= first_target, body < stations
    leaves = is_target | is_station | (body == home)
    may: npt.NDArray[np.bool_] = np.outer(leaves, is_target) | np.outer(is_target, is_station)
    may[body, body] = False
    return may
