"""`instances/best-known.csv`, and the script that keeps it."""

from __future__ import annotations

import contextlib
import importlib
import io
import json
import math
import re
import sys
from collections.abc import Iterator
from dataclasses import replace
from importlib.metadata import EntryPoint
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from plans import with_legs

import adr_opt
from adr_opt.common.progress import Progress
from adr_opt.common.stop import Stop
from adr_opt.mission.certified import certify, certify_routes
from adr_opt.mission.certify import certificate_of
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.mission.result import Result
from adr_opt.run import methods
from adr_opt.sources.generator import FAMILIES
from adr_opt.sources.library import Entry, Library

ROOT = Path(__file__).parents[2]
NAME = "tiny-001"


@pytest.fixture(scope="module")
def script() -> Iterator[ModuleType]:
    sys.path.insert(0, str(ROOT / "bench"))
    yield importlib.import_module("best_known")
    sys.path.remove(str(ROOT / "bench"))
    del sys.modules["best_known"]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder like instances/, with one instance and an empty table."""
    (tmp_path / "tiny").mkdir()
    text = (ROOT / "instances" / "tiny" / f"{NAME}.json").read_text(encoding="utf-8")
    (tmp_path / "tiny" / f"{NAME}.json").write_text(text, encoding="utf-8")
    return tmp_path


@pytest.fixture
def mission(folder: Path) -> Mission:
    return Mission(adr_opt.load(folder / "tiny" / f"{NAME}.json"))


def certified(mission: Mission, sequence: tuple[int, ...], method: str = "hand") -> adr_opt.Plan:
    plan = certify(mission, method, sequence, seed=0, runtime_s=0.0).plan
    assert plan is not None
    return plan


def saved(folder: Path, plan: adr_opt.Plan) -> Path:
    path = folder / "plan.json"
    plan.save(path)
    return path


def bound_file(folder: Path, mission: Mission, upper_bound: float | None, **more: Any) -> Path:
    """What `bound --json` prints."""
    content = {
        "instance": {"name": mission.instance.name, "sha256": mission.instance.sha256},
        "method": "proves",
        "upper_bound": upper_bound,
        "versions": {"adr-opt": "0.1.0"},
    }
    path = folder / "bound.json"
    path.write_text(json.dumps(content | more), encoding="utf-8")
    return path


def consistent(script: ModuleType, folder: Path) -> dict[str, Any]:
    """The rows of a table, in which the script finds nothing wrong."""
    with contextlib.redirect_stdout(io.StringIO()):
        assert script.main(["--folder", str(folder), "verify"]) == 0
    rows = script.read_table(folder)
    plans = {f"best-known/{path.name}" for path in folder.glob("best-known/*")}
    assert plans == {row.plan for row in rows.values()} - {""}
    for name, row in rows.items():
        assert name == row.instance
        assert row.who
        assert row.date
        assert bool(row.bound_method) or not math.isfinite(row.upper_bound)
        # The plan files of committed instances are kept as well.
        assert bool(row.plan) == bool(row.order and script.file_of(folder, name))
        if row.plan:
            plan = adr_opt.load_plan(folder / row.plan)
            assert plan.method == row.planner_method
            known = math.isfinite(row.upper_bound)
            assert (plan.upper_bound, plan.gap) == (
                (row.upper_bound, row.gap) if known else (None,) * 2
            )
    return rows


def test_the_committed_rows_of_small_fields_are_verified(
    script: ModuleType, capsys: pytest.CaptureFixture[str]
) -> None:
    """The script finds nothing wrong with some, and their bounds have certificates."""
    assert script.main(["verify", "tiny-000", "tiny-007", "hand-made"]) == 0
    assert "3 rows, 0 wrong: 3 plans checked, 2 bounds verified, 0 bounds without" in (
        capsys.readouterr().out
    )


def test_the_summary_counts_the_rows_of_families(
    script: ModuleType, capsys: pytest.CaptureFixture[str]
) -> None:
    """It prints means of a family, and how many of its rows are proven."""
    assert script.main(["summary", "electric"]) == 0
    said = capsys.readouterr().out
    rows = [
        row
        for name, row in script.read_table(ROOT / "instances").items()
        if name.startswith("electric-")
    ]
    proven = sum(row.objective == row.upper_bound for row in rows)
    assert len(rows) == 20
    assert said.startswith("electric: 20 rows, objective ")
    assert said.endswith(f" {proven} proven\n")
    assert said.strip() in (ROOT / "docs/benchmarks.md").read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("family", [*FAMILIES, "hand-made"])
def test_every_committed_row_is_verified(script: ModuleType, family: str) -> None:
    """Plans, gaps and certificates of all families."""
    assert script.main(["verify", family]) == 0


def test_only_a_better_plan_replaces_a_plan(
    script: ModuleType, folder: Path, mission: Mission, capsys: pytest.CaptureFixture[str]
) -> None:
    """More prizes win, at equal prizes less ΔV; anything else leaves both files as they are."""
    best = adr_opt.solve(mission, "greedy-guarded").sequence
    assert best is not None
    singles = sorted(
        (certified(mission, (j,)) for j in range(1, len(mission.names)) if mission.time((j,)).made),
        key=lambda plan: plan.delta_v_m_s,
    )
    cheap, dear = singles[0], singles[-1]
    assert cheap.delta_v_m_s < dear.delta_v_m_s

    def offer(plan: adr_opt.Plan) -> Any:
        assert script.main(["--folder", str(folder), "add", str(saved(folder, plan))]) == 0
        return consistent(script, folder)[NAME]

    assert offer(dear).delta_v_m_s == dear.delta_v_m_s
    assert offer(cheap).delta_v_m_s == cheap.delta_v_m_s
    table = (folder / "best-known.csv").read_bytes()
    assert offer(dear).delta_v_m_s == cheap.delta_v_m_s
    assert "not better" in capsys.readouterr().out
    assert (folder / "best-known.csv").read_bytes() == table
    assert offer(certified(mission, best, "better")).planner_method == "better"
    assert offer(cheap).objective == len([j for j in best if j])


def test_only_a_lower_bound_replaces_a_bound(
    script: ModuleType, folder: Path, mission: Mission
) -> None:
    """Bounds go down only; the plan file gets the bound of the row and says whose it is."""

    def offer(upper_bound: float | None) -> Any:
        path = bound_file(folder, mission, upper_bound)
        assert script.main(["--folder", str(folder), "add", str(path)]) == 0
        return consistent(script, folder)

    assert offer(None) == {}
    assert offer(7.0)[NAME].upper_bound == 7.0
    assert offer(7.5)[NAME].upper_bound == 7.0
    assert offer(None)[NAME].upper_bound == 7.0
    plan = certified(mission, (1,))
    assert script.main(["--folder", str(folder), "add", str(saved(folder, plan))]) == 0
    row = offer(4.0)[NAME]
    assert (row.objective, row.upper_bound, row.gap, row.bound_method) == (1.0, 4.0, 0.75, "proves")
    kept = adr_opt.load_plan(folder / "best-known" / f"{NAME}.json")
    assert kept.notes == ("upper bound by proves",)
    assert kept.status == "feasible"
    # A plan file that brings a bound is a claim for both.
    proven = plan.replace(upper_bound=1.0, gap=0.0, status="optimal", method="exact")
    assert script.main(["--folder", str(folder), "add", str(saved(folder, proven))]) == 0
    row = consistent(script, folder)[NAME]
    assert (row.upper_bound, row.bound_method, row.planner_method) == (1.0, "exact", "hand")
    assert adr_opt.load_plan(folder / row.plan).status == "optimal"


def test_an_illegal_plan_is_refused(
    script: ModuleType, folder: Path, mission: Mission, capsys: pytest.CaptureFixture[str]
) -> None:
    """All violations are listed, exit 1, and nothing is written."""
    plan = certified(mission, (1,))
    leg = plan.legs[0]
    lie = with_legs(plan, (leg.replace(delta_v_m_s=leg.delta_v_m_s - 1.0),), objective=9.0)
    assert script.main(["--folder", str(folder), "add", str(saved(folder, lie))]) == 1
    said = capsys.readouterr().err
    assert "leg 1: cost" in said
    assert "plan: objective" in said
    assert not (folder / "best-known.csv").exists()
    assert not (folder / "best-known").exists()


def test_a_bound_below_a_known_plan_is_an_alarm(
    script: ModuleType, folder: Path, mission: Mission, capsys: pytest.CaptureFixture[str]
) -> None:
    """A bound below a legal plan, whichever comes first, is refused with exit 1."""
    plan = saved(folder, certified(mission, (1,)))
    assert script.main(["--folder", str(folder), "add", str(plan)]) == 0
    before = (folder / "best-known.csv").read_bytes()
    assert script.main(["--folder", str(folder), "add", str(bound_file(folder, mission, 0.5))]) == 1
    assert "ALARM: the bound 0.5 by proves" in capsys.readouterr().err
    assert (folder / "best-known.csv").read_bytes() == before

    (folder / "best-known.csv").unlink()
    assert script.main(["--folder", str(folder), "add", str(bound_file(folder, mission, 0.5))]) == 0
    assert script.main(["--folder", str(folder), "add", str(plan)]) == 1
    assert "ALARM" in capsys.readouterr().err
    assert script.read_table(folder)[NAME].objective == -math.inf


def test_other_instances_and_files_are_wrong(
    script: ModuleType, folder: Path, mission: Mission, capsys: pytest.CaptureFixture[str]
) -> None:
    """What is not for a committed instance, or not one of the three kinds, is exit 2."""

    def wrong(path: Path, named: str) -> None:
        assert script.main(["--folder", str(folder), "add", str(path)]) == 2
        assert named in capsys.readouterr().err

    changed = mission.instance.with_limits(delta_v_m_s=2000.0)
    wrong(saved(folder, certified(Mission(changed), (1,))), "is not that of")
    other = Mission(adr_opt.generate("tiny", 77))
    wrong(saved(folder, certified(other, (1,))), "commit it there first")
    wrong(bound_file(folder, mission, 3.0, instance="tiny-001"), "not what 'bound --json' prints")
    wrong(folder / "absent.json", "no such file")
    (folder / "list.json").write_text("[]")
    wrong(folder / "list.json", "not a JSON object")
    (folder / "best-known.csv").write_text("a,b\n1,2\n")
    wrong(bound_file(folder, mission, 3.0), "the columns must be")
    header = ",".join(script.COLUMNS)
    (folder / "best-known.csv").write_text(f"{header}\n{NAME},abc\n")
    wrong(bound_file(folder, mission, 3.0), "line 2")


def test_a_row_for_another_version_of_an_instance_is_kept(
    script: ModuleType, folder: Path, mission: Mission, capsys: pytest.CaptureFixture[str]
) -> None:
    """After a change of the instance the old row is not mixed with new results."""
    path = bound_file(folder, mission, 7.0)
    assert script.main(["--folder", str(folder), "add", str(path)]) == 0
    table = folder / "best-known.csv"
    table.write_text(table.read_text().replace(mission.instance.sha256, "0" * 64))
    assert script.main(["--folder", str(folder), "add", str(path)]) == 1
    assert "another version of the instance" in capsys.readouterr().err


def in_library(folder: Path, *seeds: int) -> list[str]:
    """A library of tiny instances in a folder, of which only the first may be a file there."""
    made = [adr_opt.generate("tiny", seed) for seed in seeds]
    entries = tuple(Entry(name=each.name, sha256=each.sha256) for each in made)
    (folder / "library.json").write_text(Library(version="1.0", instances=entries).to_json())
    return [each.name for each in made]


def test_instances_of_the_library_are_solved_by_name(
    script: ModuleType, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A name or a family is enough; such rows hold the order, from which the plan comes again."""
    _, second, third = in_library(folder, 1, 2, 3)
    arguments = ["--folder", str(folder), "solve", "--method", "beam", "--time-limit", "5"]
    assert script.main([*arguments, second]) == 0
    row = consistent(script, folder)[second]
    assert row.order
    assert not row.plan
    assert not (folder / "best-known").exists()
    # Resumed, it does the rest; then nothing.
    assert script.main([*arguments, "--family", "tiny", "--missing"]) == 0
    assert "[2/2] tiny-003" in capsys.readouterr().out
    rows = consistent(script, folder)
    assert set(rows) == {NAME, second, third}
    assert rows[second] == row
    assert [each for each in rows.values() if each.plan] == [rows[NAME]]
    table = (folder / "best-known.csv").read_bytes()
    assert script.main([*arguments, "--family", "tiny", "--missing"]) == 0
    assert capsys.readouterr().out == ""
    assert (folder / "best-known.csv").read_bytes() == table

    out = folder / "again.json"
    assert script.main(["--folder", str(folder), "plan", second, "--out", str(out)]) == 0
    plan = adr_opt.load_plan(out)
    assert adr_opt.check(adr_opt.generate("tiny", 2), plan) == ()
    assert (plan.objective, plan.upper_bound, plan.method) == (
        row.objective,
        row.upper_bound,
        row.planner_method,
    )
    # A plan file for an instance of the library is a claim too.
    assert script.main(["--folder", str(folder), "add", str(out)]) == 0
    assert "not better" in capsys.readouterr().out


def test_campaigns_are_solved(
    script: ModuleType, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A row of several chasers holds a route each, also an empty one, and gives the plan again."""
    made = adr_opt.generate("tiny", 1, chasers=3)
    library = Library(version="1.0", instances=(Entry(name=made.name, sha256=made.sha256),))
    (folder / "library.json").write_text(library.to_json())
    name, out = made.name, folder / "again.json"
    assert name == "tiny-001-c3"
    there = ["--folder", str(folder)]
    arguments = [*there, "solve", "--time-limit", "20"]
    assert script.main([*arguments, name]) == 2
    assert "'lagrangian' does not follow several chasers" in capsys.readouterr().err
    alone = certify_routes(
        Problem(made), "hand", [(), (1,), ()], seed=0, runtime_s=0.0, upper_bound=8.0
    ).plan
    assert alone is not None
    # Whatever order a plan has its routes in, and if it leaves out those that are empty.
    (route,) = (route for route in alone.routes if route.legs)
    assert script.main([*there, "add", str(saved(folder, alone.replace(routes=(route,))))]) == 0
    assert consistent(script, folder)[name].order == "-/1/-"
    assert script.main([*arguments, "--bound", "none", name]) == 0
    row = consistent(script, folder)[name]
    assert (row.planner_method, row.bound_method) == ("auto", "hand")
    assert row.objective == row.upper_bound == 8.0
    assert script.main([*there, "plan", name, "--out", str(out)]) == 0
    plan = adr_opt.load_plan(out)
    assert adr_opt.check(made, plan) == ()
    assert (len(plan.routes), plan.objective, plan.status) == (3, row.objective, "optimal")


def test_wrong_calls_are_one_sentence(
    script: ModuleType, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Unknown families and plans, and a library that does not fit, are exit 2 before any work."""
    in_library(folder, 1, 2)

    def wrong(*arguments: str) -> str:
        assert script.main(["--folder", str(folder), *arguments]) == 2
        return capsys.readouterr().err

    assert "use one of tiny" in wrong("solve", "--family", "huge")
    assert "has no plan of it" in wrong("plan", "tiny-002", "--out", str(folder / "p.json"))
    assert "no such file" in wrong("solve", "tiny-009")
    library = folder / "library.json"
    sha256 = adr_opt.generate("tiny", 2).sha256
    library.write_text(library.read_text().replace(sha256, "0" * 64))
    assert "generated with sha256" in wrong("solve", "tiny-002")
    assert "no such instance or family" in wrong("verify", "huge")
    for incomplete in ([], ["solve"], ["add"]):
        with pytest.raises(SystemExit, match="2"):
            script.main(["--folder", str(folder), *incomplete])
    with pytest.raises(SystemExit, match="2"):
        script.main(["--folder", str(folder), "plan", "tiny-002"])


def trivial(mission: Mission, *, seed: int, stop: Stop, progress: Progress) -> Result:
    """The sum of all prizes."""
    return certify(
        mission, "trivial", None, seed=seed, runtime_s=0.0, upper_bound=mission.total_prize
    )


def test_instances_are_solved(
    script: ModuleType, folder: Path, mission: Mission, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An instance file is solved with planner and bound, and its row gets both."""
    groups = {
        methods.PLANNERS: [("greedy-guarded", "solvers.planners.greedy:greedy_guarded")],
        methods.BOUNDS: [("trivial", f"{__name__}:trivial")],
    }
    monkeypatch.setattr(
        methods, "entry_points", lambda group: [EntryPoint(*pair, group) for pair in groups[group]]
    )
    path = folder / "tiny" / f"{NAME}.json"
    arguments = ["--folder", str(folder), "solve", "--method", "greedy-guarded"]
    arguments += ["--bound", "trivial"]
    assert script.main([*arguments, "--time-limit", "5", str(path)]) == 0
    row = consistent(script, folder)[NAME]
    assert (row.planner_method, row.bound_method) == ("greedy-guarded", "trivial")
    assert row.upper_bound == mission.total_prize
    assert row.objective > 0.0
    assert "numba" in row.versions
    # One file that is wrong does not keep the others back.
    (folder / "best-known.csv").unlink()
    assert script.main([*arguments, str(folder / "absent.json"), str(path)]) == 2
    assert NAME in consistent(script, folder)


@pytest.fixture
def certified_row(script: ModuleType, folder: Path, mission: Mission) -> Any:
    """The row of an optimal plan whose bound has a certificate, made by the script."""
    result = adr_opt.solve(mission, "exact", time_limit=60)
    assert result.status == "optimal"
    assert result.plan is not None
    there = ["--folder", str(folder)]
    assert script.main([*there, "add", str(saved(folder, result.plan))]) == 0
    assert script.main([*there, "certify", "tiny", "--time-limit", "60"]) == 0
    row = consistent(script, folder)[NAME]
    assert row.certificate == f"certificates/{NAME}.json.gz"
    return row


def test_rows_are_verified(
    script: ModuleType, folder: Path, certified_row: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    """A row as it should be is verified whole; one in which anything was changed is wrong."""
    capsys.readouterr()
    assert script.main(["--folder", str(folder), "verify"]) == 0
    said = capsys.readouterr().out
    assert f"{NAME}: plan 4 checked; bound 4 verified" in said
    assert "1 rows, 0 wrong: 1 plans checked, 1 bounds verified, 0 bounds without" in said
    other = adr_opt.generate("tiny", 2)
    row, alone = certified_row, {"certificate": ""}
    for changes, named in (
        ({"sha256": other.sha256}, "is not that of"),
        (alone | {"objective": 3.0}, "the plan collects 4, not 3"),
        (alone | {"delta_v_m_s": row.delta_v_m_s - 1e-3}, "m/s, not"),
        (alone | {"order": "-".join(reversed(row.order.split("-")))}, "another order"),
        (alone | {"upper_bound": 5.0}, "the gap is 0.2, not 0.0"),
        ({"upper_bound": 3.0, "objective": 3.0}, "its certificate proves 4, not bound 3"),
        (alone | {"plan": "best-known/none.json"}, "no such file"),
        ({"certificate": "certificates/none.json.gz"}, "no such file"),
    ):
        script.write_table(folder, {NAME: replace(row, **changes)})
        assert script.main(["--folder", str(folder), "verify", NAME]) == 1, changes
        assert re.search(f"WRONG: .*{re.escape(named)}", capsys.readouterr().out), changes
    # Without the plan file the plan is made again from its order, and without a proof that is said.
    script.write_table(folder, {NAME: replace(row, plan="", certificate="")})
    assert script.main(["--folder", str(folder), "verify", "tiny"]) == 0
    assert "plan 4 checked; bound 4 without a certificate" in capsys.readouterr().out


def test_a_false_certificate_is_refused(
    script: ModuleType, folder: Path, certified_row: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    """One that claims less than it proves changes nothing, and fails the row where it is kept."""
    path = folder / certified_row.certificate
    table = (folder / "best-known.csv").read_bytes()
    lie = adr_opt.load_certificate(path).replace(upper_bound=3.0)
    lie.save(folder / "lie.json")
    assert script.main(["--folder", str(folder), "add", str(folder / "lie.json")]) == 1
    assert "the certificate is refused" in capsys.readouterr().err
    assert (folder / "best-known.csv").read_bytes() == table
    lie.save(path)
    assert script.main(["--folder", str(folder), "verify"]) == 1
    assert "WRONG" in capsys.readouterr().out


def test_what_others_bring(
    script: ModuleType, folder: Path, mission: Mission, capsys: pytest.CaptureFixture[str]
) -> None:
    """Their plans count if legal, their bounds with a certificate alone; the row names them."""
    there, theirs = ["--folder", str(folder)], ["--who", "Ada Lovelace"]
    result = adr_opt.solve(mission, "exact", time_limit=60)
    assert result.plan is not None
    certificate_of(mission.instance, result).save(folder / "proof.json")
    plan = saved(folder, result.plan)
    bound = bound_file(folder, mission, 4.0)
    assert script.main([*there, "add", str(bound), *theirs]) == 2
    assert "a bound of others counts with its certificate" in capsys.readouterr().err
    assert script.main([*there, "add", str(plan), *theirs]) == 0
    row = consistent(script, folder)[NAME]
    assert (row.who, row.objective, row.upper_bound) == ("Ada Lovelace", 4.0, math.inf)
    assert script.main([*there, "add", str(folder / "proof.json"), *theirs]) == 0
    row = consistent(script, folder)[NAME]
    assert (row.who, row.upper_bound, row.gap) == ("Ada Lovelace", 4.0, 0.0)
    assert row.certificate
    assert script.main([*there, "verify"]) == 0


def test_a_lower_bound_drops_the_certificate_of_a_higher_one(
    script: ModuleType, folder: Path, mission: Mission
) -> None:
    """What is kept proves the bound of its row: a better claim without proof leaves none."""
    there = ["--folder", str(folder)]
    loose = adr_opt.Certificate(
        instance={"name": NAME, "sha256": mission.instance.sha256},
        method="sum of prizes",
        upper_bound=mission.total_prize,
    )
    loose.save(folder / "loose.json")
    assert script.main([*there, "add", str(folder / "loose.json")]) == 0
    assert consistent(script, folder)[NAME].certificate
    assert script.main([*there, "add", str(bound_file(folder, mission, 4.0))]) == 0
    row = consistent(script, folder)[NAME]
    assert (row.upper_bound, row.certificate) == (4.0, "")
