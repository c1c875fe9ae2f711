"""Trade-offs over thrust and specific impulse."""

from __future__ import annotations

import csv
import json
from functools import cache
from pathlib import Path

import pytest
from conftest import Cli, refused
from electric_fields import electric

import adr_opt
from adr_opt.analysis.trade import Axis, Tradeoff, tradeoff
from adr_opt.analysis.trade.axes import PointLimits, Tanks, grid, with_drive
from adr_opt.analysis.trade.points import KnownPoints, Point
from adr_opt.analysis.trade.shared import slack_m_s, variant
from adr_opt.ui.report.traded import traded_page

THRUSTS, IMPULSES = Axis("thrust", (0.02, 0.05, 0.2)), Axis("isp", (1200.0, 1800.0))


@cache
def made() -> Tradeoff:
    """Values of a mission for three thrusts and two specific impulses."""
    return tradeoff(electric(1, targets=3), [THRUSTS, IMPULSES], time_limit=60.0)


@pytest.mark.slow
def test_each_point_has_the_value_of_planning_alone() -> None:
    """Plan and bound at each thrust and specific impulse are those of that chaser's mission."""
    field = electric(1, targets=3)
    assert len(made().points) == 6
    for point in made().points:
        own = with_drive(field, point.thrust_n, point.isp_s)
        assert [chaser.thrust_n for chaser in own.chasers] == [point.thrust_n]
        assert [chaser.tank.isp_s for chaser in own.chasers] == [point.isp_s]
        assert variant(field, point.limits, tanks=Tanks()) == own
        alone = adr_opt.solve(own, "exact", time_limit=60.0)
        assert point.prize == alone.objective
        assert point.upper_bound == alone.upper_bound
        assert point.delta_v_m_s == own.largest_tank_m_s
    assert len({point.prize for point in made().points}) > 1


def test_points_of_different_drives_say_nothing_of_each_other() -> None:
    """Neither plans nor bounds are handed on, as more thrust or propellant may be no better."""
    limits = [PointLimits(900.0, 1.0, thrust, 1500.0) for thrust in (0.1, 0.2)]
    board = KnownPoints(limits)
    board.add(Point(900.0, 1.0, 3.0, 4.0, thrust_n=0.1, isp_s=1500.0))
    other = board.points[limits[1]]
    assert other.prize == -float("inf")
    assert other.upper_bound == float("inf")
    assert slack_m_s(electric(1)) == float("inf")


def test_durations_of_one_drive_share_plans_and_bounds() -> None:
    """With thrust and duration varied, prizes and bounds ascend with the time of each thrust."""
    field = electric(1, targets=3)
    last_s = field.mission.duration_s
    axes = [Axis("thrust", (0.05, 0.2)), Axis("duration", (0.5 * last_s, last_s))]
    found = tradeoff(field, axes, time_limit=60.0)
    for (thrust_n,), (short, long) in found.along("duration").items():
        assert short.thrust_n == long.thrust_n == thrust_n
        assert short.prize <= long.prize
        assert short.upper_bound <= long.upper_bound


@pytest.mark.parametrize(
    ("axes", "said"),
    [
        ([Axis("isp", (1500.0,)), Axis("propellant", (10.0,))], "vary isp or propellant"),
        ([Axis("delta-v", (500.0,))], "expense or low thrust"),
    ],
)
def test_what_cannot_be_varied_is_refused(axes: list[Axis], said: str) -> None:
    """One clear sentence where points could not be told apart, or the tank is one by mass."""
    with pytest.raises(adr_opt.InputError, match=said):
        grid(electric(1), axes)


@pytest.mark.parametrize("axis", [THRUSTS, IMPULSES])
def test_impulses_have_no_drive_to_vary(axis: Axis) -> None:
    """Of chasers without low thrust neither is varied."""
    with pytest.raises(adr_opt.InputError, match="has low thrust; give one a thrust_n"):
        grid(adr_opt.generate("removal", 0, targets=4), [axis])


def test_the_page_and_the_card_name_the_drive() -> None:
    """Tables have columns for thrust and specific impulse, charts a line for each value."""
    text = traded_page(made())
    assert '<th scope="col" class=n>N</th>' in text
    assert '<th scope="col" class=n>Isp s</th>' in text
    assert "Prize and bound against thrust [N]" in text
    assert "isp 1,800 s" in text
    assert "Isp s" in made()._repr_html_()
    assert "0.2 N, 1200 s" in repr(made().points[2])


def test_the_command_writes_them_and_goes_on(cli: Cli, tmp_path: Path) -> None:
    """`--vary thrust` and `--vary isp` give a row each, and a second call runs nothing anew."""
    path, out = tmp_path / "i.json", tmp_path / "curve.csv"
    path.write_text(electric(1, targets=3).to_json(), encoding="utf-8")
    options = ("--vary", "thrust=0.05,0.2", "--vary", "isp=1500", "--out", out, "--json")
    first = json.loads(cli("tradeoff", path, *options).out)
    assert [point["thrust_n"] for point in first["points"]] == [0.05, 0.2]
    assert first["varied"] == {"thrust": [0.05, 0.2], "isp": [1500.0]}
    with out.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [(row["thrust_n"], row["isp_s"]) for row in rows] == [
        ("0.05", "1500.0"),
        ("0.2", "1500.0"),
    ]
    again = json.loads(cli("tradeoff", path, *options).out)
    assert [p["prize"] for p in again["points"]] == [p["prize"] for p in first["points"]]
    assert [p["runtime_s"] for p in again["points"]] == pytest.approx(
        [p["runtime_s"] for p in first["points"]], abs=1e-3
    )


def test_a_frontier_is_one_of_a_single_drive(cli: Cli, tmp_path: Path) -> None:
    """With thrust varied a frontier is refused in a sentence, and nothing is written."""
    path, out = tmp_path / "i.json", tmp_path / "frontier.csv"
    path.write_text(electric(1, targets=3).to_json(), encoding="utf-8")
    found = cli("tradeoff", path, "--vary", "thrust=0.05,0.2", "--frontier", out)
    refused(found, "vary thrust: a frontier is one of chasers with the same drive")
    assert not out.exists()
