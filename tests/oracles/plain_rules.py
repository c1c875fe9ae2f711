"""The rules of a mission once more, one small function for each, over small frozen states.

Plain NumPy, and independent of the rules of planners and judges: nothing is imported from them. A
rule is read as that of one state and one leg to one place; states and legs are arrays, so that it
holds for many at once. `move` applies one rule after the other, in the order of the mission. Every
rule is monotone: who is ready earlier, has more left and has spent less may do whatever another
one may.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.common.constants import SLACK_M_S, SLACK_S

Numbers = npt.NDArray[np.float64]
Counts = npt.NDArray[np.int64]
Truth = npt.NDArray[np.bool_]


class Leg(NamedTuple):
    """Connections between two places: when they depart and arrive, and their ΔV."""

    departure_s: Numbers
    arrival_s: Numbers
    delta_v_m_s: Numbers


class Tow(NamedTuple):
    """How long a tow takes, its ΔV, the mass that is towed, and the part that is flown without."""

    time_s: float
    delta_v_m_s: float
    mass_kg: float
    back_m_s: float = 0.0


@dataclass(frozen=True)
class Place:
    """A body: a station, a target, or one that only lends its orbit to a start.

    The first ``capture_s`` of a stay lie within one of ``windows_s``, its beginnings and ends.
    ``prizes`` are those of a target where they fall: until when, and how much, at last for ever.
    """

    kind: str
    stay_s: float = 0.0
    windows_s: tuple[tuple[float, float], ...] = ((0.0, math.inf),)
    capture_s: float = 0.0
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

    def filled(self, kits: Counts) -> Numbers:
        """What it holds after refuelling."""
        return np.array(self.full)[kits]

    def after(self, content: Numbers, delta_v_m_s: Numbers | float) -> Numbers:
        """What a burn leaves: less ΔV, or less mass by the equation of Tsiolkovsky."""
        if self.exhaust_m_s == 0.0:
            return content - delta_v_m_s
        return content * np.exp(-delta_v_m_s / self.exhaust_m_s)

    def empty(self, kits: Counts) -> Numbers:
        """The least content that is legal: nothing, or the dry mass with its kits, less slack."""
        if self.exhaust_m_s == 0.0:
            return np.zeros(kits.shape)
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
    most_between_refuels: float = math.inf
    cost: str = "delta-v"
    per_s: float = 0.0
    expense: tuple[float, float, float] = (0.0, 0.0, 0.0)


class State(NamedTuple):
    """Chasers at one place, having serviced some targets.

    Attributes
    ----------
    done : (states,) int
        A bit for each place that has been serviced.
    targets : (states,) int
        How many these are.
    visits : (states,) int
        Of targets since the last refuelling, or since the start.
    kits : (states,) int
        Aboard.
    ready_s : (states,) float
    content : (states,) float
        Of the tank.
    spent_m_s : (states,) float
    launched_kg : (states,) float
        Mass at launch that what is no longer aboard has taken.
    per_kg : (states,) float
        Mass at launch for each kilogram that is still aboard; 0 once the first tank is done.
    lost : (states,) float
        What prizes have fallen by.
    uses : (states, 2 * stations) float
        How often it has refuelled at each station with a limit, and by how many kilograms.
    before : (states,) int
        Number of the one that it was before its last move; −1 at the start.
    """

    done: Counts
    targets: Counts
    visits: Counts
    kits: Counts
    ready_s: Numbers
    content: Numbers
    spent_m_s: Numbers
    launched_kg: Numbers
    per_kg: Numbers
    lost: Numbers
    uses: Numbers
    before: Counts

    def of(self, which: Counts | Truth) -> State:
        """Some of them."""
        return State(*(column[which] for column in self))


def begin(world: World) -> State:
    """At the start, with any number of kits aboard."""
    kits = np.arange(len(world.tank.full))
    none, nothing = np.zeros(kits.size, np.int64), np.zeros(kits.size)
    return State(
        done=none,
        targets=none,
        visits=none,
        kits=kits,
        ready_s=nothing + world.since_s,
        content=np.array(world.tank.at_start),
        spent_m_s=nothing,
        launched_kg=nothing,
        per_kg=nothing + 1.0,
        lost=nothing,
        uses=np.zeros((kits.size, limits(world).size)),
        before=none - 1,
    )


def may_go(world: World, state: State, here: int, there: int) -> Truth:
    """A target once, if both numbers allow and a kit is left; a station from targets only."""
    place = world.places[there]
    if place.kind == "station":
        return np.full(state.done.shape, world.places[here].kind == "target")
    is_new = (state.done >> there & 1 == 0) & (state.targets < world.most_targets)
    is_new &= state.visits < world.most_between_refuels
    return is_new & (state.kits >= place.takes_kit) & (place.kind == "target")


def may_leave(state: State, leg: Leg) -> Truth:
    """A chaser departs when it is ready, or later."""
    return leg.departure_s >= state.ready_s - SLACK_S


def end_of_stay(world: World, place: Place, leg: Leg) -> Numbers:
    """A stay begins once its capture is within a window; it ends in the mission, and so does a tow.

    Infinite if not.
    """
    begin_s = np.full(leg.arrival_s.shape, np.inf)
    for opens_s, closes_s in reversed(place.windows_s):
        here_s = np.maximum(leg.arrival_s, opens_s)
        begin_s = np.where(here_s + place.capture_s <= closes_s + SLACK_S, here_s, begin_s)
    done_s = begin_s + place.stay_s + (place.tow.time_s if place.tow else 0.0)
    return np.where(done_s <= world.until_s + SLACK_S, done_s, np.inf)


def content_after(world: World, state: State, place: Place, leg: Leg) -> Numbers:
    """The tank suffices for the leg, and then for a tow; a station fills it, and a kit stays.

    Minus infinity if it does not suffice.
    """
    tank = world.tank
    content = tank.after(state.content, leg.delta_v_m_s)
    suffices = content >= tank.empty(state.kits)
    if place.kind == "station":
        content = tank.filled(state.kits)
    if place.takes_kit:
        content = content - tank.kit_kg
    if place.tow is not None:
        both = content + place.tow.mass_kg
        docked_m_s = place.tow.delta_v_m_s - place.tow.back_m_s
        content = tank.after(both, docked_m_s) - place.tow.mass_kg
        content = tank.after(content, place.tow.back_m_s)
        suffices &= content >= tank.empty(state.kits)
    return np.where(suffices, content, -np.inf)


def launched(world: World, state: State, place: Place, leg: Leg) -> tuple[Numbers, Numbers]:
    """The mass at launch that is accounted for, and that of each kilogram that is still aboard.

    A burn of the first tank multiplies what is aboard after it. What is left at a place, what a tow
    burns for what it pulls, and at a station the whole chaser, is accounted for there.
    """
    if world.cost != "mass":
        return state.launched_kg, state.per_kg
    tank = world.tank
    per_kg = state.per_kg * np.exp(leg.delta_v_m_s / tank.exhaust_m_s)
    if place.kind == "station":
        whole_kg = tank.dry_kg + state.kits * tank.kit_kg
        return state.launched_kg + per_kg * whole_kg, np.zeros(per_kg.shape)
    if place.takes_kit:
        return state.launched_kg + per_kg * tank.kit_kg, per_kg
    if place.tow is not None:
        docked = math.exp((place.tow.delta_v_m_s - place.tow.back_m_s) / tank.exhaust_m_s)
        more = math.exp(place.tow.delta_v_m_s / tank.exhaust_m_s)
        return state.launched_kg + per_kg * place.tow.mass_kg * (docked - 1.0), per_kg * more
    return state.launched_kg, per_kg


def loss(place: Place, end_s: Numbers) -> Numbers:
    """What the prize has fallen by when a service ends then."""
    lost = np.zeros(end_s.shape)
    for (until_s, _), (_, prize) in zip(place.prizes, place.prizes[1:], strict=False):
        lost[end_s > until_s + SLACK_S] = place.prizes[0][1] - prize
    return lost


def limits(world: World) -> Numbers:
    """Of each station, the most refuellings and the most kilograms."""
    stations = (place for place in world.places if place.kind == "station")
    return np.array([most for each in stations for most in (each.refuellings, each.propellant_kg)])


def uses_after(world: World, state: State, there: int, leg: Leg) -> Numbers:
    """One more refuelling, by what is missing in the tank, where a station has limits."""
    place, tank, uses = world.places[there], world.tank, state.uses.copy()
    if place.kind == "station" and min(place.refuellings, place.propellant_kg) < math.inf:
        uses[:, 2 * there] += 1.0
        if tank.exhaust_m_s > 0.0:
            left = tank.after(state.content, leg.delta_v_m_s)
            uses[:, 2 * there + 1] += tank.filled(state.kits) - left
    return uses


def move(world: World, state: State, number: Counts, there: int, leg: Leg) -> State:
    """The states after legs to a place where they `may_go`, and the stay there, of legal ones.

    ``number`` is that of each state before.
    """
    place = world.places[there]
    ready_s = end_of_stay(world, place, leg)
    content = content_after(world, state, place, leg)
    uses = uses_after(world, state, there, leg)
    launched_kg, per_kg = launched(world, state, place, leg)
    is_target = place.kind == "target"
    towed_m_s = place.tow.delta_v_m_s if place.tow else 0.0
    after = State(
        done=state.done | (is_target << there),
        targets=state.targets + is_target,
        visits=(state.visits + 1) * is_target,
        kits=state.kits - place.takes_kit,
        ready_s=ready_s,
        content=content,
        spent_m_s=state.spent_m_s + leg.delta_v_m_s + towed_m_s,
        launched_kg=launched_kg,
        per_kg=per_kg,
        lost=state.lost + loss(place, ready_s),
        uses=uses,
        before=number,
    )
    is_within = (uses <= limits(world)).all(axis=1)
    return after.of(may_leave(state, leg) & (ready_s < np.inf) & (content > -np.inf) & is_within)


def price(world: World, state: State) -> Numbers:
    """All that is better if it is less, among states with equal targets, place and kits."""
    of_cost = {"mass": (state.launched_kg, state.per_kg), "delta-v": (state.spent_m_s,)}
    always = state.ready_s, -state.content, state.lost, *of_cost.get(world.cost, ())
    visits = (state.visits,) if world.most_between_refuels < math.inf else ()
    return np.column_stack((*always, *visits, state.uses))


def cost(world: World, state: State) -> Numbers:
    """What routes cost that end here; nothing if they have no legs."""
    fixed, per_kg, per_kg_squared = world.expense
    if world.cost == "duration":
        paid = state.ready_s
    elif world.cost == "delta-v":
        paid = state.spent_m_s + world.per_s * (state.ready_s - world.since_s)
    elif world.cost == "expense":
        paid = np.full(state.ready_s.shape, fixed)
    else:
        whole_kg = world.tank.dry_kg + state.kits * world.tank.kit_kg
        weight_kg = state.launched_kg + state.per_kg * whole_kg - world.tank.dry_kg
        paid = fixed + per_kg * weight_kg + per_kg_squared * weight_kg**2
    return np.where(state.before < 0, 0.0, paid)
