"""What flights with errors take from each tank, and the share of a tank that they leave usable."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ...common.errors import InputError
from ...kernels.orbits.short_periods import Array
from ...plan.refined_plan import RefinedPlan
from ...plan.routes import several
from ...problem.instance import Instance
from ...problem.uncertainty import TankUncertainty
from ..flight.tanks import TankLegs, legs_by_tank
from .result import Dispersion, Quantile, TankDispersion

LEAST_SHARE = 0.01
"""Smallest usable share that is stated."""


def tank_dispersions(
    instance: Instance, refined: RefinedPlan, spent: Array, share: float
) -> Iterator[TankDispersion]:
    """What flights take from each tank, from the ΔV of legs, shape (legs, flights) [m/s]."""
    for one, taken in _taken(instance, refined, spent):
        legs, budget = one.legs, one.budget_m_s
        refined_m_s = math.fsum(
            part
            for leg in legs
            for part in (leg.flown_delta_v_m_s, leg.removal_m_s, leg.holding_m_s)
        )
        yield TankDispersion(
            tank=one.tank,
            first_leg=legs[0].leg,
            last_leg=legs[-1].leg,
            budget_m_s=budget,
            refined_delta_v_m_s=refined_m_s,
            delta_v_m_s=Quantile.of(taken, share),
            breaks_share=float((taken > budget).mean()),
            chaser=one.chaser.name if several(instance) else None,
        )


def usable_tank(
    instance: Instance, refined: RefinedPlan, dispersion: Dispersion
) -> TankUncertainty:
    """The usable share of a full tank that flights with errors amount to.

    A tank that planned legs leave empty, and that flights with errors drain by a factor more, is in
    terms of planned ΔV a smaller one: its share is planned over flown ΔV. The shares of all tanks
    in all flights have the mean and the standard deviation of the uniform distribution that is
    returned, unless it would end above a full tank, where it is cut off.

    Parameters
    ----------
    instance : Instance
    refined : RefinedPlan
    dispersion : Dispersion
        Of that refined plan.

    Raises
    ------
    InputError
        No tank is planned to give ΔV.
    """
    shares = [
        planned_m_s / taken
        for one, taken in _taken(instance, refined, dispersion.leg_delta_v_m_s)
        if (
            planned_m_s := math.fsum(
                leg.planned_delta_v_m_s + leg.planned_removal_m_s for leg in one.legs
            )
        )
        > 0.0
    ]
    if not shares:
        raise InputError("no leg of the plan takes ΔV: nothing is learnt of its tanks")
    drawn = np.concatenate(shares)
    half_width = math.sqrt(3.0) * float(drawn.std())
    middle = float(drawn.mean())
    least, most = (
        min(max(end, LEAST_SHARE), 1.0) for end in (middle - half_width, middle + half_width)
    )
    return TankUncertainty(least=least, most=most)


def _taken(
    instance: Instance, refined: RefinedPlan, spent: Array
) -> Iterator[tuple[TankLegs, Array]]:
    """Legs of each tank, and the ΔV that each flight takes from it [m/s]."""
    row = {leg.leg: at for at, leg in enumerate(refined.legs)}
    for one in legs_by_tank(instance, refined):
        removals_m_s = math.fsum(leg.removal_m_s + leg.holding_m_s for leg in one.legs)
        yield one, spent[[row[leg.leg] for leg in one.legs]].sum(axis=0) + removals_m_s
