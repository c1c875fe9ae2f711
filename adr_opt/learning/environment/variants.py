"""Variants of the published missions, by the fields and uncertainty that episodes are drawn from.

The study has those of :data:`.fields.PUBLISHED`; variants and uncertainties are ours.
"""

from __future__ import annotations

from ...common.constants import DAY_S
from .fields import Fields

REDUCED_FUEL = Fields("reduced-fuel")
"""50 targets, 7 days, 1 km/s."""

REDUCED_TIME = Fields("reduced-time")
"""50 targets, 3 days, 3 km/s."""

RANDOMISED = Fields(delta_v_m_s=(1000.0, 3000.0), duration_s=(3.0 * DAY_S, 7.0 * DAY_S))
"""50 targets, with a budget and a duration that are drawn for each episode between the others."""
