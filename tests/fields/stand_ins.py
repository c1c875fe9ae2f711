"""Methods for the command line to call that show how they were called."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

METHODS = '''
"""Methods that show how they were called."""

import math
import time
from pathlib import Path

from adr_opt.mission.certified import certify
from adr_opt.mission.result import Result


def starter(mission, *, seed, stop, progress, start=None):
    """Return the start plan.

    And nothing else."""
    return certify(mission, "starter", start or (), seed=seed, runtime_s=0.0)


def worker(mission, *, seed, stop, progress, jobs=1, depth=3, fast=False, word="a", limit=math.inf):
    """Count the questions it may ask, up to 100."""
    count = 0
    while count < 100 and not stop(0.0, math.inf):
        count += 1
    counters = {"jobs": jobs, "depth": depth, "fast": fast, "asked": count}
    return certify(
        mission, "worker", (), seed=seed, runtime_s=0.0, counters=counters,
        notes=[f"jobs {jobs} depth {depth} fast {fast} word {word} asked {count}"],
    )


def hopeless(mission, *, seed, stop, progress):
    """Find nothing."""
    return certify(mission, "hopeless", None, seed=seed, runtime_s=0.0)


def patient(mission, *, seed, stop, progress):
    """Wait until it is told to stop, then return one visit."""
    progress(1.0, 4.0)
    if mission.instance.name == "tiny-000":  # and not the one that it practises on
        Path("started").touch()
    while not stop(1.0, 4.0):
        time.sleep(0.01)
    return certify(mission, "patient", (1,), seed=seed, runtime_s=0.0, upper_bound=4.0)


def deaf(mission, *, seed, stop, progress):
    """Never ask."""
    Path("started").touch()
    time.sleep(600.0)


def lid(mission, *, seed, stop, progress, start=None):
    """Bound by the number of targets."""
    bound = math.inf if mission.total_prize == 3.0 else mission.total_prize
    return Result(
        "lid", None, None, -math.inf, bound, "unknown", {"start": len(start or ())}, seed, 0.5
    )
'''


def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The methods above, installed as a package would be; returns the folder to import from."""
    home = tmp_path / "installed"
    metadata = home / "show_methods-1.0.dist-info"
    metadata.mkdir(parents=True)
    (home / "show_methods.py").write_text(METHODS, encoding="utf-8")
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: show-methods\nVersion: 1.0\n")
    planners = ("starter", "worker", "hopeless", "patient", "deaf", "absent")
    lines = ["[adr_opt.planners]", *(f"{name} = show_methods:{name}" for name in planners)]
    lines += ["[adr_opt.bounds]", "lid = show_methods:lid"]
    (metadata / "entry_points.txt").write_text("\n".join(lines) + "\n")
    monkeypatch.syspath_prepend(str(home))
    monkeypatch.setenv("PYTHONPATH", str(home), prepend=os.pathsep)
    sys.modules.pop("show_methods", None)
    return home
