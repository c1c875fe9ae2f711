"""Reasons why a refined plan does not hold, and the part of it that holds."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from typing import NamedTuple

from ...common.constants import EARTH_RADIUS_M
from ...judge.check.violation import DELTA_V_TOLERANCE_M_S
from ...kernels.orbits.gravity import FIELDS
from ...mission.build_legs import tow_flown
from ...mission.problem import Problem
from ...mission.result import proven_of
from ...plan.expense import cost_of_routes
from ...plan.plan import Leg, Plan, Route, Unvisited
from ...plan.refined_plan import RefinedLeg, RefinedPlan, RefinedTow
from ...plan.routes import Flown, routes_of, weighed
from ...plan.tows import removals_by_name
from ...problem.chasers import AtStation
from ...problem.instance import Instance
from ..flight.flights import tank_name
from ..flight.refined_result import MOST_RELEASE_ECCENTRICITY, MOST_RELEASE_OFF_M
from ..flight.tanks import legs_by_tank, tanks_of
from .bodies import Whereabouts, near_circle, state_of
from .tow import towed


class Strayed(NamedTuple):
    """A release off the disposal orbit.

    Attributes
    ----------
    leg : int
        Number of the leg that counts the tow.
    name : str
        Of the object.
    off_m, eccentricity : float
        Mean altitude above that of disposal [m], and mean eccentricity.
    """

    leg: int
    name: str
    off_m: float
    eccentricity: float

    def __str__(self) -> str:
        return (
            f"leg {self.leg}: {self.name} is released {self.off_m:.3g} m off the disposal orbit, "
            f"with an eccentricity of {self.eccentricity:.2g}"
        )


def strayed(instance: Instance, refined: RefinedPlan) -> Iterator[Strayed]:
    """Releases by spirals that miss the disposal orbit as judged by ``fly``."""
    for leg in refined.legs:
        tows: list[tuple[str, RefinedTow | None]] = [(leg.destination, leg.tow)]
        if leg.after_launch:
            tows.insert(0, (leg.origin, leg.tow_before))
        for name, tow in tows:
            if tow is None or tow.thrust is None:
                continue
            mean = near_circle(state_of(tow.released), FIELDS[refined.gravity])
            disposal_m = EARTH_RADIUS_M + instance.circle_m(name)
            off_m, eccentricity = float(mean[0]) - disposal_m, math.hypot(mean[1], mean[2])
            if abs(off_m) > MOST_RELEASE_OFF_M or eccentricity > MOST_RELEASE_ECCENTRICITY:
                yield Strayed(leg.leg, name, off_m, eccentricity)


MOST_MISS_M, MOST_MISS_M_S = 1.0, 1e-3
"""Largest miss of a leg, as judged by `fly`."""


def troubles(problem: Problem, refined: RefinedPlan) -> tuple[str, ...]:
    """Reasons why a refined plan does not hold; empty if it does.

    Every leg must be there and arrive, every spiral must release its object on the disposal orbit,
    and every tank must be enough, less the margin that is kept back. Times need no look: refined
    legs arrive when the plan says, or not at all.
    """
    return tuple(_troubles(problem, refined))


def _troubles(problem: Problem, refined: RefinedPlan) -> Iterator[str]:
    for missing in refined.missing:
        yield f"leg {missing.leg} is missing: {missing.reason}"
    for leg in refined.legs:
        if leg.residual_m > MOST_MISS_M or leg.residual_m_s > MOST_MISS_M_S:
            yield f"leg {leg.leg} misses by {leg.residual_m:.3g} m"
    yield from map(str, strayed(problem.instance, refined))
    fillings = legs_by_tank(problem.instance, refined)
    for tank, filled in zip(tanks_of(problem.instance, refined), fillings, strict=True):
        over = (tank.over_m_s or 0.0) + problem.margin * filled.full_m_s
        if over > DELTA_V_TOLERANCE_M_S:
            legs = f"legs {tank.first_leg} to {tank.last_leg}"
            yield f"{tank_name(tank.tank, tank.chaser)} ({legs}) is over by {over:.1f} m/s"


def beginning(
    problem: Problem, plan: Plan, refined: RefinedPlan, barred: Collection[int] = ()
) -> tuple[Plan, RefinedPlan] | None:
    """The longest beginning of each chaser's legs that holds and may end the mission.

    Parameters
    ----------
    problem : Problem
    plan : Plan
    refined : RefinedPlan
        Of that plan.
    barred : collection of int
        Numbers of legs that must not be flown.

    Returns
    -------
    (Plan, RefinedPlan) or None
        None if there is no such beginning with a leg.
    """
    instance = problem.instance
    routes = [
        (flown, _holding(problem, flown, refined, barred)) for flown in routes_of(instance, plan)
    ]
    legs = [leg for flown, count in routes for _, leg in flown.legs[:count]]
    done = {leg.destination for leg in legs}
    if not legs or any(target.required and target.name not in done for target in instance.targets):
        return None
    kept = [number for flown, count in routes for number, _ in flown.legs[:count]]
    bodies = problem.missions[0].numbers(leg.destination for leg in legs).tolist()
    objective = problem.prizes(bodies, [leg.free_s for leg in legs])
    dropped = tuple(
        Unvisited(target=leg.destination, reason="delta-v")
        for flown, count in routes
        for _, leg in flown.legs[count:]
        if leg.destination not in instance.station_names
    )
    said = f"the first {len(kept)}" if len(routes) == 1 else f"{len(kept)}"
    # Kits that are left behind by legs that are not flown are not taken along.
    shown = tuple(
        Route(
            chaser=plan.routes[0].chaser if len(plan.routes) == 1 else flown.chaser.name,
            legs=weighed(instance, flown.chaser, _ending(instance, flown, count)),
        )
        for flown, count in routes
    )
    shorter = proven_of(problem, objective).of(
        plan,
        objective=objective,
        cost=cost_of_routes(instance, shown),
        routes=shown,
        unvisited=(*plan.unvisited, *dropped),
        notes=(*plan.notes, f"of {len(plan.legs)} legs {said} hold when refined"),
    )
    renumbered = [
        _towing(instance, refined, shorter, leg.replace(leg=kept.index(leg.leg) + 1))
        for leg in refined.legs
        if leg.leg in kept
    ]
    return shorter, _with(refined, renumbered).made_of(shorter)


def _ending(instance: Instance, flown: Flown, count: int) -> Iterator[Leg]:
    """The first legs of a chaser; the last tow starts immediately, as no leg follows.

    A spiral keeps its times, for which it was refined.
    """
    tows = removals_by_name(instance, None)
    for at, (_, leg) in enumerate(flown.legs[:count], start=1):
        by_spiral = leg.tow is None or not leg.tow.burns
        if by_spiral or at < count or count == len(flown.legs):
            yield leg
        else:
            row = instance.orbits()[instance.names.index(leg.destination)]
            yield leg.replace(tow=tow_flown(row, tows[leg.destination], leg.end_s))


def _towing(instance: Instance, refined: RefinedPlan, plan: Plan, leg: RefinedLeg) -> RefinedLeg:
    """A refined leg with the current tow of its plan."""
    tow = plan.legs[leg.leg - 1].tow
    if tow is None or leg.tow is None or leg.tow.thrust is not None:
        return leg
    if tow.first_burn_s == leg.tow.start_s:
        return leg
    bodies = Whereabouts.of(instance, refined)
    return leg.replace(tow=towed(instance, bodies, leg.destination, tow.burns))


def _holding(problem: Problem, flown: Flown, refined: RefinedPlan, barred: Collection[int]) -> int:
    """Maximum number of a chaser's legs that hold such that it may end after them."""
    numbers = [number for number, _ in flown.legs]
    for count in range(len(numbers), 0, -1):
        first = numbers[:count]
        lost = any(missing.leg in first for missing in refined.missing)
        lost = lost or not set(first).isdisjoint(barred)
        if lost or not _may_end(problem.instance, flown, count):
            continue
        kept = [leg for leg in refined.legs if leg.leg in first]
        if not troubles(problem, _with(refined, kept)):
            return count
    return 0


def _may_end(instance: Instance, flown: Flown, count: int) -> bool:
    """Whether a chaser may end after a number of legs."""
    leg, end = flown.legs[count - 1][1], flown.chaser.end
    last = leg.destination
    if leg.traits.from_nowhere and leg.tow is not None and not leg.tow.burns:
        return False  # its spiral is refined with the leg after it only
    if isinstance(end, AtStation):
        return last == end.station
    return last not in instance.station_names


def _with(refined: RefinedPlan, legs: list[RefinedLeg]) -> RefinedPlan:
    """A refined plan with a subset of its legs, complete."""
    known = {name for leg in legs for name in (leg.origin, leg.destination)}
    return refined.replace(
        status="complete",
        bodies=tuple(body for body in refined.bodies if body.name in known),
        legs=tuple(legs),
        missing=(),
    )
