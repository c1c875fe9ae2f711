"""Claims of peers, the packages they come in, and the static costs that routing tools take."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType
from typing import NamedTuple

import numpy as np

import adr_opt
from adr_opt.common.errors import MissingExtra
from adr_opt.mission.problem import Problem


def need(package: str) -> ModuleType:
    """Import an optional package.

    Raises
    ------
    MissingExtra
        It is not installed.
    """
    try:
        return import_module(package)
    except ImportError:
        raise MissingExtra("comparing with the peers", package, "peers") from None


class Promise(NamedTuple):
    """Claims of a peer.

    Attributes
    ----------
    routes : tuple of tuple of int
        Bodies in order for each chaser, stations for refuelling.
    visits : float
        Prizes that the peer's model collects.
    bound : float
        The peer's bound on its own model; +inf for none.
    build_s, solve_s : float
        Wall times [s].
    """

    routes: tuple[tuple[int, ...], ...]
    visits: float
    bound: float
    build_s: float
    solve_s: float


STATISTICS = ("mean", "quartile", "best", "epoch", "middle")
"""Statistics that matrices are made from."""


def static_costs(mission: adr_opt.Mission, statistic: str) -> tuple[np.ndarray, np.ndarray]:
    """One matrix for all times, from samples every half hour.

    Parameters
    ----------
    mission : Mission
    statistic : {"mean", "quartile", "best", "epoch", "middle"}
        Over the ready times from which a leg exists and ends within the mission: the mean, the
        lower quartile or the least of each quantity by itself, the first time's, or that of the
        time nearest to the middle of the mission.

    Returns
    -------
    delta_v, duration : (bodies, bodies) float64
        [m/s]; from ready to the end of service [s]; +inf where there is never a transfer.
    """
    rules = mission.rules
    times = np.arange(rules.ready, max(rules.duration, rules.ready + 1.0), 1800.0)
    sampled = mission.timetable.matrices(times)
    duration = sampled.duration + rules.service
    exists = (times[:, None, None] + duration <= rules.duration) & np.isfinite(sampled.delta_v)
    count = exists.sum(axis=0)
    found = []
    for values in (sampled.delta_v, duration):
        if statistic == "mean":
            total = np.where(exists, values, 0.0).sum(axis=0)
            single = np.where(count > 0, total / np.maximum(count, 1), np.inf)
        elif statistic in ("quartile", "best"):
            ordered = np.sort(np.where(exists, values, np.inf), axis=0)
            rank = count // 4 if statistic == "quartile" else np.zeros_like(count)
            single = np.take_along_axis(ordered, rank[None], axis=0)[0]
        else:
            wanted = 0.5 * (rules.ready + rules.duration) if statistic == "middle" else times[0]
            off = np.where(exists, np.abs(times - wanted)[:, None, None], np.inf)
            nearest = np.take_along_axis(values, off.argmin(axis=0)[None], axis=0)[0]
            single = np.where(count > 0, nearest, np.inf)
        np.fill_diagonal(single, 0.0)
        found.append(single)
    return found[0], found[1]


def one_matrix(problem: Problem, statistic: str) -> tuple[np.ndarray, np.ndarray]:
    """Static costs shared by all chasers: those of the chaser that is available longest."""
    longest = max(problem.missions, key=lambda each: each.rules.duration - each.rules.ready)
    return static_costs(longest, statistic)
