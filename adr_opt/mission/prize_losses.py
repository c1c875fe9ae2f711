"""Losses of prizes in the costs of labels, so that less lost comes before less cost.

Labels along an order are compared by one number. A multiple of a unit that no cost reaches, added
to the cost, orders them by losses first: both are sums over legs. Losses are exact; costs of equal
losses are told apart by :data:`FINEST` at least.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..common.errors import InputError
from ..kernels.rules.falls import Falls

FloatArray = npt.NDArray[np.float64]


FINEST = 0.01
"""Largest difference of costs that large losses may hide [m/s or kg]."""


class PrizeLosses(NamedTuple):
    """Losses of prizes as costs of labels: so that less lost comes before less cost.

    Attributes
    ----------
    falls : Falls or None
        Of whole multiples of the unit; None if no prize falls.
    unit : float
        More than any cost, a power of two.
    step : float
        The prize that it stands for.
    """

    falls: Falls | None
    unit: float
    step: float

    @classmethod
    def of(cls, falls: Falls | None, most_cost: float) -> PrizeLosses:
        """From losses in prizes, and an upper limit on costs.

        Raises
        ------
        InputError
            Losses and costs are too large together for one number.
        """
        if falls is None:
            return cls(None, math.inf, 0.0)
        unit = 2.0 ** math.ceil(math.log2(max(most_cost, 1.0)) + 1.0)
        steps = np.rint(falls.lost / falls.unit)
        last = falls.first[1:][np.diff(falls.first) > 0] - 1
        if math.ulp(float(steps[last].sum()) * unit) > FINEST:
            raise InputError(
                f"prizes may fall by {steps[last].sum():.3g} units of {falls.unit:g}, which beside "
                f"costs of up to {most_cost:.3g} are too many; round prizes, or state less ΔV"
            )
        return cls(falls._replace(lost=steps * unit), unit, falls.unit)

    def apart(self, costs: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Losses of prizes, and costs, from the sums in labels."""
        if self.falls is None:
            return np.zeros(costs.size), costs
        lost = np.floor(costs / self.unit)
        return lost * self.step, costs - lost * self.unit
