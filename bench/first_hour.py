"""Measure what a new user waits for: installation, the first plan, a plan with nothing compiled.

    python bench/first_hour.py                  # all rows; clones this checkout's last commit
    python bench/first_hour.py --runs 5 cold import

`solve` is ``make solve`` in a fresh clone with an empty home; `cold` is `solve` by ``auto`` with an
empty folder for kernels against one that has them; `wheel` the same from a wheel in an environment
of its own, where nothing may be compiled; `import` is ``import adr_opt`` in a process. Times are
medians of whole processes; the first plan is counted from the start of the process.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
NOMINAL = ROOT / "instances" / "nominal" / "nominal-000.json"

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
    ran = subprocess.run(
        [python, "-c", FIRST_PLAN, str(NOMINAL)],
        check=True,
        capture_output=True,
        text=True,
        cwd=kept.parent,
        env=environment | {"ADR_OPT_CACHE_DIR": str(kept)},
    )
    whole = time.time() - began
    found, compiling = json.loads(ran.stdout.splitlines()[-1])
    return found - began, whole, compiling


def make_solve(folder: Path, runs: int) -> list[str]:
    """``make solve`` in a fresh clone, with an empty home."""
    taken = []
    for run in range(runs):
        clone, home = folder / f"clone-{run}", folder / f"home-{run}"
        subprocess.run(["git", "clone", "--quiet", str(ROOT), str(clone)], check=True)
        home.mkdir()
        empty = {"HOME": str(home), "XDG_CACHE_HOME": str(home), "PYTHON": sys.executable}
        began = time.perf_counter()
        call = ["make", "solve"]
        subprocess.run(call, cwd=clone, check=True, capture_output=True, env=alone() | empty)
        taken.append(time.perf_counter() - began)
        shutil.rmtree(clone)
    return [f"| `make solve` in a fresh clone | {statistics.median(taken):.1f} s |"]


def cold(folder: Path, runs: int) -> list[str]:
    """A plan by ``auto`` with and without compiled kernels."""
    measured = []
    for run in range(runs):
        kept = folder / f"kept-{run}"
        here = sys.executable, kept, dict(os.environ)
        measured.append((first_plan(*here), first_plan(*here)))
    first, whole = (statistics.median(run[0][k] for run in measured) for k in range(2))
    warm_first, warm = (statistics.median(run[1][k] for run in measured) for k in range(2))
    ratio = statistics.median(run[0][1] / run[1][1] for run in measured)
    return [
        f"| first plan by `auto`, nothing compiled | {first:.1f} s |",
        f"| first plan by `auto`, all compiled | {warm_first:.1f} s |",
        f"| whole run, nothing compiled | {whole:.1f} s |",
        f"| whole run, all compiled | {warm:.1f} s |",
        f"| ratio of whole runs | {ratio:.1f} |",
    ]


def wheel(folder: Path, runs: int) -> list[str]:
    """A plan by ``auto`` from a wheel, in an environment of its own."""
    subprocess.run(
        [sys.executable, str(ROOT / "bench" / "wheel.py"), "--out", str(folder / "dist")],
        check=True,
        capture_output=True,
    )
    (made,) = (folder / "dist").glob("*.whl")
    subprocess.run([sys.executable, "-m", "venv", str(folder / "venv")], check=True)
    python = str(folder / "venv" / "bin" / "python")
    constraints = str(ROOT / "constraints.txt")
    install = [python, "-m", "pip", "install", "--quiet", "--constraint", constraints, str(made)]
    subprocess.run(install, check=True, env=alone())
    measured = [first_plan(python, folder / f"wheel-{run}", alone()) for run in range(runs)]
    first, whole, compiling = (statistics.median(run[k] for run in measured) for k in range(3))
    return [
        f"| first plan by `auto` from a wheel, empty cache | {first:.1f} s |",
        f"| whole run from a wheel, empty cache | {whole:.1f} s |",
        f"| of that compiling | {compiling:.1f} s |",
        f"| size of the wheel | {made.stat().st_size / 1e6:.1f} MB |",
    ]


def importing(folder: Path, runs: int) -> list[str]:
    """``import adr_opt`` in a process of its own."""
    taken = []
    for _ in range(3 * runs):
        began = time.perf_counter()
        subprocess.run([sys.executable, "-c", "import adr_opt"], check=True, cwd=folder)
        taken.append(time.perf_counter() - began)
    return [f"| `import adr_opt`, whole process | {statistics.median(taken):.2f} s |"]


ROWS: dict[str, Callable[[Path, int], list[str]]] = {
    "solve": make_solve,
    "cold": cold,
    "wheel": wheel,
    "import": importing,
}


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("rows", nargs="*", metavar="ROW", help=f"of {', '.join(ROWS)}; all")
    parser.add_argument("--runs", type=int, default=3, help="runs of each, of which the median")
    asked = parser.parse_args()
    unknown = sorted(set(asked.rows) - set(ROWS))
    if unknown:
        parser.error(f"no such row: {', '.join(unknown)}")
    print("| wait | time |\n|---|---|")
    for name in asked.rows or ROWS:
        folder = Path(tempfile.mkdtemp())
        try:
            print("\n".join(ROWS[name](folder, asked.runs)), flush=True)
        finally:
            shutil.rmtree(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
