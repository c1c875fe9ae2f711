"""Costs from elsewhere (docs/model.md section 9): in files, on pages and in plots."""

from __future__ import annotations

import json
from pathlib import Path

import browser
import numpy as np
import pytest
from conftest import Cli, refused
from random_rules import given_mission
from toy_roads import as_rows, roads, solved

import adr_opt
from adr_opt.problem.given import COLUMNS, of_rows


@pytest.mark.parametrize("seed", range(6))
def test_files_give_back_what_was_saved(tmp_path: Path, seed: int) -> None:
    """An instance and its connections, saved and loaded, are the same, and so are their plans."""
    pytest.importorskip("pyarrow")
    instance = given_mission(seed)
    instance.save(tmp_path / "my.json")
    again = adr_opt.load(tmp_path / "my.json")
    assert again == instance
    assert again.sha256 == instance.sha256
    assert (tmp_path / "my.json").read_text() == instance.to_json()
    for column in ("origin", "destination", "departure", "arrival", "cost"):
        assert np.array_equal(getattr(again.given, column), getattr(instance.given, column))
    ours, theirs = (adr_opt.solve(one, "greedy-guarded") for one in (instance, again))
    assert ours.sequence == theirs.sequence


def test_what_matrix_writes_can_be_given_back(cli: Cli, tmp_path: Path) -> None:
    """Connections as `.parquet` and matrices as `.nc`, as `matrix` writes them, are read."""
    for package in ("pyarrow", "h5netcdf"):
        pytest.importorskip(package)
    drawn = adr_opt.generate("tiny", 0).with_limits(duration_s=40000.0)
    Path("tiny.json").write_text(drawn.to_json())
    assert cli("matrix", "tiny.json", "--out", "all.parquet", "--quiet").status == 0
    assert cli("matrix", "tiny.json", "--every", 5000, "--out", "some.nc", "--quiet").status == 0
    for file in ("all.parquet", "some.nc"):
        content = json.loads(drawn.to_json())
        content["transfer"]["given"] = {"file": file}
        Path("given.json").write_text(json.dumps(content))
        instance = adr_opt.load("given.json")
        assert instance.transfer.given.sha256 == instance.given.sha256
        assert cli("solve", "given.json", "--time-limit", 5, "--out", "plan.json").status == 0
        assert cli("check", "given.json", "plan.json").status == 0
    sampled = adr_opt.Mission(drawn).timetable.matrices([0.0, 5000.0])
    there = np.isfinite(sampled.delta_v[0]) & ~np.eye(len(drawn.names), dtype=bool)
    i, j = np.argwhere(there)[0]
    leaves, lands, cost = instance.given.of_pair(drawn.names[i], drawn.names[j])
    assert leaves[0] == 0.0
    assert lands[0] == sampled.duration[0, i, j]
    assert cost[0] == sampled.delta_v[0, i, j]
    # What was given can be exported in turn.
    assert cli("matrix", "given.json", "--out", "again.parquet", "--quiet").status == 0
    assert cli("matrix", "given.json", "--at", 0, "--out", "again.nc", "--quiet").status == 0


def test_files_that_are_missing_or_others_are_refused(cli: Cli, tmp_path: Path) -> None:
    """A file that is not there, is another one's, or no such file is one sentence, exit code 2."""
    pa = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    instance, plan = solved()
    instance.save("my.json")
    plan.save("plan.json")
    there = Path("roads.parquet").read_bytes()
    for verb in (
        ("solve", "my.json"),
        ("check", "my.json", "plan.json"),
        ("bound", "my.json", "--method", "lagrangian"),
    ):
        Path("roads.parquet").unlink(missing_ok=True)
        refused(cli(*verb), "roads.parquet: no such file")
        Path("roads.parquet").write_bytes(b"PAR1 nothing of the kind")
        refused(cli(*verb), "roads.parquet: not a Parquet file")
    dearer = as_rows()
    dearer["delta_v_m_s"][0] += 1.0
    adr_opt.Timetable.from_connections(roads(), dearer).instance.save("other.json")
    refused(cli("solve", "my.json"), "roads.parquet: not the connections that my.json names")
    parquet.write_table(pa.table({"origin": ["depot"]}), "roads.parquet")
    refused(cli("solve", "my.json"), "roads.parquet: column destination is missing")
    parquet.write_table(pa.table(as_rows() | {"origin": ["moon"] * 132}), "roads.parquet")
    refused(cli("solve", "my.json"), "roads.parquet: column origin: 'moon' is not a body")
    rows = as_rows() | {"delta_v_m_s": [None, *as_rows()["delta_v_m_s"][1:]]}
    parquet.write_table(pa.table(rows), "roads.parquet")
    refused(
        cli("solve", "my.json"),
        "row 0, 'depot' to 'mill': delta_v_m_s is missing and arrival_s is not",
    )
    parquet.write_table(pa.table(as_rows() | {"exception": [False] * 132}), "roads.parquet")
    refused(cli("solve", "my.json"), "roads.parquet: column exception: limits of exceptions were")
    for content in (there, None):
        if content is None:
            # From another program, with a column more and texts as they are.
            parquet.write_table(pa.table(as_rows() | {"lane": [1] * 132}), "roads.parquet")
        else:
            Path("roads.parquet").write_bytes(content)
        assert cli("check", "my.json", "plan.json").status == 0
    text = Path("my.json").read_text()
    for name in ("../roads.parquet", "roads.csv", "sub/roads.parquet"):
        Path("odd.json").write_text(text.replace("roads.parquet", name))
        refused(cli("solve", "odd.json"), "transfer.given.file")
    Path("no.json").write_text(text.replace("roads.parquet", "roads.nc"))
    Path("roads.nc").write_bytes(b"nothing")
    pytest.importorskip("h5netcdf")
    refused(cli("solve", "no.json"), "roads.nc: not a NetCDF 4 file")


def test_given_costs_have_no_trajectory(cli: Cli, tmp_path: Path) -> None:
    """What would fly a plan refuses it in a sentence, before anything is written."""
    pytest.importorskip("pyarrow")
    instance, plan = solved()
    instance.save("my.json")
    plan.save("plan.json")
    for verb in (
        ("fly", "my.json", "plan.json"),
        ("refine", "my.json", "plan.json", "--out", "x.json"),
        ("solve", "my.json", "--refine", "--out", "x.json"),
        ("export", "my.json", "plan.json", "--out", "x.oem"),
    ):
        refused(cli(*verb), "its plans have no trajectory")
        assert not Path("x.json").exists()
    free = instance.replace(chasers=[instance.chaser.replace(end="anywhere")])
    with pytest.raises(adr_opt.InputError, match="does not follow bodies without an orbit"):
        adr_opt.solve(free, "ppo")


def test_the_page_shows_what_there_is(cli: Cli, tmp_path: Path) -> None:
    """A report has timeline, costs and budget, and neither orbits, altitude nor planes."""
    pytest.importorskip("pyarrow")
    pytest.importorskip("plotly")
    instance, plan = solved()
    instance.save("my.json")
    plan.save("plan.json")
    outcome = cli("report", "my.json", "plan.json", "--out", "my.html")
    assert outcome.status == 0, outcome.err
    text = Path("my.html").read_text()
    found = text.partition('id="mission">')[2].partition("</script>")[0]
    figures = json.loads(found)["figures"]
    assert set(figures) == {"budget", "costs", "gantt", "lanes"}
    assert [trace["name"] for trace in figures["costs"]["data"]] == ["planned"]
    assert "transfer" in {trace["name"] for trace in figures["gantt"]["data"]}
    assert len(figures["budget"]["data"][0]["x"]) == 1 + len(plan.legs) + 1
    for absent in ('id="orbits"', 'id="altitude"', 'id="planes"', "co-elliptic"):
        assert absent not in text.partition("<script>")[0]
    assert "connections given in roads.parquet" in text
    with_orbits = adr_opt.generate("tiny", 0)
    back = with_orbits.with_given(of_rows({name: [] for name in COLUMNS}, with_orbits.names))
    nothing = adr_opt.solve(back, "greedy-guarded").plan
    from adr_opt.ui.report import page

    assert 'id="planes"' in page(back, nothing)


@pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
@pytest.mark.slow
def test_the_page_works_without_orbits(tmp_path: Path) -> None:
    """All charts that there are get drawn, and nothing is complained about."""
    pytest.importorskip("plotly")
    from adr_opt.ui.report import write_report

    write_report(*solved(), tmp_path / "my.html")
    with browser.Browser(tmp_path / "profile") as tab:
        tab.open(tmp_path / "my.html")
        tab.wait_for("document.documentElement?.dataset.complete")
        assert tab.evaluate("document.querySelectorAll('.chart.js-plotly-plot').length") == 3
        assert [text for level, text in tab.complaints if level == "error"] == []


def test_plots_of_time_are_drawn() -> None:
    """The plots that need no orbit show given legs; those that do say what is missing."""
    pyplot = pytest.importorskip("matplotlib.pyplot")
    from adr_opt.ui import plot

    instance, plan = solved()
    _, ax = pyplot.subplots()
    plot.gantt(ax, instance, plan)
    plot.delta_v_left(ax, instance, plan)
    plot.leg_delta_v(ax, instance, plan)
    phases = {segment.phase for segment in plot.segments(instance, plan)}
    assert phases == {"wait", "transfer", "service"}
    for function in (plot.planes, plot.altitude):
        with pytest.raises(adr_opt.InputError, match=r"has no orbit|have no trajectory"):
            function(ax, instance, plan)
    pyplot.close("all")
