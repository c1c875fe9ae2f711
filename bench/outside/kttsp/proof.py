"""What no tour falls below, by arrivals before which provably nobody arrives.

A time at which somebody may be ready lies in a cell of departures, and no leg that leaves in it or
later arrives before a time that :mod:`.cells` proves for continuous departures and flights. The
least duration over all tours with such arrivals (:mod:`solvers.tours.earliest`, which keeps all
states) is at most that of every real one. Cells that matter to tours which would be shorter than a
known one are then looked at in ever smaller parts, and where that is slow, those that the earliest
tour itself needs in far smaller ones: what stands in the way is mostly one leg that costs hardly
more than it may. If in the end there is no such tour, the known one is optimal but for what it was
asked to be beaten by.
"""

from __future__ import annotations

import hashlib
import math
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError
from solvers.tours.earliest import Arrivals, Found, earliest_tour, near_of
from solvers.tours.earliest_arrivals import wanted_by

from ..reading import FloatArray
from . import boxes, cells, costs, kepler, lambert, spans
from .cells import first_arrivals
from .reading import Problem
from .sampling import Leg, legs_of, limit_m_s
from .spans import normal_of

STEP_D = 0.01
"""Of departures."""

WIDEST = 5
"""The longest spans of arrivals are 2^5 steps."""

FLIGHT_D = 10.0
"""Longer flights count as possible."""

DEPTHS = 3, 5
"""Cells that matter are cut into 2^n parts of a step, at first and at last."""

DEEP = 9
"""Those that the earliest tour needs are, where this gains little."""

AHEAD_D = 1.8
"""Tours that end so much later than those at the earliest are looked at in a round."""

WIDER = 2.0
"""The same, as a multiple of itself, for a round after one that has found none."""

CLOSE_D = 0.25
"""The same, for what is looked at along the earliest tour."""

SLOW_D = 0.15
"""Rounds are followed by those of smaller parts until they have gained so much together."""

LITTLE_D = 1e-4
"""Tours that are shorter by less are not looked for: states are compared with so much to spare."""


class Bound(NamedTuple):
    """What was proven.

    Attributes
    ----------
    duration_d : float
        No tour is shorter.
    rounds : int
        Of this proof and of those whose cells it went on from.
    time_s : float
        Of this one.
    processor_s : float
        Of all of them.
    """

    duration_d: float
    rounds: int
    time_s: float
    processor_s: float


def raised(
    problem: Problem, leg: Leg, first: int, last: int, depth: int, wanted_d: FloatArray,
    arrival_d: FloatArray,
) -> None:  # fmt: skip
    """Look at some cells of a leg in parts, and raise their arrivals.

    Parameters
    ----------
    problem : Problem
    leg : tuple of int
        Kind, origin and destination.
    first, last : int
        From the first cell to before the last.
    depth : int
    wanted_d : (cells,) float64
        Later arrivals need not be proven [d].
    arrival_d : (cells,) float64
        Is raised [d].
    """
    kind, i, j = leg
    one, other = problem.elements[i], problem.elements[j]
    normals = normal_of(one), normal_of(other)
    between = math.atan2(
        float(np.linalg.norm(np.cross(*normals))), float(np.dot(*normals))
    )  # of small angles the arc cosine knows little
    out = arrival_d * DAY_S
    first_arrivals(
        one, other, *normals, between, STEP_D * DAY_S, WIDEST, depth,
        problem.least_flight_d * DAY_S, FLIGHT_D * DAY_S, limit_m_s(problem, kind), first, last,
        wanted_d * DAY_S, out,
    )  # fmt: skip
    # Days are rounded from seconds; nobody arrives that much earlier.
    arrival_d[first:last] = np.maximum(arrival_d[first:last], out[first:last] / DAY_S - 1e-9)


def all_legs(problem: Problem, end_d: float) -> tuple[Arrivals, list[Leg]]:
    """Arrivals of all legs before anything is proven, and the legs: the shortest flight."""
    legs = legs_of(problem)
    row = np.full((2, problem.targets, problem.targets), -1, dtype=np.int64)
    for place, leg in enumerate(legs):
        row[leg] = place
    trivial = np.arange(int(end_d / STEP_D)) * STEP_D + problem.least_flight_d - 1e-9
    arrival = np.tile(trivial, (len(legs), 1))
    return Arrivals(STEP_D, row, arrival, near_of(row[0] >= 0), problem.exceptions, False), legs


def first_cells(problem: Problem, end_d: float, jobs: int) -> tuple[Arrivals, list[Leg]]:
    """The same, by cells that are not cut."""
    arrivals, legs = all_legs(problem, end_d)
    count = arrivals.arrival.shape[1]
    wanted = np.full(count, np.inf)

    def fill(place: int) -> None:
        raised(problem, legs[place], 0, count, 0, wanted, arrivals.arrival[place])

    with ThreadPoolExecutor(jobs) as threads:
        list(threads.map(fill, range(len(legs))))
    return arrivals, legs


def along(
    arrivals: Arrivals, found: Found, begin_d: float, wanted: FloatArray
) -> dict[int, list[tuple[int, int]]]:
    """The cells of each row that a tour waits or leaves in, as long as arrivals matter."""
    windows, time_d = {}, begin_d
    for origin, destination, exceptional in zip(
        found.order[:-1], found.order[1:], found.exceptional, strict=True
    ):
        row = int(arrivals.row[int(exceptional), origin, destination])
        first = int(time_d / STEP_D)
        time_d = max(float(arrivals.arrival[row, first]), time_d)
        matter = np.append(wanted[row, first:] > -np.inf, False)
        windows[row] = [(first, first + int(np.argmin(matter)))]
    return windows


def windows_of(marks: npt.NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """First places of runs of what is true, and those after their last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], marks, [False]]).astype(np.int8)))
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        yield int(first), int(last)


def rounds_of(
    problem: Problem, shorter_d: float, jobs: int, arrivals: Arrivals, legs: list[Leg],
    proven: float,
) -> Iterator[float]:  # fmt: skip
    """What no tour falls below, round by round; ``shorter_d`` if there is provably none below it.

    Only tours that end little later than those of the last round at the earliest are looked at, so
    that few cells matter at a time.

    Parameters
    ----------
    problem : Problem
    shorter_d : float
        Only tours that end earlier are looked for.
    jobs : int
    arrivals, legs : Arrivals, list of tuple
        Of :func:`first_cells`; are raised.
    proven : float
        What no tour falls below, as far as is known.
    """
    depth, ahead, slow_from = DEPTHS[0], AHEAD_D, proven
    while proven < shorter_d:
        latest = min(proven + ahead, shorter_d)
        found = earliest_tour(arrivals, latest, begin=problem.begin_d)
        if not found.whole:
            return  # what was left out might have been shorter
        proven = min(found.end, latest)
        yield proven
        if not found.order:
            ahead *= WIDER
            continue
        ahead = AHEAD_D
        if proven - slow_from > SLOW_D:
            # What stood in the way is past: coarse cells, which are far less work, are enough
            # again.
            depth, slow_from = DEPTHS[0], proven
        deep = depth > DEPTHS[1]
        wanted = wanted_by(arrivals, found, min(latest, proven + (CLOSE_D if deep else AHEAD_D)))
        if deep:
            windows = along(arrivals, found, problem.begin_d, wanted)
        else:
            rows = np.flatnonzero(wanted.max(axis=1) > -np.inf)
            windows = {int(row): list(windows_of(wanted[row] > -np.inf)) for row in rows}

        def raise_row(
            row: int, depth: int = DEEP if deep else depth, wanted: FloatArray = wanted,
            windows: dict[int, list[tuple[int, int]]] = windows,
        ) -> float:  # fmt: skip
            before = arrivals.arrival[row].copy()
            for first, last in windows[row]:
                raised(
                    problem, legs[row], first, last, depth, wanted[row] + STEP_D,
                    arrivals.arrival[row],
                )  # fmt: skip
            return float(np.max(arrivals.arrival[row] - before))

        with ThreadPoolExecutor(jobs) as threads:
            most = max(threads.map(raise_row, windows), default=0.0)
        if deep and most < LITTLE_D:
            return  # smaller parts would not know more
        depth += 0 if deep else 1


class Cells(NamedTuple):
    """What was proven of the cells of an instance so far, as it is kept in a file.

    Attributes
    ----------
    arrival : (legs, cells) float64
        Before when nobody arrives [d].
    spent_s : float
        Of processors.
    rounds : int
    origin : str
        See :func:`origin_of`.
    """

    arrival: FloatArray
    spent_s: float
    rounds: int
    origin: str


def origin_of(problem: Problem) -> str:
    """What cells rest on, as a digest: the instance, and every line that rules a leg out.

    A cell that wrong code has proven stays in its file, and spoils each proof that goes on from it.
    """
    digest = hashlib.sha256(problem.elements.tobytes())
    digest.update(
        repr((problem.least_flight_d, limit_m_s(problem, 0), limit_m_s(problem, 1))).encode()
    )
    for module in (boxes, cells, costs, kepler, lambert, spans):
        digest.update(Path(str(module.__file__)).read_bytes())
    return digest.hexdigest()


def read_cells(path: Path, legs: int, count: int, origin: str) -> Cells:
    """What was proven before; the file is one that :func:`bound` has written."""
    try:
        with np.load(path) as kept:
            found = Cells(
                kept["arrival"], float(kept["spent_s"]), int(kept["rounds"]), str(kept["origin"])
            )
    except (OSError, KeyError, ValueError):
        raise InputError(f"--cells {path}: no cells of a proof; name another file") from None
    if found.origin != origin or len(found.arrival) != legs or found.arrival.shape[1] < count:
        raise InputError(f"--cells {path}: cells of another proof; name another file")
    # Whether later cells are known makes no difference to what is proven of these.
    return found._replace(arrival=np.ascontiguousarray(found.arrival[:, :count]))


def write_cells(path: Path, proven: Cells) -> None:
    """Keep what was proven; a file that is there is replaced when the new one is whole."""
    part = path.with_name(path.name + ".part")
    with part.open("wb") as file:
        np.savez(file, **proven._asdict())
    part.replace(path)


def bound(
    problem: Problem,
    shorter_d: float,
    *,
    time_limit_s: float = math.inf,
    jobs: int = 2,
    path: Path | None = None,
) -> Bound:
    """What no tour falls below.

    Parameters
    ----------
    problem : Problem
    shorter_d : float
        The duration of a known tour, which the bound does not exceed.
    time_limit_s : float
        After which no round begins.
    jobs : int
        Threads.
    path : Path, optional
        Cells are kept there after each round, and taken from there if they are.
    """
    clock = time.perf_counter(), time.process_time()
    end_d, origin = math.ceil(shorter_d) + STEP_D, origin_of(problem)
    if path is not None and path.is_file():
        arrivals, legs = all_legs(problem, end_d)
        kept = read_cells(path, *arrivals.arrival.shape, origin)
        arrivals = arrivals._replace(arrival=kept.arrival)
    else:
        arrivals, legs = first_cells(problem, end_d, jobs)
        kept = Cells(arrivals.arrival, 0.0, 0, origin)
    known = [problem.begin_d]
    for proven in rounds_of(problem, shorter_d - LITTLE_D, jobs, arrivals, legs, problem.begin_d):
        known.append(proven)
        spent = kept.spent_s + time.process_time() - clock[1]
        if path is not None:
            rounds = kept.rounds + len(known) - 1
            write_cells(path, Cells(arrivals.arrival, spent, rounds, origin))
        if time.perf_counter() - clock[0] > time_limit_s:
            break
    spent = kept.spent_s + time.process_time() - clock[1]
    return Bound(known[-1], kept.rounds + len(known) - 1, time.perf_counter() - clock[0], spent)
