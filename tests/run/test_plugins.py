"""Planners that others write, and practice missions: faults are sentences, each kind is there."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.mission.certified import certify, certify_routes
from adr_opt.mission.problem import Problem
from adr_opt.problem.rules import FIRST
from adr_opt.run import front, methods
from adr_opt.run.method_spec import MethodSpec
from adr_opt.run.methods import PLANNERS
from adr_opt.run.warm_up import PracticeKind, practice_problem, thrusting_problem
from adr_opt.testing import CASES, PlannerFault, validate_planner
from adr_opt.ui.cli.warm_up import _is_for, _kinds
from solvers.labels.label_search import LabelSearch, practise

ROOT = Path(__file__).parents[2]

PLUGINS = '''
"""Planners that are wrong, and one that notes what it is called with."""

from adr_opt.problem.rules import FIRST
from adr_opt.run.method_spec import MethodSpec, Practice
from adr_opt.mission.certified import certify, certify_routes

CALLS = []

a_list = [1, 2, 3]


def forgets(mission, *, seed, stop, progress):
    """Plan, and forget to return it."""


def other(mission, budget, rng):
    """Take other arguments than planners do."""


def noting(mission, *, seed, stop, progress, walks=100_000, mode="quick", jobs=1):
    """Note the options of each call."""
    CALLS.append((mission.instance.name, walks, mode, jobs))
    return certify(mission, "noting", (), seed=seed, runtime_s=0.0)


def modest(mission, *, seed, stop, progress, walks=100_000):
    """Note its options, and practise with few walks."""
    CALLS.append((mission.instance.name, walks))
    return certify(mission, "modest", (), seed=seed, runtime_s=0.0)


MODEST = MethodSpec(
    "modest", "plugins_of_others:modest", practice=Practice(rounds=2, options={"walks": 3})
)


def several(problem, *, seed, stop, progress, walks=100):
    """Plan for several chasers as well."""
    CALLS.append((problem.instance.name, walks))
    return certify_routes(problem, "several", [() for _ in problem.missions], seed=seed,
                          runtime_s=0.0)


SEVERAL = MethodSpec(
    "several", "plugins_of_others:several", follows=FIRST | {"several chasers"}
)
'''

NAMES = ("forgets", "other", "a_list", "noting", "modest", "several")
SPECIFIED = {"modest": "MODEST", "several": "SEVERAL"}


@pytest.fixture
def calls(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[tuple]:
    """Install the planners above; what they note is in the list."""
    metadata = tmp_path / "plugins-1.0.dist-info"
    metadata.mkdir()
    (tmp_path / "plugins_of_others.py").write_text(PLUGINS, encoding="utf-8")
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: plugins\nVersion: 1.0\n")
    lines = [
        "[adr_opt.planners]",
        *(f"{name} = plugins_of_others:{SPECIFIED.get(name, name)}" for name in NAMES),
    ]
    (metadata / "entry_points.txt").write_text("\n".join(lines) + "\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    sys.modules.pop("plugins_of_others", None)
    import plugins_of_others

    found: list[tuple] = plugins_of_others.CALLS
    return found


@pytest.fixture
def field() -> adr_opt.Instance:
    return adr_opt.generate("tiny", seed=0)


@pytest.mark.usefixtures("calls")
@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("forgets", r"^method 'forgets' returned None in place of a Result; let it return what"),
        (
            "other",
            r"^method 'other' takes \(mission, budget, rng\) \(missing a required argument: "
            r"'budget'\); planners are functions of \(mission, \*, seed, stop, progress\), and",
        ),
        ("a_list", r"^method 'a_list' is of type list and cannot be called; planners are"),
    ],
)
def test_a_planner_that_is_none_is_one_sentence(
    field: adr_opt.Instance, name: str, said: str
) -> None:
    """What returns None, takes other arguments or cannot be called is named and told what to be."""
    with pytest.raises(InputError, match=said) as raised:
        adr_opt.solve(field, name, time_limit=1)
    assert "\n" not in str(raised.value)


@pytest.mark.usefixtures("calls")
def test_a_planner_that_is_none_does_not_stand_in_the_way_of_others(
    field: adr_opt.Instance, capsys: pytest.CaptureFixture[str]
) -> None:
    """The others are still listed and recommended; the shell says the sentence and exits with 2."""
    from adr_opt.ui.cli.entry import main

    with pytest.raises(InputError, match=r"takes no start plan; .* use one of: .*local-search"):
        adr_opt.solve(field, "greedy-guarded", start=[1])
    assert main(["methods"]) == 0
    listed = capsys.readouterr().out
    assert "method 'other' takes (mission, budget, rng)" in listed
    assert "beam" in listed
    path = ROOT / "instances" / "tiny" / "tiny-000.json"
    assert main(["solve", str(path), "--method", "forgets"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_practising_uses_the_options_asked_for(calls: list[tuple], field: adr_opt.Instance) -> None:
    """Neither a run nor practice has other options than those asked for, and no run practises."""
    adr_opt.solve(field, "noting", walks=7, mode="slow", jobs=2)
    front.warm_up(methods.PLANNERS, "noting", options={"walks": 8, "mode": "slow"}, jobs=2)
    practice = "reduced-time-000-n16-z2"
    assert calls == [("tiny-000", 7, "slow", 2), (practice, 8, "slow", 2)]


def test_a_planner_may_say_with_which_numbers_it_practises(
    calls: list[tuple], field: adr_opt.Instance
) -> None:
    """What its specification says of practice is taken for the practice mission alone."""
    front.warm_up(methods.PLANNERS, "modest", options={"walks": 9})
    adr_opt.solve(field, "modest", walks=9)
    assert [walks for _, walks in calls] == [3, 9]


def test_a_planner_for_several_chasers_gets_its_options_too(calls: list[tuple]) -> None:
    """Options that are keyword arguments reach the function that plans for several chasers."""
    field = adr_opt.generate("tiny", seed=0, chasers=2)
    adr_opt.solve(field, "several", walks=5)
    assert calls[-1] == (field.name, 5)


def _empty(mission, *, seed, stop, progress):
    """Stay where the chaser is, which keeps to all rules but required targets."""
    return certify(mission, "empty", (), seed=seed, runtime_s=0.0)


def test_a_good_planner_passes_all_cases(monkeypatch: pytest.MonkeyPatch) -> None:
    """The example of the documentation passes every case that is one for it."""
    monkeypatch.syspath_prepend(str(ROOT / "examples" / "random-walks"))
    from random_walks import random_walks

    passed = validate_planner(random_walks, walks=20)
    left_out = {"practice campaign", "practice mission without a timetable", "start plan"}
    assert set(passed) == set(CASES) - left_out


def test_an_installed_planner_is_tried_by_name() -> None:
    """Cases are chosen by name; those that a planner knows by its specification are among them."""
    wanted = ("practice campaign", "start plan", "windows")
    assert validate_planner("exact", cases=wanted) == wanted
    with pytest.raises(InputError, match="case 'no such' is unknown; use one of: practice mission"):
        validate_planner(_empty, cases=["no such"])
    with pytest.raises(InputError, match="option 'walks' of method '_empty' is unknown"):
        validate_planner(_empty, walks=3)


def _none(mission, *, seed, stop, progress):
    return None


def _raising(mission, *, seed, stop, progress):
    raise ZeroDivisionError("no idea")


def _illegal(mission, *, seed, stop, progress):
    return certify(mission, "illegal", (1, 1), seed=seed, runtime_s=0.0)


def _boasting(mission, *, seed, stop, progress):
    progress(3.0, math.inf)
    return _empty(mission, seed=seed, stop=stop, progress=progress)


def _lying(mission, *, seed, stop, progress):
    result = _empty(mission, seed=seed, stop=stop, progress=progress)
    plan = result.plan.replace(objective=2.0)
    return replace(result, plan=plan, objective=2.0)


def _mistaken(mission, *, seed, stop, progress):
    return certify(mission, "mistaken", (), seed=seed, runtime_s=0.0, upper_bound=1.0)


def _restless(mission, *, seed, stop, progress):
    while True:
        stop(0.0, math.inf)


def _planless(mission, *, seed, stop, progress):
    return certify(mission, "planless", None, seed=seed, runtime_s=0.0)


_counted: list[int] = []


def _fickle(mission, *, seed, stop, progress):
    _counted.append(1)
    return certify(mission, "fickle", (len(_counted) % 2 + 1,), seed=seed, runtime_s=0.0)


@pytest.mark.parametrize(
    ("wrong", "case", "said"),
    [
        (_none, "practice mission", "method '_none' returned None in place of a Result"),
        (_raising, "usual field", "raised ZeroDivisionError('no idea')"),
        (_illegal, "windows", "is visited twice"),
        (_boasting, "usual field", "it reported the incumbent 3.0 and returned a plan that"),
        (_lying, "usual field", "its plan breaks the rules: plan: objective"),
        (_mistaken, "usual field", "its bound 1.0 is below"),
        (_restless, "time over at once", "it goes on after stop(incumbent, bound) returned"),
        (_planless, "no targets", "returned no plan"),
        (_fickle, "same seed, same plan", "gives another plan when called again"),
    ],
)
def test_what_a_planner_does_wrong_is_said_by_the_name_of_the_case(
    wrong: Callable, case: str, said: str
) -> None:
    """Each fault is found in a case that shows it, and the error names that case."""
    with pytest.raises(PlannerFault) as raised:
        validate_planner(wrong, cases=[case])
    assert [fault.case for fault in raised.value.faults] == [case]
    assert f"{case}: " in str(raised.value)
    assert said in str(raised.value)


def test_a_planner_of_other_arguments_is_refused_before_any_case() -> None:
    """A function that is none is an InputError, not a fault in every case."""
    with pytest.raises(InputError, match="planners are functions of"):
        validate_planner(lambda mission: None)


def test_an_empty_plan_passes_but_where_a_target_is_required() -> None:
    """Every case can be failed or passed by what the rules say: a chaser that stays is legal."""
    with pytest.raises(PlannerFault) as raised:
        validate_planner(_empty)
    assert {fault.case for fault in raised.value.faults} == {"required target", "two stations"}
    passed = validate_planner(_planless, cases=["required target out of reach"])
    assert passed == ("required target out of reach",)


def test_a_planner_of_several_chasers_is_tried_with_them() -> None:
    """A planner that says that it plans for several gets the practice campaign, and is judged."""

    def wrong(problem, *, seed, stop, progress):
        routes = [(1,)] * len(problem.missions)
        return certify_routes(problem, "wrong", routes, seed=seed, runtime_s=0.0)

    several = MethodSpec("wrong", wrong, follows=FIRST | {"several chasers"})
    with pytest.raises(PlannerFault, match="practice campaign: "):
        validate_planner(several, cases=["practice campaign"])


@pytest.mark.usefixtures("calls")
def test_warm_up_says_of_a_planner_what_is_wrong() -> None:
    """Practising finds out that no result comes back, and returns the sentence."""
    problem = front.warm_up(methods.PLANNERS, "forgets")
    assert "returned None in place of a Result" in str(problem)


@pytest.mark.parametrize("several", [False, True])
def test_practice_of_low_thrust_thrusts_and_tows(several: bool) -> None:
    """Its chasers thrust, some of its targets are towed, and some pairs have legs."""
    problem = PracticeKind(thrusts=True, several=several).problem()
    assert all(chaser.thrust_n is not None for chaser in problem.instance.chasers)
    assert len(problem.missions) == 1 + several
    assert {target.removal for target in problem.instance.targets} == {"tow", "visit"}
    mission = problem.missions[0]
    assert any(
        mission.time((problem.instance.first_target + at, problem.instance.first_target + to)).made
        for at, to in ((0, 1), (0, 2), (1, 2))
    )


@pytest.mark.parametrize("required", [False, True])
def test_practice_with_functions_of_time_has_some(required: bool) -> None:
    """Its arrivals are functions; as a tour, all of its targets are required."""
    problem = PracticeKind(timed=True, tours=required).problem()
    assert problem.missions[0].has_functions
    assert {target.required for target in problem.instance.targets} == {required}


def test_every_kind_is_practised_by_exact() -> None:
    """There is no kind of practice mission that the planner for all of them leaves out."""
    kinds = _kinds()
    assert len(set(kinds)) == len(kinds)
    assert all(_is_for(kind, front.spec_of("exact", PLANNERS)) for kind in kinds)
    thrusting = [kind for kind in kinds if kind.thrusts]
    assert not any(_is_for(kind, front.spec_of("beam", PLANNERS)) for kind in thrusting)


def test_a_cut_is_paid_for_in_practice(monkeypatch: pytest.MonkeyPatch) -> None:
    """Walks pay for a subset-row cut, or for none, where there is a timetable; with tows too."""
    cut = []
    original = LabelSearch.cut

    def noting(self: LabelSearch, cuts: list, **more: bool) -> None:
        original(self, cuts, **more)
        cut.append(list(cuts))

    monkeypatch.setattr(LabelSearch, "cut", noting)
    for problem in (practice_problem(several=True), thrusting_problem()):
        assert problem.missions[0].timetable is not None
        practise(problem)
    assert [len(cuts) for cuts in cut] == [0, 1, 0, 1]
    practise(Problem(thrusting_problem().instance))  # whose timetable is not built
    practise(PracticeKind(timed=True).problem())
    assert len(cut) == 4
    assert all(np.isfinite(each.multiplier) for cuts in cut for each in cuts)
