"""Greedy planners: as published, and with the one guard that it lacks."""

from __future__ import annotations

import math
import time

import numpy as np

from adr_opt.errors import InputError
from adr_opt.kernels import rules as rule_kernels
from adr_opt.kernels.compile import kernel
from adr_opt.kernels.constants import STATION
from adr_opt.mission import Mission
from adr_opt.planner import Progress
from adr_opt.result import Result, certify
from adr_opt.stop import Stop


@kernel
def greedy_sequence(rules, alpha, beta, guarded):
    """Visit the cheapest legal target again and again; refuel when there is none.

    Parameters
    ----------
    rules : Rules
    alpha, beta : float
        Cost of a move: α·ΔV [m/s] + β·T [s], T from ready to arrival.
    guarded : bool
        Take a target only if the ΔV left there still reaches the station. The deadline is no part
        of the guard: there is no duty to return, and near the end nobody can. Where neither a
        guarded target nor refuelling is legal, an unguarded target can only add to the mission.

    Returns
    -------
    sequence : (moves,) int64
    """
    bodies = rules.service.size
    visited = np.zeros(bodies, dtype=np.bool_)
    sequence = np.empty(2 * bodies, dtype=np.int64)
    moves, since_refuel = 0, 0
    body, now, left = STATION, 0.0, rules.budget
    while True:
        best, best_cost = -1, math.inf
        safe, safe_cost = -1, math.inf
        for j in range(1, bodies):
            if not rule_kernels.may_go(body, since_refuel, visited, j):
                continue
            legal, delta_v, end = rule_kernels.fits(rules, body, now, left, j)
            if not legal:
                continue
            cost = alpha * delta_v + beta * (end - rules.service[j] - now)
            if cost < best_cost:
                best, best_cost = j, cost
            if guarded and cost < safe_cost:
                _, back, _ = rule_kernels.fits(rules, j, end, left - delta_v, STATION)
                if back <= left - delta_v:
                    safe, safe_cost = j, cost
        choice = safe if guarded else best
        if choice < 0 and rule_kernels.may_go(body, since_refuel, visited, STATION):
            if rule_kernels.fits(rules, body, now, left, STATION)[0]:
                choice = STATION
        if choice < 0:
            choice = best
        if choice < 0:
            if moves > 0 and body == STATION:
                moves -= 1  # a refuelling that nothing follows
            return sequence[:moves]
        _, delta_v, now = rule_kernels.fits(rules, body, now, left, choice)
        left = rule_kernels.left_after(rules, left, delta_v, choice)
        since_refuel = 0 if choice == STATION else since_refuel + 1
        visited[choice] = choice != STATION
        body = choice
        sequence[moves] = choice
        moves += 1


def _plan(
    name: str, mission: Mission, seed: int, progress: Progress, alpha: float, beta: float
) -> Result:
    for what, weight in (("alpha", alpha), ("beta", beta)):
        if not math.isfinite(weight) or weight < 0.0:
            raise InputError(f"option {what} = {weight!r} of method {name!r}: must be ≥ 0")
    rules = mission.rules
    start = time.perf_counter()
    sequence = greedy_sequence(rules, alpha, beta, name == "greedy-guarded")
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
) -> Result:
    """The published greedy: the legal target with the least α·ΔV + β·T; refuel if there is none.

    It has no look-ahead for the way back to the station and strands itself. Deterministic; ends
    by itself within a millisecond and does not ask ``stop``.

    Parameters
    ----------
    alpha, beta : float
        Weights of ΔV [per m/s] and of the time from ready to arrival [per s].
    """
    return _plan("greedy", mission, seed, progress, alpha, beta)


def greedy_guarded(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    alpha: float = 1.0,
    beta: float = 0.0,
) -> Result:
    """Greedy that takes a target only if the station can still be reached from it.

    The same rule and options as :func:`greedy` with one guard; as quick.
    """
    return _plan("greedy-guarded", mission, seed, progress, alpha, beta)
