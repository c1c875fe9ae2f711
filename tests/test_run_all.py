"""The rooms of the benchmark one by one: methods, trials, store, statistics, report, bad input."""

from __future__ import annotations

import importlib
import json
import math
import re
import sqlite3
import sys
import time
from collections.abc import Callable, Iterator
from itertools import product
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from browser import EXECUTABLE, Browser
from scipy import stats

import adr_opt
from adr_opt.errors import InputError

BENCH = Path(__file__).parents[1] / "bench"
Load = Callable[[str], ModuleType]


@pytest.fixture(scope="module")
def load() -> Iterator[Load]:
    """Import a module of the bench folder, which is no package."""
    pytest.importorskip("plotly")
    pytest.importorskip("matplotlib")
    sys.path.insert(0, str(BENCH))
    yield importlib.import_module
    sys.path.remove(str(BENCH))


def protocol(load: Load, *specs: str, fields: int = 2, iterations: int = 2, **changes: Any) -> Any:
    trials, methods = load("harness.trials"), load("harness.methods")
    asked = {
        "suites": ("nominal",),
        "fields": fields,
        "iterations": iterations,
        "zones": 6,
        "methods": methods.parse_methods(specs or ("greedy",), 10.0),
        "seed": 0,
        "bound": None,
    }
    return trials.Protocol(**{**asked, **changes})


def row(load: Load, trial: Any, method: str, visits: int = 20, **changes: Any) -> tuple[str, dict]:
    """A message with a row as a worker tells it."""
    facts = {
        "suite": trial.suite,
        "field": trial.field,
        "iteration": trial.iteration,
        "zones": trial.zones,
        "method": method,
        "seed": 0,
        "outcome": "legal",
        "visits": visits,
        "refuellings": 1,
        "objective": float(visits),
        "delta_v_m_s": 5000.0,
        "duration_used_s": 6e5,
        "planning_s": 0.01 * visits,
        "runtime_s": 0.01,
        "check_s": 0.01,
        "build_s": 0.3,
        "sha256": f"{trial.suite}-{trial.field}-{trial.iteration}",
        "environment": load("harness.environment").environment(),
    }
    return "row", {**facts, **changes}


def filled(load: Load, folder: Path, asked: Any) -> Any:
    """A store with a row for everything that a protocol asks for, made up."""
    store = load("harness.store").Store(folder)
    run = store.begin_run("test", asked, 1)
    rows = [
        row(load, trial, method.key, 20 + 3 * number + (trial.field + trial.iteration) % 3)
        for trial in asked.trials()
        for number, method in enumerate(asked.methods)
    ]
    store.keep(rows, run)
    store.end_run(run, 1.0, dict.fromkeys((*load("harness.work").PARTS, "task"), 0.1))
    return store


# --- methods and trials ---------------------------------------------------------------------------


def test_a_method_has_one_key_however_it_is_typed(load: Load) -> None:
    """Options with commas, their order, a limit of one's own and doubles lead to one key each."""
    parse = load("harness.methods").parse_methods
    text = "greedy, mcts:simulations=50,depth=3@2,beam:width=20"
    keys = [method.key for method in parse([text, "mcts:depth=3,simulations=50@2.0"], 10.0)]
    assert keys == ["greedy@10", "mcts:depth=3,simulations=50@2", "beam:width=20@10"]
    assert parse(["auto"], 10.0)[0].values() == {"jobs": 1}
    assert parse(["auto:jobs=2"], 10.0)[0].values() == {"jobs": 2}


def test_labels_drop_the_time_limit_unless_it_tells_methods_apart(load: Load) -> None:
    """Two limits of one method keep them in their labels; the others are named without."""
    labels = load("harness.methods").labels(["greedy@10", "auto@10", "auto@60"])
    assert labels == {"greedy@10": "greedy", "auto@10": "auto@10", "auto@60": "auto@60"}


def test_iterations_change_the_zones_and_nothing_else(load: Load) -> None:
    """All draws of zones differ, the field of a suite is the generator's, with and without them."""
    trials = protocol(load, fields=3, iterations=4).trials()
    made = [trial.instance() for trial in trials]
    assert len({instance.keep_out_zones for instance in made}) == len(trials) == 12
    for trial, instance in zip(trials, made, strict=True):
        bare = adr_opt.generate("nominal", trial.field)
        assert len(instance.keep_out_zones) == 6
        assert instance.replace(name=bare.name, keep_out_zones=()) == bare
    without = load("harness.trials").Trial("nominal", 3, 0, 0)
    assert without.instance().sha256 == adr_opt.generate("nominal", 3).sha256


def test_methods_for_one_chaser_leave_campaigns_out(load: Load, tmp_path: Path) -> None:
    """A suite of several chasers lacks the rows of those methods and bounds that plan it, only."""
    bound = load("harness.trials").BoundCall("lagrangian", 5.0)
    asked = protocol(
        load, "greedy", "beam", "auto", fields=1, iterations=1, zones=0, bound=bound,
        suites=("tiny", "campaign"),
    )  # fmt: skip
    store = load("harness.store").Store(tmp_path)
    lacking = {trial.suite: keys for trial, keys in store.missing(asked).items()}
    assert lacking == {
        "tiny": {"greedy@10", "beam@10", "auto@10"}, "campaign": {"greedy@10", "auto@10"},
    }  # fmt: skip
    run = store.begin_run("a", asked, 1)
    one, several = asked.trials()
    assert store.claim(one, asked, run).bound == bound
    task = store.claim(several, asked, run)
    assert ([method.name for method in task.methods], task.bound) == (["greedy", "auto"], None)
    store.keep([row(load, several, key) for key in lacking["campaign"]], run)
    assert several not in store.missing(asked)
    with pytest.raises(InputError, match="several chasers, for which none of the methods plans"):
        load("harness.options").parse(
            ["--out", str(tmp_path), "--suite", "campaign", "--methods", "beam,mcts"], ""
        )


def test_a_campaign_is_planned_checked_and_told(load: Load, tmp_path: Path) -> None:
    """A row of several chasers is legal and holds a route each; the duration is of the longest."""
    asked = protocol(load, "greedy-guarded", fields=1, iterations=1, zones=0, suites=("campaign",))
    store = load("harness.store").Store(tmp_path)
    run, told = store.begin_run("a", asked, 1), []
    task = store.claim(asked.trials()[0], asked, run)
    load("harness.work").work(task, lambda kind, facts: told.append((kind, facts)))
    (facts,) = [facts for kind, facts in told if kind == "row"]
    assert facts["outcome"] == "legal", facts["message"]
    routes = [[int(body) for body in route.split()] for route in facts["sequence"].split(" / ")]
    assert len(routes) == 3
    assert sum(body > 0 for route in routes for body in route) == facts["visits"]
    plan = adr_opt.solve(adr_opt.generate("campaign", 0), "greedy-guarded").plan
    assert facts["duration_used_s"] == max(leg.end_s for leg in plan.legs)


# --- the store ------------------------------------------------------------------------------------


def test_a_row_is_kept_once_and_no_longer_missing(load: Load, tmp_path: Path) -> None:
    """The same row told twice, even by two stores, is one row; exactly the rest is missing."""
    asked = protocol(load, "greedy", "beam")
    first, second = (load("harness.store").Store(tmp_path) for _ in range(2))
    trial = asked.trials()[0]
    run = first.begin_run("a", asked, 1)
    assert len(first.keep([row(load, trial, "greedy@10", 16)], run)) == 1
    assert first.keep([row(load, trial, "greedy@10", 17)], run) == []
    assert second.keep([row(load, trial, "greedy@10", 18)], second.begin_run("b", asked, 1)) == []
    (kept,) = second.results()
    assert kept["visits"] == 16
    missing = second.missing(asked)
    assert missing[trial] == {"beam@10"}
    assert len(missing) == 4
    # Another seed or time limit is another row.
    assert len(first.keep([row(load, trial, "greedy@10", seed=1)], run)) == 1


def test_a_claimed_trial_is_left_alone_until_its_run_is_dead(load: Load, tmp_path: Path) -> None:
    """Two runs never take the same trial; the claims of a run that ended or died are void."""
    asked = protocol(load)
    store = load("harness.store").Store(tmp_path)
    mine, theirs = store.begin_run("a", asked, 1), store.begin_run("b", asked, 1)
    trial = asked.trials()[0]
    assert store.claim(trial, asked, mine).methods == asked.methods
    assert store.claim(trial, asked, theirs) is None
    base = sqlite3.connect(store.path)
    base.execute("UPDATE run SET host = 'elsewhere' WHERE id = ?", (mine,))
    base.commit()
    assert store.claim(trial, asked, theirs) is None
    base.execute("UPDATE run SET alive = alive - 3600 WHERE id = ?", (mine,))
    base.commit()
    assert store.claim(trial, asked, theirs).methods == asked.methods
    store.end_run(theirs, 1.0, {})
    assert store.claim(trial, asked, mine) is not None


def test_the_bound_of_a_trial_is_the_least_that_anyone_proved(load: Load, tmp_path: Path) -> None:
    """Rows show the least bound of bounds and legal plans, and the gap to it; illegal ones none."""
    asked = protocol(load, "greedy", "auto", "beam")
    store = load("harness.store").Store(tmp_path)
    run = store.begin_run("a", asked, 1)
    trial = asked.trials()[0]
    bound = {key: row(load, trial, "x")[1][key] for key in ("suite", "field", "iteration", "zones")}
    store.keep(
        [
            row(load, trial, "greedy@10", 16),
            row(load, trial, "auto@10", 30, upper_bound=32.0),
            row(load, trial, "beam@10", 40, outcome="illegal", upper_bound=1.0),
            ("bound", {**bound, "method": "lagrangian", "limit_s": 1.0, "upper_bound": 33.0,
                       "environment": row(load, trial, "x")[1]["environment"]}),
        ],
        run,
    )  # fmt: skip
    found = {result["method"]: (result["bound"], result["gap"]) for result in store.results()}
    assert found == {
        "greedy@10": (32.0, 0.5),
        "auto@10": (32.0, 2.0 / 32.0),
        "beam@10": (32.0, None),
    }


def test_files_of_others_and_of_other_formats_are_refused(load: Load, tmp_path: Path) -> None:
    """No database, one of something else, another format: one sentence, and the file as it was."""
    make = load("harness.store").Store
    path = tmp_path / "results.sqlite"
    path.write_text("visits, seconds\n" * 100)
    with pytest.raises(InputError, match=r"results\.sqlite: cannot be used as a file of results"):
        make(tmp_path)
    path.unlink()
    base = sqlite3.connect(path)
    base.execute("CREATE TABLE cake (slices INTEGER)")
    base.commit()
    with pytest.raises(InputError, match="is no file of this benchmark's results"):
        make(tmp_path)
    base.close()
    path.unlink()
    make(tmp_path).close()
    base = sqlite3.connect(path)
    base.execute("PRAGMA user_version = 7")
    base.commit()
    base.close()
    before = path.read_bytes()
    with pytest.raises(InputError, match="has format 7, but this version reads and writes format"):
        make(tmp_path)
    assert path.read_bytes() == before


# --- bad input ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--suite", "nominals"], "--suite: 'nominals' is unknown; use all or one of"),
        (["--methods", "gready"], "method 'gready' is unknown; use one of"),
        (["--methods", "beam:widht=3"], "option 'widht' of method 'beam' is unknown"),
        (["--methods", "beam:width=wide"], "option width = 'wide' of method 'beam'"),
        (["--methods", "beam:width=0"], "option width = 0 of method 'beam': must be at least 1"),
        (["--methods", "beam@soon"], "the time limit 'soon' is not a number of seconds"),
        (["--methods", "beam@-1"], "the time limit must be positive"),
        (["--methods", ","], "names no method"),
        (["--bound", "lagrange"], "--bound: method 'lagrange' is unknown"),
        (["--cases", "0"], "--cases = 0: must be between 1 and"),
        (["--cases", "ten"], "invalid int value: 'ten'"),
        (["--iterations", "1001"], "--iterations = 1001: must be between 1 and 1000"),
        (["--zones", "0"], "without zones all iterations are the same mission"),
        (["--time-limit", "nan"], "--time-limit = nan: must be positive"),
        (["--jobs", "0"], "--jobs = 0: must be a number of processes"),
        (["--jobs", "2", "--cluster", "dask://a:1"], "--jobs and --cluster exclude each other"),
        (["--colour"], "unrecognized arguments: --colour"),
        (["--report-only"], "no such file; run once without --report-only first"),
    ],
)
def test_a_wrong_call_is_one_sentence(
    load: Load,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    said: str,
) -> None:
    """Exit status 2 and one line that says what is wrong; nothing is written."""
    folder = tmp_path / "out"
    methods = [] if "--methods" in arguments else ["--methods", "greedy"]
    assert load("run_all").main([*arguments, *methods, "--out", str(folder)]) == 2
    heard = capsys.readouterr()
    assert said in heard.err
    assert heard.err.count("\n") == 1
    assert not folder.exists()


def test_an_unwritable_folder_and_a_silent_address_are_one_sentence(
    load: Load, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A folder below a file and a port without a scheduler end the run before it starts."""
    pytest.importorskip("distributed")
    (tmp_path / "file").write_text("")
    call = ["--suite", "tiny", "--methods", "greedy"]
    assert load("run_all").main([*call, "--out", str(tmp_path / "file" / "out")]) == 2
    assert "cannot be written to" in capsys.readouterr().err
    monkeypatch.setattr(adr_opt.cluster, "PATIENCE_S", 0.5)
    out = ["--out", str(tmp_path / "out")]
    for address, said in (
        ("dask://127.0.0.1:1", "no Dask scheduler answers at dask://127.0.0.1:1"),
        ("127.0.0.1:1", "'127.0.0.1:1' is no address; write dask://HOST:PORT"),
    ):
        assert load("run_all").main([*call, *out, "--cluster", address]) == 2
        assert said in capsys.readouterr().err


def test_a_missing_package_is_named_before_any_work(
    load: Load, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without a package of the report nothing is planned, and the sentence says what to install."""
    monkeypatch.setattr(load("harness.report.write"), "PACKAGES", ("scipy", "no_such_package"))
    out = tmp_path / "out"
    assert load("run_all").main(["--suite", "tiny", "--methods", "greedy", "--out", str(out)]) == 2
    assert "needs the package no_such_package: install the extra" in capsys.readouterr().err
    assert not out.exists()


def test_the_forecast_follows_what_was_seen(load: Load, tmp_path: Path) -> None:
    """Seconds left are the rows left times their mean, shared by the workers."""
    asked = protocol(load, "beam", fields=10, iterations=1)
    missing = {trial: {"beam@10"} for trial in asked.trials()}
    forecast = load("harness.display").Forecast(asked, missing, {("nominal", "beam@10"): 4.0})
    begin = forecast.left_s(1)
    assert begin == pytest.approx(10 * 4.0 + 10 * load("harness.display").GUESS_S)
    assert forecast.left_s(2) == begin / 2
    for _ in range(9):
        forecast.hear("nominal", "beam@10", 4.0, load("harness.display").GUESS_S)
    assert forecast.left_s(1) == pytest.approx(begin / 10)


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
    store = filled(load, tmp_path, protocol(load, "greedy", "mcts", "beam", fields=3, zones=0))
    results = load("harness.report.model").read(store)
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
    store = load("harness.store").Store(tmp_path)
    asked = protocol(load, "beam:width=10", "beam:width=100", "auto@1", "auto@5",
                     "mcts:preset=tuned", zones=0,
                     iterations=1)  # fmt: skip
    run = store.begin_run("a", asked, 1)
    for trial in asked.trials():
        for key, visits, cpu in (
            ("beam:width=100@10", 29, 0.5), ("beam:width=10@10", 27, 0.1), ("auto@1", 29, 0.9),
            ("auto@5", 30, 4.0), ("mcts:preset=tuned@10", 29, 5.0),
        ):  # fmt: skip
            more = {"planning_cpu_s": cpu, "build_cpu_s": 0.25, "upper_bound": 30.0,
                    "status": "optimal" if visits == 30 else "feasible"}  # fmt: skip
            store.keep([row(load, trial, key, visits, **more)], run)
    (section,) = load("harness.report.model").read(store).sections
    found = quality.spots(section)
    curves = quality.curves(found)
    assert {name: quality.words(curve) for name, curve in curves.items()} == {
        "beam": ["10", "100"], "auto": ["1 s", "5 s"], "mcts preset=tuned": ["preset=tuned"],
    }  # fmt: skip
    assert [spot.seconds for spot in curves["beam"]] == pytest.approx([0.35, 0.75])
    assert [(spot.visits, spot.proven, spot.bound) for spot in curves["auto"]] == [
        (29.0, 0, 30.0), (30.0, 2, 30.0),
    ]  # fmt: skip
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


def test_the_chart_of_the_page_is_that_of_its_table(load: Load) -> None:
    """docs/benchmarks.md has the table that the committed chart is drawn from, line by line."""
    script = load("time_quality")
    page = (BENCH.parent / "docs" / "benchmarks.md").read_text(encoding="utf-8")
    found = load("harness.report.quality").read_table(script.TABLE)
    assert "\n".join(script.lines(found)) in page
    assert {spot.planner for spot in found} >= {
        "greedy", "greedy-guarded", "beam", "mcts", "local-search", "auto", "ortools", "exact",
        "ppo",
    }  # fmt: skip
    assert f"pictures/{script.PICTURE.name}" in page
    picture = script.PICTURE.read_text(encoding="utf-8")
    assert picture.startswith("<?xml")
    assert len(picture) < 500_000


def test_rows_of_the_format_before_are_still_read(load: Load, tmp_path: Path) -> None:
    """A file without processor times gets the columns, and its times by the clock count."""
    schema, make = load("harness.schema"), load("harness.store").Store
    store = filled(load, tmp_path, protocol(load, "greedy", zones=0))
    before = [tuple(each.values())[:10] for each in store.results()]
    store.close()
    base = sqlite3.connect(tmp_path / "results.sqlite")
    base.execute("DROP VIEW result")
    for column in ("planning_cpu_s", "build_cpu_s"):
        base.execute(f"ALTER TABLE row DROP COLUMN {column}")
    base.execute(
        "CREATE VIEW result AS SELECT * FROM row JOIN environment ON environment.id = environment"
    )
    base.execute("PRAGMA user_version = 1")
    base.commit()
    base.close()
    store = make(tmp_path)
    assert [tuple(each.values())[:10] for each in store.results()] == before
    (section,) = load("harness.report.model").read(store).sections
    (spot,) = load("harness.report.quality").spots(section)
    assert spot.seconds == spot.wall_s > 0.0
    store.close()
    base = sqlite3.connect(tmp_path / "results.sqlite")
    assert base.execute("PRAGMA user_version").fetchone() == (schema.FORMAT,)


def test_the_report_counts_only_legal_plans_and_names_the_rest(load: Load, tmp_path: Path) -> None:
    """A plan that failed is no visits in the mean, and its sentence stands in the page."""
    asked = protocol(load, "greedy", "beam")
    store = load("harness.store").Store(tmp_path)
    run = store.begin_run("a", asked, 1)
    for trial in asked.trials():
        store.keep([row(load, trial, "greedy@10", 16), row(load, trial, "beam@10", 30)], run)
    base = sqlite3.connect(store.path)
    base.execute(
        "UPDATE row SET outcome = 'illegal', message = 'leg 1: <late>' "
        "WHERE method = 'beam@10' AND field = 1 AND iteration = 0"
    )
    base.commit()
    path = load("harness.report.write").write(store, tmp_path)
    failures = load("harness.report.model").read(store).failures
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
    store = load("harness.store").Store(tmp_path)
    asked = protocol(load, fields=1, iterations=1, zones=0)
    run = store.begin_run("a", asked, 1)
    (trial,) = asked.trials()
    digest = adr_opt.generate("nominal", 0).sha256
    store.keep([row(load, trial, "greedy@10", 15, sha256=digest)], run)
    (section,) = load("harness.report.model").read(store).sections
    assert section.means("greedy@10").gap_to_best_known == 0.5  # 15 of 30


@pytest.mark.skipif(EXECUTABLE is None, reason="no Chromium on this machine")
def test_the_page_draws_offline_and_fits_a_phone(load: Load, tmp_path: Path) -> None:
    """Both figures are drawn, nothing is fetched or complained of, the page is not too wide."""
    store = filled(load, tmp_path, protocol(load, "greedy", "mcts", "beam", fields=5))
    page = load("harness.report.write").write(store, tmp_path)
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
    store = filled(load, tmp_path, protocol(load, "greedy", "mcts"))
    page = load("harness.report.write").write(store, tmp_path).read_text(encoding="utf-8")
    assert "calibration" in page
    assert "MacBook Pro M1 Max" in page
    assert "25–29, mean 27.1" in page
    assert f"numba {adr_opt.result.versions()['numba']}" in page
    figures = re.search(r'<script type="application/json" id="figures">(.*?)</script>', page)
    assert figures is not None
    assert set(json.loads(figures[1])) == {"figure-0", "figure-1", "figure-2"}


@pytest.mark.slow
def test_ten_thousand_rows_are_reported_in_five_seconds(load: Load, tmp_path: Path) -> None:
    """The report of 10,000 rows takes less than 5 s."""
    asked = protocol(load, "greedy", "greedy-guarded", "mcts", "beam", "auto", fields=100,
                     iterations=10, suites=("nominal", "reduced-time"))  # fmt: skip
    store = filled(load, tmp_path, asked)
    assert len(store.results()) == 10_000
    began = time.perf_counter()
    load("harness.report.write").write(store, tmp_path)
    seconds = time.perf_counter() - began
    print(f"10,000 rows reported in {seconds:.2f} s")
    assert seconds < 5.0
