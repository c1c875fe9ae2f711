"""Side by side with the peers: PyVRP on a static relaxation, DIDPPy on a model in slots, and ours.

    python bench/peers.py --family nominal --count 4 --time-limit 10 --seed 0
    python bench/peers.py --instances instances/nominal/nominal-000.json --peers didppy
    python bench/peers.py --family campaign --count 5 --time-limit 60

Same instances, time limit, seed and cores. Every clock starts with a ready timetable; building a
peer's model from it is not charged to the peer and is listed as "build". What a peer *promises* is
the number of targets that its own model visits; what it *keeps* is left of that when the plan is
timed exactly on the timetable and passes ``check``. Needs ``pip install -e '.[peers]'``.

How each peer is used is said in ``contest/pyvrp_static.py`` and ``contest/ortools_static.py``,
whose matrix is made of what ``--static`` says, and in ``contest/didppy_slots.py``.

**Timing** a peer's order exactly. "as it is": the legal beginning of its order, its own refuelling
stops included. "mended": the same order with and without its stops, with and without keeping the
way to the station open; a move that is not legal is made after a refuelling stop, or else left
out. The best of all these counts.

**Several chasers** (family ``campaign``) are the vehicles of PyVRP and of OR-Tools' routing; what
plans for one chaser is left out. Each one's order is timed by itself, and *gap* is how far a plan
is from the best bound there is, of ``instances/best-known.csv`` or proven by one of our methods.
"""

from __future__ import annotations

import argparse
import sys

from contest.arguments import missions, parser_of, problems, require_positive
from contest.didppy_slots import didppy_promise
from contest.ortools_static import ortools_promise
from contest.promise import Promise, need, packages
from contest.pyvrp_static import pyvrp_promise
from contest.static import STATISTICS, static_costs
from contest.table import (
    STATIC,
    Row,
    best_bounds,
    checked,
    legal,
    legal_routes,
    our_row,
    peer_rows,
    table,
    timed,
)
from machine import heading

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.mission.order_repair import as_it_is, mended
from adr_opt.mission.problem import problem_of
from adr_opt.run.methods import spec

__all__ = [
    "Promise",
    "Row",
    "as_it_is",
    "best_bounds",
    "checked",
    "didppy_promise",
    "legal",
    "legal_routes",
    "mended",
    "missions",
    "need",
    "ortools_promise",
    "our_row",
    "packages",
    "parser_of",
    "peer_rows",
    "pyvrp_promise",
    "require_positive",
    "static_costs",
    "table",
    "timed",
]

OURS = ("auto", "beam", "ortools")
OTHERS = ("pyvrp", "didppy", "didppy-early")
OF_CAMPAIGNS = ("pyvrp", "ortools")
"""Peers by default, for one chaser and for several."""


def able(ours: list[str], peers: list[str] | None, several: bool) -> tuple[list[str], list[str]]:
    """Our methods and the peers to compare; where there are several chasers, those that can."""
    if peers is None:
        peers = list(OF_CAMPAIGNS if several else OTHERS)
    if not several:
        return ours, peers
    ours_able = [name for name in ours if spec(name).several]
    peers_able = [name for name in peers if name in STATIC]
    left_out = [name for name in [*ours, *peers] if name not in {*ours_able, *peers_able}]
    if left_out:
        print(f"for one chaser, left out: {', '.join(left_out)}", file=sys.stderr)
    return ours_able, peers_able


def run(arguments: argparse.Namespace) -> None:
    """Measure and print the table."""
    require_positive(arguments)
    fields = problems(arguments)
    several = any(len(problem.missions) > 1 for problem in fields)
    ours, others = able(arguments.ours, arguments.peers, several)
    contests = []
    for name in others:
        package, _, variant = name.partition("-")
        need(package)
        contests += [(package, one) for one in (arguments.static if name in STATIC else [variant])]
    common = {"time_limit_s": arguments.time_limit, "seed": arguments.seed, "jobs": arguments.jobs}
    warm = problem_of(adr_opt.generate("tiny", 0, chasers=2 if several else 1))
    for name in ours:  # compile before the clock starts
        adr_opt.solve(warm, name, time_limit=20.0, iterations=3)
    rows: list[Row] = []
    for problem in fields:
        for mission in problem.missions:
            mission.rules  # noqa: B018  builds the timetable
        for name in ours:
            rows.append(our_row(name, problem, **common))
        for name, variant in contests:
            rows += peer_rows(name, variant, problem, slot_s=arguments.slot, **common)
        for row in rows:
            if row.instance == problem.instance.name:
                what = f"{row.instance} {row.method}"
                print(f"{what}: {row.visits:g} of {row.promised:g} promised", file=sys.stderr)
    print(heading())
    packaged = dict.fromkeys(package for package, _ in contests)
    print(
        f"{packages(*packaged)}; time limit {arguments.time_limit:g} s, seed "
        f"{arguments.seed}, {arguments.jobs} core(s); instances "
        f"{', '.join(dict.fromkeys(row.instance for row in rows))}\n"
    )
    print(table(rows, best_bounds(rows, fields) if several else None))


def main() -> int:
    """Command line; 2 if the call or the installation is wrong."""
    parser = parser_of(__doc__, 10.0)
    parser.add_argument(
        "--static",
        nargs="+",
        default=["mean", "best"],
        choices=STATISTICS,
        help="what the matrix of PyVRP, and of OR-Tools, is made of",
    )
    parser.add_argument(
        "--peers",
        nargs="*",
        choices=["pyvrp", "ortools", "didppy", "didppy-early"],
        help=f"by default {', '.join(OTHERS)}; of several chasers {', '.join(OF_CAMPAIGNS)}",
    )
    parser.add_argument("--ours", nargs="*", default=list(OURS))
    try:
        run(parser.parse_args())
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
