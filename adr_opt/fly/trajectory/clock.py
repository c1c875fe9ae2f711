"""Calendar times of a trajectory, in UTC."""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np
import numpy.typing as npt

from ...common.errors import InputError
from ...problem.instance import Instance
from .kepler import Array
from .sampling import Arc

MICROSECONDS = 1_000_000


class UtcClock:
    """Seconds since the epoch of an instance as UTC, to the microsecond.

    Every day has 86,400 s: a leap second between the epoch and a time would put the time one
    second off. None has been inserted since 2017, and none is announced.
    """

    def __init__(self, instance: Instance) -> None:
        epoch = instance.epoch.astimezone(UTC).replace(tzinfo=None)
        self._epoch = np.datetime64(epoch, "us")
        self._first_s = (datetime.min - epoch).total_seconds()
        self._last_s = (datetime.max - epoch).total_seconds()

    def labels(self, times_s: npt.ArrayLike) -> list[str]:
        """Times like 2026-01-01T00:00:00.000000.

        Raises
        ------
        InputError
            A time is not in the years 1 to 9999.
        """
        times = np.atleast_1d(np.asarray(times_s, dtype=float))
        if not bool(np.all((times >= self._first_s) & (times < self._last_s))):
            raise InputError("the plan leaves the years 1 to 9999 of calendar times")
        ticks = np.rint(times * MICROSECONDS).astype("timedelta64[us]")
        return [str(label) for label in np.datetime_as_string(self._epoch + ticks, unit="us")]

    def label(self, time_s: float) -> str:
        """A time as such a label."""
        return self.labels([time_s])[0]


def states_at_labels(arc: Arc) -> tuple[Array, Array]:
    """Positions of an arc and their rates at its times, rounded as in labels, to the microsecond.

    Between a time and its label lie up to 0.5 µs, or 4 mm of way: too much to leave. The motion
    between them is a straight line to a nanometre.
    """
    late = (np.rint(arc.times_s * MICROSECONDS) / MICROSECONDS - arc.times_s)[:, None]
    rates = arc.rates_m_s
    return arc.positions_m + late * rates, rates
