"""Costs of all pairs sampled at ready times, as matrices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..common.card import Shown
from ..common.constants import SLACK_M_S, SLACK_S

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False, eq=False)
class Matrices(Shown):
    """Costs sampled at ready times, with axes (departure, origin, destination).

    Attributes
    ----------
    departures : (departures,) float64
        Ready times since the epoch [s].
    names : tuple of str
        Bodies, the stations first.
    delta_v : (departures, bodies, bodies) float64
        [m/s].
    duration : (departures, bodies, bodies) float64
        From ready to arrival: wait, transfer, approach; without service [s].
    choice : str
        The choice of transfers, in words.

    ``delta_v`` and ``duration`` are +inf where there is no transfer, and 0 on the diagonal. Two
    objects are equal if all digits and the choice are equal; :meth:`allclose` allows for rounding.
    The arrays are writable, so objects have no hash.
    """

    departures: FloatArray
    names: tuple[str, ...]
    delta_v: FloatArray
    duration: FloatArray
    choice: str

    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Matrices):
            return NotImplemented
        if (self.names, self.choice) != (other.names, other.choice):
            return False
        return all(
            np.array_equal(getattr(self, name), getattr(other, name))
            for name in ("departures", "delta_v", "duration")
        )

    def allclose(
        self, other: Matrices, *, delta_v_m_s: float = SLACK_M_S, time_s: float = SLACK_S
    ) -> bool:
        """Whether two objects have equal bodies, departures and costs, within tolerances.

        Costs are compared, not the choice of transfers; if one has no transfer, the other must have
        none either.

        Parameters
        ----------
        other : Matrices
        delta_v_m_s, time_s : float
            Largest difference of each ΔV [m/s], and of each departure and duration [s]; by default
            the slack of the model.
        """
        if self.names != other.names or self.delta_v.shape != other.delta_v.shape:
            return False
        return all(
            np.allclose(getattr(self, name), getattr(other, name), rtol=0.0, atol=most)
            for name, most in (
                ("departures", time_s),
                ("delta_v", delta_v_m_s),
                ("duration", time_s),
            )
        )
