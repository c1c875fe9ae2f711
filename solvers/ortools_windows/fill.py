"""Fill a plan up: greedy appending at its end, then the insertions that keep the rest legal."""

import math

import numpy as np

from adr_opt.kernels import rules as rule_kernels
from adr_opt.kernels.compile import kernel
from adr_opt.kernels.constants import STATION
from adr_opt.kernels.memory import write


@kernel
def append(rules, sequence, time_value):
    """Go on greedily from the end of a legal sequence.

    The move is to the legal target with the least ΔV + time_value · duration from which the
    station is still within the ΔV left; if there is none, to the station; if that is not legal
    either, to the cheapest legal target, which can only add to the mission.

    Parameters
    ----------
    sequence : (moves,) int64
        Legal as far as it goes; cut where it is not.
    time_value : float
        [m/s per s].

    Returns
    -------
    (moves,) int64
        Last moves to the station are left out: they earn nothing.
    """
    bodies = rules.service.size
    visited = np.zeros(bodies, dtype=np.bool_)
    ends, lefts = np.empty(sequence.size), np.empty(sequence.size)
    made, _ = rule_kernels.replay(
        rules, sequence, 0, STATION, 0.0, rules.budget, 0, visited, ends, lefts
    )
    longer = np.empty(made + 2 * bodies, dtype=np.int64)
    write(longer, sequence[:made])
    body, now, left, since_refuel = STATION, 0.0, rules.budget, 0
    if made > 0:
        body, now, left = sequence[made - 1], ends[made - 1], lefts[made - 1]
        # Only whether it is zero matters to the rules.
        since_refuel = int(body != STATION)
    while True:
        choice, least = -1, math.inf
        last, last_least = -1, math.inf
        for j in range(1, bodies):
            if not rule_kernels.may_go(body, since_refuel, visited, j):
                continue
            legal, delta_v, end = rule_kernels.fits(rules, body, now, left, j)
            if not legal:
                continue
            cost = delta_v + time_value * (end - now)
            if cost < last_least:
                last, last_least = j, cost
            if cost < least:
                _, back, _ = rule_kernels.fits(rules, j, end, left - delta_v, STATION)
                if back <= left - delta_v:
                    choice, least = j, cost
        if choice < 0 and rule_kernels.may_go(body, since_refuel, visited, STATION):
            if rule_kernels.fits(rules, body, now, left, STATION)[0]:
                choice = STATION
        if choice < 0:
            choice = last
        if choice < 0:
            break
        _, delta_v, now = rule_kernels.fits(rules, body, now, left, choice)
        left = rule_kernels.left_after(rules, left, delta_v, choice)
        since_refuel = 0 if choice == STATION else since_refuel + 1
        visited[choice] = choice != STATION
        body = choice
        longer[made] = choice
        made += 1
    while made > 0 and longer[made - 1] == STATION:
        made -= 1
    return longer[:made]


@kernel
def insert(rules, sequence):
    """Insert unvisited targets one by one while all other moves stay legal.

    Of the largest prize that fits, the place with the earliest end of the plan is taken.

    Parameters
    ----------
    sequence : (moves,) int64
        Legal.

    Returns
    -------
    (moves,) int64
    """
    bodies = rules.service.size
    while True:
        size = sequence.size
        ends, lefts = np.empty(size + 1), np.empty(size + 1)
        trial = np.empty(size + 1, dtype=np.int64)
        given = np.zeros(bodies, dtype=np.bool_)
        for j in sequence:
            given[j] = j != STATION
        best_prize, best_end = 0.0, math.inf
        best = trial
        visited = np.empty(bodies, dtype=np.bool_)
        for place in range(size + 1):
            for j in range(1, bodies):
                if given[j] or rules.prize[j] <= 0.0 or rules.prize[j] < best_prize:
                    continue
                write(trial, sequence[:place])
                trial[place] = j
                write(trial[place + 1 :], sequence[place:])
                visited[:] = False
                made, _ = rule_kernels.replay(
                    rules, trial, 0, STATION, 0.0, rules.budget, 0, visited, ends, lefts
                )
                if made < size + 1:
                    continue
                if rules.prize[j] > best_prize or ends[size] < best_end:
                    best_prize, best_end = rules.prize[j], ends[size]
                    best = trial.copy()
        if best_end == math.inf:
            return sequence
        sequence = best


def filled(rules, sequence, time_value):
    """A legal plan from a sequence: cut where it breaks a rule, then appended to and inserted into.

    Parameters
    ----------
    rules : Rules
    sequence : (moves,) int64
    time_value : float
        [m/s per s].

    Returns
    -------
    (moves,) int64
    """
    return insert(rules, append(rules, sequence, time_value))
