"""The report and the plots of a plan whose nodes drift."""

from __future__ import annotations

import json
import math
import re
import sys
from itertools import pairwise
from pathlib import Path

import browser
import numpy as np
import pytest
from conftest import Cli
from drifting_plans import DAY_S, drifting_instance, drifting_plan, with_a_tight_tank
from hypothesis import given
from hypothesis import strategies as st
from plans import with_legs
from report_data import data

import adr_opt
from adr_opt.fly.flight.mean_flight import fly_mean
from adr_opt.fly.flight.tanks import tanks_of
from adr_opt.fly.refine import refine
from adr_opt.kernels.orbits import columns
from adr_opt.plan.refined_plan import Missing
from adr_opt.ui import plot
from adr_opt.ui.plot.budget import budgets
from adr_opt.ui.plot.nodes import Nodes, nodes_of, of_body, of_track
from adr_opt.ui.plot.strands import tracks

plotly_graph_objects = pytest.importorskip("plotly.graph_objects")

from adr_opt.ui.report import figures, page, write_report  # noqa: E402
from adr_opt.ui.report.text import lasting  # noqa: E402

MISSION = (drifting_instance, drifting_plan)


def words(text: str) -> str:
    """What stands on a page, without scripts, style and tags."""
    text = re.sub(r"(?s)<(script|style)\b[^>]*>.*?</\1>", "", text)
    return " ".join(re.sub(r"<[^>]*>", " ", text).split())


@given(
    ends=st.tuples(st.floats(-4e3, 4e3), st.floats(-4e3, 4e3)),
    span=st.floats(1.0, 1e8),
    common=st.floats(-1e-4, 1e-4),
    low=st.floats(-360.0, 360.0),
)
def test_lines_of_nodes_go_around(
    ends: tuple[float, float], span: float, common: float, low: float
) -> None:
    """Whatever the drift: shown angles are in the window, and where they belong, to whole turns."""
    times = np.array([5.0, 5.0 + span])
    shown = Nodes(common, low)
    at, angles = shown.line(times, np.array(ends))
    known = ~np.isnan(at)
    assert at[0] == times[0]
    assert at[-1] == pytest.approx(times[1])
    assert np.all(np.diff(at[known]) >= 0.0)
    assert angles[known].min() >= low - 1e-6
    assert angles[known].max() <= low + 360.0 + 1e-6
    true = np.interp(at[known], times, ends) - common * at[known]
    turns = (true - angles[known]) / 360.0
    assert np.abs(turns - np.round(turns)).max() < 1e-6
    for (t_0, a_0), (t_1, a_1) in pairwise(zip(at, angles, strict=True)):
        if not (math.isnan(t_0) or math.isnan(t_1)) and t_1 - t_0 > 1e-6 * span:
            slope = (ends[1] - ends[0]) / span - common
            assert (a_1 - a_0) / (t_1 - t_0) == pytest.approx(slope, rel=1e-3, abs=1e-6)


def test_the_chaser_goes_from_node_to_node() -> None:
    """While it waits and serves, its line is the body's; on the drift orbit it crosses."""
    instance, plan = (make() for make in MISSION)
    shown, rows = nodes_of(instance), instance.orbits()
    found = tracks(instance, plan)
    for track in found:
        if track.phase not in ("wait", "service"):
            continue
        leg = plan.legs[track.leg - 1]
        at_origin = track.times_s[0] < leg.burns[0].time_s
        row = rows[instance.names.index(leg.origin if at_origin else leg.destination)]
        times, angles = of_track(shown, track)
        bodies = np.degrees(row[columns.RAAN] + row[columns.RAAN_RATE] * times)
        off = angles + shown.common_deg_s * times - bodies
        assert np.abs(np.remainder(off + 180.0, 360.0) - 180.0).max() < 1e-6
    (drift,) = (track for track in found if track.phase == "drift")
    _, (begin, end) = of_track(shown, drift)
    _, near = of_body(instance, shown, instance.names.index("near"), 60 * DAY_S)
    _, far = of_body(instance, shown, instance.names.index("far"), 60 * DAY_S)
    assert abs(begin - near.mean()) < 1.0 < 2.0 < abs(end - near.mean())
    assert abs(end - far.mean()) < 3.0


def test_the_drift_is_in_every_chart() -> None:
    """Altitude, timeline, nodes and path show the drift orbit; each leg has its two bars of ΔV."""
    instance, plan = (make() for make in MISSION)
    charts = data(page(instance, plan))["figures"]
    assert set(charts) == {*("altitude", "budget", "costs", "gantt", "lanes", "nodes", "planes")}
    for name, figure in charts.items():
        assert len(plotly_graph_objects.Figure(figure).data) >= 2, name
    for name in ("altitude", "gantt", "nodes"):
        assert "drift" in {trace.get("meta", {}).get("phase") for trace in charts[name]["data"]}
    (level,) = (trace for trace in charts["altitude"]["data"] if trace["name"] == "drift orbit")
    start, end, _ = level["x"]
    assert end - start > 40.0
    assert level["y"][0] == level["y"][1]
    planned, burned = charts["costs"]["data"]
    assert planned["y"] == [round(leg.delta_v_m_s, 2) for leg in plan.legs]
    assert burned["y"] == [round(leg.burns_delta_v_m_s, 2) for leg in plan.legs]
    assert planned["y"][1] != burned["y"][1]


def test_nodes_show_what_is_near_the_chaser() -> None:
    """The chart begins at the bodies that are visited; the far one is drawn, outside of it."""
    instance, plan = (make() for make in MISSION)
    figure = figures.nodes(instance, plan, tracks(instance, plan))
    low, high = figure["layout"]["yaxis"]["range"]
    assert high - low < 20.0
    names = {trace["name"]: trace for trace in figure["data"]}
    assert min(names["not visited"]["y"][:-1]) > high
    assert low < min(names["drift orbit"]["y"][:-1]) < max(names["drift orbit"]["y"][:-1]) < high


def test_tables_and_words_are_those_of_a_long_mission() -> None:
    """Legs have a kind, days instead of hours, planned ΔV and burns; nothing says planes stay."""
    instance, plan = (make() for make in MISSION)
    text = page(instance, plan)
    rows = re.findall(r'(?s)<tr data-leg="\d+"[^>]*>(.*?)</tr>', text)
    for row, leg in zip(rows, plan.legs, strict=True):
        cells = re.findall(r"<td[^>]*>(.*?)</td>", row)
        assert cells[3] == leg.kind
        assert cells[4] == f"{(leg.departure_s - leg.ready_s) / DAY_S:.2f}"
        assert cells[6] == ("—" if leg.kind == "drift" else str(leg.phasing_revolutions))
        assert cells[7:10] == [
            f"{leg.delta_v_m_s:.1f}",
            f"{leg.burns_delta_v_m_s:.1f}",
            f"{(leg.arrival_s - leg.departure_s) / DAY_S:.2f}",
        ]
    said = words(text)
    assert "wait d" in said
    assert "flight d" in said
    assert "circles that drift at the secular rates of J2" in said
    assert "drifts of up to 60 days, planned on a grid of 5 days" in said
    assert "planes stay" not in said
    tiny = adr_opt.generate("tiny", 0)
    short = adr_opt.solve(tiny, "greedy-guarded").plan
    assert short is not None
    said = words(page(tiny, short))
    assert "wait h" in said
    assert "kind" not in said
    assert "nodes" not in data(page(tiny, short))["figures"]


def test_spans_have_the_unit_that_suits_them() -> None:
    """Hours and minutes up to two days, then days."""
    assert lasting(3.5 * 3600.0) == "3:30\u202fh"
    assert lasting(47.0 * 3600.0) == "47:00\u202fh"
    assert lasting(49.9 * DAY_S) == "49.9\u202fd"


@pytest.mark.slow
def test_every_page_says_whether_the_plan_was_flown_refined_or_neither(monkeypatch) -> None:
    """The paragraph has the flight, without boinor too, or what refining came to, or why not."""
    instance, plan = drifting_instance(0.003), drifting_plan(0.003)
    flight = fly_mean(instance, plan)
    for name in ("boinor", "boinor.bodies"):
        monkeypatch.setitem(sys.modules, name, None)
    said = words(page(instance, plan))
    assert f"F{str(flight)[1:]}; not refined." in said
    assert "1 drift planned with" in said
    record = flight.record.replace(how="refined", gravity="j4")
    said = words(page(instance, plan.replace(flown=record)))
    assert "When it was planned, refined in the field j4: 1 short leg planned with" in said
    assert "When it was planned, it was refined in the field j4, and every tank held." in said
    # Once legs are others, what the file says of them is nothing.
    stale = record.replace(legs_sha256="0" * 64)
    said = words(page(instance, plan.replace(flown=stale)))
    assert "; not refined." in said
    assert "every tank held" not in said
    refined = refine(instance, plan, jobs=1)
    assert "Refined in the field j2: 2 legs, as told below." in words(page(instance, plan, refined))
    leg = plan.legs[0]
    broken = with_legs(plan, (leg.replace(burns=leg.burns[:2]), *plan.legs[1:]))
    assert "Neither flown nor refined: leg 1: no burn begins" in words(page(instance, broken))


def test_the_verdict_says_what_was_flown(cli: Cli) -> None:
    """A tick where tanks hold, and on which orbits; an alert where burns break the tank."""
    pytest.importorskip("boinor.bodies")
    instance, plan = (make() for make in MISSION)
    said = words(page(instance, plan))
    assert "✓ Checked against the instance: no violations. Flown in the mean dynamics of J2" in said
    assert "eccentric" not in said.partition("Flown in the mean dynamics")[2][:300]
    said = words(page(drifting_instance(0.003), drifting_plan(0.003)))
    assert "✓" in said
    assert "the tanks are judged by burns that are aimed at the true ones" in said
    assert "every tank holds" in said
    tight, of = with_a_tight_tank()
    text = page(tight, of)
    alert = text.partition('role="alert"')[2].partition("</section>")[0]
    assert "When flown this plan breaks 1 tank" in alert
    assert "closed form" in alert
    Path("my.json").write_text(tight.to_json(), encoding="utf-8")
    of.save("plan.json")
    outcome = cli("report", "my.json", "plan.json", "--out", "mission.html")
    assert outcome.status == 1
    assert "when flown tank 1 (legs 1 to 2) of" in outcome.err


@pytest.mark.slow
def test_a_refined_plan_is_judged_by_its_refined_flight(cli: Cli) -> None:
    """A tank that breaks in mean motion and holds refined is not said to break, nor left unflown.

    Where the refined one breaks, or lacks a leg, that heads the page, and nothing else.
    """
    tight, of = with_a_tight_tank()
    assert adr_opt.fly.flight.fly(tight, of).broken_tanks
    refined = adr_opt.refine(tight, of)
    assert all(tank.holds for tank in tanks_of(tight, refined))
    text = page(tight, of, refined)
    said = words(text)
    assert 'role="alert"' not in text
    assert "✓ Checked against the instance: no violations. Refined and flown in" in said
    assert "every tank holds" in said
    assert "breaks" not in said
    assert "not flown" not in said
    flown = words(page(tight, of, refined, flight=adr_opt.fly.flight.fly(tight, of)))
    assert "The plan, flown" in flown
    assert "breaks" not in flown
    tight.save("my.json")
    of.save("plan.json")
    refined.save("refined.json")
    call = ("report", "my.json", "plan.json", "--refined", "refined.json", "--out", "m.html")
    outcome = cli(*call, "--json")
    assert outcome.status == 0, outcome
    assert all(tank["holds"] for tank in json.loads(outcome.out)["tanks"])
    assert "tank" not in outcome.err
    lacking = refined.replace(
        status="incomplete", legs=refined.legs[:1], missing=(Missing(leg=2, reason="interrupted"),)
    )
    broken = words(page(tight, of, lacking))
    assert "The refined plan does not hold" in broken
    assert "When flown this plan breaks" not in broken


@pytest.mark.slow
def test_a_refined_plan_on_eccentric_orbits_is_flown_on_the_true_ones() -> None:
    """Its page does not say that nobody has flown it there, as that of the plan alone does."""
    instance, plan = drifting_instance(0.003), drifting_plan(0.003)
    refined = adr_opt.refine(instance, plan)
    assert refined.missing == ()
    said = words(page(instance, plan, refined))
    assert "not flown on the true ones" not in said
    assert "Refined and flown in numerically integrated motion" in said
    assert (
        "Targets on eccentric orbits are met there. Orbits, map, timeline and ΔV left show" in said
    )
    assert f"; refined {refined.flown_delta_v_m_s:.0f} " in said.replace("\u202f", "")


def test_segments_and_tracks_fill_the_mission() -> None:
    """Phases read off the plan are those that are flown, one after the other, without gaps."""
    instance, plan = (make() for make in MISSION)
    cut = plot.segments(instance, plan)
    for before, after in pairwise(cut):
        assert after.start_s == pytest.approx(before.end_s, abs=1e-3)
    sampled = tracks(instance, plan)
    assert [(t.leg, t.phase) for t in sampled] == [(s.leg, s.phase) for s in cut]
    for track in sampled:
        assert len(track.around_m) <= 130
        if track.phase in ("wait", "service", "drift"):
            assert len(track.times_s) == 2


def test_the_budget_falls_to_what_the_plan_states() -> None:
    """Burns of a drift take their shares of its planned ΔV, so that nothing is ever given back."""
    instance, plan = (make() for make in MISSION)
    course = budgets(instance, plan)[instance.chaser.name]
    assert all(after <= before for before, after in pairwise(course.left_m_s))
    for number, leg in enumerate(plan.legs, start=1):
        last = max(at for at, of_leg in enumerate(course.legs) if of_leg == number)
        assert course.left_m_s[last] == pytest.approx(leg.delta_v_left_m_s, abs=1e-3)


@pytest.mark.parametrize("name", ["nodes", "leg_delta_v", "altitude", "delta_v_left", "gantt"])
def test_plots_draw_a_drift(name: str) -> None:
    """Each adds to the axis, labels it and returns it."""
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    from matplotlib import pyplot

    instance, plan = (make() for make in MISSION)
    _, ax = pyplot.subplots()
    count = len(ax.get_children())
    assert getattr(plot, name)(ax, instance, plan) is ax
    assert len(ax.get_children()) > count
    assert ax.get_xlabel()
    assert ax.get_ylabel()
    if name == "nodes":
        titles = {line.get_label(): line for line in ax.lines}
        assert {"visited", "not visited", "drift orbit", "service"} <= set(titles)
        assert titles["drift orbit"].get_linewidth() > 2.0 * titles["visited"].get_linewidth()
        other = plot.nodes(pyplot.subplots()[1], instance)
        assert {line.get_label() for line in other.lines} >= {"target"}
    pyplot.close("all")
    with pytest.raises(adr_opt.InputError, match="belongs to the instance"):
        getattr(plot, name)(ax, adr_opt.generate("tiny", 0), plan)


@pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
@pytest.mark.slow
@pytest.mark.parametrize("width", [1280, 390])
def test_in_a_browser(tmp_path: Path, width: int) -> None:
    """At desk and at phone width: no error, no sideways scrolling, the chart of nodes among all.

    A leg that is chosen narrows the times of the nodes too.
    """
    instance, plan = (make() for make in MISSION)
    write_report(instance, plan, tmp_path / "mission.html")
    with browser.Browser(tmp_path / "profile", width=width) as tab:
        tab.open_report(tmp_path / "mission.html")
        assert tab.evaluate("document.querySelectorAll('.chart.js-plotly-plot').length") == 10
        tab.evaluate("document.querySelector('tr[data-leg=\"1\"]').click()")
        reach = "document.getElementById('nodes').layout.xaxis.range"
        tab.wait_for(f"{reach}[1] < 10")
        start, end = tab.evaluate(reach)
        assert start < plan.legs[0].ready_s / DAY_S < plan.legs[0].end_s / DAY_S < end
