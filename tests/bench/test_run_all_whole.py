"""The benchmark as a whole, with planners that are wrong.

That a run goes on after a kill, has one writer, ends by Ctrl-C and runs on a cluster is that of
every study (tests/study).
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from html import escape
from pathlib import Path

import pytest

for package in ("matplotlib", "plotly", "scipy"):
    pytest.importorskip(package)

SCRIPT = Path(__file__).parents[2] / "bench" / "run_all.py"
PATIENCE_S = 400.0

# Planners as a third party would install them.
PLANNERS = """
import os, signal
from adr_opt.run.methods import get
from adr_opt.mission.certified import certify

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
    if mission.instance.name.startswith("tiny-001"):
        os.kill(os.getpid(), signal.SIGKILL)
    return get("greedy")(mission, seed=seed, stop=stop, progress=progress)
"""

NAMES = ("raises", "forgets", "breaks", "lies", "deadly")


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
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}


@pytest.mark.slow
def test_planners_that_raise_lie_or_kill_do_not_end_the_run(
    tmp_path: Path, environment: dict[str, str]
) -> None:
    """Their rows say so, all others are there, the report names them, the exit status is 1."""
    out = tmp_path / "out"
    methods = "deadly,greedy,raises,forgets,breaks,lies,beam:width=50"
    asked = f"--suite tiny --cases 3 --iterations 1 --methods {methods} --jobs 2"
    run = subprocess.run(
        [
            *(sys.executable, str(SCRIPT), "--out", str(out), *asked.split()),
            *("--bound", "lagrangian", "--bound-time-limit", "5"),
        ],
        env=environment,
        text=True,
        capture_output=True,
        timeout=PATIENCE_S,
        check=False,
    )
    assert run.returncode == 1
    lines = (out / "results.jsonl").read_text(encoding="utf-8").splitlines()[1:]
    rows = [(each["key"], each["value"]) for each in map(json.loads, lines)]
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
        assert sentence in run.stderr
    for wrong in ("raises", "forgets", "breaks"):
        assert f"{wrong}: fails on the practice mission tiny-000-z2 (" in run.stderr
