"""Proofs hold against everything that `check` accepts, where rounding would decide, too.

The instances are of the kind in which a chaser is ready exactly when a departure event is, a plan
costs exactly the budget, or ends exactly with the mission.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from calling import call
from judge import accepted

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M, MU_M3_S2
from adr_opt.common.errors import MissingExtra
from adr_opt.common.stop import MaxRuntime
from adr_opt.mission.problem import Mission
from adr_opt.mission.result import Result
from adr_opt.problem.bodies import Station, Target
from adr_opt.problem.chasers import AtStation, Chaser, Tank
from adr_opt.problem.instance import Instance
from adr_opt.problem.orbit import Orbit
from adr_opt.problem.settings import KeepOutZone, MissionSettings, TransferSettings
from adr_opt.run.methods import BOUNDS, PLANNERS, get, names, takes_jobs
from adr_opt.sources.generator import EPOCH

PROVERS = ("auto", "exact", "mip", "cpsat")
RARE = (63, 842, 883, 1005)
"""Where a chaser is ready at 0 just after the first event, and where the costs of sequences tie."""

EVERY_TIME = 24
"""So many of each kind in every run of the tests."""

LIMIT_S = 120.0
"""Nothing takes a second, but for kernels that have to be compiled."""
PERIOD_S = 2.0 * math.pi * math.sqrt((EARTH_RADIUS_M + 700e3) ** 3 / MU_M3_S2)


def resonant(seed: int) -> Instance:
    """Bodies whose legs end when the next ones begin, but for rounding.

    By turns planes share their RAAN, their inclination, or everything and altitudes differ;
    latitudes are quarters of a turn, services half periods, and the stand-off is next to nothing.
    """
    rng = np.random.default_rng(seed)

    def orbit() -> Orbit:
        steps = [float(rng.integers(-2, 3)) if seed % 3 == kind else 0.0 for kind in range(3)]
        return Orbit(
            semi_major_axis_m=EARTH_RADIUS_M + 700e3 + 5e3 * (steps[2] + abs(steps[2])),
            eccentricity=0.0,
            inclination_deg=90.0 + steps[0],
            raan_deg=steps[1],
            argument_of_perigee_deg=0.0,
            true_anomaly_deg=float(rng.choice([0.0, 0.0, 90.0, 180.0, 1e-9])),
        )

    zone = KeepOutZone(
        min_altitude_m=700e3,
        max_altitude_m=720e3,
        start_s=float(rng.choice([0.0, 2.0 * PERIOD_S])),
        end_s=float(rng.choice([2.0, 3.5, 4.0])) * PERIOD_S,
    )
    station = Station(name="station", orbit=orbit())
    targets = tuple(
        Target(name=f"t{number}", prize=float(rng.choice([1.0, 1.0, 2.0, 0.7])), orbit=orbit())
        for number in range(int(rng.integers(2, 5)))
    )
    duration_s = PERIOD_S * float(rng.choice([6.5, 9.0, 10.5, 13.0, 14.0]))
    tank = Tank(delta_v_m_s=float(rng.uniform(100.0, 900.0)))
    service, refuelling = (float(rng.choice([0.0, 0.5, 1.0])) for _ in range(2))
    standoff_m = float(rng.choice([0.0, 0.0, 1e-6, 1e-4, 9e-4]))
    time_value_m_s_per_h = float(rng.choice([0.0, 75.0]))
    instance = Instance(
        name=f"resonant-{seed}",
        epoch=EPOCH,
        stations=(station,),
        targets=targets,
        chasers=(Chaser(name="chaser", start=AtStation(station="station"), tank=tank),),
        mission=MissionSettings(
            duration_s=duration_s,
            service_revolutions=service,
            refuel_revolutions=refuelling,
        ),
        transfer=TransferSettings(
            standoff_m=standoff_m,
            max_altitude_m=float(rng.choice([700e3, 2000e3])),
            max_phasing_revolutions=3,
        ),
        keep_out_zones=(zone,) if seed % 4 == 0 else (),
    )
    return instance.with_time_value(time_value_m_s_per_h)


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
                one_core = {"jobs": 1} if takes_jobs(function) else {}
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


@pytest.mark.parametrize("seed", [*range(EVERY_TIME), *RARE])
def test_no_proof_is_beaten_by_a_plan_that_check_accepts(seed: int) -> None:
    """Where a chaser is ready exactly at events, bounds and optima are those of `check`."""
    assert_holds(resonant(seed))


@pytest.mark.parametrize("seed", range(EVERY_TIME))
def test_limits_that_a_plan_just_meets(seed: int) -> None:
    """Where a plan takes all there is to the last bit, all proofs end, and hold against `check`."""
    assert_holds(tight(seed))


@pytest.mark.slow
@pytest.mark.parametrize("make", [resonant, tight])
def test_many_more(make: Callable[[int], Instance]) -> None:
    """The same for hundreds of instances of both kinds."""
    for seed in (*range(EVERY_TIME, 40), *range(1000, 1300)):
        assert_holds(make(seed))
