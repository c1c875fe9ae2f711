"""The rooms of the benchmark one by one: methods, trials, store, bad input."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest
from run_all_rows import Load, protocol, row

import adr_opt
from adr_opt.common import cluster
from adr_opt.common.errors import InputError

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
    store = load("harness.store").Store(tmp_path)
    lacking = {trial.suite: keys for trial, keys in store.missing(asked).items()}
    assert lacking == {
        "tiny": {"greedy@10", "beam@10", "auto@10"},
        "campaign": {"greedy@10", "auto@10"},
    }
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
            (
                "bound",
                {
                    **bound,
                    "method": "lagrangian",
                    "limit_s": 1.0,
                    "upper_bound": 33.0,
                    "environment": row(load, trial, "x")[1]["environment"],
                },
            ),
        ],
        run,
    )
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
