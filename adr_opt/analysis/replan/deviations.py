"""Deviations of a mission from its plan: failed services, other durations, other costs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from ...common.constants import SLACK_M_S, SLACK_S
from ...common.errors import InputError
from ...common.records import LARGEST_DELTA_V_M_S, LARGEST_DURATION_S
from ...legs.service_limits import service_begins
from ...plan.plan import Leg, Plan
from ...plan.routes import Flown
from ...problem.instance import Instance

Numbered = tuple[tuple[int, Leg], ...]
"""Legs in order, each with its number in the plan."""


@dataclass(frozen=True)
class Deviations:
    """Deviations of a mission from its plan.

    Attributes
    ----------
    missed : tuple of str
        Targets that were reached, and not serviced.
    retry : bool
        Whether they may be tried again; else they are given up.
    services_s : mapping of str to float
        How long the service of a target took, or the attempt at it [s].
    costs_m_s : mapping of int to float
        What a leg took, by its number from 1, without the tow that may follow [m/s].
    """

    missed: tuple[str, ...] = ()
    retry: bool = False
    services_s: Mapping[str, float] = field(default_factory=dict)
    costs_m_s: Mapping[int, float] = field(default_factory=dict)

    @property
    def given_up(self) -> tuple[str, ...]:
        """Missed targets that are not retried."""
        return () if self.retry else self.missed

    def missed_of(self, legs: Iterable[Leg]) -> tuple[str, ...]:
        """Missed targets among the destinations of some legs."""
        return tuple(leg.destination for leg in legs if leg.destination in self.missed)


AS_PLANNED = Deviations()


def check_deviations(instance: Instance, plan: Plan, went: Deviations) -> None:
    """Refuse impossible deviations, whatever the time.

    Raises
    ------
    InputError
        A name is no target, or none that the plan leads to, a number no leg, or a value is
        negative, not finite, or too large.
    """
    if went.retry and not went.missed:
        raise InputError("retry: no target is missed; name targets to retry as missed, too")
    targets, visited = {target.name for target in instance.targets}, set(plan.destinations)
    names = [("missed", name) for name in went.missed]
    names += [("service-took", name) for name in went.services_s]
    for what, name in names:
        if name not in targets:
            raise InputError(f"{what} {name!r}: not a target of {instance.name!r}")
        if name not in visited:
            raise InputError(f"{what} {name!r}: no leg of the plan leads to it")
    for name, took_s in went.services_s.items():
        if not 0.0 <= took_s <= LARGEST_DURATION_S:
            raise InputError(
                f"service-took {name!r}: {took_s:g} s; give 0 to {LARGEST_DURATION_S:g} s"
            )
    for number, cost_m_s in went.costs_m_s.items():
        if not 1 <= number <= len(plan.legs):
            raise InputError(f"cost of leg {number}: the plan has the legs 1 to {len(plan.legs)}")
        if not 0.0 <= cost_m_s <= LARGEST_DELTA_V_M_S:
            raise InputError(
                f"cost of leg {number}: {cost_m_s:g} m/s; give 0 to {LARGEST_DELTA_V_M_S:g} m/s"
            )


def service_end_s(instance: Instance, leg: Leg, went: Deviations) -> float:
    """Actual end of the service at the end of a leg [s]."""
    took_s = went.services_s.get(leg.destination)
    return leg.end_s if took_s is None else service_begins(instance, leg) + took_s


def possible_legs(
    instance: Instance, legs: Numbered, begins_s: Sequence[float], went: Deviations
) -> int:
    """Number of legs that can be flown as planned: all before one that begins within a service."""
    for at, (_, leg) in enumerate(legs[:-1]):
        if begins_s[at + 1] < service_end_s(instance, leg, went) - SLACK_S:
            return at + 1
    return len(legs)


def refuse_not_begun(legs: Numbered, begun: int, fixed: int, at_s: float, went: Deviations) -> None:
    """Refuse deviations of legs that have not begun.

    Parameters
    ----------
    legs : tuple of (int, Leg)
        Of one chaser.
    begun, fixed : int
        Numbers of its first legs that have begun, and that are flown as planned.
    at_s : float
        [s].

    Raises
    ------
    InputError
        A target that is missed is one to which the leg has not begun; a service or a cost is of a
        leg that is planned anew.
    """
    for at, (number, leg) in enumerate(legs):
        name = leg.destination
        if name in went.missed and at >= begun:
            raise InputError(
                f"missed {name!r}: leg {number}, which leads to it, has not begun by {at_s:g} s; "
                "name it as lost instead"
            )
        if at < fixed:
            continue
        anew = f"leg {number}{{}} is replanned from {at_s:g} s on; give {{}} only for legs that "
        anew += "have begun or are kept"
        if name in went.services_s:
            raise InputError(
                f"service-took {name!r}: " + anew.format(", which leads to it,", "a time")
            )
        if number in went.costs_m_s:
            raise InputError(f"cost of leg {number}: " + anew.format("", "a cost"))


def as_carried_out(instance: Instance, fixed: Numbered, at_s: float, went: Deviations) -> Numbered:
    """Legs with their actual times and costs.

    A target that was missed is not towed. The attempt is over by the time at which it is known to
    have failed, unless it is said how long it took, or the chaser has not arrived.

    Raises
    ------
    InputError
        A target was missed that has been towed.
    """
    made: list[tuple[int, Leg]] = []
    for at, (number, leg) in enumerate(fixed):
        name, planned = leg.destination, leg
        if made and made[-1][1] != fixed[at - 1][1]:
            leg = leg.replace(ready_s=made[-1][1].free_s)
        if name in went.services_s:
            leg = leg.replace(end_s=service_end_s(instance, planned, went))
        elif name in went.missed:
            leg = leg.replace(end_s=max(leg.arrival_s, min(at_s, leg.end_s)))
        if name in went.missed and leg.tow is not None:
            if at + 1 < len(fixed):
                raise InputError(
                    f"missed {name!r}: leg {fixed[at + 1][0]} has begun by {at_s:g} s, with the "
                    f"tow of it; give an earlier time, or say with service-took how long it "
                    "was tried"
                )
            leg = leg.replace(tow=None)
        if number in went.costs_m_s:
            leg = leg.replace(delta_v_m_s=went.costs_m_s[number])
        made.append((number, leg))
    return tuple(made)


def without_service(instance: Instance, missed: Iterable[str]) -> Instance:
    """The instance in which missed targets take no kit and are not towed."""
    names = set(missed)
    if not names:
        return instance
    return instance.replace(
        targets=tuple(
            target.replace(removal="visit") if target.name in names else target
            for target in instance.targets
        )
    )


def weighed_anew(instance: Instance, flown: Flown, fixed: int) -> Flown:
    """A route with the remainder after each of its first legs, at their actual costs.

    Parameters
    ----------
    instance : Instance
        In which what was missed takes nothing.
    flown : Flown
        With the kits aboard that were not left behind as a part of the chaser.
    fixed : int
        Number of its first legs.

    Raises
    ------
    InputError
        They took more than there was.
    """
    stages = flown.aboard(instance)[1 : fixed + 1]
    legs = list(flown.legs)
    for at, stage in enumerate(stages):
        number, leg = legs[at]
        least_m_s = min(stage.on_arrival_m_s, stage.left_m_s)
        if least_m_s < -SLACK_M_S:
            raise InputError(
                f"leg {number} to {leg.destination!r}: the tank would lack {-least_m_s:.6g} m/s "
                "for it by the reported times and costs; correct them, or give the cost of this "
                "leg, too"
            )
        legs[at] = number, leg.replace(delta_v_left_m_s=stage.left_m_s, mass_kg=stage.mass_kg)
    return replace(flown, legs=tuple(legs))


def said_of(
    legs: Numbered, begun: int, planned: int, possible: int, missed: Sequence[str]
) -> tuple[str, ...]:
    """Notes on legs that deviations have kept from beginning, or have not.

    Parameters
    ----------
    legs : tuple of (int, Leg)
        Of one chaser, as planned.
    begun, planned : int
        Number of legs that have begun, and that would have by their times.
    possible : int
        Number of legs that can be flown as planned.
    missed : sequence of str
    """
    notes = []
    if possible < planned:
        number, leg = legs[possible]
        notes.append(
            f"leg {number} to {leg.destination} was to begin before the service at "
            f"{legs[possible - 1][1].destination} is over, and is not flown"
        )
    for at, (_, leg) in enumerate(legs[: begun - 1]):
        if leg.destination in missed:
            number, onward = legs[at + 1]
            notes.append(
                f"{leg.destination} was missed, and leg {number} to {onward.destination} had begun "
                "by then; if its chaser is still there, say with service-took how long it was tried"
            )
    return tuple(notes)
