"""Connections: every transfer of a pair that a chaser who is free to wait may want."""

from __future__ import annotations

import math
import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .errors import InputError
from .instance import Instance
from .kernels import connections as kernels
from .kernels.constants import HOUR_S, SLACK_S

FloatArray = npt.NDArray[np.float64]

CHOICES = {"earliest": (0.0, 1.0), "cheapest": (1.0, 0.0)}
"""Weights of ΔV and of the time of arrival that a name stands for."""

Choice = float | str
"""How one connection is chosen of many: a name, or what an hour is worth [m/s]."""


@dataclass(frozen=True)
class Connections:
    """The connections of a pair in order of departure, then of arrival.

    Attributes
    ----------
    departure, arrival : (connections,) float64
        Times since the epoch; the arrival is the end of the approach [s].
    delta_v : (connections,) float64
        [m/s].
    revolutions : (connections,) int8
        Phasing revolutions.
    """

    departure: FloatArray
    arrival: FloatArray
    delta_v: FloatArray
    revolutions: npt.NDArray[np.int8]

    def after(self, ready: float) -> Connections:
        """Those that a chaser can take that is ready at a time [s]."""
        first = int(np.searchsorted(self.departure, ready - SLACK_S))
        return Connections(
            self.departure[first:],
            self.arrival[first:],
            self.delta_v[first:],
            self.revolutions[first:],
        )


class Connecting:
    """Works out the connections of an instance, pair by pair.

    Parameters
    ----------
    instance : Instance
    """

    def __init__(self, instance: Instance) -> None:
        self._orbits = instance.orbits()
        self._extra = instance.eccentricity_delta_v()
        self._rule = instance.transfer_rule()
        self._resolution = instance.transfer.delta_v_resolution_m_s
        self._end = instance.mission.duration_s + SLACK_S

    def of_pair(self, i: int, j: int, resolution_m_s: float) -> Connections:
        """All connections of a pair; none from a body to itself."""
        if i == j:
            none = np.empty(0)
            return Connections(none, none, none, np.empty(0, dtype=np.int8))
        orbits = self._orbits
        found = kernels.of_pair(
            orbits[i], orbits[j], self._extra[i, j], self._rule, self._end, resolution_m_s
        )
        return Connections(found.departure, found.arrival, found.delta_v, found.revolutions)

    def choose(
        self,
        times: FloatArray,
        worth: float,
        time_value: float,
        delta_v: FloatArray,
        duration: FloatArray,
    ) -> None:
        """The best connections at ready times, into arrays (departure, origin, destination).

        Parameters
        ----------
        times : (departures,) float64
            [s].
        worth, time_value : float
            The best has the least worth·ΔV + time_value·arrival.
        delta_v, duration : (departures, bodies, bodies) float64
            Written: [m/s], and from ready to arrival [s].
        """

        def fill(i: int) -> None:
            for j in range(len(self._orbits)):
                if i == j:
                    delta_v[:, i, j] = duration[:, i, j] = 0.0
                    continue
                found = self.of_pair(i, j, self._resolution)
                best = kernels.best_from(
                    found.departure, found.arrival, found.delta_v, worth, time_value
                )
                first = np.searchsorted(found.departure, times - SLACK_S)
                there = first < best.size
                chosen = best[first[there]]
                delta_v[:, i, j] = duration[:, i, j] = np.inf
                delta_v[there, i, j] = found.delta_v[chosen]
                duration[there, i, j] = found.arrival[chosen] - times[there]

        with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
            list(pool.map(fill, range(len(self._orbits))))


def weights_of(choose: Choice) -> tuple[float, float]:
    """Weights of ΔV [per m/s] and of time [per s] that a choice stands for.

    Raises
    ------
    InputError
        There is no such choice.
    """
    if choose in CHOICES:
        return CHOICES[str(choose)]
    try:
        value = float(choose)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value >= 0.0):
        raise InputError(
            f"choose = {choose!r}: must be 'earliest', 'cheapest' or what an hour is worth, "
            "a number of m/s ≥ 0"
        )
    return 1.0, value / HOUR_S
