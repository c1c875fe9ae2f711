"""The rooms of the benchmark one by one: methods, trials, its file, bad input."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from run_all_rows import Load, kept, protocol, row

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.study import Place, Run, cluster

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
        load,
        "greedy",
        "beam",
        "auto",
        fields=1,
        iterations=1,
        zones=0,
        bound=bound,
        suites=("tiny", "campaign"),
    )
    results = load("harness.results")
    with Run(results.study(), tmp_path / "r.jsonl") as running:
        lacking = results.missing(running, asked, retry_failed=False)
    names = {trial.suite: [each.what.name for each in rows] for trial, rows in lacking.items()}
    assert names == {
        "tiny": ["greedy", "beam", "auto", "lagrangian"],
        "campaign": ["greedy", "auto"],
    }
    with pytest.raises(InputError, match="several chasers, for which none of the methods plans"):
        load("harness.options").parse(
            ["--out", str(tmp_path), "--suite", "campaign", "--methods", "beam,mcts"], ""
        )


def test_a_campaign_is_planned_checked_and_told(load: Load) -> None:
    """A row of several chasers is legal and holds a route each; the duration is of the longest."""
    asked = protocol(load, "greedy-guarded", fields=1, iterations=1, zones=0, suites=("campaign",))
    ((wanted,),) = [asked.wanted(trial) for trial in asked.trials()]
    facts = load("harness.work").Rows().row(wanted, Place())
    assert facts["outcome"] == "legal", facts["message"]
    routes = [[int(body) for body in route.split()] for route in facts["sequence"].split(" / ")]
    assert len(routes) == 3
    assert sum(body > 0 for route in routes for body in route) == facts["visits"]
    plan = adr_opt.solve(adr_opt.generate("campaign", 0), "greedy-guarded").plan
    assert facts["duration_used_s"] == max(leg.end_s for leg in plan.legs)


# --- the file -------------------------------------------------------------------------------------


def test_what_the_file_has_is_not_missing(load: Load, tmp_path: Path) -> None:
    """Exactly the rest is made, knowing the best plan; rows that failed are made again if asked."""
    asked = protocol(load, "greedy", "beam")
    first, second, *_ = asked.trials()
    results = load("harness.results")
    bad = {"outcome": "raised", "message": "no"}
    path = kept(
        load,
        tmp_path,
        [
            row(load, first, "greedy@10", 16),
            row(load, first, "beam@10", 30, seed=1),
            row(load, second, "greedy@10", **bad),
            row(load, second, "beam@10"),
        ],
    )
    for retry, number in ((False, 3), (True, 4)):
        with Run(results.study(), path) as running:
            lacking = results.missing(running, asked, retry_failed=retry)
        assert len(lacking) == number
        ((name, best),) = [(each.what.name, each.best) for each in lacking[first]]
        assert (name, best) == ("beam", 16.0)
        assert [each.what.name for each in lacking.get(second, ())] == ["greedy"] * retry


def test_the_bound_of_a_trial_is_the_least_that_anyone_proved(load: Load, tmp_path: Path) -> None:
    """Rows show the least bound of bounds and legal plans, and the gap to it; illegal ones none."""
    call = load("harness.trials").BoundCall("lagrangian", 1.0)
    (trial,) = protocol(load, fields=1, iterations=1).trials()
    wanted = load("harness.trials").Wanted(trial, call, 0)
    bound = {"upper_bound": 33.0, "environment": load("harness.work").environment()}
    path = kept(
        load,
        tmp_path,
        [
            row(load, trial, "greedy@10", 16),
            row(load, trial, "auto@10", 30, upper_bound=32.0),
            row(load, trial, "beam@10", 40, outcome="illegal", upper_bound=1.0),
            (wanted.key(), bound, 1.0),
        ],
    )
    rows, bounds = load("harness.results").results(path)
    assert {row["method"]: (row["bound"], row["gap"]) for row in rows} == {
        "greedy@10": (32.0, 0.5),
        "auto@10": (32.0, 2.0 / 32.0),
        "beam@10": (32.0, None),
    }
    assert [each["upper_bound"] for each in bounds] == [33.0]


def test_files_of_others_are_refused(
    load: Load, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Another file: one sentence, and the file as it was."""
    call = ["--suite", "tiny", "--methods", "greedy", "--out", str(tmp_path)]
    path = tmp_path / "results.jsonl"
    path.write_text("visits, seconds\n" * 100)
    before = path.read_bytes()
    for more in ([], ["--report-only"]):
        assert load("run_all").main([*call, *more]) == 2
        assert "results.jsonl: not a file of a study (benchmark)" in capsys.readouterr().err
    assert path.read_bytes() == before


@pytest.mark.parametrize(
    "facts",
    [
        {"objective": None},
        {"refuellings": 10**400},
        {"environment": {}},
        {"planning_s": "1"},
        {"x": 1},
    ],
)
def test_rows_that_are_none_are_refused(
    load: Load, tmp_path: Path, facts: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    """A row with an unknown or missing fact, or one of another type: a sentence with its line."""
    (trial,) = protocol(load, fields=1, iterations=1).trials()
    kept(load, tmp_path, [row(load, trial, "greedy@10", **facts)])
    assert load("run_all").main(["--out", str(tmp_path), "--report-only"]) == 2
    assert "results.jsonl: line 2: not a row of benchmark" in capsys.readouterr().err


def test_rows_can_be_made_where_the_benchmark_is_not_installed(load: Load) -> None:
    """What is sent to a cluster needs adr-opt there, and none of the scripts of the benchmark."""
    cloudpickle = pytest.importorskip("cloudpickle")
    load("run_all")._by_value("dask://a:1")
    load("harness.work").warm_up(load("harness.methods").parse_methods(("greedy",), 10.0)[0])
    asked = protocol(load, "greedy", fields=1, iterations=1, zones=0, suites=("tiny",))
    ((wanted,),) = [asked.wanted(trial) for trial in asked.trials()]
    made = subprocess.run(
        [sys.executable, "-c", ELSEWHERE],
        input=cloudpickle.dumps((load("harness.work").Rows().row, wanted)),
        capture_output=True,
        check=False,
    )
    assert made.stdout.decode().strip() == "legal", made.stderr.decode()


ELSEWHERE = """
import pickle, sys
from adr_opt.study import Place
row, wanted = pickle.loads(sys.stdin.buffer.read())
print(row(wanted, Place(alone=False))["outcome"])
"""


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
    load: Load, tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], said: str
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
    monkeypatch.setattr(cluster, "PATIENCE_S", 0.5)
    out = ["--out", str(tmp_path / "out")]
    for address, said in (
        ("dask://127.0.0.1:1", "no Dask scheduler answers at dask://127.0.0.1:1"),
        ("127.0.0.1:1", "'127.0.0.1:1' is not an address; write dask://HOST:PORT"),
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


def test_the_forecast_follows_what_was_seen(load: Load) -> None:
    """Seconds left are the rows left times their mean, shared by the workers."""
    asked = protocol(load, "beam", fields=10, iterations=1)
    lacking = {trial: asked.wanted(trial) for trial in asked.trials()}
    display = load("harness.display")
    forecast = display.Forecast(lacking)
    assert forecast.left_s(1) == pytest.approx(20 * display.GUESS_S)
    facts = {"planning_s": 3.0, "check_s": 1.0, "build_s": display.GUESS_S}
    for rows in list(lacking.values())[:5]:
        forecast.hear(rows[0], facts)
    assert forecast.left_s(1) == pytest.approx(5 * 4.0 + 5 * display.GUESS_S)
    assert forecast.left_s(2) == forecast.left_s(1) / 2
