"""The relaxation in which chasers may wait and choose, against plain enumeration."""

from __future__ import annotations

import math

import numpy as np
import pytest
from brute_force import brute_force
from hand_made import hand_made

import adr_opt
from adr_opt.instance import Instance
from adr_opt.kernels.constants import STATION
from adr_opt.mission import Mission
from solvers.relaxation import WaitingBound, WaitingRoutes

DAY_S = 86400.0


def random_instance(seed: int) -> Instance:
    """A few targets with random limits, prizes and zones; some planes and some orbits are equal."""
    rng = np.random.default_rng(seed)
    instance = adr_opt.generate(
        "tiny", int(rng.integers(10)), zones=int(rng.choice([0, 0, 3])), targets=5
    )
    targets = [
        target.replace(prize=float(rng.choice([0.0, 0.3, 1.0, 1.0, 2.5])))
        for target in instance.targets[: rng.integers(3, 6)]
    ]
    if rng.random() < 0.3:
        targets[1] = targets[1].replace(orbit=targets[0].orbit)
    if rng.random() < 0.3:
        orbit = targets[2].orbit.replace(inclination_deg=targets[0].orbit.inclination_deg)
        targets[2] = targets[2].replace(orbit=orbit.replace(raan_deg=targets[0].orbit.raan_deg))
    limited = instance.with_limits(
        duration_s=DAY_S * float(rng.uniform(0.3, 0.9)),
        delta_v_m_s=float(rng.choice([150.0, 300.0, 500.0, 900.0])),
    )
    return limited.replace(
        targets=tuple(targets),
        mission=limited.mission.replace(service_revolutions=float(rng.choice([0.0, 0.5, 1.0]))),
    )


def waiting_optimum(mission: Mission) -> float:
    """Most prize of any plan in which the chaser may wait and choose: all plans, set by set."""
    rules = mission.rules
    bodies = len(mission.names)
    legs = {
        (i, j): mission.timetable.connections(i, j, resolution_m_s=0.0)
        for i in range(bodies)
        for j in range(bodies)
        if i != j
    }
    best = 0.0
    # (targets done, body, refuelling earned) → non-dominated (time, ΔV left)
    layer = {(frozenset[int](), STATION, False): [(0.0, rules.budget)]}
    while layer:
        following: dict[tuple[frozenset[int], int, bool], list[tuple[float, float]]] = {}
        for (done, i, earned), labels in layer.items():
            best = max(best, sum(rules.prize[j] for j in done))
            for j in range(bodies):
                if j == i or j in done or (j == STATION and not earned):
                    continue
                key = (done if j == STATION else done | {j}, j, j != STATION)
                pair = legs[i, j]
                for time, left in labels:
                    for c in range(int(np.searchsorted(pair.departure, time)), pair.arrival.size):
                        end = pair.arrival[c] + rules.service[j]
                        if pair.delta_v[c] > left or end > rules.duration:
                            continue
                        rest = rules.budget if j == STATION else left - pair.delta_v[c]
                        found = following.setdefault(key, [])
                        if not any(t <= end and v >= rest for t, v in found):
                            found[:] = [(t, v) for t, v in found if t < end or v > rest]
                            found.append((end, rest))
        layer = following
    return best


def proven_optimum(mission: Mission, multipliers: np.ndarray, slot: float) -> float:
    """The least threshold at which a search ends with a plan, asked for from above."""
    bound = WaitingBound(mission, slot, jobs=2)
    routes = WaitingRoutes(bound)
    value, _ = bound.evaluate(multipliers)
    worths = {0.0}
    for prize in mission.rules.prize[1:]:
        worths |= {worth + prize for worth in worths}
    assert value >= max(worth for worth in worths if worth <= value + 1e-9) - 1e-9
    for worth in sorted((w for w in worths if 0.0 < w <= value + 1e-9), reverse=True):
        while True:
            routes.use(multipliers)
            finished, _, plan, grown = routes.search(worth - 1e-6, 10**6, lambda: False)
            assert finished
            visited = [] if plan is None else [int(j) for j in plan if j != STATION]
            assert len(set(visited)) == len(visited)
            if sum(mission.rules.prize[j] for j in visited) >= worth - 1e-6:
                bound.close()
                return worth
            if grown == 0:
                # Some reach it only by the multipliers of targets that they leave out.
                if not multipliers.any():
                    break
                multipliers = np.zeros_like(multipliers)
    bound.close()
    return 0.0


def test_searches_end_at_the_optimum_of_the_waiting_mission():
    """No plan that enumeration knows is above the bound, and the searches find the best one."""
    visits = 0.0
    for seed in range(60):
        mission = Mission(random_instance(seed))
        optimum = waiting_optimum(mission)
        rng = np.random.default_rng(seed)
        prize = mission.rules.prize
        bound = WaitingBound(mission, float(rng.choice([7.0, 20.0, 50.0])))
        for multipliers in (np.zeros(prize.size), rng.uniform(0.0, 1.2, prize.size) * prize):
            multipliers[STATION] = 0.0
            value, _ = bound.evaluate(multipliers)
            assert value >= optimum - 1e-9, seed
        found = proven_optimum(mission, multipliers if seed % 2 else 0.0 * multipliers, 20.0)
        assert found == pytest.approx(optimum, abs=1e-9), seed
        visits += optimum
    assert visits > 60.0


def test_who_may_wait_is_never_worse_off():
    """The optimum with waiting is at least that without, and sometimes more."""
    gains = 0
    for seed in range(30):
        mission = Mission(random_instance(100 + seed))
        gain = waiting_optimum(mission) - brute_force(mission)[0]
        assert gain >= -1e-9, seed
        gains += gain > 0.5
    assert gains > 0


def test_the_hand_made_instance():
    """Its optimum, worked out on paper, has no use for waiting."""
    mission = Mission(hand_made())
    assert waiting_optimum(mission) == 3.0
    assert proven_optimum(mission, np.zeros(5), 10.0) == 3.0


def test_the_result_does_not_depend_on_threads():
    """One thread and two give the same values of all states."""
    mission = Mission(adr_opt.generate("nominal", 0, targets=12))
    one, two = (WaitingBound(mission, 50.0, jobs) for jobs in (1, 2))
    for bound in (one, two):
        bound.evaluate(np.zeros(13))
        bound.close()
    np.testing.assert_array_equal(one.network.landing, two.network.landing)
    np.testing.assert_array_equal(one.values.best, two.values.best)
    assert math.isfinite(one.network.shortest)
