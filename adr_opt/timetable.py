"""The timetable of an instance: exact ΔV and durations of every transfer at every time."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .errors import InputError
from .instance import Instance
from .kernels import timetable as kernels
from .kernels.constants import MU_M3_S2

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Matrices:
    """Costs sampled at ready times; the axes are (departure, origin, destination).

    Attributes
    ----------
    departures : (departures,) float64
        Ready times since the epoch [s].
    names : tuple of str
        Bodies, the station first.
    delta_v : (departures, bodies, bodies) float64
        [m/s].
    duration : (departures, bodies, bodies) float64
        From ready to arrival: wait for the node, transfer, approach; without service [s].

    Both are +inf where there is no transfer and 0 on the diagonal.
    """

    departures: FloatArray
    names: tuple[str, ...]
    delta_v: FloatArray
    duration: FloatArray


class Timetable:
    """Every transfer of an instance at every departure event (MODEL section 3).

    Parameters
    ----------
    instance : Instance
    threads : int, optional
        Threads to build with; all cores by default. The table does not depend on it.

    Attributes
    ----------
    instance : Instance
    table : adr_opt.kernels.timetable.Table
        The read-only arrays, for kernels.
    names : tuple of str
        Bodies, the station first.
    """

    def __init__(self, instance: Instance, threads: int | None = None) -> None:
        self.instance = instance
        self.names = instance.names
        bodies = instance.orbits()
        size = len(bodies)
        duration = instance.mission.duration_s
        shortest = math.pi * math.sqrt(bodies[:, 0].min() ** 3 / MU_M3_S2)
        most = int(duration / shortest) + 2
        try:
            table = kernels.Table(
                first=np.zeros((size, size)),
                spacing=np.zeros(size),
                total=np.zeros((size, size), dtype=np.int32),
                entries=np.full((size, most, size, 2), np.inf),
                revolutions=np.full((size, most, size), -1, dtype=np.int8),
            )
        except (MemoryError, ValueError):
            raise InputError(
                f"the timetable of {size} bodies over {duration / 86400:.4g} days does not fit "
                "into memory; take fewer targets or a shorter mission"
            ) from None
        extra = instance.eccentricity_delta_v()
        rule = instance.transfer_rule()

        def fill(origin: int) -> None:
            kernels.fill_row(origin, bodies, extra, rule, duration, table)

        workers = threads or os.cpu_count() or 1
        fill(0)  # compiles once, before the threads
        if workers == 1:
            for origin in range(1, size):
                fill(origin)
        else:
            with ThreadPoolExecutor(workers) as pool:
                list(pool.map(fill, range(1, size)))
        for array in table:
            array.setflags(write=False)
        self.table = table

    @property
    def entries(self) -> int:
        """Number of (pair, departure event) entries."""
        return int(self.table.total.sum())

    def index(self, body: int | str) -> int:
        """Index of a body given by index or name."""
        if isinstance(body, str):
            try:
                return self.names.index(body)
            except ValueError:
                raise InputError(f"body {body!r} is not in {self.instance.name!r}") from None
        return body

    def lookup(
        self, origin: int | str, destination: int | str, time_s: float
    ) -> tuple[float, float]:
        """The transfer of a chaser that is ready at ``origin`` at ``time_s``.

        Returns
        -------
        delta_v, arrival : float
            [m/s], [s]; both +inf where there is no transfer.
        """
        i, j = self.index(origin), self.index(destination)
        delta_v, arrival = kernels.lookup(self.table, i, j, float(time_s))
        return float(delta_v), float(arrival)

    def matrices(self, departures: Sequence[float] | FloatArray) -> Matrices:
        """Sample ΔV and duration at ready times.

        Parameters
        ----------
        departures : sequence of float
            Times since the epoch at which the chaser is ready [s].

        Raises
        ------
        InputError
            A time is negative or not finite.
        """
        times = np.atleast_1d(np.asarray(departures, dtype=float))
        if times.ndim != 1 or not np.all(np.isfinite(times) & (times >= 0.0)):
            raise InputError("departures must be a list of finite times ≥ 0 in seconds")
        size = len(self.names)
        delta_v = np.empty((times.size, size, size))
        duration = np.empty_like(delta_v)
        kernels.sample(self.table, times, delta_v, duration)
        return Matrices(times, self.names, delta_v, duration)
