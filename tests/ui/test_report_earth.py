"""The turning Earth of the report, its pictures for slides, and when the page is painted."""

from __future__ import annotations

import json
import math
import time
import zipfile
from dataclasses import replace
from itertools import accumulate, pairwise
from pathlib import Path

import browser
import numpy as np
import pytest
from launched import campaign, planned

from adr_opt.plan.plan import Plan
from adr_opt.problem.frame import Frame
from adr_opt.problem.instance import Instance

pytest.importorskip("plotly.graph_objects")

from adr_opt.problem.sun import greenwich
from adr_opt.ui.report import page
from adr_opt.ui.report.assets import asset
from adr_opt.ui.report.facts import facts
from adr_opt.ui.report.sections import headline

DAY_S = 86400.0

COASTS = {
    "Lisbon": (-9.2, 38.7),
    "Cape Horn": (-67.3, -55.9),
    "Cape Agulhas": (20.0, -34.8),
    "Darwin": (130.8, -12.4),
    "Reykjavik": (-21.9, 64.1),
    "Key West": (-81.8, 24.6),
    "Tokyo": (139.8, 35.4),
    "Baku": (49.9, 40.4),
}
"""Longitude and latitude of places by the sea, the Caspian one among them [°]."""

INLAND = {
    "Novosibirsk": (82.9, 55.0),
    "Brasilia": (-47.9, -15.8),
    "Atlantic": (-40.0, 30.0),
    "Point Nemo": (-123.4, -48.9),
    "N'Djamena": (15.0, 12.1),
    "South Pole": (0.0, -89.0),
}
"""Places far from any coast."""

SEAS = ("Atlantic", "Point Nemo")


def coast() -> list[list[tuple[float, float]]]:
    """The lines of the file: longitude and latitude [°]."""
    packed = json.loads(asset("coast/coastline.json"))
    return [
        [
            (x / packed["units"], y / packed["units"])
            for x, y in zip(accumulate(line[0::2]), accumulate(line[1::2]), strict=True)
        ]
        for line in packed["lines"]
    ]


def away_deg(place: tuple[float, float]) -> float:
    """How far the nearest point of a coast is, along the ground [°]."""
    x, y = np.radians(np.array([point for line in coast() for point in line])).T
    to_x, to_y = np.radians(place)
    cosine = np.sin(y) * np.sin(to_y) + np.cos(y) * np.cos(to_y) * np.cos(x - to_x)
    return float(np.degrees(np.arccos(cosine.max())))


def test_coasts_are_where_they_are() -> None:
    """Ports lie at the lines, and deserts and oceans do not, so no axis is turned or cut off."""
    for name, place in COASTS.items():
        assert away_deg(place) < 1.5, name
    for name, place in INLAND.items():
        assert away_deg(place) > 5.0, name


def test_lines_stay_on_the_map() -> None:
    """Each coast is closed or ends at the antimeridian, and none runs along that or across it."""
    lines = coast()
    assert len(lines) > 120
    for line in lines:
        (first_x, _), (last_x, _) = line[0], line[-1]
        assert line[0] == line[-1] or abs(first_x) == abs(last_x) == 180.0
        for (x, y), (to_x, to_y) in pairwise(line):
            assert abs(x) <= 180.0
            assert abs(y) <= 90.0
            assert (x, y) != (to_x, to_y)
            assert abs(to_x - x) < 30.0
            assert not abs(x) == abs(to_x) == 180.0


def test_the_coastline_is_small_and_says_where_it_comes_from() -> None:
    """A page gets less than 40 kB of it; source and licence stand beside it."""
    assert len(asset("coast/coastline.json")) < 40e3
    said = asset("coast/README.md")
    assert "Natural Earth" in said
    assert "public domain" in said


def test_longitudes_are_those_of_the_frame() -> None:
    """The page says from where they count, which is the frame that the instance names, if any."""
    instance, plan = campaign(), planned()
    assert "from the equinox of date" in page(instance, plan)
    named = instance.replace(frame=Frame(name="GCRF"))
    of = plan.replace(instance=plan.instance.replace(sha256=named.sha256))
    text = page(named, of)
    assert "elements in GCRF" in text
    assert "equinox of date" not in text


def test_nothing_is_said_of_stations_where_there_are_none() -> None:
    """No tile, column, heading or note on refuelling for a campaign that has no station."""
    instance, plan = campaign(), planned()
    assert instance.stations == ()
    text = page(instance, plan)
    for words in (
        "refuellings",
        "Station traffic",
        "every refuelling",
        "or refuelling",
        "station,",
    ):
        assert words not in text.partition('<script type="application/json"')[0], words
    assert "<h2>Chasers</h2>" in text


def test_figures_of_the_headline_are_grouped() -> None:
    """Thousands stand apart, and a duration of years has one decimal."""
    found = replace(facts(campaign(), planned()), used_s=1453.57 * DAY_S, visits=12345)
    text = headline(found)
    assert ">1\u202f453.6<" in text
    assert ">12\u202f345<" in text


with_browser = pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")


@with_browser
@pytest.mark.parametrize("width", [1400, 390])
def test_tiles_hold_their_figures(tmp_path: Path, width: int) -> None:
    """Eight tiles with the largest figures that a mission has, in one row or in two columns."""
    known = facts(campaign(), planned())
    large = replace(
        known,
        visits=1900,
        targets=1900,
        prize=123456.78,
        total_prize=234567.89,
        stations=3,
        refuellings=1234,
        used_s=14536.57 * DAY_S,
        delta_v_m_s=123456.0,
        upper_bound=234567.89,
        gap=0.4736,
    )
    (tmp_path / "page.html").write_text(page(campaign(), planned()), encoding="utf-8")
    with browser.Browser(tmp_path / "profile", width=width) as tab:
        tab.open(tmp_path / "page.html")
        tab.wait_for("document.querySelectorAll('.headline b').length")
        tab.evaluate(
            f"document.querySelector('.headline').innerHTML = {json.dumps(headline(large))}"
        )
        over = tab.evaluate(
            "[...document.querySelectorAll('.headline b')].filter((figure) => {"
            " const range = document.createRange(); range.selectNodeContents(figure);"
            " const tile = figure.closest('div').getBoundingClientRect();"
            " const [text, ...more] = range.getClientRects();"
            " return more.length || text.right > tile.right - 4; })"
            ".map((figure) => figure.textContent)"
        )
        assert over == []
        assert tab.evaluate("document.querySelectorAll('.headline b').length") == 8


def long_mission() -> tuple[Instance, Plan]:
    """The campaign with four years, of which the plan takes what it took."""
    instance = campaign().with_limits(duration_s=1461.0 * DAY_S)
    plan = planned()
    return instance, plan.replace(instance=plan.instance.replace(sha256=instance.sha256))


CHART = "document.getElementById('{}').data.find(({{ name }}) => name === 'coastlines')"
GLOBE = "document.getElementById('orbits')"
PIXEL = f"""(() => {{
  const canvas = {GLOBE}.querySelector("canvas");
  const by = canvas.width / {GLOBE}.clientWidth;
  const [x, y] = {GLOBE}.seen.at(...%s);
  return [...canvas.getContext("2d").getImageData(x * by, y * by, 1, 1).data].slice(0, 3);
}})()"""


@with_browser
@pytest.mark.slow
def test_the_earth_turns_and_is_painted_early(tmp_path: Path) -> None:
    """Coasts turn with Greenwich, tiles come before charts, and pictures come as one archive."""
    instance, plan = long_mission()
    (tmp_path / "page.html").write_text(page(instance, plan), encoding="utf-8")
    with browser.Browser(tmp_path / "profile") as tab:
        tab.open_report(tmp_path / "page.html")
        painted = tab.evaluate(
            "performance.getEntriesByName('first-contentful-paint')[0].startTime"
        )
        assert painted <= tab.evaluate("Number(document.documentElement.dataset.loading) + 1")
        assert not [said for _, said in tab.complaints if "willReadFrequently" in said]

        # Four years are played within minutes, a leg slower, and what the reader chooses stays.
        speed = "document.getElementById('speed').value"
        choose = (
            "((name, value) => {{ const list = document.getElementById(name); list.value = value;"
            " list.dispatchEvent(new Event('change')); }})('{}', '{}')"
        )
        assert tab.evaluate(speed) == "1000000"
        tab.evaluate(choose.format("leg", 2))
        assert int(tab.evaluate(speed)) < 1000000
        tab.evaluate(choose.format("speed", 86400))
        tab.evaluate(choose.format("leg", 0))
        assert tab.evaluate(speed) == "86400"

        # The map has the coasts as they are, the globe turned to the time of the slider.
        (x, y), *_ = coast()[0]
        assert tab.evaluate(f"(({{ x, y }}) => [x[0], y[0]])({CHART.format('ground')})") == [x, y]
        angle, rate = greenwich(instance)
        met = set()
        for time_s in (0.0, 40.3 * DAY_S, 80.7 * DAY_S):
            tab.evaluate(
                f"document.getElementById('time').value = {time_s};"
                "document.getElementById('time').dispatchEvent(new Event('input'))"
            )
            now = tab.evaluate("Number(document.getElementById('time').value)")
            eye = tab.wait_for(f"{GLOBE}.time === {now} && {GLOBE}.seen.eye")
            for name, (longitude, latitude) in INLAND.items():
                north, east = math.radians(latitude), math.radians(longitude) + angle + rate * now
                up = np.array([math.cos(east), math.sin(east), math.tan(north)]) * math.cos(north)
                if up @ eye > 0.3:
                    _, green, blue = tab.evaluate(PIXEL % (6378137.0 * up).tolist())
                    assert (green > blue) == (name not in SEAS), name
                    met.add(name)
        assert set(SEAS) & met
        assert met - set(SEAS)

        # It is filmed as it is played, and the film is a file.
        tab.call("Page.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
        tab.evaluate("document.getElementById('film').click()")
        tab.wait_for(f"{GLOBE}.time > 86400")
        tab.evaluate("document.getElementById('film').click()")
        while not (found := list(tmp_path.glob("*-film.webm"))):
            time.sleep(0.1)
        assert found[0].read_bytes()[:4] == bytes.fromhex("1a45dfa3")
        tab.evaluate("document.getElementById('pictures').click()")
        while not (found := list(tmp_path.glob("*-pictures.zip"))):
            assert [said for level, said in tab.complaints if level == "error"] == []
            time.sleep(0.1)
        charts = tab.evaluate(
            "[...document.querySelectorAll('.chart')].filter(({ id, data }) =>"
            " id === 'orbits' || data?.length)"
            ".map(({ id }) => id)"
        )
    with zipfile.ZipFile(found[0]) as archive:
        assert archive.testzip() is None
        assert [name[3:-4] for name in archive.namelist()] == charts
        for name in archive.namelist():
            content = archive.read(name)
            assert content[:8] == b"\x89PNG\r\n\x1a\n"
            assert int.from_bytes(content[16:20], "big") == 1920
