"""The benchmark as a whole, run as processes: killed, resumed, side by side, on a cluster."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from html import escape
from pathlib import Path

import pytest

for package in ("matplotlib", "plotly", "scipy"):
    pytest.importorskip(package)

SCRIPT = Path(__file__).parents[2] / "bench" / "run_all.py"
PATIENCE_S = 400.0

# Planners as a third party would install them. Each call is noted, so that work that is done twice
# cannot hide behind rows that are kept once.
PLANNERS = """
import os, signal, time
from adr_opt.run.methods import get
from adr_opt.mission.mission import Mission
from adr_opt.mission.certified import certify

def note(mission, name):
    if "-i" not in mission.instance.name:
        return  # compiling, not planning
    with open(os.environ["NOTES"], "a") as file:
        file.write(f"{name} {mission.instance.name}\\n")

def slow(mission, *, seed, stop, progress):
    note(mission, "slow")
    time.sleep(0.15)
    while held(f"slow {mission.instance.name}\\n"):
        time.sleep(0.02)
    return get("greedy")(mission, seed=seed, stop=stop, progress=progress)

def held(line):
    try:
        return line in open(os.environ["NOTES"]).readlines()[int(open(os.environ["HOLD"]).read()):]
    except FileNotFoundError:
        return False

def raises(mission, *, seed, stop, progress):
    raise RuntimeError("no idea what to do")

def forgets(mission, *, seed, stop, progress):
    get("greedy")(mission, seed=seed, stop=stop, progress=progress)

def breaks(mission, *, seed, stop, progress):
    return certify(mission, "breaks", (1, 1), seed=seed, runtime_s=0.0)

def lies(mission, *, seed, stop, progress):
    result = get("greedy")(mission, seed=seed, stop=stop, progress=progress)
    plan = result.plan.replace(objective=result.objective + 1.0)
    return result.__class__(**{**vars(result), "plan": plan})

def deadly(mission, *, seed, stop, progress):
    note(mission, "deadly")
    if mission.instance.name.startswith("tiny-001"):
        os.kill(os.getpid(), signal.SIGKILL)
    return get("greedy")(mission, seed=seed, stop=stop, progress=progress)
"""

NAMES = ("slow", "raises", "forgets", "breaks", "lies", "deadly")

TIMES = {"planning_s", "planning_cpu_s", "check_s", "build_s", "build_cpu_s", "warm_s", "runtime_s"}


@pytest.fixture
def environment(tmp_path: Path) -> dict[str, str]:
    """Variables of processes that find the planners above, as if they were installed."""
    folder = tmp_path / "installed"
    information = folder / "odd_planners-1.0.dist-info"
    information.mkdir(parents=True)
    (folder / "odd_planners.py").write_text(PLANNERS)
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: odd-planners\nVersion: 1\n")
    names = "\n".join(f"{name} = odd_planners:{name}" for name in NAMES)
    (information / "entry_points.txt").write_text(f"[adr_opt.planners]\n{names}\n")
    paths = filter(None, (str(folder), os.environ.get("PYTHONPATH")))
    return {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(paths),
        "NOTES": str(tmp_path / "notes.txt"),
        "HOLD": str(tmp_path / "hold.txt"),
    }


Start = Callable[..., subprocess.Popen]


def heed_interrupts() -> None:
    """What a script in the background starts inherits an ignored SIGINT, but not from a shell."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def start(environment: dict[str, str]) -> Iterator[Start]:
    """Start the benchmark as a process; ended with the test."""
    started = []

    def call(folder: Path, *arguments: object) -> subprocess.Popen:
        command = [sys.executable, str(SCRIPT), "--out", str(folder), "--suite", "tiny"]
        process = subprocess.Popen(
            [*command, *map(str, arguments)],
            env=environment,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            preexec_fn=heed_interrupts,
        )
        started.append(process)
        return process

    yield call
    for process in started:
        if process.poll() is None:
            process.kill()
        process.communicate()


def finish(process: subprocess.Popen) -> tuple[int, str]:
    """Exit status and messages of a process."""
    _, said = process.communicate(timeout=PATIENCE_S)
    return process.returncode, said


def facts(folder: Path) -> dict[str, dict]:
    """All of each row but times and places: what has to be the same however it came about."""
    path = folder / "results.jsonl"
    lines = path.read_bytes().split(b"\n")[1:-1] if path.exists() else []
    return {
        json.dumps(row["key"]): {
            name: value
            for name, value in row["value"].items()
            if name not in TIMES | {"environment"}
        }
        for row in map(json.loads, lines)
    }


def wait_until(happened: Callable[[], bool]) -> None:
    """Wait, but not for ever."""
    end = time.monotonic() + PATIENCE_S
    while not happened():
        assert time.monotonic() < end
        time.sleep(0.02)


def wait_for_rows(folder: Path, number: int) -> None:
    """Wait until a run has kept so many rows."""
    wait_until(lambda: len(facts(folder)) >= number)


@contextmanager
def held_after(environment: dict[str, str], calls: int) -> Iterator[None]:
    """While it lasts, calls of `slow` after so many do not end: a run stays half-way."""
    hold = Path(environment["HOLD"])
    hold.write_text(str(calls))
    try:
        yield
    finally:
        hold.unlink()


def wait_for_notes(environment: dict[str, str], number: int) -> None:
    """Wait until so many calls are noted."""
    path = Path(environment["NOTES"])
    wait_until(lambda: path.exists() and len(path.read_text().splitlines()) >= number)


def notes(environment: dict[str, str]) -> list[str]:
    path = Path(environment["NOTES"])
    lines = path.read_text().splitlines() if path.exists() else []
    path.unlink(missing_ok=True)
    return lines


@pytest.mark.slow
def test_a_run_that_is_killed_goes_on_where_it_was(
    start: Start, tmp_path: Path, environment: dict[str, str]
) -> None:
    """After SIGKILL half-way the same command gives the rows of an undisturbed run, none twice.

    Only the plans that were being made are made again.
    """
    arguments = ["--cases", 6, "--iterations", 2, "--methods", "greedy,slow,mcts", "--jobs", 2]
    arguments += ["--no-report"]
    assert finish(start(tmp_path / "whole", *arguments))[0] == 0
    assert len(notes(environment)) == 12

    with held_after(environment, 4):
        killed = start(tmp_path / "killed", *arguments)
        wait_for_notes(environment, 6)
        wait_for_rows(tmp_path / "killed", 4 * 3 + 2)  # four fields, and greedy of two others
        killed.send_signal(signal.SIGKILL)
        killed.wait()
        time.sleep(1.0)  # workers end when they find their coordinator gone
    before = facts(tmp_path / "killed")
    assert len(before) == 14
    status, said = finish(start(tmp_path / "killed", *arguments))
    assert status == 0
    assert facts(tmp_path / "killed") == facts(tmp_path / "whole")
    assert f"{36 - len(before)} rows" in said
    assert before.items() <= facts(tmp_path / "killed").items()
    calls = notes(environment)
    assert len(set(calls)) == 12
    assert len(calls) == 12 + 2  # one for each worker

    status, said = finish(start(tmp_path / "killed", *arguments))
    assert (status, said.splitlines()[0]) == (0, "nothing is missing")


@pytest.mark.slow
def test_one_run_at_a_time_writes_to_a_folder(
    start: Start, tmp_path: Path, environment: dict[str, str]
) -> None:
    """A second run is refused while the first goes on, which it does not disturb."""
    arguments = ["--cases", 2, "--iterations", 1, "--methods", "slow", "--jobs", 1, "--no-report"]
    with held_after(environment, 0):
        first = start(tmp_path / "out", *arguments)
        wait_for_notes(environment, 1)
        status, said = finish(start(tmp_path / "out", *arguments))
        assert (status, said.count("\n")) == (2, 1)
        assert "results.jsonl: another call is writing to it" in said
    assert finish(first)[0] == 0
    assert len(notes(environment)) == len(facts(tmp_path / "out")) == 2


@pytest.mark.slow
def test_planners_that_raise_lie_or_kill_do_not_end_the_run(start: Start, tmp_path: Path) -> None:
    """Their rows say so, all others are there, the report names them, the exit status is 1."""
    out = tmp_path / "out"
    methods = "deadly,greedy,raises,forgets,breaks,lies,beam:width=50"
    status, said = finish(
        start(
            out,
            "--cases",
            3,
            "--iterations",
            1,
            "--methods",
            methods,
            "--jobs",
            2,
            "--bound",
            "lagrangian",
            "--bound-time-limit",
            5,
        )
    )
    assert status == 1
    rows = [(json.loads(key), row) for key, row in facts(out).items()]
    outcomes = {
        (key["method"].split("@")[0], key["field"]): row["outcome"]
        for key, row in rows
        if "method" in key
    }
    bounds = [row for key, row in rows if "bound" in key]
    assert len(outcomes) == 3 * 7
    assert [row.get("message") for row in bounds] == [None] * 3
    for field in range(3):
        assert outcomes["greedy", field] == outcomes["beam:width=50", field] == "legal"
        assert outcomes["raises", field] == "raised"
        assert outcomes["forgets", field] == outcomes["breaks", field] == "raised"
        assert outcomes["lies", field] == "illegal"
        assert outcomes["deadly", field] == ("died" if field == 1 else "legal")
    assert all(row["upper_bound"] is not None for row in bounds)
    page = (out / "report.html").read_text(encoding="utf-8")
    for sentence in (
        "tiny, field 1, iteration 0: deadly: died: its worker process died",
        "tiny, field 0, iteration 0: raises: raised: RuntimeError: no idea what to do",
        "tiny, field 0, iteration 0: forgets: raised: InputError: method 'forgets' returned None",
        "tiny, field 0, iteration 0: breaks: raised: InputError: ",
        "tiny, field 2, iteration 0: lies: illegal: plan: objective",
    ):
        assert escape(sentence) in page
        assert sentence in said
    for wrong in ("raises", "forgets", "breaks"):
        assert f"{wrong}: fails on the practice mission tiny-000-z2 (" in said


@pytest.mark.slow
def test_ctrl_c_ends_a_run_and_its_workers(
    start: Start, tmp_path: Path, environment: dict[str, str]
) -> None:
    """Interrupted, a run says one sentence, exits with 130, and no worker plans on."""
    with held_after(environment, 3):
        run = start(tmp_path / "out", "--cases", 20, "--methods", "slow", "--jobs", 2)
        wait_for_rows(tmp_path / "out", 3)
        run.send_signal(signal.SIGINT)
        # Messages end when the last worker, which inherits the pipe, has ended.
        status, said = finish(run)
    assert status == 130
    assert said.splitlines()[-1].startswith("interrupted; what is finished is kept")
    assert "Traceback" not in said
    assert len(facts(tmp_path / "out")) == 3
    assert len(notes(environment)) <= 3 + 2


@contextmanager
def cluster(folder: Path, environment: dict[str, str]) -> Iterator[tuple[str, list]]:
    """A Dask scheduler with two worker processes, each its own; address and workers."""
    log = (folder / "cluster.log").open("w")
    dask = [sys.executable, "-m", "distributed.cli.dask_scheduler"]
    address_file = folder / "scheduler.json"
    processes = [
        subprocess.Popen(
            [
                *dask,
                "--host",
                "127.0.0.1",
                "--port",
                "0",
                "--no-dashboard",
                "--scheduler-file",
                str(address_file),
            ],
            cwd=folder,
            env=environment,
            stdout=log,
            stderr=log,
        )
    ]
    try:
        wait_until(address_file.exists)
        for _ in range(2):
            processes.append(
                subprocess.Popen(
                    [
                        sys.executable,
                        "-m",
                        "distributed.cli.dask_worker",
                        "--nthreads",
                        "1",
                        "--no-nanny",
                        "--no-dashboard",
                        "--scheduler-file",
                        str(address_file),
                    ],
                    cwd=folder,
                    env=environment,
                    stdout=log,
                    stderr=log,
                )
            )
        yield json.loads(address_file.read_text())["address"], processes[1:]
    finally:
        for process in reversed(processes):
            process.kill()
            process.wait()
        log.close()


@pytest.mark.slow
def test_a_cluster_gives_the_same_rows_even_when_a_worker_is_killed(
    start: Start, tmp_path: Path, environment: dict[str, str]
) -> None:
    """A real scheduler with two workers, one of them killed half-way: all rows of processes."""
    pytest.importorskip("distributed")
    arguments = ["--cases", 5, "--iterations", 2, "--methods", "greedy,slow,mcts", "--no-report"]
    assert finish(start(tmp_path / "whole", *arguments, "--jobs", 2))[0] == 0
    notes(environment)
    with cluster(tmp_path, environment) as (address, workers):
        with held_after(environment, 4):
            run = start(
                tmp_path / "cluster", *arguments, "--cluster", address.replace("tcp://", "dask://")
            )
            wait_for_notes(environment, 6)
            wait_for_rows(tmp_path / "cluster", 4 * 3)
            workers[0].send_signal(signal.SIGKILL)
            assert len(facts(tmp_path / "cluster")) < 30
        status, said = finish(run)
    assert status == 0, said
    assert facts(tmp_path / "cluster") == facts(tmp_path / "whole")
