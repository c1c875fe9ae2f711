"""``serve``: the process that plans, where it dies between one run and the next."""

from __future__ import annotations

import io
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hand_made import hand_made
from serve_desks import until

import adr_opt
from adr_opt.plan.plan import Plan
from adr_opt.problem.instance import Instance
from adr_opt.ui.serve import planner_process
from adr_opt.ui.serve.planner_process import PlannerProcess
from adr_opt.ui.serve.planning import PlanningOrder, PlanningProgress

ORDER = PlanningOrder(method="greedy-guarded", time_limit_s=5.0)


class Puppet:
    """A process that says what a test lets it say."""

    def __init__(self) -> None:
        said, self._says = os.pipe()
        self.stdout, self.stdin = os.fdopen(said, "rb"), io.BytesIO()
        self._status: int | None = None

    def poll(self) -> int | None:
        """Its status once it is dead."""
        return self._status

    def wait(self, timeout: float | None = None) -> int:
        """Its status."""
        return -9

    def die(self) -> None:
        """End, with what it has said still to be read."""
        self._status = -9

    def say(self, kind: str, **content: Any) -> None:
        """Say a line."""
        os.write(self._says, json.dumps({"kind": kind, **content}).encode() + b"\n")

    def fall_silent(self) -> None:
        """End what it says."""
        if self._says >= 0:
            os.close(self._says)
            self._says = -1


class Stage:
    """A planner whose processes are puppets, and what it has found."""

    def __init__(self, place: Path) -> None:
        self.puppets: list[Puppet] = []
        self.found: list[tuple[str, str | None]] = []
        self.planner = PlannerProcess(lambda instance, result: "well", place, self._found)

    def start(self, *_: Any, **__: Any) -> Puppet:
        """Another puppet."""
        self.puppets.append(Puppet())
        return self.puppets[-1]

    def _found(self, instance: Instance, plan: Plan | None) -> None:
        self.found.append((instance.name, None if plan is None else plan.instance.name))


@pytest.fixture
def stage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Stage]:
    """A planner with puppets for processes."""
    made = Stage(tmp_path)
    monkeypatch.setattr(planner_process, "started", made.start)
    monkeypatch.setattr(planner_process, "LAST_WORDS_S", 60.0)
    monkeypatch.setattr(planner_process, "end", lambda puppet: puppet.fall_silent())
    yield made
    for puppet in made.puppets:
        puppet.fall_silent()
    made.planner.close()


def test_last_words_of_a_dead_process_are_of_its_own_run(stage: Stage) -> None:
    """Heard after the next order, they are of the run before it, which ends before that begins."""
    first, second = adr_opt.generate("tiny", 1), hand_made()
    plan = adr_opt.solve(first, "greedy-guarded").plan
    other = adr_opt.solve(second, "greedy-guarded").plan
    assert plan is not None
    assert other is not None
    stage.planner.begin(first, ORDER, None)
    stage.puppets[0].die()
    stage.planner.begin(second, ORDER, None)
    stage.puppets[1].say("found", number=1, plan=other.to_json())
    stage.puppets[0].say("found", number=1, plan=plan.to_json())
    look = {**vars(PlanningProgress(1, "done")), "points": []}
    stage.puppets[0].say("progress", progress=look)
    stage.puppets[0].fall_silent()
    until(lambda: any(name == second.name for name, _ in stage.found))
    assert stage.found[0] == (first.name, first.name)
    assert stage.found[-1] == (second.name, second.name)
    assert stage.planner.progress().number == 2
    assert stage.planner.progress().runs
    stage.puppets[1].say("progress", progress=look)
    until(lambda: not stage.planner.progress().runs)
    assert stage.planner.progress().number == 2


def test_all_runs_of_a_dead_process_end(stage: Stage) -> None:
    """A run that is stopping and one that waits for it both end, in their order."""
    names = []
    for seed in (1, 2):
        instance = adr_opt.generate("tiny", seed)
        stage.planner.begin(instance, ORDER, None)
        names.append(instance.name)
    stage.puppets[0].die()
    stage.puppets[0].fall_silent()
    assert stage.planner.wait(60.0)
    assert stage.found == [(name, None) for name in names]
    assert stage.planner.progress().phase == "failed"


def test_a_dead_process_is_ended_though_the_next_has_begun(stage: Stage) -> None:
    """Its best plan so far is a result, also where Plan was pressed before its end was noticed."""
    first, second = adr_opt.generate("tiny", 1), adr_opt.generate("tiny", 2)
    stage.planner.begin(first, ORDER, None)
    stage.puppets[0].die()
    stage.planner.begin(second, ORDER, None)
    stage.puppets[0].fall_silent()
    until(lambda: bool(stage.found))
    assert stage.found == [(first.name, None)]
    assert stage.planner.progress().number == 2
    assert stage.planner.progress().runs
