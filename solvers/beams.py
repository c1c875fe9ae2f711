"""Beam search over partial plans: the kernel shared by the planners that construct.

Level by level: a state of level n has serviced n targets, and its successors are all targets that
can be reached from it directly or after a refuelling on the way (refuelling is part of the move,
so that a level never mixes states before and after it). The `width` best states of a level
survive; of states with the same targets visited and the same body only those that are not later
*and* poorer in ΔV than another are kept. The states are timed exactly, on the timetable. That the
earlier and richer one is as good is a rule of thumb: a chaser may not let a departure go by, so
now and then the later one meets a cheaper departure, and no width makes the search exhaustive.

States are ordered by a weighted sum, smaller first:

    time_weight · end − delta_v_weight · ΔV left − (upper bound on the objective of any completion)

where the last term needs a completion table (:mod:`solvers.completion`), and stands for what is
known about the targets still to come; without a table it is the prizes collected.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from adr_opt.kernels import rules as rule_kernels
from adr_opt.kernels import timetable
from adr_opt.kernels.compile import kernel
from adr_opt.kernels.constants import STATION
from adr_opt.kernels.memory import write
from adr_opt.mission import Mission
from adr_opt.stop import Stop

from .completion import CompletionTable, completion_value
from .halting import halted_by

CANDIDATES = 8
"""Candidates looked at for each state kept: some are dominated, stranded, or at a full body."""

LEAST_CANDIDATES = 1024
"""Looked at by narrow beams too: at the end of a tank the best of them are all stranded."""

HURRIED = 20
"""States kept on the levels that are left when the time is over: some ten milliseconds."""


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
    unguarded_s : float
        Up to so long before the end of the mission, states whose ΔV does not reach the station
        are kept only where there is room after all other candidates [s]; nobody who is later can
        make use of a refuelling. Narrow beams strand themselves without this guard. It asks for
        the ΔV at the next departure that no keep-out zone blocks: nobody can wait for that one,
        but after one more visit the way costs about as much. A completion table knows better, so
        it needs no guard.
    """

    width: int
    time_weight: float
    delta_v_weight: float
    crowding: float = 1.7
    noise: float = 0.0
    unguarded_s: float = 20e3


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
def _compact(limit, count, wanted, scores, parents, moves, ends, lefts, spent):
    """Keep the candidates up to a score, at most ``wanted`` of those exactly at it; in place."""
    kept = 0
    below = 0
    for c in range(count):
        below += scores[c] < limit
    ties = wanted - below
    for c in range(count):
        if scores[c] > limit:
            continue
        if scores[c] == limit:
            if ties <= 0:
                continue
            ties -= 1
        scores[kept], parents[kept], moves[kept] = scores[c], parents[c], moves[c]
        ends[kept], lefts[kept], spent[kept] = ends[c], lefts[c], spent[c]
        kept += 1
    return kept


@kernel
def beam_kernel(
    rules,
    prefix,
    guide,
    guided,
    width,
    time_weight,
    delta_v_weight,
    crowding,
    noise,
    guard_until,
    seed,
    halt,
):
    """Beam search from the state that a prefix leads to.

    Parameters
    ----------
    rules : Rules
    prefix : (moves,) int64
        A legal beginning, kept as it is.
    guide : CompletionTable
        Not looked at unless ``guided``.
    guided : bool
    width : int
    time_weight, delta_v_weight : float
        [prizes per s], [prizes per m/s].
    crowding : float
        As in :class:`BeamSettings`.
    noise : float
        [prizes].
    guard_until : float
        Absolute time up to which a state is stranded if it cannot afford the way back [s].
    seed : int
    halt : (1,) bool
        Once another thread sets it, only the best states of each level are gone on with, so that
        the search ends soon, with a plan to the end of the mission.

    Returns
    -------
    sequence : (moves,) int64
        The best plan found: most prize, then least ΔV.
    prize, delta_v : float
    states : int
        Number of candidates priced.
    """
    bodies = rules.service.size
    words = (bodies + 63) // 64
    one = np.uint64(1)

    # States of the level, and of the next one.
    body, next_body = np.zeros(width, np.int32), np.zeros(width, np.int32)
    time, next_time = np.zeros(width), np.zeros(width)
    left, next_left = np.zeros(width), np.zeros(width)
    spent, next_spent = np.zeros(width), np.zeros(width)
    prize, next_prize = np.zeros(width), np.zeros(width)
    ahead, next_ahead = np.zeros(width), np.zeros(width)  # Σ π of the targets not visited
    key, next_key = np.zeros(width, np.uint64), np.zeros(width, np.uint64)
    visited = np.zeros((width, words), np.uint64)
    next_visited = np.zeros((width, words), np.uint64)
    keys = np.empty(bodies, np.uint64)
    for j in range(bodies):
        keys[j] = _key_of(j, seed)

    done = np.zeros(bodies, np.bool_)
    ends, lefts = np.empty(prefix.size), np.empty(prefix.size)
    _, prefix_spent = rule_kernels.replay(
        rules, prefix, 0, STATION, 0.0, rules.budget, 0, done, ends, lefts
    )
    time[0], left[0], spent[0] = 0.0, rules.budget, prefix_spent
    if prefix.size > 0:
        body[0], time[0], left[0] = prefix[-1], ends[-1], lefts[-1]
    for j in range(1, bodies):
        if done[j]:
            prize[0] += rules.prize[j]
            visited[0, j >> 6] |= one << np.uint64(j & 63)
            key[0] += keys[j]
        elif guided:
            ahead[0] += guide.multipliers[j]
    remaining = bodies - 1
    for j in range(1, bodies):
        remaining -= done[j]
    # Refuelling is open to the first state only if the prefix has earned it.
    earned = False
    for j in prefix:
        earned = j != STATION

    parent_of = np.zeros((remaining, width), np.int32)
    move_of = np.zeros((remaining, width), np.int32)  # −j: to j by way of the station
    best_prize, best_spent, best_level, best_at = prize[0], spent[0], -1, -1

    wanted = max(CANDIDATES * width, LEAST_CANDIDATES)
    room = max(4 * wanted, 4096)
    scores, parents = np.empty(room), np.empty(room, np.int32)
    moves = np.empty(room, np.int32)
    cand_end, cand_left, cand_spent = np.empty(room), np.empty(room), np.empty(room)
    waiting = np.empty(room, np.int64)
    buckets = 1
    while buckets < 4 * width:
        buckets *= 2
    head, chain = np.empty(buckets, np.int32), np.empty(width, np.int32)
    share = width
    if crowding < remaining:
        share = max(1, math.ceil(crowding * width / remaining))
    held = np.empty(bodies, np.int64)
    room_left = width

    size, level, priced = 1, 0, 0
    while level < remaining and size > 0:
        count, limit = 0, np.inf
        for s in range(size):
            if halt[0] and s >= HURRIED:
                break
            refuels = False
            back, back_end = 0.0, 0.0
            if body[s] != STATION and (level > 0 or earned):
                refuels, back, back_end = rule_kernels.fits(
                    rules, body[s], time[s], left[s], STATION
                )
            for j in range(1, bodies):
                if (visited[s, j >> 6] >> np.uint64(j & 63)) & one:
                    continue
                shade = 0.0
                if noise > 0.0:
                    word = _mix((key[s] + keys[j]) ^ (keys[j] * np.uint64(3)))
                    shade = noise * (np.float64(word >> np.uint64(11)) * 2.0**-53)
                for by_station in range(1 + refuels):
                    if by_station:
                        fits, delta_v, end = rule_kernels.fits(
                            rules, STATION, back_end, rules.budget, j
                        )
                        rest = rules.budget - delta_v
                    else:
                        fits, delta_v, end = rule_kernels.fits(rules, body[s], time[s], left[s], j)
                        rest = left[s] - delta_v
                    if not fits:
                        continue
                    priced += 1
                    if guided:
                        bound = (
                            prize[s]
                            + rules.prize[j]
                            + (ahead[s] - guide.multipliers[j])
                            + completion_value(guide, j, end, rest)
                        )
                    else:
                        bound = prize[s] + rules.prize[j]
                    score = time_weight * end - delta_v_weight * rest - bound + shade
                    if score > limit:
                        continue
                    if count == room:
                        limit = _threshold(scores, count, wanted)
                        count = _compact(
                            limit, count, wanted, scores, parents, moves, cand_end, cand_left,
                            cand_spent,
                        )  # fmt: skip
                        if score > limit:
                            continue
                    scores[count], parents[count] = score, s
                    moves[count] = -j if by_station else j
                    cand_end[count], cand_left[count] = end, rest
                    cand_spent[count] = spent[s] + delta_v + (back if by_station else 0.0)
                    count += 1
        if count > wanted:
            limit = _threshold(scores, count, wanted)
            count = _compact(
                limit, count, wanted, scores, parents, moves, cand_end, cand_left, cand_spent
            )
        order = np.argsort(scores[:count], kind="mergesort")
        head[:] = -1
        held[:] = 0
        size = 0
        stranded = 0
        if halt[0]:
            room_left = min(width, HURRIED)
            share = min(share, max(1, math.ceil(crowding * room_left / remaining)))
        for turn in range(2 * count):
            if size == room_left or turn == count + stranded:
                break
            c = order[turn] if turn < count else waiting[turn - count]
            s = parents[c]
            j = abs(moves[c])
            if held[j] == share:
                continue
            if turn < count and cand_end[c] < guard_until:
                # Asked only here: of all candidates it would take most of the time.
                back = rule_kernels.fits(rules, j, cand_end[c], cand_left[c], STATION)[1]
                if back == np.inf:
                    back = timetable.delta_v_when_open(rules.table, j, STATION, cand_end[c])
                if back > cand_left[c]:
                    waiting[stranded] = c
                    stranded += 1
                    continue
            set_key = key[s] + keys[j]
            slot = np.int64(_mix(set_key ^ keys[j]) & np.uint64(buckets - 1))
            dominated = False
            other = head[slot]
            while other >= 0:
                if (
                    next_key[other] == set_key
                    and next_body[other] == j
                    and next_time[other] <= cand_end[c]
                    and next_left[other] >= cand_left[c]
                ):
                    dominated = True
                    break
                other = chain[other]
            if dominated:
                continue
            held[j] += 1
            next_body[size], next_time[size], next_left[size] = j, cand_end[c], cand_left[c]
            next_spent[size], next_key[size] = cand_spent[c], set_key
            next_prize[size] = prize[s] + rules.prize[j]
            if guided:
                next_ahead[size] = ahead[s] - guide.multipliers[j]
            write(next_visited[size], visited[s])
            next_visited[size, j >> 6] |= one << np.uint64(j & 63)
            chain[size] = head[slot]
            head[slot] = size
            parent_of[level, size], move_of[level, size] = s, moves[c]
            if next_prize[size] > best_prize or (
                next_prize[size] == best_prize and next_spent[size] < best_spent
            ):
                best_prize, best_spent = next_prize[size], next_spent[size]
                best_level, best_at = level, size
            size += 1
        body, next_body = next_body, body
        time, next_time = next_time, time
        left, next_left = next_left, left
        spent, next_spent = next_spent, spent
        prize, next_prize = next_prize, prize
        ahead, next_ahead = next_ahead, ahead
        key, next_key = next_key, key
        visited, next_visited = next_visited, visited
        level += 1

    backwards = np.empty(2 * remaining, np.int64)
    length = 0
    while best_level >= 0:
        move = move_of[best_level, best_at]
        backwards[length] = abs(move)
        length += 1
        if move < 0:
            backwards[length] = STATION
            length += 1
        best_at = parent_of[best_level, best_at]
        best_level -= 1
    sequence = np.empty(prefix.size + length, np.int64)
    write(sequence, prefix)
    for m in range(length):
        sequence[prefix.size + m] = backwards[length - 1 - m]
    return sequence, best_prize, best_spent, priced


def no_guide() -> CompletionTable:
    """A table that is never looked at, for kernels that take one."""
    numbers = np.zeros(1)
    whole = np.zeros(1, dtype=np.int64)
    return CompletionTable(
        np.zeros(1, dtype=np.int32), whole, numbers, whole.reshape(1, 1), 1.0, numbers, numbers,
        1.0, 1, 0, 1, 1.0,
    )  # fmt: skip


def beam_search(
    mission: Mission,
    settings: BeamSettings,
    *,
    guide: CompletionTable | None = None,
    prefix: npt.NDArray[np.int64] | None = None,
    seed: int = 0,
    stop: Stop | None = None,
) -> tuple[npt.NDArray[np.int64], float, float, int]:
    """Search once; see :func:`beam_kernel` for what it takes and returns.

    When ``stop`` has no time left, the search is hurried to its end.
    """
    rules = mission.rules
    with halted_by(stop) as halt:
        return beam_kernel(  # type: ignore[no-any-return]
            rules,
            np.empty(0, dtype=np.int64) if prefix is None else prefix,
            no_guide() if guide is None else guide,
            guide is not None,
            settings.width,
            settings.time_weight / 3600.0,
            settings.delta_v_weight / 1000.0,
            settings.crowding,
            settings.noise,
            -np.inf if guide is not None else rules.duration - settings.unguarded_s,
            seed,
            halt,
        )
