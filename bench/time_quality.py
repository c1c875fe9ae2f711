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

import argparse
import math
import os
import sys
from pathlib import Path

import run_all
from harness.report.model import read
from harness.report.quality import Spot, draw, read_table, spots, write_table
from harness.results import path_in
from machine import heading

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
    "ppo:policy=set-transfer@10",
    "ppo:decode=sample@10",
    "ppo:decode=beam@10",
    "exact@120",
)


def lines(found: list[Spot]) -> list[str]:
    """The table of the chart."""
    out = [
        "| method | fields | visits, mean ± 95 % | proven | time of processors | by the clock |",
        "|---|---|---|---|---|---|",
    ]
    for spot in found:
        half = "" if math.isnan(spot.half_width) else f" ± {spot.half_width:.2f}"
        out.append(
            f"| `{spot.method}` | {spot.fields} | {spot.visits:.2f}{half} | {spot.proven} | "
            f"{spot.seconds:.3g} s | {spot.wall_s:.3g} s |"
        )
    return out


def main() -> int:
    """Plan what is missing, draw, and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--suite", default="nominal", help="a family [nominal]")
    parser.add_argument("--cases", type=int, default=5, help="fields, by seed from 0 [5]")
    parser.add_argument("--methods", default=",".join(METHODS), help="as run_all.py takes them")
    parser.add_argument("--out", type=Path, help="folder of the rows")
    parser.add_argument("--report-only", action="store_true", help="plan nothing")
    parser.add_argument("--draw", action="store_true", help="draw the committed table again")
    parser.add_argument("--picture", type=Path, default=PICTURE)
    parser.add_argument("--table", type=Path, default=TABLE)
    arguments = parser.parse_args()
    status, suite = 0, arguments.suite
    if not arguments.draw:
        if arguments.out is None:
            parser.error("say with --out where rows are kept, or --draw")
        if not arguments.report_only:
            status = run_all.main(
                [
                    "--suite",
                    suite,
                    "--cases",
                    str(arguments.cases),
                    "--iterations",
                    "1",
                    "--zones",
                    "0",
                    "--jobs",
                    "1",
                    "--methods",
                    arguments.methods,
                    "--no-report",
                    "--out",
                    str(arguments.out),
                ]
            )
            if status == run_all.WRONG:
                return status
        found = read(path_in(arguments.out, create=False))
        (section,) = [each for each in found.sections if (each.suite, each.zones) == (suite, 0)]
        write_table(spots(section), arguments.table)
    found = read_table(arguments.table)
    count = max(spot.fields for spot in found)
    draw(found, arguments.picture, f"{suite}, {count} fields, no keep-out zones, one core")
    print(heading())
    print("\n".join(lines(found)))
    if not arguments.draw and hasattr(os, "getloadavg"):
        print(f"\nProcesses that wanted to run at the end: {os.getloadavg()[0]:.1f}.")
    return status


if __name__ == "__main__":
    sys.exit(main())
