"""Rows of a timetable that are worked out on demand: they say what a table that is built says."""

import math

import numpy as np
import pytest
from seeds import first_of, over_seeds

import adr_opt
from adr_opt.kernels.tables import on_demand
from adr_opt.kernels.tables import timetable as tables
from adr_opt.legs.nearest_pairs import neighbours
from adr_opt.legs.timetable import Timetable
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.run import table_budget
from solvers.beams.beams import BeamSettings, beam_search, with_time_value
from solvers.beams.greedy_order import greedy_sequence

LOOKED_UP = 4000


def drawn(seed: int) -> adr_opt.Instance:
    """A field with windows, zones, eccentric orbits and a chaser that comes later, or none."""
    rng = np.random.default_rng(seed)
    field = adr_opt.generate("nominal", seed, targets=12, zones=int(rng.integers(0, 4)))
    duration = field.mission.duration_s
    targets = []
    for target in field.targets:
        opens, closes = np.sort(rng.uniform(0.0, duration, 2)).tolist()
        orbit = target.orbit.replace(eccentricity=float(rng.choice([0.0, rng.uniform(0.0, 0.01)])))
        window = (opens, closes) if rng.random() < 0.3 else (0.0, None)
        targets.append(target.replace(orbit=orbit, window_s=window))
    since = float(rng.choice([0.0, rng.uniform(0.0, 0.3 * duration)]))
    chaser = field.chaser.replace(available_s=(since, None))
    return field.replace(targets=tuple(targets), chasers=(chaser,))


def asking(instance: adr_opt.Instance) -> Mission:
    """A mission without a timetable, whose searches look at all pairs."""
    mission = Mission(instance)
    mission.ask(neighbours(instance, len(instance.names)))
    return mission


@over_seeds(range(6), gate=1)
@pytest.mark.parametrize("worth", first_of([0.0, 110.0, 20.0, 2000.0], gate=2))
def test_what_is_asked_for_is_what_a_table_holds(seed, worth):
    """Whatever an hour is worth, at any time, of any pair: the same ΔV and the same arrival."""
    instance = drawn(seed)
    rng, bodies = np.random.default_rng(seed), len(instance.names)
    held = Timetable(instance, time_value_m_s_per_h=worth)
    asked = Timetable(instance, time_value_m_s_per_h=worth, examined=neighbours(instance, bodies))
    found = 0
    for _ in range(LOOKED_UP):
        i, j = rng.integers(0, bodies, 2)
        if i == j:
            continue
        ready = float(rng.uniform(0.0, instance.mission.duration_s))
        if rng.random() < 0.3:  # as one departs, or a rounding before or after
            event = int(rng.integers(0, 1 + tables.events(held.table, i, j) // 2))
            ready = tables.departure_at(held.table, i, j, event) + rng.choice([-1e-9, 0.0, 1e-9])
        there, here = tables.lookup(held.table, i, j, ready), asked.lookup(i, j, ready)
        found += math.isfinite(here[0])
        assert here == pytest.approx(there, rel=1e-12, abs=1e-7)
    assert found > LOOKED_UP / 10


@over_seeds(range(8), gate=3)
def test_where_planes_drift_what_is_asked_for_is_what_a_list_holds(seed):
    """It is as good as the best of the list, up to the resolution of that, unless that waits."""
    rng = np.random.default_rng(seed)
    family = ("fragment-cloud", "nominal")[seed % 2]
    field = adr_opt.generate(family, seed, targets=8, zones=int(rng.integers(0, 3)))
    resolution, worth = 0.5, float(rng.choice([20.0, 110.0, 500.0]))
    settings = field.transfer.replace(
        delta_v_resolution_m_s=resolution,
        max_drift_s=0.0,
        departure_spacing_s=float(rng.choice([0.0, 7200.0, 20000.0])),
    )
    field = field.replace(dynamics="j2", transfer=settings).with_limits(duration_s=8.0 * 86400.0)
    held = Timetable(field, time_value_m_s_per_h=worth)
    asked = Timetable(field, time_value_m_s_per_h=worth, examined=neighbours(field, 9))
    found, others, bodies = 0, 0, len(field.names)
    for _ in range(LOOKED_UP):
        i, j = rng.integers(0, bodies, 2)
        ready = float(rng.uniform(0.0, field.mission.duration_s))
        if i == j:
            continue
        (cost, arrival), (own, own_arrival) = held.lookup(i, j, ready), asked.lookup(i, j, ready)
        if own == math.inf:
            after = held.connections(i, j, ready).departure
            assert cost == math.inf or after.min() > ready + on_demand.PATIENCE_S - 60.0
            continue
        found += 1
        off = own - cost + worth / 3600.0 * (own_arrival - arrival)
        others += not -1e-3 <= off <= resolution + 1e-3
    assert found > LOOKED_UP / 20
    assert others <= found / 50  # nearly coplanar pairs, of which lists and rows miss some each


@over_seeds(range(4), gate=1)
def test_a_search_that_asks_finds_what_one_on_a_table_finds(seed):
    """With all pairs to look at greedy orders and beams are the same, move by move."""
    instance = drawn(seed)
    there, here = with_time_value(Mission(instance)), with_time_value(asking(instance))
    for guarded in (True, False):
        orders = [greedy_sequence(each, beta=0.01, guarded=guarded) for each in (there, here)]
        assert orders[0].tolist() == orders[1].tolist()
    settings = BeamSettings(width=50, time_weight=0.2, delta_v_weight=0.3, noise=0.1)
    (one, worth, *_), (other, own, *_) = (
        beam_search(each, settings, seed=seed) for each in (there, here)
    )
    assert one.tolist() == other.tolist()
    assert worth == own


@pytest.mark.parametrize("seed", range(3))
def test_no_sortie_is_shorter_than_said(seed):
    """The least time from a station to the end of a service is no more than a table's."""
    instance = drawn(seed)
    asked = asking(instance)
    own = on_demand.shortest_sortie(asked.timetable.table.source, 1, instance.first_target)
    assert 0.0 < own <= Mission(instance).rules.shortest_sortie


@pytest.mark.parametrize("dynamics", ["two-body", pytest.param("j2", marks=pytest.mark.slow)])
@pytest.mark.parametrize("method", ["auto", "exact", "beam", "greedy", "greedy-guarded"])
def test_plans_without_a_table(monkeypatch, method, dynamics):
    """Where no table is built a plan is legal, its bound holds, and a note says what was done."""
    monkeypatch.setattr(table_budget, "LARGE_ENTRIES", 0)
    monkeypatch.setattr(table_budget, "LEAST_S", 0.0)
    monkeypatch.setattr(table_budget, "MOMENT_S", 0.0)
    monkeypatch.setattr(table_budget, "SHARE", 0.0)
    monkeypatch.setattr(table_budget, "RANKS", 10)
    instance = adr_opt.generate("nominal", 3, targets=30)
    required = instance.targets[7].replace(required=True)
    instance = instance.replace(
        targets=(*instance.targets[:7], required, *instance.targets[8:]), dynamics=dynamics
    )
    result = adr_opt.solve(instance, method, time_limit=60.0, iterations=2)
    assert adr_opt.check(instance, result.plan) == ()
    best = adr_opt.solve(instance, "greedy-guarded").objective
    assert 0.4 * best <= result.objective <= result.upper_bound
    assert any(
        "connections computed on demand to the nearest 11 of 30" in note for note in result.notes
    )
    left_out = {each.target for each in result.plan.unvisited if each.reason == "not-considered"}
    assert left_out


def test_who_needs_a_table_gets_one():
    """A mission that was planned without a table has one for a method that looks at it."""
    instance = drawn(1)
    mission = asking(instance)
    assert "rows on demand" in repr(mission.timetable)
    with_it = [adr_opt.solve(each, "mcts", iterations=3) for each in (mission, Mission(instance))]
    assert with_it[0].sequence == with_it[1].sequence
    assert not mission.timetable.is_on_demand


def test_a_required_target_is_looked_at_from_everywhere():
    """However far a required target is, it is among the destinations of every body."""
    instance = adr_opt.generate("nominal", 1, targets=40)
    last = instance.targets[-1]
    instance = instance.replace(targets=(*instance.targets[:-1], last.replace(required=True)))
    near = neighbours(instance, 3).near[0]
    number = len(instance.names) - 1
    assert (near[:number] == number).any(axis=1).all()


def test_long_missions_have_tables(monkeypatch):
    """With thousands of departure events nothing is asked for, nor where one waits for planes."""
    monkeypatch.setattr(table_budget, "LARGE_ENTRIES", 0)
    field = adr_opt.generate("nominal", 0, targets=5)
    assert table_budget.may_work_on_demand(Problem(field))
    year = field.with_limits(duration_s=86400.0 * 365.0)
    assert not table_budget.may_work_on_demand(Problem(year))
    drifting = field.replace(dynamics="j2")
    assert table_budget.may_work_on_demand(Problem(drifting))
    waiting = drifting.replace(transfer=drifting.transfer.replace(max_drift_s=86400.0))
    assert not table_budget.may_work_on_demand(Problem(waiting))


@pytest.mark.parametrize("method", ["greedy-guarded", "auto", "exact"])
def test_several_chasers_plan_on_rows_that_are_asked_for(method):
    """Without timetables two chasers plan as with them, and bounds stay above what they collect."""
    for seed in range(1 if method == "auto" else 3):  # auto goes on to the cost
        first = drawn(seed).chaser
        instance = drawn(seed).replace(chasers=(first, first.replace(name="another")))
        held, asked = Problem(instance), Problem(instance)
        asked.ask(neighbours(instance, len(instance.names)))
        results = [
            adr_opt.solve(problem, method, time_limit=30.0, iterations=2)
            for problem in (held, asked)
        ]
        assert adr_opt.check(instance, results[1].plan) == ()
        assert results[1].upper_bound >= results[0].objective - 1e-9
        if method == "greedy-guarded":
            assert results[0].routes == results[1].routes
