"""Common parts of bounds by walks over packed legs: multipliers, rounding and threads.

How a walk pays for ΔV, and what its values depend on, is for each of them to say
(:mod:`.priced_walks`, :mod:`.tank_walks`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from adr_opt.common.stop import TimeIsOver
from adr_opt.mission.evidence import Evidence
from adr_opt.mission.mission import Mission

from ..networks.evidence import evidence_of
from ..networks.packed_legs import Stream, units_of
from .walks import bonuses

USUAL_SLOT_M_S = 20.0
"""Slot stated in certificates if ΔV is not tracked [m/s]."""


class BestWalks(NamedTuple):
    """Values of all states, each packed with the next body of its walk.

    Attributes
    ----------
    best : integers
        Of the best walk from each state.
    second : the same shape
        Of the best one with another next body.
    """

    best: np.ndarray
    second: np.ndarray


class StreamBound:
    """Repeated evaluation of a mission's best walks for given multipliers.

    Parameters
    ----------
    mission : Mission
    stream : Stream
        Its legs; none of them may land where it departed.
    largest : float
        No sum of values may exceed it in size, the next body included.
    dearest : float
        What a leg changes a value by at most, as a multiple of the largest prize.
    jobs : int
        Threads.
    over : callable
        Asked now and then whether the time is over.

    Attributes
    ----------
    worth : (bodies,) float64
        What services are worth.
    walk : (legs,) int64
        Best walk of the last evaluation: bodies in order.
    """

    def __init__(
        self,
        mission: Mission,
        stream: Stream,
        largest: float,
        dearest: float,
        jobs: int,
        over: Callable[[], bool],
    ) -> None:
        rules = mission.rules
        self._stream, self._jobs, self._over = stream, jobs, over
        self.worth, self._guard = np.array(rules.prize), mission.bound_guard
        self._bonuses = bonuses(mission)
        bodies = self.worth.size
        self._is_target = np.arange(bodies) >= rules.first_target
        self._is_station, self._may_end, self._start = rules.is_station, rules.may_end, rules.start
        self._units = units_of(rules.budget, stream.unit)
        self._bits = int(bodies).bit_length()
        self._greatest = float(self.worth.max(initial=0.0)) or 1.0
        self._most_legs = stream.steps // max(1, stream.least) + 2
        room = largest / (1 << self._bits) / self._most_legs / dearest / self._greatest
        # A power of two, so that units are exact numbers.
        self._unit = 2.0 ** -math.floor(math.log2(room))
        self.walk = np.empty(0, dtype=np.int64)
        self._pool = ThreadPoolExecutor(jobs) if jobs > 1 else None

    @property
    def total(self) -> float:
        """The sum of all prizes."""
        return float(self.worth[self._is_target].sum())

    @property
    def radius(self) -> float:
        """Search radius around the best multipliers."""
        return 10.0 * self._greatest

    def _within(self, multipliers: np.ndarray) -> np.ndarray:
        """Nearest multipliers at which the bound can be evaluated."""
        within: np.ndarray = np.clip(multipliers, 0.0, self.worth + self._greatest)
        within[~self._is_target] = 0.0
        return within

    def _rounded(self, multipliers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Reduced worths of services in integer units, and the corresponding multipliers.

        Multipliers are rounded down so that it is a whole number; where none is left that number is
        rounded up.
        """
        gain = np.ceil((self.worth - multipliers) / self._unit)
        rounded = np.maximum(0.0, self.worth - gain * self._unit)
        gain = np.where(rounded > 0.0, gain, np.ceil(self.worth / self._unit)).astype(np.int64)
        gain[~self._is_target], rounded[~self._is_target] = 0, 0.0
        return gain, rounded

    def _missing(self) -> np.ndarray:
        """Subgradient: one minus the walk's number of services of each target."""
        slope = 1.0 - np.bincount(self.walk, minlength=self.worth.size).astype(float)
        slope[~self._is_target] = 0.0
        return slope

    def _sweep(self, part: Callable[[int, int, int, int], None]) -> None:
        """Sweep all steps backwards, by parts of bodies: first body, stride, target and first step.

        Raises
        ------
        TimeIsOver
        """
        high = self._stream.steps
        while high > 0:
            if self._over():
                raise TimeIsOver
            # No leg that departs in these steps lands in one of them.
            low = max(0, high - self._stream.least)
            if self._pool is None:
                part(0, 1, high, low)
            else:
                parts = [
                    self._pool.submit(part, first, self._jobs, high, low)
                    for first in range(self._jobs)
                ]
                for each in parts:
                    each.result()
            high = low

    def per_m_s(self, multipliers: np.ndarray) -> float | None:
        """Price of ΔV at an evaluated point; None if there is none [worth per m/s]."""
        return None

    def evidence(self, value: float, multipliers: np.ndarray) -> Evidence:
        """Evidence of a bound at an evaluated point."""
        of_bodies = multipliers[: self.worth.size]
        most = value - math.fsum(of_bodies) + self._guard
        slot = self._stream.unit if math.isfinite(self._stream.unit) else USUAL_SLOT_M_S
        walks = evidence_of(of_bodies, [(0,)], [most], None, slot)
        (of_one,) = walks.walks
        of_one = replace(of_one, per_m_s=self.per_m_s(multipliers))
        return replace(walks, walks=(of_one,), time_step_s=self._stream.length)

    def close(self) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()
