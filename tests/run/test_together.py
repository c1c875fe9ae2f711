"""`solve --bound`: a planner and a bound side by side."""

from __future__ import annotations

import json
import math
import threading
import time
from collections.abc import Callable
from importlib.metadata import EntryPoint
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from conftest import Cli

import adr_opt
from adr_opt.common.progress import Progress, silent
from adr_opt.common.stop import AnyOf, Interrupted, MaxIterations, MaxRuntime, Stop
from adr_opt.mission.certified import certify
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem, problem_of
from adr_opt.mission.result import Result
from adr_opt.run import front, methods
from adr_opt.run.side_by_side import InvalidBound, Meeting, Seat, together

LONG_S = 300.0
"""A limit that no test may reach."""

NEVER = MaxRuntime(math.inf)


def planning(sequence: tuple[int, ...] | None, *, waits: bool = True, fails: bool = False) -> Any:
    """A planner that has a plan from the beginning and asks until it is told to stop."""

    def method(mission: Any, stop: Stop, progress: Progress) -> Result:
        mission = problem_of(mission).missions[0]
        value = -math.inf if sequence is None else mission.time(sequence).objective
        progress(value, math.inf)
        asked = 0
        while waits:
            asked += 1
            if fails and asked > 3:
                raise ZeroDivisionError("the planner failed")
            if stop(value, math.inf):
                break
            time.sleep(1e-3)
        counters = {"asked": asked}
        return certify(mission, "plans", sequence, seed=0, runtime_s=0.0, counters=counters)

    return method


def proving(
    *bounds: float, plan: tuple[int, ...] | None = None, waits: bool = True, fails: bool = False
) -> Any:
    """A bound that proves one value after the other, then asks until it is told to stop."""

    def method(mission: Any, stop: Stop, progress: Progress) -> Result:
        best, asked = math.inf, 0
        for bound in bounds:
            best = min(best, bound)
            progress(-math.inf, best)
            asked += 1
            if stop(-math.inf, best):
                break
        else:
            if fails:
                raise LookupError("the bound failed")
            while waits:
                asked += 1
                if stop(-math.inf, best):
                    break
                time.sleep(1e-3)
        return certify(
            problem_of(mission).missions[0],
            "proves",
            plan,
            seed=0,
            runtime_s=0.0,
            upper_bound=best,
            counters={"asked": asked},
            notes=["rounded down"],
        )

    return method


def fake_planner(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: tuple[int, ...] | None = None,
    jobs: int = 1,
) -> Result:
    """One target, or the start plan; asks until it is told to stop."""
    result = planning(start or (1,))(mission, stop, progress)
    return certify(
        mission,
        "fake",
        result.sequence,
        seed=seed,
        runtime_s=0.0,
        counters={**result.counters, "jobs": jobs},
    )


def fake_bound(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: tuple[int, ...] | None = None,
    jobs: int = 0,
) -> Result:
    """The number of targets less one, or what the start plan collects."""
    value = mission.total_prize - 1.0 if start is None else mission.time(start).objective
    result = proving(value)(mission, stop, progress)
    return certify(
        mission,
        "fake-bound",
        None,
        seed=seed,
        runtime_s=0.0,
        upper_bound=result.upper_bound,
        counters={**result.counters, "jobs": jobs, "start": len(start or ())},
    )


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The fakes above and the greedy planners, as if they were installed."""
    found = {
        methods.PLANNERS: {
            "greedy": "solvers.planners.greedy:greedy",
            "greedy-guarded": "solvers.planners.greedy:greedy_guarded",
            "fake": f"{__name__}:fake_planner",
        },
        methods.BOUNDS: {"fake-bound": f"{__name__}:fake_bound"},
    }
    monkeypatch.setattr(
        methods,
        "entry_points",
        lambda group: [EntryPoint(name, value, group) for name, value in found[group].items()],
    )


@pytest.fixture(scope="module")
def mission() -> Problem:
    return Problem(adr_opt.generate("tiny", 0))


def test_both_stop_when_they_meet(mission: Problem) -> None:
    """Incumbent 1 and bound 1 end both at once: optimal, gap 0, and `check` accepts the plan."""
    began = time.monotonic()
    result = together(mission, planning((1,)), proving(5.0, 1.0), MaxRuntime(LONG_S), silent)
    assert time.monotonic() - began < LONG_S / 2
    assert result.plan is not None
    assert (result.status, result.objective, result.upper_bound, result.gap) == (
        "optimal",
        1.0,
        1.0,
        0.0,
    )
    assert (result.plan.status, result.plan.upper_bound, result.plan.gap) == ("optimal", 1.0, 0.0)
    assert adr_opt.check(mission.instance, result.plan) == ()


def test_the_result_joins_both(mission: Problem) -> None:
    """Plan of the planner, bound of the bound, counters with prefixes, notes, runtime."""
    stop = MaxRuntime(0.2)
    result = together(mission, planning((1,)), proving(4.0), stop, silent)
    assert result.plan is not None
    assert result.method == result.plan.method == "plans"
    assert (result.status, result.upper_bound, result.gap) == ("feasible", 4.0, 0.75)
    assert result.plan.upper_bound == 4.0
    assert set(result.counters) == {"planner.asked", "bound.asked"}
    assert result.notes == ("rounded down", "upper bound by proves") == result.plan.notes
    assert 0.15 < result.runtime_s < LONG_S
    assert adr_opt.check(mission.instance, result.plan) == ()


def test_each_side_asks_with_what_the_other_knows(mission: Problem) -> None:
    """The stop hears of incumbent and bound together, from both threads, one at a time."""
    asked: dict[str, list[tuple[float, float]]] = {}
    inside = threading.Lock()

    class Recording:
        def __call__(self, incumbent: float, bound: float) -> bool:
            assert inside.acquire(blocking=False), "two at once"
            asked.setdefault(threading.current_thread().name, []).append((incumbent, bound))
            time.sleep(1e-4)
            inside.release()
            return sum(pairs[-1] == (1.0, 4.0) for pairs in asked.values()) == 2

        def remaining_s(self) -> float:
            return math.inf

    told: list[tuple[float, float]] = []
    together(
        mission, planning((1,)), proving(5.0, 4.0), Recording(), lambda *pair: told.append(pair)
    )
    assert len(asked) == 2
    for pairs in asked.values():
        assert pairs[-1] == (1.0, 4.0)
    assert told[0] == (-math.inf, mission.total_prize)
    assert told[-1] == (1.0, 4.0)
    for (worse, looser), (better, tighter) in pairwise(told):
        assert better >= worse
        assert tighter <= looser
        assert (better, tighter) != (worse, looser)


def test_a_planner_that_ends_leaves_the_bound_running(mission: Problem) -> None:
    """After a quick planner the bound goes on to its limit, and its last bound counts."""
    limits = (MaxIterations(3), MaxIterations(50))
    method = proving(*(7.0 - 0.1 * step for step in range(30)))
    result = together(mission, planning((1,), waits=False), method, NEVER, silent, limits)
    assert result.upper_bound == min(4.1, mission.total_prize)
    assert result.counters == {"planner.asked": 0, "bound.asked": 51}


def test_a_bound_that_ends_leaves_the_planner_running(mission: Problem) -> None:
    """After a quick bound the planner goes on to its limit."""
    limits = (MaxIterations(50), MaxIterations(3))
    result = together(mission, planning((1,)), proving(4.0, waits=False), NEVER, silent, limits)
    assert result.counters == {"planner.asked": 51, "bound.asked": 1}
    assert result.upper_bound == 4.0


@pytest.mark.parametrize(
    ("plans", "proves", "expected"),
    [
        (planning((1,), fails=True), proving(4.0), ZeroDivisionError),
        (planning((1,)), proving(4.0, fails=True), LookupError),
        (planning((1,), waits=False), proving(4.0, fails=True), LookupError),
        (planning((1,), fails=True), proving(4.0, waits=False), ZeroDivisionError),
    ],
)
def test_a_failure_ends_both_and_is_raised(
    mission: Problem, plans: Any, proves: Any, expected: type[Exception]
) -> None:
    """A failure of one side stops the other and reaches the caller; no thread stays behind."""
    before, began = threading.active_count(), time.monotonic()
    with pytest.raises(expected):
        together(mission, plans, proves, MaxRuntime(LONG_S), silent)
    assert time.monotonic() - began < LONG_S / 2
    assert threading.active_count() == before


def test_an_interrupt_stops_both(mission: Problem) -> None:
    """Ctrl-C on the command line interrupts the stop, and both sides end with what they have."""
    stop = Interrupted()

    def press(incumbent: float, bound: float) -> None:
        if (incumbent, bound) == (1.0, 4.0):
            stop.interrupt()

    result = together(mission, planning((1,)), proving(4.0), AnyOf(MaxRuntime(LONG_S), stop), press)
    assert result.runtime_s < LONG_S / 2
    assert (result.objective, result.upper_bound) == (1.0, 4.0)


def test_a_keyboard_interrupt_of_the_caller_stops_the_bound(mission: Problem) -> None:
    """KeyboardInterrupt, as in a notebook, leaves no thread behind."""

    def pressed(mission: Problem, stop: Stop, progress: Progress) -> Result:
        raise KeyboardInterrupt

    before = threading.active_count()
    with pytest.raises(KeyboardInterrupt):
        together(mission, pressed, proving(4.0), MaxRuntime(LONG_S), silent)
    assert threading.active_count() == before


def test_a_better_plan_of_the_bound_is_kept(mission: Problem) -> None:
    """Where the bound itself finds a better plan, that one is returned, and it is said."""
    guarded = adr_opt.solve(mission, "greedy-guarded").sequence
    assert guarded is not None
    assert len(guarded) > 1
    method = proving(mission.total_prize, plan=guarded, waits=False)
    result = together(mission, planning((1,), waits=False), method, NEVER, silent)
    assert result.sequence == guarded
    assert result.method == "proves"
    assert "proves found a better plan than plans" in result.notes


def test_without_a_plan_the_bound_is_kept(mission: Problem) -> None:
    """A planner that finds nothing does not lose what the bound proved."""
    result = together(
        mission, planning(None, waits=False), proving(4.0, waits=False), NEVER, silent
    )
    assert result.plan is None
    assert (result.upper_bound, result.status) == (4.0, "unknown")


def test_a_bound_below_a_legal_plan_is_an_alarm(mission: Problem) -> None:
    """A plan that is worth more than a claimed bound is never returned as proven."""
    with pytest.raises(InvalidBound, match=r"objective 1\.0 exceeds the bound 0\.5 .*'proves'"):
        together(mission, planning((1,)), proving(0.5), MaxRuntime(LONG_S), silent)


def test_rounding_makes_no_negative_gap(mission: Problem) -> None:
    """A bound below the objective by rounding only meets it exactly."""
    method = proving(1.0 - 1e-9)
    result = together(mission, planning((1,)), method, MaxRuntime(LONG_S), silent)
    assert (result.upper_bound, result.gap, result.status) == (1.0, 0.0, "optimal")


def test_remaining_time_is_that_of_the_nearest_limit() -> None:
    """Parts that cannot ask get the shared limit, their own, and nothing once it is enough."""
    meeting = Meeting(MaxRuntime(100.0), silent)
    seat = Seat(meeting, MaxRuntime(10.0))
    assert 5.0 < seat.remaining_s() < 10.0
    assert 50.0 < Seat(meeting).remaining_s() < 100.0
    assert not seat(1.0, 2.0)
    assert Seat(meeting)(2.0, math.inf)
    assert seat(1.0, 2.0)
    assert seat.remaining_s() == Seat(meeting).remaining_s() == 0.0


def test_an_own_limit_ends_nobody_else() -> None:
    """Iterations are counted for each side by itself."""
    meeting = Meeting(NEVER, silent)
    one, other = Seat(meeting, MaxIterations(1)), Seat(meeting, MaxIterations(3))
    assert [one(0.0, 9.0), one(0.0, 9.0)] == [False, True]
    assert [other(0.0, 9.0) for _ in range(4)] == [False, False, False, True]


def test_progress_may_ask() -> None:
    """A progress that asks for more in turn does not lock itself out."""
    seats: list[Callable[[float, float], bool]] = []
    answers: list[bool] = []
    meeting = Meeting(NEVER, lambda *pair: answers.append(seats[0](*pair)))
    seats.append(Seat(meeting))
    meeting.hear(1.0, 2.0)
    assert answers == [False]


@pytest.mark.usefixtures("installed")
def test_iterations_make_it_reproducible() -> None:
    """With iterations each side does its own share: twice the same result."""
    instance = adr_opt.generate("tiny", 0)
    first, second = (
        front.solve(instance, "fake", bound="fake-bound", iterations=20, time_limit=LONG_S)
        for _ in range(2)
    )
    assert first.counters == second.counters
    assert first.counters["planner.asked"] == first.counters["bound.asked"] == 21
    assert (first.sequence, first.upper_bound, first.status) == (
        second.sequence,
        second.upper_bound,
        second.status,
    )


@pytest.mark.usefixtures("installed")
def test_a_time_limit_too_short_still_gives_a_valid_bound() -> None:
    """A limit that passes before anything was done leaves plan and a valid bound."""
    instance = adr_opt.generate("tiny", 0)
    result = front.solve(instance, "greedy-guarded", bound="fake-bound", time_limit=1e-6)
    assert result.plan is not None
    assert result.objective <= result.upper_bound <= len(instance.targets)
    assert adr_opt.check(instance, result.plan) == ()


@pytest.mark.usefixtures("installed")
def test_start_and_jobs_reach_whoever_takes_them() -> None:
    """A start plan and a number of jobs go to the planner and to the bound, as far as they fit."""
    instance = adr_opt.generate("tiny", 0)
    known = front.solve(instance, "greedy-guarded").sequence
    assert known is not None
    result = front.solve(instance, "fake", bound="fake-bound", start=known, jobs=2)
    assert result.sequence == known
    assert result.status == "optimal"  # the fake bound is what the start plan collects
    assert result.counters["bound.start"] == len(known) > 1
    assert result.counters["planner.jobs"] == result.counters["bound.jobs"] == 2
    alone = front.solve(instance, "greedy", bound="fake-bound", jobs=2, time_limit=0.05)
    assert alone.counters["bound.jobs"] == 2
    with pytest.raises(adr_opt.InputError, match="uses one core"):
        front.solve(instance, "greedy", jobs=2)
    with pytest.raises(adr_opt.InputError, match="takes no start plan"):
        front.solve(instance, "greedy", bound="fake-bound", start=(1,))
    with pytest.raises(adr_opt.InputError, match=r"start plan: leg 2 goes .* to itself"):
        front.solve(instance, "fake", bound="fake-bound", start=(1, 1))
    with pytest.raises(adr_opt.InputError, match="'magic' is unknown"):
        front.solve(instance, "fake", bound="magic")


@pytest.mark.usefixtures("installed")
def test_solve_bound_on_the_command_line(cli: Cli, tiny_file: Path) -> None:
    """`solve --bound --json` has bound, gap and status, and `check` accepts the plan."""
    call = ("solve", tiny_file, "--method", "greedy-guarded", "--bound", "fake-bound")
    outcome = cli(*call, "--time-limit", "0.3", "--json", "--out", "plan.json")
    assert outcome.status == 0
    content = json.loads(outcome.out)
    expected = len(adr_opt.load(tiny_file).targets) - 1
    assert content["upper_bound"] == expected
    assert content["gap"] == pytest.approx((expected - content["objective"]) / expected)
    assert content["status"] == "feasible" if content["gap"] else "optimal"
    assert "note: upper bound by fake-bound" in outcome.err
    assert cli("check", tiny_file, "plan.json").status == 0


@pytest.mark.usefixtures("installed")
def test_bound_names_its_instance(cli: Cli, tiny_file: Path) -> None:
    """`bound --json` says which instance the bound holds for, as a plan does."""
    call = ("bound", tiny_file, "--method", "fake-bound", "--time-limit", "0.1", "--json")
    content = json.loads(cli(*call).out)
    instance = adr_opt.load(tiny_file)
    assert content["instance"] == {"name": instance.name, "sha256": instance.sha256}
