"""Ephemerides of element sets, run by SGP4."""

from __future__ import annotations

from datetime import datetime

import numpy as np
import numpy.typing as npt

from ...common.errors import InputError
from ..catalogue.propagation import satellite_of
from ..catalogue.records import ElementSet
from .ephemeris import Array
from .turning import TurningAxes


class ByElements:
    """States of an element set by SGP4, at 0.7 µs each without the turning of the axes.

    The velocities are SGP4's. They are not the derivatives of its positions: 2.6 cm/s lie between
    in the median of real element sets.

    Parameters
    ----------
    body : str
        Name of the body.
    record : ElementSet
    epoch : datetime
        Of the instance.
    axes : TurningAxes
        Into the frame of the instance; shared by its bodies.
    """

    def __init__(self, body: str, record: ElementSet, epoch: datetime, axes: TurningAxes) -> None:
        self.body, self.record, self._axes = body, record, axes
        self._satellite = satellite_of(record)
        self._since_s = (epoch - record.epoch).total_seconds()

    def state(self, times_s: npt.ArrayLike) -> Array:
        """As of :class:`.ephemeris.Ephemeris`.

        Raises
        ------
        InputError
            SGP4 fails at a time; it says that the object has decayed.
        """
        times = np.asarray(times_s, dtype=np.float64)
        flat = times.ravel()
        satellite = self._satellite
        # From the satellite's own epoch on, so that no digits of the date are lost.
        days = np.full(flat.size, satellite.jdsatepoch)
        fractions = satellite.jdsatepochF + (self._since_s + flat) / 86400.0
        codes, positions, velocities = satellite.sgp4_array(days, fractions)
        states = 1e3 * np.column_stack((positions, velocities)).reshape(-1, 6)
        bad = np.flatnonzero((codes != 0) | ~np.isfinite(states).all(axis=1))
        if bad.size:
            raise InputError(self._failure(int(codes[bad[0]]), float(flat[bad[0]])))
        turned: Array = self._axes.turned(states, flat).reshape(*times.shape, 6)
        return turned

    def _failure(self, code: int, time_s: float) -> str:
        from sgp4.api import SGP4_ERRORS

        said = SGP4_ERRORS.get(code, "no finite state")
        return (
            f"{self.body!r}: SGP4 error {code} {time_s / 86400.0:.3g} days after the epoch "
            f"({said}); leave the object out, or shorten the mission"
        )
