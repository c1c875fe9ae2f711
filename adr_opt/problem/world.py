"""Draws of one world: costs of legs, times of services, and outcomes of captures.

A draw is a function of the seed, the kind of event, the target (or the chaser and the station), and
a count alone: never of a connection, of a time, or of the order in which it is asked for. So all
policies meet the same world, and that of a clairvoyant is one deterministic mission
(docs/model.md section 13).
"""

from __future__ import annotations

import hashlib
from functools import lru_cache

import numpy as np

from ..kernels.core import draws
from .instance import Instance
from .uncertainty import LognormalFactor, Uncertainty

MASK = (1 << 64) - 1

OUTCOMES = ("serviced", "refuelled", "capture", "gone", "late", "dry")
"""Outcome of a leg, by the numbers of :mod:`adr_opt.kernels.episodes.worlds`."""


@lru_cache(maxsize=100_000)
def draw_key(*parts: str | int) -> np.uint64:
    """64 bits of the kind of an event, names, and a count: the key of a draw."""
    text = "\x00".join(f"{type(part).__name__[0]}{part}" for part in parts)
    return np.uint64(
        int.from_bytes(hashlib.blake2b(text.encode(), digest_size=8).digest(), "little")
    )


@lru_cache(maxsize=1000)
def state_of_world(seed: int) -> np.uint64:
    """State from which the draws of a world follow."""
    return np.uint64(draws.world_state(np.uint64(seed & MASK)))


def uniform(seed: int, *parts: str | int) -> float:
    """A number from (0, 1) that is a function of its arguments alone.

    Parameters
    ----------
    seed : int
        Of the world.
    *parts : str or int
        Kind of event, names, count.
    """
    return float(draws.uniform_at(state_of_world(seed), draw_key(*parts)))


class DrawnWorld:
    """One world of an uncertainty model.

    Parameters
    ----------
    instance : Instance
    uncertainty : Uncertainty
    seed : int
        Number of the world.
    """

    def __init__(self, instance: Instance, uncertainty: Uncertainty, seed: int) -> None:
        self.instance, self.uncertainty, self.seed = instance, uncertainty, seed

    def leg_factor(self, kind: str, target: str, visit: int = 1) -> float:
        """Factor on the ΔV of a leg to a target on its n-th visit."""
        return self._factor(self.uncertainty.factor_of(kind, target), "leg", target, visit)

    def station_factor(self, kind: str, chaser: str, station: str, visit: int) -> float:
        """Factor on the ΔV of a chaser's n-th leg to a station."""
        model = self.uncertainty.factor_of(kind, None)
        return self._factor(model, "station", chaser, station, visit)

    def _factor(self, model: LognormalFactor | None, *parts: str | int) -> float:
        return 1.0 if model is None else model.at(uniform(self.seed, *parts))

    def service_s(self, target: str, planned_s: float, visit: int = 1) -> float:
        """Time that a try at a target takes on its n-th visit [s]."""
        model, took_s = self.uncertainty.service_of(target), planned_s
        if model.factor is not None:
            took_s *= model.factor.at(uniform(self.seed, "service", target, visit))
        if model.added is not None:
            took_s += model.added.at(uniform(self.seed, "service-delay", target, visit))
        return took_s

    def succeeds(self, target: str, attempt: int) -> bool:
        """Whether the n-th try at a target succeeds."""
        chance = self.uncertainty.success_of(target)
        return chance >= 1.0 or uniform(self.seed, "capture", target, attempt) < chance

    def first_success(self, target: str) -> int | None:
        """Number of the first try that succeeds, of those allowed; None if none does."""
        for attempt in range(1, self.uncertainty.tries_of(target) + 1):
            if self.succeeds(target, attempt):
                return attempt
        return None

    def is_gone(self, target: str) -> bool:
        """Whether a target turns out to be gone."""
        chance = self.uncertainty.gone_of(target)
        return chance > 0.0 and uniform(self.seed, "gone", target) < chance

    def slip_s(self, chaser: str) -> float:
        """Slip of the launch of a chaser [s]."""
        model = self.uncertainty.slip_of(chaser)
        return 0.0 if model is None else model.at(uniform(self.seed, "launch", chaser))

    def usable_share(self, chaser: str, filling: int) -> float:
        """Share of a chaser's n-th full tank that can be used, the first at the start."""
        model = self.uncertainty.tanks
        return 1.0 if model is None else model.at(uniform(self.seed, "tank", chaser, filling))
