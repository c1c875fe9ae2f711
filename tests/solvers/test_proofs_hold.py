"""Proofs hold against everything that `check` accepts, where rounding would decide, too.

The instances are of the kind in which a chaser is ready exactly when a departure event is, a plan
costs exactly the budget, or ends exactly with the mission.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from calling import call
from judge import accepted
from resonant_fields import RARE, resonant
from seeds import over_seeds

import adr_opt
from adr_opt.common.errors import MissingExtra
from adr_opt.common.stop import MaxRuntime
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result
from adr_opt.problem.instance import Instance
from adr_opt.run.methods import BOUNDS, PLANNERS, get, names, spec

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


@over_seeds(SEEDS, gate=2)
def test_limits_that_a_plan_just_meets(seed: int) -> None:
    """Where a plan takes all there is to the last bit, all proofs end, and hold against `check`."""
    assert_holds(tight(seed))
