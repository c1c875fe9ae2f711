"""Build the wheel and the sdist; the wheel holds an archive of compiled kernels.

    python bench/wheel.py --out dist
    python bench/wheel.py --archive kernels.zip                      the archive alone
    python bench/wheel.py --archive kernels.zip --methods beam       with the kernels of a method

Kernels are compiled for the processors of :data:`adr_opt.kernels.core.archive.LEVEL` by planning
small missions with all methods and by calling all verbs. They are kept in the user's folder like
others, so that a second build compiles nothing. Needs ``pip install -e '.[test]'``.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from adr_opt.common.processors import usable_cores

ROOT = Path(__file__).resolve().parents[1]

FIELDS = {
    "field": "generate reduced-time --seed 0 --targets 12 --out field.json",
    "drifting": "generate rocket-bodies --seed 0 --targets 6 --out drifting.json",
    "campaign": "generate campaign --seed 0 --targets 8 --out campaign.json",
    "removal": "generate removal --seed 0 --targets 4 --out removal.json",
    "electric": "generate electric --seed 3 --targets 6 --chasers 1 --out electric.json",
    "thrusting": f"import {ROOT}/examples/catalogue/cloud.tle --thrust 0.2 --dry-mass 400 "
    "--propellant 60 --isp 1500 --duration-days 180 --max-targets 4 --out thrusting.json",
}
"""Small missions of six kinds."""

VERBS = (
    "solve {}.json --time-limit 600 --bound exact --out plan.json --certificate proof.json",
    "check {}.json plan.json",
    "verify {}.json plan.json proof.json",
    "replan {}.json plan.json --at 1 --time-limit 2 --out rest.json",
    "tradeoff {}.json --vary duration=1:2:1 --time-limit 2 --out curve.csv",
)
"""Verbs that call kernels. Each plan is proven, long before its limit, for the certificate."""

FLOWN = ("fly {}.json plan.json",)

ONE_CHASER = (
    *FLOWN,
    "refine {}.json plan.json --out refined.json",
    "fly {}.json refined.json --samples 3",
    "price {}.json debris-001 debris-002",
    "matrix {}.json --every 43200 --out costs.npz",
    "export {}.json plan.json --out mission.oem",
)

OTHERS = {
    "field": ONE_CHASER,
    "drifting": ONE_CHASER,
    "campaign": FLOWN,
    "removal": FLOWN,
    "electric": (),
    "thrusting": (
        "refine {}.json plan.json --out refined.json",
        "fly {}.json refined.json",
        "export {}.json refined.json --out mission.oem",
    ),
}
"""Verbs that not all of the missions are for."""


def main() -> int:
    """Build."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--out", type=Path, help="folder for wheel and sdist")
    parser.add_argument("--archive", type=Path, help="file for the archive")
    parser.add_argument("--methods", nargs="+", help="compile for these alone, and for no verb")
    asked = parser.parse_args()
    _compile_for_all()
    from adr_opt.kernels.core import archive

    kernels = compiled(asked.methods)
    made = asked.archive or archive.FILE
    archive.write(kernels, made)
    print(f"{len(kernels)} kernels, {made.stat().st_size / 1e6:.1f} MB: {made}")
    if asked.out is not None:
        build = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(asked.out)]
        try:
            subprocess.run([*build, str(ROOT)], check=True)
        finally:  # in a checkout, kernels change and are compiled as they do
            archive.FILE.unlink(missing_ok=True)
    return 0


def _compile_for_all() -> None:
    """Begin anew as a process that compiles for other machines too, if this one does not."""
    from adr_opt.kernels.core import archive

    if not archive.serves_this_processor():
        raise SystemExit(f"this machine is not of level {archive.LEVEL}; build on one that is")
    wanted = {"NUMBA_CPU_NAME": archive.LEVEL, "NUMBA_CPU_FEATURES": ""}
    if any(os.environ.get(name) != value for name, value in wanted.items()):
        os.execve(sys.executable, [sys.executable, *sys.argv], os.environ | wanted)


def compiled(methods: list[str] | None) -> dict[str, bytes]:
    """Kernels of methods, or of all methods and verbs, by the names of their files."""
    from adr_opt.kernels.core import cache
    from adr_opt.run.methods import BOUNDS, PLANNERS, names
    from adr_opt.ui.cli.warm_up import ENVIRONMENT, compile_for

    everything = list(dict.fromkeys((*names(PLANNERS), *names(BOUNDS), ENVIRONMENT)))
    rows = compile_for(methods or everything, usable_cores())
    for row in rows:
        if row["problem"]:
            print(f"{row['method']}: {row['problem']}")
    files: set[Path] = set().union(*(row["files"] for row in rows))
    if methods is None:
        spawn = get_context("spawn")
        with ProcessPoolExecutor(usable_cores(), spawn, max_tasks_per_child=1) as pool:
            files.update(*pool.map(run_verbs, FIELDS))
    found = {file.name: cache.read(file) for file in files}
    return {name: content for name, content in found.items() if content is not None}


def run_verbs(field: str) -> set[Path]:
    """Call all verbs for a mission; files of the kernels that were called."""
    from adr_opt.kernels.core import cache
    from adr_opt.ui.cli.entry import main as adr_opt

    folder = Path(tempfile.mkdtemp())
    try:
        os.chdir(folder)
        verbs = (*VERBS, *OTHERS[field])
        for line in (FIELDS[field], *(verb.format(field) for verb in verbs)):
            if adr_opt(line.split()) == 2:
                raise SystemExit(f"{line}: exit status 2")
        return cache.used()
    finally:
        os.chdir(ROOT)
        shutil.rmtree(folder)


if __name__ == "__main__":
    sys.exit(main())
