"""Cargo and tows of chasers, and the rocket equation of tanks by mass (docs/model.md section 5)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ..common.constants import SLACK_M_S
from ..kernels.rules.loads import Loads, after_service
from ..problem.chasers import Chaser, TankByMass
from ..problem.drives import drive_of
from ..problem.instance import Instance
from ..problem.rules import most_targets
from .tows import removals_by_name, removals_of

NOTHING: Mapping[str, float] = MappingProxyType({})

LEAST_SHARE = 1e-9
"""Lower limit of a mass relative to that without propellant, whatever a plan states."""


def loads_of(instance: Instance, chaser: Chaser, margin: float) -> Loads | None:
    """Loads of a chaser as kernels take them; None if they make no difference.

    Parameters
    ----------
    instance : Instance
    chaser : Chaser
    margin : float
        Share of each tank that is kept back.
    """
    takes = np.zeros(len(instance.names), dtype=np.int64)
    takes[instance.first_target :] = [target.service.takes_kit for target in instance.targets]
    wanted = int(takes.sum())
    tows = removals_of(instance, drive_of(chaser, instance.targets))
    heavy = wanted > 0 and chaser.kit_mass_kg > 0.0
    most = min(wanted, wanted if chaser.kits is None else chaser.kits)
    if not heavy and (most == wanted or wanted == len(instance.targets)):
        if not tows and not chaser.lacks_by_mass:
            return None
        takes[:], most = 0, 0
    allowed = most_targets(instance, chaser)
    most = most if allowed is None else min(most, allowed)
    cargo = chaser.kit_mass_kg * np.arange(most + 1)
    full = [(1.0 - margin) * chaser.usable.full_m_s(float(mass)) + SLACK_M_S for mass in cargo]
    first = list(full)
    if chaser.lacks_by_mass:
        lacking = [chaser.spent_with_m_s(float(mass)) for mass in cargo]
        first = [each - less for each, less in zip(full, lacking, strict=True)]
    scale = np.ones((takes.size, most + 1))
    loss = np.zeros_like(scale)
    if heavy:
        without_propellant = getattr(chaser.usable, "dry_mass_kg", 0.0) + cargo
        lighter = without_propellant - chaser.kit_mass_kg
        of_kit = np.divide(without_propellant, lighter, where=cargo > 0.0, out=np.ones(most + 1))
        scale[takes == 1] = of_kit
        loss[takes == 1] = of_kit - 1.0
    flown = np.zeros(takes.size)
    for body, tow in tows.items():
        assert isinstance(chaser.usable, TankByMass)
        kept = math.exp(-(tow.delta_v_m_s - tow.back_m_s) / chaser.usable.exhaust_m_s)
        alone = math.exp(-tow.back_m_s / chaser.usable.exhaust_m_s)
        scale[body] = kept * alone
        lost = alone * (1.0 - kept) * tow.object_kg
        loss[body] = lost / (chaser.usable.dry_mass_kg + cargo)
        flown[body] = tow.delta_v_m_s
    columns = takes, np.array(full), np.array(first), scale, loss
    for column in (*columns, flown):
        column.setflags(write=False)
    return Loads(chaser.usable.exhaust_m_s, *columns, heavy, flown)


def most_left_m_s(loads: Loads) -> float:
    """Largest ΔV that a tank ever holds, with the slack of the model [m/s].

    With a margin that may be more than a tank without kits is filled up to: what has been kept
    back meanwhile is worth more than the same share of that, and what leaves the tank less.
    """
    taker, most = int(np.argmax(loads.takes)), 0.0
    for kits in range(loads.full.size - 1, 0, -1):
        most = max(most, float(loads.full[kits]))
        most = float(after_service(loads, taker, kits, most)[0])
    return max(most, float(loads.full[0]))


class Aboard(NamedTuple):
    """Cargo of a chaser after a leg and the service or refuelling that follows it.

    Attributes
    ----------
    left_m_s : float
        What is left of the tank; less than 0 if it was not enough [m/s]. Here, and of mass and
        kits, where the destination is towed: after the tow.
    mass_kg : float or None
        Of the chaser with propellant and kits; None where the tank is not one by mass.
    kits : int
        Number of further kits left behind.
    on_arrival_m_s : float
        What was left before the service [m/s].
    removal_kg, removal_m_s : float
        What the tow took that follows it [kg], [m/s].
    """

    left_m_s: float
    mass_kg: float | None
    kits: int
    on_arrival_m_s: float
    removal_kg: float = 0.0
    removal_m_s: float = 0.0


def kits_of(instance: Instance, destinations: Iterable[str]) -> int:
    """Number of kits that a route leaves behind, all of which its chaser takes along."""
    takers = {target.name for target in instance.targets if target.service.takes_kit}
    return len(takers.intersection(destinations))


def followed(
    instance: Instance,
    chaser: Chaser,
    legs: Sequence[tuple[str, float]],
    towing_m_s: Mapping[str, float] = NOTHING,
    vented_kg: Sequence[float] = (),
) -> tuple[Aboard, ...]:
    """Cargo of a chaser at the start and after each leg.

    Parameters
    ----------
    instance : Instance
    chaser : Chaser
    legs : sequence of (str, float)
        Destination and ΔV [m/s] of each.
    towing_m_s : mapping of str to float
        ΔV of tows that cost something else than in plans, by name of the object [m/s].
    vented_kg : sequence of float
        Propellant vented before each leg; empty for none [kg]. What is vented before the first one
        is not there at the start.
    """
    tank, kits = chaser.usable, kits_of(instance, (destination for destination, _ in legs))
    takers = {target.name for target in instance.targets if target.service.takes_kit}
    tows = removals_by_name(instance, drive_of(chaser, instance.targets))
    cargo_kg = kits * chaser.kit_mass_kg
    left = _less(
        chaser, kits, tank.full_m_s(cargo_kg) - chaser.spent_with_m_s(cargo_kg), vented_kg, 0
    )
    found = [Aboard(left, _mass_kg(chaser, kits, left), kits, left)]
    for at, (destination, delta_v) in enumerate(legs):
        if at:
            left = _less(chaser, kits, left, vented_kg, at)
        arrived = left = left - delta_v
        removal_kg = removal_m_s = 0.0
        if destination in instance.station_names:
            left = tank.full_m_s(kits * chaser.kit_mass_kg)
        elif destination in takers:
            takers.remove(destination)
            mass, kits = _mass_kg(chaser, kits, left), kits - 1
            # What a tank lacks does not grow: masses would then be unknown.
            if mass is not None and chaser.kit_mass_kg > 0.0 and left > 0.0:
                left = _left_m_s(chaser, kits, mass - chaser.kit_mass_kg)
        elif destination in tows:
            tow, mass = tows.pop(destination), _mass_kg(chaser, kits, left)
            assert mass is not None
            removal_m_s = towing_m_s.get(destination, tow.delta_v_m_s)
            removal_kg = tow.takes_kg(mass, tank.exhaust_m_s, removal_m_s)
            left = _left_m_s(chaser, kits, mass - removal_kg)
        mass = _mass_kg(chaser, kits, left)
        found.append(Aboard(left, mass, kits, arrived, removal_kg, removal_m_s))
    return tuple(found)


class Carried(NamedTuple):
    """Cargo of a chaser along its route.

    Attributes
    ----------
    mass_kg, propellant_kg : float or None
        At the start, with all that is aboard and without what is vented before the first leg; None
        where the tank is not one by mass.
    kits : int
        At the start; each of them is left behind.
    used_kg, left_kg : float or None
        Propellant of all legs and tows, and what is in the tank after the last one; less than 0 if
        it was not enough.
    end_mass_kg : float or None
        After the last service.
    """

    mass_kg: float | None
    propellant_kg: float | None
    kits: int
    used_kg: float | None
    left_kg: float | None
    end_mass_kg: float | None


def carried(
    instance: Instance,
    chaser: Chaser,
    legs: Sequence[tuple[str, float]],
    vented_kg: Sequence[float] = (),
) -> Carried:
    """Cargo of a chaser along its route; see :func:`followed`."""
    stages, tank = followed(instance, chaser, legs, vented_kg=vented_kg), chaser.usable
    gone = vented_kg or (0.0,) * len(legs)
    later = (0.0, *gone[1:])
    start, end = stages[0], stages[-1]
    never = gone[0] if gone else 0.0
    if not isinstance(tank, TankByMass) or start.mass_kg is None or end.mass_kg is None:
        return Carried(None, None, start.kits, None, None, None)
    used = sum(
        ((stage.mass_kg or 0.0) - lost) * -math.expm1(-delta_v / tank.exhaust_m_s)
        for stage, lost, (_, delta_v) in zip(stages, later, legs, strict=False)
    )
    used += sum(stage.removal_kg for stage in stages)
    without = tank.dry_mass_kg + end.kits * chaser.kit_mass_kg
    loaded = chaser.tank
    assert isinstance(loaded, TankByMass)
    aboard = loaded.first_kg(start.kits * chaser.kit_mass_kg, chaser.most_kg)
    return Carried(
        start.mass_kg, aboard - never, start.kits, used, end.mass_kg - without, end.mass_kg
    )


def carries(instance: Instance) -> bool:
    """Whether masses or kits of any chaser are tracked."""
    by_mass = any(isinstance(chaser.usable, TankByMass) for chaser in instance.chasers)
    return by_mass or any(target.service.takes_kit for target in instance.targets)


def tank_worths(
    instance: Instance,
    chaser: Chaser,
    legs: Sequence[tuple[str, float]],
    towing_m_s: Mapping[str, float] = NOTHING,
    vented_kg: Sequence[float] = (),
) -> tuple[float, ...]:
    """ΔV of each tank of a chaser over the legs and tows flown from it [m/s].

    That of a tank by mass goes with what is left behind or towed meanwhile, and when. Tows cost
    ``towing_m_s``, and ``vented_kg`` is missing, as in :func:`followed`.
    """
    if not isinstance(chaser.usable, TankByMass):
        refuellings = sum(destination in instance.station_names for destination, _ in legs)
        full = chaser.usable.delta_v_m_s
        return (full - chaser.spent_m_s, *(full,) * refuellings)
    stages = followed(instance, chaser, legs, towing_m_s, vented_kg)
    worths, used = [], 0.0
    for (destination, delta_v), stage in zip(legs, stages[1:], strict=True):
        used += delta_v
        if destination in instance.station_names:
            worths.append(used + stage.on_arrival_m_s)
            used = 0.0
        used += stage.removal_m_s
    return (*worths, used + stages[-1].left_m_s)


def _less(chaser: Chaser, kits: int, left_m_s: float, vented_kg: Sequence[float], at: int) -> float:
    """Remaining ΔV after venting before a leg, by its place [m/s]."""
    mass = _mass_kg(chaser, kits, left_m_s)
    if mass is None or not vented_kg or not vented_kg[at]:
        return left_m_s
    return _left_m_s(chaser, kits, mass - vented_kg[at])


def _mass_kg(chaser: Chaser, kits: int, left_m_s: float) -> float | None:
    """Mass with a number of kits and a remaining ΔV [kg]."""
    tank = chaser.usable
    if not isinstance(tank, TankByMass):
        return None
    without = tank.dry_mass_kg + kits * chaser.kit_mass_kg
    return without * math.exp(left_m_s / tank.exhaust_m_s)


def _left_m_s(chaser: Chaser, kits: int, mass_kg: float) -> float:
    """Remaining ΔV at a mass, with a number of kits [m/s].

    Of a mass that cannot be, which only a plan has that takes far more than there is, less by far.
    """
    assert isinstance(chaser.usable, TankByMass)
    without = chaser.usable.dry_mass_kg + kits * chaser.kit_mass_kg
    return chaser.usable.exhaust_m_s * math.log(max(mass_kg / without, LEAST_SHARE))
