"""Check a refined plan against its instance and its plan, by the judge's own flight.

What a file says of its own quality (residuals, lowest altitudes, retargeted ΔV, runtime, notes) is
hearsay: nothing here reads it.
"""

from __future__ import annotations

from collections.abc import Iterator

from ...common.constants import DAY_S
from ...common.errors import InputError
from ...plan.plan import Plan
from ...plan.refined_plan import RefinedPlan
from ...problem.instance import AnyInstance, Instance
from ...problem.rules import CAMPAIGNS, FIRST, TOGETHER, TOURS, Follower
from ...problem.support import followed
from ..check.violation import Violation
from .bodies import check_bodies
from .flight import check_flight
from .identity import check_ephemerides, check_identity, check_legs
from .tanks import check_tanks
from .world import BodyStates, FreeMotion, reported_of

STEPS, STEPS_OF_WEEKS, WEEKS_S = 36, 16, 20.0 * DAY_S
"""Steps per revolution, and of missions no longer than some weeks. Two years end within 0.2 m of
twice as many, ten days of the fewer ones within 0.1 m; the tolerance is 10 m."""

UNJUDGED = "unjudged"
"""Rule of what cannot be judged here: the message says why."""


FOLLOWS = Follower(
    "check of refined plans", FIRST | CAMPAIGNS | TOURS | TOGETHER | {"functions of time"}
)


def check_refined(instance: AnyInstance, plan: Plan, refined: RefinedPlan) -> tuple[Violation, ...]:
    """All violations of a refined plan; if there are none, it may be flown.

    Whether the plan itself may be is for :func:`adr_opt.check` to say. What cannot be judged, as
    states of ephemerides that cannot be read, is listed under the rule ``unjudged``.

    Parameters
    ----------
    instance : Instance, path or dict
    plan : Plan
        That it was made of.
    refined : RefinedPlan

    Raises
    ------
    InputError
        The instance sets what this does not follow.
    """
    instance = followed(instance, FOLLOWS)
    foreign = (*check_identity(instance, plan, refined), *check_ephemerides(instance, refined))
    return foreign or tuple(_violations(instance, plan, refined))


def _violations(instance: Instance, plan: Plan, refined: RefinedPlan) -> Iterator[Violation]:
    yield from check_legs(instance, plan, refined)
    yield from check_tanks(instance, plan, {leg.leg: leg for leg in refined.legs})
    names = set(instance.names)
    strangers = [
        Violation(leg.leg, "body", f"{name!r} is not a body of the instance")
        for leg in refined.legs
        for name in (leg.origin, leg.destination)
        if name not in names
    ]
    yield from strangers
    try:
        reported = reported_of(instance, refined)
        yield from check_bodies(instance, refined, reported)
        if strangers:
            return
        weeks = instance.mission.duration_s <= WEEKS_S
        world = FreeMotion(refined.gravity, STEPS_OF_WEEKS if weeks else STEPS)
        places = BodyStates(world, refined, reported)
    except InputError as error:
        yield Violation(None, UNJUDGED, f"its bodies cannot be found: {error}")
    except ArithmeticError as error:
        yield Violation(None, "body", f"a body cannot be propagated: {error}")
    else:
        yield from check_flight(instance, plan, refined, world, places)
