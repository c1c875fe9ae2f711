"""What a mission with nodes that drift takes is known, told and refused before it is built."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
from conftest import Cli, refused
from seeds import first_of

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError
from adr_opt.legs import connection_finder, timetable_size
from adr_opt.mission.mission import Mission
from adr_opt.problem.instance import Instance
from adr_opt.problem.transfer_sizes import transfers_for


def rocket_bodies(days: float = 200.0, targets: int = 6) -> Instance:
    """Some of the rocket bodies for a part of the time."""
    field = adr_opt.generate("rocket-bodies", 1, targets=targets).with_limits(
        duration_s=days * DAY_S
    )
    return field.replace(transfer=transfers_for(days * DAY_S))


@pytest.fixture
def mission_file(cli: Cli) -> str:
    """The file of such a mission, in the folder where ``cli`` runs."""
    Path("drift.json").write_text(rocket_bodies().to_json(), encoding="utf-8")
    return "drift.json"


@pytest.mark.parametrize(
    "instance",
    [
        rocket_bodies(),
        rocket_bodies(days=500.0, targets=12),
        adr_opt.generate("sso", 2, targets=10),
        adr_opt.generate("nominal", 0, targets=8).replace(dynamics="j2"),
    ],
    ids=["rocket-bodies", "longer", "sso", "without long transfers"],
)
def test_connections_are_estimated_by_a_sample(instance: Instance) -> None:
    """Number and memory of all connections are those of the estimate, to a third."""
    size = connection_finder.estimate(instance)
    built = adr_opt.Timetable(instance)
    count = sum(built.connecting.counts.values())
    held = built.connecting.kept.bytes
    held += sum(array.nbytes for array in built.table if isinstance(array, np.ndarray))
    assert size.connections == pytest.approx(count, rel=0.33)
    assert 0.6 * held < size.bytes < 2.0 * held


def test_the_words_say_how_many_and_how_much() -> None:
    """Number of connections with two digits, bodies and GiB are in the words of a size."""
    size = timetable_size.Size(bodies=61, events=500, listed=7000.0)
    assert size.connections == 61 * 60 * 7000
    gibibytes = size.bytes / 2**30
    assert str(size) == (
        f"about 2.6e7 connections of 61 bodies, which take {gibibytes:.2g} GiB of memory"
    )
    assert size.is_large
    assert not timetable_size.Size(bodies=61, events=500, listed=0.0).is_large
    assert not timetable_size.Size(bodies=6, events=500, listed=7000.0).is_large


@pytest.mark.parametrize(
    "call",
    [
        ("solve", "--method", "greedy-guarded"),
        ("solve", "--method", "beam", "--bound", "lagrangian"),
        ("bound", "--method", "lagrangian"),
        ("matrix", "--at", "0", "--out", "m.npz"),
    ],
    ids=lambda call: " ".join(call[:3]),
)
def test_what_does_not_fit_is_refused(
    cli: Cli, mission_file: str, call: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each verb that builds ends with 2 and a sentence on how to shrink the mission."""
    monkeypatch.setattr(timetable_size, "available_bytes", lambda: 1e5)
    refused(
        cli(call[0], mission_file, *call[1:], "--quiet"),  # says when it compiles
        "the mission of 200 days has about",
        "connections of 7 bodies",
        "GiB are free",
        "raise drift_step_s, departure_spacing_s or delta_v_resolution_m_s, lower max_drift_s, "
        "or take fewer targets",
    )
    assert not Path("m.npz").exists()


@pytest.mark.parametrize(
    "call",
    first_of(
        [
            ("solve", "--method", "greedy-guarded"),
            ("matrix", "--at", "0", "--out", "m.npz"),
            ("bound", "--method", "lagrangian", "--time-limit", "1"),
        ],
        gate=2,
    ),
    ids=lambda call: call[0],
)
def test_what_is_large_is_told_beforehand(
    cli: Cli, mission_file: str, call: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The size of a large mission is on standard error, but for --quiet; that of others is not."""
    assert "building about" not in cli(call[0], mission_file, *call[1:]).err
    monkeypatch.setattr(timetable_size, "LARGE_BYTES", 1000.0)
    outcome = cli(call[0], mission_file, *call[1:])
    assert outcome.status == 0
    assert f"building {connection_finder.estimate(rocket_bodies())}" in outcome.err
    assert "building" not in cli(call[0], mission_file, *call[1:], "--quiet").err


def test_without_long_transfers_the_nearest_are_planned_with(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A mission of hours under J2 is planned and bounded as far as memory goes."""
    instance = adr_opt.generate("nominal", 0, targets=12).replace(dynamics="j2")
    instance = instance.with_limits(duration_s=0.5 * DAY_S)
    size = connection_finder.estimate(instance)
    table = size.bytes - timetable_size.BYTES_PER_CONNECTION * size.connections
    half = table / timetable_size.MEMORY_SHARE / 2.0
    monkeypatch.setattr(timetable_size, "available_bytes", lambda: half)
    result = adr_opt.solve(instance, "greedy-guarded")
    assert result.plan is not None
    assert adr_opt.check(instance, result.plan) == ()
    assert any("of the nearest" in note for note in result.notes)
    bound = adr_opt.bound(instance, "lagrangian")
    monkeypatch.undo()
    optimum = adr_opt.solve(instance, "exact")
    assert bound.upper_bound >= optimum.upper_bound == optimum.objective >= result.objective


def test_grids_of_seconds_are_estimated_in_no_time() -> None:
    """A grid so fine that one pair would not fit is refused within seconds, and by its number."""
    coarse = rocket_bodies()
    fine = coarse.replace(
        transfer=coarse.transfer.replace(drift_step_s=10.0, departure_spacing_s=0.0)
    )
    began = time.process_time()
    size = connection_finder.estimate(fine)
    assert time.process_time() - began < 5.0
    steps = (coarse.transfer.drift_step_s / 10.0) ** 2
    assert size.connections > 0.1 * steps * connection_finder.estimate(coarse).connections
    with pytest.raises(InputError, match="raise drift_step_s"):
        adr_opt.solve(fine, "greedy-guarded")


def test_a_coarser_sample_says_what_a_full_one_says(monkeypatch: pytest.MonkeyPatch) -> None:
    """The number of connections scaled up from a coarser grid is that of the grid, to a half."""
    field = adr_opt.generate("rocket-bodies", 1, targets=6)
    whole = connection_finder.estimate(field).connections
    monkeypatch.setattr(connection_finder, "SAMPLED_STEPS", 60)
    monkeypatch.setattr(connection_finder, "SAMPLED_EVENTS", 120)
    assert connection_finder.estimate(field).connections == pytest.approx(whole, rel=0.5)


def test_connections_that_do_not_fit_are_worked_out_when_asked(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With room for some pairs only, tables, plans and bounds are those of a large memory."""
    instance = adr_opt.generate("rocket-bodies", 1, targets=8)
    whole = adr_opt.Timetable(instance)
    size = connection_finder.estimate(instance)
    room = (size.bytes - 0.5 * whole.connecting.kept.bytes) / timetable_size.MEMORY_SHARE
    monkeypatch.setattr(timetable_size, "available_bytes", lambda: room)
    monkeypatch.setattr(timetable_size, "PAIRS_AT_ONCE", 4)
    small = adr_opt.Timetable(instance)
    kept = small.connecting.kept
    assert 4 <= len(kept) < len(whole.connecting.kept)
    assert kept.bytes <= connection_finder.estimate(instance).room_bytes
    for one, other in zip(small.table, whole.table, strict=True):
        np.testing.assert_array_equal(one, other)
    missions = [Mission(instance, made) for made in (small, whole)]
    for method in ("beam", "exact"):
        few, all_ = (adr_opt.solve(mission, method, time_limit=60) for mission in missions)
        assert few.sequence == all_.sequence
        assert few.upper_bound == all_.upper_bound
    assert len(kept) < len(whole.connecting.kept)
