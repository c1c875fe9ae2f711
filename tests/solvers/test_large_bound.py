"""Bounds where the network of all connections takes too much memory: valid, whatever is rounded."""

from __future__ import annotations

import itertools
import math
from contextlib import closing

import numpy as np
import pytest
from against_enumeration import compared
from brute_force import brute_force, brute_force_campaign
from random_rules import (
    carrying,
    drifting_mission,
    falling_mission,
    given_field,
    given_mission,
    mixed_campaign,
    random_mission,
    towing,
    towing_mission,
)
from seeds import over_kinds

import adr_opt
from adr_opt.kernels.core.windows import service_ends
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.plan.tows import removals_of
from adr_opt.problem.chasers import TankByMass
from adr_opt.problem.drives import drive_of
from adr_opt.run import front
from solvers.networks.packed_legs import AHEAD, FIELD, LegSource, NoRoom, Stream
from solvers.proof import large_proof, proof
from solvers.proof.large_proof import LargeProof, layouts
from solvers.walks.floors import Sack, floor_evidence, knapsack
from solvers.walks.least_legs import floors
from solvers.walks.multipliers import Descent
from solvers.walks.priced_walks import PooledBound
from solvers.walks.tank_walks import TankBound
from solvers.walks.walks import WalkBound

SEEDS = 60
MOST = 10**6


def laden_mission(seed: int) -> adr_opt.Instance:
    """With kits and tanks by mass."""
    return carrying(random_mission(seed), seed)


def every_kind(seeds: int, gate: int) -> pytest.MarkDecorator:
    """Missions of each kind, so many of them, and so many at the gate."""
    kinds = (
        random_mission,
        drifting_mission,
        given_mission,
        laden_mission,
        towing_mission,
        falling_mission,
    )
    return over_kinds(
        "draw, seeds", **{draw.__name__: (draw, range(seeds), gate) for draw in kinds}
    )


def streamed(mission: Mission, length: float = 0.0, unit: float = 0.0, jobs: int = 1) -> Stream:
    """The legs of a mission, by default as finely as a proof of it would count them."""
    source = LegSource(mission)
    finest = next(layouts(source, mission, MOST, math.inf))
    return source.stream(
        length or finest.length, unit or finest.unit, MOST, jobs=jobs, over=lambda: False
    )


def value_of(mission: Mission, stream: Stream, point: np.ndarray) -> float:
    """The bound of some multipliers and a price of ΔV."""
    bound = PooledBound(mission, stream)
    return bound.at(bound.allowed(point))[0]


def value_with_tanks(mission: Mission, stream: Stream, point: np.ndarray) -> float:
    """The same where walks know how full the tank is, and pay no price."""
    bound = TankBound(mission, stream)
    return bound.at(bound.allowed(point[:-1]))[0]


def some_point(mission: Mission, rng: np.random.Generator, high: float) -> np.ndarray:
    """Random multipliers up to so many prizes, and a price of ΔV."""
    worth = mission.rules.prize
    return np.append(rng.uniform(0.0, high, worth.size) * worth, rng.uniform(0.0, high))


@every_kind(60, gate=7)
def test_least_times_bound_every_plan(draw, seeds):
    """No plan that enumeration knows is worth more than services at their least time and ΔV."""
    tight = 0
    for seed in seeds:
        mission = Mission(draw(seed))
        prizes, _, _ = brute_force(mission)
        bound = mission.shown(floor_evidence(mission)[0])
        assert bound >= prizes - 1e-9, seed
        tight += bound < mission.total_prize - 1e-6
    assert tight > 0 or draw is given_mission  # whose few targets all fit the time, one by one


@over_kinds(
    "draw, seeds",
    plain=(mixed_campaign, range(15), 5),
    drifting=(lambda seed: mixed_campaign(seed, drifting_mission), range(15), 5),
    given=(lambda seed: mixed_campaign(seed, given_field), range(15), 5),
    laden=(lambda seed: carrying(mixed_campaign(seed), seed), range(15), 5),
    towing=(lambda seed: towing(mixed_campaign(seed), seed), range(15), 5),
)
def test_least_times_bound_every_plan_of_a_campaign(draw, seeds):
    """No plan of several chasers is worth more than services at least time and ΔV of all tanks."""
    for seed in seeds:
        campaign = Problem(draw(seed))
        prizes, _ = brute_force_campaign(campaign)
        assert campaign.shown(floor_evidence(campaign)[0]) >= prizes - 1e-9, seed


def electric_tows(targets: int, chasers: int) -> adr_opt.Instance:
    """Light upper stages around 83° that electric chasers of 700 and 90 kg tow down."""
    drawn = adr_opt.generate("electric", 0, targets=3 * targets)
    light = [target for target in drawn.targets if target.mass_kg < 5000.0][:targets]
    tank = TankByMass(dry_mass_kg=700.0, propellant_kg=90.0, isp_s=1800.0)
    fleet = tuple(chaser.replace(tank=tank) for chaser in drawn.chasers[:chasers])
    return drawn.replace(targets=tuple(light), chasers=fleet)


def test_tows_are_bounded_by_the_rocket_equation_backwards() -> None:
    """No chaser tows more than one whose tows and climbs are the least, each at its own mass.

    Enumerated backwards from an empty tank: the one that is launched onto its first target climbs
    once less.
    """
    campaign = Problem(electric_tows(8, 2))
    mission = campaign.missions[0]
    drive = drive_of(mission.chaser, mission.instance.targets)
    exhaust, most = mission.chaser.tank.exhaust_m_s, 790.0
    _, climbs = floors(mission)
    climb = math.exp(float(climbs[mission.instance.first_target :].min()) / exhaust)
    tow = min(each.delta_v_m_s for each in removals_of(mission.instance, drive).values())
    towing, mass, tows = math.exp(tow / exhaust), 700.0, 0
    while (before := (mass + 1400.0) * towing - 1400.0) <= most:
        tows, mass = tows + 1, before * climb
    assert 0 < tows < 4
    bound, evidence = floor_evidence(campaign)
    assert evidence.floors.alone
    assert campaign.shown(bound) == 2.0 * tows


@every_kind(20, gate=6)
def test_no_connection_is_below_the_floors(draw, seeds):
    """Connections in time take the least time to their destination, and cost the least ΔV."""
    for seed in seeds:
        mission = Mission(draw(seed))
        rules = mission.rules
        least_s, least_m_s = floors(mission)
        for i, j in itertools.permutations(range(len(mission.names)), 2):
            if i in mission.instance.launches:
                continue
            found = mission.connecting.found(i, j)
            at = np.full(found.arrival.size, j)
            end = service_ends(rules.windows, at, found.arrival, rules.service[at])
            assert (end - found.departure >= least_s[j]).all(), (seed, i, j)
            assert (found.delta_v >= least_m_s[j]).all(), (seed, i, j)


@every_kind(60, gate=4)
def test_walks_that_pay_bound_every_plan(draw, seeds):
    """Enumeration lies under the bound for any multipliers, price, length of steps and unit."""
    bounded = 0
    for seed in seeds:
        mission = Mission(draw(seed))
        prizes, _, _ = brute_force(mission)
        rng = np.random.default_rng(seed)
        fine = streamed(mission)
        coarse = streamed(
            mission, fine.length * rng.uniform(1.0, 25.0), fine.unit * rng.uniform(1.0, 60.0)
        )
        for stream in (fine, coarse):
            if stream.least == 0:
                continue
            for high in (0.0, 0.5, 2.0):
                point = some_point(mission, rng, high)
                value = value_of(mission, stream, point)
                assert mission.shown(value) >= prizes - 1e-9, (seed, high)
                if mission.rules.loads is None:
                    known = value_with_tanks(mission, stream, point)
                    assert mission.shown(known) >= prizes - 1e-9, (seed, high)
            bounded += 1
    assert bounded > len(seeds)


@every_kind(30, gate=3)
def test_proofs_without_a_network_stay_above_the_optimum(draw, seeds):
    """Brought down as far as it goes, the bound is that of enumeration or more, and often that."""
    met = 0
    for seed in seeds:
        mission = Mission(draw(seed))
        prizes, _, _ = brute_force(mission)
        stream = streamed(mission)
        if stream.least == 0 or not math.isfinite(prizes):
            continue
        kinds = [PooledBound, TankBound] if mission.rules.loads is None else [PooledBound]
        for kind in kinds:
            descent = Descent(kind(mission, stream))
            while not descent.done and descent.evaluations < 40:
                descent.step()
                assert mission.shown(descent.value) >= prizes - 1e-9, seed
            met += mission.shown(descent.value) <= prizes + 1e-6
    assert met > 0


def test_wrong_roundings_are_caught():
    """With dearer legs, or later landings, the bound falls below some optimum."""
    dear, late, empty = 0, 0, 0
    for seed in range(SEEDS):
        mission = Mission(random_mission(seed))
        prizes, _, _ = brute_force(mission)
        stream = streamed(mission)
        if not math.isfinite(prizes):
            continue
        price = np.append(np.zeros(len(mission.names)), 1.0)
        costlier = stream._replace(legs=stream.legs + 100)
        dear += mission.shown(value_of(mission, costlier, price)) < prizes - 1e-6
        room = stream.steps - (stream.legs >> 48) - (stream.legs >> AHEAD & FIELD)
        later = stream.legs + (np.minimum(room, 200) << AHEAD)
        none = np.zeros(len(mission.names) + 1)
        late += mission.shown(value_of(mission, stream._replace(legs=later), none)) < prizes - 1e-6
        known = value_with_tanks(mission, costlier, none)
        empty += mission.shown(known) < prizes - 1e-6
    assert dear > 0
    assert late > 0
    assert empty > 0


@pytest.mark.parametrize("seed", range(12))
def test_for_no_price_the_bound_is_that_of_walks_without_slots(seed):
    """With ΔV for nothing and fine steps the best walk is worth what it is in the exact network."""
    mission = Mission(adr_opt.generate("tiny", seed, zones=2 * (seed % 2)), threads=1)
    rng = np.random.default_rng(seed)
    exact = WalkBound(mission, 10.0 * mission.rules.budget, 0.0)
    stream = streamed(mission, mission.rules.duration / 32_000)
    multipliers = rng.uniform(0.0, 1.0, len(mission.names))
    value, rounded = exact.evaluate(multipliers)
    found = value_of(mission, stream, np.append(rounded, 0.0))
    assert found == pytest.approx(value, abs=1e-4)


def test_walks_that_know_their_tank_are_those_of_slots():
    """With fine steps and the same slots the best walk is worth what it is in the network.

    But for steps of time: an orbit that is left a moment before one is there may be left in time.
    """
    same = 0
    for seed in range(8):
        mission = Mission(adr_opt.generate("tiny", seed), threads=1)
        exact = WalkBound(mission, 40.0, 0.0)
        stream = streamed(mission, mission.rules.duration / 32_000, exact.slot)
        multipliers = np.random.default_rng(seed).uniform(0.0, 1.0, len(mission.names))
        value, rounded = exact.evaluate(multipliers)
        found = value_with_tanks(mission, stream, np.append(rounded, 0.0))
        assert found >= value - 2e-3, seed
        same += found <= value + 2e-3
    assert same >= 4


def test_finer_counts_bound_no_worse():
    """Halving steps or units cannot raise the bound, but for the rounding of multipliers."""
    mission = Mission(adr_opt.generate("nominal", 0, targets=12))
    point = np.append(np.full(len(mission.names), 0.05), 0.4)
    for counts in (
        [(length, 5.0) for length in (1600.0, 800.0, 400.0, 200.0)],
        [(400.0, unit) for unit in (160.0, 80.0, 40.0, 20.0)],
    ):
        values = [value_of(mission, streamed(mission, *count), point) for count in counts]
        assert all(finer <= coarser + 1e-4 for coarser, finer in itertools.pairwise(values))


def test_threads_do_not_change_the_legs_and_their_values():
    """One thread and two find the same legs of each body and the same bound."""
    mission = Mission(adr_opt.generate("nominal", 1, targets=15))
    one, two = streamed(mission), streamed(mission, jobs=2)
    for body in range(len(mission.names)):
        assert np.array_equal(
            one.legs[one.first[body] : one.last[body]], two.legs[two.first[body] : two.last[body]]
        )
    point = np.append(np.full(len(mission.names), 0.1), 0.3)
    with closing(PooledBound(mission, two, jobs=2)) as bound:
        assert bound.at(point)[0] == value_of(mission, one, point)
    with closing(TankBound(mission, two, jobs=2)) as bound:
        assert bound.at(point[:-1])[0] == value_with_tanks(mission, one, point)


def test_the_slope_is_that_of_a_plane_below():
    """The bound is convex: planes through one point lie below it at all others."""
    mission = Mission(adr_opt.generate("nominal", 2, targets=15))
    bound, rng = PooledBound(mission, streamed(mission)), np.random.default_rng(0)
    points = [some_point(mission, rng, 0.5) for _ in range(12)]
    knows = TankBound(mission, streamed(mission, unit=60.0))
    for found in (
        [bound.at(bound.allowed(point)) for point in points],
        [knows.at(knows.allowed(point[:-1])) for point in points],
    ):
        for (value, point, slope), (other, place, _) in itertools.permutations(found, 2):
            assert other >= value + slope @ (place - point) - 1e-6


def test_a_knapsack_of_floors_is_never_below_a_choice():
    """Whatever may be chosen with so many refuellings in the time is worth no more."""
    rng = np.random.default_rng(4)
    for _ in range(200):
        size = int(rng.integers(1, 8))
        prize, took, cost = (
            rng.uniform(0.0, 2.0, size),
            rng.uniform(0.5, 3.0, size),
            rng.random(size),
        )
        time_s, budget, stop_s = rng.uniform(1.0, 8.0), rng.uniform(0.2, 2.0), rng.uniform(0.2, 3.0)
        best = 0.0
        for chosen in itertools.product((0, 1), repeat=size):
            picked = np.array(chosen)
            stops = max(0, math.ceil((picked @ cost) / budget - 1.0 - 1e-12))
            if picked @ took + stops * stop_s <= time_s:
                best = max(best, float(picked @ prize))
        sack = Sack(prize, took, cost, time_s, budget, budget, stop_s)
        assert knapsack(sack).most >= best - 1e-9


def test_too_little_room_is_said():
    """More legs than there is room for are refused, and a proof without room keeps its floors."""
    mission = Mission(adr_opt.generate("tiny", 0))
    with pytest.raises(NoRoom):
        LegSource(mission).stream(60.0, 5.0, 10, jobs=2, over=lambda: False)


@pytest.mark.usefixtures("no_network")
@pytest.mark.parametrize("method", ["auto", "exact"])
def test_plans_without_a_network_state_a_bound(method):
    """A planner that proves does so by walks that pay, above the optimum and below all prizes."""
    for seed in range(6):
        instance = random_mission(seed)
        prizes, _, _ = brute_force(Mission(instance))
        result = adr_opt.solve(instance, method, time_limit=60.0, iterations=8)
        if math.isfinite(prizes):
            assert result.objective <= prizes + 1e-9 <= result.upper_bound + 2e-9, seed


@pytest.mark.usefixtures("no_network")
def test_without_room_for_legs_the_floors_remain(monkeypatch):
    """With less and less memory the bound gets weaker, and there always is one."""
    mission = Mission(adr_opt.generate("nominal", 0, targets=45))
    bounds = []
    for room in (large_proof.ROOM_BYTES, 0.0):
        monkeypatch.setattr(large_proof, "ROOM_BYTES", room)
        result = adr_opt.bound(mission, "lagrangian", time_limit=60.0, iterations=30)
        bounds.append(result.upper_bound)
        assert any("too much memory" in note for note in result.notes)
    assert bounds[0] < bounds[1] < mission.total_prize


@pytest.mark.usefixtures("no_network")
@pytest.mark.parametrize("method", ["auto", "exact"])
def test_campaigns_without_a_network_state_a_bound(method):
    """Planned without column generation, no plan of several chasers exceeds what is stated."""
    for seed in range(8):
        campaign = Problem(mixed_campaign(seed))
        result = adr_opt.solve(campaign, method, time_limit=60.0, iterations=2)
        compared(campaign, result, seed)


@pytest.mark.parametrize("family", ["nominal", "campaign"])
def test_a_plan_on_some_pairs_states_a_bound_of_all(family):
    """A plan on the timetable of the nearest pairs has the bound of all, and check agrees."""
    instance = adr_opt.generate(family, 0, targets=50)
    result = adr_opt.solve(instance, "auto", time_limit=60.0, iterations=2, memory_gib=3e-3)
    plan = result.plan
    assert any("planned on the timetable of the nearest" in note for note in result.notes)
    assert not any("nothing is proven" in note for note in result.notes)
    assert plan.upper_bound == result.upper_bound < len(instance.targets)
    assert plan.gap == pytest.approx(1.0 - result.objective / result.upper_bound)
    assert adr_opt.check(instance, plan) == ()


def test_every_size_has_a_bound():
    """2,000 targets are bounded in seconds, without a timetable: no more services fit a week."""
    result = adr_opt.bound(
        adr_opt.generate("nominal", 0, targets=2000), "lagrangian", time_limit=20.0
    )
    assert result.upper_bound == 34.0
    assert result.status == "unknown"


def test_campaigns_of_every_size_have_a_bound(monkeypatch):
    """Three chasers among 300 targets are bounded where there is memory for a few pairs only."""
    campaign = Problem(adr_opt.generate("campaign", 0, targets=300))
    monkeypatch.setattr(front, "TABLE_BYTES", 2e7)
    result = adr_opt.bound(campaign, "exact", time_limit=60.0, iterations=1)
    assert not campaign.is_whole
    assert result.objective <= result.upper_bound <= 44.0


@pytest.mark.usefixtures("no_network")
def test_a_proof_is_over_when_time_is():
    """Who has no time left makes no legs, and keeps the bound of floors."""
    instance = adr_opt.generate("nominal", 3, targets=45)
    result = adr_opt.bound(instance, "lagrangian", time_limit=1e-3)
    assert result.counters["evaluations"] == 0
    assert result.upper_bound <= len(instance.targets)


def test_the_proof_tells_what_it_did():
    """Counters name the evaluations and how finely ΔV was counted."""
    mission = Mission(adr_opt.generate("tiny", 1))
    certificate = proof.GapTracker(mission, lambda incumbent, bound: None)
    with closing(
        LargeProof(mission, certificate, adr_opt.common.stop.MaxRuntime(60.0), jobs=1)
    ) as proving:
        proving.begin()
        for _ in range(10):
            proving.advance(lambda: False)
        assert proving.done
        assert proving.counters["evaluations"] > 0
        assert proving.counters["delta_v_unit_m_s"] == large_proof.TANK_UNITS_M_S[0]
