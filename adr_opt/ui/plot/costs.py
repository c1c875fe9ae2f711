"""ΔV by leg: the plan's figure, the sum of its burns, and what it takes refined."""

from __future__ import annotations

import math
from typing import Any

from ...plan.leg_kinds import GIVEN, LOW_THRUST
from ...plan.phases import COLOURS
from ...plan.plan import Plan
from ...plan.refined_plan import RefinedPlan
from ...problem.instance import Instance
from .chart import Chart, ChartAxis, Columns
from .draw import draw

PLANNED, BURNED, REFINED = COLOURS["phasing"], COLOURS["terminal"], COLOURS["co-elliptic"]
MENDED = COLOURS["approach"]


def has_burns(plan: Plan) -> bool:
    """Whether burns of a plan can be set against its costs: it has some, or no leg at all."""
    kinds = {leg.kind for leg in plan.legs}
    without = {GIVEN.name, LOW_THRUST.name} & kinds
    return not without or any(leg.burns for leg in plan.legs)


def costs_chart(plan: Plan, refined: RefinedPlan | None = None) -> Chart:
    """ΔV [m/s] of each leg: planned, in burns and, for a refined plan, as flown.

    Burns are left out where the plan has none. Where legs were refined onto ephemerides, the plan's
    own burns are shown, too, as they lead to where bodies are said to be.
    """
    shown = [("planned", PLANNED, [leg.delta_v_m_s for leg in plan.legs])]
    if has_burns(plan):
        shown.append(("burns", BURNED, [leg.burns_delta_v_m_s for leg in plan.legs]))
    numbers = range(1, len(plan.legs) + 1)
    if refined is not None:
        known = {leg.leg: leg for leg in refined.legs}
        onto = refined.ephemerides is not None
        if onto:
            own = {at: leg.retargeted_delta_v_m_s for at, leg in known.items()}
            shown.append(
                ("burns onto ephemerides", MENDED, [own.get(at, math.nan) for at in numbers])
            )
        flown = {at: leg.flown_delta_v_m_s for at, leg in known.items()}
        name = "refined onto ephemerides" if onto else "refined"
        shown.append((name, REFINED, [flown.get(at, math.nan) for at in numbers]))
    columns = (
        Columns(name=name, colour=colour, x=numbers, y=values, legs=numbers, of=plan.legs)
        for name, colour, values in shown
    )
    return Chart(tuple(columns), ChartAxis("leg", 0), ChartAxis("ΔV [m/s]"))


def leg_delta_v(ax: Any, instance: Instance, plan: Plan) -> Any:
    """Add two bars per leg: its planned ΔV and the sum of its burns [m/s].

    They differ by what is set aside for eccentricity, and where a leg drifts: then the plan counts
    with a closed form. Where connections are given or legs are of low thrust, there are no burns to
    be shown.

    Raises
    ------
    InputError
        The plan belongs to another instance.
    """
    plan.instance.refuse_other(instance)
    return draw(ax, costs_chart(plan))
