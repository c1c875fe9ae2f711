"""Plans made of other plans, for tests."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import adr_opt
from adr_opt.instance import Instance
from adr_opt.plan import Leg, Plan, Route


def with_legs(plan: Plan, legs: Iterable[Leg], **changes: Any) -> Plan:
    """The plan of one chaser with other legs and what these cost, and more fields changed."""
    legs = tuple(legs)
    chaser = plan.routes[0].chaser if plan.routes else "chaser"
    stated = {
        "routes": (Route(chaser=chaser, legs=legs),),
        "cost": float(sum(leg.delta_v_m_s for leg in legs)),
    }
    return plan.replace(**(stated | changes))


def solved(instance: Instance) -> Plan:
    """A quick plan."""
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    return plan
