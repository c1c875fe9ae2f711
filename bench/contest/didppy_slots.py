"""DIDPPy (CABS) on the real problem in slots of time.

The state is body, slot, ΔV left and the targets left; arrivals are rounded up to a slot and ΔV up
to 1 m/s. A chaser that is free a little before its slot may meet an earlier departure event than
the model's, so even this plan may change when timed exactly. Its bound holds for the rounded
model, not for the mission.
"""

from __future__ import annotations

import math
import time
from importlib.metadata import version
from typing import Any

import numpy as np

import adr_opt
from adr_opt.common.constants import STATION
from adr_opt.common.errors import InputError
from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.kernels.tables.timetable import shortest_spacing

from .promise import Promise, need

SLACK = 1e-9


@kernel
def _ends(rules, times, delta_v, end):
    """ΔV and end of service of (origin, destination, ready time); +inf where none is in time."""
    for i in range(rules.service.size):
        for j in range(rules.service.size):
            for s in range(times.size):
                delta_v[i, j, s] = np.inf
                end[i, j, s] = np.inf
                if i != j:
                    legal, cost, done = rule_kernels.fits(rules, i, times[s], rules.budget, j)
                    if legal:
                        delta_v[i, j, s] = cost
                        end[i, j, s] = done


def didppy_promise(
    mission: adr_opt.Mission,
    *,
    time_limit_s: float,
    slot_s: float = 240.0,
    earlier_is_better: bool = False,
    threads: int = 1,
) -> Promise:
    """The best plan and bound of CABS on the model in slots.

    Parameters
    ----------
    mission : Mission
    time_limit_s : float
        For the search [s].
    slot_s : float
        Slot of time [s].
    earlier_is_better : bool
        Let a state dominate another that is later. The model is not so (who is early may have to
        take a worse event), so the search is no longer complete and the bound is dropped.
    threads : int

    Raises
    ------
    MissingExtra
        DIDPPy is not installed.
    InputError
        The slot is not shorter than the time between two events, or DIDPPy is too old.
    """
    dp: Any = need("didppy")
    if not hasattr(dp, "fractional_knapsack"):
        raise InputError(f"DIDPPy {version('didppy')} is too old: install DIDPPy 0.11 or later")
    began = time.perf_counter()
    rules = mission.rules
    bodies = rules.service.size
    if bodies < 2:
        return Promise(((),), 0.0, 0.0, 0.0, 0.0)
    shortest = shortest_spacing(rules.table)
    if not 0.0 < slot_s < shortest:
        raise InputError(f"slot_s = {slot_s!r}: must be > 0 and < {shortest:.0f}")
    slots = math.ceil(rules.duration / slot_s) + 1
    late = slots  # the slot of what is not possible
    delta_v = np.empty((bodies, bodies, slots + 1))
    end = np.empty_like(delta_v)
    times = slot_s * np.arange(slots + 1)
    _ends(rules, times, delta_v, end)
    possible = np.isfinite(end)
    # Rounding up to m/s, less a small slack.
    spent = np.ceil(np.where(possible, delta_v, 0.0) - SLACK)
    reached = np.ceil(np.where(possible, end, 0.0) / slot_s)
    tank = math.floor(rules.budget)
    arrive = np.where(possible, reached, late).astype(np.int64)
    cost = np.where(possible, spent, tank + 1).astype(np.int64)

    whole = all(float(prize).is_integer() for prize in rules.prize)
    prizes = [int(p) if whole else float(p) for p in rules.prize]
    model = dp.Model(maximize=True, float_cost=not whole)
    kind = model.add_object_type(number=bodies)
    moments = model.add_object_type(number=slots + 1)
    todo = model.add_set_var(object_type=kind, target=list(range(1, bodies)))
    body = model.add_element_var(object_type=kind, target=STATION)
    if earlier_is_better:
        slot = model.add_element_resource_var(object_type=moments, target=0, less_is_better=True)
    else:
        slot = model.add_element_var(object_type=moments, target=0)
    left = model.add_int_resource_var(target=tank, less_is_better=False)
    over = model.add_int_var(target=0)
    arrival = model.add_element_table(arrive.tolist())
    needed = model.add_int_table(cost.tolist())

    number: dict[str, int] = {}
    rest = dp.IntExpr.state_cost() if whole else dp.FloatExpr.state_cost()
    for j in range(bodies):
        ends = arrival[body, j, slot]
        conditions = [over == 0, ends < late, needed[body, j, slot] <= left]
        effects: list[Any] = [(body, j), (slot, ends)]
        if j == STATION:
            conditions.append(body != STATION)
            effects.append((left, tank))
        else:
            conditions.append(todo.contains(j))
            effects += [(left, left - needed[body, j, slot]), (todo, todo.remove(j))]
        number[str(j)] = j
        gain = rest if j == STATION else prizes[j] + rest
        model.add_transition(
            dp.Transition(name=str(j), cost=gain, preconditions=conditions, effects=effects)
        )
    # A plan may end at any time.
    model.add_transition(
        dp.Transition(name="end", cost=rest, preconditions=[over == 0], effects=[(over, 1)])
    )
    model.add_base_case([over == 1])

    # Σ least times ≤ time left, and refuelling buys at most tank − c₀ of ΔV for τ₀ of time: one
    # knapsack in which a target weighs τ + λ c and the state has room for its time + λ its ΔV.
    stays = arrive[:, :, :-1] - np.arange(slots)
    tau = np.where(possible[:, :, :-1], stays, late).min(axis=(0, 2))
    least = cost.min(axis=(0, 2))
    bought = tank - int(least[STATION])
    rate = float(tau[STATION]) / bought if bought > 0 and tau[STATION] < late else 0.0
    weights = [float(tau[j] + rate * least[j]) for j in range(bodies)]
    # The time left as a number: elements are names of slots to DIDPPy.
    time_left = model.add_float_table([float(max(0, slots - 1 - s)) for s in range(slots + 1)])
    room = time_left[slot] + rate * left + 1e-6
    knapsack = dp.fractional_knapsack(todo, room, [float(p) for p in rules.prize], weights)
    prize_table = model.add_int_table(prizes) if whole else model.add_float_table(prizes)
    for bound in (math.floor(knapsack + 1e-6) if whole else knapsack, prize_table[todo]):
        model.add_dual_bound((over == 0).if_then_else(bound, 0 if whole else 0.0))
    built = time.perf_counter()

    solver = dp.CABS(model, time_limit=time_limit_s, quiet=True, threads=threads)
    best: Any = None
    best_bound = math.inf
    while True:
        solution, ended = solver.search_next()
        if solution.best_bound is not None and solution.best_bound < best_bound:
            best_bound = float(solution.best_bound)
        if solution.cost is not None and (best is None or solution.cost > best.cost):
            best = solution
        if ended:
            break
    moves = [] if best is None else [number[t.name] for t in best.transitions if t.name in number]
    visits = 0.0 if best is None else float(best.cost)
    if earlier_is_better:
        best_bound = math.inf
    solved = time.perf_counter() - built
    return Promise((tuple(moves),), visits, best_bound, built - began, solved)
