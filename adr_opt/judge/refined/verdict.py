"""Check a refined plan against its instance and its plan, by the judge's own flight.

First whether it is one of the plan: the same legs, times, tows and chasers. What a file says of its
own quality (residuals, lowest altitudes, retargeted ΔV, runtime, notes) is hearsay: nothing here
reads it.
"""

from __future__ import annotations

from collections.abc import Iterator

from ...common.constants import DAY_S
from ...common.errors import InputError
from ...plan.launched import as_launched
from ...plan.plan import Leg, Plan, Tow
from ...plan.refined_plan import Freedom, RefinedLeg, RefinedPlan, RefinedTow, reference
from ...problem.instance import AnyInstance, Instance
from ...problem.rules import CAMPAIGNS, FIRST, MODELLED, RELEASES, TOGETHER, TOURS, Follower
from ...problem.support import followed
from ..check.violation import TIME_TOLERANCE_S, Violation
from .flight import check_flight
from .tanks import chasers_of, check_tanks
from .world import BodyStates, FreeMotion, check_bodies, reported_of

SAME_M_S = 1e-6
"""Tolerance between the ΔV of a plan in its own file and in the refined plan's."""


def check_identity(instance: Instance, plan: Plan, refined: RefinedPlan) -> Iterator[Violation]:
    """Check that a refined plan belongs to an instance and a plan."""
    named = refined.instance
    if not named.is_of(instance):
        yield Violation(
            None,
            "instance",
            f"it belongs to the instance {named.name!r} (sha256 {named.sha256[:12]}…), not to "
            f"{instance.name!r} (sha256 {instance.sha256[:12]}…)",
        )
    stated, true = refined.plan, reference(plan)
    if stated != true:
        yield Violation(
            None,
            "plan",
            f"it was made of a plan by {stated.method!r} with seed {stated.seed} (sha256 "
            f"{stated.sha256[:12]}…), not of this one by {true.method!r} with seed {true.seed} "
            f"(sha256 {true.sha256[:12]}…)",
        )


def check_ephemerides(instance: Instance, refined: RefinedPlan) -> Iterator[Violation]:
    """Check that a refined plan uses the ephemerides of the instance."""
    its, onto = instance.ephemerides, refined.ephemerides
    if onto is not None and (its is None or (its.kind, its.sha256) != (onto.kind, onto.sha256)):
        yield Violation(
            None,
            "ephemerides",
            f"it was refined onto ephemerides (sha256 {onto.sha256[:12]}…) that are not those of "
            f"{instance.name!r}",
        )


def check_legs(instance: Instance, plan: Plan, refined: RefinedPlan) -> Iterator[Violation]:
    """Check that the legs are those of the plan at its times, none missing and none extra."""
    known = {leg.leg: leg for leg in refined.legs}
    reasons = {missing.leg: missing.reason for missing in refined.missing}
    wanted = set()
    for chaser, legs in chasers_of(instance, plan):
        before: Leg | None = None
        for number, leg in legs:
            if not leg.traits.has_burns and not leg.traits.has_arcs:
                before = leg
                continue
            wanted.add(number)
            if number in known:
                name = chaser.name if len(instance.chasers) > 1 else None
                yield from _check_leg(known[number], leg, before, name)
                yield from _check_phases(known[number], leg, refined.freedom)
            elif number not in reasons:  # one that the file says to be missing claims nothing
                yield Violation(number, "missing", "it is neither refined nor listed as missing")
            before = leg
    for number in sorted(set(known) - wanted):
        yield Violation(number, "extra", "the plan has no such leg to be refined")
    for number in sorted(set(reasons) & set(known)):
        yield Violation(number, "missing", "it is refined, but is listed as missing")
    for number in sorted(set(reasons) - wanted):
        yield Violation(number, "missing", "the plan has no such leg to be refined")
    if len(reasons) < len(refined.missing):
        yield Violation(None, "missing", "a leg is listed as missing twice")
    yield from _check_bodies(refined)


def _check_bodies(refined: RefinedPlan) -> Iterator[Violation]:
    """Check that each body occurs once, and on a leg if no leg is missing."""
    names = [body.name for body in refined.bodies]
    for name in sorted({name for name in names if names.count(name) > 1}):
        yield Violation(None, "body", f"{name!r} has more than one state at the epoch")
    if not refined.missing:
        used = {name for leg in refined.legs for name in (leg.origin, leg.destination)}
        for name in sorted(set(names) - used):
            yield Violation(None, "body", f"{name!r} is on no leg")


def _check_leg(
    found: RefinedLeg, leg: Leg, before: Leg | None, chaser: str | None
) -> Iterator[Violation]:
    """Check one leg against that of the plan, and the tows beside it."""
    number, led = found.leg, None if before is None else before.tow
    launched = before is not None and before.traits.from_nowhere
    vented = leg.vented_kg or None
    if launched and before is not None:
        vented = before.vented_kg or vented
    for name, stated, true in (
        ("kind", found.kind, leg.kind),
        ("origin", found.origin, leg.origin),
        ("destination", found.destination, leg.destination),
        ("chaser", found.chaser, chaser),
        ("vented_kg", found.vented_kg, vented),
        ("after_launch", found.after_launch, True if launched and led is not None else None),
    ):
        if stated != true:
            yield Violation(number, "leg", f"{name} = {stated!r}, but in the plan {true!r}")
    if abs(found.planned_delta_v_m_s - leg.delta_v_m_s) > SAME_M_S:
        yield Violation(
            number,
            "leg",
            f"planned_delta_v_m_s = {found.planned_delta_v_m_s!r}, but in the plan "
            f"{leg.delta_v_m_s!r}",
        )
    for name, stated_s, true_s in _times(found, leg, led):
        if abs(stated_s - true_s) > TIME_TOLERANCE_S:
            yield Violation(number, "time", f"{name} = {stated_s!r}, but in the plan {true_s!r}")
    if [burn.time_s for burn in found.burns if burn.time_s < found.states[0].time_s]:
        yield Violation(number, "time", "a burn comes before the departure")
    yield from _check_tow(number, "tow", found.tow, leg.tow, leg.end_s)
    ready_s = 0.0 if before is None else before.end_s
    yield from _check_tow(number, "tow_before", found.tow_before, led, ready_s)


def _check_phases(found: RefinedLeg, leg: Leg, freedom: Freedom) -> Iterator[Violation]:
    """Check the phases of burns: free ones are ``transfer``, others as in the plan."""
    planned = {burn.time_s: burn.phase for burn in reversed(leg.burns)}
    stated = [burn.phase for burn in found.burns]
    begun = stated.index("approach") if "approach" in stated else len(stated)
    true = [
        "approach"
        if at >= begun
        else "transfer"
        if freedom == "free"
        else planned.get(burn.time_s, "transfer")
        for at, burn in enumerate(found.burns)
    ]
    if stated != true:
        yield Violation(found.leg, "leg", f"phases are {stated}, but should be {true}")


def _times(found: RefinedLeg, leg: Leg, led: Tow | None) -> Iterator[tuple[str, float, float]]:
    """Times of a leg: name, stated value, and value by the plan [s]."""
    start_s, docked_s = leg.leaves_s, leg.docked_s
    if leg.manoeuvres is not None:
        standoff_s = leg.manoeuvres[-1].end_s
    else:
        standoff_s = docked_s if leg.standoff_s is None else leg.standoff_s
    yield "departure", found.states[0].time_s, start_s
    yield "standoff_s", found.standoff_s, standoff_s
    yield "arrival_s", found.arrival_s, docked_s
    yield "end_s", found.end_s, max(leg.end_s, docked_s)
    yield "ready_s", found.ready_s, start_s if led is not None else min(leg.ready_s, start_s)


def _check_tow(
    number: int, field: str, found: RefinedTow | None, planned: Tow | None, ready_s: float
) -> Iterator[Violation]:
    """Check a tow against that of the plan: its burns are as large and at the same times.

    A spiral may begin earlier than planned, but not before the chaser is ready.
    """
    if found is None or planned is None:
        if (found is None) != (planned is None):
            has = "has no" if planned is None else "has a"
            yield Violation(number, "tow", f"{field}: the plan {has} tow there")
        return
    ends_s = planned.burns[-1].time_s if planned.burns else planned.end_s
    if abs(found.released.time_s - ends_s) > TIME_TOLERANCE_S:
        yield Violation(
            number,
            "tow",
            f"{field}: releases at {found.released.time_s!r}, but in the plan at {ends_s!r}",
        )
    if (found.thrust is None) != bool(planned.burns):
        yield Violation(number, "tow", f"{field}: has burns or thrust that the plan does not have")
    elif found.thrust is not None:
        if found.start_s < ready_s - TIME_TOLERANCE_S:
            yield Violation(number, "tow", f"{field}: begins before the service is over")
        if abs(found.planned_m_s - planned.delta_v_m_s) > SAME_M_S:
            yield Violation(
                number,
                "tow",
                f"{field}: planned_delta_v_m_s = {found.planned_m_s!r}, but in the plan "
                f"{planned.delta_v_m_s!r}",
            )
    else:
        aimed = found.planned_delta_v_m_s is not None
        if aimed and abs(found.planned_m_s - planned.delta_v_m_s) > SAME_M_S:
            yield Violation(
                number,
                "tow",
                f"{field}: planned_delta_v_m_s = {found.planned_m_s!r}, but in the plan "
                f"{planned.delta_v_m_s!r}",
            )
        if [made.phase for made in found.burns] != [wanted.phase for wanted in planned.burns]:
            yield Violation(number, "tow", f"{field}: has other burns than in the plan")
        for made, wanted in zip(found.burns, planned.burns, strict=False):
            late = abs(made.time_s - wanted.time_s)
            # A lowered perigee is aimed at by burns of their own size.
            off = 0.0 if aimed else abs(made.size_m_s - wanted.size_m_s)
            if late > TIME_TOLERANCE_S or off > SAME_M_S:
                yield Violation(
                    number,
                    "tow",
                    f"{field}: a burn is off that of the plan by {late:.3g} s and {off:.3g} m/s",
                )


STEPS, STEPS_OF_WEEKS, WEEKS_S = 36, 16, 20.0 * DAY_S
"""Steps per revolution, and of missions no longer than some weeks. Two years end within 0.2 m of
twice as many, ten days of the fewer ones within 0.1 m; the tolerance is 10 m."""

UNJUDGED = "unjudged"
"""Rule of violations that say why a refined plan cannot be judged."""


FOLLOWS = Follower(
    "check of refined plans",
    FIRST
    | CAMPAIGNS
    | MODELLED
    | TOURS
    | TOGETHER
    | RELEASES
    | {"functions of time", "functions of time for several chasers", "capture windows"},
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
    instance = as_launched(instance, plan)
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
