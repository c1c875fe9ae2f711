"""Day and night on the report, the view that follows a chaser, and reports without a mouse."""

from __future__ import annotations

import json
import math
import re
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import browser
import numpy as np
import page_access
import pytest
from report_data import body_at
from six_kinds import SEED
from two_chasers import campaign, planned

import adr_opt
from adr_opt.kernels.orbits.sunlight import shadow
from adr_opt.plan.plan import Plan
from adr_opt.problem.frame import Frame
from adr_opt.problem.instance import Instance
from adr_opt.problem.sun import J2000, Sun, sun

pytest.importorskip("plotly.graph_objects")

from adr_opt.ui.report import page, write_report

DAY_S = 86400.0


def direction(held: Sun, time_s: float) -> np.ndarray:
    """Unit vector to the Sun from what the page holds."""
    anomaly = held.anomaly_rad + held.anomaly_rate_rad_s * time_s
    along = held.longitude_rad + held.longitude_rate_rad_s * time_s
    along += held.centre_rad * math.sin(anomaly) + held.centre_twice_rad * math.sin(2.0 * anomaly)
    c, s = math.cos(held.obliquity_rad), math.sin(held.obliquity_rad)
    return np.array([math.cos(along), c * math.sin(along), s * math.sin(along)])


@pytest.mark.parametrize("frame", [None, "GCRF"])
def test_the_sun_is_where_the_earth_has_it(frame: str | None) -> None:
    """Within 0.02° of the Earth's orbit in the library of the IAU, in both frames, for 20 years."""
    erfa = pytest.importorskip("erfa")
    instance = campaign() if frame is None else campaign().replace(frame=Frame(name=frame))
    held = sun(instance)
    for days in np.linspace(0.0, 7300.0, 41):
        then = instance.epoch + timedelta(days=float(days))
        since = (then - J2000).total_seconds() / DAY_S
        to_earth, _ = erfa.epv00(2451545.0, since)
        true = -np.array(to_earth["p"])
        if frame is None:
            true = erfa.bp06(2451545.0, since)[2] @ true
        off = math.acos(np.clip(direction(held, days * DAY_S) @ true / np.linalg.norm(true), -1, 1))
        assert math.degrees(off) < 0.02


def test_seasons_begin_when_they_do() -> None:
    """At equinoxes and solstices of 2026 the Sun is at the quarters of the ecliptic."""
    instance = campaign()
    held = sun(instance)
    seasons = {
        datetime(2026, 3, 20, 14, 46, tzinfo=UTC): 0.0,
        datetime(2026, 6, 21, 8, 25, tzinfo=UTC): 23.44,
        datetime(2026, 9, 23, 0, 5, tzinfo=UTC): 0.0,
        datetime(2026, 12, 21, 20, 50, tzinfo=UTC): -23.44,
    }
    for then, height in seasons.items():
        x, y, z = direction(held, (then - instance.epoch).total_seconds())
        assert math.degrees(math.asin(z)) == pytest.approx(height, abs=0.01)
        quarter = math.degrees(math.atan2(math.hypot(y, z), x)) % 90.0
        assert min(quarter, 90.0 - quarter) < 0.02


with_browser = pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
GLOBE = "document.getElementById('orbits')"
NOW = "Number(document.getElementById('time').value)"
TRACE = "document.getElementById('ground').data.find(({{ name }}) => name === '{}')"
CELL = "document.querySelector('tr[data-chaser=\"{}\"]').cells[7].textContent === '{}'"


def in_spring() -> tuple[Instance, Plan]:
    """The campaign three months later, when the Sun is near the planes of its orbits."""
    instance = campaign().replace(epoch=datetime(2026, 4, 1, tzinfo=UTC))
    plan = planned()
    return instance, plan.replace(instance=plan.instance.replace(sha256=instance.sha256))


def set_time(tab: browser.Browser, time_s: float) -> float:
    """Move the slider, and give the time that it stands at."""
    tab.evaluate(
        f"document.getElementById('time').value = {time_s};"
        "document.getElementById('time').dispatchEvent(new Event('input'))"
    )
    return float(tab.evaluate(NOW))


def chosen(tab: browser.Browser, name: str, value: str) -> None:
    """Choose an entry of a list."""
    tab.evaluate(
        f"((list) => {{ list.value = '{value}'; list.dispatchEvent(new Event('change')); }})"
        f"(document.getElementById('{name}'))"
    )


def press(tab: browser.Browser, where: str, key: str) -> None:
    """A key on an element."""
    tab.evaluate(
        f"document.querySelector('{where}').dispatchEvent(new KeyboardEvent('keydown', "
        f"{{ key: '{key}', bubbles: true, cancelable: true }}))"
    )


def is_lit(body: dict[str, Any], time_s: float) -> bool:
    """Whether the circle of a body is in sunlight where the body is."""
    radius, inclination, node, node_rate, latitude, latitude_rate = body["row"]
    since = (in_spring()[0].epoch - J2000).total_seconds() + time_s
    dark = shadow(radius, inclination, node + node_rate * time_s, since)
    u = latitude + latitude_rate * time_s
    return abs(math.remainder(u - dark.middle, 2.0 * math.pi)) > dark.half


@with_browser
def test_the_globe_without_a_mouse(tmp_path: Path) -> None:
    """Night is where the Sun is down, chasers are followed, keys work, and nothing is in the way.

    One page for all, as browsers take long to start.
    """
    text = page(*in_spring())
    held = json.loads(re.search(r'(?s)id="mission">(.*?)</script>', text)[1])
    (tmp_path / "page.html").write_text(text, encoding="utf-8")
    with browser.Browser(tmp_path / "profile") as tab:
        tab.open_report(tmp_path / "page.html")
        tab.evaluate("document.getElementById('ground').scrollIntoView()")
        tab.wait_for(f"document.getElementById('ground').data && {TRACE.format('Sun')}")

        # On the map the Sun is where it is, and night is what it does not see.
        angle, rate = held["motion"]["sidereal"]
        leg = planned().legs[0]
        now = set_time(tab, leg.docked_s + 0.3 * (leg.end_s - leg.docked_s))
        to_sun = direction(Sun(*held["motion"]["sun"]), now)
        east = math.atan2(to_sun[1], to_sun[0]) - angle - rate * now
        north = math.degrees(math.asin(to_sun[2]))
        tab.wait_for(f"Math.abs({TRACE.format('Sun')}.y[0] - {north}) < 1e-6")
        shown = tab.evaluate(f"{TRACE.format('Sun')}.x[0]")
        assert math.remainder(shown - math.degrees(east), 360.0) == pytest.approx(0.0, abs=1e-6)
        outline = np.array(tab.evaluate(f"(({{ x, y }}) => [x, y])({TRACE.format('night')})"))
        assert outline[1, -2] == outline[1, -3] == math.copysign(90.0, -north)
        for x, y in outline[:, :-3].T:
            lat, lon = math.radians(y), math.radians(x) - east
            height = math.cos(lat) * math.cos(lon) * math.cos(math.radians(north))
            height += math.sin(lat) * math.sin(math.radians(north))
            assert height == pytest.approx(0.0, abs=1e-9)

        # In service a chaser is in the sunlight that its target has.
        moments = {}
        for leg, facts in zip(planned().legs, held["motion"]["legs"], strict=True):
            body = held["motion"]["bodies"][facts["to"]]
            for share in np.linspace(0.05, 0.95, 10):
                then = leg.docked_s + share * (leg.end_s - leg.docked_s)
                moments.setdefault(is_lit(body, then), (then, body, facts["chaser"]))
        assert set(moments) == {True, False}
        for then, body, row in moments.values():
            now = set_time(tab, then)
            place, lit = body_at(body, now), is_lit(body, now)
            cell = CELL.format(row, "sunlight" if lit else "shadow")
            tab.wait_for(cell)

        # The view that follows a chaser has it in its middle.
        tab.evaluate(f"{GLOBE}.scrollIntoView()")
        chosen(tab, "view", str(row))
        chaser = held["motion"]["chasers"][row]["name"]
        middle = np.array(tab.evaluate(f"[{GLOBE}.clientWidth / 2, {GLOBE}.clientHeight / 2]"))
        mine = f"{GLOBE}.marks.find(({{ body, name }}) => body === null && name === '{chaser}')"
        tab.wait_for(f"Math.abs({mine}?.x - {middle[0]}) < 1")
        assert tab.evaluate(f"(({{ x, y }}) => [x, y])({mine})") == pytest.approx(middle, abs=1.0)
        assert tab.evaluate(f"{GLOBE}.seen.at(...{place.tolist()}).slice(0, 2)") == pytest.approx(
            middle, abs=1.0
        )
        chosen(tab, "view", "")
        tab.wait_for(f"{GLOBE}.seen.earth[0] === {middle[0]}")
        before = tab.evaluate(f"{GLOBE}.seen.eye")
        press(tab, "#orbits", "ArrowRight")
        tab.wait_for(f"{GLOBE}.seen.eye[0] !== {before[0]}")

        # It comes nearer by a key, and goes back; bodies behind the Earth are not seen.
        width = f"{GLOBE}.seen.radius"
        whole = tab.evaluate(width)
        press(tab, "#orbits", "+")
        tab.wait_for(f"Math.abs({width} / 1.25 - {whole}) < 1e-6 * {whole}")
        press(tab, "#orbits", "-")
        tab.wait_for(f"Math.abs({width} - {whole}) < 1e-6 * {whole}")
        seen = {name for name in tab.evaluate(f"{GLOBE}.marks.map(({{ name }}) => name)")}
        eye = np.array(tab.evaluate(f"{GLOBE}.seen.eye"))
        for body in held["motion"]["bodies"]:
            at = body_at(body, now)
            aside = np.linalg.norm(at - eye * (at @ eye))
            assert (body["name"] in seen) == (at @ eye > 0.0 or aside > held["motion"]["radius"])

        # Time is played faster and slower by keys, and tools of a chart are one stop.
        speed = "document.getElementById('speed').selectedIndex"
        index = tab.evaluate(speed)
        press(tab, "#time", "+")
        assert tab.evaluate(speed) == index + 1
        press(tab, "#time", "-")
        assert tab.evaluate(speed) == index
        assert tab.evaluate(
            "[...document.querySelectorAll('.modebar')].every((bar) =>"
            " [...bar.querySelectorAll('button')].filter(({ tabIndex }) => tabIndex === 0).length"
            " === 1)"
        )

        # What is spoken keeps still while time is played, and tells the moment once it rests.
        tab.evaluate(
            "window.said = 0; window.moved = 0;"
            "const watch = (id, what) => new MutationObserver(() => { window[what] += 1; })"
            ".observe(document.getElementById(id), { childList: true, characterData: true,"
            " subtree: true }); watch('spoken', 'said'); watch('then', 'moved');"
        )
        press(tab, "#time", " ")
        tab.wait_for("window.moved >= 5")
        assert tab.evaluate("window.said") <= 1
        press(tab, "#time", " ")
        now = tab.wait_for("document.getElementById('now').textContent")
        tab.wait_for(f"document.getElementById('spoken').textContent.startsWith('{now}')")
        spoken = tab.evaluate("document.getElementById('spoken').textContent")
        assert re.search(r"km above \d+°.* in (sunlight|shadow)", spoken)

        # The other widths and schemes are those of test_pages_are_for_everybody.
        assert page_access.faults(tab, widths=(page_access.PHONE,), schemes=("dark",)) == []
        assert [said for level, said in tab.complaints if level == "error"] == []
        assert all(url.startswith(("file:", "data:", "blob:")) for url in tab.requests)


@with_browser
def test_a_tour_is_shown_alone(tmp_path: Path) -> None:
    """Globe and slider have the legs between two stays at a station, and then all legs again."""
    instance = adr_opt.generate("nominal", SEED)
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    stays = [at for at, leg in enumerate(plan.legs, 1) if leg.destination in instance.station_names]
    first, last = stays[0] + 1, stays[1]
    write_report(instance, plan, tmp_path / "mission.html")
    with browser.Browser(tmp_path / "profile") as tab:
        tab.open_report(tmp_path / "mission.html")
        for tour, legs in (("tour 0 1", (first, last)), ("", (1, len(plan.legs)))):
            chosen(tab, "view", tour)
            tab.wait_for(f"{GLOBE}.legs.length === {legs[1] - legs[0] + 1}")
            assert tab.evaluate(f"{GLOBE}.legs") == list(range(legs[0], legs[1] + 1))
            begin = plan.legs[first - 1].ready_s if tour else 0.0
            assert tab.evaluate("Number(document.getElementById('time').min)") == pytest.approx(
                begin, abs=0.1
            )
