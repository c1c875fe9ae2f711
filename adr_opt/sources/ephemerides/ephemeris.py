"""An ephemeris: states of a body at times of the mission, and the rotation of its axes.

SGP4 gives states in TEME of their own date, and so do ephemerides without an epoch of their frame.
Those axes turn by 34 m in low orbit within a week, and by 1.8 km within a year.
"""

from __future__ import annotations

from datetime import datetime, timedelta
from typing import Protocol

import numpy as np
import numpy.typing as npt

from ...common.constants import DAY_S
from ...problem.frame import Frame
from ...problem.frame_rotation import from_gcrf, teme_axes

Array = npt.NDArray[np.float64]


class Ephemeris(Protocol):
    """States of a body in the inertial frame of an instance.

    Attributes
    ----------
    body : str
        Name of the body.
    """

    body: str

    def state(self, times_s: npt.ArrayLike) -> Array:
        """States at times, with the shape of the times plus an axis of six [m, m/s].

        Parameters
        ----------
        times_s : array_like
            Since the epoch of the instance, in days of 86,400 s.

        Raises
        ------
        InputError
            The ephemeris does not cover a time.
        """
        ...


STEP_S = 0.25 * DAY_S
"""Spacing of the times between which the rotation is interpolated; fortnightly nutation is then
right to 0.1 mm in low orbit."""

NEIGHBOURS = 4
"""Number of nodes of an interpolation."""


class TurningAxes:
    """Rotation from TEME of date into a fixed frame.

    Parameters
    ----------
    epoch : datetime
        Of the instance.
    frame : Frame
        The fixed frame.
    """

    def __init__(self, epoch: datetime, frame: Frame) -> None:
        self._epoch, self._fixed = epoch, from_gcrf(frame)
        self._first, self._matrices = 0, np.empty((0, 3, 3))

    def turned(self, states: Array, times_s: Array) -> Array:
        """States in TEME of their dates, shape (times, 6), in the fixed frame.

        The axes turn by 1e-11 rad/s, which is nothing to velocities.
        """
        if times_s.size == 0:
            return states
        places = times_s / STEP_S
        self._reach(int(np.floor(places.min())) - 1, int(np.floor(places.max())) + 2)
        left = np.floor(places).astype(int) - 1
        matrices = np.zeros((times_s.size, 3, 3))
        for one in range(NEIGHBOURS):
            weight = np.ones(times_s.size)
            for other in range(NEIGHBOURS):
                if other != one:
                    weight *= (places - left - other) / (one - other)
            matrices += weight[:, None, None] * self._matrices[left - self._first + one]
        vectors = states.reshape(-1, 2, 3)
        turned: Array = np.einsum("tij,tkj->tki", matrices, vectors).reshape(-1, 6)
        return turned

    def _reach(self, first: int, last: int) -> None:
        """Compute missing rotations at all steps of a range."""
        known = len(self._matrices)
        if known and self._first <= first and last < self._first + known:
            return
        if known:
            first, last = min(first, self._first), max(last, self._first + known - 1)
        dates = [self._epoch + timedelta(seconds=STEP_S * at) for at in range(first, last + 1)]
        self._first = first
        self._matrices = np.einsum("ij,tkj->tik", self._fixed, teme_axes(dates))
