"""Annealing orders where planes drift: strings of targets are taken out and put back in."""

from __future__ import annotations

import math
from datetime import UTC, datetime

import numpy as np
import pytest
from brute_force import brute_force
from random_rules import drifting_mission
from seeds import over_kinds

import adr_opt
from adr_opt.common.stop import MaxIterations
from adr_opt.mission.certified import certify
from adr_opt.mission.mission import Mission
from adr_opt.problem.bodies import Station, Target
from adr_opt.problem.chasers import AtStation, Chaser, Tank
from adr_opt.problem.given import of_rows
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import GivenFile, MissionSettings, TransferSettings
from solvers.orders import bit_orders, fronts, fronts_backward, single_points
from solvers.orders.connection_table import table_of
from solvers.orders.reach import may_fit, reach_of
from solvers.orders.string_removal import Strings, ruin
from solvers.progress.incumbent import Incumbent
from solvers.routes.strings import LONGEST_STRING, MOST_STRINGS

ENDLESS = MaxIterations(1)
FIELD = 16


@pytest.fixture(scope="module")
def field() -> Mission:
    """Months among targets whose planes are far apart: nobody reaches all of them in time."""
    instance = adr_opt.generate("sso", 1, targets=FIELD).with_limits(duration_s=100 * 86400.0)
    mission = Mission(instance, threads=1)
    assert mission.rules.service.size == FIELD + 1
    return mission


def toured(seed: int = 0, places: int = 8) -> Mission:
    """A mission on given connections that take no ΔV, with windows and unequal prizes."""
    rng = np.random.default_rng(seed)
    names = ["base", *(f"place-{place}" for place in range(1, places + 1))]
    spots = rng.uniform(0.0, 40.0, (len(names), 2))
    rows = [
        (i, j, leaves, leaves + max(1.0, np.ceil(np.hypot(*(spots[i] - spots[j])))), 0.0)
        for i in range(len(names))
        for j in range(len(names))
        for leaves in range(200)
        if i != j
    ]
    parts = ("origin", "destination", "departure_s", "arrival_s", "delta_v_m_s")
    columns = dict(zip(parts, np.array(rows).T, strict=True))
    columns |= {end: columns[end].astype(np.int64) for end in parts[:2]}
    instance = Instance(
        name="tour",
        epoch=datetime(2026, 1, 1, tzinfo=UTC),
        stations=(Station(name=names[0]),),
        targets=tuple(
            Target(name=name, prize=float(rng.integers(1, 30)), window_s=(opens, opens + 50.0))
            for name, opens in zip(names[1:], 20.0 * rng.integers(0, 5, places), strict=True)
        ),
        chasers=(Chaser(name="c", start=AtStation(station=names[0]), tank=Tank(delta_v_m_s=1.0)),),
        mission=MissionSettings(duration_s=200.0, service_s=5.0, refuel_revolutions=0.0),
        transfer=TransferSettings(given=GivenFile(file="tour.parquet")),
    )
    return Mission(instance.with_given(of_rows(columns, names)))


def begun(mission: Mission, order: list[int], length: int) -> bit_orders.BitOrder:
    """A course whose chaser is at the start with a full tank; nothing else is timed."""
    rules = mission.rules
    course = bit_orders.new_course(np.array(order, dtype=np.int64), rules.service.size)
    came, start = course.came, rules.start
    came.size[start], came.time[start, 0], came.tank[start, 0] = 1, rules.ready, rules.budget
    return course


@over_kinds("seeds", drawn=(range(60), 6))
def test_what_is_found_can_be_flown_under_all_rules(seeds):
    """Plans of random missions are legal, collect no more than the best, and mostly as much."""
    best = drawn = 0
    for seed in seeds:
        mission = Mission(drifting_mission(seed))
        prizes, _, _ = brute_force(mission)
        if not math.isfinite(prizes):
            continue
        strings = Strings(mission, 0, ENDLESS)
        found = Incumbent(mission)
        for _ in range(3):
            sequence = strings.anneal(30)
            assert mission.time(sequence).made == len(sequence), seed
            found.offer(sequence)
        result = certify(mission, "test", found.sequence or (), seed=0, runtime_s=0.0)
        if found.sequence is not None:
            assert result.plan is not None
            assert adr_opt.check(mission.instance, result.plan) == (), seed
        objective = mission.shown(found.objective)
        assert objective <= prizes + 1e-9, seed
        best += objective >= prizes - 1e-9
        drawn += 1
    assert best >= 0.8 * drawn, (best, drawn)


@over_kinds("seeds", drawn=(range(20), 3))
def test_what_is_found_on_tours_is_the_best(seeds):
    """Tours with windows are legal, and collect what the best of all orders collects."""
    for seed in seeds:
        mission = toured(seed, 4)
        sequence = Strings(mission, 0, ENDLESS).anneal(200)
        result = certify(mission, "test", sequence, seed=0, runtime_s=0.0)
        assert result.plan is not None
        assert adr_opt.check(mission.instance, result.plan) == (), seed
        assert result.objective == brute_force(mission)[0], seed


def test_a_seed_tells_the_plan(field):
    """The same seed anneals the same orders, another one others."""

    def made(seed: int) -> list[list[int]]:
        strings = Strings(field, seed, ENDLESS)
        return [strings.anneal(40).tolist() for _ in range(3)]

    assert made(1) == made(1)
    assert made(1) != made(2)


def test_annealing_finds_more_than_a_beam(field):
    """From nothing it services all that a beam services, and more."""
    beam = adr_opt.solve(field, "beam", width=300)
    strings = Strings(field, 0, ENDLESS)
    best = max(field.collected(strings.anneal(100)) for _ in range(4))
    assert best > beam.objective


def test_what_changes_is_timed_as_the_whole_is(field):
    """After a target is put in, fronts are those of an order that is timed from nothing."""
    rules, connections = field.rules, table_of(field)
    reach = reach_of(connections, rules.stations, rules.duration)
    workspace = fronts.new_workspace(connections)
    rng = np.random.default_rng(4)
    strings = Strings(field, 3, ENDLESS)
    visited = [int(j) for j in strings.anneal(60) if j >= rules.first_target]
    others = [j for j in range(rules.first_target, FIELD + 1) if j not in visited]
    put_in = 0
    for take in range(len(visited)):
        order = visited[:take] + visited[take + 1 :] + [visited[take], *others]
        size = len(visited) - 1
        course = begun(field, order, size)
        assert bit_orders.time_back(rules, connections, course, size, size - 1, -1, workspace)
        assert bit_orders.time_forth(rules, connections, course, size, 0, size, workspace)
        bit_orders.find_room(rules, course, size, workspace)
        place = bit_orders.best_position(
            rules, connections, reach, course, size, visited[take], workspace, rng
        )
        if place < 0:
            continue
        bit_orders.insert(course.order, size, place)
        assert bit_orders.time_back(
            rules, connections, course, size + 1, place, place - 1, workspace
        )
        assert bit_orders.time_forth(
            rules, connections, course, size + 1, place, place + 1, workspace
        )
        anew = begun(field, course.order.tolist(), size + 1)
        assert bit_orders.time_back(rules, connections, anew, size + 1, size, -1, workspace)
        assert bit_orders.time_forth(rules, connections, anew, size + 1, 0, size + 1, workspace)
        for j in course.order[: size + 1]:
            point = anew.suffices.size[j]
            assert course.suffices.size[j] == point
            for one, other in zip(course.suffices[1:3], anew.suffices[1:3], strict=True):
                np.testing.assert_array_equal(one[j, :point], other[j, :point])
        assert bit_orders.spare(course, size + 1) >= 0.0
        put_in += 1
    assert put_in >= len(visited) // 2


def test_what_is_refused_does_not_fit(field):
    """A position that bounds on legs refuse is one where no fronts meet; most of those are."""
    refused = hopeless = fitting = 0
    for mission in (field, *(Mission(drifting_mission(seed)) for seed in range(12))):
        rules, connections = mission.rules, table_of(mission)
        reach = reach_of(connections, rules.stations, rules.duration)
        workspace = fronts.new_workspace(connections)
        visited = [int(j) for j in Strings(mission, 3, ENDLESS).anneal(40)]
        visited = [j for j in visited if j >= rules.first_target]
        for j in range(rules.first_target, rules.service.size):
            kept = [other for other in visited if other != j]
            course, size = begun(mission, [*kept, j], len(kept)), len(kept)
            if not (
                bit_orders.time_back(rules, connections, course, size, size - 1, -1, workspace)
                and bit_orders.time_forth(rules, connections, course, size, 0, size, workspace)
            ):
                continue
            came, suffices = course.came, course.suffices
            for p in range(size + 1):
                i, k = kept[p - 1] if p else rules.start, kept[p] if p < size else -1
                latest, need = rules.duration, 0.0
                if k >= 0:
                    latest, need = suffices.time[k, 0], suffices.tank[k, suffices.size[k] - 1]
                times = came.time[i, 0], latest
                tanks = came.tank[i, came.size[i] - 1], need
                may = may_fit(rules, reach, i, j, k, times, tanks, p > 0)
                left = bit_orders.left_with(
                    rules, connections, course, size, j, p, latest, workspace
                )
                assert may or left == -math.inf
                refused += not may
                hopeless += left == -math.inf
                fitting += left >= 0.0
    assert fitting > 50
    assert refused > 0.5 * hopeless


def test_what_plainly_is_one_point_is_the_whole_front(field):
    """Where the quick look at two bodies answers, the fronts are what it says; mostly it does."""
    rng = np.random.default_rng(0)
    answers = {"forth": 0, "back": 0}
    for mission in (field, toured(), *(Mission(drifting_mission(seed)) for seed in range(12))):
        rules, connections = mission.rules, table_of(mission)
        bodies, workspace = rules.service.size, fronts.new_workspace(connections)
        trial, here = workspace.trial, fronts.new_front(bodies)
        for _ in range(400):
            i, j = rng.integers(0, bodies, 2)
            if i == j:
                continue
            times = np.sort(rng.uniform(0.0, rules.duration, 2))
            tank, refuels = rng.uniform(0.0, rules.budget), bool(rng.integers(2))
            here.size[i], here.time[i, 0], here.tank[i, 0] = 1, times[0], tank
            size, end, left = single_points.arrives(
                connections, i, j, refuels, times[0], tank, times[1]
            )
            if size >= 0:
                asked = rules, connections, i, j, refuels, here, times[1], workspace
                assert fronts.forwards(*asked) == size
                assert size == 0 or (trial.time[0, 0], trial.tank[0, 0]) == (end, left)
                answers["forth"] += size
            here.size[j], here.time[j, 0], here.tank[j, 0] = 1, times[1], tank
            size, departure, needed = single_points.leaves(
                connections, i, j, times[1], tank, times[0]
            )
            if size >= 0:
                asked = rules, connections, i, j, here, times[0], workspace, 0
                assert fronts_backward.backwards(*asked) == size
                assert size == 0 or (trial.time[0, 0], trial.tank[0, 0]) == (departure, needed)
                answers["back"] += size
    assert answers["forth"] > 150, answers
    assert answers["back"] > 50, answers


def test_ruins_say_what_they_leave():
    """A ruin keeps all targets, in order, and those before and behind what it says in place."""
    rng = np.random.default_rng(0)
    targets = 20
    near = np.array([rng.permutation(targets) for _ in range(targets)])
    for j in range(targets):
        near[j] = [j, *near[j][near[j] != j]]
    taken = set()
    for _ in range(300):
        before = rng.permutation(targets)
        length = int(rng.integers(1, targets + 1))
        order = before.copy()
        left, first, last = ruin(order, length, near, rng)
        assert sorted(order) == list(range(targets))
        kept = [j for j in before[:length] if j in order[:left]]
        assert order[:left].tolist() == kept
        assert order[length:].tolist() == before[length:].tolist()
        assert order[:first].tolist() == before[:first].tolist()
        behind = left - last
        assert order[last:left].tolist() == before[length - behind : length].tolist()
        taken.add(length - left)
    assert min(taken) >= 1
    assert LONGEST_STRING < max(taken) <= LONGEST_STRING * MOST_STRINGS


@pytest.mark.filterwarnings("error")
def test_one_target_has_no_neighbours() -> None:
    """A mission of one target is annealed without means of nothing."""
    mission = toured(places=1)
    assert Strings(mission, 0, ENDLESS).anneal(20) is not None
