"""Beam search over partial plans: the kernel shared by the planners that construct.

Level by level: a state of level n has serviced n targets, and its successors are all targets that
can be reached from it directly or after a refuelling on the way (refuelling is part of the move,
so that a level never mixes states before and after it). The `width` best states of a level
survive; of states with the same targets visited and the same body only those that are not later
*and* poorer in ΔV than another are kept: a chaser that is earlier and richer may wait and do all
that the other one can. The states move on the timetable of the mission's choice, so a beam is
exhaustive about where to go, never about when.

States are ordered by a weighted sum, smaller first:

    time_weight · end − delta_v_weight · ΔV left − prizes collected

or, where latest times are known (:mod:`solvers.relaxation.latest`), by the mean of that and of the
worth of the time by which they are later than they may be if the goal is to be reached.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.kernels import rules as rule_kernels
from adr_opt.kernels.compile import inlined, kernel
from adr_opt.kernels.constants import HOUR_S
from adr_opt.kernels.lists import rising
from adr_opt.kernels.memory import borrowed, write
from adr_opt.kernels.rules import State
from adr_opt.mission import Mission
from adr_opt.stop import Stop

from ..halting import halted_by
from ..relaxation.latest import Latest, latest_time, lent, no_latest
from .worth import worth_of

TIME_VALUE_M_S_PER_H = 110.0
"""What an hour is worth where beams, and windows, choose one connection for each move."""

CANDIDATES = 8
"""Candidates looked at for each state kept: some are dominated, stranded, or at a full body."""

LEAST_CANDIDATES = 1024
"""Looked at by narrow beams too: at the end of a tank the best of them are all stranded."""

HURRIED = 20
"""States kept on the levels that are left when the time is over: some ten milliseconds."""

STRAIGHT = -1
"""Stands for no station on the way."""


@dataclass(frozen=True)
class BeamSettings:
    """How a beam search orders and keeps states.

    Attributes
    ----------
    width : int
        States kept on each level.
    time_weight : float
        Worth of an hour [prizes per h].
    delta_v_weight : float
        Worth of a km/s of ΔV left [prizes per km/s].
    crowding : float
        Most states at one body, as a multiple of an equal share; +inf for no limit.
    noise : float
        Width of the random number, uniform and the same for one state in one search, that is
        added to its score [prizes]: makes searches of different seeds differ.
    guarded : bool
        Keep states that can neither refuel nor do without only where there is room after all other
        candidates. Narrow beams strand themselves without this guard.
    """

    width: int
    time_weight: float
    delta_v_weight: float
    crowding: float = 1.7
    noise: float = 0.0
    guarded: bool = True


def usual_settings(mission: Mission, width: int) -> BeamSettings:
    """Settings by what an hour and a km/s are worth in the mission."""
    worth = worth_of(mission)
    return BeamSettings(width, worth.hour, worth.kilometre_per_s)


class Weights(NamedTuple):
    """Settings as the kernel takes them: :class:`BeamSettings` in SI units."""

    width: int
    time_weight: float
    delta_v_weight: float
    crowding: float
    noise: float
    guarded: bool
    seed: int


class Level(NamedTuple):
    """States side by side.

    Attributes
    ----------
    body, since : (width,) int64
    time, left : (width,) float64
        As in :class:`adr_opt.kernels.rules.State`.
    spent, prize : (width,) float64
        ΔV spent [m/s] and prizes collected.
    ahead : (width,) float64
        Sum of the multipliers of the targets not visited.
    key : (width,) uint64
        Hash of the set of targets visited.
    visited : (width, words) uint64
    """

    body: np.ndarray
    since: np.ndarray
    time: np.ndarray
    left: np.ndarray
    spent: np.ndarray
    prize: np.ndarray
    ahead: np.ndarray
    key: np.ndarray
    visited: np.ndarray


class Candidates(NamedTuple):
    """Successors of a level.

    Attributes
    ----------
    score : (room,) float64
        Smaller is better.
    parent, move, via : (room,) int32
        State of the level, target, and station on the way or STRAIGHT.
    end, left, spent : (room,) float64
    """

    score: np.ndarray
    parent: np.ndarray
    move: np.ndarray
    via: np.ndarray
    end: np.ndarray
    left: np.ndarray
    spent: np.ndarray


@kernel
def _mix(word):
    """SplitMix64's finaliser: spreads the bits of a word (Steele, Lea and Flood 2014)."""
    word = (word ^ (word >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    word = (word ^ (word >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return word ^ (word >> np.uint64(31))


@kernel
def _key_of(number, seed):
    """The random word of a body, for hashes of sets that are sums of words."""
    return _mix(np.uint64(number + 1) * np.uint64(0x9E3779B97F4A7C15) + np.uint64(seed))


@kernel
def _threshold(scores, count, wanted):
    """The score of the candidate number ``wanted``, by Hoare's selection.

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
    """Keep the candidates up to a score, at most ``wanted`` of those exactly at it; in place."""
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
def _new_level(width, words):
    return Level(
        np.empty(width, np.int64), np.empty(width, np.int64), np.empty(width), np.empty(width),
        np.empty(width), np.empty(width), np.empty(width), np.empty(width, np.uint64),
        np.empty((width, words), np.uint64),
    )  # fmt: skip


@kernel
def _new_candidates(room):
    return Candidates(
        np.empty(room), np.empty(room, np.int32), np.empty(room, np.int32),
        np.empty(room, np.int32), np.empty(room), np.empty(room), np.empty(room),
    )  # fmt: skip


@inlined
def _lent(level, cand):
    """A level and candidates without ownership, for use within a kernel: no look is counted."""
    return (
        Level(
            borrowed(level.body), borrowed(level.since), borrowed(level.time),
            borrowed(level.left), borrowed(level.spent), borrowed(level.prize),
            borrowed(level.ahead), borrowed(level.key), borrowed(level.visited),
        ),
        Candidates(
            borrowed(cand.score), borrowed(cand.parent), borrowed(cand.move), borrowed(cand.via),
            borrowed(cand.end), borrowed(cand.left), borrowed(cand.spent),
        ),
    )  # fmt: skip


@inlined
def _is_in(level, s, j):
    """Whether a state has visited a target."""
    return (level.visited[s, j >> 6] >> np.uint64(j & 63)) & np.uint64(1) != 0


@kernel
def _succeed(rules, guide, guided, weights, level, size, serviced, keys, wanted, cand):
    """The best successors of the states of a level.

    Returns
    -------
    count : int
        Candidates; at most so many that the best ``wanted`` are among them.
    priced : int
        Successors looked at.
    """
    rules, (level, cand) = rule_kernels.lent(rules), _lent(level, cand)
    keys, guide = borrowed(keys), lent(guide)
    room = cand.score.size
    bodies = rules.service.size
    ways = np.empty(rules.stations + 1, np.int64)
    back = np.empty(rules.stations + 1)
    full = np.empty(rules.stations + 1)
    count, limit, priced = 0, np.inf, 0
    for s in range(size):
        here = State(level.body[s], level.time[s], level.left[s], level.since[s], serviced)
        ways[0], back[0], full[0] = STRAIGHT, 0.0, here.time
        choices = 1
        for station in range(rules.stations):
            if station != here.body:
                legal, delta_v, after = rule_kernels.step(rules, here, station)
                if legal:
                    ways[choices], back[choices], full[choices] = station, delta_v, after.time
                    choices += 1
        for j in range(rules.first_target, bodies):
            if _is_in(level, s, j):
                continue
            shade = 0.0
            if weights.noise > 0.0:
                word = _mix((level.key[s] + keys[j]) ^ (keys[j] * np.uint64(3)))
                shade = weights.noise * (np.float64(word >> np.uint64(11)) * 2.0**-53)
            for way in range(choices):
                begin = here
                if way > 0:
                    begin = State(
                        ways[way], full[way], rules.budget, np.int64(0), np.int64(serviced)
                    )
                legal, delta_v, after = rule_kernels.step(rules, begin, j)
                if not legal:
                    continue
                priced += 1
                collected = level.prize[s] + rules.prize[j]
                score = (
                    weights.time_weight * after.time
                    - weights.delta_v_weight * after.left
                    - collected
                )
                if guided:
                    rest = guide.goal - collected - (level.ahead[s] - guide.multipliers[j])
                    late = after.time - latest_time(guide, j, after.left, rest)
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
                cand.end[count], cand.left[count] = after.time, after.left
                cand.spent[count] = level.spent[s] + delta_v + back[way]
                count += 1
    if count > wanted:
        count = _compact(cand, _threshold(cand.score, count, wanted), count, wanted)
    return count, priced


@kernel
def _keep(
    rules, guide, guided, weights, level, serviced, keys, cand, count, most, share, desk, after
):
    """Keep the best candidates that are not dominated, into the level ``after``; returns how many.

    Parameters
    ----------
    most, share : int
        States to keep in all and at one body.
    desk : tuple of arrays
        Heads (buckets,) and links (width,) of chains of states with the same hash, int32; states
        at each body (bodies,) int64; stranded candidates (room,) int64; and, written, the
        candidate that each state kept was, (width,) int64.
    """
    rules, (level, cand) = rule_kernels.lent(rules), _lent(level, cand)
    after = _lent(after, cand)[0]
    head, chain, held, waiting, which = desk
    order = rising(cand.score, count)
    for bucket in range(head.size):
        head[bucket] = -1
    for body in range(held.size):
        held[body] = 0
    size, stranded = 0, 0
    for turn in range(2 * count):
        if size == most or turn == count + stranded:
            break
        c = order[turn] if turn < count else waiting[turn - count]
        s, j = cand.parent[c], np.int64(cand.move[c])
        if held[j] == share:
            continue
        since = level.since[s] + 1 if cand.via[c] == STRAIGHT else np.int64(1)
        if turn < count and weights.guarded:
            # Asked only here: of all candidates it would take most of the time.
            there = State(j, cand.end[c], cand.left[c], since, np.int64(serviced + 1))
            if not rule_kernels.has_way_back(rules, there):
                waiting[stranded] = c
                stranded += 1
                continue
        set_key = level.key[s] + keys[j]
        slot = np.int64(_mix(set_key ^ keys[j]) & np.uint64(head.size - 1))
        other = head[slot]
        while other >= 0 and not (
            after.key[other] == set_key
            and after.body[other] == j
            and after.time[other] <= cand.end[c]
            and after.left[other] >= cand.left[c]
        ):
            other = chain[other]
        if other >= 0:
            continue
        held[j] += 1
        after.body[size], after.since[size] = j, since
        after.time[size], after.left[size] = cand.end[c], cand.left[c]
        after.spent[size], after.key[size] = cand.spent[c], set_key
        after.prize[size] = level.prize[s] + rules.prize[j]
        if guided:
            after.ahead[size] = level.ahead[s] - guide.multipliers[j]
        write(after.visited[size], level.visited[s])
        after.visited[size, j >> 6] |= np.uint64(1) << np.uint64(j & 63)
        chain[size] = head[slot]
        head[slot] = size
        which[size] = c
        size += 1
    return size


@kernel
def _first_level(rules, guide, guided, done, first, level, keys):
    """Put the states that a search begins with into a level; returns how many."""
    body, since, ready, left, spent = first
    size = min(ready.size, level.body.size)
    for s in range(size):
        level.body[s], level.since[s] = body, since
        level.time[s], level.left[s], level.spent[s] = ready[s], left[s], spent[s]
        level.prize[s], level.ahead[s], level.key[s] = 0.0, 0.0, np.uint64(0)
        for word in range(level.visited.shape[1]):
            level.visited[s, word] = np.uint64(0)
        for j in range(rules.first_target, rules.service.size):
            if done[j]:
                level.prize[s] += rules.prize[j]
                level.visited[s, j >> 6] |= np.uint64(1) << np.uint64(j & 63)
                level.key[s] += keys[j]
            elif guided:
                level.ahead[s] += guide.multipliers[j]
    return size


@kernel
def beam_kernel(rules, done, first, guide, guided, weights, halt):
    """Beam search from some states that have the same body and the same targets done.

    Parameters
    ----------
    rules : Rules
    done : (bodies,) bool
        Targets that are done.
    first : tuple
        Body, targets since the last refuelling, and (states,) float64 each: time ready [s], ΔV left
        [m/s], ΔV spent [m/s]. At most ``width`` are taken.
    guide : Latest
        Not looked at unless ``guided``.
    guided : bool
    weights : Weights
    halt : (1,) bool
        Once another thread sets it, only the best states of each level are gone on with, so that
        the search ends soon, with a plan to the end of the mission.

    Returns
    -------
    sequence : (moves,) int64
        What the best plan found goes on with: most prize, then least ΔV.
    prize, delta_v : float
        Of the whole plan.
    priced : int
        Number of candidates priced.
    """
    bodies, width = rules.service.size, weights.width
    level, after = _new_level(width, (bodies + 63) // 64), _new_level(width, (bodies + 63) // 64)
    keys = np.empty(bodies, np.uint64)
    serviced = 0
    for j in range(bodies):
        keys[j] = _key_of(j, weights.seed)
        serviced += done[j]
    remaining = min(bodies - rules.first_target, rules.most_targets) - serviced
    size = _first_level(rules, guide, guided, done, first, level, keys)

    parent_of = np.empty((remaining, width), np.int32)
    move_of = np.empty((remaining, width), np.int32)
    via_of = np.empty((remaining, width), np.int32)
    best_prize, best_spent, best_level, best_at = level.prize[0], level.spent[0], -1, -1

    wanted = max(CANDIDATES * width, LEAST_CANDIDATES)
    cand = _new_candidates(max(4 * wanted, 4096))
    buckets = 1
    while buckets < 4 * width:
        buckets *= 2
    which = np.empty(width, np.int64)
    desk = (
        np.empty(buckets, np.int32), np.empty(width, np.int32), np.empty(bodies, np.int64),
        np.empty(cand.score.size, np.int64), which,
    )  # fmt: skip
    most = width
    depth, priced = 0, 0
    while depth < remaining and size > 0:
        if halt[0]:
            size = min(size, HURRIED)
            most = min(width, HURRIED)
        share = most
        if weights.crowding < remaining:
            share = max(1, math.ceil(weights.crowding * most / remaining))
        count, looked_at = _succeed(
            rules, guide, guided, weights, level, size, serviced + depth, keys, wanted, cand
        )
        priced += looked_at
        size = _keep(
            rules, guide, guided, weights, level, serviced + depth, keys, cand, count, most, share,
            desk, after,
        )  # fmt: skip
        for s in range(size):
            parent_of[depth, s] = cand.parent[which[s]]
            move_of[depth, s], via_of[depth, s] = cand.move[which[s]], cand.via[which[s]]
            if after.prize[s] > best_prize or (
                after.prize[s] == best_prize and after.spent[s] < best_spent
            ):
                best_prize, best_spent = after.prize[s], after.spent[s]
                best_level, best_at = depth, s
        level, after = after, level
        depth += 1

    backwards = np.empty(2 * remaining, np.int64)
    length = 0
    while best_level >= 0:
        backwards[length] = move_of[best_level, best_at]
        length += 1
        if via_of[best_level, best_at] != STRAIGHT:
            backwards[length] = via_of[best_level, best_at]
            length += 1
        best_at = parent_of[best_level, best_at]
        best_level -= 1
    return backwards[:length][::-1].copy(), best_prize, best_spent, priced


def beam_search(
    mission: Mission,
    settings: BeamSettings,
    *,
    guide: Latest | None = None,
    prefix: tuple[int, ...] = (),
    seed: int = 0,
    stop: Stop | None = None,
) -> tuple[npt.NDArray[np.int64], float, float, int]:
    """Search once; see :func:`beam_kernel` for what it takes and returns.

    The sequence returned includes the prefix, which is a legal one; the search goes on from all
    ways to fly it that are worth having. When ``stop`` has no time left, it is hurried to its end.
    """
    rules = mission.rules
    front = mission.schedules.fronts(prefix)[-1]
    done = np.zeros(rules.service.size, dtype=np.bool_)
    since = 0
    for j in prefix:
        done[j] = not rules.is_station[j]
        since = since + 1 if done[j] else 0
    body = prefix[-1] if prefix else rules.start
    weights = Weights(
        settings.width,
        settings.time_weight / HOUR_S,
        settings.delta_v_weight / 1000.0,
        settings.crowding,
        settings.noise,
        settings.guarded,
        seed,
    )
    with halted_by(stop) as halt:
        found, prize, delta_v, priced = beam_kernel(
            rules, done, (body, since, front.ready, front.left, front.cost),
            no_latest() if guide is None else guide, guide is not None, weights, halt,
        )  # fmt: skip
    return np.concatenate([np.array(prefix, dtype=np.int64), found]), prize, delta_v, priced
