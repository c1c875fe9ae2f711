"""How fast ``serve`` answers: a large catalogue, the first plan of a cloud, and under full load.

    python bench/serve_latency.py
    python bench/serve_latency.py --objects 24000 --targets 120 --seconds 20

One server, as the command line starts it. A synthetic catalogue is dropped and listed; objects of
like planes become targets; the planner has had the time to load its kernels; then Plan is pressed.
While it plans, with a bound beside the planner, states are asked for and prizes edited one after
the other. Reach: objects within 3 s, a first plan within 10 s, 95 % of all answers within 0.1 s.
"""

from __future__ import annotations

import argparse
import http.client
import itertools
import json
import random
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import machine

WARM_S = 60.0
"""Longest wait for the planner to have loaded its kernels [s]."""

REACH_S = 0.1
"""Limit on answers, which 95 % of them keep [s]."""


def catalogue(objects: int, seed: int = 0) -> bytes:
    """Element sets of objects in low orbits, as a TLE file."""
    drawn = random.Random(seed)
    lines = []
    for at in range(objects):
        name = f"PIECE {at} DEB" if at % 3 else f"STAGE {at} R/B"
        first = (
            f"1 {10_000 + at:05d}U 20001A   26001.{drawn.randrange(10**8):08d}  .00000100  00000-0"
            "  10000-4 0  999"
        )
        second = (
            f"2 {10_000 + at:05d} {98.0 + drawn.random():8.4f} {drawn.uniform(0, 359):8.4f} "
            f"{drawn.randrange(20_000):07d} {drawn.uniform(0, 359):8.4f} "
            f"{drawn.uniform(0, 359):8.4f} {drawn.uniform(14.0, 14.6):11.8f}    1"
        )
        for line in (first, second):
            digit = sum(int(each) if each.isdigit() else each == "-" for each in line) % 10
            lines.append(f"{line}{digit}")
        lines.insert(-2, name)
    return "\n".join(lines).encode() + b"\n"


class Asked:
    """A server, asked on one connection after the other."""

    def __init__(self, folder: Path) -> None:
        self.process = subprocess.Popen(
            [
                sys.executable,
                "-m",
                "adr_opt",
                "serve",
                "--folder",
                str(folder),
                "--no-open",
                "--json",
            ],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        assert self.process.stdout is not None
        lines: list[str] = []
        while not lines or lines[-1] != "}\n":
            lines.append(self.process.stdout.readline())
            if not lines[-1]:
                raise SystemExit("the server ended before it said where it serves")
        said = json.loads("".join(lines))
        self.port = said["port"]
        self.headers = {
            "Cookie": f"adr-opt-{self.port}={urlsplit(said['url']).query.partition('=')[2]}"
        }

    def ask(self, path: str, body: Any = None, kind: str = "application/json") -> tuple[float, Any]:
        """Time until the whole answer is there [s], and the answer."""
        content = body if body is None or isinstance(body, bytes) else json.dumps(body).encode()
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=300.0)
        began = time.perf_counter()
        connection.request(
            "GET" if body is None else "POST", path, content, {**self.headers, "Content-Type": kind}
        )
        answer = connection.getresponse()
        text = answer.read()
        elapsed_s = time.perf_counter() - began
        connection.close()
        if answer.status != 200:
            raise SystemExit(f"{path}: {answer.status} {text.decode()}")
        return elapsed_s, json.loads(text)

    def looks(self) -> Any:
        """Looks at the run, as the page hears of them."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=300.0)
        connection.request("GET", "/events", headers=self.headers)
        answer = connection.getresponse()
        event = ""
        for line in iter(answer.readline, b""):
            text = line.decode().strip()
            if text.startswith("event: "):
                event = text.removeprefix("event: ")
            elif text.startswith("data: ") and event == "work":
                yield json.loads(text.removeprefix("data: "))


def measure(server: Asked, objects: int, targets: int, seconds: float) -> None:
    """Print all times."""
    said, _ = server.ask("/upload?name=all.tle", catalogue(objects), "application/octet-stream")
    listed, columns = server.ask("/objects")
    again, _ = server.ask("/objects")
    print(f"{objects} objects: dropped {said:.2f} s, listed {listed:.2f} s, again {again:.2f} s")
    by_plane = sorted(zip(columns["raan_deg"], columns["names"], strict=True))
    chosen, _ = server.ask("/choose", {"names": [name for _, name in by_plane[:targets]]})
    print(f"{targets} targets: chosen {chosen:.2f} s")
    # The first run is short: it waits for the kernels, and the page may have been open for long.
    server.ask("/plan", {"method": "greedy", "time_limit_s": 1.0})
    looks = server.looks()
    end = time.perf_counter() + WARM_S
    for look in looks:
        if (look["number"] == 1 and not look["runs"]) or time.perf_counter() > end:
            break
    server.ask("/edit", {"duration_s": 8 * 86400.0})  # so that nothing of that run is of use
    began = time.perf_counter()
    order = {"method": "auto", "time_limit_s": seconds, "bound": "exact", "goes_on": False}
    server.ask("/plan", order)
    first = next(
        time.perf_counter() - began
        for look in looks
        if look["number"] == 2 and look["incumbent"] is not None
    )
    print(f"first plan {first:.2f} s after Plan was pressed, warm")
    taken: dict[str, list[float]] = {}
    name = columns["names"][columns["names"].index(by_plane[0][1])]
    for at in itertools.count():
        if time.perf_counter() > began + seconds:
            break
        for path in ("/state", "/jobs", "/results", "/choices"):
            taken.setdefault(path, []).append(server.ask(path)[0])
        edit = {"targets": {"names": [name], "prize": 1.0 + at % 50}}
        taken.setdefault("/edit", []).append(server.ask("/edit", edit)[0])
        time.sleep(0.05)
    print("while planning      answers  median s    95 % s     most s")
    for path, times in [*taken.items(), ("all", list(itertools.chain(*taken.values())))]:
        cut = statistics.quantiles(times, n=20)[-1]
        figures = f"{statistics.median(times):9.4f} {cut:9.4f} {max(times):10.4f}"
        print(f"{path:18} {len(times):8} {figures}")
    everything = list(itertools.chain(*taken.values()))
    share = sum(each <= REACH_S for each in everything) / len(everything)
    print(f"within {REACH_S:g} s: {share:.1%}")


def main() -> None:
    """Measure one server."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--objects", type=int, default=24_000)
    parser.add_argument("--targets", type=int, default=120)
    parser.add_argument("--seconds", type=float, default=20.0, help="time limit of the plan")
    given = parser.parse_args()
    print(machine.heading())
    with tempfile.TemporaryDirectory() as place:
        server = Asked(Path(place) / "project")
        try:
            measure(server, given.objects, given.targets, given.seconds)
        finally:
            server.process.terminate()
            server.process.wait(120.0)


if __name__ == "__main__":
    main()
