"""The exact method: equal to brute force, and a valid bound wherever it is cut short.

Proofs also hold against everything that `check` accepts where rounding would decide: a chaser is
ready exactly when a departure event is, a plan costs exactly the budget, or ends with the mission.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from brute_force import brute_force
from calling import call
from judge import accepted
from resonant_fields import RARE, resonant
from seeds import over_seeds
from varied_fields import variant

import adr_opt
from adr_opt.common.errors import MissingExtra
from adr_opt.common.stop import MaxIterations, MaxRuntime
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result
from adr_opt.problem.instance import Instance
from adr_opt.run.methods import BOUNDS, PLANNERS, get, names, spec
from solvers.planners.exact import exact


def prove(mission: Mission, stop: Any = None, **options: Any) -> Result:
    """Run the exact method, to its end unless told otherwise."""
    return call(exact, mission, stop=stop or MaxRuntime(60.0), **{"jobs": 1, **options})


@over_seeds(range(10), gate=3)
def test_cut_short_the_bound_is_valid(seed: int) -> None:
    """After any number of iterations the bound holds, and more of them never loosen it."""
    mission = Mission(variant(seed), threads=1)
    best, _, _ = brute_force(mission)
    found = [prove(mission, MaxIterations(limit)).upper_bound for limit in (1, 2, 4, 8)]
    assert min(found) >= best - 1e-6
    assert found == sorted(found, reverse=True)
    assert math.isfinite(found[0])


def test_too_few_labels_end_with_a_valid_bound() -> None:
    """With hardly any labels it still ends by itself, with a plan and a bound that hold."""
    mission = Mission(adr_opt.generate("tiny", 6, targets=8), threads=1)
    result = prove(mission, most_labels=5)
    assert result.upper_bound >= brute_force(mission)[0]
    assert result.plan is not None


@pytest.mark.parametrize("method", ["auto", "exact", "lagrangian"])
def test_a_proof_that_breaks_ends_its_threads(method: str) -> None:
    """Whatever goes wrong in the middle of a proof, no thread of it lives on."""
    mission = Mission(adr_opt.generate("reduced-time", 1, targets=20), threads=1)
    group = BOUNDS if method == "lagrangian" else PLANNERS
    before = threading.active_count()
    while_proving = []

    def breaks(incumbent: float, bound: float) -> None:
        if bound < mission.total_worth:
            while_proving.append(threading.active_count())
            raise RuntimeError("nobody is listening")

    with pytest.raises(RuntimeError, match="nobody is listening"):
        call(get(method, group), mission, stop=MaxIterations(10), progress=breaks, jobs=2)
    assert max(while_proving) > before
    assert threading.active_count() == before


PROVERS = ("auto", "exact", "mip")

SEEDS = [*range(40), *range(1000, 1300)]

LIMIT_S = 120.0
"""Nothing takes a second, but for kernels that have to be compiled."""


def tight(seed: int) -> Instance:
    """An instance whose limits are what its best plan takes, to the last bit or nearly so."""
    rng = np.random.default_rng(seed)
    instance = resonant(seed)
    best = accepted(instance)
    if not best.legs:
        return instance
    tanks = [0.0]
    for leg in best.legs:
        tanks[-1] += leg.delta_v_m_s
        if leg.destination == "station":
            tanks.append(0.0)
    budget, duration = max(tanks), best.legs[-1].end_s
    short = rng.choice([0.0, 1e-12, 1e-9, 1.5e-6, 5e-5])
    return instance.with_limits(
        delta_v_m_s=max(0.0, float(rng.choice([budget, _next(budget, rng), budget - short]))),
        duration_s=float(rng.choice([duration, _next(duration, rng), duration - short])),
    )


def _next(value: float, rng: np.random.Generator) -> float:
    return float(np.nextafter(value, rng.choice([-np.inf, np.inf])))


def results(mission: Mission) -> Iterator[Result]:
    """What the proving methods and the bounds say, each given the time it needs."""
    for group, methods in ((PLANNERS, PROVERS), (BOUNDS, names(BOUNDS))):
        for method in methods:
            try:
                function = get(method, group)
                one_core = {"jobs": 1} if spec(method, group).uses_cores else {}
                yield call(function, mission, stop=MaxRuntime(LIMIT_S), **one_core)
            except MissingExtra:
                continue


def assert_holds(instance: Instance) -> None:
    """No bound is below what `check` accepts, and whatever can prove that it is optimal does."""
    best = accepted(instance).objective
    for result in results(Mission(instance, threads=1)):
        assert result.upper_bound >= best * (1.0 - 1e-6), result.method
        if result.plan is None:
            continue
        assert adr_opt.check(instance, result.plan) == (), result.method
        if result.method in PROVERS:
            assert result.status == "optimal", result.method
            assert result.objective == pytest.approx(best, rel=1e-6), result.method


@over_seeds([*RARE, *SEEDS], gate=3)
def test_no_proof_is_beaten_by_a_plan_that_check_accepts(seed: int) -> None:
    """Where a chaser is ready exactly at events, bounds and optima are those of `check`."""
    assert_holds(resonant(seed))


@over_seeds(SEEDS, gate=1)
def test_limits_that_a_plan_just_meets(seed: int) -> None:
    """Where a plan takes all there is to the last bit, all proofs end, and hold against `check`."""
    assert_holds(tight(seed))
