"""``serve`` as processes: private files, one server a folder, kills."""

from __future__ import annotations

import http.client
import json
import os
import random
import signal
import stat
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
from conftest import Cli, refused
from hand_made import hand_made
from serve_desks import session_of, until

import adr_opt
from adr_opt.ui.serve.folder import Folder
from adr_opt.ui.serve.planner_process import PlannerProcess
from adr_opt.ui.serve.planning import PlanningOrder

pytest.importorskip("starlette")
pytest.importorskip("uvicorn")

pytestmark = pytest.mark.skipif(
    not Path("/proc/self/task").exists(), reason="looks for processes as Linux lists them"
)

GREEDY = {"method": "greedy-guarded", "time_limit_s": 20.0}


class Served:
    """A server in a process of its own."""

    def __init__(self, folder: Path) -> None:
        self.process = subprocess.Popen(
            [
                sys.executable,
                "-m",
                "adr_opt",
                "serve",
                "--folder",
                folder.name,
                "--no-open",
                "--json",
            ],
            cwd=folder.parent,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        assert self.process.stdout is not None
        lines = []
        while not lines or lines[-1] not in ("}\n", ""):
            lines.append(self.process.stdout.readline())
        said = json.loads("".join(lines))
        self.port = said["port"]
        self._cookie = f"adr-opt-{self.port}={urlsplit(said['url']).query.partition('=')[2]}"

    def ask(
        self, method: str, path: str, body: bytes = b"{}", kind: str = "application/json"
    ) -> Any:
        """What an address answers."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60.0)
        headers = {"Cookie": self._cookie, "Content-Type": kind}
        try:
            connection.request(method, path, body if method == "POST" else None, headers)
            answer = connection.getresponse()
            text = answer.read()
        finally:
            connection.close()
        assert answer.status == 200, text
        return json.loads(text)

    def post(self, path: str, content: Any) -> Any:
        """What a request that changes something answers."""
        return self.ask("POST", path, json.dumps(content).encode())

    def drop(self, name: str, content: bytes) -> None:
        """Drop a file."""
        self.ask("POST", f"/upload?name={name}", content, "application/octet-stream")

    def children(self) -> list[int]:
        """Processes that the server has started, from any of its threads."""
        found = []
        for task in Path(f"/proc/{self.process.pid}/task").iterdir():
            found += [int(each) for each in (task / "children").read_text().split()]
        return found

    def kill(self) -> None:
        """Kill it as with kill -9."""
        self.process.kill()
        self.process.wait()
        assert self.process.stdout is not None
        self.process.stdout.close()


@contextmanager
def served(folder: Path) -> Iterator[Served]:
    """A server until it is killed."""
    made = Served(folder)
    try:
        yield made
    finally:
        made.kill()


def alive(process: int) -> bool:
    """Whether a process is there, and not only its exit status."""
    with suppress(OSError):
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False


@pytest.mark.slow
def test_a_killed_server_leaves_what_was_done_and_nothing_else(tmp_path: Path, cli: Cli) -> None:
    """Files are private, the folder has one server, and its processes end with it."""
    folder = tmp_path / "project"
    with served(folder) as server:
        refused(cli("serve", "--folder", str(folder), "--no-open"), "another server uses")
        server.drop("i", hand_made().to_json().encode())
        server.post("/plan", GREEDY)
        until(lambda: server.ask("GET", "/state")["result"] is not None)
        for path in (folder, *folder.rglob("*")):
            mode = stat.S_IMODE(path.stat().st_mode)
            assert mode == (0o700 if path.is_dir() else 0o600), path
        children = server.children()
        assert children
        server.post("/plan", {"method": "local-search", "time_limit_s": 3600.0})
        server.post("/edit", {"targets": {"names": ["north"], "prize": 3.0}})
    until(lambda: not any(alive(each) for each in children))
    again = session_of(None, None, Folder(folder))
    state = again.state()
    assert (state["targets"][0][1], state["undoes"]) == (3.0, "prize of north 3")
    assert (state["result"], state["trouble"]) == (1, "")
    instance, plan = adr_opt.load(folder / "instance.json"), adr_opt.load_plan(folder / "plan.json")
    assert adr_opt.check(instance, plan) == ()
    again.undo()
    assert again.state()["plan"]["fits"]


@pytest.mark.slow
def test_a_planning_process_that_dies_is_said_and_replaced(tmp_path: Path) -> None:
    """A killed worker is a failed run with one sentence; the next run has another worker."""
    results: list[float] = []

    def done(instance: Any, result: Any) -> str:
        results.append(result.plan.objective)
        return "well"

    work = PlannerProcess(done, tmp_path)
    try:
        work.begin(
            adr_opt.generate("nominal", 0, targets=30),
            PlanningOrder(method="local-search", time_limit_s=3600.0),
            None,
        )
        until(lambda: work.progress().phase == "planning")
        assert work._process is not None
        os.kill(work._process.pid, signal.SIGKILL)
        assert work.wait(60.0)
        look = work.progress()
        assert (look.number, look.phase) == (1, "failed")
        assert look.said.startswith("the planning process has died by signal 9")
        work.begin(hand_made(), PlanningOrder(method="greedy-guarded", time_limit_s=20.0), None)
        assert work.wait(60.0)
        assert (work.progress().number, work.progress().phase, work.progress().said) == (
            2,
            "done",
            "well",
        )
        assert len(results) == 1
    finally:
        work.close()
    assert list(tmp_path.iterdir()) == []


def known_plans(folder: Path) -> list[Path]:
    """Plans in folders of results that are not over."""
    return [
        path
        for path in folder.glob("results/*/plan.json")
        if not (path.parent / "result.json").exists()
    ]


@pytest.mark.slow
def test_the_best_plan_so_far_outlives_a_kill(tmp_path: Path) -> None:
    """Killed while it plans, a server leaves the best plan so far, shown as one stopped early."""
    folder = tmp_path / "project"
    with served(folder) as server:
        server.drop("i", adr_opt.generate("nominal", 0, targets=30).to_json().encode())
        server.post("/plan", {"method": "local-search", "time_limit_s": 3600.0})
        until(lambda: known_plans(folder))
        assert server.ask("GET", "/results") == []
    again = session_of(None, None, Folder(folder))
    state = again.state()
    assert (state["result"], state["plan"]["fits"], state["trouble"]) == (1, True, "")
    (record,) = again.results.all()
    assert record.said.startswith("stopped early")
    assert record.objective is not None
    assert record.objective > 0.0
    instance, plan = again.results.plan(1)
    assert adr_opt.check(instance, plan) == ()
    assert adr_opt.load_plan(folder / "plan.json") == plan
    assert session_of(None, None, Folder(folder)).state()["result"] == 1


@pytest.mark.slow
def test_the_best_plan_so_far_outlives_its_planner(tmp_path: Path) -> None:
    """Where the process that plans is killed, the best plan so far is a result at once."""
    folder = tmp_path / "project"
    with served(folder) as server:
        server.drop("i", adr_opt.generate("nominal", 0, targets=30).to_json().encode())
        server.post("/plan", {"method": "local-search", "time_limit_s": 3600.0})
        until(lambda: known_plans(folder))
        for child in server.children():
            os.kill(child, signal.SIGKILL)
        until(lambda: server.ask("GET", "/results"))
        (row,) = server.ask("GET", "/results")
        assert row["said"].startswith("stopped early")
        assert server.ask("GET", "/state")["result"] == row["id"] == 1


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_a_kill_at_any_moment_loses_nothing_that_was_answered(tmp_path: Path, seed: int) -> None:
    """Of edits, plans and jobs all that the server has answered is there when it is reopened."""
    drawn = random.Random(seed)
    folder, answered, results = tmp_path / "project", [1.0], 0
    with served(folder) as server:
        server.drop("i", hand_made().to_json().encode())
        threading.Timer(drawn.uniform(0.0, 6.0), server.process.kill).start()
        with suppress(OSError, http.client.HTTPException, AssertionError):
            for at in range(10_000):
                prize = float(at + 2)
                server.post("/edit", {"targets": {"names": ["north"], "prize": prize}})
                answered.append(prize)
                if at % 7 == 0:
                    server.post("/plan", GREEDY)
                if at % 31 == 3:
                    server.post("/jobs", {"verb": "check", "options": {}, "results": []})
                results = max(results, len(server.ask("GET", "/results")))
    again = session_of(None, None, Folder(folder))
    state = again.state()
    # What was in work when it came may be there or not.
    assert state["targets"][0][1] in (answered[-1], answered[-1] + 1.0)
    assert state["trouble"] == ""
    assert len(again.results.all()) >= results
    for record in again.results.all():
        if record.has_plan:
            instance, plan = again.results.plan(record.number)
            assert adr_opt.check(instance, plan) == ()
    steps = 0
    while again.state()["undoes"] is not None:
        again.undo()
        steps += 1
    assert steps == min(int(state["targets"][0][1]), 500)
    assert not [path for path in folder.rglob(".*")]
