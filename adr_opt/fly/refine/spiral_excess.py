"""Excess of refined spirals over the plan, as ΔV of a leg."""

from __future__ import annotations

import math
from collections.abc import Mapping

from ...plan.refined_plan import RefinedLeg, RefinedTow


def spirals_excess_m_s(leg: RefinedLeg, masses_kg: Mapping[str, float]) -> float:
    """ΔV by which a leg would have to cost more for the propellant of its spirals to be planned.

    A spiral is flown with the mass of chaser and object, m + D. With the planned ΔV x the chaser is
    left with (m + D) A − D, A = exp(−x / g₀ Isp), and in flight with less. A leg before the spiral
    is charged with what leaves as little after the planned one; a leg that follows a launch with
    the difference after it.

    Parameters
    ----------
    leg : RefinedLeg
    masses_kg : mapping of name to float
        Of objects [kg].

    Returns
    -------
    float
        Not positive where spirals took less than planned [m/s].
    """
    found = 0.0
    if leg.tow is not None and leg.tow.thrust is not None:
        object_kg = masses_kg[leg.destination]
        thrust = leg.tow.thrust
        end_kg = thrust.mass_kg - thrust.propellant_kg
        wanted = end_kg / _kept(leg.tow) - object_kg
        found += thrust.exhaust_m_s * math.log((thrust.mass_kg - object_kg) / wanted)
    before = leg.tow_before if leg.after_launch else None
    if before is not None and before.thrust is not None:
        object_kg = masses_kg[leg.origin]
        thrust = before.thrust
        planned = thrust.mass_kg * _kept(before) - object_kg
        flown = thrust.mass_kg - thrust.propellant_kg - object_kg
        found += thrust.exhaust_m_s * math.log(planned / flown)
    return found


def _kept(tow: RefinedTow) -> float:
    """Share of the mass that the planned spiral leaves."""
    assert tow.thrust is not None
    return math.exp(-tow.planned_m_s / tow.thrust.exhaust_m_s)
