"""Lagrangian bound of a campaign: best walks of all chasers under common multipliers.

With multipliers π of "each target at most once", by any chaser,

    prizes collected ≤ Σ π + Σ over chasers of the best walk that is worth prize − π at each target,

and chasers of one kind have the same best walk.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Generic, TypeVar

import numpy as np

from adr_opt.mission.evidence import Evidence
from adr_opt.mission.problem import Problem

from ..networks.evidence import evidence_of
from ..walks.walks import WalkBound

Walks = TypeVar("Walks", bound=WalkBound)


class CampaignBound(Generic[Walks]):
    """Best walks of all chaser types for given multipliers, as needed by a descent.

    Kinds that move on one network share its walks.

    Parameters
    ----------
    problem : Problem
    delta_v_slot_m_s : float
        Slot of the ΔV axis [m/s].
    jobs : int
        Threads.
    over : callable
        Asked now and then whether the time is over.
    kind : callable
        Makes the bounds of walks.
    known : CampaignBound, optional
        One whose networks are shared.

    Attributes
    ----------
    walks : tuple of WalkBound
        Of each network.
    of_kind : tuple of (WalkBound, int)
        That each kind is in, and its number there.
    evidence : Evidence or None
        What the least bound of all so far rests on.
    """

    def __init__(
        self,
        problem: Problem,
        delta_v_slot_m_s: float,
        *,
        jobs: int,
        over: Callable[[], bool],
        kind: Callable[..., Walks],
        known: CampaignBound[Walks] | None = None,
    ) -> None:
        bounds: list[Walks] = []
        places: dict[int, tuple[Walks, int]] = {}
        for number, kinds in enumerate(problem.networks):
            earliest, *others = (problem.kinds[kind].mission for kind in kinds)
            network = None if known is None else known.walks[number].network
            bounds.append(
                kind(
                    earliest, delta_v_slot_m_s, jobs=jobs, over=over, network=network, others=others
                )
            )
            places |= {kind: (bounds[-1], start) for start, kind in enumerate(kinds)}
        self.walks: tuple[Walks, ...] = tuple(bounds)
        for walks in bounds:
            walks.is_paid = walks.is_target | walks.network.is_station
        self.of_kind = tuple(places[kind] for kind in range(len(problem.kinds)))
        self._guard = problem.bound_guard / len(problem.missions)
        self._counts = [len(kind.chasers) for kind in problem.kinds]
        self._chasers = [kind.chasers for kind in problem.kinds]
        self._least = math.inf
        self.evidence: Evidence | None = None
        # Multipliers that are exact in the coarsest unit are exact in all.
        self._coarsest_first = sorted(bounds, key=lambda bound: -bound.unit)
        first = bounds[0]
        self.prize, self.is_target = first.prize, first.is_target
        self.dimensions, self.total, self.radius = first.dimensions, first.total, first.radius
        self.first_point, self.allowed = first.first_point, first.allowed

    def at(self, point: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """Bound near a point, with its exact multipliers and its subgradient."""
        for bound in self._coarsest_first:
            _, point = bound.evaluate(point)
        slope, values = np.ones(self.dimensions), np.zeros(len(self.of_kind))
        for kind, (bound, start) in enumerate(self.of_kind):
            values[kind], walk = bound.best_from(start)
            slope -= self._counts[kind] * np.bincount(walk, minlength=slope.size)
        slope[~self.is_target] = 0.0
        found = -math.inf
        if not np.isneginf(values).any():
            found = math.fsum([*point, *(self._counts * values)])
        if found < self._least:
            self._least = found
            self.evidence = evidence_of(
                point,
                self._chasers,
                [float(value) + self._guard for value in values],
                None,
                self.walks[0].slot,
            )
        return found, point, slope

    @property
    def largest_gain(self) -> float:
        """Upper limit on the worth of any target to any walk."""
        return min(bound.greatest_prize for bound in self.walks)

    def close(self) -> None:
        """End the threads."""
        for bound in self.walks:
            bound.close()
