"""Episodes in uncertain worlds: the outcome of a move (docs/model.md section 13).

Moves are chosen as planned, by the rules of :mod:`adr_opt.kernels.rules.rules`; then the world
decides. Draws are those of rehearsals: a number for each key, by the state of the world
(:mod:`adr_opt.kernels.core.draws`).
"""

from typing import NamedTuple

import numpy as np

from ...common.constants import SLACK_M_S
from ..core.compile import inlined, kernel
from ..core.draws import delay_at, lognormal_at, uniform_at, world_state
from ..core.memory import borrowed
from ..core.windows import service_begin
from ..rules import rules as rule_kernels
from ..tables import timetable
from .choices import LEAST, MOST, SIGMA
from .episodes import PRIZE, begin, body_of, rules_of, state_of

SERVICED, REFUELLED, FAILED, GONE, LATE, DRY = range(6)
"""Outcome of a move, by the numbers of :data:`adr_opt.problem.world.OUTCOMES`."""

ILLEGAL = -1

LOSSES = 4
"""Number of outcomes that are losses, the last ones."""

LEG_KEY, SERVICE_KEY, DELAY_KEY, GONE_KEY, FIRST_TRY_KEY = range(5)
"""Places of :attr:`WorldTables.target_keys`; those of further tries follow."""

STATION_KEYS, TANK_KEYS = range(2)
"""Rows of :attr:`WorldTables.own_keys`."""

(
    SUCCESS,
    TRIES,
    GONE_CHANCE,
    STAY_SIGMA,
    STAY_LEAST,
    STAY_MOST,
    DELAY_CHANCE,
    DELAY_MEAN,
    DELAY_MOST,
    CAUGHT,
    MEAN_S,
    LATE_S,
    ALL_TRIES_S,
) = range(13)
"""Columns of :attr:`WorldTables.models`."""

OBSERVED = (CAUGHT, GONE_CHANCE, SUCCESS, MEAN_S, LATE_S, ALL_TRIES_S)
"""Observed columns of the models, in the order of :attr:`.choices.Choices.stay`."""

NOTHING_LEFT_M_S = -SLACK_M_S
"""ΔV of a tank that ran dry, too little for any move [m/s]."""


class WorldTables(NamedTuple):
    """Uncertainty of stacked fields, by one model or several.

    Attributes
    ----------
    target_keys : (slots, bodies, 4 + tries) uint64
        Keys of the draws of each target.
    own_keys : (slots, 2, fillings) uint64
        Keys of the legs to the station, and of the fillings of the tank, in order.
    models : (slots, models, bodies, 13) float64
        For each body the chance that a try succeeds, their maximum number, the chance that it is
        gone; spread and bounds of the factor on the time of a service; chance, mean and maximum of
        the delay [s]; then the chance that it is serviced if there is time, the mean time of a try,
        the time that one in ten exceeds, and the mean time of all tries [s].
    factors : (slots, models, kinds, bodies, 5) float64
        Of legs to each body: spread, bounds, mean and standard deviation of the factor; of one kind
        where kinds do not differ.
    tanks : (models, 2) float64
        Least and largest share of a full tank that can be used.
    families : (slots, bodies, events, bodies) int8
        Kind of leg of each entry of the timetables; without events where there is one kind.
    """

    target_keys: np.ndarray
    own_keys: np.ndarray
    models: np.ndarray
    factors: np.ndarray
    tanks: np.ndarray
    families: np.ndarray


class WorldStates(NamedTuple):
    """Worlds of many episodes, and the outcomes of their moves.

    Attributes
    ----------
    seed, state : (episodes,) uint64
        Number of the world, and the state that its draws follow from.
    model : (episodes,) int32
        Number of the model of uncertainty.
    outcome : (episodes,) int8
        Of the latest move; :data:`ILLEGAL` before the first, and of an illegal one.
    tries : (episodes,) int32
        At the target of the latest move.
    losses : (episodes, 4) int32
        Numbers of moves that came to a failed capture, a target that was gone, a late service and a
        dry tank.
    """

    seed: np.ndarray
    state: np.ndarray
    model: np.ndarray
    outcome: np.ndarray
    tries: np.ndarray
    losses: np.ndarray


class Worlds(NamedTuple):
    """The uncertainty of a pool of fields, and the worlds of the episodes on it."""

    tables: WorldTables
    states: WorldStates


@inlined
def _usable(worlds, e, slot, filling):
    """Share of a full tank that can be used, by the number of fillings before."""
    tables, states = worlds
    span = tables.tanks[states.model[e]]
    key = tables.own_keys[slot, TANK_KEYS, filling]
    return span[0] + (span[1] - span[0]) * uniform_at(states.state[e], key)


@inlined
def kind_of(pool, worlds, slot, rules, state, destination):
    """Number of the kind of leg of a move, among those of :attr:`WorldTables.factors`."""
    families = worlds.tables.families
    if families.shape[2] == 0:
        return np.int64(0)
    time = state.resources.time
    event = timetable.next_event(rules.table, state.body, destination, time)
    if event >= timetable.events(rules.table, state.body, destination):
        return np.int64(0)
    return np.int64(families[slot, state.body, event, destination])


@kernel
def begin_worlds(pool, episodes, worlds, which, seeds, models):
    """Begin some episodes again, in worlds of their own.

    Parameters
    ----------
    worlds : Worlds
    which : (starts,) int32
    seeds : (starts,) uint64
    models : (starts,) int32
        Models of uncertainty.
    """
    pool, episodes, worlds = borrowed(pool), borrowed(episodes), borrowed(worlds)
    states = worlds.states
    for place in range(which.size):
        e = which[place]
        begin(pool, episodes, e)
        states.seed[e] = seeds[place]
        states.state[e] = world_state(seeds[place])
        states.model[e] = models[place]
        states.outcome[e] = ILLEGAL
        states.tries[e] = 0
        for loss in range(LOSSES):
            states.losses[e, loss] = 0
        full = episodes.left[e]
        episodes.left[e] = full - (1.0 - _usable(worlds, e, episodes.slot[e], 0)) * full


@inlined
def _tried(worlds, e, slot, target, begins, rules):
    """Tries at a target until one succeeds, all have failed, no window is left, or one ends late.

    Returns
    -------
    outcome, tries : int
    end : float
        Of the last try [s].
    """
    tables, state = worlds.tables, worlds.states.state[e]
    what, keys = tables.models[slot, worlds.states.model[e], target], tables.target_keys[slot]
    took = rules.service[target] * lognormal_at(
        uniform_at(state, keys[target, SERVICE_KEY]),
        what[STAY_SIGMA],
        what[STAY_LEAST],
        what[STAY_MOST],
    )
    took += delay_at(
        uniform_at(state, keys[target, DELAY_KEY]),
        what[DELAY_CHANCE],
        what[DELAY_MEAN],
        what[DELAY_MOST],
    )
    most = int(what[TRIES])
    for attempt in range(most):
        end = begins + took
        if end > rules.duration:
            return LATE, attempt + 1, end
        if what[SUCCESS] >= 1.0:
            return SERVICED, attempt + 1, end
        if uniform_at(state, keys[target, FIRST_TRY_KEY + attempt]) < what[SUCCESS]:
            return SERVICED, attempt + 1, end
        begins = service_begin(rules.windows, target, end)
        if begins == np.inf:
            return FAILED, attempt + 1, end
    return FAILED, most, end


@kernel
def fly(pool, episodes, worlds, e, destination):
    """Make one move of one episode, with the leg and stay that its world draws.

    Returns
    -------
    outcome : int
        :data:`ILLEGAL`, and nothing has changed, if it is not legal as planned.
    """
    pool, episodes, worlds = borrowed(pool), borrowed(episodes), borrowed(worlds)
    tables, states = worlds
    rules, state = rules_of(pool, episodes, e), state_of(episodes, e)
    if not rule_kernels.may_go(rules, state, episodes.visited[e], destination):
        return ILLEGAL
    if not rule_kernels.step(rules, state, destination)[0]:
        return ILLEGAL
    slot, refuels = episodes.slot[e], rules.is_station[destination]
    has = state.resources
    delta_v, arrival = timetable.lookup(rules.table, state.body, destination, has.time)
    kind = kind_of(pool, worlds, slot, rules, state, destination)
    spread = tables.factors[slot, states.model[e], kind, destination]
    # Drawn by what is done and not by when: a world has the same legs for every policy.
    key = tables.target_keys[slot, destination, LEG_KEY]
    if refuels:
        key = tables.own_keys[slot, STATION_KEYS, episodes.refuelled[e]]
    drawn = uniform_at(states.state[e], key)
    cost = lognormal_at(drawn, spread[SIGMA], spread[LEAST], spread[MOST]) * delta_v
    episodes.body[e] = destination
    states.tries[e] = 0
    if cost > has.left:
        episodes.delta_v[e] += has.left
        episodes.left[e] = NOTHING_LEFT_M_S
        episodes.time[e] = arrival
        return DRY
    episodes.delta_v[e] += cost
    begins = service_begin(rules.windows, destination, arrival)
    if refuels:
        episodes.refuelled[e] += 1
        episodes.left[e] = _usable(worlds, e, slot, episodes.refuelled[e]) * rules.budget
        episodes.since[e] = 0
        episodes.time[e] = begins + rules.service[destination]
        return REFUELLED
    episodes.left[e] = has.left - cost
    episodes.since[e] += 1
    episodes.visited[e, destination] = True
    chance = tables.models[slot, states.model[e], destination, GONE_CHANCE]
    if chance > 0.0:
        if uniform_at(states.state[e], tables.target_keys[slot, destination, GONE_KEY]) < chance:
            episodes.time[e] = begins
            return GONE
    outcome, states.tries[e], episodes.time[e] = _tried(worlds, e, slot, destination, begins, rules)
    if outcome == SERVICED:
        episodes.serviced[e] += 1
        episodes.collected[e] += rules.prize[destination]
    return outcome


@kernel
def act_in_worlds(pool, episodes, worlds, first, last, actions, rewards, order):
    """Take one action in each of the episodes ``order[first:last]``.

    Parameters
    ----------
    worlds : Worlds
    actions : (episodes,) int64
    rewards : (episodes,) float32
        Written: the prize of a serviced target in mean prizes of the field, 0 for refuelling and
        for losses, −1 for an illegal action.
    order : (episodes,) int32
    """
    pool, episodes, worlds = borrowed(pool), borrowed(episodes), borrowed(worlds)
    targets = episodes.visited.shape[1] - 1
    states = worlds.states
    for place in range(first, last):
        e = order[place]
        action = actions[e]
        outcome = ILLEGAL
        if 0 <= action <= targets:
            outcome = fly(pool, episodes, worlds, e, body_of(action, targets))
        states.outcome[e] = outcome
        rewards[e] = 0.0
        if outcome == ILLEGAL:
            rewards[e] = -1.0
        elif outcome == SERVICED:
            rewards[e] = pool.limits[episodes.slot[e], PRIZE, body_of(action, targets)]
        elif outcome >= FAILED:
            states.losses[e, outcome - FAILED] += 1
