"""The route engine: its oracle, its orders, and its plans against enumeration."""

from __future__ import annotations

import itertools
import math
import threading

import numpy as np
import pytest
from seeds import over_seeds
from timed_enumeration import best_route
from timed_fields import timed_mission
from toy_roads import roads

import adr_opt
from adr_opt.common.progress import silent
from adr_opt.common.stop import Interrupted, Stop
from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.core.lists import first_at
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.problem.bodies import Target
from adr_opt.problem.chasers import AtStation, Chaser, Tank
from adr_opt.problem.given import of_rows, only
from adr_opt.problem.given_functions import of_breakpoints
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import MissionSettings, Objective
from solvers.planners import timed_routes
from solvers.planners.options import AutoOptions
from solvers.progress.gap import GapTracker
from solvers.routes import orders
from solvers.routes.engine_rounds import EngineRounds
from solvers.routes.route_engine import RouteEngine
from solvers.routes.ways import arrives, leaves, serves, ways_of

Rows = list[tuple[int, int, float, float]]


def drawn(seed: int, targets: int, chasers: int = 1) -> tuple[Instance, Rows]:
    """All targets as early as possible, over drawn connections; body 0 is the start."""
    rng = np.random.default_rng(seed)
    names = ["depot", *(f"t{number}" for number in range(targets))]
    rows: Rows = []
    for i, j in itertools.product(range(targets + 1), range(1, targets + 1)):
        for _ in range(int(rng.integers(0, 9)) if i != j else 0):
            departure, flight = float(rng.integers(0, 40)), float(rng.integers(1, 12))
            rows.append((i, j, departure, departure + flight))
    origin, destination, departs, lands = zip(*rows, strict=True)
    columns = {
        "origin": [names[i] for i in origin],
        "destination": [names[j] for j in destination],
        "departure_s": departs,
        "arrival_s": lands,
        "delta_v_m_s": np.zeros(len(rows)),
    }
    made = roads(
        name=f"drawn-{seed}",
        targets=[Target(name=name, required=True) for name in names[1:]],
        chasers=[
            Chaser(
                name=f"van-{number}", start=AtStation(station="depot"), tank=Tank(delta_v_m_s=1.0)
            )
            for number in range(chasers)
        ],
        mission=MissionSettings(duration_s=100.0, service_s=0.0, refuel_revolutions=0.0),
        objective=Objective(cost="duration"),
    )
    return made.with_given(of_rows(columns, names)), rows


def end_of(rows: Rows, order: tuple[int, ...]) -> float:
    """Earliest end of an order, from all rows."""
    free = 0.0
    for pair in itertools.pairwise((0, *order)):
        free = min((row[3] for row in rows if row[:2] == pair and row[2] >= free), default=math.inf)
    return free


@over_seeds(range(60), gate=3)
def test_ways_say_what_the_rows_say(seed: int) -> None:
    """The earliest end and the latest departure of a pair are those among all of its rows."""
    instance, rows = drawn(seed, 4)
    ways = ways_of(Problem(instance))
    for i, j in itertools.product(range(5), range(1, 5)):
        mine = [row for row in rows if row[:2] == (i, j)]
        for time in np.arange(-0.5, 60.0, 2.5):
            end = min((row[3] for row in mine if row[2] >= time), default=math.inf)
            assert arrives(ways, i, j, time) == end
            latest = max((row[2] for row in mine if row[3] <= time), default=-math.inf)
            assert leaves(ways, i, j, time) == latest


@over_seeds(range(60), gate=3)
def test_who_leaves_at_the_latest_is_in_time(seed: int) -> None:
    """Of functions of time: at the latest time one is in time, and no longer a little later."""
    ways = ways_of(Problem(timed_mission(seed)))
    rng = np.random.default_rng(seed)
    for i, j in itertools.permutations(range(ways.bodies), 2):
        for until in rng.uniform(0.0, 120.0, 8):
            latest = leaves(ways, i, j, until)
            if latest > -math.inf:
                assert arrives(ways, i, j, latest) <= until
            after = latest + 1e-5 if latest > -math.inf else -1.0
            assert arrives(ways, i, j, after) > until


@over_seeds(range(100), gate=6)
def test_times_of_an_order_are_those_of_enumeration(seed: int) -> None:
    """Earliest times are right, and latest times are the last that suffice."""
    instance, rows = drawn(seed, 4)
    ways = ways_of(Problem(instance))
    visited = 1 + np.random.default_rng(seed).permutation(4)
    order = orders.new_order(ways, np.array([5, *visited, 6]), 1)
    orders.time_forth(ways, order, 0, 6, 6)
    for length in range(1, 5):
        assert order.early[visited[length - 1]] == end_of(rows, tuple(visited[:length]))
    end = order.early[6]
    for deadline in (30.0, 45.0, min(end, 100.0)):
        orders.time_back(ways, order, 5, -1, deadline)
        for node in range(5):
            if node:
                assert (order.late[node] >= order.early[node]) == (end <= deadline)


@over_seeds(range(60), gate=3)
def test_the_engine_finds_the_best_of_all_orders(seed: int) -> None:
    """On few targets it ends as early as the best order, or finds no order of all where is none."""
    instance, rows = drawn(seed, 5)
    ends = [end_of(rows, order) for order in itertools.permutations(range(1, 6))]
    engine = RouteEngine(Problem(instance), seed, Interrupted())
    (route,) = engine.anneal(3000)
    if math.isinf(min(ends)):
        assert len(route) < 5
    else:
        assert end_of(rows, route) == min(ends)


@over_seeds(range(60), gate=3)
def test_local_search_is_by_the_engine(seed: int) -> None:
    """Where the engine serves, ``local-search`` plans all targets in time if an order does."""
    instance, rows = drawn(seed, 5)
    instance = instance.replace(objective=Objective())
    possible = any(
        math.isfinite(end_of(rows, order)) for order in itertools.permutations(range(1, 6))
    )
    result = adr_opt.solve(instance, "local-search", time_limit=60.0, iterations=3)
    assert (result.plan is not None) == possible
    assert result.plan is None or adr_opt.check(instance, result.plan) == ()


@over_seeds(range(100), gate=5)
def test_prizes_are_those_of_enumeration(seed: int) -> None:
    """On few targets its plan by functions of time collects what the best of all orders does."""
    instance = timed_mission(seed)
    problem = Problem(instance)
    prizes, _ = best_route(instance)
    if not serves(problem) or len(instance.stations) > 1 or prizes == -math.inf:
        pytest.skip("a tank binds, a station may help on the way, or there is no plan")
    problem.do_without()
    routes = RouteEngine(problem, seed, Interrupted()).anneal(2000)
    found = sum(instance.targets[j - instance.first_target].prize for j in routes[0])
    assert found == pytest.approx(prizes)
    assert problem.missions[0].time(problem.closed(routes)[0]).cost < math.inf


@over_seeds(range(20), gate=2)
def test_several_chasers_share_the_targets(seed: int) -> None:
    """Two chasers do all targets once, no later than one does, and ``check`` finds nothing."""
    instance, _ = drawn(seed, 6, chasers=2)
    result = adr_opt.solve(instance, "auto", time_limit=20.0, iterations=3)
    alone, _ = drawn(seed, 6)
    single = adr_opt.solve(alone, "auto", time_limit=20.0, iterations=3)
    if single.plan is not None:
        assert result.plan is not None
        assert adr_opt.check(instance, result.plan) == ()
        assert result.plan.cost <= single.plan.cost


def doable(mission: Mission) -> set[frozenset[int]]:
    """All sets of targets that a chaser can service in some order."""
    targets = range(mission.rules.first_target, len(mission.names))
    found = set()
    for size in range(len(targets) + 1):
        for order in itertools.permutations(targets, size):
            moves = mission.closed(order)
            flown = mission.time(moves)
            if mission.may_stop(moves) and flown.made == len(moves) and flown.cost < math.inf:
                found.add(frozenset(order))
    return found


@over_seeds(range(100), gate=4)
def test_two_chasers_collect_what_enumeration_does(seed: int) -> None:
    """By functions of time, two chasers collect as much as the best of all pairs of routes."""
    instance = timed_mission(seed)
    (chaser,) = instance.chasers
    both = instance.replace(chasers=(chaser, chaser.replace(name="second")))
    problem = Problem(both)
    if not serves(problem) or len(both.stations) > 1:
        pytest.skip("a tank binds, or a station may help on the way")
    problem.do_without()
    sets = doable(problem.missions[0])
    pairs = [one | other for one in sets for other in sets if not one & other]
    result = adr_opt.solve(both, "auto", time_limit=20.0, iterations=3)
    possible = [each for each in pairs if not problem.lacking(tuple(each))]
    if not possible:
        assert result.plan is None
        return
    assert adr_opt.check(both, result.plan) == ()
    assert result.objective == pytest.approx(
        max(
            sum(instance.targets[j - instance.first_target].prize for j in each)
            for each in possible
        )
    )


def test_functions_of_time_have_no_limit_of_targets_or_chasers() -> None:
    """Two chasers and seventy targets by functions of time have a plan that ``check`` accepts."""
    instance = roaming(70, 2)
    result = adr_opt.solve(instance, "auto", time_limit=60.0, iterations=2, prove=False)
    assert result.plan is not None
    assert adr_opt.check(instance, result.plan) == ()
    assert all(route.legs for route in result.plan.routes)
    again = adr_opt.solve(instance, "auto", time_limit=60.0, iterations=2, jobs=1, prove=False)
    assert again.routes == result.routes


class Countdown(Stop):
    """A limit that falls whenever it is asked, whatever else the processor does."""

    def __init__(self, asked: int) -> None:
        self._left = asked

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        return self.remaining_s() <= 0.0

    def remaining_s(self) -> float:
        """What is left."""
        self._left -= not threading.current_thread().daemon  # those look again and again
        return float(self._left)


def test_a_proof_without_an_end_leaves_time_to_the_engine() -> None:
    """By functions of time to twenty targets, rounds go on where the proof has used up its part."""
    problem = Problem(roaming(20, 1, 250.0))
    problem.do_without()
    first = EngineRounds(problem, GapTracker(problem, silent), 0, Interrupted(), 1)
    first.at_first()
    stop = Countdown(26)
    result = timed_routes.plan(
        "auto", problem, seed=0, stop=stop, progress=silent, start=None, options=AutoOptions(jobs=1)
    )
    assert result.counters["optimistic"] > 0
    assert result.status == "feasible"
    assert result.counters["rounds"] > first.counters["rounds"] > 0


def roaming(targets: int, chasers: int, open_s: float = 90.0) -> Instance:
    """A drawn mission by functions of time, with windows."""
    rng = np.random.default_rng(0)
    names = ["depot", *(f"t{number}" for number in range(targets))]
    points = rng.uniform(0.0, 100.0, (targets + 1, 2))
    pairs = []
    for i, j in itertools.permutations(range(targets + 1), 2):
        way = 1.0 + float(np.hypot(*(points[i] - points[j])))
        pairs.append((names[i], names[j], [[0.0, way], [300.0, 300.0 + 1.5 * way]], 0.0))
    made = roads(
        name="roaming",
        targets=[
            Target(
                name=name, prize=float(rng.integers(1, 9)), window_s=(float(opens), opens + open_s)
            )
            for name, opens in zip(names[1:], rng.integers(0, 200, targets).tolist(), strict=True)
        ],
        chasers=[
            Chaser(
                name=f"van-{number}",
                start=AtStation(station="depot"),
                end=AtStation(station="depot"),
                tank=Tank(delta_v_m_s=1.0),
            )
            for number in range(chasers)
        ],
        mission=MissionSettings(duration_s=300.0, service_s=2.0, refuel_revolutions=0.0),
    )
    return made.with_given(only(of_breakpoints(pairs, names)))


@kernel
def _first_at(numbers, low, high, least):
    """The same for Python."""
    return first_at(numbers, low, high, least)


def test_the_first_number_of_at_least_a_value_is_found_by_a_guess() -> None:
    """Between any two places of ascending numbers it is that of NumPy's search."""
    rng = np.random.default_rng(0)
    for _ in range(3000):
        numbers = np.sort(rng.integers(0, 1 + rng.integers(1, 400), int(rng.integers(1, 80))))
        numbers = numbers.astype(float) ** rng.choice([1.0, 3.0, 0.2])
        low, high = sorted(rng.integers(0, numbers.size + 1, 2).tolist())
        least = float(rng.choice([rng.choice(numbers), rng.uniform(-1.0, 1.1 * numbers.max())]))
        expected = low + int(np.searchsorted(numbers[low:high], least))
        assert _first_at(numbers, low, high, least) == expected
