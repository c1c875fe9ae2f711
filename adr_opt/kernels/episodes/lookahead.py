"""Lookahead features of moves: greedy chains to the end of the mission.

After each of the cheapest legal moves, greedy chasers with different ideas of what ΔV is worth, and
of whether the move after the next matters, go on to the end of the mission. Their costs are exact,
so the best of them is a plan that can be flown: what it collects is a promise. A policy that sees
all of them learns when to believe which.

``lookahead`` counts targets and takes them by their cost alone; ``lookahead-prizes`` counts prizes,
and a target of half the prize has to be had at half the cost. Where prizes are equal, they do and
say the same. What is promised is in prizes in either case.
"""

import math
from typing import NamedTuple

import numpy as np

from ..core.compile import inlined, kernel
from ..core.memory import borrowed
from ..rules import rules as rule_kernels
from ..tables.stacked_timetables import lookup_in_column
from ..tables.timetable import steps_begun
from .episodes import clip, outlook_of, rules_of, state_of
from .observation import LIMIT, PER_HOUR, PER_KM_S, PER_TEN, observe_transfer
from .outlook import AHEAD, HOME, M_S_PER_HOUR, NOBODY, insert

CHAINS = tuple((worth, share) for share in (0.0, 0.6) for worth in (200.0, 350.0, 600.0, 1200.0))
"""The chains: ΔV equivalent to an hour [m/s], and the share of the cheapest next move's cost that
is charged to a move."""

FOLLOWED = 8
"""Number of targets followed by chains, those with the cheapest moves now; the station is extra."""


def _chain_fields(counted: str, unit: str, collect: str) -> tuple[str, ...]:
    """Names of the features that chains give a move, by what they count."""
    return (
        *(
            text
            for worth, share in CHAINS
            for text in (
                f"{counted} by the move and the chain of {worth:.0f} m/s per h, "
                f"foresight {share:g} [{unit}]",
                "time left at its end [10 h]",
            )
        ),
        "followed by chains",
        f"most {counted} of the chains [{unit}]",
        "that number less the largest of all moves followed",
        "that number and time left / 200,000 s, less the largest of all moves followed",
        "ΔV left at the end of the chain where they are largest [km/s]",
        f"share of the chains that {collect} as the best of all moves",
    )


CHAIN_FIELDS = _chain_fields("targets", "10", "service as many targets")
"""Fields of ``lookahead`` after :data:`.observation.MOVE_FIELDS`; 0 for moves that are not
followed, except the two comparisons, which are −LIMIT for a legal move."""

CHAIN_PRIZE_FIELDS = _chain_fields("prizes", "10 mean prizes", "collect as much")
"""The same fields of ``lookahead-prizes``, where they come last."""

BEHIND = 2 * len(CHAINS)
PROMISE, LEAD = BEHIND + 1, BEHIND + 3
"""Columns of most targets and of the lead, which alone makes a good policy: take the largest."""

UNGUARDED_S = 20e3
"""Time before the end of the mission from which chains no longer keep a way to the station [s]."""

SLACK_PER_S = 1.0 / 200e3
"""Value of remaining time, to choose among chains with equal targets [targets per s]."""

EQUAL_TARGETS, EQUAL_PRIZES = 0.5, 1e-6
"""Differences, in targets and in mean prizes, within which chains count as equal."""

NOTHING_HOURS = 12.0
"""Cost charged for the next move if there is none [h]."""


class Gains(NamedTuple):
    """What each target counts for.

    Attributes
    ----------
    gain : (bodies,) float64
    per_gain : (bodies,) float64
        Factor of the cost of each: 1 over its gain.
    """

    gain: np.ndarray
    per_gain: np.ndarray


class ChainRule(NamedTuple):
    """How a chain chooses its moves.

    Attributes
    ----------
    hours_per_m_s : float
        Worth of ΔV [h per m/s].
    foresight : float
        Share of the cost of the cheapest move after it that counts as a move's own.
    """

    hours_per_m_s: float
    foresight: float


class Stamps(NamedTuple):
    """Targets visited by a chain.

    Attributes
    ----------
    stamp : (bodies,) int64
        Scratch.
    mark : int
        What stands there for them: larger than every other number in it.
    """

    stamp: np.ndarray
    mark: int


class Promises(NamedTuple):
    """Outcomes of the chains after each move of many episodes; for planners, not observed.

    Attributes
    ----------
    prize : (episodes, actions) float64
        Prize of the whole mission by the best chain [mean prizes of the field]; −inf for moves that
        are not followed.
    time_left : (episodes, actions) float64
        Most time left at the end of a chain that collects so much [s].
    lead : (episodes, actions) float64
        The most that a chain collects, in prizes and time left / 200,000 s; −inf as ``prize``.
    """

    prize: np.ndarray
    time_left: np.ndarray
    lead: np.ndarray


_WORTH = np.array([worth for worth, _ in CHAINS])
_FORESIGHT = np.array([share for _, share in CHAINS])


@kernel
def observe_lookahead(pool, episodes, order, first, last, into, prized, promises):
    """Observations ``lookahead`` of the episodes ``order[first:last]``.

    As :func:`.observation.observe_transfer`, with :data:`CHAIN_FIELDS` after the
    fields of every move; those of ``lookahead-prizes`` if ``prized``.

    Parameters
    ----------
    promises : Promises
        Written.
    """
    observe_transfer(pool, episodes, order, first, last, into, prized)
    pool, episodes = borrowed(pool), borrowed(episodes)
    moves, mask = borrowed(into.moves), borrowed(into.mask)
    promises = Promises(
        borrowed(promises.prize), borrowed(promises.time_left), borrowed(promises.lead)
    )
    targets = mask.shape[1] - 1
    begin = moves.shape[2] - len(CHAIN_FIELDS)
    chains = len(_WORTH)
    stamp = np.zeros(targets + 1, dtype=np.int64)
    rows = np.empty(FOLLOWED + 1, dtype=np.int64)
    most, slack = np.empty(FOLLOWED + 1), np.empty(FOLLOWED + 1)
    gain, per_gain = np.ones(targets + 1), np.ones(targets + 1)
    gains = Gains(gain, per_gain)
    as_good = EQUAL_PRIZES if prized else EQUAL_TARGETS
    for place in range(first, last):
        e = order[place]
        rules = rules_of(pool, episodes, e)
        outlook = outlook_of(pool, episodes.slot[e])
        state, visited = state_of(episodes, e), episodes.visited[e]
        if prized:
            for j in range(rules.prize.size):
                gain[j], per_gain[j] = rules.prize[j], 1.0 / rules.prize[j]
        for row in range(targets + 1):
            # They may have been followed when something was written here last.
            for column in range(begin, moves.shape[2]):
                moves[e, row, column] = 0.0
            promises.prize[e, row], promises.lead[e, row] = -math.inf, -math.inf
            promises.time_left[e, row] = 0.0
            if mask[e, row]:
                moves[e, row, begin + BEHIND + 2] = -LIMIT
                moves[e, row, begin + LEAD] = -LIMIT
            stamp[row] = 0
        mark = 0
        greatest, most_slack = 0.0, 0.0
        count = cheapest_moves(rules, state, per_gain, mask[e], rows)
        for place in range(count):
            row = rows[place]
            move = HOME if row == targets else row + 1
            seen = moves[e, row, begin:]
            most[place], slack[place] = 0.0, -1.0
            promised, time_left, lead = -1.0, 0.0, -1.0
            for chain in range(chains):
                # Larger than every number before, so that the stamps of earlier chains need no
                # clearing.
                mark += 1
                worth, collected, end, rest = greedy_chain(
                    rules,
                    outlook,
                    state,
                    visited,
                    move,
                    gains,
                    ChainRule(1.0 / _WORTH[chain], _FORESIGHT[chain]),
                    Stamps(stamp, mark),
                )
                left_s = rules.duration - end
                seen[2 * chain] = clip(worth * PER_TEN, 0.0, LIMIT)
                seen[2 * chain + 1] = clip(left_s * PER_HOUR * PER_TEN, 0.0, LIMIT)
                most[place] = max(most[place], worth)
                if worth + SLACK_PER_S * left_s > slack[place]:
                    slack[place] = worth + SLACK_PER_S * left_s
                    seen[BEHIND + 4] = clip(rest * PER_KM_S, 0.0, LIMIT)
                lead = max(lead, collected + SLACK_PER_S * left_s)
                if collected > promised + EQUAL_PRIZES:
                    promised, time_left = collected, left_s
                elif collected >= promised - EQUAL_PRIZES:
                    time_left = max(time_left, left_s)
            promises.prize[e, row] = episodes.collected[e] + promised
            promises.time_left[e, row], promises.lead[e, row] = time_left, lead
            greatest = max(greatest, most[place])
            most_slack = max(most_slack, slack[place])
        # Comparisons are with the best of all moves, which is known only now.
        for place in range(count):
            seen = moves[e, rows[place], begin:]
            seen[BEHIND] = 1.0
            seen[PROMISE] = clip(most[place] * PER_TEN, 0.0, LIMIT)
            seen[BEHIND + 2] = clip(most[place] - greatest, -LIMIT, LIMIT)
            seen[LEAD] = clip(slack[place] - most_slack, -LIMIT, LIMIT)
            equal = 0
            for chain in range(chains):
                if seen[2 * chain] >= clip(greatest * PER_TEN, 0.0, LIMIT) - as_good * PER_TEN:
                    equal += 1
            seen[BEHIND + 5] = equal / chains


@kernel
def cheapest_moves(rules, state, per_gain, mask, rows):
    """The legal moves that chains follow: the cheapest targets by hours + ΔV / (450 m/s).

    Parameters
    ----------
    rules : Rules
    state : State
    per_gain : (bodies,) float64
        Factor of the cost of each target.
    mask : (actions,) bool
        Legal actions, the station last.
    rows : (FOLLOWED + 1,) int64
        Written: their actions.

    Returns
    -------
    count : int
    """
    targets = mask.shape[0] - 1
    costs = np.empty(FOLLOWED)
    count = 0
    for row in range(targets):
        if not mask[row]:
            continue
        _, delta_v, after = rule_kernels.step(rules, state, row + 1)
        taken = after.resources.time - state.resources.time
        cost = (taken * PER_HOUR + delta_v / M_S_PER_HOUR) * per_gain[row + 1]
        count = insert(cost, row, costs, rows, count)
    if mask[targets]:
        rows[count] = targets
        count += 1
    return count


@inlined
def greedy_chain(rules, outlook, state, visited, move, gains, choosing, stamps):
    """Make a move, then the cheapest next move repeatedly until none is left.

    Inlined although it is long: of rules that come as an argument every step counts references,
    which took five sixths of the time.

    The next move is the cheapest of :attr:`.outlook.Outlook.ahead` that is open,
    legal, and keeps ΔV for a way back to the station; refuelling where there is none. Costs are
    exact.

    Parameters
    ----------
    state : State
    visited : (bodies,) bool
    move : int
        The first move, a legal one.
    gains : Gains
    choosing : ChainRule
    stamps : Stamps

    Returns
    -------
    worth, collected : float
        Gains and prizes of the targets serviced.
    end, left : float
        End of the last service [s] and ΔV left then [m/s].
    """
    table, home = rules.table, outlook.home
    gain, per_gain = gains
    hours_per_m_s, foresight = choosing
    stamp, mark = stamps
    guarded_until = rules.duration - UNGUARDED_S
    worth, collected = 0.0, 0.0
    choice = move
    _, _, chosen = rule_kernels.step(rules, state, choice)
    # This ends: each move services a target that is new to the chain, or goes to the station, and
    # the station is gone to from targets only.
    while choice >= 0:
        state = chosen
        body, time = choice, state.resources.time
        if body != HOME:
            worth += gain[body]
            collected += rules.prize[body]
            stamp[body] = mark
        choice = -1
        least = math.inf
        index = steps_begun(table, body, time)
        if index < outlook.ahead.shape[1]:
            for place in range(AHEAD):
                k = np.int64(outlook.ahead[body, index, 3 * place])
                if k == NOBODY:
                    break
                if visited[k] or stamp[k] == mark:
                    continue
                legal, delta_v, after = rule_kernels.step(rules, state, k)
                if not legal:
                    continue
                ready, rest = after.resources.time, after.resources.left
                cost = ((ready - time) * PER_HOUR + delta_v * hours_per_m_s) * per_gain[k]
                if cost >= least:
                    continue
                if ready < guarded_until:
                    if lookup_in_column(home, table, k, ready)[0] > rest:
                        continue
                # What the move after it adds is positive, so that what is too dear without it stays
                # so.
                if foresight > 0.0:
                    # In place: as a function of its own this took half of all the time.
                    next_cost = NOTHING_HOURS
                    row = steps_begun(table, k, ready)
                    if row < outlook.ahead.shape[1]:
                        for second in range(AHEAD):
                            j = np.int64(outlook.ahead[k, row, 3 * second])
                            if j == NOBODY:
                                break
                            if visited[j] or stamp[j] == mark or j == k:
                                continue
                            legal, next_v, then = rule_kernels.step(rules, after, j)
                            if legal:
                                next_h = (then.resources.time - ready) * PER_HOUR
                                next_cost = (next_h + next_v * hours_per_m_s) * per_gain[j]
                                break
                    cost += foresight * next_cost
                    if cost >= least:
                        continue
                choice, least, chosen = k, cost, after
        if choice < 0 and body != HOME:
            legal, _, after = rule_kernels.step(rules, state, HOME)
            if legal:
                choice, chosen = HOME, after
    return worth, collected, state.resources.time, state.resources.left
