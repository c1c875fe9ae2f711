"""The mission report: one page that works offline."""

from __future__ import annotations

import importlib.util
import json
import re
import sys
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path

import browser
import pytest
from conftest import Cli
from plans import solved, with_legs
from report_data import data

import adr_opt
from adr_opt.fly.flight import fly
from adr_opt.fly.flight.mean_flight import fly_mean
from adr_opt.plan.palette import REASON_TITLES, REASONS
from adr_opt.plan.plan import Plan, Unvisited
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import KeepOutZone
from adr_opt.ui import plot
from adr_opt.ui.plot.strands import tracks

plotly_graph_objects = pytest.importorskip("plotly.graph_objects")

from adr_opt.ui.report import figures, page, write_report  # noqa: E402
from adr_opt.ui.report.facts import facts  # noqa: E402
from adr_opt.ui.report.motion import MOST_RINGS  # noqa: E402
from adr_opt.ui.report.space import leg_options  # noqa: E402

ROOT = Path(__file__).parents[2]
EVIL = (
    "</script><script>document.title='evil'</script>",
    "<img src=x onerror=\"document.title='evil'\">",
    '<a href="https://evil.example/">click</a>',
    "${title} %{y} &amp; \u2028 \u202e " + "long " * 40,
)


def replaced_names(instance: Instance) -> Instance:
    """The instance with hostile names."""
    targets = tuple(
        target.replace(name=EVIL[at]) if at < len(EVIL) else target
        for at, target in enumerate(instance.targets)
    )
    return instance.replace(name="<b>mission</b>", targets=targets)


@pytest.fixture(scope="module")
def mission() -> tuple[Instance, Plan]:
    """The 50 targets of a nominal instance with its best-known plan."""
    return (
        adr_opt.load(ROOT / "instances/nominal/nominal-000.json"),
        adr_opt.load_plan(ROOT / "instances/best-known/nominal-000.json"),
    )


@pytest.fixture(scope="module")
def hostile() -> tuple[Instance, Plan]:
    """Hostile names, all of them visited, a zone, a note, and prizes that differ."""
    zone = KeepOutZone(min_altitude_m=900e3, max_altitude_m=910e3, start_s=0.0, end_s=9e4)
    instance = replaced_names(adr_opt.generate("tiny", 0)).replace(keep_out_zones=(zone,))
    first = instance.targets[0].replace(prize=2.5)
    instance = instance.replace(targets=(first, *instance.targets[1:]))
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    return instance, plan.replace(notes=("<i>note</i>",))


class Outline(HTMLParser):
    """Tags, addresses and text of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.addresses: list[str] = []
        self.handlers: list[str] = []
        self.words: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note an element and what it leads to."""
        self.tags.append(tag)
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href")]
        self.handlers += [name for name, _ in attrs if name.startswith("on")]

    def handle_data(self, data: str) -> None:
        """Note text."""
        self.words.append(data)

    @property
    def text(self) -> str:
        """All text with single spaces."""
        return " ".join(" ".join(self.words).split())


def outline(text: str) -> Outline:
    """The outline of a page, without its scripts and its style."""
    return Outline(re.sub(r"(?s)<(script|style)\b[^>]*>.*?</\1>", "", text))


def test_a_page_of_50_targets_is_under_6_mb(mission, tmp_path: Path) -> None:
    """The reach of the report: 50 targets in less than 6 MB, and the size stated is true."""
    written = write_report(*mission, tmp_path / "mission.html")
    assert written.size_bytes == (tmp_path / "mission.html").stat().st_size
    assert written.size_bytes < 6e6
    assert written.violations == ()
    assert written.trouble is None


def test_the_same_mission_gives_the_same_page(mission) -> None:
    """The page holds no time of writing and nothing else that changes."""
    assert page(*mission) == page(*mission)


def test_the_page_asks_for_nothing(mission) -> None:
    """No address leads out of the page, and its policy forbids every request."""
    text = page(*mission)
    assert outline(text).addresses == ["data:,"]
    assert "default-src 'none'" in text
    assert "'unsafe-eval'" not in text
    assert "connect-src" not in text


def test_headline_figures(mission) -> None:
    """Visits, bound, gap, ΔV, refuellings and duration are those of the plan."""
    instance, plan = mission
    found = facts(instance, plan)
    visits = set(plan.destinations) - {instance.stations[0].name}
    assert (found.visits, found.targets) == (len(visits), 50)
    assert found.delta_v_m_s == pytest.approx(sum(leg.delta_v_m_s for leg in plan.legs))
    assert found.refuellings == len(plan.legs) - len(visits)
    assert found.budgets_m_s == 3000.0 * (found.refuellings + 1)
    assert found.used_s == plan.legs[-1].end_s
    text = outline(page(instance, plan)).text
    assert f"targets visited {len(visits)} of 50" in text
    assert f"upper bound {plan.upper_bound:g} proven" in text
    assert f"refuellings {found.refuellings} at the station" in text
    assert "no violations" in text


def test_every_leg_and_every_unvisited_target_is_in_a_table(mission) -> None:
    """The table of legs has each leg with its ΔV; what is left out has its reason."""
    instance, plan = mission
    text = page(instance, plan)
    rows = re.findall(r'(?s)<tr data-leg="(\d+)"[^>]*>(.*?)</tr>', text)
    assert [int(number) for number, _ in rows] == list(range(1, len(plan.legs) + 1))
    for (_, row), leg in zip(rows, plan.legs, strict=True):
        assert f"{leg.origin} → <b>{leg.destination}</b>" in row
        assert f">{leg.delta_v_m_s:.1f}<" in row
        assert ("refuels" in row) == (leg.destination == "station")
    words = outline(text).text
    for entry in plan.unvisited:
        assert f"{entry.target} {entry.reason}" in words
    assert "one more leg to it would end too late for the mission" in words


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            {"status": "optimal", "upper_bound": 30.0, "gap": 0.0},
            "Optimal prize, as the plan states",
        ),
        ({"status": "feasible", "upper_bound": 32.0, "gap": 0.0625}, "6.25\u202f%"),
        ({"status": "feasible", "upper_bound": None, "gap": None}, "The plan states no upper"),
    ],
)
def test_bound_and_gap_are_said_in_words(mission, changes: dict, said: str) -> None:
    """The page says what is proven, or that nothing is."""
    instance, plan = mission
    section = page(instance, plan.replace(**changes)).partition("<h2>Bound and gap</h2>")[2]
    assert said in section.partition("</section>")[0]


def test_violations_head_the_page(mission) -> None:
    """Every violation that the check finds stands in an alert before the figures."""
    instance, plan = mission
    leg = plan.legs[4].replace(delta_v_m_s=plan.legs[4].delta_v_m_s - 1.0)
    plan = with_legs(plan, (*plan.legs[:4], leg, *plan.legs[5:]), objective=31.0)
    violations = adr_opt.check(instance, plan)
    assert len(violations) > 2
    text = page(instance, plan)
    alert = text.partition('role="alert"')[2].partition("</section>")[0]
    assert f"{len(violations)} violations" in alert
    assert alert.count("<li>") == len(violations)
    assert text.index('role="alert"') < text.index('class="headline"')
    assert "no violations" not in text


@pytest.fixture(scope="module")
def eccentric() -> tuple[Instance, Plan]:
    """A plan between eccentric orbits that is legal in the model, and breaks a tank in truth."""
    tiny = adr_opt.generate("tiny", 22)
    instance = tiny.replace(
        targets=tuple(
            target.replace(
                orbit=target.orbit.replace(eccentricity=0.03, argument_of_perigee_deg=80.0 * number)
            )
            for number, target in enumerate(tiny.targets)
        )
    ).with_limits(delta_v_m_s=1500.0)
    most = max(legs_by_tank(instance, solved(instance)))
    instance = instance.with_limits(delta_v_m_s=most + 1e-3)
    plan = solved(instance)
    assert adr_opt.check(instance, plan) == ()
    return instance, plan


def legs_by_tank(instance: Instance, plan: Plan) -> list[float]:
    """The ΔV that a plan takes from each tank."""
    tanks = [0.0]
    for leg in plan.legs:
        tanks[-1] += leg.delta_v_m_s
        if leg.destination in instance.station_names:
            tanks.append(0.0)
    return tanks


@pytest.mark.slow
def test_tanks_that_break_head_the_page(eccentric, cli: Cli) -> None:
    """No tick for a plan that breaks a tank on the true orbits: the page and the verb say which."""
    pytest.importorskip("boinor.bodies")
    instance, plan = eccentric
    broken = fly(instance, plan).broken_tanks
    assert broken
    text = page(instance, plan)
    alert = text.partition('role="alert"')[2].partition("</section>")[0]
    assert "legal in the model" in alert
    assert "solve --refine" in alert
    assert "--margin" not in text
    assert [str(tank) for tank in broken] == re.findall(r"<li>(.*?)</li>", alert)
    assert "✓" not in text
    Path("my.json").write_text(instance.to_json(), encoding="utf-8")
    plan.save("plan.json")
    said = cli("report", "my.json", "plan.json", "--out", "mission.html", "--json")
    assert said.status == 1
    tanks = json.loads(said.out)["tanks"]
    assert [tank["tank"] for tank in tanks if not tank["holds"]] == [tank.tank for tank in broken]
    assert f"plan.json: on the true orbits {broken[0]}" in said.err


@pytest.mark.slow
def test_no_tick_without_a_flight_on_the_true_orbits(eccentric, mission, monkeypatch) -> None:
    """Without boinor the page of an eccentric field says what it does not know; circles need none.

    And a plan that holds on the true orbits has its tick.
    """
    instance, plan = eccentric
    roomy = instance.with_limits(delta_v_m_s=9000.0)
    if importlib.util.find_spec("boinor") is not None:
        assert "every tank holds" in outline(page(roomy, solved(roomy))).text
        assert "✓" in page(roomy, solved(roomy))
    monkeypatch.setitem(sys.modules, "boinor.bodies", None)
    text = page(instance, plan)
    assert "✓" not in text
    assert "not flown on the true ones" in text
    record = fly_mean(instance, plan).record.replace(how="refined", gravity="j2", holds=True)
    text = page(instance, plan.replace(flown=record))
    assert "not flown on the true ones" not in text
    assert "it was refined in the field j2 and that every tank" in text
    assert "[astro]" in text
    assert "✓" in page(*mission)


def test_names_in_the_timeline_can_be_told_apart(mission) -> None:
    """Long names that begin alike keep their ends beside the timeline."""
    instance, plan = mission
    names = {
        target.name: f"COSMOS 2251 DEB {34000 + at}" for at, target in enumerate(instance.targets)
    }
    legs = tuple(
        leg.replace(
            origin=names.get(leg.origin, leg.origin),
            destination=names.get(leg.destination, leg.destination),
        )
        for leg in plan.legs
    )
    targets = tuple(target.replace(name=names[target.name]) for target in instance.targets)
    instance = instance.replace(targets=targets)
    reference = plan.instance.replace(sha256=instance.sha256)
    drawn = figures.gantt(instance, with_legs(plan, legs, instance=reference))
    ticks = drawn["layout"]["yaxis"]["ticktext"]
    assert all(len(tick) <= 16 for tick in ticks)
    assert all(tick.endswith(leg.destination[-5:]) for tick, leg in zip(ticks, legs, strict=True))
    assert len(set(ticks)) == len(set(plan.destinations))


def test_a_plan_that_cannot_be_flown_is_reported_all_the_same(mission) -> None:
    """Tables and violations come out even where no path can be drawn, and the page says so."""
    instance, plan = mission
    leg = plan.legs[1].replace(burns=plan.legs[1].burns[::-1])
    text = page(instance, with_legs(plan, (plan.legs[0], leg, *plan.legs[2:])))
    assert "path cannot be drawn: leg 2: the burns are not in time order" in text
    assert 'role="alert"' in text
    strange = plan.legs[1].replace(destination="nobody", burns=())
    text = page(instance, with_legs(plan, (plan.legs[0], strange)))
    assert "&#x27;nobody&#x27; is not a body of the instance" in text


def test_a_plan_without_legs_and_an_instance_without_targets(mission) -> None:
    """Nothing to show is shown as nothing."""
    instance, plan = mission
    empty = with_legs(plan, (), objective=0.0, status="feasible", upper_bound=None, gap=None)
    assert "targets visited 0 of 50" in outline(page(instance, empty)).text
    alone = instance.replace(targets=())
    plan = adr_opt.solve(alone, "greedy-guarded").plan
    assert "targets visited 0 of 0" in outline(page(alone, plan)).text


def test_names_are_text_wherever_they_stand(hostile) -> None:
    """Names with tags, entities and quotes add no tag, no address and no handler to the page."""
    instance, plan = hostile
    harmless = adr_opt.generate("tiny", 0)
    text = page(instance, plan)
    found = outline(text)
    assert set(found.tags) <= set(outline(page(harmless, solved(harmless))).tags)
    assert not {"a", "img"} & set(found.tags)
    assert found.addresses == ["data:,"]
    assert found.handlers == []
    assert EVIL[0] in found.text
    assert text.count("<script") == 3  # data, library, script


def test_names_are_text_in_charts(hostile) -> None:
    """plotly.js reads tags in the texts that it draws, so it is given none but line breaks."""
    content = data(page(*hostile))
    strings: list[str] = []

    def collect(value: object) -> None:
        if isinstance(value, dict):
            for key, item in value.items():
                if key != "ids":  # what a click leads to is compared, and never drawn
                    collect(item)
        elif isinstance(value, list):
            for item in value:
                collect(item)
        elif isinstance(value, str):
            strings.append(value)

    collect(content)
    tags = {tag for text in strings for tag in re.findall(r"<[^>]*>?", text)}
    assert tags <= {"<br>", "<b>", "</b>", "<extra>", "</extra>"}
    assert any("&lt;img" in text for text in strings)


def test_charts_are_valid_plotly_figures(mission, hostile) -> None:
    """Plotly's own schema accepts every chart, the colours that the page adds left aside."""
    for instance, plan in (mission, hostile):
        for name, figure in data(page(instance, plan))["figures"].items():
            made = plotly_graph_objects.Figure(figure)
            assert len(made.data) >= 2, name


def test_charts_show_the_whole_mission(mission) -> None:
    """Bars fill the timeline, the altitude runs from the epoch to the end, each leg arrives."""
    instance, plan = mission
    flown = tracks(instance, plan)
    bars = figures.gantt(instance, plan)["data"]
    total = sum(sum(trace["x"]) for trace in bars)
    assert total == pytest.approx(plan.legs[-1].end_s / 86400.0, abs=1e-3)
    points = [
        (x, y)
        for trace in figures.altitude(instance, plan, flown)["data"]
        for x, y in zip(trace["x"], trace["y"], strict=True)
        if x is not None
    ]
    assert min(x for x, _ in points) == 0.0
    assert max(x for x, _ in points) == pytest.approx(plan.legs[-1].end_s / 86400.0, abs=1e-5)


def test_planes_are_numbered_by_legs(mission) -> None:
    """Each visited target has the number of the leg that leads to it, at its plane."""
    instance, plan = mission
    (numbers,) = (one for one in figures.planes(instance, plan)["data"] if one["name"] == "order")
    orbits = {target.name: target.orbit for target in instance.targets}
    visits = [(n, leg) for n, leg in enumerate(plan.legs, start=1) if leg.destination in orbits]
    assert numbers["text"] == [str(n) for n, _ in visits]
    for (_, leg), inclination in zip(visits, numbers["y"], strict=True):
        assert inclination == pytest.approx(orbits[leg.destination].inclination_deg, abs=1e-4)
    assert len(set(numbers["textposition"])) > 4


def test_planes_show_why_targets_are_left_out(mission) -> None:
    """Each target left out has the mark of its reason, which no other reason has."""
    instance, plan = mission
    reasons = list(REASONS)
    left = tuple(
        Unvisited(target=target.name, reason=reasons[at % len(reasons)])
        for at, target in enumerate(instance.targets)
        if target.name not in plan.destinations
    )
    drawn = figures.planes(instance, plan.replace(unvisited=left))["data"]
    marks = {one["name"]: one for one in drawn if one["name"].startswith("left out, ")}
    wanted = Counter(REASON_TITLES[each.reason] for each in left)
    assert set(marks) == {f"left out, {reason}: {count}" for reason, count in wanted.items()}
    assert len({one["marker"]["symbol"] for one in marks.values()}) == len(marks) > 3
    for title, one in marks.items():
        assert len(one["ids"]) == int(title.rpartition(" ")[2])


def test_legs_in_the_list_keep_their_catalogue_numbers(mission) -> None:
    """Long names are cut in the list of legs, and their numbers are not."""
    _, plan = mission
    legs = tuple(
        leg.replace(
            origin=f"FENGYUN 1C DEBRIS OF 2007 {29000 + at} (2)",
            destination=f"FENGYUN 1C DEBRIS OF 2007 {29001 + at} (2)",
        )
        for at, leg in enumerate(plan.legs)
    )
    options = re.findall(r"<option[^>]*>(.*?)</option>", leg_options(with_legs(plan, legs)))[1:]
    for at, option in enumerate(options):
        assert option.startswith(f"{at + 1}: FENG")
        assert f"{29000 + at} (2) → " in option
        assert option.endswith(f"{29001 + at} (2)")


def test_zones_are_in_the_altitude_chart(hostile) -> None:
    """A zone is a box at its altitudes and times, and has a hover text."""
    instance, plan = hostile
    figure = figures.altitude(instance, plan, tracks(instance, plan))
    (box,) = figure["layout"]["shapes"]
    assert (box["y0"], box["y1"]) == (900.0, 910.0)
    assert box["x1"] == pytest.approx(9e4 / 86400.0)
    assert "keep-out zone 900–910 km" in figure["data"][-1]["hovertemplate"]


with_browser = pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
READY = "document.documentElement?.dataset.ready"
COMPLETE = "document.documentElement?.dataset.complete"


def only_local(requests: list[str]) -> bool:
    """Whether every request is for the file itself or for data inside it."""
    return all(request.startswith(("file:", "data:", "blob:")) for request in requests)


@with_browser
@pytest.mark.parametrize(
    ("width", "dark"), [pytest.param(1280, False, marks=pytest.mark.slow), (390, True)]
)
def test_in_a_browser(mission, tmp_path: Path, width: int, dark: bool) -> None:
    """At desk and at phone width: no error, no request, no sideways scrolling, all charts there."""
    write_report(*mission, tmp_path / "mission.html")
    with browser.Browser(tmp_path / "profile", width=width, dark=dark) as tab:
        tab.open(tmp_path / "mission.html")
        ready = int(tab.wait_for(READY))
        complete = int(tab.wait_for(COMPLETE))
        # for whoever runs this with -s on a quiet machine: two seconds are the reach
        print(f"{width} px: interactive after {ready} ms, orbits drawn after {complete} ms")
        assert [text for level, text in tab.complaints if level == "error"] == []
        assert only_local(tab.requests)
        assert tab.evaluate("document.documentElement.scrollWidth") == width
        assert tab.evaluate("document.querySelectorAll('.chart.js-plotly-plot').length") == 9
        tables = tab.evaluate(
            "[...document.querySelectorAll('.scroll')]"
            ".map((box) => box.getBoundingClientRect().right)"
        )
        assert max(tables) <= width
        reached = tab.evaluate(
            "[...document.querySelectorAll('.scroll')].map((box) => { box.scrollLeft = 1e6;"
            " const last = box.querySelector('th:last-child').getBoundingClientRect();"
            " return last.right - box.getBoundingClientRect().right; })"
        )
        assert max(reached) <= 1.0  # the last column of every table can be scrolled to
        background = tab.evaluate("getComputedStyle(document.body).backgroundColor")
        light = sum(int(part) for part in re.findall(r"\d+", background)[:3]) / 3.0
        assert light < 60.0 if dark else light > 220.0
        sizes = tab.evaluate(
            "[...document.querySelectorAll('p, td, th, dt, dd')]"
            ".map((part) => parseFloat(getComputedStyle(part).fontSize))"
        )
        assert min(sizes) >= 12.0


@with_browser
@pytest.mark.slow
def test_controls(mission, tmp_path: Path) -> None:
    """Choosing a leg narrows the charts of times to it, and a phase can be switched off."""
    instance, plan = mission
    write_report(instance, plan, tmp_path / "mission.html")
    with browser.Browser(tmp_path / "profile") as tab:
        tab.open(tmp_path / "mission.html")
        tab.wait_for(COMPLETE)
        tab.evaluate("document.querySelector('tr[data-leg=\"7\"]').click()")
        leg = plan.legs[6]
        for chart in ("altitude", "budget", "gantt"):
            expression = f"document.getElementById('{chart}').layout.xaxis.range"
            tab.wait_for(f"{expression}[0] > 0")
            start, end = tab.evaluate(expression)
            assert start < leg.ready_s / 86400.0 < leg.end_s / 86400.0 < end
            assert end - start < 1.2 * (leg.end_s - leg.ready_s) / 86400.0
        assert tab.evaluate("document.getElementById('leg').value") == "7"
        tab.evaluate("document.querySelector('button[data-phase=\"service\"]').click()")
        tab.wait_for(
            "document.getElementById('gantt').data.some((trace) => trace.visible === false)"
        )
        assert [text for level, text in tab.complaints if level == "error"] == []


@with_browser
def test_hostile_names_in_a_browser(hostile, tmp_path: Path) -> None:
    """No name of a target becomes a script, an image or a link."""
    write_report(*hostile, tmp_path / "mission.html")
    with browser.Browser(tmp_path / "profile") as tab:
        tab.open(tmp_path / "mission.html")
        tab.wait_for(COMPLETE)
        assert (
            tab.evaluate("document.title")
            == "<b>mission</b> · " + tab.evaluate("document.title").partition(" · ")[2]
        )
        assert tab.evaluate("document.querySelectorAll('main img, main a').length") == 0
        assert [text for level, text in tab.complaints if level == "error"] == []
        assert only_local(tab.requests)


def test_the_examples_of_the_page_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The Python examples of docs/report.md run one after the other as they stand."""
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    text = (ROOT / "docs/report.md").read_text(encoding="utf-8")
    for code in re.findall(r"(?s)```python\n(.*?)```", text):
        exec(code, names)
    assert names["written"].violations == ()
    assert len(names["ax"].lines) > 3


def test_the_page_on_the_report_names_every_plot_and_every_part() -> None:
    """docs/report.md lists exactly the plot functions, and the limit of orbits of the code."""
    text = (ROOT / "docs/report.md").read_text(encoding="utf-8")
    functions = {name for name in plot.__all__ if callable(getattr(plot, name))} - {"Segment"}
    assert set(re.findall(r"`(?:plot\.)?(\w+)\(", text)) - {"page"} <= functions | {"adr_opt"}
    for name in functions:
        assert f"`{name}(" in text or f"`plot.{name}(" in text
    assert f"at most {MOST_RINGS} orbits" in text
