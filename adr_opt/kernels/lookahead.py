"""Where a move leads: greedy chains to the end of the mission, as a part of an observation.

After every legal move, three greedy chasers with different ideas of what ΔV is worth go on to the
end of the mission. Alone, the best of them tells good moves from bad ones; a policy that sees all
three learns when to believe which.
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

CHAIN_M_S_PER_HOUR = (250.0, M_S_PER_HOUR, 900.0)
"""ΔV that the chains take to be worth an hour [m/s]."""

CHAIN_FIELDS = (
    "targets serviced by the move and the chain of 250 m/s per h after it [10]",
    "time left at its end [10 h]",
    "ΔV left at its end [km/s]",
    "targets serviced by the move and the chain of 450 m/s per h after it [10]",
    "time left at its end [10 h]",
    "ΔV left at its end [km/s]",
    "targets serviced by the move and the chain of 900 m/s per h after it [10]",
    "time left at its end [10 h]",
    "ΔV left at its end [km/s]",
    "most targets of the three [10]",
    "that number less the largest of all legal moves",
    "that number and time left / 200,000 s, less the largest of all legal moves",
    "time from now to the third service of the chain of 450 m/s per h [30 h]",
    "ΔV of that chain until then [km/s]",
)
"""What ``lookahead`` has after :data:`adr_opt.kernels.observation.MOVE_FIELDS`; 0 for moves that
are not legal."""

LEAD = 11
"""The one of them that alone makes a good policy: take the move where it is largest."""

UNGUARDED_S = 20e3
"""So long before the end of the mission the chains no longer keep a way to the station."""

SLACK_PER_S = 1.0 / 200e3
"""Worth of time left where two chains service as many targets [targets per s]."""


@kernel
def observe_lookahead(pool, episodes, order, first, last, moves, mission, mask, legal):
    """Observations ``lookahead`` of the episodes ``order[first:last]``.

    As :func:`adr_opt.kernels.observation.observe_transfer`, with :data:`CHAIN_FIELDS` after the
    fields of every legal move.
    """
    observe_transfer(pool, episodes, order, first, last, moves, mission, mask, legal)
    pool, episodes = lent(pool, episodes)
    moves, mask = borrowed(moves), borrowed(mask)
    targets = mask.shape[1] - 1
    begin = moves.shape[2] - len(CHAIN_FIELDS)
    stamp = np.zeros(targets + 1, dtype=np.int64)
    most, slack = np.empty(targets + 1), np.empty(targets + 1)
    for place in range(first, last):
        e = order[place]
        rules = rules_of(pool, episodes, e)
        outlook = outlook_of(pool, episodes.slot[e])
        body, now, left = episodes.body[e], episodes.time[e], episodes.left[e]
        since, visited = episodes.since_refuel[e], episodes.visited[e]
        stamp[:] = 0
        mark = 0
        greatest, most_slack = 0.0, 0.0
        for row in range(targets + 1):
            if not mask[e, row]:
                # They may have been legal when something was written here last.
                for column in range(begin, moves.shape[2]):
                    moves[e, row, column] = 0.0
                continue
            move = STATION if row == targets else row + 1
            most[row], slack[row] = 0.0, 0.0
            for chain in range(3):
                mark += 1
                worth = CHAIN_M_S_PER_HOUR[chain]
                count, third_s, third_v, end, rest = greedy_chain(
                    rules, outlook, body, now, left, since, visited, move, 1.0 / worth,
                    worth == M_S_PER_HOUR, stamp, mark,
                )  # fmt: skip
                column = begin + 3 * chain
                left_s = rules.duration - end
                moves[e, row, column] = clip(count * PER_TEN, 0.0, LIMIT)
                moves[e, row, column + 1] = clip(left_s * PER_HOUR * PER_TEN, 0.0, LIMIT)
                moves[e, row, column + 2] = clip(rest * PER_KM_S, 0.0, LIMIT)
                if worth == M_S_PER_HOUR:
                    third = (third_s - now) * PER_HOUR / 30.0
                    moves[e, row, begin + 12] = clip(third, 0.0, LIMIT)
                    moves[e, row, begin + 13] = clip(third_v * PER_KM_S, 0.0, LIMIT)
                most[row] = max(most[row], count)
                slack[row] = max(slack[row], count + SLACK_PER_S * left_s)
            greatest = max(greatest, most[row])
            most_slack = max(most_slack, slack[row])
        for row in range(targets + 1):
            if mask[e, row]:
                moves[e, row, begin + 9] = clip(most[row] * PER_TEN, 0.0, LIMIT)
                moves[e, row, begin + 10] = clip(most[row] - greatest, -LIMIT, LIMIT)
                moves[e, row, begin + 11] = clip(slack[row] - most_slack, -LIMIT, LIMIT)


@kernel
def greedy_chain(
    rules, outlook, body, time, left, since, visited, move, hours_per_m_s, is_sorted, stamp, mark
):
    """Make a move, and then the cheapest next move again and again, as far as it goes.

    The next move is the cheapest of :attr:`adr_opt.kernels.outlook.Outlook.ahead` that is open,
    fits, and keeps a way back to the station; refuelling where there is none. Costs are exact.

    Parameters
    ----------
    body, time, left, since, visited
        The state of the chaser, see :mod:`adr_opt.kernels.rules`.
    move : int
        The first move, a legal one.
    hours_per_m_s : float
        Worth of ΔV [h per m/s].
    is_sorted : bool
        The outlook's order is this chain's, so that its first target is the cheapest.
    stamp : (bodies,) int64
        Scratch; ``mark`` must be larger than every number in it.
    mark : int

    Returns
    -------
    count : int
        Targets serviced.
    third_s, third_v : float
        When the third of them is serviced [s] and the ΔV until then [m/s], a refuelling next
        after it included; at the end of the chain if it has fewer.
    end, left : float
        End of the last service [s] and ΔV left then [m/s].
    """
    spacing = rules.table.spacing
    guarded_until = rules.duration - UNGUARDED_S
    count, spent, third_s, third_v = 0, 0.0, 0.0, 0.0
    choice = move
    _, choice_v, choice_end = rule_kernels.fits(rules, body, time, left, choice)
    while choice >= 0:
        left = rule_kernels.left_after(rules, left, choice_v, choice)
        spent += choice_v
        body, time = choice, choice_end
        if choice == STATION:
            since = 0
        else:
            since += 1
            count += 1
            stamp[choice] = mark
        if count <= 3:
            third_s, third_v = time, spent
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
                choice, least, choice_v, choice_end = k, cost, delta_v, end
                if is_sorted:
                    break
        if choice < 0 and since > 0 and body != STATION:
            fits, choice_v, choice_end = rule_kernels.fits(rules, body, time, left, STATION)
            if fits:
                choice = STATION
    return count, third_s, third_v, time, left
