"""Campaigns planned as tours through time: legal, and as good as trying everything."""

from __future__ import annotations

import itertools
import json
import math

import numpy as np
import pytest
from random_rules import freely
from tour_fields import APART, MOST, STAY, STEP_S, launched

import adr_opt
from adr_opt.analysis.priced import price
from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError
from adr_opt.judge.check.verdict import check
from adr_opt.kernels.legs import drift, drift_pair
from adr_opt.kernels.orbits.ephemeris import EPOCH_S
from adr_opt.legs.connection_finder import ConnectionFinder
from adr_opt.mission.problem import Problem
from adr_opt.problem.instance import Instance, instance_of
from adr_opt.problem.tours import tour_obstacle
from solvers.tours import cells, enumerated
from solvers.tours.least_expense import LeastExpense, cell_length_s

SHORTEST = 1
"""Shortest drift, in steps."""


def legs_of(instance: Instance) -> np.ndarray:
    """Exact ΔV of all drift legs, by bodies, departure and arrival in steps."""
    problem = Problem(instance)
    ends, count = problem.connecting.ends, len(instance.targets)
    times = int(instance.mission.duration_s / STEP_S + 1e-9) + 1
    found = np.full((count, count, times, times), np.inf)
    for i, j in itertools.permutations(range(count), 2):
        first = instance.first_target
        bodies = ends.leaving[first + i], ends.arriving[first + j]
        pair = drift_pair.prepare(*bodies, ends.rule, EPOCH_S)
        for d in range(times):
            for a in range(d + SHORTEST, min(d + MOST - STAY, times - 1) + 1):
                found[i, j, d, a] = drift.delta_v(pair, d * STEP_S, a * STEP_S)
    return found


def least_expense(instance: Instance, apart: int | None, most: int | None) -> float:
    """Least expense of all orders, cuts and times, by trying them."""
    legs, count = legs_of(instance), len(instance.targets)
    times = legs.shape[-1]
    chaser = instance.chasers[0]
    tank, stated = chaser.tank, chaser.priced
    exhaust = tank.isp_s * 9.80665  # type: ignore[union-attr]
    dry, full = tank.dry_mass_kg, tank.propellant_kg  # type: ignore[union-attr]

    def missions(order: tuple[int, ...]) -> list[tuple[int, int, float]]:
        """Launch, last arrival and expense of the ways to fly an order."""
        ways = []

        def back(at: int, now: int, mass: float, last: int) -> None:
            if at == 0:
                carried = mass - dry
                if carried - len(order) * chaser.kit_mass_kg <= full:
                    ways.append((now, last, stated.of(carried)))
                return
            i, j = order[at - 1], order[at]
            for before in range(now - STAY - SHORTEST, -1, -1):
                if most is not None and now - before > most:
                    break
                cost = legs[i, j, before + STAY : now, now].min()
                if cost < math.inf:
                    heavier = mass * math.exp(cost / exhaust) + chaser.kit_mass_kg
                    back(at - 1, before, heavier, last)

        for last in range(times - STAY):
            back(len(order) - 1, last, dry + chaser.kit_mass_kg, last)
        return ways

    best = math.inf
    known: dict[tuple[int, ...], list[tuple[int, int, float]]] = {}
    for order in itertools.permutations(range(count)):
        for cuts in itertools.product((False, True), repeat=count - 1):
            if sum(cuts) >= len(instance.chasers):
                continue
            parts, part = [], [order[0]]
            for one, cut in zip(order[1:], cuts, strict=True):
                if cut:
                    parts.append(tuple(part))
                    part = []
                part.append(one)
            parts.append(tuple(part))
            # Least expense of missions over by each time, the next one launched after that.
            over = np.zeros(times)
            for mission in parts:
                if mission not in known:
                    known[mission] = missions(mission)
                then = np.full(times, np.inf)
                for launch, last, cost in known[mission]:
                    since = 0.0 if mission is parts[0] else math.inf
                    if mission is not parts[0] and apart is not None:
                        before = launch - STAY - apart
                        since = over[before] if before >= 0 else math.inf
                    elif mission is not parts[0]:
                        since = over[-1]
                    then[last] = min(then[last], since + cost)
                over = np.minimum.accumulate(then)
            best = min(best, float(over[-1]))
    return best


@pytest.mark.parametrize("seed", range(8))
def test_a_tour_is_as_cheap_as_trying_everything_makes_it(seed: int) -> None:
    """On tiny campaigns, rules on and off, plans are legal and cost least."""
    off = {
        0: {},
        1: {"transfer__max_leg_s": None},
        2: {"mission__mission_separation_s": None},
        3: {"transfer__max_leg_s": None, "mission__mission_separation_s": None},
    }[seed % 4]
    instance = launched(seed, 3 + (seed > 5), **off)
    apart = None if instance.mission.mission_separation_s is None else APART
    most = None if instance.transfer.max_leg_s is None else MOST
    least = least_expense(instance, apart, most)
    result = adr_opt.solve(instance, iterations=2, time_limit=math.inf)
    if math.isinf(least):
        assert result.plan is None
        return
    assert result.plan is not None
    assert not check(instance, result.plan)
    assert result.plan.cost >= least * (1.0 - 1e-9)
    assert result.plan.cost <= (1.0 + 1e-9) * least


@pytest.mark.parametrize("work", [None, 2e6])
def test_a_finer_grid_is_never_worse(work, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each halving of the grid gives a plan of no more cost, tried on all times or on some."""
    if work is not None:
        monkeypatch.setattr(enumerated, "MOST_WORK", work)
    cheaper = 0
    for seed in (3, 11, 12, 17):
        costs = []
        for halved in (1, 2, 4):
            instance = launched(seed, 3, transfer__drift_step_s=STEP_S / halved)
            plan = adr_opt.solve(instance, iterations=1, time_limit=math.inf).plan
            costs.append(math.inf if plan is None else plan.cost)
            assert plan is None or not check(instance, plan)
        assert costs[1] <= costs[0] * (1.0 + 1e-9), seed
        assert costs[2] <= costs[1] * (1.0 + 1e-9), seed
        cheaper += costs[2] < costs[0]
    assert cheaper


@pytest.fixture(scope="module")
def planned() -> tuple[Instance, adr_opt.Plan]:
    """A campaign of several missions with its plan."""
    for seed in range(20):
        instance = launched(100 + seed, 4)
        plan = adr_opt.solve(instance, iterations=1, time_limit=math.inf).plan
        if plan is not None and sum(bool(route.legs) for route in plan.routes) > 1:
            return instance, plan
    raise AssertionError("no campaign of several missions was drawn")


def rules(instance: Instance, plan: adr_opt.Plan) -> set[str]:
    """Rules that a plan breaks in another instance."""
    named = plan.instance.replace(sha256=instance.sha256)
    return {each.rule for each in check(instance, plan.replace(instance=named))}


def test_a_shorter_limit_of_legs_is_noticed(planned: tuple[Instance, adr_opt.Plan]) -> None:
    """A plan whose longest leg, arrival to arrival, exceeds the limit breaks it, and no other."""
    instance, plan = planned
    gaps = [
        other.arrival_s - one.arrival_s
        for route in plan.routes
        for one, other in itertools.pairwise(route.legs)
    ]
    for limit, broken in ((max(gaps), set()), (max(gaps) - 1.0, {"leg-time"})):
        tighter = instance.replace(transfer=instance.transfer.replace(max_leg_s=limit))
        assert rules(tighter, plan) == broken


def test_missions_that_are_too_near_are_noticed(planned: tuple[Instance, adr_opt.Plan]) -> None:
    """A plan whose missions lie closer than the separation breaks it, and no other rule."""
    instance, plan = planned
    routes = [route.legs for route in plan.routes if route.legs]
    flown = sorted(routes, key=lambda legs: legs[0].departure_s)
    rests = [after[0].departure_s - before[-1].end_s for before, after in itertools.pairwise(flown)]
    for apart, broken in ((min(rests), set()), (min(rests) + 1.0, {"separation"})):
        mission = instance.mission.replace(mission_separation_s=apart)
        assert rules(instance.replace(mission=mission), plan) == broken


def test_an_overlapping_mission_within_a_longer_one_is_noticed() -> None:
    """A mission launched during the one before counts from the end of that, not of its own."""
    instance, plan = None, None
    for seed in range(20):
        free = launched(200 + seed, 4, mission__mission_separation_s=None)
        found = adr_opt.solve(free, iterations=1, time_limit=math.inf).plan
        spans = [
            (r.legs[0].departure_s, r.legs[-1].end_s)
            for r in (found.routes if found else ())
            if r.legs
        ]
        overlaps = any(other[0] < one[1] for one, other in itertools.pairwise(sorted(spans)))
        if overlaps:
            instance, plan = free, found
            break
    assert instance is not None
    assert plan is not None
    mission = instance.mission.replace(mission_separation_s=0.0)
    assert rules(instance.replace(mission=mission), plan) == {"separation"}


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"mission__launch_separation_s": 1.0}, "write one of the two"),
        ({"transfer__max_leg_s": 0.0}, "max_leg_s"),
    ],
)
def test_rules_that_contradict_each_other_are_refused(changes: dict, said: str) -> None:
    """Both separations together, and a leg of no time, are refused in a sentence."""
    with pytest.raises(InputError, match=said):
        launched(0, 3, **changes)


def test_a_chaser_in_space_is_not_separated() -> None:
    """Missions are kept apart only where every chaser is launched."""
    instance = launched(0)
    orbit = {"orbit": instance.targets[0].orbit}
    with pytest.raises(InputError, match="starts in space"):
        instance.replace(chasers=(instance.chasers[0], instance.chasers[1].replace(start=orbit)))


def test_other_methods_and_other_instances_are_refused() -> None:
    """Methods that know neither rule say so, and so do instances that are no tour."""
    instance = launched(0)
    with pytest.raises(InputError, match=r"longest leg.*use one of: auto, exact"):
        adr_opt.solve(instance, "greedy-guarded", time_limit=5.0)
    with pytest.raises(InputError, match="takes no start plan"):
        adr_opt.solve(instance, start=[["t0"], [], []], time_limit=5.0)
    with pytest.raises(InputError, match="price does not follow longest leg"):
        price(instance, [["t0"], [], []])
    first, *others = instance.targets
    free = instance.replace(targets=(first.replace(required=False), *others))
    assert tour_obstacle(free) == "'t0' is not required"
    with pytest.raises(InputError, match="'t0' is not required"):
        adr_opt.solve(free, time_limit=5.0)


def test_fields_that_are_not_set_are_not_written() -> None:
    """A file without the two rules has neither field, and survives a round trip with them."""
    text = launched(0, transfer__max_leg_s=None, mission__mission_separation_s=None).to_json()
    assert "max_leg_s" not in text
    assert "separation" not in text
    instance = launched(0)
    assert instance_of(json.loads(instance.to_json())) == instance
    assert json.loads(instance.to_json())["transfer"]["max_leg_s"] == MOST * STEP_S


def test_what_cannot_be_done_in_time_has_no_plan() -> None:
    """A mission too short for its targets ends without a plan, in a note."""
    result = adr_opt.solve(launched(0, steps=3), iterations=1, time_limit=math.inf)
    assert result.plan is None
    assert result.status == "unknown"
    assert any("no tour" in note for note in result.notes)


@pytest.mark.parametrize("seed", range(8))
def test_no_connection_of_a_cell_is_cheaper_than_its_bound(seed: int) -> None:
    """Short legs and drifts that arrive anywhere in a cell cost at least its bound.

    The last ones by free burns between eccentric orbits.
    """
    instance = launched(300 + seed, 4, steps=16)
    instance = freely(instance, seed) if seed > 5 else instance
    connecting, random = ConnectionFinder(instance), np.random.default_rng(seed)
    ends, near, looked = connecting.ends, 0, 0
    for i, j in itertools.permutations(range(instance.first_target, len(instance.names)), 2):
        found = connecting.of_pair(i, j, connecting.planning_resolution_m_s)
        pair = drift_pair.prepare(ends.leaving[i], ends.arriving[j], ends.rule, EPOCH_S)
        for _ in range(30):
            width = float(random.uniform(0.2, 5.0)) * DAY_S
            longest = float(random.uniform(0.3, 10.0)) * DAY_S
            begin = float(random.uniform(0.0, 35.0)) * DAY_S
            bound = cells.least_cost(
                pair, ends.rule, begin, begin + width, longest, cells.START_M_S, cells.TRIES
            )
            of_cell = (found.arrival >= begin) & (found.arrival <= begin + width)
            of_cell &= found.arrival - found.departure <= longest
            listed = found.delta_v[of_cell].min(initial=math.inf)
            drawn = min(
                drift.delta_v(pair, arrival - span, arrival)
                for arrival in np.linspace(begin, begin + width, 7)
                for span in np.linspace(longest / 9, longest, 9)
            )
            assert bound <= min(listed, drawn)
            near += bound > 0.75 * min(listed, drawn)
            looked += 1
    # A bound that is always nothing would hold as well.
    assert near > 0.3 * looked


@pytest.mark.parametrize("seed", range(6))
def test_no_campaign_costs_less_than_the_bound(seed: int) -> None:
    """The least expense of all campaigns, by trying everything, is no less than the bound."""
    instance = launched(400 + seed, 3)
    least = least_expense(instance, APART, MOST)
    found = LeastExpense(Problem(instance))
    for _ in range(3):
        found.advance(math.inf)
        assert found.value <= least
    fixed = instance.chasers[0].priced.fixed
    assert found.value > fixed


@pytest.mark.parametrize("seed", range(4))
def test_cells_are_no_longer_than_a_stay(seed: int) -> None:
    """However short services are, the bound lies below a plan, since cells are as short."""
    instance = launched(450 + seed, 3, mission__service_s=0.15 * STEP_S)
    problem = Problem(instance)
    length = cell_length_s(problem)
    assert length is not None
    assert length <= 0.15 * STEP_S
    with pytest.raises(ValueError, match="no longer than a stay"):
        LeastExpense(problem, STEP_S)
    found = LeastExpense(problem)
    found.advance(math.inf)
    plan = adr_opt.solve(instance, iterations=3, time_limit=math.inf).plan
    assert plan is not None
    assert found.value <= plan.cost
    assert cell_length_s(Problem(launched(450 + seed, 3, mission__service_s=1.0))) is None


def test_exact_states_the_bound_with_its_plan(planned: tuple[Instance, adr_opt.Plan]) -> None:
    """The method exact gives a legal plan with a bound of its cost, which check accepts."""
    instance, plan = planned
    result = adr_opt.solve(instance, "exact", iterations=2, time_limit=math.inf)
    assert result.plan is not None
    assert not check(instance, result.plan)
    assert result.plan.cost_bound is not None
    assert 0.0 < result.plan.cost_bound <= min(plan.cost, result.plan.cost)


@pytest.mark.parametrize("seed", range(6))
def test_heavy_kits_and_a_cost_in_delta_v_are_planned_or_not(seed: int) -> None:
    """Where the cost is ΔV a plan is legal, kits aboard, or there is none, and nothing breaks."""
    instance = launched(500 + seed, 4, objective={"cost": "delta-v"})
    tank = instance.chasers[0].tank.replace(propellant_kg=60.0)
    chasers = tuple(each.replace(tank=tank, kit_mass_kg=150.0) for each in instance.chasers)
    heavy = instance.replace(chasers=chasers)
    result = adr_opt.solve(heavy, iterations=2, time_limit=math.inf)
    assert result.plan is None or not check(heavy, result.plan)
