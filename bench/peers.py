"""Side by side with the peers: PyVRP on a static relaxation, DIDPPy on a model in slots, and ours.

    python bench/peers.py --family nominal --count 4 --time-limit 10 --seed 0
    python bench/peers.py --instances instances/nominal/nominal-000.json --peers didppy

Same instances, time limit, seed and cores. Every clock starts with a ready timetable; building a
peer's model from it is not charged to the peer and is listed as "build". What a peer *promises* is
the number of targets that its own model visits; what it *keeps* is left of that when the plan is
timed exactly on the timetable and passes ``check``. Needs ``pip install -e '.[peers]'``.

How each peer is used is said in ``contest/pyvrp_static.py`` (``--static``) and
``contest/didppy_slots.py``.

**Timing** a peer's order exactly. "as it is": the legal beginning of its order, its own refuelling
stops included. "mended": the same order with and without its stops, with and without keeping the
way to the station open; a move that is not legal is made after a refuelling stop, or else left
out. The best of all these counts.
"""

from __future__ import annotations

import argparse
import sys

from contest.arguments import missions, parser_of, require_positive
from contest.didppy_slots import didppy_promise
from contest.promise import Promise, need, packages
from contest.pyvrp_static import pyvrp_promise, static_costs
from contest.table import Row, checked, legal, our_row, peer_rows, table
from machine import heading

import adr_opt
from adr_opt.errors import InputError
from adr_opt.mending import as_it_is, mended

__all__ = [
    "Promise", "Row", "as_it_is", "checked", "didppy_promise", "legal", "mended", "missions",
    "need", "our_row", "packages", "parser_of", "peer_rows", "pyvrp_promise", "require_positive",
    "static_costs", "table",
]  # fmt: skip

OURS = ("auto", "beam", "ortools")


def run(arguments: argparse.Namespace) -> None:
    """Measure and print the table."""
    require_positive(arguments)
    contests = []
    for name in arguments.peers:
        package, _, variant = name.partition("-")
        need(package)
        contests += [(package, one) for one in (arguments.static if name == "pyvrp" else [variant])]
    common = {"time_limit_s": arguments.time_limit, "seed": arguments.seed, "jobs": arguments.jobs}
    warm = adr_opt.Mission(adr_opt.generate("tiny", 0))
    for name in arguments.ours:  # compile before the clock starts
        adr_opt.solve(warm, name, time_limit=20.0, iterations=3)
    rows: list[Row] = []
    for mission in missions(arguments):
        mission.rules  # noqa: B018  builds the timetable
        for name in arguments.ours:
            rows.append(our_row(name, mission, **common))
        for name, variant in contests:
            rows += peer_rows(name, variant, mission, slot_s=arguments.slot, **common)
        for row in rows:
            if row.instance == mission.instance.name:
                what = f"{row.instance} {row.method}"
                print(f"{what}: {row.visits:g} of {row.promised:g} promised", file=sys.stderr)
    print(heading())
    print(
        f"{packages('pyvrp', 'didppy')}; time limit {arguments.time_limit:g} s, seed "
        f"{arguments.seed}, {arguments.jobs} core(s); instances "
        f"{', '.join(dict.fromkeys(row.instance for row in rows))}\n"
    )
    print(table(rows))


def main() -> int:
    """Command line; 2 if the call or the installation is wrong."""
    parser = parser_of(__doc__, 10.0)
    parser.add_argument(
        "--static",
        nargs="+",
        default=["mean", "best"],
        choices=["mean", "quartile", "best", "epoch"],
        help="what PyVRP's matrix is made of",
    )
    parser.add_argument(
        "--peers",
        nargs="*",
        default=["pyvrp", "didppy", "didppy-early"],
        choices=["pyvrp", "didppy", "didppy-early"],
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
