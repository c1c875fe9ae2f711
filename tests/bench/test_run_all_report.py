"""What the benchmark makes of its rows: statistics, curves, and the report."""

from __future__ import annotations

import json
import math
import re
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from browser import EXECUTABLE, Browser
from run_all_rows import BENCH, Load, filled, kept, protocol, row
from scipy import stats

import adr_opt

# --- statistics and report ------------------------------------------------------------------------


def test_means_are_over_fields(load: Load) -> None:
    """Iterations are averaged first, and the interval is Student's over the fields."""
    statistics = load("harness.report.statistics")
    means = statistics.field_means({(0, 0, 0): 1.0, (0, 1, 0): 3.0, (1, 0, 0): 4.0, (2, 0, 0): 6.0})
    assert means == {0: 2.0, 1: 4.0, 2: 6.0}
    mean, half = statistics.interval(list(means.values()))
    assert mean == 4.0
    # t(0.975; 2) = 4.302653 and s = 2, from a table
    assert half == pytest.approx(4.302653 * 2.0 / math.sqrt(3.0), rel=1e-6)
    assert math.isnan(statistics.interval([1.0])[1])


def test_pairs_use_common_missions_and_holm(load: Load) -> None:
    """Only missions of both methods count; p-values are Wilcoxon's, adjusted step by step."""
    statistics = load("harness.report.statistics")
    assert statistics.holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    first = {(field, 0, 0): 20.0 + field for field in range(8)}
    second = {(field, 0, 0): 10.0 for field in range(6)} | {(5, 1, 0): 99.0}
    (pair,) = statistics.pairs({"a": first, "b": second})
    assert (pair.fields, pair.better, pair.equal, pair.worse) == (6, 6, 0, 0)
    assert pair.difference == 12.5
    assert pair.p == pytest.approx(2.0 / 2**6)  # all of six ranks on one side
    (same,) = statistics.pairs({"a": first, "b": dict(first)})
    assert (same.equal, same.p) == (8, 1.0)


def test_a_p_value_is_one_that_the_fields_can_give(load: Load) -> None:
    """Of few fields none is given, and none is below what all signs of the differences allow."""
    statistics = load("harness.report.statistics")
    rng = np.random.default_rng(5)
    for size in range(1, 9):
        for _ in range(20):
            differences = rng.integers(-3, 4, size).astype(float)
            left = np.array([d for d in differences if d])
            if not left.size:
                assert statistics.signed_rank(differences) == 1.0
                continue
            ranks = stats.rankdata(np.abs(left))
            sums = [ranks @ signs for signs in product((0, 1), repeat=left.size)]
            positive, total = ranks[left > 0].sum(), ranks.sum()
            tail = min(positive, total - positive)
            wanted = min(1.0, 2.0 * np.mean([each <= tail + 1e-9 for each in sums]))
            assert statistics.signed_rank(differences) == pytest.approx(wanted)
            assert statistics.signed_rank(differences) >= statistics.least_p(left.size)
    rising = {(field, 0, 0): 20.0 + field for field in range(20)}
    for fields, methods, told in ((5, 2, False), (6, 2, True), (7, 4, False), (8, 4, True)):
        values = {
            method: {(field, 0, 0): rising[field, 0, 0] * (1 + method) for field in range(fields)}
            for method in range(methods)
        }
        pairs = statistics.pairs(values)
        assert statistics.least_p(fields, len(pairs)) <= 0.05 or not told
        assert {pair.p is not None for pair in pairs} == {told}
    long = rng.normal(0.3, 1.0, 40)
    assert statistics.signed_rank(long) == pytest.approx(
        stats.wilcoxon(long, method="exact").pvalue
    )


def test_times_stand_beside_visits(load: Load, tmp_path: Path) -> None:
    """No page, legend or cell compares times without the visits; few fields give no p-value."""
    path = filled(load, tmp_path, protocol(load, "greedy", "mcts", "beam", fields=3, zones=0))
    results = load("harness.report.model").read(path)
    (section,) = results.sections
    labels = results.labels
    for trace in load("harness.report.charts").seconds(section, labels)["data"]:
        assert re.search(r", \d+\.\d\d visits$", trace["name"])
    page = load("harness.report.page").page(results)
    for line in re.findall(r"<tr>.*?</tr>", page):
        assert "10<sup>" not in line or "visits against" in line
    assert "visits against 15–18" in page
    assert page.count("n = 3: not below 0.25") == 3
    assert "with fewer than 7 fields" in page


def test_methods_lie_on_curves_of_time_and_quality(load: Load, tmp_path: Path) -> None:
    """A planner is a curve; its points are its settings by time; the table makes the picture."""
    quality = load("harness.report.quality")
    rows = []
    asked = protocol(
        load,
        "beam:width=10",
        "beam:width=100",
        "auto@1",
        "auto@5",
        "mcts:preset=tuned",
        zones=0,
        iterations=1,
    )
    for trial in asked.trials():
        for key, visits, cpu in (
            ("beam:width=100@10", 29, 0.5),
            ("beam:width=10@10", 27, 0.1),
            ("auto@1", 29, 0.9),
            ("auto@5", 30, 4.0),
            ("mcts:preset=tuned@10", 29, 5.0),
        ):
            more = {
                "planning_cpu_s": cpu,
                "build_cpu_s": 0.25,
                "upper_bound": 30.0,
                "status": "optimal" if visits == 30 else "feasible",
            }
            rows.append(row(load, trial, key, visits, **more))
    path = kept(load, tmp_path, rows)
    (section,) = load("harness.report.model").read(path).sections
    found = quality.spots(section)
    curves = quality.curves(found)
    assert {name: quality.words(curve) for name, curve in curves.items()} == {
        "beam": ["10", "100"],
        "auto": ["1 s", "5 s"],
        "mcts preset=tuned": ["preset=tuned"],
    }
    assert [spot.seconds for spot in curves["beam"]] == pytest.approx([0.35, 0.75])
    assert [(spot.visits, spot.proven, spot.bound) for spot in curves["auto"]] == [
        (29.0, 0, 30.0),
        (30.0, 2, 30.0),
    ]
    quality.write_table(found, tmp_path / "t.csv")
    again = quality.read_table(tmp_path / "t.csv")
    for one, other in zip(again, found, strict=True):
        assert one.method == other.method
        assert one.seconds == pytest.approx(other.seconds, rel=1e-5)
    for name in ("one.svg", "two.svg"):
        quality.draw(again, tmp_path / name, "a title")
    picture = (tmp_path / "one.svg").read_bytes()
    assert picture == (tmp_path / "two.svg").read_bytes()
    assert len(picture) > 10_000


def test_the_chart_of_the_page_is_that_of_its_table(load: Load, tmp_path, capsys) -> None:
    """docs/benchmarks.md shows the committed chart, and names the table that it is drawn from."""
    script = load("time_quality")
    page = (BENCH.parent / "docs" / "benchmarks.md").read_text(encoding="utf-8")
    found = load("harness.report.quality").read_table(script.TABLE)
    assert script.curves(draw=True, picture=tmp_path / "drawn.svg") == 0
    assert f"(../bench/curves/{script.TABLE.name})" in page
    assert len(capsys.readouterr().out.strip().splitlines()) == 2 + len(found)
    assert {spot.planner for spot in found} >= {
        "greedy",
        "greedy-guarded",
        "beam",
        "mcts",
        "local-search",
        "auto",
        "ortools",
        "exact",
        "ppo",
    }
    assert f"pictures/{script.PICTURE.name}" in page
    picture = script.PICTURE.read_text(encoding="utf-8")
    assert picture.startswith("<?xml")
    assert len(picture) < 500_000


def test_the_report_counts_only_legal_plans_and_names_the_rest(load: Load, tmp_path: Path) -> None:
    """A plan that failed is no visits in the mean, and its sentence stands in the page."""
    asked = protocol(load, "greedy", "beam")
    bad = {"outcome": "illegal", "message": "leg 1: <late>"}
    rows = []
    for trial in asked.trials():
        rows.append(row(load, trial, "greedy@10", 16))
        more = bad if (trial.field, trial.iteration) == (1, 0) else {}
        rows.append(row(load, trial, "beam@10", 30, **more))
    file = kept(load, tmp_path, rows)
    path = load("harness.report.write").write(file, tmp_path)
    failures = load("harness.report.model").read(file).failures
    assert failures == ("nominal, field 1, iteration 0: beam: illegal: leg 1: <late>",)
    page = path.read_text(encoding="utf-8")
    assert "beam: illegal: leg 1: &lt;late&gt;" in page
    lines = (tmp_path / "summary.csv").read_text().splitlines()
    summary = [dict(zip(lines[0].split(","), line.split(","), strict=True)) for line in lines[1:]]
    assert [(line["method"], line["visits_mean"], line["failed"]) for line in summary] == [
        ("greedy@10", "16.0", "0"),
        ("beam@10", "22.5", "1"),
    ]
    assert summary[0]["gap_to_best_known"] == str((3 * 14 / 30 + 0.0) / 4)


def test_best_known_plans_of_the_repository_count(load: Load, tmp_path: Path) -> None:
    """The gap of a mission without zones is to the table of best-known plans, found by digest."""
    asked = protocol(load, fields=1, iterations=1, zones=0)
    (trial,) = asked.trials()
    digest = adr_opt.generate("nominal", 0).sha256
    path = kept(load, tmp_path, [row(load, trial, "greedy@10", 15, sha256=digest)])
    (section,) = load("harness.report.model").read(path).sections
    assert section.means("greedy@10").gap_to_best_known == 0.5  # 15 of 30


@pytest.mark.skipif(EXECUTABLE is None, reason="no Chromium on this machine")
@pytest.mark.slow
def test_the_page_draws_offline_and_fits_a_phone(load: Load, tmp_path: Path) -> None:
    """Both figures are drawn, nothing is fetched or complained of, the page is not too wide."""
    path = filled(load, tmp_path, protocol(load, "greedy", "mcts", "beam", fields=5))
    page = load("harness.report.write").write(path, tmp_path)
    for width in (1280, 390):
        with Browser(tmp_path / f"profile-{width}", width=width) as browser:
            browser.open(page)
            browser.wait_for("document.querySelectorAll('.figure .points').length >= 6")
            fetched = [url for url in browser.requests if not url.startswith("data:")]
            assert fetched == [page.as_uri()]
            assert browser.complaints == []
            assert browser.evaluate("document.documentElement.scrollWidth") <= width
            marks = "document.querySelectorAll('#figure-0 .points path').length"
            assert browser.evaluate(marks) == 3 * 5
    pictures = sorted(path.name for path in tmp_path.glob("*.png"))
    assert pictures == ["time-nominal-z6.png", "visits-nominal-z6.png"]


def test_the_page_names_calibration_machine_and_published_numbers(
    load: Load, tmp_path: Path
) -> None:
    """What a reader must not miss: what is calibrated, whose hardware, which versions."""
    path = filled(load, tmp_path, protocol(load, "greedy", "mcts"))
    page = load("harness.report.write").write(path, tmp_path).read_text(encoding="utf-8")
    assert "calibration" in page
    assert "MacBook Pro M1 Max" in page
    assert "25–29, mean 27.1" in page
    assert f"numba {adr_opt.mission.result.versions()['numba']}" in page
    figures = re.search(r'<script type="application/json" id="figures">(.*?)</script>', page)
    assert figures is not None
    assert set(json.loads(figures[1])) == {"figure-0", "figure-1", "figure-2"}
