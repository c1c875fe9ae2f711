"""The rules of a mission once more, one small function for each, over a small frozen state.

Plain Python, and independent of the rules of planners and judges: nothing is imported from them.
``move`` applies one rule after the other, in the order of the mission. Every rule is monotone:
whoever is ready earlier, has more left and has spent less may do whatever another one may.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from adr_opt.common.constants import SLACK_M_S, SLACK_S


class Leg(NamedTuple):
    """A connection: when it departs and arrives, and its ΔV."""

    departure_s: float
    arrival_s: float
    delta_v_m_s: float


class Tow(NamedTuple):
    """How long a tow takes, its ΔV, and the mass that is towed."""

    time_s: float
    delta_v_m_s: float
    mass_kg: float


@dataclass(frozen=True)
class Place:
    """A body: a station, a target, or one that only lends its orbit to a start.

    ``prizes`` are those of a target where they fall: until when, and how much, at last for ever.
    """

    kind: str
    stay_s: float = 0.0
    opens_s: float = 0.0
    closes_s: float = math.inf
    takes_kit: bool = False
    tow: Tow | None = None
    prizes: tuple[tuple[float, float], ...] = ()
    refuellings: float = math.inf
    propellant_kg: float = math.inf


@dataclass(frozen=True)
class Tank:
    """A tank. ``exhaust_m_s`` of 0: it holds a ΔV, and masses are unknown.

    Otherwise its content is the mass of the whole chaser. ``full`` and ``at_start`` are contents by
    the number of kits aboard.
    """

    full: tuple[float, ...]
    at_start: tuple[float, ...]
    exhaust_m_s: float = 0.0
    dry_kg: float = 0.0
    kit_kg: float = 0.0

    def after(self, content: float, delta_v_m_s: float) -> float:
        """What a burn leaves: less ΔV, or less mass by the equation of Tsiolkovsky."""
        if self.exhaust_m_s == 0.0:
            return content - delta_v_m_s
        return content * math.exp(-delta_v_m_s / self.exhaust_m_s)

    def empty(self, kits: int) -> float:
        """The least content that is legal: nothing, or the dry mass with its kits, less slack."""
        if self.exhaust_m_s == 0.0:
            return 0.0
        return self.after(self.dry_kg + kits * self.kit_kg, SLACK_M_S)


@dataclass(frozen=True)
class World:
    """What a chaser meets: places with stations first, its tank, its times, its limits, its cost.

    ``cost`` is ``"delta-v"``, ``"duration"``, ``"expense"`` without masses, or ``"mass"``: the
    expense of what has to be launched. ``expense`` is fixed, for each kilogram, and its square.
    """

    places: tuple[Place, ...]
    tank: Tank
    start: int
    end: int | None = None
    since_s: float = 0.0
    until_s: float = math.inf
    most_targets: float = math.inf
    cost: str = "delta-v"
    per_s: float = 0.0
    expense: tuple[float, float, float] = (0.0, 0.0, 0.0)


class State(NamedTuple):
    """A chaser at a place, having serviced some targets.

    Attributes
    ----------
    done : frozenset of int
    place : int
    kits : int
        Aboard.
    ready_s : float
    content : float
        Of the tank.
    spent_m_s : float
    launched_kg : float
        Mass at launch that what is no longer aboard has taken.
    per_kg : float
        Mass at launch for each kilogram that is still aboard; 0 once the first tank is done.
    lost : float
        What prizes have fallen by.
    uses : tuple of float
        How often it has refuelled at each station with a limit, and by how many kilograms.
    before : State or None
        The one that it was before its last move.
    """

    done: frozenset[int]
    place: int
    kits: int
    ready_s: float
    content: float
    spent_m_s: float = 0.0
    launched_kg: float = 0.0
    per_kg: float = 1.0
    lost: float = 0.0
    uses: tuple[float, ...] = ()
    before: State | None = None


def begin(world: World, kits: int) -> State:
    """At the start, with some kits aboard."""
    return State(
        done=frozenset(),
        place=world.start,
        kits=kits,
        ready_s=world.since_s,
        content=world.tank.at_start[kits],
        uses=(0.0,) * len(limits(world)),
    )


def may_go(world: World, state: State, there: int) -> bool:
    """A target once, if the number allows and a kit is left; a station from targets only."""
    place = world.places[there]
    if place.kind == "station":
        return world.places[state.place].kind == "target"
    return (
        place.kind == "target"
        and there not in state.done
        and len(state.done) < world.most_targets
        and (state.kits > 0 or not place.takes_kit)
    )


def end_of_stay(place: Place, arrival_s: float, until_s: float) -> float | None:
    """A stay begins in its window and ends in it; it ends in the mission, and so does a tow."""
    end_s = max(arrival_s, place.opens_s) + place.stay_s
    if end_s > min(place.closes_s, until_s) + SLACK_S:
        return None
    if place.tow is not None:
        end_s += place.tow.time_s
    return end_s if end_s <= until_s + SLACK_S else None


def content_after(world: World, state: State, place: Place, leg: Leg) -> float | None:
    """The tank suffices for the leg, and then for a tow; a station fills it, and a kit stays."""
    tank = world.tank
    content = tank.after(state.content, leg.delta_v_m_s)
    if content < tank.empty(state.kits):
        return None
    if place.kind == "station":
        return tank.full[state.kits]
    if place.takes_kit:
        content -= tank.kit_kg
    if place.tow is not None:
        both = content + place.tow.mass_kg
        content = tank.after(both, place.tow.delta_v_m_s) - place.tow.mass_kg
        if content < tank.empty(state.kits):
            return None
    return content


def launched(world: World, state: State, place: Place, leg: Leg) -> tuple[float, float]:
    """The mass at launch that is accounted for, and that of each kilogram that is still aboard.

    A burn of the first tank multiplies what is aboard after it. What is left at a place, what a tow
    burns for what it pulls, and at a station the whole chaser, is accounted for there.
    """
    if world.cost != "mass" or state.per_kg == 0.0:
        return state.launched_kg, state.per_kg
    tank = world.tank
    per_kg = state.per_kg * math.exp(leg.delta_v_m_s / tank.exhaust_m_s)
    if place.kind == "station":
        return state.launched_kg + per_kg * (tank.dry_kg + state.kits * tank.kit_kg), 0.0
    if place.takes_kit:
        return state.launched_kg + per_kg * tank.kit_kg, per_kg
    if place.tow is not None:
        more = math.exp(place.tow.delta_v_m_s / tank.exhaust_m_s)
        return state.launched_kg + per_kg * place.tow.mass_kg * (more - 1.0), per_kg * more
    return state.launched_kg, per_kg


def loss(place: Place, end_s: float) -> float:
    """What the prize has fallen by when a service ends then."""
    for until_s, prize in place.prizes:
        if end_s <= until_s + SLACK_S:
            return place.prizes[0][1] - prize
    return 0.0


def limits(world: World) -> tuple[float, ...]:
    """Of each station, the most refuellings and the most kilograms."""
    stations = (place for place in world.places if place.kind == "station")
    return tuple(most for place in stations for most in (place.refuellings, place.propellant_kg))


def uses_after(world: World, state: State, there: int, leg: Leg) -> tuple[float, ...] | None:
    """One more refuelling, by what is missing in the tank; none beyond the limits of a station."""
    place, tank = world.places[there], world.tank
    if place.kind != "station" or min(place.refuellings, place.propellant_kg) == math.inf:
        return state.uses
    times, drawn_kg = state.uses[2 * there] + 1.0, state.uses[2 * there + 1]
    if tank.exhaust_m_s > 0.0:
        drawn_kg += tank.full[state.kits] - tank.after(state.content, leg.delta_v_m_s)
    if times > place.refuellings or drawn_kg > place.propellant_kg:
        return None
    return (*state.uses[: 2 * there], times, drawn_kg, *state.uses[2 * there + 2 :])


def move(world: World, state: State, there: int, leg: Leg) -> State | None:
    """The state after a leg to a place where ``may_go``, and the stay there; None if illegal."""
    place = world.places[there]
    if leg.departure_s < state.ready_s - SLACK_S:
        return None
    content = content_after(world, state, place, leg)
    if content is None:
        return None
    ready_s = end_of_stay(place, leg.arrival_s, world.until_s)
    if ready_s is None:
        return None
    uses = uses_after(world, state, there, leg)
    if uses is None:
        return None
    launched_kg, per_kg = launched(world, state, place, leg)
    return State(
        state.done | {there} if place.kind == "target" else state.done,
        there,
        state.kits - place.takes_kit,
        ready_s,
        content,
        state.spent_m_s + leg.delta_v_m_s + (place.tow.delta_v_m_s if place.tow else 0.0),
        launched_kg,
        per_kg,
        state.lost + loss(place, ready_s),
        uses,
        state,
    )


def may_end(world: World, state: State) -> bool:
    """A route ends where its chaser has to be in the end."""
    return world.end in (None, state.place)


def price(world: World, state: State) -> tuple[float, ...]:
    """All that is better if it is less, among states with equal targets, place and kits."""
    always = state.ready_s, -state.content, state.lost, *state.uses
    if world.cost == "delta-v":
        return *always, state.spent_m_s
    return (*always, state.launched_kg, state.per_kg) if world.cost == "mass" else always


def cost(world: World, state: State) -> float:
    """What a route costs that ends here; nothing if it has no legs."""
    if state.before is None:
        return 0.0
    if world.cost == "duration":
        return state.ready_s
    if world.cost == "delta-v":
        return state.spent_m_s + world.per_s * (state.ready_s - world.since_s)
    fixed, per_kg, per_kg_squared = world.expense
    if world.cost == "expense":
        return fixed
    dry_kg, kits_kg = world.tank.dry_kg, state.kits * world.tank.kit_kg
    weight_kg = state.launched_kg + state.per_kg * (dry_kg + kits_kg) - dry_kg
    return fixed + per_kg * weight_kg + per_kg_squared * weight_kg**2


def sequence(state: State) -> tuple[int, ...]:
    """The places that a chaser has gone to, from the first."""
    return () if state.before is None else (*sequence(state.before), state.place)
