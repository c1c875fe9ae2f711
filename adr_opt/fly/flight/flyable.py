"""Preconditions for flying a plan's burns, and distance of its orbits from circles."""

from __future__ import annotations

from typing import NamedTuple

from ...common.errors import InputError
from ...common.wording import counted
from ...plan.after_tows import left_row
from ...plan.plan import Leg, Plan
from ...plan.routes import Flown, routes_of, several
from ...plan.tows import removals_by_name
from ...problem.instance import Instance
from ...problem.rules import CAMPAIGNS, FIRST, MODELLED, RELEASES, TOURS, Follower
from ...problem.support import refuse

TOLD_M = 1e3
"""Distance above which eccentric orbits are reported [m]."""


class OffCircles(NamedTuple):
    """Legs of a plan on eccentric orbits.

    Attributes
    ----------
    legs : int
    eccentricity : float
        The largest.
    distance_m : float
        The largest distance of a true position from that on the circle.
    """

    legs: int
    eccentricity: float
    distance_m: float

    def __str__(self) -> str:
        one = self.legs == 1
        return (
            f"{self.legs} leg{' is' if one else 's are'} on eccentric orbits, up to "
            f"{self.eccentricity:.2g}, and planned between circles, from which bodies are up to "
            f"{self.distance_m / 1e3:.3g} km away: unrefined burns miss by kilometres; 'refine' "
            "retargets them"
        )


def off_circles(instance: Instance, plan: Plan) -> OffCircles | None:
    """The legs of a plan on eccentric orbits; None if none is away from circles by kilometres.

    At the same mean anomaly a body is away from its circle by at most 2 a e, to first order.
    """
    orbits = dict(zip(instance.names, instance.known_orbits, strict=True))
    legs, eccentricity, distance_m = 0, 0.0, 0.0
    for leg in plan.legs:
        ends = [orbits.get(name) for name in (leg.origin, leg.destination)]
        if not leg.traits.has_burns or all(not end or not end.eccentricity for end in ends):
            continue
        legs += 1
        for end in ends:
            if end is not None:
                eccentricity = max(eccentricity, end.eccentricity)
                distance_m = max(distance_m, 2.0 * end.semi_major_axis_m * end.eccentricity)
    return OffCircles(legs, eccentricity, distance_m) if distance_m >= TOLD_M else None


TIME_TOLERANCE_S = 1e-3
"""Tolerance between the last burn and the stated arrival [s]."""


REFINED = Follower(
    "flying",
    FIRST - {"given connections", "bodies without an orbit"}
    | CAMPAIGNS
    | MODELLED
    | TOURS
    | {"rules of tours beyond tours", "prizes that fall beyond lists of connections"}
    | {"capture windows"}
    | RELEASES,
    "its plans have no trajectory",
)
"""Rules followed in flying refined plans, and in refining."""

FLOWN = Follower(
    "flying plans",
    REFINED.follows - {"low thrust"},
    "plans have no burns: refine the plan, and fly the refined one",
)


def refuse_what_cannot_be_flown(instance: Instance, plan: Plan) -> None:
    """Raise :class:`InputError` for a plan that cannot be flown over an instance.

    It belongs to another instance, or to one whose costs are given, names an unknown body or
    chaser, or has burns out of time order, after the arrival or without an approach; or a tow is
    missing, or one too many.
    """
    refuse(instance, REFINED)  # for want of a trajectory, before want of burns
    refuse(instance, FLOWN)
    _refuse_wrong_legs(instance, plan)


def refuse_what_cannot_be_refined(instance: Instance, plan: Plan) -> None:
    """Raise :class:`InputError` for a plan that cannot be refined over an instance.

    As :func:`refuse_what_cannot_be_flown` does, but legs of low thrust may have their arcs.
    """
    refuse(instance, REFINED)
    _refuse_wrong_legs(instance, plan)


def _refuse_wrong_legs(instance: Instance, plan: Plan) -> None:
    plan.instance.refuse_other(instance)
    spiralling = {
        number
        for flown in routes_of(instance, plan)
        if flown.chaser.thrust_n is not None
        for number, _ in flown.legs
    }
    bodies = set(instance.names)
    towed = {target.name for target in instance.targets if target.service.is_flown}
    burns = {
        name: len(tow.burns_m_s or ()) for name, tow in removals_by_name(instance, None).items()
    }
    led_s = _tows_before_s(plan)
    for number, leg in enumerate(plan.legs, start=1):
        _refuse_leg(number, leg, bodies)
        due = burns.get(leg.destination, 0) if leg.destination in towed else None
        _refuse_tow(number, leg, due, number in spiralling)
        before_s = led_s.get(number, leg.leaves_s)
        waits = left_row(instance, leg.origin, leg.departure_s) is not None
        late_s = leg.leaves_s - before_s
        if late_s < -TIME_TOLERANCE_S or (late_s > TIME_TOLERANCE_S and not waits):
            raise InputError(
                f"leg {number} leaves at {leg.leaves_s!r} s, but the tow before it ends at "
                f"{before_s!r} s; correct its times"
            )


def _tows_before_s(plan: Plan) -> dict[int, float]:
    """End of the tow before a leg, by number of the leg [s]."""
    found, number = {}, 0
    for route in plan.routes:
        for leg in route.legs:
            number += 1
            if leg.tow is not None and leg is not route.legs[-1]:
                found[number + 1] = leg.tow.burns[-1].time_s if leg.tow.burns else leg.tow.end_s
    return found


def refuse_broken_chain(instance: Instance, plan: Plan) -> None:
    """Raise :class:`InputError` for legs that do not connect to each other.

    Each may be flown alone; a flight of all of them needs that each begins where and not before the
    one before it, of the same chaser, ends.
    """
    for flown in routes_of(instance, plan):
        _refuse_broken_route(flown, f"{flown.chaser.name!r}" if several(instance) else "the chaser")


def _refuse_broken_route(flown: Flown, who: str) -> None:
    where, free_s = flown.chaser.start_name, 0.0
    for number, leg in flown.legs:
        if leg.origin != where:
            raise InputError(
                f"leg {number} begins at {leg.origin!r}, but {who} is at {where!r}; put the "
                "legs in order"
            )
        begins_s = min(leg.ready_s, leg.departure_s, leg.leaves_s)
        if begins_s < free_s - TIME_TOLERANCE_S:
            raise InputError(
                f"leg {number} begins at {begins_s!r} s, but {who} is free at {free_s!r} s "
                "only; correct its times"
            )
        # A tow may be put off until the next leg leaves, after the departure_s of a drift; the
        # chaser is free as soon as it may be over. That it ends on leaving is asked elsewhere.
        where, free_s = leg.destination, leg.free_s


def _refuse_tow(number: int, leg: Leg, due: int | None, by_spiral: bool) -> None:
    """Refuse a leg whose tow is missing, superfluous or of a wrong number of burns."""
    is_towed = due is not None
    if is_towed != (leg.tow is not None):
        # Without it neither the cost of the tow is known, nor where the chaser goes on from.
        wrong = "but the plan has no tow of it" if is_towed else "but the plan has a tow of it"
        raise InputError(
            f"leg {number}: {leg.destination!r} is {'towed' if is_towed else 'not towed'}, "
            f"{wrong}; {'add' if is_towed else 'take out'} the field tow"
        )
    if leg.tow is None:
        return
    if by_spiral:
        whole = [leg.end_s - TIME_TOLERANCE_S, leg.tow.start_s, leg.tow.end_s]
        if leg.tow.burns or whole != sorted(whole):
            raise InputError(
                f"leg {number}: a tow by low thrust has no burns, and lies after end_s = "
                f"{leg.end_s!r}; correct it"
            )
        return
    assert due is not None  # there is a tow
    times = [burn.time_s for burn in leg.tow.burns]
    if len(times) != due or not leg.end_s - TIME_TOLERANCE_S <= times[0] <= times[-1]:
        raise InputError(
            f"leg {number}: a tow has {counted(due, 'burn')} here, the first one after "
            f"end_s = {leg.end_s!r}; correct them"
        )


def _refuse_leg(number: int, leg: Leg, bodies: set[str]) -> None:
    for name in (leg.origin, leg.destination):
        if name not in bodies:
            raise InputError(f"leg {number}: {name!r} is not a body of the instance")
    if leg.traits.has_arcs:
        _refuse_arcs(number, leg)
    if not leg.traits.has_burns:
        if leg.burns:
            raise InputError(f"leg {number}: a {leg.traits.noun} has no burns; take them out")
        return
    times = [burn.time_s for burn in leg.burns]
    if times != sorted(times):
        raise InputError(f"leg {number}: the burns are not in time order; sort them by time_s")
    if all(burn.phase != "approach" for burn in leg.burns):
        raise InputError(f"leg {number}: no burn begins the approach; add the approach burns")
    if leg.arrival_s < times[-1] - TIME_TOLERANCE_S:
        raise InputError(
            f"leg {number}: arrival_s = {leg.arrival_s!r} is before the last burn at "
            f"{times[-1]!r}; it must be the end of the approach"
        )


def _refuse_arcs(number: int, leg: Leg) -> None:
    arcs = leg.manoeuvres or ()
    if len(arcs) != 2:
        raise InputError(
            f"leg {number}: a {leg.traits.noun} has two arcs; state both in manoeuvres"
        )
    times = [time for arc in arcs for time in (arc.start_s, arc.end_s)]
    whole = [leg.departure_s - TIME_TOLERANCE_S, *times, leg.arrival_s]
    if whole != sorted(whole):
        raise InputError(
            f"leg {number}: its arcs are not in time order between departure_s and arrival_s; "
            "correct their times"
        )
