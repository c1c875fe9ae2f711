"""The report and the pictures of a campaign: lanes of chasers, and stays at stations."""

from __future__ import annotations

import json
import re
from itertools import pairwise
from pathlib import Path

import browser
import pytest
from conftest import Cli
from two_chasers import HOME, OWN, campaign, planned

import adr_opt
from adr_opt.plan.palette import CHASERS, chaser_colours
from adr_opt.plan.phases import COLOURS
from adr_opt.plan.plan import Plan
from adr_opt.problem.chasers import AtStation
from adr_opt.problem.instance import Instance
from adr_opt.ui import plot
from adr_opt.ui.plot.budget import budgets
from adr_opt.ui.plot.gantt import segments
from adr_opt.ui.plot.strands import tracks
from adr_opt.ui.plot.traffic import also_there, stays, traffic_chart

pytest.importorskip("plotly.graph_objects")

from adr_opt.ui.report import figures, page
from adr_opt.ui.report.facts import facts

DAY_S = 86400.0


@pytest.fixture(scope="module", params=["two-body", "j2"])
def mission(request: pytest.FixtureRequest) -> tuple[Instance, Plan]:
    return campaign(request.param), planned(request.param)


def test_refuellings_are_counted_over_time(mission: tuple[Instance, Plan]) -> None:
    """The line of a station rises by one at the end of each refuelling there, of any chaser."""
    instance, plan = mission
    ends = sorted(leg.end_s / DAY_S for leg in plan.legs if leg.destination == "station")
    (line,) = traffic_chart(instance, plan).series
    assert list(line.x) == pytest.approx([0.0, *ends])
    assert list(line.y) == list(range(len(ends) + 1))


def test_each_chaser_has_a_lane(mission: tuple[Instance, Plan]) -> None:
    """The bars of a lane are the phases of its chaser, one after the other without overlap."""
    instance, plan = mission
    figure = figures.lanes(instance, plan)
    assert figure["layout"]["yaxis"]["ticktext"] == [HOME, OWN, "station"]
    bars: dict[float, list[tuple[float, float, int]]] = {}
    for trace in figure["data"]:
        if "meta" in trace:
            columns = (trace["y"], trace["base"], trace["x"], trace["customdata"])
            for lane, start, length, leg in zip(*columns, strict=True):
                bars.setdefault(lane, []).append((start, start + length, leg))
    assert set(bars) == {1, 2}
    assert {leg for _, _, leg in bars[1]} == {1, 2, 3}
    assert {leg for _, _, leg in bars[2]} == {4, 5, 6, 7}
    for lane in bars.values():
        for (_, end, _), (start, _, _) in pairwise(sorted(lane)):
            assert start >= end - 1e-5
    total = sum(end - start for lane in bars.values() for start, end, _ in lane)
    found = sum(segment.duration_s for segment in segments(instance, plan))
    assert total == pytest.approx(found / DAY_S, abs=1e-4)


def test_station_traffic_is_that_of_the_legs(mission: tuple[Instance, Plan]) -> None:
    """A stay begins with docking, or the start, and ends with the first burn of the next leg."""
    instance, plan = mission
    home, own = stays(instance, plan)
    legs = plan.legs
    assert (home.chaser, home.leg, home.since_s, home.refuelled_s) == (HOME, 1, 0.0, None)
    assert home.until_s == legs[0].burns[0].time_s
    assert (own.chaser, own.leg, own.refuelled_s) == (OWN, 5, legs[4].end_s)
    assert (own.since_s, own.until_s) == (legs[4].burns[-1].time_s, legs[5].burns[0].time_s)
    assert also_there(home, (home, own)) == ()


def test_chasers_that_meet_at_a_station_are_told() -> None:
    """Two chasers that wait at the same station before their first legs are there together."""
    instance = campaign()
    start = AtStation(station="station")
    second = instance.chasers[1].replace(start=start, available_s=(600.0, None))
    instance = instance.replace(chasers=(instance.chasers[0], second))
    plan = adr_opt.solve(instance, "greedy").plan
    assert plan is not None
    found = stays(instance, plan)
    for stay in found[:2]:
        assert also_there(stay, found) == ({HOME, OWN}.difference({stay.chaser}).pop(),)


def test_every_chaser_has_its_budget(mission: tuple[Instance, Plan]) -> None:
    """ΔV left begins with the chaser's own tank, and ends with what its last leg leaves."""
    instance, plan = mission
    found = budgets(instance, plan)
    for chaser, route in zip(instance.chasers, plan.routes, strict=True):
        course = found[chaser.name]
        assert course.left_m_s[0] == chaser.tank.delta_v_m_s
        assert course.left_m_s[-1] == pytest.approx(route.legs[-1].delta_v_left_m_s)
        assert sum(course.refuelled) == (chaser.name == OWN)
    told = facts(instance, plan)
    assert (told.budgets_m_s, told.chasers, told.flying) == (1300.0, 2, 2)
    assert told.used_s == max(leg.end_s for leg in plan.legs)


def test_the_rest_is_coloured_by_chaser(mission: tuple[Instance, Plan]) -> None:
    """Arcs are in the colour of the chaser that flies them; none of these is that of a phase."""
    instance, plan = mission
    colours, flown = chaser_colours(instance), tracks(instance, plan)
    assert not set(CHASERS) & set(COLOURS.values())
    charts = [figures.altitude(instance, plan, flown)]
    if instance.dynamics == "j2":
        charts.append(figures.nodes(instance, plan, flown))
    for chart in charts:
        arcs = [trace for trace in chart["data"] if trace.get("meta", {}).get("titled")]
        assert {trace["name"] for trace in arcs} == {HOME, OWN}
        for trace in arcs:
            legs = {1, 2, 3} if trace["name"] == HOME else {4, 5, 6, 7}
            assert set(trace["customdata"]) <= legs
            assert trace["line"]["color"] == colours[trace["name"]]
        legend = [trace["name"] for trace in chart["data"] if trace.get("showlegend") is True]
        assert legend == [HOME, OWN]
    ways = [trace for trace in figures.planes(instance, plan)["data"] if trace["mode"] == "lines"]
    assert [(way["name"], way["customdata"]) for way in ways] == [
        (HOME, [0, 1, 2, 3]),
        (OWN, [0, 4, 5, 6, 7]),
    ]


def test_one_chaser_has_no_section_of_its_own() -> None:
    """Where there is one chaser, the page has its lane and no traffic, and arcs keep phases."""
    instance = adr_opt.generate("tiny", 0)
    plan = adr_opt.solve(instance, "greedy").plan
    assert plan is not None
    text = page(instance, plan)
    assert text.count('id="lanes"') == 1
    assert "Station traffic" not in text
    assert "the chaser’s path" in text
    arcs = figures.altitude(instance, plan, tracks(instance, plan))["data"]
    assert all(trace["line"]["color"] == COLOURS[trace["meta"]["phase"]] for trace in arcs)


def test_the_page_lists_chasers_and_traffic(mission: tuple[Instance, Plan]) -> None:
    """The page has a row for each chaser with its tanks, one for each stay, and names in legs."""
    instance, plan = mission
    refined = adr_opt.refine(instance, plan, freedom="planned")
    text = page(instance, plan, refined)
    chasers = text[text.index('aria-label="Chasers"') : text.index("<h3>Station traffic")]
    rows = re.findall(r"<tr>(.*?)</tr>", chasers)[1:]
    assert len(rows) == 2
    for row, route in zip(rows, plan.routes, strict=True):
        cells = [re.sub("<[^>]*>", "", cell) for cell in re.findall("<td.*?</td>", row)]
        taken = sum(leg.flown_delta_v_m_s for leg in refined.legs if leg.chaser == route.chaser)
        assert cells[0] == route.chaser
        assert cells[2] == "3"
        assert cells[4] == f"{sum(leg.delta_v_m_s for leg in route.legs):.1f}"
        assert cells[5] == f"{taken:.1f}"
        assert cells[7].count("+") == (route.chaser == OWN)
    before = text.partition("<h2>Burns</h2>")[0]  # where each burn has its chaser, too
    assert before.count("<td>kicker</td>") == 4 + 1
    assert f"{OWN} may service 3 targets" in text
    assert "500 or 400 m/s" in text


@pytest.mark.slow
def test_report_of_a_campaign_from_the_command_line(cli: Cli) -> None:
    """`report` writes the page, and names the chaser of a tank that breaks on true orbits."""
    instance, plan = campaign(eccentricity=0.02), planned(eccentricity=0.02)
    Path("my.json").write_text(instance.to_json(), encoding="utf-8")
    plan.save("plan.json")
    outcome = cli("report", "my.json", "plan.json", "--out", "page.html", "--json")
    assert outcome.status == 1
    broken = [tank for tank in json.loads(outcome.out)["tanks"] if not tank["holds"]]
    assert broken
    for tank in broken:
        assert f"tank {tank['tank']} of {tank['chaser']!r}" in outcome.err


def test_pictures_have_a_line_for_each_chaser(mission: tuple[Instance, Plan]) -> None:
    """Budgets and planes are drawn with a line for each, the timeline with a name."""
    pyplot = pytest.importorskip("matplotlib.pyplot")
    instance, plan = mission
    for draw in (plot.delta_v_left, plot.planes):
        figure, ax = pyplot.subplots()
        draw(ax, instance, plan)
        said = [text for text in ax.get_legend_handles_labels()[1] if HOME in text or OWN in text]
        assert len(said) == 2
        pyplot.close(figure)
    figure, ax = pyplot.subplots()
    plot.gantt(ax, instance, plan)
    rows = [label.get_text() for label in ax.get_yticklabels()]
    assert [row.partition(":")[0] for row in rows if ":" in row] == [HOME, OWN]
    plot.altitude(ax, instance, plan)
    pyplot.close(figure)


@pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
@pytest.mark.parametrize(
    ("width", "dark"), [pytest.param(1280, False, marks=pytest.mark.slow), (390, True)]
)
@pytest.mark.slow
def test_in_a_browser(tmp_path: Path, width: int, dark: bool) -> None:
    """At desk and at phone width: no error, no sideways scrolling; a phase can be switched off."""
    (tmp_path / "page.html").write_text(page(campaign("j2"), planned("j2")), encoding="utf-8")
    with browser.Browser(tmp_path / "profile", width=width, dark=dark) as tab:
        tab.open_report(tmp_path / "page.html")
        assert tab.evaluate("document.querySelectorAll('.chart.js-plotly-plot').length") == 11
        hidden = "document.getElementById('lanes').data.filter((t) => t.visible === false).length"
        tab.evaluate("document.querySelector('button[data-phase=\"service\"]').click()")
        tab.wait_for(f"{hidden} === 1")
        tab.evaluate("document.querySelector('tr[data-leg=\"6\"]').click()")
        leg = planned("j2").legs[5]
        tab.wait_for("document.getElementById('lanes').layout.xaxis.range[0] > 0")
        start, end = tab.evaluate("document.getElementById('lanes').layout.xaxis.range")
        assert start < leg.ready_s / DAY_S < leg.end_s / DAY_S < end
