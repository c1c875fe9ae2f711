"""Variants of the published missions, by the fields and uncertainty that episodes are drawn from.

The study has those of :data:`.fields.PUBLISHED`; variants and uncertainties are ours.
"""

from __future__ import annotations

from itertools import product

from ...common.constants import DAY_S, HOUR_S
from ...problem.uncertainty import (
    CaptureUncertainty,
    Delay,
    LegUncertainty,
    LognormalFactor,
    ServiceUncertainty,
    Uncertainty,
)
from .fields import Fields

REDUCED_FUEL = Fields("reduced-fuel")
"""50 targets, 7 days, 1 km/s."""

REDUCED_TIME = Fields("reduced-time")
"""50 targets, 3 days, 3 km/s."""

RANDOMISED = Fields(delta_v_m_s=(1000.0, 3000.0), duration_s=(3.0 * DAY_S, 7.0 * DAY_S))
"""50 targets, with a budget and a duration that are drawn for each episode between the others."""


def troubled(spread: float, success: float, delayed: float) -> Uncertainty:
    """A model of uncertainty by three numbers.

    Parameters
    ----------
    spread : float
        Of the lognormal factor on the ΔV of a leg.
    success : float
        Chance that a try at a target succeeds, of two; a quarter of the others are gone.
    delayed : float
        Chance that a service takes 4 hours more on average, at three times that spread.
    """
    return Uncertainty(
        legs=LegUncertainty(delta_v_factor=LognormalFactor(lognormal_sigma=spread)),
        service_s=ServiceUncertainty(
            factor=LognormalFactor(lognormal_sigma=3.0 * spread),
            added=Delay(chance=delayed, mean_s=4.0 * HOUR_S),
        ),
        capture=CaptureUncertainty(success=success, tries=2),
        gone=0.25 * (1.0 - success),
    )


TROUBLED = troubled(0.1, 0.8, 0.1)
"""Legs of spread 0.1, services of spread 0.3 of which one in ten is delayed, captures that succeed
with a chance of 0.8 in each of two tries, and one target in twenty gone."""

TROUBLES = tuple(
    troubled(*each) for each in product((0.0, 0.05, 0.1, 0.2), (1.0, 0.9, 0.8, 0.6), (0.0, 0.1))
)
"""Models from none to twice the trouble, of which each episode draws one."""
