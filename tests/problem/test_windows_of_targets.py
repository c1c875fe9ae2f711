"""Several windows of a target, captures, and their files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.judge.check.violation import Violation
from adr_opt.legs.service_limits import limits_of
from adr_opt.mission.mission import Mission
from adr_opt.plan.plan import Plan
from adr_opt.problem.bodies import Target
from adr_opt.problem.capture_windows import read_windows
from adr_opt.problem.instance import Instance

HOURS = 3600.0


@pytest.fixture
def instance() -> Instance:
    """Three targets in a day, with services of an hour."""
    made = adr_opt.generate("tiny", 0, targets=3)
    return made.replace(mission=made.mission.replace(service_revolutions=None, service_s=HOURS))


def with_first(instance: Instance, **changes: Any) -> Instance:
    return instance.replace(targets=(instance.targets[0].replace(**changes), *instance.targets[1:]))


def test_windows_are_in_order_and_apart(instance: Instance) -> None:
    """They are sorted, joined where they touch, and written in the newest format alone."""
    made = with_first(instance, windows_s=[[9e3, 2e4], [5e3, 6e3], [6e3, 9e3], [3e4, None]])
    assert made.targets[0].windows == ((5e3, 2e4), (3e4, None))
    assert json.loads(made.to_json())["format"] == "adr-opt-instance/3"
    assert Instance.from_json(made.to_json()) == made
    assert "windows_s" not in instance.to_json()
    assert json.loads(instance.to_json())["format"] == "adr-opt-instance/2"


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"windows_s": [[0, 9]], "window_s": (0.0, 9.0)}, "window_s as well"),
        ({"windows_s": [[9, 3]]}, "must not close before it opens"),
        ({"windows_s": []}, "windows_s"),
        ({"capture_s": 3601.0}, "longer than the service"),
        ({"capture_s": -1.0}, "capture_s"),
    ],
)
def test_what_makes_no_sense_is_refused(
    instance: Instance, changes: dict[str, Any], said: str
) -> None:
    """One sentence says which field is wrong."""
    with pytest.raises(InputError, match=said):
        with_first(instance, **changes)


def test_captures_are_no_longer_than_revolutions() -> None:
    """A service in revolutions lasts as long as those of the target."""
    made = adr_opt.generate("tiny", 0, targets=1)
    stay_s = float(limits_of(made).service[-1])
    assert with_first(made, capture_s=stay_s).targets[0].capture_s == stay_s
    with pytest.raises(InputError, match="longer than the service"):
        with_first(made, capture_s=1.001 * stay_s)


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_windows_stand_in_a_file(instance: Instance, suffix: str, tmp_path: Path) -> None:
    """Saved and read again they are the same; one that is not named is never captured."""
    names = [target.name for target in instance.targets]
    rows = {names[0]: np.array([[5e3, 6e3], [1e4, 2e4]]), names[1]: np.array([[0.0, 9e4]])}
    made = instance.with_windows(rows, capture_s=600.0)
    if suffix == "parquet":
        pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
        listed = [(name, a, b) for name, each in rows.items() for a, b in each.tolist()]
        columns = ("target", "opens_s", "closes_s")
        table = pa.table(dict(zip(columns, map(list, zip(*listed, strict=True)), strict=True)))
        pq.write_table(table, tmp_path / "w.parquet")
        made = instance.with_windows(read_windows(tmp_path / "w.parquet"), "w.parquet", 600.0)
    made.save(tmp_path / "a.json")
    again = adr_opt.load(tmp_path / "a.json")
    assert again == made
    assert again.sha256 == made.sha256
    for target in again.targets:
        wanted = rows.get(target.name, np.empty((0, 2)))
        assert again.intervals_of(target).tolist() == wanted.tolist()
        assert target.capture_s == 600.0
    windows = limits_of(again).windows
    assert windows.closing[-1] == -np.inf
    part = again.part([names[0]])
    assert Mission(part).rules.windows.opening[-1] == 5e3
    part.save(tmp_path / "part.json")  # beside the whole, whose file it leaves alone
    assert adr_opt.load(tmp_path / "part.json") == part
    assert adr_opt.load(tmp_path / "a.json") == made


def test_a_file_of_windows_has_to_be_the_one_named(instance: Instance, tmp_path: Path) -> None:
    """Another content, an unknown target, no file, and windows of a target are refused."""
    name = instance.targets[0].name
    made = instance.with_windows({name: np.array([[5e3, 6e3]])})
    path = tmp_path / "a.json"
    made.save(path)
    (tmp_path / "windows.csv").write_text(f"target,opens_s,closes_s\n{name},5000,7000\n")
    with pytest.raises(InputError, match="not the windows"):
        adr_opt.load(path)
    (tmp_path / "windows.csv").unlink()
    with pytest.raises(InputError, match="no such file"):
        adr_opt.load(path)
    with pytest.raises(InputError, match="was not read"):
        adr_opt.Timetable(json.loads(made.to_json()))
    with pytest.raises(InputError, match="is not a target"):
        instance.with_windows({"other": np.array([[0.0, 1.0]])})
    with pytest.raises(InputError, match="windows of its own"):
        with_first(made, window_s=(0.0, 9e3))


def visited(instance: Instance) -> tuple[Plan, Target]:
    """A plan, and the target that it visits first."""
    plan = adr_opt.solve(instance, "greedy", time_limit=10.0).plan
    assert plan is not None
    names = {target.name: target for target in instance.targets}
    return plan, names[plan.legs[0].destination]


def judged(
    instance: Instance, plan: Plan, *windows: tuple[float, float | None], **more: Any
) -> tuple[Violation, ...]:
    """What `check` finds where the first target that is visited has windows."""
    name = plan.legs[0].destination
    targets = tuple(
        target.replace(windows_s=windows, **more) if target.name == name else target
        for target in instance.targets
    )
    made = instance.replace(targets=targets)
    return adr_opt.check(made, plan.replace(instance=plan.instance.replace(sha256=made.sha256)))


def test_check_knows_windows_and_captures(instance: Instance) -> None:
    """A stay whose capture is within a window is right, and what has to wait or jumps is not."""
    plan, _ = visited(instance)
    arrival, end = plan.legs[0].arrival_s, plan.legs[0].end_s
    assert judged(instance, plan, (0.0, 1.0), (arrival - 60.0, end)) == ()
    assert judged(instance, plan, (arrival - 60.0, end + 1e-7), (end + 1e3, None)) == ()
    early = arrival - 60.0, end - 60.0
    assert {found.rule for found in judged(instance, plan, early)} == {"window"}
    assert "service" in {found.rule for found in judged(instance, plan, early, (end, None))}
    assert judged(instance, plan, early, (end, None), capture_s=HOURS - 60.0) == ()
    assert judged(instance, plan, early, (end, None), capture_s=HOURS - 59.0) != ()


def test_check_takes_either_side_of_an_edge(instance: Instance) -> None:
    """At a closing edge, within the slack, who begins at once keeps to the rule, and who waits."""
    plan, _ = visited(instance)
    leg = plan.legs[0]
    edge = leg.end_s - 5e-7, leg.end_s + 4e3
    assert judged(instance, plan, (0.0, edge[0]), (edge[1], None)) == ()
    only = plan.replace(
        routes=(plan.routes[0].replace(legs=(leg.replace(end_s=edge[1] + HOURS),)),)
    )
    found = judged(instance, only, (0.0, edge[0]), (edge[1], None))
    assert {violation.rule for violation in found}.isdisjoint({"window", "service"})
