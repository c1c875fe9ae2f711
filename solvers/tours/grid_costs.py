"""Costs of all legs of a tour on a coarse grid of times.

A leg costs what :mod:`adr_opt.kernels.legs.drift_linear` says of it, to first order and without
phase, a fiftieth of the time of the exact form and a few per cent off. Which targets follow each
other is decided on these costs, and the times of all legs on the exact ones (:mod:`.retiming`).
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from adr_opt.common.stop import Stop
from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.legs import drift_linear
from adr_opt.kernels.orbits.ephemeris import EPOCH_S
from adr_opt.mission.problem import Problem

from .costs import FORBIDDEN, Costs, TimeGrid

UNIT_M_S = 0.1
"""ΔV of one unit of the costs [m/s]."""

STEPS = 10
"""Number of steps of the grid in the longest drift."""

FINE = 4
"""Number of lengths of transfers tried within a step."""

SLACK = 0.24
"""Extra time of transfers in planning, in steps: on the fine grid less time is lost."""

MOST_BYTES = 1.2e9
"""Maximum memory of the costs; for more, the grid is coarser [bytes]."""

WAITING = 2
"""Number of steps that a chaser may wait before a leg, where no rule limits the time of legs."""


class Steps(NamedTuple):
    """Times of the legs of a pair on a grid.

    Attributes
    ----------
    first, step : float
        First arrival, and step of the grid [s].
    stay, longest : float
        Time at a body, and of the longest transfer [s].
    least_gap : int
        Steps from an arrival to the next one, at least.
    slack : float
        How much longer transfers may take than the grid leaves room for [s].
    """

    first: float
    step: float
    stay: float
    longest: float
    least_gap: int
    slack: float


@dataclass(frozen=True)
class TourLayout:
    """Coarse grid of a tour.

    Attributes
    ----------
    steps : Steps
    times, gaps : int
        Numbers of arrivals, and of gaps between two of them.
    grid : TimeGrid
    """

    steps: Steps
    times: int
    gaps: int
    grid: TimeGrid


@kernel
def fill_pair(pair, steps, table):
    """Fill the costs of a pair.

    Parameters
    ----------
    pair : LinearPair
    steps : Steps
    table : (gaps, times) uint16
        By the gap from arrival to arrival and the earlier arrival.
    """
    gaps, times = table.shape
    lengths = math.floor(steps.longest / steps.step * FINE + 1e-6)
    best = np.empty(lengths + 1)
    table[:] = FORBIDDEN
    for arrives in range(steps.least_gap, times):
        arrival = steps.first + arrives * steps.step
        shape = drift_linear.shape_left(pair, arrival)
        best[0] = np.inf
        for s in range(1, lengths + 1):
            span = s * steps.step / FINE
            node = drift_linear.node_left_from(pair, arrival - span, arrival)
            climb = drift_linear.climb_of(pair, span, node)
            best[s] = min(best[s - 1], drift_linear.cost_of(pair, span, node, shape, climb))
        for g in range(min(gaps, arrives - steps.least_gap + 1)):
            room = (steps.least_gap + g) * steps.step - steps.stay + steps.slack
            s = min(math.floor(room / steps.step * FINE + 1e-6), lengths)
            if s > 0 and best[s] / UNIT_M_S < FORBIDDEN - 1:
                table[g, arrives - steps.least_gap - g] = np.uint16(best[s] / UNIT_M_S)


def layout_of(problem: Problem) -> TourLayout:
    """The coarse grid of a problem's tours: the stay is a whole number of its steps."""
    instance, rules = problem.instance, problem.missions[0].rules
    stay = float(rules.service[instance.first_target :].max())
    longest, limit = instance.transfer.max_drift_s, instance.transfer.max_leg_s
    since, until = instance.available_s[0]
    last = min(instance.mission.duration_s, math.inf if until is None else until) - stay
    step = longest / STEPS
    if stay > 0.5 * step:
        step = stay / max(1, round(stay / step))
    apart_s = instance.mission.mission_separation_s
    while True:
        least_gap = max(1, math.ceil(stay / step - 1e-9))
        within = stay + longest + WAITING * step if limit is None else limit
        gaps = max(1, math.floor(within / step + 1e-9) - least_gap + 1)
        times = max(1, math.floor((last - since) / step + 1e-9) + 1)
        if 2.0 * len(instance.targets) ** 2 * gaps * times <= MOST_BYTES:
            break
        step *= 2.0
    apart = -times if apart_s is None else math.ceil((stay + apart_s) / step - 1e-9)
    steps = Steps(since, step, stay, longest, least_gap, SLACK * step)
    return TourLayout(steps, times, gaps, TimeGrid(least_gap, apart, UNIT_M_S))


def costs_of(problem: Problem, layout: TourLayout, cores: int, stop: Stop) -> Costs:
    """ΔV of all legs on the grid; legs without enough time are forbidden.

    Returns
    -------
    (targets, targets, gaps, times) uint16
        [0.1 m/s], by the two targets, the gap from arrival to arrival, and the earlier arrival.
    """
    instance, ends = problem.instance, problem.connecting.ends
    count, first = len(instance.targets), instance.first_target
    found = np.full((count, count, layout.gaps, layout.times), FORBIDDEN, np.uint16)
    limits = ends.rule.min_radius, ends.rule.max_radius, ends.rule.oblateness, EPOCH_S

    def fill(i: int) -> None:
        for j in range(count):
            if i != j and stop.remaining_s() > 0.0:
                pair = drift_linear.prepare(
                    ends.leaving[first + i], ends.arriving[first + j], *limits
                )
                fill_pair(pair, layout.steps, found[i, j])

    with ThreadPoolExecutor(cores) as threads:
        list(threads.map(fill, range(count)))
    return found
