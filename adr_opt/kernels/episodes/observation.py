"""Observations ``choices`` of many episodes: rows of :mod:`.choices`, filled from timetables."""

from typing import NamedTuple

import numpy as np

from ..core.compile import inlined, kernel
from ..core.memory import borrowed
from ..rules import rules as rule_kernels
from ..tables import timetable
from .choice_rows import look_ahead, note_onward, write_rows
from .choices import CERTAIN, LOOKED_AHEAD, ONWARD, Standing
from .episodes import BODIES, HOME, SERVICE, action_of, rules_of, state_of
from .worlds import ALL_TRIES_S, CAUGHT, GONE_CHANCE, LATE_S, MEAN_S, SUCCESS, kind_of


class ObservationArrays(NamedTuple):
    """Arrays that observations are written to, by episode.

    Attributes
    ----------
    moves : (episodes, actions, fields) float32
        :data:`.choices.CHOICE_FIELDS` of every action; 0 for targets that are visited or that the
        field does not have.
    mission : (episodes, len(MISSION_FIELDS)) float32
        :data:`.choices.MISSION_FIELDS`.
    mask : (episodes, actions) bool
        Legal actions.
    legal : (episodes,) int32
        Number of legal actions.
    """

    moves: np.ndarray
    mission: np.ndarray
    mask: np.ndarray
    legal: np.ndarray


@kernel
def observe_choices(pool, episodes, order, first, last, into, worlds, choices):
    """Observations ``choices`` of the episodes ``order[first:last]``.

    Those of one field side by side are quicker: their table is then in the cache.

    Parameters
    ----------
    order : (episodes,) int32
    into : ObservationArrays
        Written.
    worlds : Worlds or None
        None where everything goes as planned.
    choices : Choices
        Scratch for as many choices as there are actions.
    """
    pool, episodes, worlds = borrowed(pool), borrowed(episodes), borrowed(worlds)
    moves, mission, mask, legal = borrowed(into)
    choices = borrowed(choices)
    targets = mask.shape[1] - 1
    places = np.empty(targets + 1, dtype=np.int64)
    near = np.empty((targets + 1, pool.near.shape[3]), dtype=np.int16)
    there = np.empty((LOOKED_AHEAD, 1 + ONWARD), dtype=np.int64)
    is_open = np.empty(targets + 1, dtype=np.bool_)
    for place in range(first, last):
        e = order[place]
        slot = episodes.slot[e]
        rules, state = rules_of(pool, episodes, e), state_of(episodes, e)
        bodies, visited = pool.counts[slot, BODIES], episodes.visited[e]
        has = state.resources
        period = min(int(has.time / pool.period[slot]), pool.near.shape[1] - 1)
        moves[e] = 0.0
        mask[e] = False
        count, allowed = 0, 0
        for j in range(bodies):
            is_open[j] = j != HOME and not visited[j]
            if not (j == HOME or is_open[j]):
                continue
            _fill(rules, state, visited, choices, count, j)
            _fill_stay(pool, episodes, worlds, e, choices, count)
            near[count] = pool.near[slot, period, j]
            places[count] = action_of(j, targets)
            mask[e, places[count]] = choices.legal[count]
            allowed += choices.legal[count]
            count += 1
        look_ahead(choices, near, is_open, has.time, count, there)
        for row in range(LOOKED_AHEAD):
            at = there[row, 0]
            for column in range(1, 1 + ONWARD):
                k = there[row, column]
                if at >= 0 and k >= 0:
                    ready = choices.end[at]
                    delta_v, arrival = timetable.lookup(rules.table, choices.bodies[at], k, ready)
                    seconds = arrival + rules.service[k] - ready
                    note_onward(choices, at, seconds, delta_v, rules.duration)
        legal[e] = allowed
        standing = Standing(
            has.time,
            rules.duration,
            has.left,
            rules.budget,
            has.since,
            state.body == HOME,
            pool.orbits[slot, state.body],
            pool.orbits[slot, HOME],
        )
        write_rows(standing, choices, count, pool.orbits[slot], places, moves[e], mission[e])


@inlined
def _fill(rules, state, visited, choices, at, j):
    """Fill in the planned values of a choice."""
    choices.bodies[at], choices.station[at] = j, j == HOME
    choices.open[at] = j != state.body and (j != HOME or state.resources.since > 0)
    choices.legal[at] = False
    choices.needed[at], choices.end[at], choices.left[at] = np.inf, np.inf, -np.inf
    choices.back[at], choices.back_end[at] = 0.0, np.inf
    choices.onward[at] = np.inf
    choices.worth[at] = rules.prize[j]
    # The rules that make a move also say whether it is legal, so that no mask differs from them.
    if rule_kernels.may_go(rules, state, visited, j):
        fits, needed, after = rule_kernels.step(rules, state, j)
        end = after.resources.time
        choices.legal[at], choices.needed[at] = fits, needed
        choices.end[at], choices.left[at] = end, after.resources.left
        choices.back_end[at] = end
        if j != HOME and end <= rules.duration:
            back, arrival = timetable.lookup(rules.table, j, HOME, end)
            choices.back[at], choices.back_end[at] = back, arrival + rules.service[HOME]


@inlined
def _fill_stay(pool, episodes, worlds, e, choices, at):
    """Fill in the distribution of a choice's outcome."""
    slot, j, stay = episodes.slot[e], choices.bodies[at], choices.stay[at]
    if worlds is None:
        stay[0], stay[1], stay[2] = 1.0, 0.0, 1.0
        stay[3:] = pool.limits[slot, SERVICE, j]
        for column in range(len(CERTAIN)):
            choices.factor[at, column] = CERTAIN[column]
        return
    tables = worlds.tables
    model, kind = worlds.states.model[e], 0
    if tables.families.shape[2] > 0:
        rules, state = rules_of(pool, episodes, e), state_of(episodes, e)
        kind = kind_of(pool, worlds, slot, rules, state, j)
    what = tables.models[slot, model, j]
    stay[0], stay[1], stay[2] = what[CAUGHT], what[GONE_CHANCE], what[SUCCESS]
    stay[3], stay[4], stay[5] = what[MEAN_S], what[LATE_S], what[ALL_TRIES_S]
    choices.factor[at] = tables.factors[slot, model, kind, j]
