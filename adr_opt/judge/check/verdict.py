"""Check a plan against its instance, from the instance alone.

Shares nothing with the planners but the physics of one transfer (orbits, co-elliptic sequences,
planes that drift, zones, burns) and the slack of the model: what eccentricity costs and drifts do,
departure events, the choice of the entry and the mission rules are stated here a second time, on
purpose, and plainly; so are the keep-out zones, in `zone_crossings`, from the burns alone. Where
connections are given (`given`), a leg is looked up among them as they are: those that planners
leave out count as well.

The mission is followed by a clock and a tank of its own, and the rules are asked about those, with
the slack and nothing more. The figures of the plan only have to agree with them, to the tolerances
of `violation`; so no plan gains anything by rounding its figures in its own favour, leg after leg,
and what is accepted here is what is proven about.
"""

from __future__ import annotations

from ...common.errors import InputError
from ...plan.plan import Plan
from ...problem.instance import AnyInstance
from ...problem.rules import JUDGED, Follower
from ...problem.support import followed
from .missed import check_missed
from .routes import check_legs, check_routes
from .totals import check_cost, check_model, check_totals
from .violation import Violation

FOLLOWS = Follower("check", JUDGED)


def check(instance: AnyInstance, plan: Plan) -> tuple[Violation, ...]:
    """List all violations of a plan.

    Parameters
    ----------
    instance : Instance, path or dict
    plan : Plan

    Returns
    -------
    tuple of Violation
        Empty for a legal plan, which may be flown.

    Raises
    ------
    InputError
        The plan belongs to another instance, or is only an order of bodies.
    """
    if not isinstance(plan, Plan):
        raise InputError(
            "check judges a plan with times and costs; for an order of bodies, use "
            "adr_opt.analysis.price, which makes a plan of it"
        )
    instance = followed(instance, FOLLOWS)
    plan.instance.refuse_other(instance)
    return (
        *check_model(plan),
        *check_routes(instance, plan),
        *check_legs(instance, plan),
        *check_missed(instance, plan),
        *check_totals(instance, plan),
        *check_cost(instance, plan),
    )
