"""Results of flying a refined plan many times with errors."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ...common.records import without
from ...kernels.orbits.short_periods import Array
from ..flight.flights import of_chaser
from .errors import FlightErrors

CONFIDENCE_SIGMA = 1.959964
"""Half width of the confidence interval of a quantile: 95 % of a normal distribution."""


@dataclass(frozen=True)
class Quantile:
    """A quantile of the flights, with its confidence interval.

    Attributes
    ----------
    share : float
        Of the flights that need no more than ``value``.
    value : float
        The smallest one drawn that this share of flights does not exceed.
    low, high : float or None
        An interval that holds the true quantile with a confidence of 95 %, between two of the
        drawn values, whatever their distribution; None where the flights are too few for one.
    """

    share: float
    value: float
    low: float | None
    high: float | None

    @classmethod
    def of(cls, values: Array, share: float) -> Quantile:
        """A quantile of random values, shape (n,).

        How many of n draws lie below the true quantile is binomial (H. David and H. Nagaraja,
        Order Statistics, 3rd edition, 2003, section 7.1), here by its normal approximation.
        """
        ordered = np.sort(values)
        n = ordered.size
        spread = CONFIDENCE_SIGMA * math.sqrt(n * share * (1.0 - share))
        rank = max(math.ceil(n * share), 1)
        low, high = math.floor(n * share - spread), math.ceil(n * share + spread) + 1
        return cls(
            share=share,
            value=float(ordered[rank - 1]),
            low=float(ordered[low - 1]) if low >= 1 else None,
            high=float(ordered[high - 1]) if high <= n else None,
        )

    def to_dict(self) -> dict[str, float | None]:
        """The quantile as plain data."""
        return asdict(self)


@dataclass(frozen=True)
class LegDispersion:
    """Statistics of one leg flown many times.

    Attributes
    ----------
    leg : int
        Number of the leg, from 1.
    origin, destination : str
    refined_delta_v_m_s, mean_delta_v_m_s : float
        Without errors, and the mean with them [m/s].
    delta_v_m_s : Quantile
        [m/s].
    standoff_miss_m, standoff_miss_m_s : Quantile
        Distance from the stand-off when the approach begins, before it corrects that, and speed
        relative to it.
    arrival_miss_m : Quantile
        Distance from the target when the chaser is to dock.
    waits_share : float
        Of the flights that miss the stand-off by more than half its distance from the target and
        wait a revolution there.
    target_off_m : Quantile or None
        Distance of the target from where it is planned, at the stand-off; None where that is sure.
    """

    leg: int
    origin: str
    destination: str
    refined_delta_v_m_s: float
    mean_delta_v_m_s: float
    delta_v_m_s: Quantile
    standoff_miss_m: Quantile
    standoff_miss_m_s: Quantile
    arrival_miss_m: Quantile
    waits_share: float
    target_off_m: Quantile | None = None

    def to_dict(self) -> dict[str, Any]:
        """The statistics as plain data."""
        return without(asdict(self), "target_off_m")


@dataclass(frozen=True)
class TankDispersion:
    """Statistics of one tank over many flights.

    Attributes
    ----------
    tank, first_leg, last_leg : int
        From 1.
    budget_m_s, refined_delta_v_m_s : float
        What it holds, and what its legs take without errors [m/s].
    delta_v_m_s : Quantile
        What they take with errors.
    breaks_share : float
        Of the flights that it is not enough for.
    chaser : str or None
        Whose tank it is; None where there is one chaser.
    """

    tank: int
    first_leg: int
    last_leg: int
    budget_m_s: float
    refined_delta_v_m_s: float
    delta_v_m_s: Quantile
    breaks_share: float
    chaser: str | None = None

    @property
    def holds(self) -> bool:
        """Whether the tank suffices for the requested share of flights."""
        return self.delta_v_m_s.value <= self.budget_m_s

    def to_dict(self) -> dict[str, Any]:
        """The statistics as plain data, with the chaser if there are several."""
        return of_chaser(asdict(self) | {"holds": self.holds})


@dataclass(frozen=True)
class Linearity:
    """Deviation of linearised flights from exact ones.

    Attributes
    ----------
    flights : int
        That were flown again.
    delta_v_m_s : float
        Largest difference of the ΔV of a whole flight [m/s].
    standoff_m : float
        Largest distance between their places at a stand-off [m].
    """

    flights: int
    delta_v_m_s: float
    standoff_m: float


@dataclass(frozen=True, eq=False)
class Dispersion:
    """Statistics of a refined plan flown many times with errors.

    Attributes
    ----------
    flights, seed, corrections : int
        How many; of the random numbers; burns for corrections alone after each burn.
    errors : FlightErrors
    refined_delta_v_m_s : float
        Of all legs without errors [m/s].
    delta_v_m_s : Quantile
        Of all legs with errors.
    waits_s : Quantile
        How long flights wait at stand-offs that they have missed by far, all legs together [s].
    late_share : float
        Of the flights in which such a wait does not end before the next departure.
    legs : tuple of LegDispersion
    tanks : tuple of TankDispersion
    linearity : Linearity
    leg_delta_v_m_s, leg_standoff_miss_m : (legs, flights) float64
        Each flight's [m/s], [m].
    uncertain : tuple of str
        Bodies that are elsewhere than planned.
    known_before_s : float or None
        Time before the stand-off from which it is known where they are; None: a revolution [s].
    """

    flights: int
    seed: int
    corrections: int
    errors: FlightErrors
    refined_delta_v_m_s: float
    delta_v_m_s: Quantile
    waits_s: Quantile
    late_share: float
    legs: tuple[LegDispersion, ...]
    tanks: tuple[TankDispersion, ...]
    linearity: Linearity
    leg_delta_v_m_s: Array
    leg_standoff_miss_m: Array
    uncertain: tuple[str, ...] = ()
    known_before_s: float | None = None

    @property
    def broken_tanks(self) -> tuple[TankDispersion, ...]:
        """Tanks that do not suffice for the requested share of flights."""
        return tuple(tank for tank in self.tanks if not tank.holds)

    def to_dict(self) -> dict[str, Any]:
        """The statistics as plain data: the addition of ``fly --samples N --json``."""
        targets = {"uncertain": list(self.uncertain), "known_before_s": self.known_before_s}
        return {
            "flights": self.flights,
            "seed": self.seed,
            "corrections": self.corrections,
            "errors": self.errors.to_dict(),
            **({"targets": targets} if self.uncertain else {}),
            "refined_delta_v_m_s": self.refined_delta_v_m_s,
            "delta_v_m_s": self.delta_v_m_s.to_dict(),
            "waits_s": self.waits_s.to_dict(),
            "late_share": self.late_share,
            "holds": not self.broken_tanks,
            "linearity": asdict(self.linearity),
            "tanks": [tank.to_dict() for tank in self.tanks],
            "legs": [leg.to_dict() for leg in self.legs],
        }
