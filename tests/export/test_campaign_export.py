"""Campaigns in files of other programs: a chaser at a time, or all of them where a format can."""

from __future__ import annotations

import json
import re
from datetime import datetime
from itertools import pairwise
from pathlib import Path

import pytest
from conftest import Cli, refused
from two_chasers import HOME, OWN, campaign, planned

import adr_opt
from adr_opt.export.flights import write_plan
from adr_opt.fly.trajectory import sample

NAMED = "name one (--chaser): 'tender', 'kicker'"
EPOCH = "2026-01-01T00:00:00"


@pytest.fixture
def files(cli: Cli) -> Cli:
    """The command line in a folder with a campaign, its plan and the same refined."""
    Path("my.json").write_text(campaign("j2").to_json(), encoding="utf-8")
    planned("j2").save("plan.json")
    assert (
        cli("refine", "my.json", "plan.json", "--out", "r.json", "--burns", "planned").status == 0
    )
    return cli


def seconds(label: str) -> float:
    """A calendar time as seconds since the epoch of the field."""
    return (datetime.fromisoformat(label[:26]) - datetime.fromisoformat(EPOCH)).total_seconds()


def test_a_chaser_is_asked_for(files: Cli) -> None:
    """What holds the flight of one chaser is not written without a name; the sentence lists all."""
    wanted = [("plan.json", f"a.{suffix}") for suffix in ("oem", "opm", "script")]
    for plan, out in [*wanted, *(("r.json", out) for _, out in wanted)]:
        call = ("export", "my.json", plan, "--out", out)
        refused(files(*call), NAMED)
        refused(files(*call, "--chaser", "ghost"), "'ghost'", "'tender', 'kicker'")
        refused(
            files(*call, "--chaser", HOME, "--leg", 5), "it belongs to 'kicker', not to 'tender'"
        )
        assert not Path(out).exists()


def test_czml_of_a_refined_plan_holds_all_chasers(files: Cli) -> None:
    """Without a name there are all chasers in their own colours, with one only its own legs."""
    for chasers, legs, words in (
        (["kicker", "tender"], 7, ()),
        ([OWN], 4, ("--chaser", OWN)),
        ([HOME], 1, ("--leg", 2)),
    ):
        done = files("export", "my.json", "r.json", "--out", "a.czml", "--json", *words)
        assert done.status == 0, done.err
        told = json.loads(done.out)
        assert told["legs"] == legs
        assert told.get("chaser") == (chasers[0] if words else None)
        packets = json.loads(Path("a.czml").read_text(encoding="utf-8"))
        crew = [packet for packet in packets if packet["id"].startswith("chaser/")]
        assert sorted(packet["name"] for packet in crew) == chasers
        assert len({tuple(one["point"]["outlineColor"]["rgba"]) for one in crew}) == len(crew)
        arcs = {packet["id"].partition("/")[0] for packet in packets if "path" in packet}
        assert len(arcs) == legs


@pytest.mark.parametrize("plan", ["plan.json", "r.json"])
@pytest.mark.parametrize("name", [HOME, OWN])
def test_oem_holds_the_legs_of_one_chaser(files: Cli, plan: str, name: str) -> None:
    """An ephemeris has the chaser's name and its own legs only, from its first to its last time."""
    outcome = files("export", "my.json", plan, "--out", "a.oem", "--chaser", name, "--json")
    assert outcome.status == 0, outcome.err
    told = json.loads(outcome.out)
    text = Path("a.oem").read_text(encoding="utf-8")
    assert set(re.findall(r"OBJECT_NAME = (.*)", text)) == {name}
    legs = [1, 2, 3] if name == HOME else [4, 5, 6, 7]
    assert sorted({int(n) for n in re.findall(r"COMMENT leg (\d+),", text)}) == legs
    assert (told["chaser"], told["legs"]) == (name, len(legs))
    route = next(route for route in planned("j2").routes if route.chaser == name)
    times = [seconds(label) for label in re.findall(r"(?:START|STOP)_TIME = (.*)", text)]
    assert times == sorted(times)
    assert times[0] == pytest.approx(route.legs[0].ready_s, abs=1e-5)
    assert times[-1] == pytest.approx(route.legs[-1].end_s, abs=1e-5)
    assert f"The chaser is {name}, one of 2 of the instance." in text


def test_a_leg_says_whose_it_is(files: Cli) -> None:
    """With a leg no chaser need be named, and a body of a refined plan needs none either."""
    assert files("export", "my.json", "plan.json", "--out", "a.opm", "--leg", 6).status == 0
    assert "OBJECT_NAME = kicker" in Path("a.opm").read_text(encoding="utf-8")
    assert files("export", "my.json", "r.json", "--out", "a.oem", "--leg", 2).status == 0
    assert "OBJECT_NAME = tender" in Path("a.oem").read_text(encoding="utf-8")
    body = ("--body", "debris-006")
    assert files("export", "my.json", "r.json", "--out", "b.oem", *body).status == 0
    assert "OBJECT_NAME = debris-006" in Path("b.oem").read_text(encoding="utf-8")
    refused(files("export", "my.json", "plan.json", "--out", "a.opm", "--leg", 8), "legs 1 to 7")


def test_other_formats_start_with_the_chaser(files: Cli) -> None:
    """OPM and GMAT begin where the chaser does, and have its burns and no others."""
    instance, plan = campaign("j2"), planned("j2")
    for out, pattern in (("a.opm", r"MAN_EPOCH_IGNITION"), ("a.script", r"Create ImpulsiveBurn")):
        outcome = files("export", "my.json", "plan.json", "--out", out, "--chaser", OWN)
        assert outcome.status == 0, outcome.err
        text = Path(out).read_text(encoding="utf-8")
        burns = sum(len(leg.impulses) for leg in plan.routes[1].legs)
        assert len(re.findall(pattern, text)) == burns
        assert "The chaser is kicker" in text
    place = sample(instance, plan).legs[3].arcs[0].positions_m[0]
    text = Path("a.opm").read_text(encoding="utf-8")
    stated = [float(re.search(rf"^{axis} = (\S+)", text, re.M)[1]) for axis in "XYZ"]  # type: ignore[index]
    assert stated == pytest.approx((place / 1e3).tolist(), abs=1e-6)


def test_czml_holds_all_chasers(files: Cli) -> None:
    """A CZML file of a campaign has each chaser, over its own legs, and the path of each arc."""
    assert files("export", "my.json", "plan.json", "--out", "all.czml").status == 0
    packets = json.loads(Path("all.czml").read_text(encoding="utf-8"))
    crew = {packet["id"]: packet for packet in packets if packet["id"].startswith("chaser/")}
    assert [packet["name"] for packet in crew.values()] == [HOME, OWN]
    flown = sample(campaign("j2"), planned("j2"))
    for (at, packet), route in zip(crew.items(), planned("j2").routes, strict=True):
        start, end = packet["availability"].split("/")
        assert seconds(start) == pytest.approx(route.legs[0].ready_s, abs=1e-5)
        assert seconds(end) == pytest.approx(route.legs[-1].end_s, abs=1e-5)
        numbers = [1, 2, 3] if at == "chaser/1" else [4, 5, 6, 7]
        arcs = [arc for path in flown.legs if path.number in numbers for arc in path.arcs]
        assert len(packet["position"]) == len(arcs)
        for part, arc in zip(packet["position"], arcs, strict=True):
            assert part["cartesian"][1:4] == pytest.approx(arc.positions_m[0].tolist(), abs=1e-2)
    names = [packet["name"] for packet in packets if packet["id"].startswith("leg ")]
    assert sum(name.startswith(f"{OWN}, leg ") for name in names) == sum(
        len(path.arcs) for path in flown.legs[3:]
    )
    assert files("export", "my.json", "plan.json", "--out", "one.czml", "--chaser", OWN).status == 0
    one = json.loads(Path("one.czml").read_text(encoding="utf-8"))
    assert [packet["name"] for packet in one if packet["id"].startswith("chaser")] == [OWN]


def test_long_campaigns_show_bodies_while_legs_meet_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where bodies are shown during legs only, spans of different chasers are put together."""
    from adr_opt.export.flights import czml

    monkeypatch.setattr(czml, "MOST_BODY_STATES", 1)
    instance, plan = campaign(), planned()
    flown = sample(instance, plan)
    shown = czml._when_shown(flown)
    for name, spans in shown.items():
        assert all(begin < end for begin, end in spans)
        assert all(a[1] < b[0] for a, b in pairwise(spans))
        for path in flown.legs:
            if name in (path.leg.origin, path.leg.destination):
                begin, end = path.arcs[0].start_s, path.arcs[-1].end_s
                assert any(since <= begin and end <= until for since, until in spans)


def test_one_chaser_is_exported_as_before(tmp_path: Path) -> None:
    """The one chaser of a mission may be named, or not, with the same file."""
    instance = adr_opt.generate("tiny", 0)
    plan = adr_opt.solve(instance, "greedy").plan
    assert plan is not None
    for suffix in ("oem", "czml"):
        plain, named = tmp_path / f"a.{suffix}", tmp_path / f"b.{suffix}"
        write_plan(instance, plan, plain)
        write_plan(instance, plan, named, chaser="chaser")
        lines = [
            [
                line
                for line in path.read_text(encoding="utf-8").splitlines()
                if "CREATION" not in line
            ]
            for path in (plain, named)
        ]
        assert lines[0] == lines[1]
    with pytest.raises(adr_opt.InputError, match="not a chaser of the instance"):
        write_plan(instance, plan, tmp_path / "c.oem", chaser="ghost")
