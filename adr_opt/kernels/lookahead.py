"""Where a move leads: greedy chains to the end of the mission, as a part of an observation.

After each of the cheapest legal moves, greedy chasers with different ideas of what ΔV is worth, and
of whether the move after the next matters, go on to the end of the mission. Their costs are exact,
so the best of them is a plan that can be flown: its number of targets is a promise. A policy that
sees all of them learns when to believe which.
"""

import math

import numpy as np

from . import rules as rule_kernels
from .compile import kernel
from .constants import STATION
from .episodes import clip, lent, outlook_of, rules_of
from .memory import borrowed
from .observation import LIMIT, PER_HOUR, PER_KM_S, PER_TEN, observe_transfer, way_back
from .outlook import AHEAD, M_S_PER_HOUR, NOBODY

CHAINS = tuple((worth, share) for share in (0.0, 0.6) for worth in (200.0, 350.0, 600.0, 1200.0))
"""The chains: ΔV taken to be worth an hour [m/s], and how much of the cost of the cheapest move
after it counts as a move's own."""

FOLLOWED = 8
"""So many targets are followed by chains, those whose moves are cheapest now, and the station."""

CHAIN_FIELDS = (
    *(
        text
        for worth, share in CHAINS
        for text in (
            f"targets by the move and the chain of {worth:.0f} m/s per h, foresight {share:g} [10]",
            "time left at its end [10 h]",
        )
    ),
    "followed by chains",
    "most targets of the chains [10]",
    "that number less the largest of all moves followed",
    "that number and time left / 200,000 s, less the largest of all moves followed",
    "ΔV left at the end of the chain where they are largest [km/s]",
    "share of the chains that service as many targets as the best of all moves",
)
"""What ``lookahead`` has after :data:`adr_opt.kernels.observation.MOVE_FIELDS`; 0 for moves that
are not followed, except for the two that compare: they are −LIMIT where the move is legal."""

BEHIND = 2 * len(CHAINS)
PROMISE, LEAD = BEHIND + 1, BEHIND + 3
"""Most targets, and the one that alone makes a good policy: take the move where it is largest."""

UNGUARDED_S = 20e3
"""So long before the end of the mission the chains no longer keep a way to the station."""

SLACK_PER_S = 1.0 / 200e3
"""Worth of time left where two chains service as many targets [targets per s]."""

NOTHING_HOURS = 12.0
"""What no move at all costs as the move after the next [h]."""

_WORTH = np.array([worth for worth, _ in CHAINS])
_FORESIGHT = np.array([share for _, share in CHAINS])


@kernel
def observe_lookahead(pool, episodes, order, first, last, moves, mission, mask, legal):
    """Observations ``lookahead`` of the episodes ``order[first:last]``.

    As :func:`adr_opt.kernels.observation.observe_transfer`, with :data:`CHAIN_FIELDS` after the
    fields of every move.
    """
    observe_transfer(pool, episodes, order, first, last, moves, mission, mask, legal)
    pool, episodes = lent(pool, episodes)
    moves, mask = borrowed(moves), borrowed(mask)
    targets = mask.shape[1] - 1
    begin = moves.shape[2] - len(CHAIN_FIELDS)
    chains = len(_WORTH)
    stamp = np.zeros(targets + 1, dtype=np.int64)
    rows = np.empty(FOLLOWED + 1, dtype=np.int64)
    most, slack = np.empty(FOLLOWED + 1), np.empty(FOLLOWED + 1)
    for place in range(first, last):
        e = order[place]
        rules = rules_of(pool, episodes, e)
        outlook = outlook_of(pool, episodes.slot[e])
        body, now, left = episodes.body[e], episodes.time[e], episodes.left[e]
        since, visited = episodes.since_refuel[e], episodes.visited[e]
        for row in range(targets + 1):
            # They may have been followed when something was written here last.
            moves[e, row, begin:] = 0.0
            if mask[e, row]:
                moves[e, row, begin + BEHIND + 2 : begin + BEHIND + 4] = -LIMIT
        stamp[:] = 0
        mark = 0
        greatest, most_slack = 0.0, 0.0
        count = cheapest_moves(rules, body, now, left, mask[e], rows)
        for place in range(count):
            row = rows[place]
            move = STATION if row == targets else row + 1
            seen = moves[e, row, begin:]
            most[place], slack[place] = 0.0, -1.0
            for chain in range(chains):
                mark += 1
                serviced, end, rest = greedy_chain(
                    rules, outlook, body, now, left, since, visited, move,
                    1.0 / _WORTH[chain], _FORESIGHT[chain], stamp, mark,
                )  # fmt: skip
                left_s = rules.duration - end
                seen[2 * chain] = clip(serviced * PER_TEN, 0.0, LIMIT)
                seen[2 * chain + 1] = clip(left_s * PER_HOUR * PER_TEN, 0.0, LIMIT)
                most[place] = max(most[place], serviced)
                if serviced + SLACK_PER_S * left_s > slack[place]:
                    slack[place] = serviced + SLACK_PER_S * left_s
                    seen[BEHIND + 4] = clip(rest * PER_KM_S, 0.0, LIMIT)
            greatest = max(greatest, most[place])
            most_slack = max(most_slack, slack[place])
        for place in range(count):
            seen = moves[e, rows[place], begin:]
            seen[BEHIND] = 1.0
            seen[BEHIND + 1] = clip(most[place] * PER_TEN, 0.0, LIMIT)
            seen[BEHIND + 2] = clip(most[place] - greatest, -LIMIT, LIMIT)
            seen[BEHIND + 3] = clip(slack[place] - most_slack, -LIMIT, LIMIT)
            equal = 0
            for chain in range(chains):
                if seen[2 * chain] >= clip(greatest * PER_TEN, 0.0, LIMIT) - 0.05:
                    equal += 1
            seen[BEHIND + 5] = equal / chains


@kernel
def cheapest_moves(rules, body, time, left, mask, rows):
    """The legal moves that are followed: the cheapest targets by hours + ΔV / (450 m/s).

    Parameters
    ----------
    body, time, left
        The state of the chaser, see :mod:`adr_opt.kernels.rules`.
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
        _, delta_v, end = rule_kernels.fits(rules, body, time, left, row + 1)
        cost = (end - time) * PER_HOUR + delta_v / M_S_PER_HOUR
        if count == FOLLOWED and cost >= costs[count - 1]:
            continue
        place = min(count, FOLLOWED - 1)
        while place > 0 and costs[place - 1] > cost:
            costs[place], rows[place] = costs[place - 1], rows[place - 1]
            place -= 1
        costs[place], rows[place] = cost, row
        count = min(count + 1, FOLLOWED)
    if mask[targets]:
        rows[count] = targets
        count += 1
    return count


@kernel
def greedy_chain(
    rules, outlook, body, time, left, since, visited, move, hours_per_m_s, foresight, stamp, mark
):
    """Make a move, and then the cheapest next move again and again, as far as it goes.

    The next move is the cheapest of :attr:`adr_opt.kernels.outlook.Outlook.ahead` that is open,
    fits, and keeps ΔV for a way back to the station (at the next departure that no keep-out zone
    blocks); refuelling where there is none. Costs are exact.

    Parameters
    ----------
    body, time, left, since, visited
        The state of the chaser, see :mod:`adr_opt.kernels.rules`.
    move : int
        The first move, a legal one.
    hours_per_m_s : float
        Worth of ΔV [h per m/s].
    foresight : float
        Share of the cost of the cheapest move after it that counts as a move's own.
    stamp : (bodies,) int64
        Scratch; ``mark`` must be larger than every number in it.
    mark : int

    Returns
    -------
    count : int
        Targets serviced.
    end, left : float
        End of the last service [s] and ΔV left then [m/s].
    """
    spacing = rules.table.spacing
    guarded_until = rules.duration - UNGUARDED_S
    count = 0
    choice = move
    _, choice_v, choice_end = rule_kernels.fits(rules, body, time, left, choice)
    while choice >= 0:
        left = rule_kernels.left_after(rules, left, choice_v, choice)
        body, time = choice, choice_end
        if choice == STATION:
            since = 0
        else:
            since += 1
            count += 1
            stamp[choice] = mark
        choice = -1
        least = math.inf
        index = math.ceil(time / spacing[body])
        if index < outlook.ahead.shape[1]:
            for place in range(AHEAD):
                k = np.int64(outlook.ahead[body, index, 3 * place])
                if k == NOBODY:
                    break
                if visited[k] or stamp[k] == mark:
                    continue
                legal, delta_v, end = rule_kernels.fits(rules, body, time, left, k)
                if not legal:
                    continue
                cost = (end - time) * PER_HOUR + delta_v * hours_per_m_s
                if cost >= least:
                    continue
                if end < guarded_until:
                    if way_back(outlook, spacing[k], k, end)[0] > left - delta_v:
                        continue
                if foresight > 0.0:
                    # In place: as a function of its own this took half of all the time.
                    after = NOTHING_HOURS
                    rest, begin = left - delta_v, math.ceil(end / spacing[k])
                    if begin < outlook.ahead.shape[1]:
                        for second in range(AHEAD):
                            j = np.int64(outlook.ahead[k, begin, 3 * second])
                            if j == NOBODY:
                                break
                            if visited[j] or stamp[j] == mark or j == k:
                                continue
                            legal, delta_v_j, end_j = rule_kernels.fits(rules, k, end, rest, j)
                            if legal:
                                after = (end_j - end) * PER_HOUR + delta_v_j * hours_per_m_s
                                break
                    cost += foresight * after
                    if cost >= least:
                        continue
                choice, least, choice_v, choice_end = k, cost, delta_v, end
        if choice < 0 and since > 0 and body != STATION:
            fits, choice_v, choice_end = rule_kernels.fits(rules, body, time, left, STATION)
            if fits:
                choice = STATION
    return count, time, left
