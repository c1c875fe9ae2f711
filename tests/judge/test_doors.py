"""The gate: what is wrong with a file is noticed at every door that reads it."""

from __future__ import annotations

import ast
import os
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest
from plans import solved, unjudged, with_legs
from run_all_rows import Load

import adr_opt
from adr_opt.judge.admit import Admitted, admit, admit_made

ROOT = Path(__file__).parents[2]

READERS = {
    "adr_opt/ui/cli/parameters.py",
    # The judges themselves, and verbs whose plans the functions behind them admit.
    "adr_opt/ui/cli/check.py",
    "adr_opt/ui/cli/verify.py",
    "adr_opt/ui/cli/compare.py",
    "adr_opt/ui/cli/report.py",
    "adr_opt/ui/cli/solve.py",
    "adr_opt/ui/cli/bound.py",
    # The server's own folder, admitted where it is read, and plans that it has just made.
    "adr_opt/ui/serve/project/plan_files.py",
    "adr_opt/ui/serve/project/points.py",
    "adr_opt/ui/serve/planner_worker.py",
    "adr_opt/ui/serve/planner_process.py",
}
"""Modules that may read a file of a plan: they hand it to the gate."""

CLASSES = {"Plan", "RefinedPlan", "Certificate"}


@pytest.fixture(scope="module")
def doors(load: Load, tmp_path_factory: pytest.TempPathFactory) -> Iterator[ModuleType]:
    """The verbs and the defects, in a folder with good files."""
    before = Path.cwd()
    os.chdir(tmp_path_factory.mktemp("doors"))
    found = load("doors")
    found.good_files()
    yield found
    os.chdir(before)


def reads_a_plan(node: ast.AST) -> bool:
    """Whether a node of a syntax tree makes a plan of a file or of a text."""
    if not isinstance(node, ast.Call):
        return False
    called = node.func
    if isinstance(called, ast.Name):
        return called.id in {"load_plan", "load_refined", "load_certificate"}
    return (
        isinstance(called, ast.Attribute)
        and called.attr in {"load", "from_json", "model_validate_json"}
        and isinstance(called.value, ast.Name)
        and called.value.id in CLASSES
    )


def test_plans_are_read_at_the_gate_alone() -> None:
    """No other module of the product makes a plan of a file."""
    found = set()
    for room in ("adr_opt", "solvers"):
        for path in (ROOT / room).rglob("*.py"):
            text = path.read_text(encoding="utf-8")
            if any(name in text for name in CLASSES) and any(
                map(reads_a_plan, ast.walk(ast.parse(text)))
            ):
                found.add(str(path.relative_to(ROOT)))
    assert found == READERS


@pytest.mark.parametrize("kind", ["plan", "refined plan", "certificate"])
def test_some_defects_are_noticed_at_some_doors(kind: str, doors: ModuleType) -> None:
    """Each door and each defect once: refused in one sentence, or stated."""
    found = Counter(said for _, _, said in doors.cells(kind, every=len(doors.KINDS[kind][2])))
    assert set(found) <= {"refused", "stated"}, found
    assert found["refused"]


@pytest.mark.slow
def test_every_defect_is_noticed_at_every_door(doors: ModuleType) -> None:
    """The tables of the page on judging are what the verbs do, and no cell is silent."""
    page = (ROOT / "docs/judging.md").read_text(encoding="utf-8")
    for kind in doors.KINDS:
        found = {(defect, door): said for defect, door, said in doors.cells(kind)}
        assert set(found.values()) <= {"refused", "stated"}, found
        assert doors.table(kind, found) in page


def test_good_files_pass_every_door(doors: ModuleType) -> None:
    """What is legal is neither refused nor called anything else."""
    for kind, names in (
        ("plan", ("check", "fly", "verify", "rehearse")),
        ("refined plan", ("check", "fly", "export .oem")),
        ("certificate", ("verify",)),
    ):
        doors.edited(doors.KINDS[kind][0], lambda content: None)
        for name in names:
            assert doors.outcome(doors.KINDS[kind][2][name]) == "silent", (kind, name)


def test_nothing_else_makes_an_admitted() -> None:
    """An admitted plan is made by the gate and by nothing else."""
    instance = adr_opt.generate("tiny", 0)
    with pytest.raises(TypeError, match="only"):
        Admitted(instance, solved(instance), (), object())


def test_what_is_let_in_unjudged_keeps_its_violations() -> None:
    """A plan with violations is let in only if that is asked for, and says so."""
    instance = adr_opt.generate("tiny", 0)
    plan = solved(instance)
    assert admit(instance, plan).holds
    wrong = with_legs(plan, plan.legs[1:])
    assert not unjudged(instance, wrong).holds
    with pytest.raises(adr_opt.InputError, match=r"not legal: leg 1: chain: .*'check' lists"):
        admit(instance, wrong)


def test_a_planner_that_breaks_a_rule_is_an_error_of_ours() -> None:
    """A plan of a planner that the judge refuses is no fault of the input."""
    instance = adr_opt.generate("tiny", 0)
    plan = solved(instance)
    assert admit_made(instance, plan).holds
    with pytest.raises(RuntimeError, match="'greedy-guarded' made a plan that breaks a rule"):
        admit_made(instance, with_legs(plan, plan.legs[1:]))
