"""What a new user waits for: installation, the first plan, a plan with nothing compiled.

    python bench/first_hour.py                  # all rows; clones this checkout's last commit
    python bench/first_hour.py cold import --runs 5

`solve` is ``make solve`` in a fresh clone with an empty home; `cold` is `solve` by ``auto`` with an
empty folder for kernels against one that has them; `wheel` the same from a wheel in an environment
of its own, where nothing may be compiled; `import` is ``import adr_opt`` in a process. Times are
medians of whole processes; the first plan is counted from the start of the process.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from statistics import median
from typing import Literal

from fields import INSTANCES, ROOT
from tables import experiment, head, row, times_s

FIRST_PLAN = """
import json, sys, time
import adr_opt
from adr_opt.kernels.core.compile import compiling_s
found = []
def tell(incumbent, bound):
    if incumbent > 0.0 and not found:
        found.append(time.time())
adr_opt.solve(sys.argv[1], "auto", time_limit=10.0, progress=tell)
print(json.dumps([found[0], compiling_s()]))
"""


def alone() -> dict[str, str]:
    """The environment of this process, without what points to a checkout."""
    return {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")}


def first_plan(python: str, kept: Path, environment: dict[str, str]) -> tuple[float, float, float]:
    """Seconds to the first plan and to the last line, and those spent compiling."""
    began = time.time()
    said = subprocess.check_output(
        [python, "-c", FIRST_PLAN, str(INSTANCES / "nominal" / "nominal-000.json")],
        text=True,
        cwd=kept.parent,
        env=environment | {"ADR_OPT_CACHE_DIR": str(kept)},
    )
    whole = time.time() - began
    found, compiling = json.loads(said.splitlines()[-1])
    return found - began, whole, compiling


def make_solve(folder: Path, runs: int) -> Iterator[tuple[str, str]]:
    """``make solve`` in a fresh clone, with an empty home."""
    taken = []
    for run in range(runs):
        clone, home = folder / f"clone-{run}", folder / f"home-{run}"
        subprocess.run(["git", "clone", "--quiet", str(ROOT), str(clone)], check=True)
        home.mkdir()
        empty = {"HOME": str(home), "XDG_CACHE_HOME": str(home), "PYTHON": sys.executable}
        began = time.perf_counter()
        subprocess.check_output(["make", "solve"], cwd=clone, env=alone() | empty)
        taken.append(time.perf_counter() - began)
    yield "`make solve` in a fresh clone", f"{median(taken):.1f} s"


def cold(folder: Path, runs: int) -> Iterator[tuple[str, str]]:
    """A plan by ``auto`` with and without compiled kernels."""
    measured = []
    for run in range(runs):
        here = sys.executable, folder / f"kept-{run}", dict(os.environ)
        measured.append((first_plan(*here), first_plan(*here)))
    for at, what in enumerate(("first plan by `auto`", "whole run")):
        for warm, state in enumerate(("nothing", "all")):
            yield f"{what}, {state} compiled", f"{median(run[warm][at] for run in measured):.1f} s"
    ratio = median(run[0][1] / run[1][1] for run in measured)
    yield "ratio of whole runs", f"{ratio:.1f}"


def wheel(folder: Path, runs: int) -> Iterator[tuple[str, str]]:
    """A plan by ``auto`` from a wheel, in an environment of its own."""
    build = [sys.executable, str(ROOT / "bench" / "wheel.py"), "--out", str(folder / "dist")]
    subprocess.check_output(build)
    (made,) = (folder / "dist").glob("*.whl")
    subprocess.run([sys.executable, "-m", "venv", str(folder / "venv")], check=True)
    python, constraints = str(folder / "venv/bin/python"), str(ROOT / "constraints.txt")
    install = [python, "-m", "pip", "install", "--quiet", "--constraint", constraints, str(made)]
    subprocess.run(install, check=True, env=alone())
    measured = [first_plan(python, folder / f"wheel-{run}", alone()) for run in range(runs)]
    first, whole, compiling = (median(run[k] for run in measured) for k in range(3))
    yield "first plan by `auto` from a wheel, empty cache", f"{first:.1f} s"
    yield "whole run from a wheel, empty cache", f"{whole:.1f} s"
    yield "of that compiling", f"{compiling:.1f} s"
    yield "size of the wheel", f"{made.stat().st_size / 1e6:.1f} MB"


def importing(folder: Path, runs: int) -> Iterator[tuple[str, str]]:
    """``import adr_opt`` in a process of its own."""
    command = [sys.executable, "-c", "import adr_opt"]
    taken = times_s(lambda: subprocess.run(command, check=True, cwd=folder), 3 * runs)
    yield "`import adr_opt`, whole process", f"{median(taken):.2f} s"


ROWS: dict[str, Callable[[Path, int], Iterator[tuple[str, str]]]] = {
    "solve": make_solve,
    "cold": cold,
    "wheel": wheel,
    "import": importing,
}


def waits(*rows: Literal["solve", "cold", "wheel", "import"], runs: int = 3) -> None:
    """Print some rows, or all."""
    head("wait", "time")
    for name in rows or ROWS:
        with tempfile.TemporaryDirectory() as folder:
            for each in ROWS[name](Path(folder), runs):
                row(*each)


if __name__ == "__main__":
    sys.exit(experiment(__doc__, waits))
