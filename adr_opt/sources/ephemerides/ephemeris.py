"""An ephemeris: states of a body at times of the mission."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

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
        """States at times, of the shape of the times and one axis of six more [m, m/s].

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
