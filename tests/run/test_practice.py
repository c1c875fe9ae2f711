"""Practice missions: each is of its kind, and what they call is compiled for missions like it."""

from __future__ import annotations

import numpy as np
import pytest

from adr_opt.mission.problem import Problem
from adr_opt.run import front
from adr_opt.run.methods import PLANNERS
from adr_opt.run.warm_up import PracticeKind, practice_problem, thrusting_problem
from adr_opt.ui.cli.warm_up import _is_for, _kinds
from solvers.labels.label_search import LabelSearch
from solvers.labels.practice import practise


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
