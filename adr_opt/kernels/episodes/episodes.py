"""Many missions at once: a pool of timetables, the episodes on it, and one step of them all.

A *slot* of the pool holds one field; several episodes may play on it with budgets and durations of
their own. Fields may differ in their number of targets: arrays have room for the largest.

Actions are numbered as the environment numbers them: the targets in their order, then the station.
"""

from typing import NamedTuple

import numpy as np

from ...common.constants import SLACK_M_S, SLACK_S
from ..core.compile import inlined, kernel
from ..core.memory import borrowed
from ..core.windows import Windows
from ..rules import rules as rule_kernels
from ..rules.resources import Resources, limits_in
from ..rules.rules import Rules, State
from ..tables import stacked_timetables, timetable

HOME = 0
"""Index of the only station of an episode's mission, where the chaser starts."""

BODIES = 0
"""First column of :attr:`StackedFields.counts`."""

SERVICE, OPENS, LATEST, PRIZE = range(4)
"""Rows of :attr:`StackedFields.limits`."""


class StackedFields(NamedTuple):
    """Data of several fields, stacked.

    Attributes
    ----------
    counts : (slots, 1 + limits) int32
        Bodies of each field, the station first, and then its
        :class:`adr_opt.kernels.rules.resources.CountLimits`.
    orbits : (slots, bodies, columns) float64
        Rows of :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`.
    limits : (slots, 4, bodies or more) float64
        :data:`SERVICE` as in :class:`adr_opt.kernels.rules.rules.Rules`, :data:`OPENS` and
        :data:`LATEST`, the windows [s], of which there may be more than bodies, and :data:`PRIZE`,
        that of each target in mean prizes of the field, 0 for the station: its reward. One array,
        since every one that comes as an argument takes as long as a few moves.
    places : (slots, bodies + 1) int64
        Of second windows.
    is_station : (bodies,) bool
        The same for all fields: the first body is the only station.
    tables : Table
        With a leading axis of slots.
    near : (slots, periods, bodies, nearest) int16
        Nearest targets of each body in each of some periods of the mission, the nearest first; −1
        where there are no more.
    period : (slots,) float64
        How long each is [s].
    """

    counts: np.ndarray
    orbits: np.ndarray
    limits: np.ndarray
    places: np.ndarray
    is_station: np.ndarray
    tables: timetable.Table
    near: np.ndarray
    period: np.ndarray


class Episodes(NamedTuple):
    """The states of many episodes.

    Attributes
    ----------
    slot : (episodes,) int32
        Field of the pool.
    budget, duration : (episodes,) float64
        Full ΔV budget [m/s] and end of the mission [s].
    body : (episodes,) int32
        Where each chaser is.
    since, serviced : (episodes,) int32
    time, left : (episodes,) float64
        As in :class:`adr_opt.kernels.rules.resources.Resources`.
    visited : (episodes, bodies) bool
        Serviced targets; also True for bodies that the field does not have.
    refuelled : (episodes,) int32
        Refuelling stops so far.
    delta_v : (episodes,) float64
        ΔV of all moves so far [m/s].
    collected : (episodes,) float64
        Prizes collected so far [mean prizes of the field].
    """

    slot: np.ndarray
    budget: np.ndarray
    duration: np.ndarray
    body: np.ndarray
    since: np.ndarray
    time: np.ndarray
    left: np.ndarray
    visited: np.ndarray
    serviced: np.ndarray
    refuelled: np.ndarray
    delta_v: np.ndarray
    collected: np.ndarray


@inlined
def rules_of(pool, episodes, e):
    """The mission rules of an episode."""
    slot, bodies = episodes.slot[e], pool.is_station.size
    return Rules(
        table=stacked_timetables.in_slot(pool.tables, slot),
        service=pool.limits[slot, SERVICE, :bodies],
        windows=Windows(pool.places[slot], pool.limits[slot, OPENS], pool.limits[slot, LATEST]),
        prize=pool.limits[slot, PRIZE, :bodies],
        is_station=pool.is_station,
        # Where missions may end is not asked for, since they may end anywhere.
        may_end=pool.is_station,
        stations=1,
        first_target=1,
        start=HOME,
        ready=0.0,
        limits=limits_in(pool.counts[slot, 1:]),
        returns=False,
        budget=episodes.budget[e] + SLACK_M_S,
        duration=episodes.duration[e] + SLACK_S,
        shortest_sortie=0.0,
        loads=None,
        falls=None,
    )


@inlined
def state_of(episodes, e):
    """The state of an episode, which never has kits."""
    return State(
        np.int64(episodes.body[e]),
        Resources(
            episodes.time[e],
            episodes.left[e],
            np.int64(episodes.since[e]),
            np.int64(episodes.serviced[e]),
            np.int64(0),
        ),
    )


@kernel
def begin(pool, episodes, e):
    """Reset an episode to its start: docked at the station with a full budget at t = 0."""
    episodes.body[e] = HOME
    episodes.since[e] = 0
    episodes.time[e] = 0.0
    episodes.left[e] = episodes.budget[e] + SLACK_M_S
    episodes.serviced[e] = 0
    episodes.refuelled[e] = 0
    episodes.delta_v[e] = 0.0
    episodes.collected[e] = 0.0
    bodies = pool.counts[episodes.slot[e], BODIES]
    for j in range(episodes.visited.shape[1]):
        episodes.visited[e, j] = j >= bodies


@inlined
def body_of(action, targets):
    """Body that an action leads to: actions are the targets in order, then the station."""
    return HOME if action == targets else action + 1


@inlined
def action_of(body, targets):
    """Action that leads to a body, the inverse of :func:`body_of`."""
    return targets if body == HOME else body - 1


@kernel
def move(pool, episodes, e, destination):
    """Make one move of one episode if it is legal.

    Returns
    -------
    legal : bool
        Nothing has changed if not.
    """
    pool, episodes = borrowed(pool), borrowed(episodes)
    rules, state = rules_of(pool, episodes, e), state_of(episodes, e)
    if not rule_kernels.may_go(rules, state, episodes.visited[e], destination):
        return False
    legal, delta_v, after = rule_kernels.step(rules, state, destination)
    if not legal:
        return False
    there = after.resources
    episodes.body[e], episodes.time[e], episodes.left[e] = after.body, there.time, there.left
    episodes.since[e], episodes.serviced[e] = there.since, there.serviced
    episodes.delta_v[e] += delta_v
    episodes.collected[e] += rules.prize[destination]
    if rules.is_station[destination]:
        episodes.refuelled[e] += 1
    else:
        episodes.visited[e, destination] = True
    return True


@kernel
def make_mask(pool, episodes, e, mask):
    """Legal actions of an episode, written into ``mask`` (actions,) bool; returns their number."""
    pool, episodes, mask = borrowed(pool), borrowed(episodes), borrowed(mask)
    rules = rules_of(pool, episodes, e)
    bodies = pool.counts[episodes.slot[e], BODIES]
    targets = mask.size - 1
    state = state_of(episodes, e)
    count = 0
    for action in range(targets + 1):
        mask[action] = False
    for j in range(bodies):
        if rule_kernels.may_go(rules, state, episodes.visited[e], j):
            if rule_kernels.step(rules, state, j)[0]:
                mask[action_of(j, targets)] = True
                count += 1
    return count


@kernel
def begin_many(pool, episodes, which, slots, budgets, durations):
    """Reset some episodes to the start of missions on other slots of the pool.

    Parameters
    ----------
    which : (starts,) int
    slots : (starts,) int
    budgets, durations : (starts,) float64
    """
    pool, episodes = borrowed(pool), borrowed(episodes)
    for place in range(which.size):
        e = which[place]
        episodes.slot[e] = slots[place]
        episodes.budget[e] = budgets[place]
        episodes.duration[e] = durations[place]
        begin(pool, episodes, e)


@kernel
def act(pool, episodes, first, last, actions, rewards, order=None):
    """Take one action in each of the episodes ``first`` to ``last`` − 1.

    Parameters
    ----------
    actions : (episodes,) int64
    rewards : (episodes,) float32
        Written: the prize of a serviced target in mean prizes of the field, 0 for refuelling, −1
        for an illegal action.
    order : (episodes,) int, optional
        The episodes are ``order[first:last]`` instead.
    """
    pool, episodes = borrowed(pool), borrowed(episodes)
    targets = episodes.visited.shape[1] - 1
    for place in range(first, last):
        e = place if order is None else order[place]
        action = actions[e]
        legal = False
        if 0 <= action <= targets:
            legal = move(pool, episodes, e, body_of(action, targets))
        if not legal:
            rewards[e] = -1.0
        else:
            rewards[e] = pool.limits[episodes.slot[e], PRIZE, body_of(action, targets)]
