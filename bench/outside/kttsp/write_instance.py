"""Writes an instance over a sampled table of Lambert arcs, of a file or of a drawn field.

    python bench/outside/kttsp/write_instance.py OUT.json --field small.kttsp --end 116
    python bench/outside/kttsp/write_instance.py OUT.json --draw 181 --seed 1 --end 240
    python bench/outside/kttsp/write_instance.py OUT.json --field FILE --end 116 --near PLAN.json

The connections are written beside it, as OUT.parquet. With --near departures are sampled near those
of a plan of such an instance alone, on finer grids. --score PLAN.json says what a plan comes to by
the rules of the contest, as it is and flown in continuous time, and writes nothing; --tour FILE
keeps the better of them as it is submitted.
Exit status 0: done; 2: the call or a file is wrong, in one sentence.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

# This script lies in the package that it runs.
sys.path.insert(0, str(Path(__file__).parents[2]))

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.common.files import check_writable
from outside.kttsp.drawing import drawn
from outside.kttsp.instances import instance_of, tour_of_plan
from outside.kttsp.known import write_tour
from outside.kttsp.ours import flown, kinds_of, visits_d
from outside.kttsp.reading import Problem, Tour, read_problem
from outside.kttsp.sampling import Grid, sampled
from outside.kttsp.scoring import score

DONE, WRONG = 0, 2


def problem_of(parsed: argparse.Namespace) -> Problem:
    """The field of the call."""
    if (parsed.field is None) == (parsed.draw is None):
        raise InputError("give --field FILE or --draw TARGETS, one of the two")
    if parsed.field is not None:
        return read_problem(parsed.field)
    if parsed.draw < 2:
        raise InputError(f"--draw {parsed.draw}: give 2 targets or more")
    return drawn(parsed.draw, parsed.seed)


def tour_in(path: Path, problem: Problem) -> Tour:
    """The tour of a plan file.

    Raises
    ------
    InputError
        The plan is of another field.
    """
    plan = adr_opt.Plan.load(path)
    try:
        tour = tour_of_plan(problem, plan)
    except (KeyError, IndexError):
        raise InputError(
            f"{path}: no plan of this field; give one that solve has written"
        ) from None
    if tour.order.size != problem.targets:
        raise InputError(f"{path}: {tour.order.size} of {problem.targets} targets; give a tour")
    return tour


def said(problem: Problem, name: str, tour: Tour) -> float:
    """Print a tour by the rules of the contest; its duration, infinite if it breaks one [d]."""
    found = score(problem, tour)
    print(
        f"{name}: {found.duration_d:.4f} d, {found.exceptions} exceptions, "
        f"{len(found.violations)} rules broken",
        *found.violations[:3], sep="\n  ",
    )  # fmt: skip
    return float("inf") if found.violations else found.duration_d


def scored(problem: Problem, path: Path, keep: Path | None) -> None:
    """Score a plan as it is, and flown."""
    tour = tour_in(path, problem)
    again = flown(problem, tour.order, kinds_of(problem, tour))
    durations = said(problem, "as planned", tour), said(problem, "flown", again)
    if keep is not None:
        write_tour(keep, problem, tour if durations[0] <= durations[1] else again)


def write(problem: Problem, parsed: argparse.Namespace) -> None:
    """Sample the table and write the instance."""
    out = parsed.out
    if out is None or out.suffix != ".json":
        raise InputError(f"{out}: name a .json file for the instance")
    check_writable(out)
    end_d = problem.longest_d if parsed.end is None else parsed.end
    grid = Grid(
        end_d, tuple(parsed.step), tuple(parsed.arrival), tuple(parsed.flight),
        tuple(parsed.nearest),
    )  # fmt: skip
    near = None if parsed.near is None else visits_d(problem, tour_in(parsed.near, problem))
    began, processor = time.perf_counter(), time.process_time()
    rows = sampled(problem, grid, visits_d=near, within_d=parsed.within, jobs=parsed.jobs)
    taken = time.perf_counter() - began, time.process_time() - processor
    file = out.with_suffix(".parquet").name
    instance = instance_of(problem, rows, file)
    instance.save(out)
    given = instance.given
    assert given is not None
    columns = given.origin, given.destination, given.departure, given.arrival, given.cost
    held = sum(column.nbytes for column in columns) + rows.exception.nbytes
    print(
        f"{out}: {problem.targets} targets, {given.departure.size:,} connections, "
        f"{rows.exception.sum():,} of them exceptions; {held / 1e6:.0f} MB in memory, "
        f"{out.with_suffix('.parquet').stat().st_size / 1e6:.0f} MB in {file}; sampled in "
        f"{taken[0]:.0f} s ({taken[1]:.0f} s of processors)"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("out", type=Path, nargs="?")
    parser.add_argument("--field", type=Path, metavar="FILE", help="a .kttsp file")
    parser.add_argument("--draw", type=int, metavar="TARGETS", help="draw a field instead")
    parser.add_argument("--seed", type=int, default=0, help="of the drawing")
    parser.add_argument("--end", type=float, help="last departure [d]")
    pair: dict[str, Any] = {"type": float, "nargs": 2, "metavar": ("USUAL", "EXCEPTIONS")}
    defaults = Grid(0.0)
    parser.add_argument("--step", **pair, default=defaults.step_d, help="of departures [d]")
    parser.add_argument("--arrival", **pair, default=defaults.arrival_d, help="of arrivals [d]")
    parser.add_argument("--flight", **pair, default=defaults.flight_d, help="longest [d]")
    parser.add_argument(
        "--nearest", **(pair | {"type": int}), default=defaults.nearest,
        help="destinations of an origin; of exceptions, in each group",
    )  # fmt: skip
    parser.add_argument("--near", type=Path, metavar="PLAN", help="sample near its departures")
    parser.add_argument("--within", type=float, default=np.inf, help="how near [d]")
    parser.add_argument("--jobs", type=int, default=2, help="threads")
    parser.add_argument("--score", type=Path, metavar="PLAN", help="say what a plan comes to")
    parser.add_argument("--tour", type=Path, metavar="FILE", help="keep the scored tour")
    parsed = parser.parse_args(arguments)
    try:
        problem = problem_of(parsed)
        if parsed.score is not None:
            scored(problem, parsed.score, parsed.tour)
        else:
            write(problem, parsed)
    except InputError as error:
        print(error, file=sys.stderr)
        return WRONG
    return DONE


if __name__ == "__main__":
    sys.exit(main())
