"""``tradeoff``: plans and bounds over budgets and durations, on one timetable."""

from __future__ import annotations

import csv
import json
import math
import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from conftest import Cli, refused
from hand_made import PERIOD_S, hand_made
from towed_fields import field as towed
from two_chasers import campaign

import adr_opt
from adr_opt.analysis import Axis, parse_axis, tradeoff
from adr_opt.analysis.trade import run
from adr_opt.analysis.trade.axes import PointLimits, Tanks, grid
from adr_opt.analysis.trade.plans import plans_of
from adr_opt.analysis.trade.points import Impossible, KnownPoints, Point
from adr_opt.analysis.trade.shared import Shared, slack_m_s, variant
from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError
from adr_opt.legs.connection_finder import ConnectionFinder
from adr_opt.problem.chasers import TankByMass
from adr_opt.ui.report.charts import BOTTOM, TOP, WIDE
from adr_opt.ui.report.traded import traded_page

IN_DELTA_V = Tanks("delta_v_m_s")

TANKS = Axis("delta-v", (130.0, 140.0, 270.0, 300.0, 420.0, 700.0))
DURATIONS = Axis("duration", tuple(round(n * PERIOD_S) * 1.0 for n in (4, 8, 11, 14)))


@pytest.fixture(scope="module")
def surface():
    return tradeoff(hand_made(), [TANKS, DURATIONS], time_limit=60.0)


def test_each_point_has_a_plan_of_its_own_instance(surface) -> None:
    """Plans of points are legal on the instances of their limits, and collect what is told."""
    found = {at: (instance, plan) for at, instance, plan in plans_of(surface)}
    assert sorted(found) == [at for at, point in enumerate(surface.points) if point.routes]
    for at, (instance, plan) in found.items():
        point = surface.points[at]
        assert instance == variant(surface.instance, point.limits, tanks=IN_DELTA_V)
        assert adr_opt.check(instance, plan) == ()
        assert (plan.objective, plan.status) == (point.prize, point.status)
        assert plan.cost == pytest.approx(point.cost)


def test_plans_of_points_are_written(cli: Cli) -> None:
    """``--plans`` writes instance and plan of each point that has one, as other verbs read them."""
    hand_made().save("i.json")
    call = ("tradeoff", "i.json", "--vary", "delta-v=1,600", "--method", "greedy", "--quiet")
    Path("p").mkdir()
    for old in ("point-3.plan.json", "point-03.instance.json"):
        (Path("p") / old).write_text("{}")
    assert cli(*call, "--plans", "p").status == 0
    names = [f"point-{at}.{what}.json" for at in (1, 2) for what in ("instance", "plan")]
    assert sorted(path.name for path in Path("p").iterdir()) == names
    assert cli("check", f"p/{names[2]}", f"p/{names[3]}").status == 0
    call = ("tradeoff", f"p/{names[0]}", *call[2:])
    refused(cli(*call, "--plans", "p"), "p: the plans would replace p/point-1.instance.json")
    assert sorted(path.name for path in Path("p").iterdir()) == names


def test_every_point_is_what_planning_it_alone_gives(surface) -> None:
    """Prizes and proofs are those of the exact method at each point, and plans can be flown."""
    assert len(surface.points) == 24
    for point in surface.points:
        instance = variant(surface.instance, point.limits, tanks=IN_DELTA_V)
        alone = adr_opt.solve(instance, "exact", time_limit=60.0)
        assert point.prize == alone.objective, point.limits
        assert point.status == alone.status == "optimal"
        assert point.upper_bound == alone.upper_bound
        timing = adr_opt.Mission(instance, threads=1).time(point.routes[0])
        assert timing.made == len(point.routes[0])
        assert timing.objective == point.prize == point.visits


def test_larger_points_are_no_worse(surface) -> None:
    """Along both axes prizes and bounds do not fall, and the surface is no plane."""
    for kind in ("delta-v", "duration"):
        for row in surface.along(kind).values():
            for one, two in pairwise(row):
                assert one.prize <= two.prize
                assert one.upper_bound <= two.upper_bound
    assert len({point.prize for point in surface.points}) == 4


def test_not_every_point_is_run(surface) -> None:
    """Where neighbours say it all, the proving method is not asked."""
    asked = [point for point in surface.points if "auto" in point.methods]
    assert 0 < len(asked) < len(surface.points)


def test_tanks_share_a_timetable_exactly() -> None:
    """The table of a mission is bit by bit that of one with another tank, for any time value."""
    instance = adr_opt.generate("tiny", 1)
    shared = Shared(instance, instance.mission.duration_s, tanks=IN_DELTA_V)
    duration = instance.mission.duration_s
    first = shared.problem(PointLimits(900.0, duration))
    first = first.missions[0]
    assert first.timetable is first.timetable
    other = shared.problem(PointLimits(400.0, duration)).missions[0]
    assert other.timetable is first.timetable
    for value in (75.0, 300.0):
        alone = adr_opt.Mission(other.instance, threads=1).with_time_value(value)
        table = other.with_time_value(value).timetable.table
        for mine, own in zip(table, alone.timetable.table, strict=True):
            np.testing.assert_array_equal(mine, own)
        rules = other.with_time_value(value).rules
        assert rules.budget == alone.rules.budget
        assert rules.shortest_sortie == alone.rules.shortest_sortie


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("resolution", [0.1, 5.0])
def test_connections_of_shorter_missions_are_those_in_time(seed: int, resolution: float) -> None:
    """Under J2, with long transfers, those of a long one that arrive in time are all of them."""
    field = adr_opt.generate("rocket-bodies", seed, targets=4)
    settings = field.transfer.replace(
        delta_v_resolution_m_s=resolution,
        drift_step_s=2.0 * DAY_S,
        max_drift_s=60.0 * DAY_S,
        departure_spacing_s=DAY_S,
    )
    long = field.replace(transfer=settings).with_limits(duration_s=80.0 * DAY_S)
    whole = ConnectionFinder(long)
    for days in (20.0, 33.7, 79.0):
        short = long.with_limits(duration_s=days * DAY_S)
        mine, own = whole.shortened(short), ConnectionFinder(short)
        for i in range(len(short.names)):
            for j in range(len(short.names)):
                if i == j:
                    continue
                shared, alone = mine.found(i, j), own.found(i, j)
                for name in ("departure", "arrival", "delta_v", "revolutions"):
                    np.testing.assert_array_equal(getattr(shared, name), getattr(alone, name))
                order = np.argsort(alone.crossing, kind="stable")
                assert (np.diff(shared.crossing[order]) >= 0).all()


def test_larger_tanks_may_leave_out_connections_where_planes_drift() -> None:
    """So each tank has its own there, and bounds count only for tanks that are smaller enough."""
    field = adr_opt.generate("rocket-bodies", 0, targets=4).with_limits(duration_s=30.0 * DAY_S)
    assert ConnectionFinder(field).depends_on_tank
    assert slack_m_s(field) == pytest.approx(10.0 * field.transfer.delta_v_resolution_m_s)
    assert slack_m_s(hand_made()) == 0.0
    board = KnownPoints(
        [PointLimits(100.0, 1.0), PointLimits(105.0, 1.0), PointLimits(200.0, 1.0)], slack_m_s=10.0
    )
    board.add(Point(200.0, 1.0, 5.0, 6.0))
    board.add(Point(105.0, 1.0, 4.0, 5.0))
    assert board.points[PointLimits(100.0, 1.0)].upper_bound == 6.0
    assert board.points[PointLimits(200.0, 1.0)].prize == 5.0


def test_a_drifting_field_is_traded_too() -> None:
    """Durations and tanks of a mission whose planes drift give the values of planning alone."""
    field = adr_opt.generate("rocket-bodies", 1, targets=4).with_limits(duration_s=60.0 * DAY_S)
    axes = [Axis("delta-v", (300.0, 1500.0)), Axis("duration", (40.0 * DAY_S, 60.0 * DAY_S))]
    made = tradeoff(field, axes, time_limit=60.0)
    for point in made.points:
        alone = adr_opt.solve(
            variant(field, point.limits, tanks=IN_DELTA_V), "exact", time_limit=20.0
        )
        assert point.prize == alone.objective
        assert point.upper_bound >= alone.objective


@pytest.mark.slow
def test_campaigns_are_traded_over_durations() -> None:
    """Of several chasers with tanks of their own the duration is varied, and tanks stay."""
    axis = Axis("duration", (DAY_S, 2.0 * DAY_S))
    made = tradeoff(campaign(), [axis], time_limit=60.0)
    assert [len(point.routes) for point in made.points] == [2, 2]
    for point in made.points:
        short = campaign().with_limits(duration_s=point.duration_s)
        alone = adr_opt.solve(short, "exact", time_limit=60.0)
        assert point.prize == alone.objective
        assert point.upper_bound >= alone.objective


def test_a_plan_above_a_bound_is_an_error() -> None:
    """Points that contradict each other are not stored: a method is broken."""
    board = KnownPoints([PointLimits(100.0, 1.0), PointLimits(200.0, 1.0)])
    board.add(Point(200.0, 1.0, 3.0, 3.0))
    with pytest.raises(Impossible):
        board.add(Point(100.0, 1.0, 4.0, 9.0))
    board = KnownPoints([PointLimits(100.0, 1.0), PointLimits(200.0, 1.0)])
    board.add(Point(200.0, 1.0, upper_bound=-math.inf))
    with pytest.raises(Impossible):
        board.add(Point(100.0, 1.0, 0.0, 9.0))


def test_of_a_plateau_the_largest_is_run_first() -> None:
    """Its bound counts for all of them."""
    board = KnownPoints([PointLimits(100.0, 1.0), PointLimits(200.0, 1.0), PointLimits(300.0, 1.0)])
    board.add(Point(100.0, 1.0, 3.0, 9.0))
    assert next(board.open({})) == PointLimits(300.0, 1.0)
    board.add(replace(board.points[PointLimits(300.0, 1.0)], upper_bound=3.0))
    assert list(board.open({})) == []


def test_results_of_something_else_are_refused(tmp_path: Path) -> None:
    """A file of another instance or of other settings is left as it is."""
    path = tmp_path / "r.jsonl"
    axis = Axis("delta-v", (300.0,))
    tradeoff(hand_made(), [axis], path=path)
    content = path.read_bytes()
    with pytest.raises(InputError, match="made with other instance"):
        tradeoff(hand_made(periods=15.0), [axis], path=path)
    with pytest.raises(InputError, match="made with other settings"):
        tradeoff(hand_made(), [axis], path=path, seed=3)
    assert path.read_bytes() == content


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("delta-v=1000:3000:500", (1000.0, 1500.0, 2000.0, 2500.0, 3000.0)),
        ("delta-v=0.1:0.35:0.1", (0.1, 0.2, 0.3)),
        ("delta-v = 3,1,2", (1.0, 2.0, 3.0)),
        ("duration=1:2:0.5", (DAY_S, 1.5 * DAY_S, 2.0 * DAY_S)),
    ],
)
def test_axes_are_read(text: str, values) -> None:
    """Ranges have both ends, lists any order, durations days."""
    assert parse_axis(text).values == pytest.approx(values)


def test_points_are_all_pairs() -> None:
    """A surface has every tank with every duration."""
    points = grid(hand_made(), [TANKS, DURATIONS])
    assert len(set(points)) == len(TANKS.values) * len(DURATIONS.values)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("--vary", "delta-v"), "give it as NAME=LO:HI:STEP"),
        (("--vary", "mass=1:2:1"), "'mass' is unknown; use one of: delta-v, propellant, duration"),
        (("--vary", "delta-v=1:2"), "give numbers, as LO:HI:STEP"),
        (("--vary", "delta-v=a,b"), "give numbers"),
        (("--vary", "delta-v=3:1:1"), "LO must not exceed HI"),
        (("--vary", "delta-v=1:3:0"), "STEP must be positive"),
        (("--vary", "delta-v=0,1"), "must be positive"),
        (("--vary", "delta-v=5,5"), "each given once"),
        (("--vary", "delta-v=1:1e9:1"), "more than the 10000 allowed"),
        (("--vary", "delta-v=5", "--vary", "delta-v=6"), "varied twice"),
        (("--vary", "delta-v=5", "--vary", "propellant=6"), "each states the content of a tank"),
        (("--vary", "propellant=5"), "is given in ΔV, without masses"),
        (("--vary", "delta-v=5", "--method", "no"), "'no'"),
        (("--vary", "kits=1", "--start", "p.json"), "--start: designs have none"),
        (("--vary", "delta-v=5", "--time-limit", "0"), "time limit = 0"),
        (("--vary", "delta-v=5", "--jobs", "-1"), "jobs = -1"),
        (("--vary", "delta-v=5", "--page", "x.txt"), "ends in .html"),
        (("--vary", "delta-v=5", "--plot", "x.gif"), ".svg, .png or .pdf"),
        (("--vary", "delta-v=5", "--out", "h.json"), "this is the input"),
    ],
)
def test_a_wrong_call_is_one_sentence(cli: Cli, arguments, named: str) -> None:
    """Exit status 2 and a sentence, before any work."""
    hand_made().save("h.json")
    refused(cli("tradeoff", "h.json", *arguments), named)


def test_a_tank_by_mass_with_kits_has_no_budget(cli: Cli) -> None:
    """What cannot be varied is refused in a sentence."""
    instance = hand_made()
    tank = TankByMass(dry_mass_kg=500.0, propellant_kg=54.0, isp_s=300.0)
    chaser = instance.chaser.replace(tank=tank, kits=2, kit_mass_kg=5.0)
    instance.replace(chasers=(chaser,)).save("h.json")
    outcome = cli("tradeoff", "h.json", "--vary", "delta-v=100,200")
    refused(
        outcome, "is one by mass, and masses count (kit_mass_kg, tows, expense or low thrust); vary"
    )


def test_propellant_is_varied_where_masses_count(cli: Cli) -> None:
    """Tanks by mass hold more or less propellant, and stay what they are: tows are planned."""
    instance = towed()
    instance.save("t.json")
    call = ("tradeoff", "t.json", "--vary", "propellant=150:450:100", "--time-limit", "20")
    outcome = cli(*call, "--json", "--out", "t.csv", "--page", "t.html")
    assert outcome.status == 0, outcome
    made = json.loads(outcome.out)
    assert made["varied"] == {"propellant": [150.0, 250.0, 350.0, 450.0]}
    assert made["proven"] == 4
    for point in made["points"]:
        alone = instance.with_limits(propellant_kg=point["propellant_kg"])
        assert alone.chaser.tank.propellant_kg == point["propellant_kg"]
        assert alone.chaser.tank.dry_mass_kg == instance.chaser.tank.dry_mass_kg
        assert point["delta_v_m_s"] == alone.chaser.tank.delta_v_m_s
        assert adr_opt.solve(alone, "exact", time_limit=60.0).objective == point["prize"]
    prizes = [point["prize"] for point in made["points"]]
    assert prizes == sorted(prizes)
    assert prizes[0] < prizes[-1]
    assert "propellant of a full tank [kg]" in Path("t.html").read_text(encoding="utf-8")
    again = cli(*call, "--out", "t.csv")
    assert again.status == 0
    assert [line.split("│")[1].strip() for line in again.out.splitlines() if "│" in line] == [
        "150",
        "250",
        "350",
        "450",
    ]


def test_propellant_is_not_varied_where_a_station_has_little() -> None:
    """Larger tanks take more of a station, so that points would say nothing of each other."""
    instance = towed()
    limited = instance.replace(stations=(instance.stations[0].replace(max_propellant_kg=500.0),))
    with pytest.raises(InputError, match="a station has a max_propellant_kg"):
        tradeoff(limited, [Axis("propellant", (100.0, 200.0))])


def test_points_stand_alone_where_planes_drift_and_masses_count() -> None:
    """No plan of a smaller tank is taken for one of a larger tank there, and no bound back."""
    points = [
        PointLimits(1000.0, DAY_S),
        PointLimits(2000.0, DAY_S),
        PointLimits(2000.0, 2.0 * DAY_S),
    ]
    board = KnownPoints(points, slack_m_s(towed("j2")))
    assert not board.counts(points[0], points[1])
    assert board.counts(points[1], points[2])
    assert KnownPoints(points, slack_m_s(towed())).counts(points[0], points[1])


def test_plans_that_are_there_are_points(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    """The limits of the instance are a point no worse than its plans; illegal ones are refused."""
    monkeypatch.setattr(run, "QUICK", "greedy")
    instance = hand_made()
    best = adr_opt.solve(instance, "exact", time_limit=60.0).plan
    assert best is not None
    own = instance.chaser.tank.delta_v_m_s
    axes = [Axis("delta-v", (own - 200.0, own + 50.0))]
    asked = {"method": "greedy", "time_limit": 60.0}
    alone = tradeoff(instance, axes, **asked)
    made = tradeoff(instance, axes, starts=[best], **asked)
    assert [point.delta_v_m_s for point in made.points] == [own - 200.0, own, own + 50.0]
    assert alone.points[-1].prize < best.objective <= made.points[1].prize == made.points[-1].prize
    assert made.points[1].routes == tuple(best.orders.values())
    assert made.points[1].cost <= best.cost + 1e-6
    instance.save("i.json")
    best.save("p.json")
    call = ("tradeoff", "i.json", "--vary", f"delta-v={own - 200.0}", "--method", "greedy")
    told = json.loads(cli(*call, "--start", "p.json", "--json").out)
    assert [point["prize"] for point in told["points"]] == [
        point.prize for point in made.points[:2]
    ]
    best.replace(objective=best.objective + 1.0).save("p.json")
    refused(cli(*call, "--start", "p.json"), "p.json: the plan is not legal")


def test_the_verb_writes_what_it_tells(cli: Cli) -> None:
    """Table, CSV, JSON, page and picture of one call."""
    pytest.importorskip("matplotlib")
    hand_made().save("h.json")
    outcome = cli(
        "tradeoff",
        "h.json",
        "--vary",
        "delta-v=130,300",
        "--vary",
        "duration=0.5,0.96",
        "--out",
        "t.csv",
        "--page",
        "t.html",
        "--plot",
        "t.svg",
    )
    assert outcome.status == 0, outcome
    assert "4 of 4 points proven" in outcome.out
    page = Path("t.html").read_text(encoding="utf-8")
    assert page.count('<figure class="drawn">') == 2
    assert "<script" not in page
    assert "<svg" in Path("t.svg").read_text(encoding="utf-8")
    call = ("tradeoff", "h.json", "--vary", "delta-v=130,300", "--vary", "duration=0.5,0.96")
    runs = Path("t.jsonl").read_bytes()
    content = json.loads(cli(*call, "--out", "t.csv", "--json").out)
    assert Path("t.jsonl").read_bytes() == runs
    with Path("t.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    for row, point in zip(rows, content["points"], strict=True):
        assert float(row["delta_v_m_s"]) == point["delta_v_m_s"]
        assert float(row["prize"]) == point["prize"]
        assert json.loads(row["routes"]) == point["routes"]
    Path("t.jsonl").unlink()
    refused(cli(*call, "--out", "t.csv"), "t.csv: exists without t.jsonl, so it cannot be resumed")
    assert content["proven"] == 4
    assert [point["status"] for point in content["points"]] == ["optimal"] * 4


def test_the_band_of_the_page_reaches_up_to_the_bounds(surface) -> None:
    """Far above the prizes the band is in the picture, and its axis reaches as far."""
    field = adr_opt.generate("tiny", 0, targets=8)
    points = (
        Point(100.0, DAY_S, prize=3.0, upper_bound=7.6, visits=3),
        Point(200.0, DAY_S, prize=4.0, visits=4),
    )
    made = replace(surface, instance=field, axes=(Axis("delta-v", (100.0, 200.0)),), points=points)
    page = traded_page(made)
    (outline,) = re.findall(r'<polygon points="([^"]*)"', page)
    heights = [float(point.split(",")[1]) for point in outline.split()]
    # The prizes from left to right, and back along the bounds; all of them below the upper edge.
    assert len(heights) == 4
    assert min(heights) >= TOP
    assert max(heights) <= WIDE[1] - BOTTOM
    # As high as they are: of 8 prizes where nothing is proven.
    zero = WIDE[1] - BOTTOM
    shares = [(zero - height) / (zero - heights[2]) for height in heights]
    assert shares == pytest.approx([3.0 / 8.0, 4.0 / 8.0, 1.0, 7.6 / 8.0], abs=2e-3)
