"""The time that ephemerides cover: metadata and states at both ends, and no holes."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from datetime import timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from catalogue_files import as_json, field
from conftest import Cli
from messages import label, oem, oem_in_xml

from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError
from adr_opt.judge.refined.as_reported import interpolated_states
from adr_opt.problem.frame import Frame
from adr_opt.sources.catalogue.propagation import state as sgp4_state
from adr_opt.sources.ephemerides.by_table import ByTable
from adr_opt.sources.ephemerides.coverage import Coverage, holes
from adr_opt.sources.ephemerides.ephemeris import TurningAxes
from adr_opt.sources.ephemerides.oem import read_oem

pytest.importorskip("sgp4.api")
pytest.importorskip("erfa")

RECORD = field(1)[0]
EPOCH = RECORD.epoch
TEME = Frame(name="TEME", axes_epoch=EPOCH)
NOTATIONS: dict[str, Callable[[str], str]] = {"kvn": str, "xml": oem_in_xml}


def states(times: Any) -> Any:
    """SGP4's states."""
    found = [np.concatenate(sgp4_state(RECORD, float(t) / 60.0)) for t in times]
    return 1e3 * np.array(found)


def at(time_s: float) -> str:
    """A label of a message."""
    return label(EPOCH + timedelta(seconds=time_s))


def message(
    notation: str,
    gap_s: tuple[float, float] | None = None,
    span_s: tuple[float, float] = (0.0, 7200.0),
    **fields: str,
) -> bytes:
    """A message with a state every two minutes, without those within a gap."""
    text = oem(RECORD.label, RECORD.object_id, EPOCH, states, span_s=span_s, **fields)
    if gap_s is not None:
        left_out = {at(t) for t in np.arange(gap_s[0] + 120.0, gap_s[1], 120.0)}
        rows = [row for row in text.splitlines() if row.split(" ")[0] not in left_out]
        text = "\n".join(rows) + "\n"
    return NOTATIONS[notation](text).encode()


def readers(content: bytes) -> Any:
    """The states by the planner's reader and by the judge's."""
    segments = read_oem(content, "a.oem")
    ours = ByTable(RECORD.label, segments, EPOCH, TEME, TurningAxes(EPOCH, TEME))
    coverage = Coverage(RECORD.label, segments, EPOCH)
    return (ours.state, lambda times: interpolated_states(coverage, np.asarray(times), EPOCH, TEME))


@pytest.mark.parametrize("notation", NOTATIONS)
def test_an_ephemeris_covers_what_metadata_and_states_both_cover(notation: str) -> None:
    """Whatever START/STOP, USEABLE and rows say, the latest beginning and the earliest end count.

    Nothing is answered a second beyond either, by the planner's reader or the judge's.
    """
    for stated, useable in itertools.product((-600.0, 0.0, 600.0), (None, -900.0, 0.0, 900.0)):
        fields = {"START_TIME": at(stated), "STOP_TIME": at(7200.0 - stated)}
        if useable is not None:
            fields["USEABLE_START_TIME"] = at(useable)
            fields["USEABLE_STOP_TIME"] = at(7200.0 - useable)
        begin = max(0.0, stated, useable or 0.0)
        end = 7200.0 - begin
        for answer in readers(message(notation, **fields)):
            assert np.abs(answer([begin, end]) - states([begin, end])).max() < 50.0
            with pytest.raises(InputError, match=f"no state of .* before {at(begin)[:16]}"):
                answer([begin - 1.0])
            with pytest.raises(InputError, match=f"no state of .* after {at(end)[:16]}"):
                answer([end + 1.0])


@pytest.mark.parametrize("notation", NOTATIONS)
def test_metadata_without_states_cover_nothing(notation: str) -> None:
    """Where all states are outside of the time stated, the sentence says so."""
    fields = {"START_TIME": at(9000.0), "STOP_TIME": at(9900.0)}
    for answer in readers(message(notation, **fields)):
        with pytest.raises(InputError, match="within the times that its metadata state"):
            answer([9100.0])


@pytest.mark.parametrize("notation", NOTATIONS)
def test_a_hole_among_states_is_named_and_not_crossed(notation: str) -> None:
    """A hole has file, line, object and times, and no polynomial leads across it."""
    content = message(notation, gap_s=(2400.0, 4800.0))
    first_after = next(
        number for number, row in enumerate(content.decode().splitlines(), 1) if at(4800.0) in row
    )
    for answer in readers(content):
        for sides in ([0.0, 2399.0], [4801.0, 7200.0]):
            times = np.linspace(*sides, 100)
            assert np.linalg.norm((answer(times) - states(times))[:, :3], axis=1).max() < 50.0
        with pytest.raises(InputError, match="a gap of 2400 s among states 120 s apart") as found:
            answer([3000.0])
        said = str(found.value)
        assert said.startswith(f"a.oem: line {first_after} ({RECORD.name}")
        assert f"from {at(2400.0)[:19]}" in said
        assert f"to {at(4800.0)[:19]}" in said


@pytest.mark.parametrize(
    ("method", "degree", "missing"),
    [("LAGRANGE", 7, 3), ("LAGRANGE", 1, 1), ("HERMITE", 7, 1), ("LINEAR", 1, 1)],
)
def test_a_degree_says_how_many_states_may_be_missing(
    method: str, degree: int, missing: int
) -> None:
    """Up to half of the polynomial's states may be missing, and one in any case."""
    whole = np.arange(0.0, 7200.0, 60.0)
    for left_out, found in ((missing, 0), (missing + 1, 1)):
        knots = np.delete(whole, np.arange(40, 40 + left_out))
        assert holes(knots, states(knots), method, degree).size == found


def test_steps_that_grow_are_no_holes_and_rare_states_are() -> None:
    """Steps may follow the motion; states less than twice a revolution say nothing of it."""
    steps = 30.0 * (1.0 + 9.0 * np.sin(np.linspace(0.0, np.pi, 200)) ** 2)
    knots = np.concatenate(([0.0], np.cumsum(steps)))
    assert not holes(knots, states(knots), "LAGRANGE", 7).size
    knots = np.arange(0.0, 86400.0, 3600.0)
    assert holes(knots, states(knots), "LAGRANGE", 7).size == knots.size - 1


@pytest.mark.parametrize("notation", NOTATIONS)
@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"gap_s": (36000.0, 38760.0)}, "a gap of 2760 s"),
        ({"span_s": (120.0, DAY_S + 1200.0), "START_TIME": at(0.0)}, "before"),
        ({"span_s": (21600.0, DAY_S + 1200.0), "START_TIME": at(0.0)}, "before"),
        ({"span_s": (0.0, DAY_S - 1200.0), "STOP_TIME": at(DAY_S)}, "after"),
    ],
    ids=["hole", "two minutes", "six hours", "end"],
)
def test_an_import_refuses_what_the_mission_needs(
    cli: Cli, notation: str, change: dict[str, Any], said: str
) -> None:
    """An import names what is missing of a mission, and for no other reason; else it does not."""
    Path("all.json").write_text(as_json([RECORD]), encoding="utf-8")
    content = message(notation, **{"span_s": (0.0, DAY_S + 1200.0)} | change)
    Path("a.oem").write_bytes(content)
    asked = [
        "import",
        "all.json",
        "--epoch",
        EPOCH.isoformat(),
        "--oem",
        "a.oem",
        "--out",
        "out.json",
        "--quiet",
        "--duration-days",
    ]
    refused = cli(*asked, "1")
    assert refused.status == 2, refused
    assert f"no state of {RECORD.label!r} " in refused.err
    assert said in refused.err
    if said in ("a gap of 2760 s", "after"):
        assert cli(*asked, "0.4").status == 0
