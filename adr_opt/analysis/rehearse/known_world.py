"""A world as the deterministic mission of a clairvoyant (docs/model.md section 13).

A target with several tries is two bodies where the first try fails: one at which the chaser goes on
to the end, and one at which it gives up. Each relaxation is in favour of the clairvoyant, so that a
bound on this mission holds for every policy in that world:

* a leg to a station costs what the cheapest of its visits by any chaser does;
* a tank holds as much as the best of its fillings;
* a chaser that gives up has tried once, at the worth of all tries that failed; both bodies may be
  visited, and where connections are given, to go on takes no longer than one try;
* one try follows upon another at once, whatever its windows;
* a target without success takes no kit, is not towed, and counts towards no maximum;
* no target is required, and a chaser may end anywhere.

Where penalties price services of uncertain times, those may end after the mission, and count what
is left of their worth then: prizes that fall.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import count
from typing import NamedTuple

import numpy as np

from ...common.constants import SLACK_S
from ...common.errors import InputError
from ...legs.connection_finder import ConnectionFinder
from ...legs.corrections import Corrections
from ...mission.problem import Problem
from ...plan.leg_kinds import leg_kinds
from ...problem.bodies import Target
from ...problem.capture_windows import intervals_of, windows_from
from ...problem.chasers import AnyTank, AtStation, Chaser, TankByMass
from ...problem.instance import Instance
from ...problem.settings import Objective
from ...problem.uncertainty import Uncertainty
from ...problem.world import DrawnWorld
from .mission_facts import MissionFacts
from .tries import rounded_up
from .worths import Counted, Worth

UNIT_DIGITS, ALMOST = 3, 1e-9
"""Digits of falling prizes after the first digit of the largest prize; excess that counts as
rounding [units]."""


class StandIn(NamedTuple):
    """A body that stands for a target in a known world.

    Attributes
    ----------
    target : Target
    of : str
        Name of the target that it stands for.
    took_s : float
        Time of its service, without a tow [s].
    planned_s : float
        What that was planned to be [s].
    uncounted : int
        Services that count towards no maximum.
    over_s : float or None
        By what the service may end after the mission; None where it has to end before [s].
    """

    target: Target
    of: str
    took_s: float
    planned_s: float
    uncounted: int
    over_s: float | None = None


def timed_stand_in(
    facts: MissionFacts, world: DrawnWorld, counted: Counted, target: Target, planned_s: float
) -> StandIn:
    """A body for a target whose prize falls as less time is left at its service.

    One that has begun in time may go on after the mission.
    """
    name, mission_s = target.name, facts.instance.mission.duration_s
    is_gone = world.is_gone(name)
    took_s = 0.0 if is_gone else world.service_s(name, planned_s)
    caught = not is_gone and world.first_success(name) is not None
    unit = _unit(facts.instance)
    prizes = [counted.going_on, *(level.worth for level in counted.late or ())]
    *falling, last = (_whole(prize, unit) for prize in prizes)
    ends_s = [mission_s - level.below_s + took_s for level in counted.late or ()]
    until = [(end_s, prize) for end_s, prize in zip(ends_s, falling, strict=True) if end_s > 0.0]
    made = target.replace(
        prize=last,
        prize_until=_strictly_falling(until, last) or None,
        required=False,
        removal=target.removal if caught else "visit",
    )
    return StandIn(made, name, took_s, planned_s, int(not caught), max(took_s - planned_s, 0.0))


def _strictly_falling(
    levels: Sequence[tuple[float, float]], last: float
) -> tuple[tuple[float, float], ...]:
    """The levels without those from which a prize does not fall to the next one."""
    after = [*(prize for _, prize in levels), last][1:]
    return tuple(level for level, then in zip(levels, after, strict=True) if level[1] > then)


def _unit(instance: Instance) -> float:
    """Common step of falling prizes, about a thousandth of the largest."""
    most = max(target.prize for target in instance.targets)
    return 10.0 ** (math.floor(math.log10(most)) - UNIT_DIGITS) if most > 0.0 else 1.0


def _whole(prize: float, unit: float) -> float:
    """A prize rounded up to a multiple of a power of ten."""
    return float(f"{math.ceil(prize / unit - ALMOST) * unit:.12g}")


def in_time(stand_ins: Sequence[StandIn], instance: Instance) -> list[StandIn]:
    """The stand-ins with windows that end with the mission, and prizes of one unit.

    They are for a mission that is longer.

    A window limits when a service begins by what is planned of it. A service of a certain prize
    also has to end in time, or is left out.
    """
    kept, mission_s, unit = list[StandIn](), instance.mission.duration_s, _unit(instance)
    for part in stand_ins:
        late_s = 0.0 if part.over_s is not None else max(part.took_s - part.planned_s, 0.0)
        capture_s = part.target.capture_s
        over_s = late_s if capture_s is None else late_s + part.planned_s - capture_s
        found = intervals_of(part.target.windows)
        found[:, 1] = np.minimum(found[:, 1], mission_s - over_s)
        found = found[found[:, 1] > found[:, 0]]
        if len(found):
            own = {"window_s": (0.0, None), "windows_s": windows_from(found)}
            target = part.target.replace(prize=_whole(part.target.prize, unit), **own)
            kept.append(part._replace(target=target))
    return kept


GIVEN_UP = " (given up{})"
"""Suffix of a target's name for the body at which a chaser gives up, numbered if necessary."""


def refuse_bounds(instance: Instance, uncertainty: Uncertainty) -> None:
    """Refuse an instance or uncertainty whose policies cannot be bounded.

    Raises
    ------
    InputError
        A target that takes a kit or is towed may be tried several times, and connections are given,
        of which there are none for the body at which a chaser gives up.
    """
    for target in instance.targets:
        name = target.name
        several = uncertainty.tries_of(name) > 1 and uncertainty.success_of(name) < 1.0
        if several and target.removal != "visit" and instance.transfer.given is not None:
            raise InputError(
                f"target {name!r}: with given connections policies are not bounded where "
                "targets that take a kit or are towed have several tries; give them one"
            )


def known_problem(facts: MissionFacts, world: DrawnWorld, worth: Worth) -> Problem:
    """The mission of a clairvoyant in a world.

    Parameters
    ----------
    facts : MissionFacts
    world : DrawnWorld
    worth : callable
        What each target counts.
    """
    suffix = _suffix(facts.instance)
    stand_ins = [
        part
        for target in map(facts.instance.with_own_windows, facts.instance.targets)
        for part in _parts(facts, world, worth, target, suffix)
    ]
    over_s = max((part.over_s for part in stand_ins if part.over_s is not None), default=None)
    if over_s is not None:
        stand_ins = in_time(stand_ins, facts.instance)
    instance = _known_instance(facts, world, stand_ins, over_s or 0.0)
    corrections = _corrections(facts, world, stand_ins)
    is_same = instance.names == facts.names and not facts.tow_s and not over_s
    if not is_same:  # there are bodies, or orbits that are left, of which nothing is known yet
        finder = ConnectionFinder(instance, corrections)
    elif corrections:
        finder = facts.finder.corrected(corrections).shortened(instance)
    else:
        finder = facts.finder.shortened(instance)
    return Problem(instance, threads=1, connecting=finder)


def _suffix(instance: Instance) -> str:
    """A suffix for names that makes no name ambiguous."""
    names = (*instance.names, *(chaser.name for chaser in instance.chasers))
    suffixes = (GIVEN_UP.format(f", {number}" if number else "") for number in count())
    return next(each for each in suffixes if not any(name.endswith(each) for name in names))


def _parts(
    facts: MissionFacts, world: DrawnWorld, worth: Worth, target: Target, suffix: str
) -> Iterator[StandIn]:
    """The bodies that stand for a target."""
    name, number = target.name, facts.number[target.name]
    planned = float(facts.chasers[0].limits.service[number]) - facts.tow_s.get(number, 0.0)
    counted = worth(target)
    if counted.late is not None:
        yield timed_stand_in(facts, world, counted, target, planned)
        return
    going_on = target.replace(prize=rounded_up(counted.going_on), required=False)
    if world.is_gone(name):
        yield StandIn(going_on.replace(removal="visit"), name, 0.0, planned, 1)
        return
    took, first = world.service_s(name, planned), world.first_success(name)
    if first is None:
        going_on = going_on.replace(removal="visit")
    tries = world.uncertainty.tries_of(name) if first is None else first
    splits = tries > 1 and facts.instance.transfer.given is None
    if splits and first is None and counted.going_on == 0.0:
        splits, tries = False, 1  # there is no reason to go on
    longest = tries * took if splits else took
    yield StandIn(going_on, name, longest, planned, int(first is None))
    if splits:
        giving_up = target.replace(
            name=name + suffix, prize=rounded_up(counted.giving_up), required=False, removal="visit"
        )
        yield StandIn(giving_up, name, took, planned, 1)


def _known_instance(
    facts: MissionFacts, world: DrawnWorld, stand_ins: Sequence[StandIn], over_s: float
) -> Instance:
    instance = facts.instance
    uncounted = sum(part.uncounted for part in stand_ins)
    chasers = tuple(
        _known_chaser(facts, world, number, uncounted, over_s)
        for number in range(len(instance.chasers))
    )
    targets = tuple(part.target for part in stand_ins)
    duration_s = instance.mission.duration_s + over_s
    mission = instance.mission.replace(launch_separation_s=None, duration_s=duration_s)
    if not any(target.removal == "tow" for target in targets):
        mission = mission.replace(disposal=None)
    objective = instance.objective
    if objective.cost == "expense":  # it is the prizes that count
        objective = Objective()
    return instance.replace(
        targets=targets, chasers=chasers, mission=mission, objective=objective, windows=None
    )


def _known_chaser(
    facts: MissionFacts, world: DrawnWorld, number: int, uncounted: int, over_s: float
) -> Chaser:
    chaser = facts.instance.chasers[number]
    since, until = facts.instance.available_s[number]
    if chaser.is_launched:
        since += world.slip_s(chaser.name)
        since = since if until is None else min(since, until)
    until = None if until is None else until + over_s
    most = None if chaser.max_targets is None else chaser.max_targets + uncounted
    return chaser.replace(
        end="anywhere",
        available_s=(since, until),
        max_targets=most,
        tank=_known_tank(facts, world, chaser),
    )


def _known_tank(facts: MissionFacts, world: DrawnWorld, chaser: Chaser) -> AnyTank:
    """The tank with the largest of its drawn usable shares."""
    if world.uncertainty.tanks is None:
        return chaser.tank
    fillings = range(1, 2 + (most_refuellings(facts) if facts.stations else 0))
    share = max(world.usable_share(chaser.name, filling) for filling in fillings)
    tank = chaser.tank
    if isinstance(tank, TankByMass):
        # A share of the ΔV, whatever is aboard, so that less propellant might hold less.
        return tank
    if tank.initial_delta_v_m_s is not None:
        return tank
    full = tank.delta_v_m_s
    if isinstance(chaser.start, AtStation) or not facts.stations:
        return tank.replace(delta_v_m_s=share * full)
    first = world.usable_share(chaser.name, 1) * full
    return tank.replace(delta_v_m_s=share * full, initial_delta_v_m_s=first)


def _corrections(
    facts: MissionFacts, world: DrawnWorld, stand_ins: Sequence[StandIn]
) -> Corrections:
    """Drawn costs of connections and times of services."""
    instance, uncertainty = facts.instance, world.uncertainty
    origins = (*facts.names[: facts.first_target], *(part.target.name for part in stand_ins))
    factors: dict[tuple[str, str], float] = {}
    known = uncertainty.legs.delta_v_factor is not None or bool(uncertainty.legs.kinds)
    known |= any(each.delta_v_factor is not None for each in uncertainty.targets.values())
    for kind in (each.name for each in leg_kinds()) if known else ():
        for name in facts.names[: facts.stations]:
            factors[name, kind] = min(
                world.station_factor(kind, chaser.name, name, visit)
                for chaser in instance.chasers
                for visit in range(1, most_refuellings(facts) + 1)
            )
        for part in stand_ins:
            factors[part.target.name, kind] = world.leg_factor(kind, part.of)
    shares = {
        (origin, name, kind): factor
        for (name, kind), factor in factors.items()
        if factor != 1.0
        for origin in origins
        if origin != name
    }
    services = {
        part.target.name: part.took_s for part in stand_ins if part.took_s != part.planned_s
    }
    return Corrections(shares=shares, services_s=services)


def most_refuellings(facts: MissionFacts) -> int:
    """Maximum number of legs of one chaser to one station, by its targets and its time."""
    instance = facts.instance
    targets = len(instance.targets)
    if not targets or not facts.stations:
        return 1
    limits = facts.chasers[0].limits
    # Every refuelling follows a target: each takes at least the refuelling.
    least = float(limits.service[: facts.stations].min())
    if least <= SLACK_S:
        return targets
    return max(1, min(targets, math.ceil(instance.mission.duration_s / least)))
