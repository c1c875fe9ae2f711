"""Limits hold while the timetable is built: what is there is planned with, and it is said."""

from __future__ import annotations

import math
import time
from pathlib import Path

import numpy as np
import pytest
from hand_made import hand_made

import adr_opt
from adr_opt import available_memory, candidates, front, timetable, timetable_size
from adr_opt.errors import InputError
from adr_opt.instance import Instance
from adr_opt.mission import Mission
from adr_opt.planner import BOUNDS, PLANNERS
from adr_opt.result import Result
from adr_opt.stop import Interrupted

LATE_S = 3.0
"""How late an answer may be on a busy machine."""


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Builds are broken off even if they are nearly done."""
    monkeypatch.setattr(candidates, "MOMENT_S", -math.inf)


@pytest.fixture
def in_small_steps(impatient: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tables are built pair by pair, so that little of a small one can be broken off."""
    monkeypatch.setattr(timetable, "SLICE_ENTRIES", 1)


def broken_off(
    instance: Instance, share: float, group: str = PLANNERS, method: str = "beam", **arguments
) -> Result:
    """Plan (or bound) with somebody who interrupts when a share of the timetable is built."""
    stop = Interrupted()

    def building(built: float) -> None:
        if built >= share:
            stop.interrupt()

    return front.run(
        group, Mission(instance, threads=1), method, time_limit=60.0, stop=stop,
        building=building, **arguments,
    )  # fmt: skip


def large(targets: int = 143, days: float = 365.0) -> Instance:
    """A mission whose timetable takes minutes."""
    instance = adr_opt.generate("nominal", 0, targets=targets)
    return instance.with_limits(duration_s=86400.0 * days)


@pytest.mark.usefixtures("in_small_steps")
@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9])
@pytest.mark.parametrize("threads", [1, 2])
def test_a_table_that_is_broken_off_is_whole_for_the_first_bodies(share, threads):
    """It has the same bits as the table of the instance of these bodies alone."""
    instance = adr_opt.generate("tiny", 3, targets=9, zones=2)
    order = [0, 7, 2, 9, 4, 1, 3, 8, 6, 5]
    part = timetable.Timetable(instance, threads, order=order, enough=lambda built: built > share)
    count = len(part.names)
    assert math.sqrt(share) * 10 - 1 <= count < 10
    assert set(part.names) == {instance.names[body] for body in order[:count]}
    assert [name for name in instance.names if name in part.names] == list(part.names)
    alone = timetable.Timetable(part.instance, 1)
    for one, other in zip(part.table, alone.table, strict=True):
        assert one.flags.c_contiguous
        events = alone.most_events
        one = one[:, :events] if one.ndim > 2 else one
        assert np.array_equal(one, other)


@pytest.mark.usefixtures("in_small_steps")
def test_a_plan_of_a_part_is_a_plan_of_the_whole():
    """Interrupted half-way, the plan passes the check and says which targets it left out."""
    instance = adr_opt.generate("nominal", 0, targets=20)
    result = broken_off(instance, 0.5)
    assert result.plan is not None
    assert adr_opt.check(instance, result.plan) == ()
    assert result.plan.instance.sha256 == instance.sha256
    assert result.status == result.plan.status == "feasible"
    assert result.upper_bound == math.inf
    assert result.plan.upper_bound is None
    names = [instance.names[body] for body in result.sequence or ()]
    assert names == list(result.plan.destinations)
    left_out = [entry for entry in result.plan.unvisited if entry.reason == "not-considered"]
    visited = {name for name in names if name != "station"}
    listed = {entry.target for entry in result.plan.unvisited}
    assert visited | listed == set(instance.names[1:])
    assert not visited & listed
    count = 20 - len(left_out)
    assert 12 <= count < 20
    assert any(
        note.startswith(f"planned with the nearest {count} of 20 targets")
        for note in result.plan.notes
    )
    assert result.plan.notes == result.notes


@pytest.mark.usefixtures("in_small_steps")
def test_the_part_has_the_nearest_targets():
    """Every target that was planned with is nearer to the station's orbit than those left out."""
    instance = adr_opt.generate("nominal", 0, targets=20)
    order = candidates.nearest_first(instance, ())
    assert order[0] == 0
    result = broken_off(instance, 0.5)
    assert result.plan is not None
    left_out = {entry.target for entry in result.plan.unvisited if entry.reason == "not-considered"}
    assert left_out == {instance.names[body] for body in order[-len(left_out) :]}


def test_nearest_is_by_delta_v():
    """Targets come by their change of plane and height, those without a prize last."""
    instance = hand_made()
    north, beyond, south = (instance.names.index(name) for name in ("north", "beyond", "south"))
    order = candidates.nearest_first(instance, ())
    assert order.index(beyond) > max(order.index(north), order.index(south))
    worthless = instance.replace(
        targets=[
            target.replace(prize=0.0) if target.name == "north" else target
            for target in instance.targets
        ]
    )
    assert candidates.nearest_first(worthless, ())[-1] == north
    assert candidates.nearest_first(instance, ("beyond",))[1] == beyond


@pytest.mark.usefixtures("in_small_steps")
def test_all_prizes_by_a_part_are_optimal():
    """Where only targets without a prize were left out, collecting all prizes is still a proof."""
    instance = adr_opt.generate("tiny", 1)
    some = instance.replace(
        targets=[
            target.replace(prize=float(number == 0))
            for number, target in enumerate(instance.targets)
        ]
    )
    result = broken_off(some, 0.3)
    assert any("planned with the nearest" in note for note in result.notes)
    assert result.objective == 1.0
    assert result.status == "optimal"


@pytest.mark.usefixtures("in_small_steps")
def test_a_start_plan_is_kept_by_a_part():
    """The targets of a start plan are built first, so that it is never lost."""
    instance = adr_opt.generate("nominal", 0, targets=20)
    order = candidates.nearest_first(instance, ())
    far = instance.part([0, *order[-6:]])
    plan = adr_opt.solve(far, "beam").plan
    assert plan is not None
    start = [instance.names.index(name) for name in plan.destinations]
    kept = adr_opt.Mission(instance).time(start)
    result = broken_off(instance, 0.3, method="local-search", start=start[: kept.made])
    assert kept.made > 2
    assert result.objective >= kept.objective
    assert result.plan is not None
    assert adr_opt.check(instance, result.plan) == ()


@pytest.mark.usefixtures("in_small_steps")
def test_a_bound_of_a_part_is_no_bound():
    """A bound that was broken off during the build proves no more than the sum of all prizes."""
    instance = adr_opt.generate("tiny", 1)
    result = broken_off(instance, 0.3, BOUNDS, "lagrangian")
    assert result.upper_bound == len(instance.targets)
    assert result.status == "unknown"
    assert "there was no time to begin" in result.notes[0]
    both = broken_off(instance, 0.9, method="beam", bound="lagrangian")
    assert both.plan is not None
    assert both.upper_bound == math.inf


def test_who_interrupts_a_quick_build_still_gets_a_plan():
    """What is done in a moment is waited for: somebody who is early is not left with nothing."""
    result = broken_off(adr_opt.generate("nominal", 0, targets=20), 0.0)
    assert result.objective > 5.0


@pytest.mark.usefixtures("impatient")
@pytest.mark.parametrize("method", ["beam", "auto", "greedy"])
def test_interrupted_before_anything_there_is_no_plan(method):
    """Nothing built is no plan, said in one sentence, and no failure."""
    result = broken_off(adr_opt.generate("nominal", 0), 0.0, method=method)
    assert result.plan is None
    assert result.status == "unknown"
    assert "there was no time to begin" in result.notes[0]


def test_a_limit_holds_for_the_timetable():
    """A year of 143 targets and a limit of two seconds: a legal plan, about on time."""
    instance = large()
    adr_opt.solve(adr_opt.generate("tiny", 0), "beam")
    began = time.perf_counter()
    result = adr_opt.solve(instance, "beam", time_limit=2.0)
    assert time.perf_counter() - began < 2.0 + LATE_S
    assert result.plan is not None
    assert adr_opt.check(instance, result.plan) == ()
    assert result.objective >= 1.0
    assert any("of 143 targets" in note for note in result.notes)


def test_a_usual_field_is_never_cut():
    """However short the limit, all targets of a tiny field are planned with."""
    result = adr_opt.solve(adr_opt.generate("tiny", 1), "beam", time_limit=1e-6)
    assert not any("planned with" in note for note in result.notes)


def test_the_size_of_a_timetable_is_known_before():
    """The estimate is the table's: as many bytes, and at least as many entries."""
    instance = adr_opt.generate("tiny", 2)
    size, table = timetable_size.estimate(instance), timetable.Timetable(instance)
    held = sum(array.nbytes for array in table.table)
    assert held <= size.bytes <= 1.01 * held + 100 * len(table.names) ** 2
    assert table.entries <= size.entries <= 1.1 * table.entries + 60


def test_too_large_a_timetable_is_refused(monkeypatch):
    """Where memory is short, a sentence says how much is needed and free, and what to do."""
    instance = adr_opt.generate("tiny", 2)
    monkeypatch.setattr(timetable_size, "available_bytes", lambda: 1e4)
    pattern = (
        r"timetable of 7 bodies over 1.5 days takes .* GiB, and .* GiB of memory are free; take"
    )
    with pytest.raises(InputError, match=pattern):
        timetable.Timetable(instance)
    with pytest.raises(InputError, match=pattern):
        adr_opt.bound(instance, "lagrangian")


def test_memory_limits_the_candidates(monkeypatch):
    """Where memory is short, the nearest targets that fit are planned with."""
    instance = adr_opt.generate("nominal", 0, targets=20)
    half = timetable_size.estimate(instance).bytes / timetable_size.MEMORY_SHARE / 2.0
    monkeypatch.setattr(timetable_size, "available_bytes", lambda: half)
    result = adr_opt.solve(instance, "beam")
    assert result.plan is not None
    assert adr_opt.check(instance, result.plan) == ()
    assert any("GiB of memory" in note for note in result.notes)
    left_out = [entry for entry in result.plan.unvisited if entry.reason == "not-considered"]
    assert 5 <= len(left_out) <= 8


def test_control_groups_limit_the_memory(tmp_path: Path):
    """The least of the limits of all groups above a process counts, less what is in use."""
    group = tmp_path / "sys" / "outer" / "inner"
    group.mkdir(parents=True)
    for folder, limit in ((group, "max"), (group.parent, "1000")):
        (folder / "memory.max").write_text(limit)
        (folder / "memory.current").write_text("700")
        (folder / "memory.stat").write_text("anon 600\ninactive_file 50\n")
    old = tmp_path / "sys" / "memory"
    old.mkdir()
    (old / "memory.limit_in_bytes").write_text("900")
    (old / "memory.usage_in_bytes").write_text("700")
    (old / "memory.stat").write_text("inactive_file 0\n")
    membership = tmp_path / "cgroup"
    membership.write_text("0::/outer/inner\n")
    assert available_memory._of_the_group(tmp_path / "sys", membership) == 350.0
    membership.write_text("4:memory:/not/seen/from/here\n0::/outer/inner\n")
    assert available_memory._of_the_group(tmp_path / "sys", membership) == 200.0
    assert available_memory._of_the_group(tmp_path, tmp_path / "none") == math.inf
    assert available_memory.available_bytes() > 0.0
