"""What the report moves chasers and targets by, and the slider that does it."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any

import browser
import numpy as np
import pytest
from drifting_plans import drifting_instance, drifting_plan
from report_data import body_at
from two_chasers import OWN, campaign, planned

from adr_opt import generate, solve
from adr_opt.fly.trajectory import body_states, propagate, sample
from adr_opt.fly.trajectory.kepler import turned
from adr_opt.plan.plan import Plan
from adr_opt.problem.frame import Frame
from adr_opt.problem.instance import Instance
from adr_opt.problem.sun import greenwich, sidereal_angle_rad, sidereal_rate_rad_s
from adr_opt.ui.plot.strands import tracks
from adr_opt.ui.report import page
from adr_opt.ui.report.motion import motion

DAY_S = 86400.0
TURN = 2.0 * math.pi


@cache
def mission(kind: str) -> tuple[Instance, Plan, dict[str, Any]]:
    """A plan with what its page moves by, as it is read from the page."""
    instance, plan = {
        "two chasers": lambda: (campaign(), planned()),
        "drift": lambda: (drifting_instance(), drifting_plan()),
    }[kind]()
    held = json.loads(json.dumps(motion(instance, plan, tracks(instance, plan))))
    return instance, plan, held


def arc_at(arc: list[Any], time_s: float) -> np.ndarray:
    """Where the page has a chaser."""
    since = time_s - arc[2]
    (position,), _ = propagate(arc[4:7], arc[7:10], [arc[10] * since])
    return turned(position[None], np.array([arc[11] * since]))[0]


def seen_from(body: dict[str, Any], time_s: float, position: np.ndarray) -> np.ndarray:
    """Radial, along the arc of the track, and across it, in metres."""
    place, later = body_at(body, time_s), body_at(body, time_s + 1e-3)
    up = place / np.linalg.norm(place)
    normal = np.cross(place, later - place)
    side = normal / np.linalg.norm(normal)
    a, b = position @ up, position @ np.cross(side, up)
    radius = np.linalg.norm(place)
    return np.array([math.hypot(a, b) - radius, radius * math.atan2(b, a), position @ side])


def arcs_of(held: dict[str, Any]) -> Iterator[list[Any]]:
    """All arcs of a page."""
    return (arc for chaser in held["chasers"] for arc in chaser["arcs"])


@pytest.mark.parametrize("kind", ["two chasers", "drift"])
def test_bodies_and_chasers_are_where_the_propagator_has_them(kind: str) -> None:
    """To a millimetre, on all bodies over the whole mission and at samples of every arc."""
    instance, plan, held = mission(kind)
    for body in held["bodies"]:
        for time_s in (0.0, 0.37 * instance.mission.duration_s, instance.mission.duration_s):
            (true,), _ = body_states(instance, body["name"], time_s)
            assert np.linalg.norm(body_at(body, time_s) - true) < 1e-3
    flown = list(sample(instance, plan).arcs())
    shown = list(arcs_of(held))
    assert len(shown) == len(flown)
    for (path, true), arc in zip(flown, shown, strict=True):
        assert (arc[0], arc[2], arc[3]) == (path.number, true.start_s, true.end_s)
        for at in (0, true.times_s.size // 3, -1):
            off = arc_at(arc, float(true.times_s[at])) - true.positions_m[at]
            assert np.linalg.norm(off) < 1e-3


@pytest.mark.parametrize("kind", ["two chasers", "drift"])
def test_legs_end_at_their_targets(kind: str) -> None:
    """Seen from its target a chaser is at the stand-off behind it, and then there.

    To metres under J2, where the approach is one of two bodies, and else to centimetres.
    """
    instance, plan, held = mission(kind)
    close = 0.2 if kind == "two chasers" else 2.0
    assert len(held["legs"]) == len(plan.legs)
    for number, leg in enumerate(held["legs"], start=1):
        target = held["bodies"][leg["to"]]
        assert target["name"] == plan.legs[number - 1].destination
        (approach,) = (arc for arc in arcs_of(held) if arc[0] == number and arc[1] == "approach")
        assert (approach[2], approach[3]) == (leg["standoff"], leg["docked"])
        begins = seen_from(target, leg["standoff"], arc_at(approach, leg["standoff"]))
        assert begins == pytest.approx([0.0, -instance.transfer.standoff_m, 0.0], abs=close)
        ends = seen_from(target, leg["docked"], arc_at(approach, leg["docked"]))
        assert ends == pytest.approx([0.0, 0.0, 0.0], abs=close)


def test_greenwich_turns_as_it_does_for_others() -> None:
    """The angle at J2000, a turn in a sidereal day, and that of the library of SGP4."""
    j2000 = datetime(2000, 1, 1, 12, tzinfo=UTC)
    assert math.degrees(sidereal_angle_rad(j2000)) == pytest.approx(280.46061837, abs=1e-6)
    assert TURN / sidereal_rate_rad_s() == pytest.approx(86164.0905, abs=1e-3)
    later = datetime(2026, 3, 5, 17, 20, tzinfo=UTC)
    gstime = pytest.importorskip("sgp4.propagation").gstime
    days = (later - j2000).total_seconds() / DAY_S + 2451545.0
    assert sidereal_angle_rad(later) == pytest.approx(gstime(days), abs=1e-8)


def test_greenwich_counts_in_the_frame_of_the_instance() -> None:
    """In GCRF it is the Earth rotation angle of the IERS; from the equinox of date 0.33° more."""
    erfa = pytest.importorskip("erfa")
    instance = generate("tiny", 0)
    days = (instance.epoch - datetime(2000, 1, 1, 12, tzinfo=UTC)).total_seconds() / 86400.0
    of_date, rate = greenwich(instance)
    assert (of_date, rate) == (sidereal_angle_rad(instance.epoch), sidereal_rate_rad_s())
    teme = instance.replace(frame=Frame(name="TEME", axes_epoch=instance.epoch))
    assert greenwich(teme) == (of_date, rate)
    for name in ("GCRF", "EME2000"):
        angle, turning = greenwich(instance.replace(frame=Frame(name=name)))
        assert angle == pytest.approx(erfa.era00(2451545.0, days), abs=1e-9)
        assert math.degrees(of_date - angle) == pytest.approx(0.33, abs=0.005)
        assert TURN / turning == pytest.approx(86164.0989, abs=1e-3)


with_browser = pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
NOW = "Number(document.getElementById('time').value)"


def press(tab: browser.Browser, key: str) -> None:
    """A key goes down and up again."""
    text = {"text": " "} if key == " " else {}
    code = {" ": 32, "End": 35, "Home": 36, "ArrowLeft": 37, "ArrowRight": 39}[key]
    for kind in ("keyDown", "keyUp"):
        tab.call(
            "Input.dispatchKeyEvent",
            type=kind,
            key=key,
            code="Space" if key == " " else key,
            windowsVirtualKeyCode=code,
            **(text if kind == "keyDown" else {}),
        )


@with_browser
@pytest.mark.slow
def test_the_slider_moves_the_mission(tmp_path: Path) -> None:
    """By keys: chasers are where the propagator has them; playing goes on, and stops again."""
    pytest.importorskip("plotly")
    from adr_opt.ui.report import write_report

    instance, plan, held = mission("two chasers")
    write_report(instance, plan, tmp_path / "mission.html")
    options = ("--disable-3d-apis", "--force-prefers-reduced-motion")
    with browser.Browser(tmp_path / "profile", options=options) as tab:
        tab.open_report(tmp_path / "mission.html")
        tab.evaluate("document.getElementById('ground').scrollIntoView()")
        tab.evaluate("document.getElementById('time').focus()")
        step = tab.evaluate("Number(document.getElementById('time').step)")
        for key, wanted in (("ArrowRight", step), ("ArrowRight", 2 * step), ("ArrowLeft", step)):
            press(tab, key)
            assert tab.evaluate(NOW) == wanted
        said = tab.evaluate("document.getElementById('time').getAttribute('aria-valuetext')")
        assert said.startswith("0\u202fd ")

        # The second chaser in the middle of its first transfer, in the table and on the map.
        row = next(at for at, chaser in enumerate(held["chasers"]) if chaser["name"] == OWN)
        leg = held["chasers"][row]["arcs"][0][0]
        middle = 0.5 * (held["legs"][leg - 1]["leaves"] + held["legs"][leg - 1]["docked"])
        tab.evaluate(
            f"document.getElementById('leg').value = '{leg}';"
            "document.getElementById('leg').dispatchEvent(new Event('change'));"
            f"document.getElementById('time').value = {middle};"
            "document.getElementById('time').dispatchEvent(new Event('input'))"
        )
        cells = f"[...document.querySelectorAll('tr[data-chaser=\"{row}\"] td')]"
        tab.wait_for(f"{cells}[1].textContent.startsWith('{leg} ')")
        now = tab.evaluate(NOW)
        assert abs(now - middle) <= step
        (arc,) = (
            arc for arc in held["chasers"][row]["arcs"] if arc[0] == leg and arc[2] <= now < arc[3]
        )
        place = arc_at(arc, now)
        angle, rate = held["sidereal"]
        east = math.degrees(math.atan2(place[1], place[0]) - angle - rate * now)
        north = math.degrees(math.asin(place[2] / np.linalg.norm(place)))
        shown = [
            float(text.replace("−", "-"))
            for text in tab.evaluate(f"{cells}.slice(3, 6).map((cell) => cell.textContent)")
        ]
        assert shown[0] == pytest.approx((np.linalg.norm(place) - 6378137.0) / 1e3, abs=0.051)
        assert shown[1] == pytest.approx(north, abs=0.0051)
        assert math.remainder(shown[2] - east, 360.0) == pytest.approx(0.0, abs=0.0051)
        tab.wait_for("document.getElementById('ground').data.at(-1).name === 'chasers'")
        marks = tab.evaluate("document.getElementById('ground').data.at(-1).y")
        assert marks[row] == pytest.approx(north, abs=1e-6)

        # In close-up the leg ends where its target is, and the approach begins at the stand-off.
        tab.evaluate("document.querySelector('button[data-part=\"approach\"]').click()")
        tab.evaluate("document.getElementById('closeup').scrollIntoView()")
        way = "document.getElementById('closeup').data.find(({ name }) => name === 'approach')"
        tab.wait_for(f"{way}?.x.length > 30 && {way}.x[0] < -900")
        first, last = tab.evaluate(f"[0, -1].map((at) => [{way}.x.at(at), {way}.y.at(at)])")
        assert first == pytest.approx([-instance.transfer.standoff_m, 0.0], abs=0.2)
        assert last == pytest.approx([0.0, 0.0], abs=0.2)

        shown = "document.getElementById('closeup').data.filter((one) => one.visible !== false)"
        assert tab.evaluate(f"{shown}.map(({{ name }}) => name)") == [
            "approach",
            "target",
            "chaser",
        ]

        # Who wants little motion gets a picture a second, and may stop it; the end stops it too.
        begin = plan.legs[leg - 1].ready_s
        press(tab, "Home")
        assert tab.evaluate(NOW) == pytest.approx(begin, abs=0.1)
        tab.evaluate(
            "window.pictures = 0; window.began = performance.now();"
            "document.getElementById('speed').value = '60';"
            "const slider = document.getElementById('time');"
            "new MutationObserver(() => { window.pictures += 1; })"
            ".observe(slider, { attributeFilter: ['aria-valuetext'] });"
        )
        press(tab, " ")
        tab.wait_for(f"{NOW} > {begin} + 100")
        assert tab.evaluate("window.pictures <= 2 + (performance.now() - window.began) / 1000")
        assert tab.evaluate("document.getElementById('play').getAttribute('aria-label')") == "pause"
        press(tab, " ")
        stopped = tab.evaluate(NOW)
        tab.call(
            "Runtime.evaluate",
            expression="new Promise((done) => setTimeout(done, 1300))",
            awaitPromise=True,
        )
        assert tab.evaluate(NOW) == stopped
        press(tab, "End")
        assert tab.evaluate(NOW) == pytest.approx(plan.legs[leg - 1].end_s, abs=step)
        assert [text for level, text in tab.complaints if level == "error"] == []


def rounding() -> tuple[Instance, Plan]:
    """A plan whose targets are approached on safety ellipses."""
    instance = generate("tiny", 2, approach="safety-ellipse")
    plan = solve(instance, "greedy-guarded").plan
    assert plan is not None
    return instance, plan


def test_the_page_says_what_a_safety_ellipse_keeps_out_of() -> None:
    """Its radius is among what the page moves by and in words; of half laps there is none."""
    instance, plan = rounding()
    assert motion(instance, plan, tracks(instance, plan))["keepOut"] == 200.0
    assert mission("two chasers")[2]["keepOut"] is None
    assert "stays out of the dotted circle of 200 m" in page(instance, plan)


@with_browser
@pytest.mark.slow
def test_the_close_up_shows_what_is_kept_out_of(tmp_path: Path) -> None:
    """A circle about the target, which the way enters only in its last half lap."""
    pytest.importorskip("plotly")
    from adr_opt.ui.report import write_report

    instance, plan = rounding()
    write_report(instance, plan, tmp_path / "ellipse.html")
    with browser.Browser(tmp_path / "profile", options=("--disable-3d-apis",)) as tab:
        tab.open_report(tmp_path / "ellipse.html")
        tab.evaluate("document.getElementById('closeup').scrollIntoView()")
        tab.evaluate("document.querySelector('button[data-part=\"approach\"]').click()")
        ring = "document.getElementById('closeup').data.find(({ name }) => name === 'kept out of')"
        tab.wait_for(f"{ring} !== undefined")
        x, y = (np.array(tab.evaluate(f"{ring}.{axis}")) for axis in "xy")
        assert np.hypot(x, y) == pytest.approx(200.0, abs=0.01)
