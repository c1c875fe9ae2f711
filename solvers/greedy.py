"""Greedy planners: as published, and with the one guard that it lacks."""

from __future__ import annotations

import math
import time

import numpy as np

from adr_opt.errors import InputError
from adr_opt.kernels import rules as rule_kernels
from adr_opt.kernels.compile import kernel
from adr_opt.kernels.memory import write
from adr_opt.mission import Mission
from adr_opt.planner import Progress
from adr_opt.result import Result, certify
from adr_opt.stop import Stop

THE_INSTANCES_OWN = -1.0
"""Stands for the instance's default time value."""

GUARDED_BETA = 0.0125
"""Default worth of time of the guarded planner: 45 m/s an hour [m/s per s]."""


@kernel
def greedy_sequence(rules, beginning, alpha, beta, guarded):
    """Visit the cheapest legal target again and again; refuel when there is none.

    Parameters
    ----------
    rules : Rules
    beginning : (moves,) int64
        Moves to make before; cut where one is not legal.
    alpha, beta : float
        Cost of a move: α·ΔV [m/s] + β·T [s], T from ready to the beginning of service.
    guarded : bool
        Take a target only if the chaser can still refuel after it, or need not any more. Where
        neither a guarded target nor refuelling is legal, an unguarded target can only add to the
        mission.

    Returns
    -------
    sequence : (moves,) int64
    """
    rules = rule_kernels.lent(rules)
    bodies = rules.service.size
    visited = np.zeros(bodies, dtype=np.bool_)
    ends, lefts = np.empty(beginning.size), np.empty(beginning.size)
    moves, _, state = rule_kernels.replay(
        rules, beginning, rule_kernels.beginning(rules), visited, ends, lefts
    )
    sequence = np.empty(moves + 2 * bodies, dtype=np.int64)
    write(sequence, beginning[:moves])
    while True:
        best, best_cost = -1, math.inf
        safe, safe_cost = -1, math.inf
        for j in range(rules.first_target, bodies):
            if not rule_kernels.may_go(rules, state, visited, j):
                continue
            legal, delta_v, after = rule_kernels.step(rules, state, j)
            if not legal:
                continue
            cost = alpha * delta_v + beta * (after.time - rules.service[j] - state.time)
            if cost < best_cost:
                best, best_cost = j, cost
            if guarded and cost < safe_cost and rule_kernels.has_way_back(rules, after):
                safe, safe_cost = j, cost
        choice = safe if guarded else best
        if choice < 0:
            choice = _cheapest_station(rules, state, alpha, beta)
        if choice < 0:
            choice = best
        if choice < 0:
            return sequence[:moves]
        _, _, state = rule_kernels.step(rules, state, choice)
        visited[choice] = not rules.is_station[choice]
        sequence[moves] = choice
        moves += 1


@kernel
def _cheapest_station(rules, state, alpha, beta):
    """The station where a chaser refuels; −1 if it may refuel at none."""
    cheapest, least = -1, math.inf
    for s in range(rules.stations):
        if s == state.body:
            continue
        legal, delta_v, after = rule_kernels.step(rules, state, s)
        cost = alpha * delta_v + beta * (after.time - state.time)
        if legal and cost < least:
            cheapest, least = s, cost
    return cheapest


def _plan(
    name: str,
    mission: Mission,
    seed: int,
    progress: Progress,
    alpha: float,
    beta: float,
    time_value_m_s_per_h: float,
) -> Result:
    for what, weight in (("alpha", alpha), ("beta", beta)):
        if not math.isfinite(weight) or weight < 0.0:
            raise InputError(f"option {what} = {weight!r} of method {name!r}: must be ≥ 0")
    start = time.perf_counter()
    # What is below 0 stands for the default; what is no number is for the mission to refuse.
    if not time_value_m_s_per_h < 0.0:
        mission = mission.with_time_value(time_value_m_s_per_h)
    rules = mission.rules
    nothing = np.empty(0, dtype=np.int64)
    sequence = greedy_sequence(rules, nothing, alpha, beta, name == "greedy-guarded")
    runtime = time.perf_counter() - start
    progress(float(rule_kernels.collected(rules, sequence)), math.inf)
    return certify(mission, name, sequence, seed=seed, runtime_s=runtime)


def greedy(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    alpha: float = 1.0,
    beta: float = 0.0,
    time_value_m_s_per_h: float = THE_INSTANCES_OWN,
) -> Result:
    """The published greedy: the legal target with the least α·ΔV + β·T; refuel if there is none.

    It has no look-ahead for the way back to the station and strands itself. Deterministic; ends
    by itself within a millisecond and does not ask ``stop``.

    Parameters
    ----------
    alpha, beta : float
        Weights of ΔV [per m/s] and of the time from ready to arrival [per s].
    time_value_m_s_per_h : float
        Of all connections to a target, the one with the least ΔV + value · (arrival − ready) is
        looked at. Below 0: the default of the instance, 75.
    """
    return _plan("greedy", mission, seed, progress, alpha, beta, time_value_m_s_per_h)


def greedy_guarded(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    alpha: float = 1.0,
    beta: float = GUARDED_BETA,
    time_value_m_s_per_h: float = THE_INSTANCES_OWN,
) -> Result:
    """Greedy that takes a target only if the chaser can refuel after it, or need not any more.

    The same rule as :func:`greedy` with one guard and, by default, a price on time, so that a
    cheap transfer is not waited for while a zone is closed; as quick.
    """
    return _plan("greedy-guarded", mission, seed, progress, alpha, beta, time_value_m_s_per_h)
