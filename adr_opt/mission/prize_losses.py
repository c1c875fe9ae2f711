"""Losses of prizes in the costs of labels, so that less lost comes before less cost.

Labels along an order are compared by one number. A multiple of a unit that no cost reaches, added
to the cost, orders them by losses first, exactly: both are sums over legs.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..common.tolerance import common_step
from ..kernels.rules.falls import Falls

FloatArray = npt.NDArray[np.float64]


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
        """From losses in prizes, and an upper limit on costs."""
        if falls is None:
            return cls(None, math.inf, 0.0)
        lost = falls.lost
        unit = 2.0 ** math.ceil(math.log2(max(most_cost, 1.0)) + 1.0)
        step = common_step(lost.tolist()) or 1.0
        return cls(falls._replace(lost=np.rint(lost / step) * unit), unit, step)

    def apart(self, costs: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Losses of prizes, and costs, from the sums in labels."""
        if self.falls is None:
            return np.zeros(costs.size), costs
        lost = np.floor(costs / self.unit)
        return lost * self.step, costs - lost * self.unit
