"""``tradeoff`` goes on from a file that may be torn, edited or damaged, and does not trust it."""

from __future__ import annotations

import csv
import errno
import io
import json
import math
import os
from pathlib import Path

import pytest
from conftest import Cli, refused
from hand_made import hand_made
from two_chasers import campaign

from adr_opt.analysis import Axis, tradeoff
from adr_opt.analysis.trade.points import Point, Tradeoff
from adr_opt.analysis.trade.results import COLUMNS, ResultsFile
from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError

TANKS = Axis("delta-v", (130.0, 300.0))
SHA256 = hand_made().sha256


@pytest.fixture(scope="module")
def content(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A file of results as it is at the end: a row for each of two tanks."""
    path = tmp_path_factory.mktemp("results") / "r.csv"
    tradeoff(hand_made(), [TANKS], path=path, time_limit=60.0)
    return path.read_text()


@pytest.fixture(scope="module")
def made() -> Tradeoff:
    """What the same call comes to without a file."""
    return tradeoff(hand_made(), [TANKS], time_limit=60.0)


def edited(content: str, row: int, **cells: str) -> str:
    """The file with other cells in a row, counted from 0."""
    rows = list(csv.DictReader(io.StringIO(content, newline="")))
    rows[row] |= cells
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def resumed(path: Path, text: str | bytes) -> tuple[Tradeoff, list[Point]]:
    """What the call comes to that goes on with this file, and what it ran."""
    ran: list[Point] = []
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    found = tradeoff(
        hand_made(), [TANKS], path=path, time_limit=60.0, told=lambda point, _: ran.append(point)
    )
    return found, ran


def same(one: Tradeoff, other: Tradeoff) -> bool:
    """Whether two curves say the same, but for times and methods."""
    return [(p.limits, p.prize, p.upper_bound, p.visits, p.cost, p.routes) for p in one.points] == [
        (p.limits, p.prize, p.upper_bound, p.visits, p.cost, p.routes) for p in other.points
    ]


def test_what_routes_collect_is_worked_out_anew(
    tmp_path: Path, content: str, made: Tradeoff
) -> None:
    """Prize, visits and cost of a file do not count, but those of its routes."""
    text = edited(content, 1, prize="4.0", visits="99", cost="1.0", status="optimal")
    found, ran = resumed(tmp_path / "r.csv", text)
    assert ran == []
    assert same(found, made)
    rows = list(csv.DictReader(io.StringIO((tmp_path / "r.csv").read_text(), newline="")))
    assert (rows[1]["prize"], rows[1]["visits"]) == ("3.0", "3")


@pytest.mark.parametrize(
    ("cells", "said"),
    [
        ({"routes": '[["moon"]]'}, "row 3: 'moon' is not a body"),
        ({"routes": '["moon"]'}, "row 3: not a row of results"),
        ({"routes": "[[[1]]]"}, "row 3: not a row of results"),
        ({"routes": "[" * 100_000}, "row 3: not a row of results"),
        ({"routes": "[]"}, "row 3: the prize .* is stated of no routes"),
        ({"routes": "[[], []]"}, "row 3: there are 2 routes for 1 chasers"),
        ({"prize": "inf"}, "row 3: prize = inf is not a result"),
        ({"prize": "nan"}, "row 3: prize = nan is not a result"),
        ({"upper_bound": "nan"}, "row 3: upper_bound = nan is not a result"),
        ({"upper_bound": "0.5"}, "row 3: a bound of the file lies below what a plan of it"),
        ({"upper_bound": "-inf"}, r"row \d: a bound of the file lies below what a plan of it"),
        ({"delta_v_m_s": "nan"}, "row 3: delta_v_m_s = nan is not a result"),
        ({"duration_s": "-1"}, "row 3: duration_s = -1.0 is not a result"),
        ({"cpu_s": "1e999"}, "row 3: cpu_s = inf is not a result"),
        ({"visits": "many"}, "row 3: not a row of results"),
        ({"method": "magic"}, "row 3: 'magic' is not a method of this trade-off"),
    ],
)
def test_rows_that_cannot_be_true_are_refused(
    tmp_path: Path, content: str, cells: dict[str, str], said: str
) -> None:
    """An edited row is named in one sentence, and the file is left as it is."""
    text = edited(content, 1, **cells)
    with pytest.raises(InputError, match=said) as error:
        resumed(tmp_path / "r.csv", text)
    assert str(error.value).isprintable()
    assert (tmp_path / "r.csv").read_text() == text


def test_routes_that_ask_for_more_are_refused(tmp_path: Path, content: str) -> None:
    """The plan of a larger tank is none of a smaller one, nor is one that goes somewhere twice."""
    rows = list(csv.DictReader(io.StringIO(content, newline="")))
    assert rows[0]["routes"] != rows[1]["routes"]
    with pytest.raises(InputError, match=r"row 2: move \d of the sequence"):
        resumed(tmp_path / "r.csv", edited(content, 0, routes=rows[1]["routes"]))
    (route,) = json.loads(rows[1]["routes"])
    with pytest.raises(InputError, match="row 3: move"):
        resumed(tmp_path / "r.csv", edited(content, 1, routes=json.dumps([[*route, route[0]]])))


def test_a_bound_that_a_later_plan_exceeds_is_one_sentence(
    tmp_path: Path, content: str, made: Tradeoff
) -> None:
    """A bound of the file that is too low is found out when a run collects more."""
    assert made.points[1].prize > 0.5
    text = edited(content, 1, method="beam", upper_bound="0.5", prize="-inf", routes="[]")
    with pytest.raises(InputError, match=r"a bound of this file lies below what a plan collects"):
        resumed(tmp_path / "r.csv", text)


@pytest.mark.parametrize("row", [1, 2])
@pytest.mark.parametrize("share", [0.02, 0.3, 0.7, 0.99])
@pytest.mark.parametrize("between", ["", "\n"])
def test_a_half_written_row_in_the_middle_is_passed_over(
    tmp_path: Path, content: str, made: Tradeoff, row: int, share: float, between: str
) -> None:
    """The rows that are whole count, be they on the line of one that is not."""
    lines = content.splitlines(keepends=True)
    torn = lines[row][: int(share * len(lines[row]))]
    found, ran = resumed(tmp_path / "r.csv", "".join([*lines[:row], torn, between, *lines[row:]]))
    assert ran == []
    assert same(found, made)
    assert (tmp_path / "r.csv").read_text().count("\n") == 3


@pytest.mark.parametrize("left", [0, 10, 200])
def test_after_a_row_that_was_cut_off_others_are_whole(
    tmp_path: Path, content: str, made: Tradeoff, left: int
) -> None:
    """What is appended to a torn file stands on lines of its own, header included."""
    lines = content.splitlines(keepends=True)
    path = tmp_path / "r.csv"
    text = "".join(lines[:2]) + lines[2][:left] if left != 10 else lines[0][:left]
    path.write_text(text)
    settings = next(csv.DictReader(io.StringIO(content, newline="")))["settings"]
    file = ResultsFile(path, SHA256, settings)
    file.append(made.points[1], "auto")
    again = ResultsFile(path, SHA256, settings).found
    assert [point.limits for _, point in again] == [
        each.limits for each in (made.points[1:] if left == 10 else made.points)
    ]


def test_what_was_written_is_counted(
    tmp_path: Path, made: Tradeoff, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A system that takes a part of a row gets the rest, and a disk that is full keeps no part."""
    path, write = tmp_path / "r.csv", os.write
    monkeypatch.setattr(os, "write", lambda handle, content: write(handle, content[:7]))
    file = ResultsFile(path, SHA256, "s")
    for point in made.points:
        file.append(point, "auto")
    before = path.read_bytes()
    assert [point.prize for _, point in ResultsFile(path, SHA256, "s").found] == [
        point.prize for point in made.points
    ]
    parts = iter([5])

    def fills_up(handle: int, content: bytes) -> int:
        for part in parts:
            return write(handle, content[:part])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "write", fills_up)
    with pytest.raises(InputError, match="No space left"):
        file.append(made.points[0], "auto")
    assert path.read_bytes() == before


def test_a_long_row_is_read_as_it_was_written(tmp_path: Path) -> None:
    """Routes of ten thousand bodies are no other file's."""
    path = tmp_path / "r.csv"
    route = tuple(f"a target with a name {number:06}" for number in range(10_000))
    point = Point(1.0, 1.0, 5.0, 6.0, 5, 7.0, (route,), ("auto",))
    ResultsFile(path, SHA256, "s").append(point, "auto")
    limit = csv.field_size_limit()
    ((_, again),) = ResultsFile(path, SHA256, "s").found
    assert again.routes == point.routes
    assert csv.field_size_limit() == limit


def test_line_ends_of_other_programs_are_read(tmp_path: Path, content: str, made: Tradeoff) -> None:
    """A file that was saved with carriage returns, or with blank lines, is the same one."""
    found, ran = resumed(tmp_path / "r.csv", content.replace("\n", "\r\n") + "\r\n\n")
    assert ran == []
    assert same(found, made)


def test_campaigns_go_on_too(tmp_path: Path) -> None:
    """Routes of two chasers are flown anew; a target that both visit is refused."""
    path, axis = tmp_path / "r.csv", Axis("duration", (DAY_S, 2.0 * DAY_S))
    whole = tradeoff(campaign(), [axis], time_limit=60.0, path=path)
    text = path.read_text()
    ran: list[Point] = []
    again = tradeoff(
        campaign(), [axis], time_limit=60.0, path=path, told=lambda point, _: ran.append(point)
    )
    assert ran == []
    assert same(again, whole)
    one, two = whole.points[1].routes
    both = json.dumps([one, one])
    assert one != two
    path.write_text(edited(text, 1, routes=both))
    with pytest.raises(InputError, match=r"row 3: .*"):
        tradeoff(campaign(), [axis], time_limit=60.0, path=path)


def test_control_characters_of_a_file_do_not_reach_the_terminal(cli: Cli, content: str) -> None:
    """Settings, methods and names in an edited file are said with escapes."""
    hand_made().save("h.json")
    call = ("tradeoff", "h.json", "--vary", "delta-v=130,300", "--time-limit", 60)
    for cells in (
        {"settings": "\x1b[2J\x07 gone"},
        {"method": "\x1b[2J"},
        {"routes": json.dumps([["\x1b]0;title\x07"]])},
    ):
        Path("r.csv").write_text(edited(content, 1, **cells))
        outcome = cli(*call, "--out", "r.csv")
        refused(outcome, "r.csv: row 3")
        assert outcome.err.rstrip("\n").isprintable()


def test_a_point_without_a_plan_goes_on(tmp_path: Path) -> None:
    """Where a required target is out of reach, no routes and no bound are what the file says."""
    field = hand_made()
    first = field.targets[0].replace(required=True)
    field = field.replace(targets=(first, *field.targets[1:]))
    axis, path = Axis("delta-v", (1.0,)), tmp_path / "r.csv"
    (point,) = tradeoff(field, [axis], path=path).points
    (again,) = tradeoff(field, [axis], path=path).points
    assert point.prize == again.prize == -math.inf
    assert again.status == point.status
