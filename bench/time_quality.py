"""Visits against time, the timetable included: every method with its widths and limits.

    python bench/time_quality.py --cases 5 --out R        # plan, then draw and print
    python bench/time_quality.py --out R --report-only    # draw and print what is there
    python bench/time_quality.py --draw                   # draw the committed table again

Plans fields of a suite without zones by `run_all.py`, one process at a time, so that it goes on
where it was; writes docs/pictures/time-quality.svg and the table that it is drawn from,
bench/curves/time-quality.csv, and prints the table. Times are medians of processor time: of the
timetable on one core, and of planning with a timetable of its own for each method. Exit status as
of `run_all.py`.
"""

from __future__ import annotations

import math
import os
import sys
from pathlib import Path

import run_all
from harness.report.model import read
from harness.report.quality import draw as draw_spots
from harness.report.quality import read_table, spots, write_table
from harness.results import path_in
from tables import experiment, head, row

from adr_opt.common.errors import InputError

ROOT = Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs" / "pictures" / "time-quality.svg"
TABLE = ROOT / "bench" / "curves" / "time-quality.csv"

METHODS = (
    "greedy@10",
    "greedy-guarded@10",
    "beam:width=10@60",
    "beam:width=100@60",
    "beam:width=1000@60",
    "beam:width=10000@60",
    "mcts@60",
    "mcts:simulations=2000@60",
    "mcts:simulations=20000@60",
    "mcts:preset=tuned@60",
    "local-search@0.3",
    "local-search@1",
    "local-search@3",
    "local-search@10",
    "auto@0.5",
    "auto@1",
    "auto@3",
    "auto@10",
    "ortools@1",
    "ortools@3",
    "ortools@10",
    "ppo@10",
    "ppo:decode=sample@10",
    "ppo:decode=beam@10",
    "exact@120",
)


def curves(
    suite: str = "nominal",
    cases: int = 5,
    methods: str = ",".join(METHODS),
    out: Path | None = None,
    report_only: bool = False,
    draw: bool = False,
    picture: Path = PICTURE,
    table: Path = TABLE,
) -> int:
    """Plan what is missing, draw, and print; with ``--draw`` draw the committed table again."""
    status = 0
    if not draw:
        if out is None:
            raise InputError("say with --out where rows are kept, or --draw")
        if not report_only:
            words = f"--suite {suite} --cases {cases} --iterations 1 --zones 0 --jobs 1 --no-report"
            status = run_all.main([*words.split(), "--methods", methods, "--out", str(out)])
            if status == run_all.WRONG:
                return status
        rows = read(path_in(out, create=False))
        (section,) = [each for each in rows.sections if (each.suite, each.zones) == (suite, 0)]
        write_table(spots(section), table)
    found = read_table(table)
    count = max(spot.fields for spot in found)
    draw_spots(found, picture, f"{suite}, {count} fields, no keep-out zones, one core")
    head("method", "fields", "visits, mean ± 95 %", "proven", "time of processors", "by the clock")
    for spot in found:
        half = "" if math.isnan(spot.half_width) else f" ± {spot.half_width:.2f}"
        seconds = f"{spot.seconds:.3g} s", f"{spot.wall_s:.3g} s"
        row(f"`{spot.method}`", spot.fields, f"{spot.visits:.2f}{half}", spot.proven, *seconds)
    if not draw and hasattr(os, "getloadavg"):
        print(f"\nProcesses that wanted to run at the end: {os.getloadavg()[0]:.1f}.")
    return status


if __name__ == "__main__":
    sys.exit(experiment(__doc__, curves))
