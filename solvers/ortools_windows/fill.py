"""Fill a plan up: greedy appending at its end, then the insertions that keep the rest legal."""

import math

import numpy as np

from adr_opt.kernels import rules as rule_kernels
from adr_opt.kernels.compile import kernel
from adr_opt.kernels.memory import write

from ..greedy import greedy_sequence


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
            given[j] = True
        best_prize, best_end = 0.0, math.inf
        best = trial
        visited = np.empty(bodies, dtype=np.bool_)
        for place in range(size + 1):
            for j in range(rules.first_target, bodies):
                if given[j] or rules.prize[j] <= 0.0 or rules.prize[j] < best_prize:
                    continue
                write(trial, sequence[:place])
                trial[place] = j
                write(trial[place + 1 :], sequence[place:])
                visited[:] = False
                begin = rule_kernels.beginning(rules)
                if rule_kernels.replay(rules, trial, begin, visited, ends, lefts)[0] <= size:
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
    longer = greedy_sequence(rules, sequence, 1.0, time_value, True)
    size = longer.size
    while size > 0 and rules.is_station[longer[size - 1]] and not rules.returns:
        size -= 1
    return insert(rules, longer[:size])
