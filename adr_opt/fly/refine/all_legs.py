"""Refinement of a plan: all legs guided to their stand-offs in true dynamics, in parallel."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from types import MappingProxyType
from typing import NamedTuple, cast

import numpy as np

from ...common.clock import now_s
from ...common.errors import InputError
from ...common.processors import usable_cores
from ...judge.admit import Admitted, AnyPlan, admit
from ...mission.result import versions
from ...plan.launched import as_launched
from ...plan.plan import InstanceReference, Leg, Plan
from ...plan.refined_plan import (
    BodyState,
    EphemeridesReference,
    Freedom,
    Gravity,
    Missing,
    RefinedLeg,
    RefinedPlan,
    reference,
)
from ...plan.routes import owners, routes_of
from ...problem.instance import AnyInstance, Instance
from ...problem.support import followed
from ...study import check_jobs
from ...study.cluster import Cluster
from ..flight.flyable import REFINED, refuse_broken_chain, refuse_what_cannot_be_refined
from .bodies import MovingBodies, TrueBodies
from .one_leg import refine_leg
from .reported import DEFAULT_GRAVITY, ReportedBodies, holding_m_s, opened
from .spiral import NoSpiral, spirals_by_leg
from .thrust_leg import Tows, refine_thrust_leg
from .thrust_task import propelled_by_leg

GRAVITIES = ("two-body", "j2", "j3", "j4")
FREEDOMS = ("free", "planned")

INTERRUPTED = "interrupted"
"""Reason for a leg that was not reached in time."""

POLL_S = 0.1
"""Interval at which the stopping criterion is queried [s]."""

Report = Callable[[int, int], None]


class Wanted(NamedTuple):
    """Parameters of :func:`refine`."""

    gravity: Gravity | None
    freedom: Freedom | None
    jobs: int | None
    cluster: str | None
    enough: Callable[[], bool]
    report: Report
    ephemerides: bool = False


class KnownBodies(NamedTuple):
    """Where legs begin and end.

    ``holding`` is the ΔV of holding by leg [m/s], of legs between ephemerides.
    """

    bodies: MovingBodies
    onto: EphemeridesReference | None = None
    holding: Mapping[int, float] = MappingProxyType({})


def refine(  # noqa: PLR0913
    instance: AnyInstance,
    plan: AnyPlan,
    *,
    gravity: Gravity | None = None,
    freedom: Freedom | None = None,
    jobs: int | None = None,
    cluster: str | None = None,
    enough: Callable[[], bool] = lambda: False,
    report: Report = lambda done, total: None,
    ephemerides: bool = False,
) -> RefinedPlan:
    """Turn a plan into a trajectory in true dynamics, leg by leg.

    Each leg begins docked with its origin on the origin's true orbit at its first burn, keeps the
    plan's times of stand-off and arrival, and ends docked with its destination on the
    destination's true orbit.

    Parameters
    ----------
    instance : Instance, path or dict
    plan : Plan or Admitted
        Free of violations, unless it was let in unjudged (:func:`adr_opt.judge.admit.admit`).
    gravity : {"two-body", "j2", "j3", "j4"}, optional
        The field, with zonal harmonics up to the one that is named; that of the instance's
        dynamics by default, and with ephemerides "j4".
    freedom : {"free", "planned"}, optional
        ``free``: the least ΔV, with impulses at any time from a leg's first burn to its stand-off,
        between the altitude limits of the instance. ``planned``: the plan's burns, at their times
        and kept near what they were. By default free, unless there are keep-out zones, which only
        the plan's burns are known to avoid.
    jobs : int, optional
        Threads; all cores by default.
    cluster : str, optional
        Address of a Dask scheduler whose workers take the legs instead, as
        :func:`adr_opt.study.cluster.client_of` takes it.
    enough : callable
        Called between legs; once it returns True, the legs refined so far are returned.
    report : callable
        Called with the number of finished legs and the total.
    ephemerides : bool
        Whether legs begin and end at the states of their bodies in the ephemerides beside the
        instance, instead of those that follow from mean elements. The ΔV of holding there is
        estimated.

    Returns
    -------
    RefinedPlan
        Legs for which no trajectory was found, or that come down below the limit of altitude, or
        for which no time was left, are among its ``missing``.

    Raises
    ------
    InputError
        The plan belongs to another instance or has violations, its legs cannot be flown or do not
        follow each other, or a parameter has an unknown value. With ephemerides: there are none,
        they do not match the instance's digest, or a leg has low thrust.
    """
    wanted = Wanted(gravity, freedom, jobs, cluster, enough, report, ephemerides)
    return refined_again(admit(followed(instance, REFINED), plan), wanted, {})


def refined_again(
    admitted: Admitted[Plan], wanted: Wanted, known: dict[Hashable, RefinedLeg]
) -> RefinedPlan:
    """Refine a plan, reusing legs of low thrust that are known from another plan.

    Parameters
    ----------
    admitted : Admitted
        The plan, with its instance.
    wanted : Wanted
    known : dict
        Refined legs of low thrust of plans of the instance, in the same field, by what they were
        made of; those of this plan are added.

    Raises
    ------
    InputError
        As of :func:`refine`.
    """
    instance, plan = admitted.instance, admitted.plan
    jobs, cluster, enough, report = wanted[2:6]
    gravity = wanted.gravity or (DEFAULT_GRAVITY if wanted.ephemerides else instance.dynamics)
    _check_word("gravity", gravity, GRAVITIES)
    freedom = _freedom(instance, wanted.freedom)
    check_jobs(1 if jobs is None else jobs, cluster)
    refuse_what_cannot_be_refined(instance, plan)
    refuse_broken_chain(instance, plan)
    instance = as_launched(instance, plan)
    began = now_s()
    numbered = list(enumerate(plan.legs, start=1))
    legs = [(n, leg) for n, leg in numbered if leg.traits.has_burns or leg.traits.has_arcs]
    after_launch = {n + 1 for n, leg in numbered if leg.traits.from_nowhere}
    whose, lead_ins = owners(instance, plan), plan.lead_ins
    ends = _ends(instance, gravity, plan, legs, ephemerides=wanted.ephemerides)
    bodies = ends.bodies
    propelled = propelled_by_leg(instance, plan)
    tows = _tows(instance, plan, after_launch)
    # What is not loaded at a launch stands with the leg after it, as a launch is none.
    vented_kg = {n + leg.traits.from_nowhere: leg.vented_kg for n, leg in numbered if leg.vented_kg}
    done: dict[int, RefinedLeg] = {}
    missing: dict[int, Missing] = {}
    made_of = {
        number: (leg.replace(delta_v_left_m_s=0.0), propelled[number], tows[number])
        for number, leg in legs
        if leg.traits.has_arcs
    }
    for number, what in made_of.items():
        if what in known:
            done[number] = known[what].replace(leg=number, chaser=whose.get(number))
    report(len(done), len(legs))
    with _executor(jobs, cluster) as calls:
        running: dict[Future[RefinedLeg], int] = {
            (
                calls.submit(
                    refine_thrust_leg,
                    instance,
                    cast(TrueBodies, bodies),
                    number,
                    leg,
                    propelled[number],
                    tows[number],
                )
                if leg.traits.has_arcs
                else calls.submit(
                    refine_leg,
                    instance,
                    bodies,
                    number,
                    leg,
                    freedom,
                    lead_ins.get(number, ()),
                    number in after_launch,
                )
            ): number
            for number, leg in legs
            if number not in done
        }
        left = set(running)
        while left:
            ended, left = wait(left, POLL_S, FIRST_COMPLETED)
            for future in ended:
                number = running[future]
                if future.cancelled():
                    missing[number] = Missing(leg=number, reason=INTERRUPTED)
                    continue
                try:
                    done[number] = future.result().replace(
                        chaser=whose.get(number),
                        holding_delta_v_m_s=ends.holding.get(number),
                        vented_kg=vented_kg.get(number),
                    )
                except ArithmeticError as error:
                    tow = error.name if isinstance(error, NoSpiral) else None
                    missing[number] = Missing(leg=number, reason=str(error), tow=tow)
            if ended:
                report(len(done) + len(missing), len(legs))
            if enough():
                for future in left:
                    future.cancel()
    known |= {what: done[number] for number, what in made_of.items() if number in done}
    made = RefinedPlan(
        instance=InstanceReference(name=instance.name, sha256=instance.sha256),
        plan=reference(plan),
        planned=plan,
        ephemerides=ends.onto,
        gravity=gravity,
        freedom=freedom,
        status="incomplete" if missing else "complete",
        runtime_s=now_s() - began,
        versions=versions(),
        bodies=tuple(_body(name, state) for name, state in bodies.epoch_states.items()),
        legs=tuple(done[number] for number in sorted(done)),
        missing=tuple(missing[number] for number in sorted(missing)),
    )
    return _without_low(instance, plan, made)


def _without_low(instance: Instance, plan: Plan, made: RefinedPlan) -> RefinedPlan:
    """A refined plan without legs that descend below the limit of altitude."""
    from ...judge.refined import check_refined

    low = {
        found.leg: Missing(leg=found.leg, reason=found.message)
        for found in check_refined(instance, plan, made)
        if found.rule == "altitude" and found.leg is not None
    }
    if not low:
        return made
    missing = {one.leg: one for one in made.missing} | low
    return made.replace(
        status="incomplete",
        legs=tuple(leg for leg in made.legs if leg.leg not in low),
        missing=tuple(missing[number] for number in sorted(missing)),
    )


def _ends(
    instance: Instance,
    gravity: Gravity,
    plan: Plan,
    legs: list[tuple[int, Leg]],
    *,
    ephemerides: bool,
) -> KnownBodies:
    """Where the legs of a plan begin and end."""
    if not ephemerides:
        names = [name for _, leg in legs for name in (leg.origin, leg.destination)]
        return KnownBodies(TrueBodies(instance, gravity, names))
    known = opened(instance)
    assert instance.ephemerides is not None  # else none could be opened
    tows = [
        (leg.destination, leg.removal_burns[0].time_s) for leg in plan.legs if leg.removal_burns
    ]
    bodies = ReportedBodies(instance, known, gravity, (leg for _, leg in legs), tows)
    led = plan.lead_ins
    onto = EphemeridesReference(kind=instance.ephemerides.kind, sha256=instance.ephemerides.sha256)
    return KnownBodies(
        bodies,
        onto,
        {number: holding_m_s(known, gravity, leg, led=number in led) for number, leg in legs},
    )


def _tows(instance: Instance, plan: Plan, after_launch: set[int]) -> dict[int, Tows]:
    """Spirals next to each leg, by its number."""
    spirals, found = spirals_by_leg(instance, plan), {}
    for flown in routes_of(instance, plan):
        before = None
        for number, _ in flown.legs:
            after = spirals.get(number)
            found[number] = Tows(before, after, number in after_launch)
            before = after
    return found


@contextmanager
def _executor(jobs: int | None, cluster: str | None) -> Iterator[Executor]:
    """Executor that guides the legs; those not begun at the end are dropped."""
    made = Cluster(cluster) if cluster is not None else ThreadPoolExecutor(jobs or usable_cores())
    try:
        yield made
    finally:
        made.shutdown(cancel_futures=True)


def _freedom(instance: Instance, freedom: Freedom | None) -> Freedom:
    if freedom is None:
        return "planned" if instance.keep_out_zones else "free"
    _check_word("freedom", freedom, FREEDOMS)
    if freedom == "free" and instance.keep_out_zones:
        raise InputError(
            'freedom = "free": the instance has keep-out zones, which only the plan\'s own burns '
            'are known to avoid; use "planned"'
        )
    return freedom


def _check_word(name: str, value: str, known: tuple[str, ...]) -> None:
    if value not in known:
        raise InputError(f"{name} = {value!r}: use one of {', '.join(known)}")


def _body(name: str, state: np.ndarray) -> BodyState:
    values = state.tolist()
    return BodyState(name=name, position_m=tuple(values[:3]), velocity_m_s=tuple(values[3:]))
