"""``tradeoff`` goes on from a file that may be edited or damaged, and flies its routes anew."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from conftest import Cli, refused
from hand_made import hand_made
from two_chasers import campaign

from adr_opt.analysis import Axis, tradeoff
from adr_opt.analysis.trade.points import Point, Tradeoff
from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError

TANKS = Axis("delta-v", (130.0, 300.0))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Tradeoff]:
    """A file of two tanks, of which "auto" has run both, and what the call came to."""
    path = tmp_path_factory.mktemp("results") / "r.jsonl"
    found = tradeoff(hand_made(), [TANKS], path=path, time_limit=60.0)
    return path.read_text(), found


def edited(content: str, change: Callable[[dict[str, Any]], None]) -> str:
    """The file with its last row changed."""
    *lines, last = content.splitlines()
    row = json.loads(last)
    change(row)
    return "\n".join([*lines, json.dumps(row)]) + "\n"


def resumed(path: Path, text: str) -> tuple[Tradeoff, list[Point]]:
    """What the call comes to that goes on with this file, and what it ran."""
    ran: list[Point] = []
    path.write_text(text)
    found = tradeoff(
        hand_made(), [TANKS], path=path, time_limit=60.0, told=lambda point, _: ran.append(point)
    )
    return found, ran


def said_of(made: Tradeoff) -> list[tuple[Any, ...]]:
    """What a curve says, but for times."""
    return [(p.limits, p.prize, p.upper_bound, p.visits, p.cost, p.routes) for p in made.points]


def test_a_file_says_what_its_call_said(tmp_path: Path, made: tuple[str, Tradeoff]) -> None:
    """Prizes, visits and costs are worked out anew of the routes, and nothing is run."""
    content, whole = made
    again, ran = resumed(tmp_path / "r.jsonl", content)
    assert ran == []
    assert said_of(again) == said_of(whole)


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ({"routes": [["moon"]]}, "'moon' is not a body"),
        ({"routes": ["moon"]}, "is not a body|routes for 1 chasers"),
        ({"routes": [[1]]}, "not a row of tradeoff"),
        ({"routes": 1}, "not a row of tradeoff"),
        ({"routes": [[], []]}, "there are 2 routes for 1 chasers"),
        ({"upper_bound": "nan"}, "not a row of tradeoff"),
        ({"upper_bound": [1.0]}, "not a row of tradeoff"),
        ({"upper_bound": 0.5}, "a bound in the file is below the prize"),
        ({"upper_bound": "infeasible"}, "a bound in the file is below the prize"),
        ({"cpu_s": -1.0}, "not a row of tradeoff"),
        ({"cpu_s": None}, "not a row of tradeoff"),
    ],
)
def test_rows_that_cannot_be_true_are_refused(
    tmp_path: Path, made: tuple[str, Tradeoff], value: dict[str, Any], said: str
) -> None:
    """An edited row is named in one sentence, and the file is left as it is."""
    text = edited(made[0], lambda row: row["value"].update(value))
    with pytest.raises(InputError, match=said) as error:
        resumed(tmp_path / "r.jsonl", text)
    assert str(error.value).isprintable()
    assert (tmp_path / "r.jsonl").read_text() == text


def test_routes_that_ask_for_more_are_refused(tmp_path: Path, made: tuple[str, Tradeoff]) -> None:
    """The plan of a larger tank is none of a smaller one, nor is one that goes somewhere twice."""
    small, large = (point.routes for point in made[1].points)
    assert small != large
    twice = [[*large[0], large[0][0]]]
    for routes, tank in ((large, TANKS.values[0]), (twice, TANKS.values[1])):

        def change(row: dict[str, Any], routes: object = routes, tank: float = tank) -> None:
            row["key"]["delta_v_m_s"] = tank
            row["value"]["routes"] = routes

        with pytest.raises(
            InputError, match=r"line \d+: (move \d of the sequence|.* is visited twice)"
        ):
            resumed(tmp_path / "r.jsonl", edited(made[0], change))


def test_a_bound_that_a_later_plan_exceeds_is_one_sentence(
    tmp_path: Path, made: tuple[str, Tradeoff]
) -> None:
    """A bound of the file that is too low is found out when a run collects more."""
    head, first, *_ = made[0].splitlines(keepends=True)
    row = json.loads(first)
    row["value"] |= {"upper_bound": 0.5, "routes": []}
    row["key"]["delta_v_m_s"] = TANKS.values[1]
    with pytest.raises(InputError, match=r"a bound of this file lies below what a plan collects"):
        resumed(tmp_path / "r.jsonl", head + json.dumps(row) + "\n")


def test_campaigns_go_on_too(tmp_path: Path) -> None:
    """Routes of two chasers are flown anew; a target that both visit is refused."""
    path, axis = tmp_path / "r.jsonl", Axis("duration", (DAY_S, 2.0 * DAY_S))
    whole = tradeoff(campaign(), [axis], time_limit=60.0, path=path)
    text, ran = path.read_text(), list[Point]()
    again = tradeoff(
        campaign(), [axis], time_limit=60.0, path=path, told=lambda point, _: ran.append(point)
    )
    assert ran == []
    assert said_of(again) == said_of(whole)
    one, two = whole.points[1].routes
    assert one != two
    path.write_text(edited(text, lambda row: row["value"].update(routes=[one, one])))
    with pytest.raises(InputError, match=r"line \d+: .*"):
        tradeoff(campaign(), [axis], time_limit=60.0, path=path)


def test_control_characters_of_a_file_do_not_reach_the_terminal(
    cli: Cli, made: tuple[str, Tradeoff]
) -> None:
    """Names in an edited file are said with escapes."""
    hand_made().save("h.json")
    Path("r.jsonl").write_text(
        edited(made[0], lambda row: row["value"].update(routes=[["\x1b]0;title\x07"]]))
    )
    call = ("tradeoff", "h.json", "--vary", "delta-v=130,300", "--time-limit", 60)
    outcome = cli(*call, "--out", "r.jsonl")
    refused(outcome, "r.jsonl: line")
    assert outcome.err.rstrip("\n").isprintable()


def test_a_point_without_a_plan_goes_on(tmp_path: Path) -> None:
    """Where a required target is out of reach, no routes and no bound are what the file says."""
    field = hand_made()
    first = field.targets[0].replace(required=True)
    field = field.replace(targets=(first, *field.targets[1:]))
    axis, path = Axis("delta-v", (1.0,)), tmp_path / "r.jsonl"
    (point,) = tradeoff(field, [axis], path=path).points
    (again,) = tradeoff(field, [axis], path=path).points
    assert point.prize == again.prize == -math.inf
    assert again.status == point.status
