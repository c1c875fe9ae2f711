"""What the legs of a refined plan take from each tank."""

from __future__ import annotations

import math

from ..instance import Instance
from ..refining.plan import RefinedLeg, RefinedPlan
from .result import TankFlight


def legs_by_tank(instance: Instance, refined: RefinedPlan) -> list[list[RefinedLeg]]:
    """The legs tank by tank; a tank ends with the leg to a station."""
    tanks: list[list[RefinedLeg]] = [[]]
    for leg in refined.legs:
        tanks[-1].append(leg)
        if leg.destination in instance.station_names:
            tanks.append([])
    return [legs for legs in tanks if legs]


def tanks_of(instance: Instance, refined: RefinedPlan) -> tuple[TankFlight, ...]:
    """The tanks of a refined plan, with what is planned and flown of each."""
    return tuple(
        TankFlight(
            tank=number,
            first_leg=of_tank[0].leg,
            last_leg=of_tank[-1].leg,
            budget_m_s=instance.chaser.tank.delta_v_m_s,
            planned_delta_v_m_s=math.fsum(leg.planned_delta_v_m_s for leg in of_tank),
            flown_delta_v_m_s=math.fsum(burn.size_m_s for leg in of_tank for burn in leg.burns),
        )
        for number, of_tank in enumerate(legs_by_tank(instance, refined), start=1)
    )
