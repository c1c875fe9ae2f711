"""The Lagrangian bound: valid on every instance, and tight where the search finishes."""

import numpy as np
import pytest
from brute_force import brute_force
from calling import call
from seeds import over_seeds

import adr_opt
from adr_opt.common.stop import MaxIterations, MaxRuntime
from adr_opt.kernels.core.compile import kernel
from adr_opt.mission.certify import certificate_of
from adr_opt.mission.mission import Mission
from solvers.bounds.lagrangian import lagrangian
from solvers.networks import simd
from solvers.walks.latest_times import latest_of, latest_time
from solvers.walks.multipliers import Descent
from solvers.walks.walks import MOST_SLOTS, WalkBound

SLOTS_M_S = (7.0, 40.0, 150.0)
SHARES = (0.0, 1.0 / 60.0, 0.2, 0.5)


def silent(incumbent, bound):
    pass


def tiny_mission(seed, *, refuelling=False):
    """3–6 targets; time or ΔV short; every other one with unequal prizes, every third with zones.

    With ``refuelling`` few targets, a long mission and a small tank.
    """
    rng = np.random.default_rng(seed)
    targets = int(rng.integers(2, 5) if refuelling else rng.integers(3, 7))
    instance = adr_opt.generate("tiny", seed, targets=targets, zones=2 * (seed % 3 == 0))
    prizes = np.ones(targets)
    if seed % 2:
        prizes = np.round(rng.uniform(0.0, 3.0, targets), 3)
    days = rng.uniform(1.0, 2.5) if refuelling else rng.uniform(0.5, 1.6)
    budget = rng.uniform(500.0, 1100.0) if refuelling else rng.uniform(300.0, 2500.0)
    return Mission(
        instance.replace(
            targets=tuple(
                t.replace(prize=float(p)) for t, p in zip(instance.targets, prizes, strict=True)
            )
        ).with_limits(duration_s=86400.0 * float(days), delta_v_m_s=float(budget)),
        threads=1,
    )


@pytest.fixture(scope="module")
def nominal():
    return Mission(adr_opt.generate("nominal", 0))


@over_seeds(range(150), gate=5)
def test_bound_is_valid_and_tight_on_tiny_instances(seed):
    """Brute force lies under the bound for any slot, and the finished search proves it optimal."""
    mission = tiny_mission(seed, refuelling=seed % 5 < 2)
    optimum, _, _ = brute_force(mission)
    result = call(
        lagrangian, mission, stop=MaxRuntime(60.0), jobs=1, delta_v_slot_m_s=SLOTS_M_S[seed % 3]
    )
    assert result.upper_bound >= optimum - 1e-9
    assert result.upper_bound <= optimum + 1e-5
    assert result.status == "optimal"
    assert result.objective == pytest.approx(optimum, abs=1e-5)


def test_rounding_the_wrong_way_is_caught():
    """With the ΔV of legs rounded up the bound falls below the optimum of some tiny instance."""

    def caught(seed: int) -> bool:
        mission = tiny_mission(seed, refuelling=True)
        optimum, _, _ = brute_force(mission)
        bound = WalkBound(mission, 150.0)
        bound.buckets.cost[:] += 1
        return bound.evaluate(np.zeros(len(mission.names)))[0] < optimum - 1e-6

    assert any(map(caught, range(60)))


def test_landing_late_is_caught():
    """With services that end some rows too late the bound falls below some optimum."""

    def caught(seed: int) -> bool:
        mission = tiny_mission(seed)
        optimum, _, _ = brute_force(mission)
        bound = WalkBound(mission, 7.0, 0.0)
        buckets = bound.buckets
        final = buckets.start[buckets.destination + 1] - 1
        buckets.landing[:] = np.minimum(buckets.landing + 10, final)
        return bound.evaluate(np.zeros(len(mission.names)))[0] < optimum - 1e-6

    assert any(map(caught, range(60)))


@over_seeds(range(40), gate=4)
def test_the_best_plan_is_never_later_than_the_latest_times(seed):
    """Each state of an optimal plan is there in time to collect the rest of the optimum."""
    mission = tiny_mission(seed, refuelling=seed % 2 == 0)
    optimum, _, sequence = brute_force(mission)
    timing = mission.time(sequence)
    rng = np.random.default_rng(seed)
    bound = WalkBound(mission, SLOTS_M_S[seed % 3], SHARES[seed % 4])
    value, multipliers = bound.evaluate(rng.uniform(0.0, 0.5, len(mission.names)))
    latest = latest_of(bound, mission, multipliers, value)
    for made, (body, end, left) in enumerate(
        zip(sequence, timing.ends, timing.lefts, strict=True), start=1
    ):
        unvisited = set(range(len(mission.names))) - set(sequence[:made])
        rest = optimum - mission.collected(sequence[:made])
        rest -= sum(multipliers[j] for j in unvisited)
        assert end <= latest_time(latest, body, left, rest) + 1e-3


def test_walks_never_go_straight_back(nominal):
    """No walk goes i → j → i, also not by way of the station."""
    bound = WalkBound(nominal, 50.0)
    rng = np.random.default_rng(0)
    for high in (0.0, 0.2, 0.8):
        bound.evaluate(rng.uniform(0.0, high, 51))
        walk = bound.walk
        assert walk.size > 5
        returns = (walk[2:] == walk[:-2]) & (walk[2:] != 0)
        assert not returns.any()


def test_walk_is_worth_its_bound(nominal):
    """The best walk's prizes less multipliers, with all multipliers, make up the bound."""
    bound = WalkBound(nominal, 50.0)
    value, rounded = bound.evaluate(np.random.default_rng(1).uniform(0.0, 0.2, 51))
    worth = (nominal.rules.prize - rounded)[bound.walk].sum() + rounded.sum()
    assert value == pytest.approx(worth, abs=1e-9)


@pytest.mark.slow
def test_shorter_buckets_bound_no_worse(nominal):
    """Halving the buckets cannot raise the bound, and exact times give the least."""
    multipliers = np.full(51, 0.05)
    shares = (0.2, 0.1, 0.05, 0.0)
    values = [WalkBound(nominal, 100.0, share).evaluate(multipliers)[0] for share in shares]
    assert values == sorted(values, reverse=True)


@pytest.mark.slow
def test_finer_slots_bound_no_worse(nominal):
    """Halving the slot cannot raise the bound: ⌊x/2u⌋ legs fit wherever ⌊x/u⌋ legs do."""
    multipliers = np.full(51, 0.05)
    values = [WalkBound(nominal, slot).evaluate(multipliers)[0] for slot in (200.0, 100.0, 50.0)]
    assert values[0] >= values[1] >= values[2]


@over_seeds(range(0, 150, 15), gate=3)
def test_a_tank_without_end_is_proven_as_soon_as_one_that_is_large(seed):
    """With 1e9 m/s no ΔV is counted: brute force is met, and the certificate is verified."""
    mission = Mission(tiny_mission(seed).instance.with_limits(delta_v_m_s=1e9), threads=1)
    optimum, _, _ = brute_force(mission)
    result = call(lagrangian, mission, stop=MaxIterations(60), jobs=1)
    assert result.counters["delta_v_slot_m_s"] >= 1e9
    assert result.status == "optimal"
    assert result.upper_bound == result.objective == pytest.approx(optimum, abs=1e-5)
    certificate = certificate_of(mission.instance, result)
    assert adr_opt.verify(mission.instance, result.plan, certificate).verified


def test_slots_of_large_tanks_are_few():
    """Nothing that is made before time is asked for grows with the tank, up to the largest."""
    instance = adr_opt.generate("tiny", 0)
    for tank_m_s in (3e3, 1e5, 1e6, 1e9):
        mission = Mission(instance.with_limits(delta_v_m_s=tank_m_s), threads=1)
        walks = WalkBound(mission, 20.0)
        assert walks.top <= MOST_SLOTS
        assert walks.top * walks.slot <= tank_m_s * (1.0 + 1e-9)
        assert walks.slot >= 20.0


def test_more_targets_than_bits():
    """More targets than one integer remembers: the search still finds the plan it bounds."""
    instance = adr_opt.generate("nominal", 3, targets=70)
    mission = Mission(instance.with_limits(duration_s=1.2 * 86400.0, delta_v_m_s=1500.0))
    result = lagrangian(mission, seed=0, stop=MaxRuntime(60.0), progress=silent)
    assert result.status == "optimal"
    assert result.objective == result.upper_bound
    assert max(result.sequence) > 0


def test_degenerate_missions_are_bounded():
    """No targets, no time, no ΔV, no prizes: the bound is 0 and the empty plan meets it."""
    instance = adr_opt.generate("tiny", 0)
    for variant in (
        instance.replace(targets=()),
        instance.with_limits(duration_s=0.0),
        instance.with_limits(delta_v_m_s=0.0),
        instance.replace(targets=tuple(t.replace(prize=0.0) for t in instance.targets)),
    ):
        result = lagrangian(Mission(variant), seed=0, stop=MaxRuntime(20.0), progress=silent)
        assert result.upper_bound == 0.0
        assert result.objective == 0.0


def test_descent_beats_its_start_and_ends():
    """With unequal prizes the multipliers bring the bound well under its start."""
    mission = tiny_mission(1)
    instance = adr_opt.generate("nominal", 1, targets=12)
    mission = Mission(instance.with_limits(duration_s=3.0 * 86400.0))
    descent = Descent(WalkBound(mission, 50.0))
    first = descent.step()
    while not descent.done:
        value = descent.step()
        assert value >= descent.value
        assert descent.evaluations < 300
    assert descent.value < first - 0.2


@pytest.mark.slow
def test_a_required_target_is_no_reason_to_go_round(nominal):
    """The first bound with a required target is no weaker than the first one without."""
    instance = nominal.instance
    required = instance.targets[3].replace(required=True)
    targets = (*instance.targets[:3], required, *instance.targets[4:])
    free, bound = (
        WalkBound(Mission(each), 20.0) for each in (instance, instance.replace(targets=targets))
    )
    least, _, _ = free.at(free.first_point())
    value, _, _ = bound.at(bound.first_point())
    bonus = Mission(instance.replace(targets=targets)).bonus
    assert value == pytest.approx(least + bonus, abs=0.01)


@kernel
def _lanes_at_work(a, b, out):
    x, y = simd.load(a, 0), simd.load(b, 0)
    simd.store(out, 0, simd.larger(x, y))
    simd.store(out, 16, simd.smaller(x, y))
    simd.store(out, 32, simd.plus(x, y))
    simd.store(out, 48, simd.both(x, y))
    simd.store(out, 64, simd.where_equal(x, y, simd.spread(7), x))
    simd.store(out, 80, simd.where_less(x, simd.count_up(), y, x))
    simd.store(out, 96, simd.where_same(x, y, simd.spread(3), simd.spread(-5)))


def test_lanes_do_as_numpy_does():
    """Each operation on sixteen numbers gives what NumPy gives."""
    rng = np.random.default_rng(3)
    a, b = rng.integers(-9, 9, (2, 16)).astype(np.int32)
    out = np.zeros(112, dtype=np.int32)
    _lanes_at_work(a, b, out)
    up = np.arange(16)
    expected = [
        np.maximum(a, b),
        np.minimum(a, b),
        a + b,
        a & b,
        np.where(a == b, 7, a),
        np.where(a < up, b, a),
        np.where((a ^ b) & 3 == 0, -5, b),
    ]
    assert np.array_equal(out.reshape(7, 16), np.array(expected))
