"""The report and the plots of a plan with low thrust."""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise
from pathlib import Path

import browser
import numpy as np
import pytest
from plans import with_legs
from report_data import data

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M, MU_M3_S2
from adr_opt.kernels.orbits import elements
from adr_opt.plan.palette import chaser_colours
from adr_opt.plan.plan import Plan
from adr_opt.plan.routes import routes_of
from adr_opt.problem.instance import Instance
from adr_opt.sources.generator.rocket_bodies import LIGHT_KG
from adr_opt.ui import plot
from adr_opt.ui.plot.budget import masses
from adr_opt.ui.plot.gantt import segments
from adr_opt.ui.plot.thrust_arcs import thrust_arcs

pytest.importorskip("plotly.graph_objects")

from adr_opt.ui.report import page, write_report
from adr_opt.ui.report.motion import motion
from adr_opt.ui.report.thrust import thrust_times

DAY_S = 86400.0


@cache
def electric() -> tuple[Instance, Plan]:
    """Two chasers that tow a few lighter rocket bodies, and a plan."""
    field = adr_opt.generate("electric", 0, targets=16, chasers=2)
    lighter = tuple(target for target in field.targets if target.mass_kg == LIGHT_KG)
    instance = field.replace(targets=lighter)
    plan = adr_opt.solve(instance, "greedy").plan
    assert plan is not None
    assert adr_opt.check(instance, plan) == ()
    assert sum(leg.manoeuvres is not None for leg in plan.legs) >= 3
    return instance, plan


@pytest.mark.slow
def test_courses_have_no_jumps() -> None:
    """Each phase begins on the orbit on which the one before it ends: arcs lead to the targets."""
    instance, plan = electric()
    for flown in routes_of(instance, plan):
        mine = {number for number, _ in flown.legs}
        arcs = [arc for arc in thrust_arcs(instance, plan) if arc.leg in mine]
        assert {"thrust", "drift", "tow", "service"} <= {arc.phase for arc in arcs}
        for before, after in pairwise(arcs):
            assert after.times_s[0] == pytest.approx(before.times_s[-1], abs=1e-3)
            assert after.altitudes_m[0] == pytest.approx(before.altitudes_m[-1], abs=1.0)
            turned = math.remainder(after.nodes_deg[0] - before.nodes_deg[1], 360.0)
            assert abs(turned) < 2e-3


def test_places_follow_one_another_and_lead_to_targets() -> None:
    """Integrated in small steps, an arc ends where the next begins, and legs end at their targets.

    Where a tow has ended nothing waits, and a chaser waits on from there.
    """
    instance, plan = electric()
    held = motion(instance, plan, thrust_arcs(instance, plan))
    assert held["spirals"]
    rows = instance.orbits()
    met = 0
    for chaser in held["chasers"]:
        for before, after in pairwise(chaser["arcs"]):
            begin_s, end_s, speed, speed_rate = before[2:6]
            steps = np.linspace(0.0, end_s - begin_s, 2001)
            rates = (speed + speed_rate * steps) ** 3 / MU_M3_S2 + before[11]
            here = before[10] + float(np.trapezoid(rates, steps))
            assert math.remainder(here - after[10], 2.0 * math.pi) == pytest.approx(0.0, abs=1e-4)
            assert after[2] == pytest.approx(end_s, abs=1e-3)
            if before[1] == "thrust" and after[1] not in ("thrust", "drift"):
                target = rows[instance.names.index(plan.legs[after[0] - 1].destination)]
                wanted = float(elements.latitudes(target, after[2]))
                off = math.remainder(after[10] - wanted, 2.0 * math.pi)
                assert off == pytest.approx(0.0, abs=1e-9)
                met += 1
            if before[1] == "drift":
                # at most half a revolution in all
                assert abs(before[11]) * (end_s - begin_s) <= math.pi + 1e-9
    assert met == sum(leg.manoeuvres is not None for leg in plan.legs)


def test_between_its_arcs_a_leg_is_on_its_drift_orbit() -> None:
    """The altitude between both arcs is that of the speed that the first one leads to."""
    instance, plan = electric()
    heights = {
        arc.leg: arc.altitudes_m for arc in thrust_arcs(instance, plan) if arc.phase == "drift"
    }
    assert heights
    orbits = {target.name: target.orbit for target in instance.targets}
    for number, low_m in heights.items():
        leg = plan.legs[number - 1]
        assert low_m[0] == low_m[1]
        second = leg.manoeuvres[1]
        speed = math.sqrt(3.986004418e14 / orbits[leg.destination].semi_major_axis_m)
        radius = 3.986004418e14 / (speed + second.size_m_s) ** 2
        assert low_m[0] == pytest.approx(radius - EARTH_RADIUS_M, abs=2.0)


def test_thrust_is_drawn_within_its_windows() -> None:
    """Positions along an arc lie within the windows about two opposite places of the orbit."""
    instance, plan = electric()
    drawn = [arc for arc in thrust_arcs(instance, plan) if arc.phase == "thrust"]
    shown = [arc for arc in drawn if arc.around_m.size]
    assert 0 < len(shown) < len(drawn)
    for arc in shown:
        leg = plan.legs[arc.leg - 1]
        stated = next(one for one in leg.manoeuvres if one.start_s <= arc.times_s[0] < one.end_s)
        node = math.radians(arc.nodes_deg[0])
        ascending = np.array([math.cos(node), math.sin(node), 0.0])
        points = arc.around_m[~np.isnan(arc.around_m[:, 0])]
        along = points @ ascending / np.linalg.norm(points, axis=1)
        latitudes = np.degrees(np.arccos(along)) * np.where(points[:, 2] < 0.0, -1.0, 1.0)
        off = latitudes - stated.argument_of_latitude_deg
        away = np.abs((off + 90.0) % 180.0 - 90.0)
        assert away.max() == pytest.approx(stated.window_deg, abs=1e-3)


def test_phases_follow_one_another() -> None:
    """Thrust, drift and thrust fill a leg, and what follows a tow does not wait beside it."""
    instance, plan = electric()
    for flown in routes_of(instance, plan):
        mine = {number for number, _ in flown.legs}
        found = [segment for segment in segments(instance, plan) if segment.leg in mine]
        for before, after in pairwise(found):
            assert after.start_s == pytest.approx(before.end_s, abs=1e-3)
        phases = [segment.phase for segment in found]
        at = phases.index("drift")
        assert phases[at - 1] == phases[at + 1] == "thrust"


def test_masses_fall_to_those_of_the_plan() -> None:
    """The mass falls along arcs and tows alone, and after each leg it is what the plan states."""
    instance, plan = electric()
    found = masses(instance, plan)
    assert set(found) == {chaser.name for chaser in instance.chasers}
    for flown in routes_of(instance, plan):
        knots = found[flown.chaser.name]
        assert knots[0][2] == pytest.approx(900.0)
        for (_, t, m), (_, after_s, after_kg) in pairwise(knots):
            assert after_s >= t
            assert after_kg <= m + 1e-6
        for number, leg in flown.legs:
            last = [mass_kg for at, _, mass_kg in knots if at == number][-1]
            assert last == pytest.approx(leg.mass_kg, rel=1e-9)


def test_times_of_thrust_take_the_propellant() -> None:
    """Full thrust for the times that are told takes as much propellant as the plan."""
    instance, plan = electric()
    for flown in routes_of(instance, plan):
        times = thrust_times(instance, flown)
        flow_kg_s = 0.4 / (1800.0 * 9.80665)
        used_kg = flow_kg_s * sum(each.leg_on_s + each.tow_on_s for each in times.values())
        assert used_kg == pytest.approx(flown.carried(instance).used_kg, rel=1e-9)
        for each in times.values():
            assert each.leg_on_s <= each.arcs_s
            assert each.tow_on_s <= each.tow_s


def test_the_page_shows_arcs_masses_and_times_of_thrust(tmp_path: Path) -> None:
    """It has charts of orbits, altitude, nodes and mass, and tables of thrust, but no close-up."""
    instance, plan = electric()
    written = write_report(instance, plan, tmp_path / "a.html")
    assert written.trouble is None
    text = (tmp_path / "a.html").read_text(encoding="utf-8")
    shown = data(text)
    assert {"altitude", "nodes", "mass", "lanes"} <= set(shown["figures"])
    assert shown["motion"]["spirals"]
    for chart in ("orbits", "altitude", "mass"):
        assert f'id="{chart}"' in text
    assert "<h2>Thrust</h2>" in text
    assert 'data-phase="thrust"' in text
    assert 'id="ground"' in text
    assert 'id="closeup"' not in text
    traces = shown["figures"]["mass"]["data"]
    assert [trace["line"]["color"] for trace in traces] == list(chaser_colours(instance).values())
    phases = {trace.get("meta", {}).get("phase") for trace in shown["figures"]["altitude"]["data"]}
    assert {"thrust", "drift", "tow"} <= phases


def test_plots_follow_arcs() -> None:
    """On an axis of matplotlib altitude, nodes and mass of the same plan are drawn."""
    pyplot = pytest.importorskip("matplotlib.pyplot")
    instance, plan = electric()
    figure, axes = pyplot.subplots(3)
    for ax, function in zip(axes, (plot.altitude, plot.nodes, plot.mass), strict=True):
        assert function(ax, instance, plan) is ax
        assert len(ax.lines) >= 2
    pyplot.close(figure)


def test_a_plan_whose_arcs_lead_nowhere_is_still_told_of() -> None:
    """An arc that takes more speed than there is stands at the top, and the tables below."""
    instance, plan = electric()
    at = next(at for at, leg in enumerate(plan.legs) if leg.manoeuvres is not None)
    arcs = plan.legs[at].manoeuvres
    wrong = plan.legs[at].replace(manoeuvres=(arcs[0].replace(size_m_s=1e5), arcs[1]))
    spoilt = with_legs(plan, [*plan.legs[:at], wrong, *plan.legs[at + 1 :]])
    text = page(instance, spoilt)
    assert f"leg {at + 1}: its arcs do not lead to a closed orbit" in text
    assert "the change of size is incomplete" in text


@pytest.mark.slow
@pytest.mark.skipif(browser.EXECUTABLE is None, reason="no Chromium")
@pytest.mark.parametrize("width", [1400, 390])
def test_the_page_of_low_thrust_draws_everything(width: int, tmp_path: Path) -> None:
    """In a browser all its charts are drawn, nothing goes wrong, and nothing is too wide.

    Along spirals a chaser is above the ground where its orbit has it.
    """
    instance, plan = electric()
    held = motion(instance, plan, thrust_arcs(instance, plan))
    write_report(instance, plan, tmp_path / "a.html")
    with browser.Browser(tmp_path / "profile", width=width) as opened:
        opened.open_report(tmp_path / "a.html")
        for chart in ("altitude", "mass", "nodes", "gantt"):
            assert opened.evaluate(f"document.querySelectorAll('#{chart} .main-svg').length") > 0
        arcs = held["chasers"][0]["arcs"]
        for phase in ("thrust", "drift", "tow", "service"):
            arc = next(arc for arc in arcs if arc[1] == phase)
            opened.evaluate(
                f"document.getElementById('time').value = {0.5 * (arc[2] + arc[3])};"
                "document.getElementById('time').dispatchEvent(new Event('input'))"
            )
            now = opened.evaluate("Number(document.getElementById('time').value)")
            _, _, begin_s, _, speed, speed_rate, tilt, tilt_rate, _, _, latitude, rate, *_ = next(
                arc for arc in arcs if arc[2] <= now < arc[3]
            )
            since = np.linspace(0.0, now - begin_s, 20001)
            speeds = speed + speed_rate * since
            turned = latitude + rate * since[-1] + np.trapezoid(speeds**3 / MU_M3_S2, since)
            north = math.asin(math.sin(tilt + tilt_rate * since[-1]) * math.sin(turned))
            height = (MU_M3_S2 / speeds[-1] ** 2 - EARTH_RADIUS_M) / 1e3
            cells = "[...document.querySelector('tr[data-chaser=\"0\"]').cells]"
            number = f"Number({cells}[{{}}].textContent.replace('−', '-'))"
            opened.wait_for(f"Math.abs({number.format(3)} - {height}) < 0.06")
            opened.wait_for(f"Math.abs({number.format(4)} - {math.degrees(north)}) < 0.02")
        assert opened.evaluate("document.documentElement.scrollWidth") <= width
        assert [text for level, text in opened.complaints if level == "error"] == []
