"""Two properties hold the whole, for everything that is registered.

For every planner, ``check`` finds nothing and the objective is at most every bound; on every small
instance, brute force lies between the best planner and the tightest bound. A planner or bound that
is installed is tested by being installed.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import fields
from functools import cache
from typing import Any

import calling
import numpy as np
import pytest
from brute_force import brute_force
from hand_made import OPTIMAL_PLAN, OPTIMUM, hand_made
from random_rules import DAY_S, drifting_field
from seeds import first_of
from varied_fields import varied

import adr_opt
from adr_opt.common.errors import MissingExtra
from adr_opt.common.stop import Interrupted, MaxIterations, MaxRuntime, Stop
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result
from adr_opt.problem.instance import Instance
from adr_opt.run import front
from adr_opt.run.methods import BOUNDS, PLANNERS, get, names, options_of, spec

ITERATIONS = 3
EFFORT = 0.4
ON_TIME_S = 3.0
"""Processor time that a method may work on for: one step that cannot ask."""

WAITED_S = 60.0
"""However busy the machine is, a method that takes longer by the clock waits for something."""


SMALL: dict[str, Callable[[], Instance]] = {
    "hand-made": hand_made,
    "tiny": lambda: adr_opt.generate("tiny", 1),
    "zones": lambda: varied(2, zones=3),
    "unequal": lambda: varied(3, prizes=(3.0, 1.0, 2.0)),
    "fractional": lambda: varied(4, prizes=(0.7, 2.3, 0.0, 1.1), zones=2),
    "refuelling": lambda: varied(5, prizes=(1.5, 1.0), days=2.5, delta_v_m_s=600.0, targets=5),
    "drifting": lambda: drifting_field(np.random.default_rng(1), 120 * DAY_S, 4),
}
EDGES: dict[str, Callable[[], Instance]] = {
    "no targets": lambda: adr_opt.generate("tiny", 0, targets=0),
    "one target": lambda: adr_opt.generate("tiny", 0, targets=1),
    "no time": lambda: varied(0, days=0.0),
    "no delta-v": lambda: varied(0, delta_v_m_s=0.0),
    "no prizes": lambda: varied(0, prizes=(0.0,)),
    "no targets, J2": lambda: drifting_field(np.random.default_rng(2), 60 * DAY_S, 0),
    "no time, J2": lambda: varied(0, days=0.0).replace(dynamics="j2"),
    "limits": lambda: varied(0, prizes=(1e12, 1.0, 3e11), delta_v_m_s=1e9, targets=4),
}
INSTANCES = {
    **SMALL,
    **EDGES,
    "nominal": lambda: adr_opt.generate("nominal", 0, targets=25),
    "whole": lambda: adr_opt.generate("nominal", 0),
}
FEW = ("fractional", "drifting", "nominal")
WHOLE = pytest.param("whole", marks=pytest.mark.slow)

planners = pytest.mark.parametrize("method", names(PLANNERS))
bounds = pytest.mark.parametrize("method", names(BOUNDS))
small = pytest.mark.parametrize("name", SMALL)
everywhere = pytest.mark.parametrize("name", [*SMALL, *EDGES, "nominal", WHOLE])


@cache
def mission(name: str) -> Mission:
    """The mission of a name, its timetable built."""
    made = Mission(INSTANCES[name](), threads=1)
    assert made.rules.prize.size == len(made.names)
    return made


@cache
def optimum(name: str) -> tuple[float, tuple[int, ...]]:
    """The best objective of a small instance, and a sequence that has it."""
    objective, _, sequence = brute_force(mission(name))
    return objective, sequence


class Heard:
    """A progress that writes down what it hears."""

    def __init__(self) -> None:
        self.incumbents: list[float] = []
        self.bounds: list[float] = []

    def __call__(self, incumbent: float, bound: float) -> None:
        """Write it down."""
        self.incumbents.append(incumbent)
        self.bounds.append(bound)


def efforts(function: Callable[..., Any]) -> dict[str, Any]:
    """The option that limits one iteration, for methods whose iterations may be long."""
    return (
        {"effort": EFFORT}
        if "effort" in {each.name for each in fields(options_of(function))}
        else {}
    )


def call(group: str, method: str, name: str, stop: Stop, **arguments: Any) -> Result:
    """Run a method on one core; the test is skipped if a package that it needs is missing."""
    try:
        function = get(method, group)
        if spec(method, group).uses_cores:
            arguments.setdefault("jobs", 1)
        arguments |= efforts(function)
        return calling.call(function, mission(name), stop=stop, **arguments)
    except MissingExtra as missing:
        pytest.skip(str(missing))


def work() -> Stop:
    """The same little work on any machine."""
    return MaxIterations(ITERATIONS)


@cache
def ran(group: str, method: str, name: str) -> tuple[Result, Heard]:
    """What a little work gives, and what was heard on the way."""
    heard = Heard()
    return call(group, method, name, work(), progress=heard), heard


def limited(group: str, method: str, name: str, margin: float = 0.0) -> Result:
    """The same little work by the front door, without any limit of time."""
    try:
        wanted = front.RunOptions(
            math.inf, iterations=ITERATIONS, margin=margin, options=efforts(get(method, group))
        )
        return front.run(group, mission(name), method, wanted)
    except MissingExtra as missing:
        pytest.skip(str(missing))


@contextmanager
def on_time(limit_s: float = 0.0) -> Iterator[None]:
    """What is done ends soon after a limit; what other processes do meanwhile is not counted."""
    began, worked = time.perf_counter(), time.process_time()
    yield
    assert time.process_time() - worked < 2.0 * limit_s + ON_TIME_S
    assert time.perf_counter() - began < limit_s + WAITED_S


def every(group: str, name: str) -> dict[str, Result]:
    """The results of all methods of a group that can run here."""
    results = {}
    for method in names(group):
        try:
            results[method] = ran(group, method, name)[0]
        except pytest.skip.Exception:
            continue
    return results


def assert_legal(result: Result, name: str) -> None:
    """The plan is one that ``check`` has nothing against."""
    assert result.plan is not None
    assert adr_opt.check(mission(name).instance, result.plan) == ()


def assert_sound(result: Result, name: str) -> None:
    """Plan, objective, bound, gap and status of a result say the same."""
    total = mission(name).total_prize
    best_bound = min(result.upper_bound, total)
    assert not math.isnan(result.upper_bound)
    if result.plan is None:
        assert result.sequence is None
        assert result.objective == -math.inf
        assert result.status == "unknown"
        return
    assert_legal(result, name)
    collected = sum(mission(name).rules.prize[j] for j in result.sequence)
    assert result.plan.objective == result.objective == pytest.approx(collected)
    assert result.objective <= best_bound * (1.0 + 1e-12)
    met = result.objective >= best_bound - (0.5 * mission(name).prize_step or 1e-11 * total)
    assert result.status == result.plan.status == ("optimal" if met else "feasible")
    if math.isfinite(result.upper_bound):
        assert result.plan.upper_bound == result.upper_bound
        assert result.plan.gap == result.gap >= -1e-9
    else:
        assert result.plan.upper_bound is None
        assert result.plan.gap is None


def test_everything_expected_is_registered() -> None:
    """The tests below are about all methods: the registry is not empty, and knows the default."""
    assert {"auto", "beam", "exact", "greedy", "greedy-guarded", "local-search"} <= set(names())
    assert {"exact", "lagrangian"} <= set(names(BOUNDS))


@everywhere
@planners
def test_planner_is_sound(method: str, name: str) -> None:
    """Every planner returns a plan without violations, and a certificate that agrees with it."""
    result, _ = ran(PLANNERS, method, name)
    assert result.method == method
    assert result.plan is not None
    assert_sound(result, name)


@everywhere
@bounds
def test_bound_is_sound(method: str, name: str) -> None:
    """Every bound is finite, at most the sum of all prizes, and agrees with its plan if any."""
    result, _ = ran(BOUNDS, method, name)
    assert result.upper_bound <= mission(name).total_prize * (1.0 + 1e-6)
    assert_sound(result, name)


@everywhere
@planners
def test_objective_is_at_most_every_bound(method: str, name: str) -> None:
    """No planner collects more than any bound allows."""
    objective = ran(PLANNERS, method, name)[0].objective
    for bound, result in every(BOUNDS, name).items():
        assert objective <= result.upper_bound * (1.0 + 1e-6), f"{method} beats {bound}"


@small
def test_brute_force_lies_between(name: str) -> None:
    """Brute force lies between the best planner and the tightest bound."""
    best, _ = optimum(name)
    planned = every(PLANNERS, name)
    assert max(result.objective for result in planned.values()) <= best + 1e-9
    proven = [*planned.values(), *every(BOUNDS, name).values()]
    assert min(result.upper_bound for result in proven) >= best - 1e-6


@small
def test_best_planner_meets_brute_force(name: str) -> None:
    """The best planner finds, with little work, what brute force finds."""
    best = max(result.objective for result in every(PLANNERS, name).values())
    assert best == pytest.approx(optimum(name)[0])


@pytest.mark.parametrize("method", ["auto", "beam", "exact", "local-search", "mip", "ortools"])
def test_the_worked_out_optimum_is_found(method: str) -> None:
    """Of the hand-made instance the only optimal plan is found, and proven by those that prove."""
    result, _ = ran(PLANNERS, method, "hand-made")
    assert (result.sequence, result.objective) == (OPTIMAL_PLAN, OPTIMUM)
    if method in ("auto", "exact", "mip"):
        assert (result.status, result.upper_bound) == ("optimal", pytest.approx(OPTIMUM))


@pytest.mark.parametrize("name", ["fractional", "refuelling", "nominal", WHOLE])
@planners
def test_same_seed_same_plan(method: str, name: str) -> None:
    """The same seed and the same number of iterations give the same plan and the same bound.

    However many cores there are.
    """
    first, again = ran(PLANNERS, method, name)[0], limited(PLANNERS, method, name)
    assert again.sequence == first.sequence
    assert again.upper_bound == first.upper_bound


@pytest.mark.parametrize("name", ["fractional", "refuelling", "nominal", WHOLE])
@bounds
def test_same_seed_same_bound(method: str, name: str) -> None:
    """The same number of iterations gives the same bound, however many cores there are."""
    first, again = ran(BOUNDS, method, name)[0], limited(BOUNDS, method, name)
    assert again.upper_bound == first.upper_bound


@pytest.mark.parametrize("name", [*SMALL, "nominal"])
@planners
def test_planner_tells_its_progress(method: str, name: str) -> None:
    """Incumbents rise and bounds fall as they are told, and both end at the result."""
    result, heard = ran(PLANNERS, method, name)
    assert heard.incumbents == sorted(heard.incumbents)
    assert heard.bounds == sorted(heard.bounds, reverse=True)
    assert heard.incumbents
    assert heard.incumbents[-1] == pytest.approx(result.objective)
    # Where all is collected, that alone is a bound, and no planner has to tell it.
    all_collected = result.plan is not None and not result.plan.unvisited
    if math.isfinite(result.upper_bound) and not (
        all_collected and heard.bounds[-1:] == [math.inf]
    ):
        assert heard.bounds[-1] == pytest.approx(result.upper_bound)


@pytest.mark.parametrize("name", [*SMALL, "nominal"])
@bounds
def test_bound_tells_its_progress(method: str, name: str) -> None:
    """A bound falls as it is told, never below the incumbent, and ends at the result."""
    result, heard = ran(BOUNDS, method, name)
    assert heard.bounds == sorted(heard.bounds, reverse=True)
    assert heard.bounds[-1] == pytest.approx(result.upper_bound)
    for incumbent, bound in zip(heard.incumbents, heard.bounds, strict=True):
        assert incumbent <= bound + 1e-6


@small
@bounds
def test_bound_with_the_best_plan_to_start_from(method: str, name: str) -> None:
    """A known optimal plan never brings a bound below the optimum, and may prove it optimal."""
    if not spec(method, BOUNDS).starts:
        pytest.skip(f"{method} takes no start plan")
    best, sequence = optimum(name)
    result = call(BOUNDS, method, name, work(), start=sequence)
    assert result.upper_bound >= best - 1e-6
    if result.upper_bound <= best + 1e-6:
        assert result.status == "optimal"
    assert_sound(result, name)


@small
@planners
def test_start_plan_is_never_lost(method: str, name: str) -> None:
    """A planner that begins from an optimal plan returns one as good, however little it works."""
    if not spec(method).starts:
        pytest.skip(f"{method} takes no start plan")
    best, sequence = optimum(name)
    result = call(PLANNERS, method, name, MaxIterations(1), start=sequence)
    assert result.objective == pytest.approx(best)
    assert_legal(result, name)


MARGIN = 0.25


@cache
def with_less(name: str) -> float:
    """The best objective of a small instance whose tank is smaller by the margin."""
    instance = INSTANCES[name]()
    less = (1.0 - MARGIN) * instance.chaser.tank.delta_v_m_s
    return brute_force(Mission(instance.with_limits(delta_v_m_s=less), threads=1))[0]


def assert_kept_back(result: Result, name: str) -> None:
    """The plan is legal on the whole instance, leaves the share in each tank, and claims no bound.

    Nor is it called optimal, unless it collects all there is.
    """
    assert result.plan is not None
    assert_legal(result, name)
    instance = mission(name).instance
    budget = instance.chaser.tank.delta_v_m_s
    lowest = min((leg.delta_v_left_m_s for leg in result.plan.legs), default=budget)
    assert lowest >= MARGIN * budget - 1e-6
    for leg in result.plan.legs:
        if leg.destination in instance.station_names:
            assert leg.delta_v_left_m_s == pytest.approx(budget)
    assert result.plan.upper_bound is None
    assert result.plan.gap is None
    everything = result.plan.objective >= mission(name).total_prize - 1e-9
    assert result.plan.status == ("optimal" if everything else "feasible")
    assert any("25 % of each tank" in note for note in result.plan.notes)


@pytest.mark.parametrize("name", ["hand-made", "fractional", "refuelling"])
@planners
def test_planner_keeps_the_margin(method: str, name: str) -> None:
    """Every planner keeps the share of each tank, and none is better than brute force with it."""
    result = limited(PLANNERS, method, name, MARGIN)
    assert_kept_back(result, name)
    assert result.objective <= with_less(name) + 1e-9
    assert result.upper_bound >= with_less(name) - 1e-6


@pytest.mark.parametrize("name", ["hand-made", "fractional", "refuelling"])
@bounds
def test_bound_knows_the_margin(method: str, name: str) -> None:
    """A bound with a margin is one of plans that keep it, and says so; its plan claims nothing."""
    result = limited(BOUNDS, method, name, MARGIN)
    assert result.upper_bound >= with_less(name) - 1e-6
    assert any("no plan that keeps back 25 % of each tank" in note for note in result.notes)
    if result.plan is not None:
        assert_kept_back(result, name)


def test_the_margin_costs_something_somewhere() -> None:
    """The tests above could fail: with the margin the optimum is smaller, and the bounds see it."""
    assert with_less("refuelling") < optimum("refuelling")[0]
    proven = front.bound(mission("refuelling"), "exact", time_limit=60.0, margin=MARGIN)
    assert with_less("refuelling") <= proven.upper_bound < optimum("refuelling")[0]


@pytest.mark.parametrize("margin", [-0.1, 1.0, float("nan"), float("inf")])
def test_a_margin_that_is_no_share_is_refused(margin: float) -> None:
    """A margin is a share of the tank, from 0 to below 1."""
    with pytest.raises(adr_opt.InputError, match=r"margin = .*: must be a share of the tank"):
        adr_opt.solve(mission("tiny"), "greedy", margin=margin)


def interrupted() -> Interrupted:
    """A stop that says enough whenever it is asked."""
    stop = Interrupted()
    stop.interrupt()
    return stop


@pytest.mark.parametrize("name", ["fractional", "nominal"])
@planners
def test_planner_interrupted_at_once(method: str, name: str) -> None:
    """A planner that is to stop at once returns at once, with a legal plan."""
    ran(PLANNERS, method, name)  # compiled and imported, the timetable is there
    with on_time():
        result = call(PLANNERS, method, name, interrupted())
    assert_sound(result, name)


@pytest.mark.parametrize(
    "name", first_of(sorted([*SMALL, "nominal"], key=lambda name: name not in FEW), gate=len(FEW))
)
@pytest.mark.parametrize("method", sorted(set(names(PLANNERS)) - {"greedy"}))
def test_out_of_time_a_planner_is_as_good_as_guarded_greedy(method: str, name: str) -> None:
    """Through the front door, no time at all still gives the guarded greedy plan, and at once.

    The published greedy stays as it is.
    """
    ran(PLANNERS, method, name)
    least = call(PLANNERS, "greedy-guarded", name, MaxIterations(1))
    heard = Heard()
    with on_time():
        result = adr_opt.solve(mission(name), method, time_limit=1e-9, progress=heard)
    assert result.method == method
    assert result.objective >= least.objective
    assert heard.incumbents[-1] == pytest.approx(result.objective)
    assert_sound(result, name)


def test_the_published_greedy_stays_as_it_is() -> None:
    """Out of time it returns its own plan, although guarded greedy has a better one."""
    result = adr_opt.solve(mission("nominal"), "greedy", time_limit=1e-9)
    own = call(PLANNERS, "greedy", "nominal", MaxIterations(1))
    assert result.sequence == own.sequence
    assert own.objective < call(PLANNERS, "greedy-guarded", "nominal", MaxIterations(1)).objective


def test_a_plan_that_is_not_the_planners_own_says_so() -> None:
    """Out of time, the note names the planner whose plan it is; in time there is no such note."""
    late = adr_opt.solve(mission("nominal"), "mcts", time_limit=1e-9)
    assert "mcts ran out of time: the plan is that of greedy-guarded" in late.notes
    assert late.plan is not None
    assert late.plan.notes == late.notes
    played = adr_opt.solve(mission("nominal"), "mcts", time_limit=60.0)
    assert not any("ran out of time" in note for note in played.notes)
    assert played.objective < late.objective


@pytest.mark.parametrize("name", ["fractional", "nominal"])
@bounds
def test_bound_interrupted_at_once(method: str, name: str) -> None:
    """A bound that is to stop at once returns at once, with a bound that is valid."""
    ran(BOUNDS, method, name)
    with on_time():
        result = call(BOUNDS, method, name, interrupted())
    known = max(found.objective for found in every(PLANNERS, name).values())
    assert known - 1e-6 <= result.upper_bound <= mission(name).total_prize + 1e-6


@pytest.mark.parametrize("group", [PLANNERS, BOUNDS])
def test_time_limit_is_respected(group: str) -> None:
    """Every method ends on time on a nominal field, and what it returns is sound."""
    for method in every(group, "nominal"):
        limit_s = 0.7
        with on_time(limit_s):
            result = call(group, method, "nominal", MaxRuntime(limit_s))
        assert_sound(result, "nominal")
