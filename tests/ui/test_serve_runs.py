"""``serve``: the best plan so far of a run, kept until there is a better one."""

from __future__ import annotations

import errno
import math
from pathlib import Path
from typing import Any

import pytest
from hand_made import hand_made
from serve_desks import session_of, until

import adr_opt
from adr_opt.common.progress import Relayed, show_plan, tell_plan
from adr_opt.mission.certified import certify_routes
from adr_opt.mission.problem import problem_of
from adr_opt.plan.plan import Plan
from adr_opt.problem.instance import Instance
from adr_opt.run import front
from adr_opt.ui.serve import work
from adr_opt.ui.serve.folder import Folder
from adr_opt.ui.serve.planning import PlanningOrder
from adr_opt.ui.serve.project import results
from adr_opt.ui.serve.session import EditingSession

HALF, WHOLE = ("south",), ("south", "station", "beyond")


def numbers(names: tuple[str, ...]) -> tuple[int, ...]:
    """Bodies of the instance by their names."""
    known = problem_of(hand_made()).names
    return tuple(known.index(name) for name in names)


def test_plans_are_shown_to_those_that_want_to_see_them() -> None:
    """Routes pass through what tells incumbents in other terms; who hears numbers hears those."""
    heard: list[Any] = []

    class Witness:
        def __call__(self, incumbent: float, bound: float) -> None:
            heard.append((incumbent, bound))

        def found(self, routes: Any) -> None:
            heard.append(routes)

    witness = Witness()
    tell_plan(Relayed(lambda best, bound: witness(2.0 * best, bound), witness), 1.0, (3, 1))
    assert heard == [((3, 1),), (2.0, math.inf)]
    show_plan(lambda incumbent, bound: heard.append(incumbent), (3, 1))
    assert len(heard) == 2


@pytest.mark.parametrize(
    ("method", "chasers"),
    [(method, 1) for method in ("auto", "exact", "local-search", "beam", "mcts", "ortools")]
    + [(method, 2) for method in ("auto", "exact", "ortools")],
)
def test_planners_show_legal_plans(method: str, chasers: int) -> None:
    """What a planner shows are routes that can be flown, the last as good as its result."""
    if method == "ortools":
        pytest.importorskip("ortools")
    instance, shown = hand_made(), list[Any]()
    one = instance.chasers[0]
    crew = tuple(one.replace(name=f"chaser {at + 1}") for at in range(chasers))
    instance = instance.replace(chasers=crew)

    class Witness:
        def __call__(self, incumbent: float, bound: float) -> None:
            pass

        def found(self, routes: Any) -> None:
            shown.append(routes)

    result = front.solve(instance, method, time_limit=5.0, progress=Witness())
    problem = problem_of(instance)
    assert shown
    prizes = [problem.collected(j for route in routes for j in route) for routes in shown]
    assert max(prizes) == result.objective
    assert [len(routes) for routes in shown] == [chasers] * len(shown)
    for routes in shown:
        plan = certify_routes(problem, method, routes, seed=0, runtime_s=0.0).plan
        assert plan is not None
        assert adr_opt.check(instance, plan) == ()


@pytest.fixture
def session(tmp_path: Path) -> EditingSession:
    """A session on a hand-made mission, in a new project."""
    return session_of(hand_made(), None, Folder(tmp_path / "project", tmp_path / "i.json"))


def plan_of(names: tuple[str, ...]) -> Plan:
    """A plan of the mission that visits these targets."""
    plan = certify_routes(
        problem_of(hand_made()), "by-hand", [numbers(names)], seed=0, runtime_s=0.0
    ).plan
    assert plan is not None
    return plan


def test_the_best_plan_so_far_becomes_that_of_the_result(session: EditingSession) -> None:
    """While a run goes on its plans are no results; then its folder is that of its result."""
    instance, folder = session.instance(), session.folder.path
    for names in (HALF, WHOLE):
        session._found(instance, plan_of(names))
        assert session.results.all() == []
        assert adr_opt.load_plan(folder / "results/0001-solve/plan.json") == plan_of(names)
    session._planned(instance, adr_opt.solve(instance, "exact"))
    (record,) = session.results.all()
    assert (record.number, record.said, record.objective) == (1, "", 3.0)
    assert session.state()["result"] == 1


def test_a_run_without_a_result_leaves_its_best_plan(session: EditingSession) -> None:
    """A planner that fails after its first plan leaves that as a result, which is shown."""
    instance = session.instance()
    session._found(instance, None)
    assert session.results.all() == []
    session._found(instance, plan_of(HALF))
    session._found(instance, None)
    (record,) = session.results.all()
    assert record.said.startswith("stopped early")
    assert session.state()["plan"]["visits"] == 1
    session._found(instance, None)
    assert len(session.results.all()) == 1


def test_a_run_that_ends_leaves_the_next_one_alone(session: EditingSession) -> None:
    """The end of a run that has no plan yet is not that of one that has, which comes after it."""
    instance = session.instance()
    session._found(instance, plan_of(HALF))
    session._found(hand_made(periods=15.0), None)
    assert session.results.all() == []
    session._found(instance, None)
    assert [record.number for record in session.results.all()] == [1]


def test_a_full_disk_at_the_end_leaves_the_best_plan(
    session: EditingSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A result that cannot be written is kept with the next run, and does not mix with its own."""
    instance, folder = session.instance(), session.folder.path
    session._found(instance, plan_of(WHOLE))
    with monkeypatch.context() as full:
        full.setattr(results, "write_text", no_space)
        with pytest.raises(OSError, match="No space"):
            session._planned(instance, adr_opt.solve(instance, "exact"))
    assert session.results.all() == []
    assert adr_opt.load_plan(folder / "results/0001-solve/plan.json").objective == 3.0
    session._found(instance, plan_of(HALF))
    assert [record.objective for record in session.results.all()] == [3.0]
    session._found(instance, None)
    assert [record.objective for record in session.results.all()] == [3.0, 1.0]


def test_a_full_disk_at_the_beginning_is_not_the_end(
    session: EditingSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the first plan of a run cannot be stored the next one is, with its instance."""
    instance, folder = session.instance(), session.folder.path
    with monkeypatch.context() as full:
        full.setattr(Instance, "save", no_space)
        with pytest.raises(OSError, match="No space"):
            session._found(instance, plan_of(HALF))
    assert list((folder / "results").iterdir()) == []
    session._found(instance, plan_of(WHOLE))
    again = session_of(None, None, Folder(folder))
    assert [record.objective for record in again.results.all()] == [2.0]


def no_space(*_: Any) -> None:
    """Write nothing, as where the disk is full."""
    raise OSError(errno.ENOSPC, "No space left on device")


def test_an_unfinished_plan_is_taken_up(session: EditingSession, tmp_path: Path) -> None:
    """A project left within a run shows its best plan, unless a better one of the draft is shown.

    A folder without a plan, or with one of another instance, is no result, and goes.
    """
    instance, folder = session.instance(), session.folder.path
    session._planned(instance, adr_opt.solve(instance, "exact"))
    session._found(instance, plan_of(WHOLE))
    again = session_of(None, None, Folder(folder))
    assert again.state()["result"] == 1
    assert [record.number for record in again.results.all()] == [1, 2]
    again._found(instance, plan_of(HALF))
    strange = folder / "results/0003-solve/instance.json"
    hand_made(periods=15.0).save(strange)
    (folder / "results/0004-solve").mkdir()
    again = session_of(None, None, Folder(folder))
    assert [record.number for record in again.results.all()] == [1, 2]
    assert not strange.parent.exists()
    assert not (folder / "results/0004-solve").exists()


def test_a_watch_makes_plans_of_the_best_routes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Routes that are better than those before become plans; half a plan and worse ones do not."""
    monkeypatch.setattr(work, "PAUSE_S", 0.01)
    found: list[Plan] = []
    watch = work.IncumbentWatch(
        problem_of(hand_made()), PlanningOrder(method="beam", time_limit_s=1.0), found.append
    )
    with watch:
        for routes, count in (
            ((numbers(HALF),), 1),
            (((99,),), 1),
            ((numbers(HALF), ()), 1),
            ((numbers(WHOLE),), 2),
            ((numbers(HALF),), 2),
        ):
            watch.hear(routes)
            until(lambda count=count: len(found) == count)
    assert [plan.objective for plan in found] == [1.0, 2.0]
