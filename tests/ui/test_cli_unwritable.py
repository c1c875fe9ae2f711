"""Places that cannot be written, and names that cannot be said: one sentence, and no left-overs."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from conftest import Cli, refused

import adr_opt
from adr_opt.plan.plan import load_plan


def test_places_that_cannot_be_written(
    cli: Cli, tiny_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A hopeless --out is refused before the planner starts."""

    def never(*_: Any, **__: Any) -> None:
        raise AssertionError("the planner was started")

    monkeypatch.setattr("adr_opt.run.front.run", never)
    monkeypatch.setattr("adr_opt.sources.generator.generate", never)
    monkeypatch.setattr("adr_opt.sources.catalogue.read", never)
    cloud = Path(__file__).parents[2] / "examples/catalogue/cloud.tle"
    calls = (["solve", tiny_file, "--method", "greedy"], ["generate", "tiny"], ["import", cloud])
    for call in calls:
        refused(cli(*call, "--out", "no/such/p.json"), "no/such/p.json: the folder no/such does")
        refused(cli(*call, "--out", "."), ".: this is a folder")
        refused(cli(*call, "--out", "/dev/null"), "/dev/null: not an ordinary file")
    refused(cli("solve", tiny_file, "--method", "greedy", "--out", tiny_file), "this is the input")


@pytest.mark.slow
def test_results_beside_others_that_are_not_there_yet(cli: Cli, tiny_file: Path) -> None:
    """A result may replace a file while another result of the run is new, but not be the same."""
    Path("old.json").write_text("old")
    Path("old.html").write_text("old")
    call = ["solve", tiny_file, "--method", "exact"]
    done = cli(*call, "--certificate", "old.json", "--out", "new.json")
    assert done.status == 0, done.err
    assert Path("new.json").exists()
    assert Path("old.json").read_text() != "old"
    call = ["tradeoff", tiny_file, "--vary", "delta-v=500,1000", "--time-limit", 1]
    done = cli(*call, "--page", "old.html", "--out", "new.csv")
    assert done.status == 0, done.err
    assert Path("new.csv").exists()
    assert Path("old.html").read_text() != "old"
    call = ["solve", tiny_file, "--method", "exact", "--certificate", "./same.json"]
    refused(cli(*call, "--out", "same.json"), "./same.json: this is the name of another result")


def test_no_result_takes_the_place_of_another_or_of_what_is_read(cli: Cli, tiny_file: Path) -> None:
    """Of one call no two results go into one file, by whatever name, nor one into an input."""
    solved = cli("solve", tiny_file, "--method", "exact", "--out", "p.json")
    assert solved.status == 0, solved.err
    Path("old.json").write_text("old")
    Path("new-link.json").symlink_to("new.json")
    Path("old.svg").write_text("old")
    call = ["solve", tiny_file, "--method", "exact", "--out"]
    another = "this is the name of another result"
    refused(cli(*call, "old.json", "--certificate", "old.json"), another)
    refused(cli(*call, "new.json", "--certificate", "new-link.json"), another)
    refused(cli(*call, "new.json", "--refine", "--refined-out", "new-link.json"), another)
    refused(cli(*call, "x.json", "--start", "p.json", "--certificate", "p.json"), "is the input")
    call = ["replan", tiny_file, "p.json", "--at", "0.1", "--out", "new.json", "--out-instance"]
    refused(cli(*call, "new-link.json"), another)
    call = ["tradeoff", tiny_file, "--vary", "delta-v=500", "--out", "old.svg"]
    refused(cli(*call, "--plot", "old.svg"), another)
    call = ["tradeoff", tiny_file, "--vary", "duration=1", "--out", "old.json"]
    refused(cli(*call, "--frontier", "old.json"), another)
    assert Path("old.json").read_text() == Path("old.svg").read_text() == "old"
    assert load_plan("p.json").legs


def test_a_link_is_written_through(cli: Cli, tmp_path: Path) -> None:
    """--out on a link replaces the file it points to and leaves the link."""
    (tmp_path / "folder").mkdir()
    (tmp_path / "link.json").symlink_to("folder/real.json")
    assert cli("generate", "tiny", "--out", "link.json").status == 0
    assert (tmp_path / "link.json").is_symlink()
    assert adr_opt.load(tmp_path / "folder" / "real.json") == adr_opt.generate("tiny", 0)


def test_a_failed_write_leaves_nothing(
    cli: Cli, tmp_path: Path, full_disk: Callable[[], None]
) -> None:
    """A disk that fills up while a file is written leaves neither the file nor a piece of it."""
    full_disk()
    refused(cli("generate", "tiny", "--out", "my.json"), "my.json: cannot be written (File too")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("more", [["--quiet"], ["--quiet", "--json"]])
def test_a_plan_that_cannot_be_written_is_printed(
    cli: Cli, tiny_file: Path, tmp_path: Path, full_disk: Callable[[], None], more: list[str]
) -> None:
    """A full disk does not cost the plan: it ends standard output, and the exit status is 2."""
    full_disk()
    outcome = cli("solve", tiny_file, "--method", "greedy-guarded", "--out", "p.json", *more)
    assert outcome.status == 2
    assert "p.json: cannot be written" in outcome.err
    assert "the plan is on standard output" in outcome.err
    assert outcome.err.count("\n") == 1
    plan = adr_opt.plan.plan.Plan.model_validate_json(outcome.out[outcome.out.index("{") :])
    assert adr_opt.check(adr_opt.load(tiny_file), plan) == ()
    assert not list(tmp_path.glob("*p*.json"))


def test_a_certificate_that_cannot_be_written_says_where_the_plan_is(
    cli: Cli, tiny_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A disk that fills up after the plan costs the certificate alone, and the bound is said."""

    def full(path: str, content: bytes) -> None:
        raise adr_opt.InputError(f"{path}: cannot be written (No space left on device)")

    monkeypatch.setattr("adr_opt.plan.certificate.write_bytes", full)
    call = ("solve", tiny_file, "--method", "exact", "--certificate", "c.json", "--quiet")
    kept = cli(*call, "--out", "p.json")
    assert kept.status == 2
    assert kept.err.endswith(
        "c.json: cannot be written (No space left on device); the plan is in p.json\n"
    )
    assert "{" not in kept.out
    assert adr_opt.check(adr_opt.load(tiny_file), load_plan("p.json")) == ()
    printed = cli(*call)
    assert printed.status == 2
    assert "; the plan is on standard output instead" in printed.err
    assert printed.out.rstrip().endswith("}")
    bound = cli("bound", tiny_file, "--method", "lagrangian", "--certificate", "c.json", "--quiet")
    assert bound.status == 2
    assert "c.json: cannot be written" in bound.err
    assert "upper bound" in bound.out


@pytest.mark.parametrize("suffix", [".npz", ".nc", ".parquet"])
def test_a_matrix_that_cannot_be_written(
    cli: Cli, tiny_file: Path, tmp_path: Path, full_disk: Callable[[], None], suffix: str
) -> None:
    """A disk that fills up while a matrix is written ends in one sentence and leaves nothing."""
    for package in ("h5netcdf", "xarray", "pyarrow"):
        pytest.importorskip(package)
    arguments = ["matrix", tiny_file, *([] if suffix == ".parquet" else ["--at", 0]), "--out"]
    assert cli(*arguments, f"first{suffix}").status == 0  # compiles and caches
    full_disk()
    refused(cli(*arguments, f"c{suffix}"), f"c{suffix}: cannot be written (")
    assert {path.name for path in tmp_path.iterdir()} == {"tiny.json", f"first{suffix}"}


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="names of files are text elsewhere")
@pytest.mark.parametrize("encoding", [{"PYTHONUTF8": "0"}, {"PYTHONUTF8": "1"}])
def test_names_that_no_encoding_can_say(
    tiny_file: Path, tmp_path: Path, encoding: dict[str, str]
) -> None:
    """A file whose name is no text is read and written, and named with escapes, in any locale."""
    pytest.importorskip("pyarrow")
    environment = os.environ | {"LC_ALL": "POSIX"} | encoding
    plan, rows = b"p\xff.json", b"r\xff\xc3\xbc.parquet"
    for arguments, said in (
        (["solve", tiny_file, "--method", "greedy", "--out", plan], b"wrote p\\udcff.json"),
        (["check", tiny_file, plan], b""),
        (["check", tiny_file, b"n\xff"], b"n\\udcff: no such file"),
        (["matrix", tiny_file, "--out", rows, "--json"], b"wrote r\\udcff"),
    ):
        done = subprocess.run(
            [sys.executable, "-m", "adr_opt", *arguments],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            check=False,
        )
        assert done.returncode == (2 if b"no such" in said else 0), done.stderr
        assert said in done.stderr
        assert b"Traceback" not in done.stderr
        if "--json" in arguments:
            assert json.loads(done.stdout)["path"].encode(errors="surrogateescape") == rows
    assert {plan, rows} <= {name for name in os.listdir(os.fsencode(tmp_path))}


def test_names_with_a_nul(tmp_path: Path) -> None:
    """No file can have a NUL in its name, which is said like everything else."""
    instance = adr_opt.generate("tiny", 0)
    plan = adr_opt.solve(instance, "greedy").plan
    assert plan is not None
    with pytest.raises(adr_opt.InputError, match="not a valid file name"):
        plan.save(f"{tmp_path}/a\0b.json")
    with pytest.raises(adr_opt.InputError, match="not a valid file name"):
        adr_opt.load(f"{tmp_path}/a\0b.json")


def test_left_overs_of_killed_writers_are_removed(cli: Cli, tmp_path: Path) -> None:
    """With the next write beside them go temporary files older than a day, and nothing else."""
    day, names = 86400.0, {}
    for name, age in {
        ".plan-abcd1234.part.json": 2.0 * day,
        ".m-a_b_c_d_.part": 2.0 * day,
        ".plan-efgh5678.part.json": 0.5 * day,
        ".plan-abcd1234.json": 2.0 * day,
        "plan-abcd1234.part.json": 2.0 * day,
        ".plan-abcd1234.part.json.bak": 2.0 * day,
    }.items():
        names[name] = age
        (tmp_path / name).touch()
        os.utime(tmp_path / name, times=(time.time() - age,) * 2)
    (tmp_path / ".link-abcd1234.part.json").symlink_to("no")
    (tmp_path / ".folder-abcd1234.part").mkdir()
    assert cli("generate", "tiny", "--out", "my.json").status == 0
    left = {path.name for path in tmp_path.iterdir()}
    assert names.keys() - left == {".plan-abcd1234.part.json", ".m-a_b_c_d_.part"}
    assert {"my.json", ".link-abcd1234.part.json", ".folder-abcd1234.part"} <= left
