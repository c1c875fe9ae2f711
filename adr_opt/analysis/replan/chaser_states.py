"""State of a plan at a time: fixed legs, and the starting point of each chaser."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

from ...common.constants import SLACK_S
from ...common.errors import InputError
from ...legs.service_limits import limits_of, removal_times
from ...plan.cargo import kits_of
from ...plan.expense import carried_kg
from ...plan.plan import Leg, Plan
from ...plan.routes import Flown, routes_of
from ...problem.chasers import AnyTank, AtStation, Chaser, TankByMass
from ...problem.instance import Instance
from .deviations import (
    AS_PLANNED,
    Deviations,
    as_carried_out,
    check_deviations,
    possible_legs,
    refuse_not_begun,
    said_of,
    weighed_anew,
    without_service,
)

DELAY_S = 1.0
"""Delay of a chaser whose leg failed, after which that departure is over [s]."""


@dataclass(frozen=True)
class ChaserState:
    """A chaser between its fixed legs and its new plan.

    Attributes
    ----------
    chaser : Chaser
        As the instance has it.
    legs : tuple of Leg
        Flown, under way, or fixed.
    body : str or None
        Where it is once they are; None for one that is not launched yet.
    free_s : float
        Since when it is free there, at least the time asked for [s]. Here, and of what is left:
        before a tow that has not begun, but after one that has.
    left_m_s : float
        ΔV left then.
    propellant_kg : float or None
        Of tanks by mass.
    kits : int or None
        The most it may still leave behind; None where there is no limit. Where kits have a mass,
        those that are aboard.
    since_refuelling : int
        Targets visited since the last one; one that was missed counts.
    since_s : float
        When it may fly at all [s].
    idle_kits : int
        More are aboard, which nothing takes any more: they are carried along.
    is_put : bool
        Whether it is with an object that it is still to tow, before it goes on. Its rest begins
        with that target: it is put there, as chasers are launched, while its service ends.
    missed : tuple of str
        Targets that its legs lead to, and that were not serviced.
    notes : tuple of str
        What is said of legs that went otherwise than planned.
    """

    chaser: Chaser
    legs: tuple[Leg, ...]
    body: str | None
    free_s: float
    left_m_s: float
    propellant_kg: float | None
    kits: int | None
    since_refuelling: int
    since_s: float
    idle_kits: int = 0
    is_put: bool = False
    missed: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def is_new(self) -> bool:
        """Whether the chaser has not flown yet."""
        return not self.legs

    @property
    def weighed_kits(self) -> int:
        """Kits aboard that have mass; none if unlimited, as they then weigh nothing."""
        return 0 if self.kits is None else self.kits

    @property
    def is_at_target(self) -> bool:
        """Whether the chaser is at a target that it has serviced or missed."""
        return self.since_refuelling > 0

    @property
    def is_released(self) -> bool:
        """Whether the chaser's last tow has begun or ended, so that it is on the disposal orbit."""
        return bool(self.legs) and self.legs[-1].tow is not None and not self.is_put

    def onward(self, legs: tuple[Leg, ...]) -> tuple[Leg, ...]:
        """Legs of a new plan, without a first leg that only places the chaser where it is."""
        return legs[1:] if self.is_put else legs

    @property
    def has_to_return(self) -> bool:
        """Whether the chaser must end at a station."""
        return isinstance(self.chaser.end, AtStation)


def states_at(
    instance: Instance,
    plan: Plan,
    at_s: float,
    *,
    keep: int = 0,
    failed: int | None = None,
    went: Deviations = AS_PLANNED,
) -> tuple[ChaserState, ...]:
    """State of each chaser at a time.

    A leg that has begun is finished, as there is no way back. One that leaves a disposal
    orbit begins with the tow: it leaves as that ends. The legs after it that have not begun are
    fixed too if ``keep`` says so, for each chaser. A leg that was to begin before a service
    was over that took longer has not begun.

    Parameters
    ----------
    instance : Instance
    plan : Plan
    at_s : float
        Since the epoch [s].
    keep : int
    failed : int, optional
        Number of a leg that does not begin when it was to; it may not have begun. Those before it
        of its chaser are fixed, and it is free for another one once that time is over.
    went : Deviations
        What went otherwise than planned.

    Raises
    ------
    InputError
        The time is outside the mission, the leg is none, or has begun, or what is told cannot have
        been.
    """
    if not 0.0 <= at_s <= instance.mission.duration_s:
        raise InputError(
            f"time {at_s:g} s: outside the mission, which lasts {instance.mission.duration_s:g} s"
        )
    if keep < 0:
        raise InputError(f"keep = {keep}: must not be negative")
    if failed is not None and not 1 <= failed <= len(plan.legs):
        raise InputError(f"failed leg {failed}: the plan has the legs 1 to {len(plan.legs)}")
    check_deviations(instance, plan, went)
    instance = instance.without_reserves()
    return tuple(
        _state(instance, flown, _fixed(instance, flown, at_s, keep, failed, went), at_s, went)
        for flown in routes_of(instance, plan)
    )


class Fixed(NamedTuple):
    """The legs of a chaser that are flown as planned.

    Attributes
    ----------
    legs : tuple of (int, Leg)
        Each after its number.
    since_s : float
        No leg may begin before that any more [s].
    notes : tuple of str
    """

    legs: tuple[tuple[int, Leg], ...]
    since_s: float
    notes: tuple[str, ...]


def _fixed(
    instance: Instance, flown: Flown, at_s: float, keep: int, failed: int | None, went: Deviations
) -> Fixed:
    legs, begins_s = flown.legs, _begins_s(flown)
    planned = sum(time_s < at_s for time_s in begins_s)
    possible = possible_legs(instance, legs, begins_s, went)
    begun = min(planned, possible)
    count, since_s = min(begun + keep, len(legs)), at_s
    for at, (number, leg) in enumerate(legs):
        if number != failed:
            continue
        if at < begun:
            raise InputError(
                f"failed leg {failed}: it has begun at {begins_s[at]:.0f} s, before {at_s:g} s, "
                f"and will be finished; if {leg.destination!r} is not serviced, report it as missed"
            )
        count = at
        since_s = max(at_s, begins_s[at] + DELAY_S)
    if count > possible:
        raise InputError(
            f"leg {legs[possible][0]} to {legs[possible][1].destination!r} is to be kept, but "
            f"would begin before the service at {legs[possible - 1][1].destination!r} is over; "
            "keep fewer legs"
        )
    refuse_not_begun(legs, begun, count, at_s, went)
    notes = said_of(legs, begun, planned, possible, went.missed)
    return Fixed(as_carried_out(instance, legs[:count], at_s, went), since_s, notes)


def _state(
    instance: Instance, flown: Flown, fixed: Fixed, at_s: float, went: Deviations
) -> ChaserState:
    """State after the fixed legs, with the kits of missed targets still aboard."""
    chaser, stations = flown.chaser, instance.station_names
    count = len(fixed.legs)
    missed = went.missed_of(leg for _, leg in fixed.legs)
    kept = kits_of(instance, missed)
    serviced = without_service(instance, missed)
    loaded = _loaded(instance, flown)
    happened = replace(
        loaded, chaser=heavier(loaded.chaser, kept), legs=(*fixed.legs, *flown.legs[count:])
    )
    if missed or fixed.legs != flown.legs[:count]:
        happened = weighed_anew(serviced, happened, count)
    legs = tuple(leg for _, leg in happened.legs[:count])
    aboard = happened.aboard(serviced)[count]
    tow = legs[-1].tow if legs else None
    # A tow that was planned to begin within a service that took longer has not begun either.
    is_put = tow is not None and (tow.start_s >= at_s or legs[-1].end_s > tow.start_s + SLACK_S)
    propellant = None
    if isinstance(happened.chaser.tank, TankByMass) and aboard.mass_kg is not None:
        mass_kg = aboard.mass_kg + (aboard.removal_kg if is_put else 0.0)
        without_kg = happened.chaser.tank.dry_mass_kg + aboard.kits * chaser.kit_mass_kg
        propellant = max(mass_kg - without_kg, 0.0)
    since = 0
    for leg in legs:
        since = 0 if leg.destination in stations else since + 1
    kits = chaser.kits
    if legs and chaser.kit_mass_kg > 0.0:
        kits = aboard.kits + kept
    elif kits is not None:
        kits -= kits_of(serviced, (leg.destination for leg in legs))
    body = legs[-1].destination if legs else None if chaser.awaits_launch else chaser.start_name
    since_s, _ = instance.available_s[instance.chasers.index(chaser)]
    free_s = since_s
    if legs:
        free_s = legs[-1].end_s if is_put else legs[-1].done_s
    left_m_s = max(aboard.on_arrival_m_s if is_put else aboard.left_m_s, 0.0)
    return ChaserState(
        chaser,
        legs,
        body,
        max(fixed.since_s, free_s),
        left_m_s,
        propellant,
        kits,
        since,
        since_s,
        is_put=is_put,
        missed=missed,
        notes=fixed.notes,
    )


def _begins_s(flown: Flown) -> list[float]:
    """Start of each leg: the departure, or the start of the tow before it [s]."""
    tows = [None, *(leg.tow for _, leg in flown.legs)]
    return [
        leg.leaves_s if tow is None else tow.start_s
        for tow, (_, leg) in zip(tows, flown.legs, strict=False)
    ]


def _loaded(instance: Instance, flown: Flown) -> Flown:
    """The legs of a chaser, with no more propellant than at its launch.

    Where launched masses are paid for, that is what its route needs, and no drop more.
    """
    chaser, tank = flown.chaser, flown.chaser.tank
    paid = instance.objective.cost == "expense" and chaser.priced.counts_mass
    if isinstance(chaser.start, AtStation) or not paid or not isinstance(tank, TankByMass):
        return flown
    kits_kg = chaser.kit_mass_kg * kits_of(instance, (name for name, _ in flown.spent))
    least_kg = (carried_kg(instance, chaser, flown.spent) or 0.0) - kits_kg
    never_kg = flown.vented_kg[0] if flown.legs else 0.0  # is taken off once more
    holds_kg = min(least_kg + never_kg, tank.propellant_kg)
    return replace(flown, chaser=chaser.replace(tank=tank_holding(chaser, None, holds_kg)))


def heavier(chaser: Chaser, kits: int) -> Chaser:
    """A chaser that includes some kits in its own mass."""
    tank, kits_kg = chaser.tank, kits * chaser.kit_mass_kg
    if not isinstance(tank, TankByMass) or kits_kg == 0.0:
        return chaser
    return chaser.replace(tank=tank.replace(dry_mass_kg=tank.dry_mass_kg + kits_kg))


def put_s(instance: Instance, state: ChaserState) -> tuple[float, float]:
    """Start of the service at the target where a chaser is placed [s]."""
    assert state.body is not None
    body = instance.names.index(state.body)
    tow_s = removal_times(instance, range(len(instance.chasers)))[body]
    service_s = float(limits_of(instance).service[body]) - tow_s
    return max(state.free_s - service_s, 0.0), state.free_s


def tank_holding(chaser: Chaser, left_m_s: float | None, propellant_kg: float | None) -> AnyTank:
    """A tank with a given content at the start."""
    tank = chaser.tank
    if isinstance(tank, TankByMass):
        initial_kg = None if propellant_kg is None else min(propellant_kg, tank.propellant_kg)
        return tank.replace(initial_propellant_kg=initial_kg)
    initial_m_s = None if left_m_s is None else min(left_m_s, tank.delta_v_m_s)
    return tank.replace(initial_delta_v_m_s=initial_m_s)
