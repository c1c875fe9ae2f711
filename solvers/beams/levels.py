"""Levels of a beam: states, their successors, and the selection of survivors."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.lists import rising
from adr_opt.kernels.core.memory import borrowed, write
from adr_opt.kernels.rules import resources as resource_kernels
from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.kernels.rules.resources import Resources
from adr_opt.kernels.rules.rules import Rules, State
from adr_opt.kernels.tables.timetable import asks

from ..walks.latest_times import Latest, latest_time

STRAIGHT = -1
"""Marks a move without a station on the way."""


class Weights(NamedTuple):
    """Settings as kernels take them: :class:`BeamSettings` in SI units."""

    width: int
    time_weight: float
    delta_v_weight: float
    crowding: float
    noise: float
    guarded: bool
    seed: int


class BeamContext(NamedTuple):
    """Data that are constant over levels.

    Attributes
    ----------
    rules : Rules
    guide : Latest
        Not looked at unless ``guided``.
    guided : bool
    weights : Weights
    keys : (bodies,) uint64
        Random words, for hashes of sets that are sums of words.
    """

    rules: Rules
    guide: Latest
    guided: bool
    weights: Weights
    keys: np.ndarray


class Level(NamedTuple):
    """States of a level, as columns.

    Attributes
    ----------
    body : (width,) int64
    resources : Resources
        Of each state, (width,) each.
    spent, prize : (width,) float64
        ΔV spent [m/s] and prizes collected.
    ahead : (width,) float64
        Sum of the multipliers of the targets not visited.
    key : (width,) uint64
        Hash of the set of targets visited.
    visited : (width, words) uint64
    """

    body: np.ndarray
    resources: Resources
    spent: np.ndarray
    prize: np.ndarray
    ahead: np.ndarray
    key: np.ndarray
    visited: np.ndarray


class Successors(NamedTuple):
    """Successors of a level, as columns.

    Attributes
    ----------
    score : (room,) float64
        Smaller is better.
    parent, move, via : (room,) int32
        State of the level, target, and station on the way or STRAIGHT.
    end, left, spent : (room,) float64
        End of the service [s], ΔV left then, and ΔV spent [m/s]. What else there is of resources is
        worked out of those that are kept only: see :func:`_resources_of`.
    """

    score: np.ndarray
    parent: np.ndarray
    move: np.ndarray
    via: np.ndarray
    end: np.ndarray
    left: np.ndarray
    spent: np.ndarray


class LevelRoom(NamedTuple):
    """Maximum number of states in a level, in total and per body."""

    states: int
    at_body: int


class LevelScratch(NamedTuple):
    """Memory of :func:`keep`.

    Attributes
    ----------
    head : (buckets,) int32
    chain : (width,) int32
        Chains of states with the same hash: the first of each, and the next.
    held : (bodies,) int64
        States at each body.
    waiting : (room,) int64
        Stranded candidates.
    which : (width,) int64
        Written: the candidate that each state kept was.
    """

    head: np.ndarray
    chain: np.ndarray
    held: np.ndarray
    waiting: np.ndarray
    which: np.ndarray


@kernel
def _mix(word):
    """SplitMix64's finaliser, which spreads the bits of a word (Steele, Lea and Flood 2014)."""
    word = (word ^ (word >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    word = (word ^ (word >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return word ^ (word >> np.uint64(31))


@kernel
def key_of(number, seed):
    """Random word of a body; hashes of sets are sums of words."""
    return _mix(np.uint64(number + 1) * np.uint64(0x9E3779B97F4A7C15) + np.uint64(seed))


@kernel
def _threshold(scores, count, wanted):
    """Score of the candidate with rank ``wanted``, by Hoare's selection.

    ``np.partition`` is as quick and takes a quarter of the beam's time to compile.
    """
    kept = scores[:count].copy()
    low, high, place = 0, count - 1, wanted - 1
    while low < high:
        middle = kept[(low + high) // 2]
        first, last = min(kept[low], kept[high]), max(kept[low], kept[high])
        pivot = max(first, min(middle, last))
        i, j = low, high
        while i <= j:
            while kept[i] < pivot:
                i += 1
            while kept[j] > pivot:
                j -= 1
            if i <= j:
                kept[i], kept[j] = kept[j], kept[i]
                i += 1
                j -= 1
        if place <= j:
            high = j
        elif place >= i:
            low = i
        else:
            break
    return kept[place]


@kernel
def _compact(cand, limit, count, wanted):
    """Keep candidates up to a score, with at most ``wanted`` exactly at it; in place."""
    kept = 0
    below = 0
    for c in range(count):
        below += cand.score[c] < limit
    ties = wanted - below
    for c in range(count):
        if cand.score[c] > limit:
            continue
        if cand.score[c] == limit:
            if ties <= 0:
                continue
            ties -= 1
        cand.score[kept], cand.parent[kept] = cand.score[c], cand.parent[c]
        cand.move[kept], cand.via[kept] = cand.move[c], cand.via[c]
        cand.end[kept], cand.left[kept] = cand.end[c], cand.left[c]
        cand.spent[kept] = cand.spent[c]
        kept += 1
    return kept


@kernel
def new_level(width, words):
    """An empty level."""
    return Level(
        np.empty(width, np.int64),
        resource_kernels.columns(width),
        np.empty(width),
        np.empty(width),
        np.empty(width),
        np.empty(width, np.uint64),
        np.empty((width, words), np.uint64),
    )


@kernel
def new_candidates(room):
    """Empty storage for candidates."""
    return Successors(
        np.empty(room),
        np.empty(room, np.int32),
        np.empty(room, np.int32),
        np.empty(room, np.int32),
        np.empty(room),
        np.empty(room),
        np.empty(room),
    )


@inlined
def _is_in(level, s, j):
    """Whether a state has visited a target."""
    return (level.visited[s, j >> 6] >> np.uint64(j & 63)) & np.uint64(1) != 0


@inlined
def _shade(weights, key, word):
    """Random part of a score, from the set of visited targets and the next one."""
    mixed = _mix((key + word) ^ (word * np.uint64(3)))
    return weights.noise * (np.float64(mixed >> np.uint64(11)) * 2.0**-53)


@kernel
def succeed(search, level, size, wanted, cand):
    """The best successors of the states of a level.

    Parameters
    ----------
    search : BeamContext
    level : Level
    size : int
        States in it.
    wanted : int
    cand : Successors
        Written.

    Returns
    -------
    count : int
        Number of candidates, just enough for the best ``wanted`` to be among them.
    priced : int
        Successors looked at.
    """
    rules, level, cand = borrowed(search.rules), borrowed(level), borrowed(cand)
    keys, guide = borrowed(search.keys), borrowed(search.guide)
    guided, weights = search.guided, search.weights
    room = cand.score.size
    ways = np.empty(rules.stations + 1, np.int64)
    back = np.empty(rules.stations + 1)
    full = np.empty(rules.stations + 1)
    count, limit, priced = 0, np.inf, 0
    asking = asks(rules.table)
    for s in range(size):
        has = resource_kernels.at(level.resources, s)
        here = State(level.body[s], has)
        ways[0], back[0], full[0] = STRAIGHT, 0.0, has.time
        choices = 1
        for station in range(rules.stations):
            if station != here.body:
                legal, delta_v, after = rule_kernels.step(rules, here, station)
                if legal:
                    ways[choices], back[choices] = station, delta_v
                    full[choices] = after.resources.time
                    choices += 1
        for place in range(rule_kernels.looked_at(rules)):
            j = rule_kernels.destination(rules, here.body, has.time, place)
            if not asking and _is_in(level, s, j):
                continue
            shade = 0.0
            if weights.noise > 0.0 and not asking:
                shade = _shade(weights, level.key[s], keys[j])
            for way in range(choices):
                begin = here
                if way > 0:
                    refuelled = resource_kernels.extend(
                        has, ways[way], True, back[way], full[way], rules.loads, rules.budget
                    )
                    begin = State(ways[way], refuelled)
                if asking:  # other bodies are near to a station
                    j = rule_kernels.destination(rules, begin.body, begin.resources.time, place)
                    if j < rules.first_target or j == here.body or _is_in(level, s, j):
                        continue
                    if weights.noise > 0.0:
                        shade = _shade(weights, level.key[s], keys[j])
                legal, delta_v, after = rule_kernels.step(rules, begin, j)
                if not legal:
                    continue
                priced += 1
                then = after.resources
                collected = level.prize[s] + rule_kernels.worth_at(rules, j, then.time)
                score = weights.time_weight * then.time - weights.delta_v_weight * then.left
                score -= collected
                if guided:
                    rest = guide.goal - collected - (level.ahead[s] - guide.multipliers[j])
                    late = then.time - latest_time(guide, j, then.left, rest)
                    score = 0.5 * (score + weights.time_weight * late)
                score += shade
                if score > limit:
                    continue
                if count == room:
                    limit = _threshold(cand.score, count, wanted)
                    count = _compact(cand, limit, count, wanted)
                    if score > limit:
                        continue
                cand.score[count], cand.parent[count] = score, s
                cand.move[count], cand.via[count] = j, ways[way]
                cand.end[count], cand.left[count] = then.time, then.left
                cand.spent[count] = level.spent[s] + delta_v + back[way]
                count += 1
    if count > wanted:
        count = _compact(cand, _threshold(cand.score, count, wanted), count, wanted)
    return count, priced


@inlined
def _resources_of(rules, level, cand, c):
    """Resources of a candidate; the remainder of its tank is known."""
    has, end = resource_kernels.at(level.resources, cand.parent[c]), cand.end[c]
    if cand.via[c] != STRAIGHT:
        has = resource_kernels.extend(has, cand.via[c], True, 0.0, end, rules.loads, rules.budget)
    has = resource_kernels.extend(has, cand.move[c], False, 0.0, end, rules.loads, rules.budget)
    return Resources(end, cand.left[c], has.since, has.serviced, has.kits)


@kernel
def keep(search, level, cand, count, room, scratch, after):
    """Keep the best undominated candidates, in the level ``after``; returns their number.

    Parameters
    ----------
    search : BeamContext
    level : Level
    cand : Successors
    count : int
        Successors of the level among them.
    room : LevelRoom
    scratch : LevelScratch
    after : Level
        Written.
    """
    rules, level, cand = borrowed(search.rules), borrowed(level), borrowed(cand)
    after = borrowed(after)
    keys, guide, weights = search.keys, search.guide, search.weights
    head, chain, held, waiting, which = scratch
    order = rising(cand.score, count)
    for bucket in range(head.size):
        head[bucket] = -1
    for body in range(held.size):
        held[body] = 0
    size, stranded = 0, 0
    for turn in range(2 * count):
        if size == room.states or turn == count + stranded:
            break
        c = order[turn] if turn < count else waiting[turn - count]
        s, j = cand.parent[c], np.int64(cand.move[c])
        if held[j] == room.at_body:
            continue
        has = _resources_of(rules, level, cand, c)
        if turn < count and weights.guarded:
            # Asked only here: of all candidates it would take most of the time.
            if not rule_kernels.has_way_back(rules, State(j, has)):
                waiting[stranded] = c
                stranded += 1
                continue
        set_key = level.key[s] + keys[j]
        slot = np.int64(_mix(set_key ^ keys[j]) & np.uint64(head.size - 1))
        prize = level.prize[s] + rule_kernels.worth_at(rules, j, cand.end[c])
        other = head[slot]
        while other >= 0 and not (
            after.key[other] == set_key
            and after.body[other] == j
            and resource_kernels.dominates(
                resource_kernels.at(after.resources, other), has, rules.loads, rules.limits
            )
            and (rules.falls is None or after.prize[other] >= prize)
        ):
            other = chain[other]
        if other >= 0:
            continue
        held[j] += 1
        after.body[size], after.spent[size], after.key[size] = j, cand.spent[c], set_key
        resource_kernels.put(after.resources, size, has)
        after.prize[size] = prize
        if search.guided:
            after.ahead[size] = level.ahead[s] - guide.multipliers[j]
        write(after.visited[size], level.visited[s])
        after.visited[size, j >> 6] |= np.uint64(1) << np.uint64(j & 63)
        chain[size] = head[slot]
        head[slot] = size
        which[size] = c
        size += 1
    return size


@kernel
def begin(search, done, first, serviced, level):
    """Write the initial states of a search to a level; returns their number.

    Parameters
    ----------
    search : BeamContext
    done, first
        As :func:`.beams.beam_kernel` takes them.
    serviced : int
        Targets that are done.
    level : Level
        Written.
    """
    rules, keys = search.rules, search.keys
    body, since, kits, ready, left, spent, lost = first
    size = min(ready.size, level.body.size)
    for s in range(size):
        has = Resources(ready[s], left[s], since, serviced, kits[s])
        resource_kernels.put(level.resources, s, has)
        level.body[s], level.spent[s] = body, spent[s]
        level.prize[s], level.ahead[s], level.key[s] = -lost[s], 0.0, np.uint64(0)
        for word in range(level.visited.shape[1]):
            level.visited[s, word] = np.uint64(0)
        for j in range(rules.first_target, rules.service.size):
            if done[j]:
                level.prize[s] += rules.prize[j]
                level.visited[s, j >> 6] |= np.uint64(1) << np.uint64(j & 63)
                level.key[s] += keys[j]
            elif search.guided:
                level.ahead[s] += search.guide.multipliers[j]
    return size
