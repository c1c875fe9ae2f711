"""Filling of a plan by insertions that keep the rest legal."""

import math

import numpy as np

from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.core.memory import borrowed
from adr_opt.kernels.rules import rules as rule_kernels

from .network import state_at


@kernel
def best_insertion(rules, sequence, bodies, times, lefts, count):
    """The best target to insert such that all later moves stay legal.

    Of the largest prize that fits, the place with the earliest end of the plan.

    Parameters
    ----------
    sequence : (moves,) int64
    bodies, times, lefts : (moves + 1,)
        Where the chaser is before each move, the end included; since when [s]; ΔV left [m/s].
    count : int
        Targets of the sequence.

    Returns
    -------
    target, place : int
        Target −1 for none.
    """
    rules = borrowed(rules)
    given = np.zeros(rules.service.size, dtype=np.bool_)
    for j in sequence:
        given[j] = True
    best, best_place, best_prize, best_end = -1, -1, 0.0, math.inf
    if count >= rules.limits.targets:
        return best, best_place
    for place in range(sequence.size + 1):
        for new in range(rules.first_target, given.size):
            prize = rules.prize[new]
            if given[new] or prize <= 0.0 or prize < best_prize:
                continue
            state = state_at(rules, bodies[place], times[place], lefts[place])
            legal, _, state = rule_kernels.step(rules, state, new)
            at = place
            while legal and at < sequence.size:
                legal, _, state = rule_kernels.step(rules, state, sequence[at])
                at += 1
            if legal and (prize > best_prize or state.resources.time < best_end):
                best, best_place, best_prize, best_end = new, place, prize, state.resources.time
    return best, best_place
