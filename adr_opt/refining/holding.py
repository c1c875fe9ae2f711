"""Whether a refined plan holds, and how much of one that does not."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ..chasers import AtStation
from ..checking.violation import DELTA_V_TOLERANCE_M_S
from ..flight.tanks import tanks_of
from ..instance import Instance
from ..mission import Mission
from ..plan import Leg, Plan, Route, Unvisited, cost_of
from ..result import status_of
from .plan import Missing, RefinedLeg, RefinedPlan, reference

MOST_MISS_M, MOST_MISS_M_S = 1.0, 1e-3
"""What a leg may miss by, as `fly` judges it."""


def troubles(mission: Mission, refined: RefinedPlan) -> tuple[str, ...]:
    """Why a refined plan does not hold; nothing if it does.

    Every leg must be there and arrive, and every tank must be enough, less the margin that is kept
    back. Times need no look: refined legs arrive when the plan says, or not at all.
    """
    return tuple(_troubles(mission, refined))


def _troubles(mission: Mission, refined: RefinedPlan) -> Iterator[str]:
    for missing in refined.missing:
        yield f"leg {missing.leg} is missing: {missing.reason}"
    for leg in refined.legs:
        if leg.residual_m > MOST_MISS_M or leg.residual_m_s > MOST_MISS_M_S:
            yield f"leg {leg.leg} misses by {leg.residual_m:.3g} m"
    for tank in tanks_of(mission.instance, refined):
        over = (tank.over_m_s or 0.0) + mission.reserve_m_s
        if over > DELTA_V_TOLERANCE_M_S:
            legs = f"legs {tank.first_leg} to {tank.last_leg}"
            yield f"tank {tank.tank} ({legs}) is over by {over:.1f} m/s"


def beginning(
    mission: Mission, plan: Plan, refined: RefinedPlan
) -> tuple[Plan, RefinedPlan] | None:
    """The longest beginning of a plan that holds and may end there; None if there is none.

    Parameters
    ----------
    mission : Mission
    plan : Plan
    refined : RefinedPlan
        Of that plan.
    """
    for count in range(len(plan.legs) - 1, 0, -1):
        legs = plan.legs[:count]
        if not _may_end(mission.instance, legs):
            continue
        kept = [leg for leg in refined.legs if leg.leg <= count]
        lost = [missing for missing in refined.missing if missing.leg <= count]
        if troubles(mission, _with(refined, refined.plan.sha256, kept, lost)):
            continue
        objective = mission.prizes(mission.numbers(leg.destination for leg in legs))
        dropped = tuple(
            Unvisited(target=leg.destination, reason="delta-v")
            for leg in plan.legs[count:]
            if leg.destination not in mission.instance.station_names
        )
        shorter = plan.replace(
            objective=objective, status=status_of(mission, objective, math.inf),
            upper_bound=None, gap=None, cost_bound=None, cost_gap=None, cost_status=None,
            cost=cost_of(mission.instance.objective, legs),
            routes=(Route(chaser=plan.routes[0].chaser, legs=legs),),
            unvisited=(*plan.unvisited, *dropped),
            notes=(*plan.notes, f"of {len(plan.legs)} legs the first {count} hold when refined"),
        )  # fmt: skip
        return shorter, _with(refined, reference(shorter).sha256, kept, lost)
    return None


def _may_end(instance: Instance, legs: tuple[Leg, ...]) -> bool:
    """Whether a mission may end after these legs, and services all required targets."""
    last, end = legs[-1].destination, instance.chaser.end
    done = {leg.destination for leg in legs}
    if any(target.required and target.name not in done for target in instance.targets):
        return False
    if isinstance(end, AtStation):
        return last == end.station
    return last not in instance.station_names


def _with(
    refined: RefinedPlan, sha256: str, legs: list[RefinedLeg], missing: list[Missing]
) -> RefinedPlan:
    """A refined plan with fewer legs."""
    known = {name for leg in legs for name in (leg.origin, leg.destination)}
    return refined.replace(
        plan=refined.plan.replace(sha256=sha256),
        status="incomplete" if missing else "complete",
        bodies=tuple(body for body in refined.bodies if body.name in known),
        legs=tuple(legs),
        missing=tuple(missing),
    )
