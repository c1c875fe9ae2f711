"""Spoilt tables of costs, trade-off files and plans end in a result or in one printable sentence.

At the gate a few of each; `pytest -m slow tests/problem/test_mutated_files.py -s` does 21,000, and
says what they came to.
"""

from __future__ import annotations

import gc
import os
import signal
import sys
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import given_tables
import numpy as np
import pytest
from conftest import Cli
from hand_made import hand_made
from mutations import (
    changed_bytes,
    drawn,
    spoilt,
    spoilt_bytes,
    spoilt_cells,
    spoilt_json,
    spoilt_lines,
    spoilt_numbers,
)
from seeds import over_kinds
from toy_roads import NAMES, solved
from two_chasers import campaign

import adr_opt
from adr_opt.analysis import Axis, tradeoff
from adr_opt.common.errors import InputError
from adr_opt.common.stop import MaxIterations
from adr_opt.problem.chasers import TankByMass
from adr_opt.problem.given_files import read_given

CASES, FEW = range(5700), 60
SLOWEST_S = 60.0
"""Kernels that have to be compiled included."""

STUCK_S = 10
"""After which a library has lost its way in a damaged file."""

LONGEST_SENTENCE = 900
TANKS = Axis("delta-v", (130.0, 300.0))

SAMPLES = over_kinds("numbers", cases=(CASES, FEW))


class Found:
    """What cases came to, and those that should have come to something else."""

    def __init__(self, kind: str, folder: Path) -> None:
        self.kind, self.folder = kind, folder
        self.counts: Counter[str] = Counter()
        self.wrong: list[str] = []

    def case(self, number: int, data: bytes, judge: Callable[[], str]) -> None:
        """Judge a case; what it raises that is no `InputError` with one sentence is kept."""
        began = time.process_time()
        try:
            self.counts[judge()] += 1
        except InputError as error:
            said = str(error)
            if not (10 < len(said) < LONGEST_SENTENCE and said.isprintable()):
                self.keep(number, data, f"no sentence: {said[:200]!r}")
            self.counts["refused"] += 1
        except Exception:
            self.keep(number, data, traceback.format_exc(limit=-3))
        if time.process_time() - began > SLOWEST_S:
            self.keep(number, data, "too slow")

    def keep(self, number: int, data: bytes, said: str) -> None:
        """Keep a case that went wrong."""
        (self.folder / f"{self.kind}-{number}").write_bytes(data)
        self.wrong.append(f"{self.kind} {number}: {said}")
        self.counts["wrong"] += 1

    def judged(self) -> None:
        """Say what there was, and fail if anything was wrong."""
        print(f"{self.kind}: {dict(self.counts)}")
        assert self.wrong == [], "\n".join([f"{len(self.wrong)} in {self.folder}", *self.wrong[:5]])


@pytest.fixture
def complaints(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """What is complained about where nobody hears of it: a second traceback, mostly."""
    heard: list[str] = []
    monkeypatch.setattr(sys, "unraisablehook", lambda found: heard.append(repr(found.exc_value)))
    yield heard
    gc.collect()
    assert heard == []


def read(path: Path, instance: adr_opt.Instance) -> str:
    """Read a table; what is taken can be planned on."""
    given = read_given(path, NAMES)
    for values in (given.departure, given.arrival, given.cost):
        assert np.isfinite(values).all()
        assert (values >= 0.0).all()
    assert set(given.names) <= set(NAMES)
    instance.with_given(given)
    return "taken"


@SAMPLES
def test_spoilt_columns(tmp_path: Path, numbers: range, complaints: list[str]) -> None:
    """Parquet files are read or refused, whatever is in them, and whatever their bytes are."""
    pytest.importorskip("pyarrow")
    found, (instance, _), path = Found("parquet", tmp_path), solved(), tmp_path / "t.parquet"
    for number in numbers:
        rng = drawn("parquet", number)
        data = given_tables.parquet(rng)
        if rng.random() < 0.3:
            data = spoilt_bytes(data, rng)
        path.write_bytes(data)
        found.case(number, data, lambda: read(path, instance))
    found.judged()


@SAMPLES
def test_spoilt_matrices(tmp_path: Path, numbers: range, complaints: list[str]) -> None:
    """NetCDF files of other variables, types, units and values are read or refused."""
    for package in ("xarray", "h5netcdf"):
        pytest.importorskip(package)
    found, (instance, _), path = Found("netcdf", tmp_path), solved(), tmp_path / "t.nc"
    for number in numbers[: len(numbers) // 2]:
        data = given_tables.netcdf(drawn("netcdf", number))
        path.write_bytes(data)
        found.case(number, data, lambda: read(path, instance))
    found.judged()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs processes that can be ended")
@SAMPLES
def test_damaged_matrices(tmp_path: Path, numbers: range) -> None:
    """NetCDF files with other bytes are read or refused, without a second traceback.

    Each by a process of its own: of some the HDF5 library makes no end, or ends with the process,
    which is nothing that a program above it could mend. These are counted, and must be few.
    """
    for package in ("xarray", "h5netcdf"):
        pytest.importorskip(package)
    found, (instance, _), path = Found("damaged", tmp_path), solved(), tmp_path / "t.nc"
    path.write_bytes(given_tables.whole_netcdf())
    assert read(path, instance) == "taken"  # what the libraries look up once is no part of a case

    for number in numbers[: len(numbers) // 4]:
        rng = drawn("damaged", number)
        whole = given_tables.netcdf(rng) if rng.random() < 0.5 else given_tables.whole_netcdf()
        data = rng.choice((spoilt_bytes, changed_bytes, changed_bytes))(whole, rng)
        path.write_bytes(data)
        found.case(number, data, lambda: in_a_process(lambda: read(path, instance)))
    stuck = found.counts["stuck"] + found.counts["killed"]
    assert stuck <= 1 + 0.02 * len(numbers)
    found.judged()


def in_a_process(judge: Callable[[], str]) -> str:
    """The same in a process that is ended after some seconds."""
    read_end, write_end = os.pipe()
    child = os.fork()
    if child == 0:
        gc.freeze()  # what was there before is not looked through, and so not copied
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(STUCK_S)
        heard: list[str] = []
        sys.unraisablehook = lambda found: heard.append(repr(found.exc_value))
        try:
            said = f"done {judge()}"
        except InputError as error:
            said = f"refused {error}"
        except BaseException:
            said = f"raised {traceback.format_exc(limit=-3)}"
        gc.collect()
        said = f"raised again: {heard[0]}" if heard else said
        os.write(write_end, said.encode(errors="backslashreplace")[:4000])
        os._exit(0)
    os.close(write_end)
    said = os.read(read_end, 4000).decode()
    os.close(read_end)
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        return "stuck" if os.WTERMSIG(status) == signal.SIGALRM else "killed"
    how, _, told = said.partition(" ")
    if how == "refused":
        raise InputError(told)
    assert how == "done", told
    return told


class Over(MaxIterations):
    """A stop that has stopped before anything is run."""

    def remaining_s(self) -> float:
        """No time is left."""
        return 0.0


@SAMPLES
def test_spoilt_tradeoffs(tmp_path: Path, numbers: range) -> None:
    """Files of results are gone on from, or refused and left as they are."""
    path, instance = tmp_path / "r.csv", hand_made()
    tradeoff(instance, [TANKS], path=path, time_limit=60.0)
    whole = path.read_bytes()
    cells = (instance.sha256, "method auto, 20 s, seed 0", "auto", "beam+auto", "magic")
    found = Found("tradeoff", tmp_path)
    for number in numbers:
        rng = drawn("tradeoff", number)
        data = spoilt(
            whole,
            rng,
            spoilt_bytes,
            spoilt_numbers,
            spoilt_lines,
            lambda data, rng: spoilt_cells(data, rng, cells),
        )
        path.write_bytes(data)
        stop = None if number % 50 == 0 else Over(1)

        def judge(data: bytes = data, stop: Any = stop) -> str:
            try:
                made = tradeoff(instance, [TANKS], path=path, time_limit=60.0, stop=stop)
            except InputError:
                assert stop is None or path.read_bytes() == data
                raise
            for point in made.points:
                assert not point.prize > point.upper_bound
                if stop is None:
                    assert point.proven
            return "gone on from"

        found.case(number, data, judge)
    found.judged()


def missions() -> Iterator[tuple[str, adr_opt.Instance, str]]:
    """Instances of several kinds with a plan of each."""
    towed = adr_opt.generate(
        "rocket-bodies",
        0,
        targets=4,
        towed_kg=1400.0,
        disposal={"circle_m": 350e3},
        tank=TankByMass(dry_mass_kg=1000.0, propellant_kg=3000.0, isp_s=310.0),
    )
    for name, instance, method in (
        ("tiny", adr_opt.generate("tiny", 0), "greedy-guarded"),
        ("campaign", campaign(), "auto"),
        ("drifting", towed, "auto"),
    ):
        plan = adr_opt.solve(instance, method, time_limit=60.0).plan
        assert plan is not None, name
        yield name, instance, plan.to_json()
    instance, plan = solved()
    yield "roads", instance, plan.to_json()


VERBS: tuple[tuple[str, ...], ...] = (
    ("fly",),
    ("export", "--out", "x.czml"),
    ("export", "--out", "x.oem"),
    ("replan", "--at", "0.2", "--time-limit", "0.2", "--method", "greedy-guarded"),
    ("report", "--out", "x.html"),
    ("solve", "--method", "local-search", "--time-limit", "0.5", "--start"),
)
"""Verbs that read plans, besides `check`."""


@SAMPLES
def test_spoilt_plans(cli: Cli, tmp_path: Path, numbers: range) -> None:
    """What reads a plan judges it, or refuses it in one sentence, and never breaks off."""
    known = []
    for name, instance, text in missions():
        instance.save(tmp_path / f"{name}.json")
        known.append((f"{name}.json", text.encode()))
    found = Found("plan", tmp_path)
    for number in numbers:
        rng = drawn("plan", number)
        file, whole = known[number % len(known)]
        data = spoilt(whole, rng, spoilt_bytes, spoilt_numbers, spoilt_json, spoilt_json)
        Path("p.json").write_bytes(data)
        calls: list[tuple[str, ...]] = [("check", file, "p.json")]
        if number % 5 == 0:
            verb, *more = rng.choice(VERBS)
            calls.append(
                (verb, file, *more, "p.json") if verb == "solve" else (verb, file, "p.json", *more)
            )
        for call in calls:
            found.case(number, data, lambda call=call: judged(cli, call))  # type: ignore[misc]
    found.judged()


def judged(cli: Cli, call: tuple[str, ...]) -> str:
    """Whether a verb ends as verbs do."""
    outcome = cli(*call)
    assert outcome.status in (0, 1, 2)
    assert "Traceback" not in outcome.err
    assert all(each.isprintable() or each in "\n\t" for each in outcome.out + outcome.err)
    if outcome.status == 2:
        said = [line for line in outcome.err.splitlines() if "compiling, once" not in line]
        assert said[-1].startswith("adr-opt: ")
        raise InputError(said[-1])
    return f"{call[0]} {outcome.status}"
