"""Drawn orienteering with time windows: plans and proofs against the best known.

    python bench/windows.py --count 2 --limits 6 60
    python bench/windows.py --count 8 --limits 60 --pyvrp 20 --rows R/windows.csv

Draws ``--count`` instances of each of four kinds (``contest/orienteering.py``) and plans each by
``--method`` within each limit. The best known prizes of an instance are the largest of all that
were found here, by PyVRP too, and kept in the table of ``--keep``. Every plan passes ``check`` and
is scored again by the tour alone. Rows that the table of ``--rows`` has are not planned again, so
that a run that was broken off goes on where it was.
"""

from __future__ import annotations

import argparse
import csv
import math
import statistics
from pathlib import Path
from typing import NamedTuple

from contest.orienteering import KINDS, Places, by_pyvrp, collected, draw, instance_of
from machine import heading

import adr_opt
from adr_opt.common.files import write_text

TABLE = Path(__file__).parent / "curves" / "windows.csv"


class Planned(NamedTuple):
    """A plan and a proof.

    Attributes
    ----------
    prizes, bound : float
    proven : bool
    time_s : float
    """

    prizes: float
    bound: float
    proven: bool
    time_s: float


def planned(places: Places, method: str, limit_s: float) -> Planned:
    """Plan within a limit."""
    instance = instance_of(places)
    result = adr_opt.solve(instance, method, time_limit=limit_s)
    if result.plan is None:
        return Planned(0.0, result.upper_bound, False, result.runtime_s)
    assert adr_opt.check(instance, result.plan) == ()
    tour = [int(leg.destination[6:]) for leg in result.plan.legs if leg.destination[0] == "p"]
    prizes = float(collected(places, tour))
    assert prizes == result.objective
    return Planned(prizes, result.upper_bound, result.status == "optimal", result.runtime_s)


def read_best(path: Path) -> dict[str, float]:
    """Best known prizes by instance; none if there is no table."""
    if not path.exists():
        return {}
    with path.open(encoding="utf-8", newline="") as file:
        return {row["instance"]: float(row["prizes"]) for row in csv.DictReader(file)}


def write_best(path: Path, best: dict[str, float]) -> None:
    """Keep the best known prizes."""
    rows = [f"{name},{prizes:g}" for name, prizes in sorted(best.items())]
    write_text(path, "\n".join(["instance,prizes", *rows, ""]))


def read_rows(path: Path | None) -> dict[tuple[str, str, float], Planned]:
    """Rows by instance, method and limit; none if there is no table."""
    if path is None or not path.exists():
        return {}
    with path.open(encoding="utf-8", newline="") as file:
        return {
            (row["instance"], row["method"], float(row["limit_s"])): Planned(
                float(row["prizes"]),
                float(row["bound"]),
                row["proven"] == "yes",
                float(row["time_s"]),
            )
            for row in csv.DictReader(file)
        }


def add_row(path: Path | None, name: str, method: str, limit_s: float, one: Planned) -> None:
    """Append a row."""
    if path is None:
        return
    is_new = not path.exists()
    with path.open("a", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        if is_new:
            table.writerow(["instance", "method", "limit_s", *Planned._fields])
        table.writerow(
            [
                name,
                method,
                limit_s,
                one.prizes,
                one.bound,
                "yes" if one.proven else "no",
                round(one.time_s, 2),
            ]
        )


def main() -> None:
    """Plan, and print a table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--kinds", nargs="+", default=KINDS, choices=KINDS)
    parser.add_argument("--count", type=int, default=2, help="instances of each kind [2]")
    parser.add_argument("--first-seed", type=int, default=0, help="seed of the first of them [0]")
    parser.add_argument("--places", type=int, default=100, help="with prizes [100]")
    parser.add_argument("--limits", type=float, nargs="+", default=[60.0], help="seconds [60]")
    parser.add_argument("--method", default="auto", help="as `solve` takes it [auto]")
    parser.add_argument("--pyvrp", type=float, help="seconds of PyVRP for each instance")
    parser.add_argument("--rows", type=Path, help="table of what was planned, to go on with")
    parser.add_argument("--keep", type=Path, default=TABLE, help="table of the best known")
    given = parser.parse_args()
    print(heading())
    best, rows_before = read_best(given.keep), read_rows(given.rows)
    head = ["instance", "best known", *(["PyVRP"] if given.pyvrp else [])]
    head += [f"{given.method}, {limit:g} s" for limit in given.limits]
    print("| " + " | ".join(head) + " |\n|" + "---|" * len(head), flush=True)
    found: dict[float, list[tuple[str, Planned]]] = {limit: [] for limit in given.limits}
    for kind in given.kinds:
        for seed in range(given.first_seed, given.first_seed + given.count):
            places = draw(kind, seed, given.places)
            name = f"{places.name}-{given.places}"
            cells = []
            if given.pyvrp:
                asked = (name, "pyvrp", given.pyvrp)
                if asked not in rows_before:
                    reached = float(by_pyvrp(places, given.pyvrp))
                    rows_before[asked] = Planned(reached, math.inf, False, given.pyvrp)
                    add_row(given.rows, *asked, rows_before[asked])
                others = rows_before[asked].prizes
                best[name] = max(best.get(name, 0.0), others)
                cells.append(f"{others:g}")
            for limit in given.limits:
                asked = (name, given.method, limit)
                if asked not in rows_before:
                    rows_before[asked] = planned(places, given.method, limit)
                    add_row(given.rows, *asked, rows_before[asked])
                one = rows_before[asked]
                found[limit].append((name, one))
                best[name] = max(best.get(name, 0.0), one.prizes)
                bound = "proven" if one.proven else f"≤ {one.bound:.0f}"
                cells.append(f"{one.prizes:g}, {bound}, {one.time_s:.1f} s")
            print("| " + " | ".join([name, f"{best[name]:g}", *cells]) + " |", flush=True)
            write_best(given.keep, best)
    for limit, rows in found.items():
        behind = [100.0 * (1.0 - one.prizes / best[name]) for name, one in rows]
        proven = sum(one.proven for _, one in rows)
        print(
            f"\n{given.method}, {limit:g} s: behind the best known by "
            f"{statistics.mean(behind):.2f} % in the mean and {max(behind):.1f} % at most, "
            f"{proven} of {len(rows)} proven"
        )


if __name__ == "__main__":
    main()
