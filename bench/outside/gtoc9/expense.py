"""Cost of a GTOC9 mission from its legs: propellant backwards, then millions of euros."""

from __future__ import annotations

import math
from collections.abc import Sequence

DRY_KG, KIT_KG, MOST_PROPELLANT_KG = 2000.0, 30.0, 5000.0
EXHAUST_M_S = 340.0 * 9.80665
"""Specific impulse times g₀."""

LAUNCH_MEUR = 55.0
"""Launch cost at the end of the contest; earlier submissions paid less, from 45."""

PER_KG2_MEUR = 2e-6
"""Cost per squared kilogram of launched mass beyond the dry mass."""


def launched_kg(delta_v_m_s: Sequence[float]) -> float:
    """Mass at launch of a mission by the ΔV of its legs: a kit for every debris.

    Counted backwards from the dry mass: the last kit is left after the last leg.
    """
    mass = DRY_KG + KIT_KG
    for leg in reversed(delta_v_m_s):
        mass = mass * math.exp(leg / EXHAUST_M_S) + KIT_KG
    return mass


def propellant_kg(delta_v_m_s: Sequence[float]) -> float:
    """Propellant of a mission by the ΔV of its legs."""
    return launched_kg(delta_v_m_s) - DRY_KG - KIT_KG * (len(delta_v_m_s) + 1)


def expense_meur(launched: float) -> float:
    """Cost of a mission by its mass at launch [M€]."""
    return LAUNCH_MEUR + PER_KG2_MEUR * (launched - DRY_KG) ** 2
