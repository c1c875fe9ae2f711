"""Planning and proving where arrivals are functions of time, against enumeration."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from seeds import over_seeds
from timed_enumeration import best_route
from timed_fields import alone, captured_timed, timed_mission, two_chasers

import adr_opt
from adr_opt.mission.certified import certify
from adr_opt.mission.certify import certificate_of
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.problem.given import only
from adr_opt.problem.given_functions import of_breakpoints
from solvers.timed_tours.earliest_end import EarliestEnd
from solvers.timed_tours.layers import LayerSearch, windows_of
from solvers.timed_tours.memories import memories_of
from solvers.timed_tours.optimistic import OptimisticLegs
from solvers.timed_tours.relaxation import bound_units, narrowed, relaxed, steps_of, whole_bands
from solvers.timed_tours.tour import deadlines, last_end, reached, sequence_of, tour_of


def _compare(instance: adr_opt.Instance, method: str) -> adr_opt.Result:
    prizes, cost = best_route(instance)
    result = adr_opt.solve(instance, method, time_limit=1000.0)
    if prizes == -math.inf:
        assert result.status == "infeasible"
        return result
    assert result.status == "optimal"
    assert result.plan is not None
    assert adr_opt.check(instance, result.plan) == ()
    assert result.objective == pytest.approx(prizes)
    assert result.plan.cost == pytest.approx(cost, abs=1e-5)
    assert result.plan.cost_status == "optimal"
    assert result.plan.cost_bound <= cost + 1e-5
    return result


@over_seeds(range(150), gate=4)
def test_routes_are_those_of_enumeration(seed: int) -> None:
    """Prizes, cost and both proofs are those of all orders, with rules on and off."""
    _compare(timed_mission(seed), "exact" if seed % 2 else "auto")


@over_seeds(range(1000), gate=3)
def test_two_chasers_are_those_of_enumeration(seed: int) -> None:
    """Of two chasers prizes and least ΔV are the best of all ways to deal out the targets."""
    instance = two_chasers(seed)
    best = (-math.inf, -math.inf)
    for dealt in itertools.product((0, 1), repeat=len(instance.targets)):
        found = [best_route(alone(instance, chaser, dealt)) for chaser in (0, 1)]
        best = max(best, (sum(one[0] for one in found), -sum(one[1] for one in found)))
    result = adr_opt.solve(instance, "exact", time_limit=1000.0)
    if best[0] == -math.inf:
        assert result.status == "infeasible"
        return
    assert result.status == "optimal"
    assert adr_opt.check(instance, result.plan) == ()
    assert result.objective == pytest.approx(best[0])
    assert result.plan.cost == pytest.approx(-best[1], abs=1e-5)
    assert result.plan.cost_bound <= -best[1] + 1e-5


@over_seeds(range(200), gate=6)
def test_tours_are_those_of_enumeration(seed: int) -> None:
    """With all targets required the end is the least of all orders, or there is no tour."""
    _compare(timed_mission(seed, all_required=True), "auto" if seed % 2 else "exact")


@over_seeds(range(100), gate=4)
def test_windows_are_those_of_enumeration(seed: int) -> None:
    """With several windows of each target the same holds of routes and of tours."""
    instance = captured_timed(seed, all_required=seed % 3 == 0)
    _compare(instance, "exact" if seed % 2 else "auto")


@over_seeds(range(300), gate=4)
def test_optimistic_legs_are_no_later(seed: int) -> None:
    """On them each route ends no later than in truth, and as late once its times are points."""
    instance = timed_mission(seed, all_required=True)
    mission, legs = adr_opt.Mission(instance), OptimisticLegs(Problem(instance))
    for body, points in legs.points.items():
        legs.points[body] = points[:: 1 + seed % 100]
    targets = range(mission.rules.first_target, len(mission.names))
    for order in itertools.islice(itertools.permutations(targets), 6):
        route = mission.closed(order)
        truth, coarse = mission.time(route), Mission(legs.instance())
        optimistic = coarse.time(route)
        assert optimistic.made >= truth.made
        if truth.made == len(route) and mission.may_stop(route):
            assert optimistic.cost <= truth.cost
            legs.refine(certify(coarse, "by hand", route, seed=0, runtime_s=0.0).plan)
            found = Mission(legs.instance()).time(route).cost
            assert found == pytest.approx(truth.cost, abs=1e-4)


@over_seeds(range(100), gate=3)
def test_relaxed_tours_end_no_later(seed: int) -> None:
    """For any multipliers, steps and memories the relaxation is no more than the best tour.

    However many words the sets take.
    """
    instance = timed_mission(seed, all_required=True)
    prizes, least = best_route(instance)
    tour = tour_of(adr_opt.Mission(instance))
    if prizes == -math.inf or tour is None:
        pytest.skip("no tour")
    rng, until = np.random.default_rng(seed), float(last_end(tour, tour.targets + 1))
    size, count = int(rng.integers(1, 4)), int(rng.integers(3, 60))
    steps, memories = steps_of(tour, until, count), memories_of(tour, size, until)
    multipliers = rng.integers(-50_000, 50_000, tour.targets)
    found = relaxed(steps, memories, whole_bands(tour.targets, count), multipliers, 1)
    assert tour.ready + bound_units(found) * steps.unit <= least + 1e-6
    # What bands leave out is no part of a tour that ends by then: the search still finds the best.
    most = math.floor((least + 1e-6 - tour.ready) / steps.unit)
    finer = steps_of(tour, until, 2 * count)
    narrow = relaxed(finer, memories, narrowed(found, most, 2), multipliers, 1)
    windows = windows_of(deadlines(tour, until), bits=1 + seed % 4)
    search = LayerSearch(tour, narrow, windows, lambda: False)
    outcome = search.search(most, 10**6)
    assert outcome.whole
    assert outcome.end_s == pytest.approx(least, abs=1e-6)
    time, here = tour.ready, tour.targets
    for j in (*outcome.order, tour.targets + 1):
        time, here = reached(tour, here, j, time), j
    assert time == outcome.end_s


@over_seeds(range(60), gate=3)
def test_bounds_hold_whenever_the_search_ends(seed: int) -> None:
    """Bound and best tour enclose the least end after every round."""
    instance = timed_mission(seed, all_required=True)
    prizes, least = best_route(instance)
    mission = adr_opt.Mission(instance)
    tour = tour_of(mission)
    assert tour is not None
    search = EarliestEnd(tour, lambda: False, jobs=1, most_labels=10**6)
    for _ in search.rounds():
        if prizes == -math.inf:
            assert search.order is None
        else:
            assert search.bound_s <= least + 1e-6 <= search.end_s + 2e-6
    assert search.proven
    if search.order is not None:
        order = sequence_of(mission, tour, search.order)
        assert mission.time(order).cost == pytest.approx(search.end_s, abs=1e-5)


def test_a_changed_leg_is_found() -> None:
    """A leg that leaves, arrives or costs otherwise than its function says is a violation."""
    instance = timed_mission(1, all_required=False)
    plan = adr_opt.solve(instance, "auto", time_limit=1000.0).plan
    leg = plan.routes[0].legs[0]
    for change in (
        {"arrival_s": leg.arrival_s - 1.0},
        {"arrival_s": leg.arrival_s + 1.0},
        {"delta_v_m_s": leg.delta_v_m_s + 1.0},
        {"departure_s": leg.departure_s + 1e4},
    ):
        legs = (leg.replace(**change), *plan.routes[0].legs[1:])
        routes = (plan.routes[0].replace(legs=legs),)
        assert adr_opt.check(instance, plan.replace(routes=routes)) != ()


def test_a_certificate_is_verified() -> None:
    """Where all targets are done the certificate stands, and is verified."""
    for seed in range(40):
        instance = timed_mission(seed, all_required=True)
        result = adr_opt.solve(instance, "auto", time_limit=1000.0)
        if result.plan is not None:
            break
    verdict = adr_opt.verify(instance, result.plan, certificate_of(instance, result))
    assert verdict.verified
    assert verdict.upper_bound == result.objective


@pytest.mark.slow
def test_sets_of_two_words_are_proven() -> None:
    """Of seventy targets whose windows leave little choice the least end is that of all orders."""
    rng, names = np.random.default_rng(5), [f"t{number:02d}" for number in range(70)]
    takes = 1.0 + rng.random((71, 71))
    pairs = [
        (i, j, [[0.0, takes[a, b]], [300.0, 300.0 + takes[a, b]]], 0.0)
        for (a, i), (b, j) in itertools.permutations(enumerate(["s0", *names]), 2)
    ]
    shape = timed_mission(0, all_required=True)
    made = shape.with_given(only(of_breakpoints([], shape.names))).replace(
        stations=shape.stations[:1],
        targets=[
            shape.targets[0].replace(name=name, window_s=(3.0 * at, 3.0 * at + 4.0))
            for at, name in enumerate(names)
        ],
        chasers=[shape.chaser.replace(end="anywhere")],
        mission=shape.mission.replace(duration_s=300.0, service_s=0.0),
    )
    tour = tour_of(Mission(made.with_given(only(of_breakpoints(pairs, made.names)))))
    assert tour is not None
    search = EarliestEnd(tour, lambda: False, jobs=1, most_labels=10**6)
    for _ in search.rounds():
        pass
    assert search.proven
    # By sets as Python has them: of all targets but a few the order is settled.
    ways = {(frozenset[int](), 0): 0.0}
    for _ in names:
        longer: dict[tuple[frozenset[int], int], float] = {}
        for (done, here), time in ways.items():
            for at in range(70):
                end = max(time + takes[here, at + 1], 3.0 * at)
                late = set(range(70)).difference(done, {at}, range(math.ceil(end / 3.0 - 2.0), 70))
                if at not in done and end <= 3.0 * at + 4.0 and not late:
                    key = done | {at}, at + 1
                    longer[key] = min(end, longer.get(key, math.inf))
        ways = longer
    assert search.end_s == pytest.approx(min(ways.values()), abs=1e-4)
