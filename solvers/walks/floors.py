"""A quick bound at any size: every service takes its least time and its least ΔV.

A plan's legs follow one another, and so do their services. Hence with t_j the least time from a
departure to the end of the service of j, and c_j the least ΔV to come to j, from wherever it may
be, the targets x_j that a plan services and its r refuellings keep to

    Σ t_j x_j + t_s r ≤ T ,      Σ c_j x_j ≤ B + b r

where B is what there is at first and b = B a full tank. Of several chasers the sums hold with the
times and the tanks of all of them together, the least t_j and c_j of any, and the largest b. The
most that x_j between 0 and 1 and r ≥ 0 can be worth is bounded by any prices τ, λ ≥ 0 of time and
of ΔV with τ t_s ≥ λ b,

    Σ prize_j x_j ≤ τ T + λ B + Σ max(0, prize_j − τ t_j − λ c_j) ,

and the best τ for a λ is where a knapsack filled in order of worth per time is full. The same holds
of each chaser alone, and where prizes have a step each of these bounds is rounded down to one
before they are added up. No table of pairs is looked at, but for costs that are given.

Where a service changes masses, what is left is no sum of ΔV. Let m be the mass of the chaser
without kits, c = g₀ Isp, and x_j the least ΔV of a leg to j, with the kit of mass k that it takes,
after which j, of mass D, is towed by burns of t, and burns of b lead back. By the rocket equation
backwards a chaser that is left with m had

    f_j(m) = α_j m + β_j ,    α_j = exp((x_j + t + b) / c) ,
    β_j = D (exp(t / c) − 1) exp(x_j / c) + k (exp(x_j / c) − 1)

or more before it. With any ballast s ≥ 0, φ(m) = c ln((m + s) / (m_dry + s)) rises with m, so that
c_j = min φ(f_j(m)) − φ(m) over the masses of a chaser, and B = φ of the largest of them, keep to
the second sum. That difference rises or falls with m all the way, and so is least at an end.
Without ballast it is what legs take of ΔV; with s = β_j / (α_j − 1) the same at every mass, so that
tows lose nothing; and with ever more the least propellant, at the least mass.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np

from adr_opt.mission.evidence import Evidence, Floors
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem, problem_of
from adr_opt.problem.chasers import TankByMass

from .least_legs import GUARD, floors

PRICES = 200
"""Number of prices of ΔV tried."""

SLOT_M_S = 20.0
"""Slot of ΔV stated in certificates that do not use it [m/s]."""

OVER = 5e-7
"""Relative increase of bounds, larger than the deviation of the verifier's code."""

MUCH = 1e3
"""Largest ballast, as a multiple of the mass of an empty chaser."""


class Priced(NamedTuple):
    """A bound, with the prices of time [worth per s] and ΔV [worth per m/s] that prove it."""

    most: float
    per_s: float
    per_m_s: float


class Sack(NamedTuple):
    """Knapsack of time and ΔV: capacities, and worth and least use of each target.

    Attributes
    ----------
    prize, took, cost : (bodies,) float64
        Worths, 0 where a body cannot be serviced; least times [s] and least ΔV [m/s], +inf there.
        ΔV here and below is with the ballast.
    time_s : float
        Of the mission [s].
    budget, tank : float
        ΔV at first, and of a full tank [m/s].
    stop_s : float
        What a refuelling takes at least, +inf where there is none [s].
    """

    prize: np.ndarray
    took: np.ndarray
    cost: np.ndarray
    time_s: float
    budget: float
    tank: float
    stop_s: float


def floor_evidence(problem: Mission | Problem) -> tuple[float, Evidence]:
    """Upper bound on plans of a mission or a campaign, with its evidence.

    In worths, as :attr:`adr_opt.kernels.rules.rules.Rules.prize` has them.
    """
    problem = problem_of(problem)
    distinct = {id(mission): mission for mission in problem.missions}
    number = [sum(id(each) == key for each in problem.missions) for key in distinct]
    least = Floors(0.0, 0.0, math.inf)
    for ballast_kg in sorted(set(chain.from_iterable(map(_ballasts, distinct.values())))):
        sacks = [sack_of(mission, ballast_kg) for mission in distinct.values()]
        most, per_s, per_m_s = knapsack(_together(sacks, number))
        found = [Floors(per_s, per_m_s, most, ballast_kg)]
        if len(problem.missions) > 1 and problem.prize_step:
            for sack in sacks:
                _, per_s, per_m_s = knapsack(sack)
                parts = [problem.rounded_down(worth_at(each, per_s, per_m_s)) for each in sacks]
                most = math.fsum(np.multiply(number, parts))
                found.append(Floors(per_s, per_m_s, most, ballast_kg, alone=True))
        least = min(least, *found, key=lambda each: each.most)
    return least.most, Evidence(np.zeros(len(problem.names)), (), SLOT_M_S, least)


def _together(sacks: Sequence[Sack], number: Sequence[int]) -> Sack:
    """One knapsack of all chasers, by number of each kind."""
    return Sack(
        prize=np.max([sack.prize for sack in sacks], axis=0),
        took=np.min([sack.took for sack in sacks], axis=0),
        cost=np.min([sack.cost for sack in sacks], axis=0),
        time_s=math.fsum(n * sack.time_s for n, sack in zip(number, sacks, strict=True)),
        budget=math.fsum(n * sack.budget for n, sack in zip(number, sacks, strict=True)),
        tank=max(sack.tank for sack in sacks),
        stop_s=min(sack.stop_s for sack in sacks),
    )


def sack_of(mission: Mission, ballast_kg: float = 0.0) -> Sack:
    """Knapsack of one chaser."""
    rules = mission.rules
    least_s, least_m_s = floors(mission)
    uses, launched = _uses(mission, least_m_s, ballast_kg), rules.start in mission.instance.launches
    if launched:  # what no leg leads to may be the first
        uses = uses._replace(cost=np.where(uses.cost <= uses.budget, uses.cost, uses.of_service))
    possible = (rules.windows.opening <= rules.windows.closing) & np.isfinite(least_s)
    possible &= uses.cost <= uses.budget
    possible[: rules.first_target] = False
    took, cost = (np.where(possible, least, math.inf) for least in (least_s, uses.cost))
    # A ready chaser takes departures a slack before, once a leg.
    time_s, budget = max(0.0, rules.duration - rules.ready), uses.budget
    if launched:
        # A launch takes no time and no ΔV.
        time_s += float(took[possible].max(initial=0.0))
        budget += float((uses.cost[possible] - uses.of_service[possible]).max(initial=0.0))
    stop_s = float(least_s[: rules.stations].min(initial=math.inf))
    prize = np.where(possible, rules.prize, 0.0)
    return Sack(prize, took, cost, time_s, budget, uses.budget, stop_s)


class _Uses(NamedTuple):
    """Least ΔV of services, and of a full tank, at some ballast [m/s].

    Attributes
    ----------
    cost, of_service : (bodies,) float64
        With the leg to a body, and without it.
    budget : float
    """

    cost: np.ndarray
    of_service: np.ndarray
    budget: float


def _uses(mission: Mission, least_m_s: np.ndarray, ballast_kg: float) -> _Uses:
    loads, chaser, nothing = mission.rules.loads, mission.chaser, np.zeros_like(least_m_s)
    if loads is None or not isinstance(chaser.usable, TankByMass):
        return _Uses(least_m_s, nothing, mission.rules.budget)
    exhaust, dry = loads.exhaust, chaser.usable.dry_mass_kg
    kits_kg = chaser.kit_mass_kg * np.arange(loads.full.size)
    most = float(np.max((dry + kits_kg) * np.exp(loads.full / exhaust) - kits_kg))

    def used(leg_m_s: np.ndarray) -> np.ndarray:
        rise, more = _backwards(mission, np.minimum(leg_m_s, 2.0 * mission.rules.budget))
        last = np.maximum((most - more) / rise, dry)  # with no more it would have been too heavy
        ends = [np.log((rise * m + more + ballast_kg) / (m + ballast_kg)) for m in (dry, last)]
        cost: np.ndarray = np.where(rise * dry + more > most, math.inf, exhaust * np.minimum(*ends))
        return (1.0 - GUARD) * cost

    full = exhaust * math.log((most + ballast_kg) / (dry + ballast_kg))
    return _Uses(used(least_m_s), used(nothing), full)


def _backwards(mission: Mission, leg_m_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """α and β [kg] of each body, with legs of some ΔV."""
    loads, chaser = mission.rules.loads, mission.chaser
    assert loads is not None
    assert isinstance(chaser.usable, TankByMass)
    tows, grows = loads.takes == 0, np.exp(leg_m_s / loads.exhaust)
    kept = np.where(tows, loads.scale[:, 0], 1.0)
    lost_kg = np.where(tows, loads.loss[:, 0] * chaser.usable.dry_mass_kg, 0.0)
    kit_kg = np.where(tows, 0.0, chaser.kit_mass_kg)
    return grows / kept, lost_kg / kept * grows + kit_kg * (grows - 1.0)


def _ballasts(mission: Mission) -> tuple[float, ...]:
    """Ballasts tried [kg], including that of the median body and a large one."""
    if mission.rules.loads is None or not isinstance(mission.chaser.usable, TankByMass):
        return (0.0,)
    rise, more = _backwards(mission, np.minimum(floors(mission)[1], mission.rules.budget))
    level = (more / np.maximum(rise - 1.0, GUARD))[more > 0.0]
    some = np.quantile(level, (0.0, 0.5, 1.0)).tolist() if level.size else []
    return (0.0, *some, MUCH * mission.chaser.usable.dry_mass_kg)


def knapsack(sack: Sack) -> Priced:
    """Least bound over the prices tried."""
    some = sack.prize > 0.0
    prize, took, cost = sack.prize[some], sack.took[some], sack.cost[some]
    if not prize.size:
        return Priced(0.0, 0.0, 0.0)
    dear = cost > 0.0
    highest = float((prize[dear] / cost[dear]).max(initial=0.0))
    prices = highest * np.append(0.0, np.geomspace(1e-4, 1.0, PRICES)) if highest else np.zeros(1)
    took = np.maximum(took, GUARD)
    least = Priced(math.inf, 0.0, 0.0)
    for price in prices:
        rest = np.maximum(0.0, prize - price * cost)
        order = np.argsort(-rest / took)
        filled = np.cumsum(took[order])
        full = int(np.searchsorted(filled, sack.time_s, side="right"))
        per_s = float((rest / took)[order[full]]) if full < order.size else 0.0
        if math.isfinite(sack.stop_s):
            per_s = max(per_s, price * sack.tank / max(sack.stop_s, GUARD))
        least = min(least, Priced(worth_at(sack, per_s, float(price)), per_s, float(price)))
    return least


def worth_at(sack: Sack, per_s: float, per_m_s: float) -> float:
    """The bound at prices of time and ΔV; too low a price of time is raised."""
    if math.isfinite(sack.stop_s):
        per_s = max(per_s, per_m_s * sack.tank / max(sack.stop_s, GUARD))
    some = sack.prize > 0.0
    prize, took, cost = sack.prize[some], sack.took[some], sack.cost[some]
    over = np.maximum(0.0, prize - per_m_s * cost - per_s * np.maximum(took, GUARD))
    value = per_s * sack.time_s + per_m_s * sack.budget + float(over.sum())
    return value * (1.0 + OVER)
