"""Limits hold while the timetable is built: what is there is planned with, and it is said."""

from __future__ import annotations

import itertools
import math
import time
from pathlib import Path

import numpy as np
import pytest
from fields import on_rows
from hand_made import hand_made

import adr_opt
from adr_opt.common import clock, memory
from adr_opt.common.constants import MU_M3_S2
from adr_opt.common.errors import InputError
from adr_opt.common.stop import Interrupted
from adr_opt.kernels.tables import timetable as tables
from adr_opt.kernels.tables import timetable_making as making
from adr_opt.kernels.tables.timetable_making import Pairs
from adr_opt.legs import connection_finder, timetable, timetable_size
from adr_opt.legs.nearest_pairs import all_pairs, nearest_pairs
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result
from adr_opt.problem import given
from adr_opt.problem.instance import Instance
from adr_opt.run import front, table_budget
from adr_opt.run.methods import BOUNDS, PLANNERS

LATE_S = 3.0
"""How late an answer may be."""


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Builds are broken off even if they are nearly done."""
    monkeypatch.setattr(table_budget, "MOMENT_S", -math.inf)


@pytest.fixture
def in_small_steps(impatient: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tables are built pair by pair, so that little of a small one can be broken off."""
    monkeypatch.setattr(timetable, "SLICE_ENTRIES", 1)


def broken_off(
    instance: Instance, share: float, group: str = PLANNERS, method: str = "beam", **arguments
) -> Result:
    """Plan (or bound) with an interruption when a share of the timetable is built."""
    stop = Interrupted()

    def building(built: float) -> None:
        if built >= share:
            stop.interrupt()

    return front.run(
        group,
        Mission(instance, threads=1),
        method,
        front.RunOptions(60.0, **arguments),
        stop=stop,
        building=building,
    )


def large(targets: int = 143, days: float = 365.0) -> Instance:
    """A mission whose timetable takes minutes."""
    instance = adr_opt.generate("nominal", 0, targets=targets)
    return instance.with_limits(duration_s=86400.0 * days)


def entries_of(table: timetable.Timetable, i: int, j: int) -> list[tuple[float, float, float]]:
    """Departure, ΔV and arrival of all events of a pair."""
    return [
        (tables.departure_at(table.table, i, j, m), *tables.entry_at(table.table, i, j, m))
        for m in range(tables.events(table.table, i, j))
    ]


def drawn_fields() -> list[Instance]:
    """Fields where events are regular, and where they are not; with zones and windows."""
    return [
        adr_opt.generate("tiny", 3, targets=9, zones=2),
        adr_opt.generate("tiny", 5, targets=9).replace(dynamics="j2"),
        adr_opt.generate("campaign", 0, targets=9, chasers=1).with_limits(2 * 86400.0),
    ]


@pytest.mark.usefixtures("in_small_steps")
@pytest.mark.parametrize("field", range(3))
@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9])
@pytest.mark.parametrize("threads", [1, 2])
def test_a_table_that_is_broken_off_holds_the_first_pairs(field, share, threads):
    """The pairs that it has have the same bits as in the table of all, the others no event."""
    instance = drawn_fields()[field]
    bodies = len(instance.names)
    for ranks in (4, bodies - 1):
        pairs = nearest_pairs(instance, (), ranks)
        part = timetable.Timetable(
            instance, threads, pairs=pairs, enough=lambda built: built > share
        )
        whole = timetable.Timetable(instance, 1)
        assert part.built >= min(share * bodies * (bodies - 1), pairs.near.size)
        assert part.is_whole == (part.built == bodies * (bodies - 1))
        there = [making.pair_at(number, pairs) for number in range(part.built)]
        there = {(int(i), int(pairs.near[i, rank])) for i, rank in there}
        assert len(there) == part.built
        for i in range(bodies):
            for j in range(bodies):
                wanted = entries_of(whole, i, j) if (i, j) in there else []
                assert entries_of(part, i, j) == wanted
                for time_s in (0.0, 4e4):
                    found = part.lookup(i, j, time_s)
                    expected = whole.lookup(i, j, time_s) if (i, j) in there else (np.inf, np.inf)
                    assert found == expected or i == j


@pytest.mark.parametrize("bodies", [1, 2, 17, 40])
@pytest.mark.parametrize("ranks", [0, 1, 16, 17, 39])
def test_pairs_come_once_and_in_waves(bodies, ranks):
    """Every origin has as many of its destinations, up to a wave, before any has more."""
    ranks = min(ranks, bodies - 1)
    pairs = Pairs(np.arange(bodies)[::-1], all_pairs(bodies).near[:, :ranks])
    found = [making.pair_at(number, pairs) for number in range(bodies * ranks)]
    assert len(set(found)) == bodies * ranks
    waves = [rank // making.WAVE for _, rank in found]
    assert waves == sorted(waves)
    assert all(j != i for i in range(bodies) for j in pairs.near[i])


@pytest.mark.usefixtures("in_small_steps")
def test_a_plan_on_some_pairs_is_a_plan_of_the_whole():
    """Interrupted half-way, the plan passes the check, proves nothing, and says what is missing."""
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
    visited = {name for name in names if name != "station"}
    listed = {entry.target for entry in result.plan.unvisited}
    assert visited | listed == set(instance.names[1:])
    assert not visited & listed
    assert any("of 20 destinations of each body" in note for note in result.plan.notes)
    assert result.plan.notes == result.notes


def test_a_target_that_no_pair_leads_to_was_not_considered():
    """A target without a search for transfers is not said to have none."""
    instance = adr_opt.generate("nominal", 0, targets=20)
    mission = Mission(instance)
    mission.build(nearest_pairs(instance, (), 3))
    result = adr_opt.solve(mission, "beam", width=10)
    assert result.plan is not None
    reasons = {entry.target: entry.reason for entry in result.plan.unvisited}
    near = set(np.unique(mission.timetable.pairs.near).tolist())
    far = [instance.names[body] for body in range(1, 21) if body not in near]
    assert far
    assert {reasons[name] for name in far} == {"not-considered"}
    assert "no-transfer" not in reasons.values()


def delta_v_floor(instance: Instance, i: int, j: int) -> float:
    """ΔV of turning the plane and changing the height, as it is at t = 0 [m/s]."""
    one, other = instance.body_orbits[i], instance.body_orbits[j]
    normals = []
    for orbit in (one, other):
        tilt, node = math.radians(orbit.inclination_deg), math.radians(orbit.raan_deg)
        normals.append(
            (math.sin(tilt) * math.sin(node), -math.sin(tilt) * math.cos(node), math.cos(tilt))
        )
    speed = math.sqrt(MU_M3_S2 / one.semi_major_axis_m)
    turn = speed * math.dist(*normals)
    climb = 0.5 * speed * (other.semi_major_axis_m / one.semi_major_axis_m - 1.0)
    return math.hypot(turn, climb)


def test_nearest_is_by_delta_v():
    """Of fifty drawn bodies each lists the others by what plane and height cost, stations first."""
    instance = adr_opt.generate("nominal", 4, targets=50)
    pairs = nearest_pairs(instance, (), 50)
    for i in range(51):
        listed = pairs.near[i].tolist()
        assert sorted([*listed, i]) == list(range(51))
        assert i == 0 or listed[0] == 0
        costs = [delta_v_floor(instance, i, j) for j in listed if j != 0]
        assert all(later >= 0.98 * earlier for earlier, later in itertools.pairwise(costs))


def test_nearest_first_are_those_wanted_and_worthless_last():
    """Origins come by their distance from the start; what is asked for first, worthless last."""
    instance = hand_made()
    north, beyond, south = (instance.names.index(name) for name in ("north", "beyond", "south"))
    order = nearest_pairs(instance, (), 9).origins.tolist()
    assert order[0] == 0
    assert order.index(beyond) > max(order.index(north), order.index(south))
    worthless = instance.replace(
        targets=[
            target.replace(prize=0.0) if target.name == "north" else target
            for target in instance.targets
        ]
    )
    pairs = nearest_pairs(worthless, (), 9)
    assert pairs.origins[-1] == north
    assert pairs.near[0, -1] == north
    assert nearest_pairs(instance, ("beyond",), 9).origins[1] == beyond


@pytest.mark.usefixtures("in_small_steps")
def test_all_prizes_by_a_part_are_optimal():
    """Where all prizes are collected on some pairs, that is still a proof."""
    instance = adr_opt.generate("tiny", 1)
    some = instance.replace(
        targets=[
            target.replace(prize=float(number == 0))
            for number, target in enumerate(instance.targets)
        ]
    )
    result = broken_off(some, 0.3)
    assert any("so nothing is proven" in note for note in result.notes)
    assert result.objective == 1.0
    assert result.status == "optimal"


@pytest.mark.usefixtures("in_small_steps")
def test_a_start_plan_is_kept_by_a_part():
    """A start plan over pairs that the table does not hold is never lost."""
    instance = adr_opt.generate("nominal", 0, targets=20)
    order = nearest_pairs(instance, (), 20).origins.tolist()
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
    result = broken_off(instance, 0.3, BOUNDS, "routing-bound")
    assert result.upper_bound == len(instance.targets)
    assert result.status == "unknown"
    assert "there was no time to begin" in result.notes[0]
    both = broken_off(instance, 0.9, method="beam", bound="lagrangian")
    assert both.plan is not None
    assert both.upper_bound == math.inf


def test_who_interrupts_a_quick_build_still_gets_a_plan():
    """A build that is nearly done is waited for: an early interrupt still gives a plan."""
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


def test_a_limit_holds_for_the_timetable(monkeypatch):
    """A year of 143 targets and a limit of two seconds: a legal plan, about on time."""
    instance = large()
    adr_opt.solve(adr_opt.generate("tiny", 0), "beam")
    monkeypatch.setattr(clock, "_seconds", clock._seconds)
    monkeypatch.setattr(clock, "_pauses", [])
    clock.count_processor_time()
    began = time.process_time()
    result = adr_opt.solve(instance, "beam", time_limit=2.0)
    assert time.process_time() - began < 2.0 + LATE_S
    assert result.plan is not None
    assert adr_opt.check(instance, result.plan) == ()
    assert result.objective >= 1.0
    assert any("of 143 destinations" in note for note in result.notes)


def test_a_usual_field_is_never_cut():
    """However short the limit, all targets of a tiny field are planned with."""
    result = adr_opt.solve(adr_opt.generate("tiny", 1), "beam", time_limit=1e-6)
    assert not any("planned with" in note for note in result.notes)


def test_the_size_of_a_timetable_is_known_before():
    """The estimate is the table's: as many bytes, and at least as many entries."""
    instance = adr_opt.generate("tiny", 2)
    size, table = connection_finder.estimate(instance), timetable.Timetable(instance)
    held = sum(array.nbytes for array in table.table[:-1])
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
        adr_opt.bound(instance, "routing-bound")


def test_memory_limits_the_pairs(monkeypatch):
    """Where memory is short, the nearest destinations that fit are planned with, and no more."""
    instance = adr_opt.generate("nominal", 0, targets=20)
    half = connection_finder.estimate(instance).bytes / timetable_size.MEMORY_SHARE / 2.0
    monkeypatch.setattr(timetable_size, "available_bytes", lambda: half)
    mission = Mission(instance)
    result = adr_opt.solve(mission, "beam")
    assert result.plan is not None
    assert adr_opt.check(instance, result.plan) == ()
    assert any("GiB of memory" in note for note in result.notes)
    held = sum(array.nbytes for array in mission.timetable.table[:-1])
    assert 0.3 * half < held < timetable_size.MEMORY_SHARE * half
    assert 7 <= mission.timetable.pairs.near.shape[1] <= 10
    assert mission.with_time_value(200.0) is mission


def test_memory_is_a_setting():
    """A plan within a memory limit is made on a table that takes no more; nonsense is refused."""
    instance = adr_opt.generate("nominal", 0, targets=20)
    held = connection_finder.estimate(instance).bytes
    mission = Mission(instance)
    result = adr_opt.solve(mission, "beam", memory_gib=held / 2.0**31)
    assert adr_opt.check(instance, result.plan) == ()
    assert sum(array.nbytes for array in mission.timetable.table[:-1]) <= held / 2.0
    assert not mission.is_whole
    drifting = Mission(adr_opt.generate("rocket-bodies", 0))
    adr_opt.solve(drifting, "greedy", memory_gib=1e-3)
    assert drifting.connecting.kept.bytes <= 2**20
    for wrong in (0.0, -1.0, math.nan):
        with pytest.raises(InputError, match=r"memory_gib = .*: must be a number above 0"):
            adr_opt.solve(instance, memory_gib=wrong)


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
    assert memory._of_the_group(tmp_path / "sys", membership) == 350.0
    membership.write_text("4:memory:/not/seen/from/here\n0::/outer/inner\n")
    assert memory._of_the_group(tmp_path / "sys", membership) == 200.0
    assert memory._of_the_group(tmp_path, tmp_path / "none") == math.inf
    assert memory.available_bytes() > 0.0


def test_a_table_of_given_connections_holds_the_pairs_that_have_any():
    """It is whole without the others, whose looking up takes longer, and so is a part of it."""
    instance = on_rows(30, near=4)
    whole = timetable.Timetable(instance)
    kept = given.among(instance.given, [instance.names[0], *instance.names[6:]])
    fewer = instance.with_given(kept).replace(targets=instance.targets[5:])
    part = whole.of_variant(fewer, whole.connecting.shortened(fewer))
    for held in (whole, part, timetable.Timetable(fewer)):
        bodies = len(held.names)
        every = timetable.Timetable(held.instance, pairs=all_pairs(bodies))
        assert held.is_whole
        assert held.built <= 4 * bodies
        for i, j in itertools.permutations(range(bodies), 2):
            for ready in (0.0, 3e4, 6e4):
                assert held.lookup(i, j, ready) == every.lookup(i, j, ready)


def test_a_large_field_has_a_plan_before_its_table(monkeypatch):
    """Methods that plan on a table tell the guarded greedy plan first, and never fall below it."""
    monkeypatch.setattr(table_budget, "LARGE_ENTRIES", 0)
    monkeypatch.setattr(timetable_size.Size, "pair_s", property(lambda size: 0.1))
    instance = adr_opt.generate("nominal", 0, targets=20)
    quick = adr_opt.solve(instance, "greedy-guarded")
    for method in ("mcts", "local-search"):
        told: list[float] = []
        found = adr_opt.solve(
            instance,
            method,
            iterations=1,
            time_limit=9.0,
            progress=lambda known, _, told=told: told.append(known),
        )
        assert told[0] == quick.objective
        assert found.objective >= quick.objective


def test_without_time_for_a_table_the_quick_plan_is_the_plan(monkeypatch):
    """Where a large field leaves no time for a table, it is said whose plan there is."""
    monkeypatch.setattr(table_budget, "LARGE_ENTRIES", 0)
    monkeypatch.setattr(timetable_size.Size, "pair_s", property(lambda size: 0.1))
    monkeypatch.setattr(table_budget, "nearest_pairs", None)  # no table is begun
    instance = adr_opt.generate("nominal", 0, targets=20)
    quick = adr_opt.solve(instance, "greedy-guarded")
    found = adr_opt.solve(instance, "ortools", time_limit=1.0)
    assert (found.method, found.sequence) == ("ortools", quick.sequence)
    assert "ortools ran out of time: the plan is that of greedy-guarded" in found.notes
