"""Orienteering as missions on given connections, planned and proven exactly, however fine time is.

Time is continuous here and connections depart one by one, so that some departures have to be
chosen: points in time for each place, whole milliseconds. Two instances are made of them.

Possible: a connection departs at each point. Who is ready in between waits for the next one, so
that its plans are tours, and its optimum is at most that of the benchmark.

Optimistic: one connection for all who are ready between a point and the next one. It departs a
millisecond before the latter, and arrives as if it had departed at the former, rounded down to
milliseconds. A later departure never arrives earlier, so every tour is a plan, and the bound of
this instance is one of the benchmark.

Where the best optimistic plan is no tour, the times at which its places can be reached become
points, and that plan is gone (dynamic discretisation discovery: Boland, Hewitt, Marshall and
Savelsbergh, "The continuous-time service network design problem", Operations Research 65(5), 2017).
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

import numpy as np
from tables import head, row

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.problem.bodies import Station, Target
from adr_opt.problem.chasers import AtStation, Chaser, Tank
from adr_opt.problem.given import Given, of_rows
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import GivenFile, MissionSettings, TransferSettings

from ..reading import FloatArray
from .reading import (
    FIRST_MS,
    SLOT_MS,
    Optimum,
    Places,
    instance_files,
    read_optima,
    read_places,
    travel_of,
)
from .scoring import score

STEP_MS = 120_000.0
"""Spacing of the first points."""

MOST_ROUNDS = 50
"""Maximum number of optimistic plans that turn out not to be tours."""


class Ours(NamedTuple):
    """The planned tour.

    Attributes
    ----------
    score, bound : float
        Of the best tour, and what no tour exceeds.
    tour : tuple of int
    rounds : int
        How many optimistic instances were planned.
    time_s, processor_s : float
        Of planning and proving, and of making the instances.
    """

    score: float
    bound: float
    tour: tuple[int, ...]
    rounds: int
    time_s: float
    processor_s: float


def latest_ms(places: Places) -> float:
    """Latest end of the tour."""
    return min(float(places.closes_ms[-1]), float(places.opens_ms[0]) + places.longest_ms)


def first_points(places: Places, step_ms: float = STEP_MS) -> list[FloatArray]:
    """For each place, beginnings of service from which something may depart [ms].

    The tour begins at one time, and from the last place nothing departs.
    """
    points = [places.opens_ms[:1].copy()]
    for opens, closes in zip(places.opens_ms[1:-1], places.closes_ms[1:-1], strict=True):
        begin = max(float(opens), float(places.opens_ms[0]))
        points.append(np.arange(begin, min(float(closes), latest_ms(places)) + 1.0, step_ms))
    return [*points, np.empty(0)]


def travels_ms(given: FloatArray, departures_ms: FloatArray) -> FloatArray:
    """Durations as of :func:`.scoring.travel_ms`, for many departures of one way."""
    slots = FIRST_MS + SLOT_MS * np.arange(given.size)
    found: FloatArray = np.interp(departures_ms, slots, given)
    return found


def begins_ms(places: Places, travel: FloatArray, i: int, j: int, times: FloatArray) -> FloatArray:
    """Earliest start of service at j after services at i that begin at some times."""
    ready = times + places.service_ms[i]
    arrival = ready + travels_ms(travel[i, j], ready)
    later: FloatArray = np.maximum(arrival, places.opens_ms[j])
    return later


def connections(
    places: Places,
    travel: FloatArray,
    points: Sequence[FloatArray],
    names: Sequence[str],
    *,
    optimistic: bool,
) -> Given:
    """The connections of either instance; they begin with the service at their origin.

    Parameters
    ----------
    places : Places
    travel : (places, places, slots) float64
        [ms].
    points : list of (points,) float64
        By place [ms].
    names : sequence of str
        The bodies, in the order of their numbers.
    optimistic : bool
    """
    number = {name: at for at, name in enumerate(names)}
    zero, end = float(places.opens_ms[0]), latest_ms(places)
    rows: list[tuple[FloatArray, ...]] = []
    for i in range(places.count - 1):
        leaves = points[i]
        if optimistic and i:
            leaves = np.append(points[i][1:], places.closes_ms[i] + 1.0) - 1.0
        for j in range(1, places.count):
            if i == j:
                continue
            begins = begins_ms(places, travel, i, j, points[i])
            begins = np.floor(begins) if optimistic else np.ceil(begins)
            kept = begins <= min(float(places.closes_ms[j]), end)
            # Of those before it opens, the last one stands for all.
            early = np.flatnonzero(begins <= places.opens_ms[j])
            kept[early[:-1]] = False
            ends = np.full((2, int(kept.sum())), [[number[_name(places, k)]] for k in (i, j)])
            if (begins[kept] <= leaves[kept]).any():
                raise InputError(f"{places.name}: a step is longer than a way; take shorter steps")
            rows.append((*ends, (leaves[kept] - zero) / 1e3, (begins[kept] - zero) / 1e3))
    origin, destination, departs, lands = (
        np.concatenate(column) for column in zip(*rows, strict=True)
    )
    columns = {
        "origin": origin.astype(int),
        "destination": destination.astype(int),
        # Half a millisecond keeps the rounding of seconds from deciding who is in time.
        "departure_s": departs + (5e-4 if optimistic else 0.0),
        "arrival_s": lands,
        "delta_v_m_s": np.zeros(departs.size),
    }
    columns["departure_s"][columns["origin"] == number["begin"]] = 0.0
    return of_rows(columns, names)


def _name(places: Places, place: int) -> str:
    return {0: "begin", places.count - 1: "end"}.get(place, f"place-{place:02d}")


def instance_of(places: Places) -> Instance:
    """One chaser from the first place to the last; services are part of connections.

    A chaser that is at a place has not been served there yet, so windows are those in which service
    begins, and the tank is of no account.
    """
    zero = float(places.opens_ms[0])
    return Instance(
        name=f"optw-{places.name}",
        epoch=datetime(2026, 1, 1, tzinfo=UTC),
        stations=(Station(name="begin"), Station(name="end")),
        targets=tuple(
            Target(
                name=_name(places, place),
                prize=float(places.score[place]),
                window_s=(
                    max(float(places.opens_ms[place]) - zero, 0.0) / 1e3,
                    (float(places.closes_ms[place]) - zero) / 1e3,
                ),
            )
            for place in range(1, places.count - 1)
        ),
        chasers=(
            Chaser(
                name="tourist",
                start=AtStation(station="begin"),
                end=AtStation(station="end"),
                tank=Tank(delta_v_m_s=1.0),
            ),
        ),
        mission=MissionSettings(
            duration_s=(latest_ms(places) - zero) / 1e3, service_s=0.0, refuel_revolutions=0.0
        ),
        transfer=TransferSettings(given=GivenFile(file="optw.parquet")),
    )


def refined(
    places: Places, travel: FloatArray, points: Sequence[FloatArray], tour: Sequence[int]
) -> list[FloatArray]:
    """The points, and the times at which a tour can reach its places."""
    finer, now, here = list(points), points[0], 0
    for one in tour:
        now = np.floor(begins_ms(places, travel, here, one, now))
        if now[0] > places.closes_ms[one]:
            break
        finer[one], here = np.union1d(finer[one], now), one
    return finer


def plan(
    places: Places,
    travel: FloatArray,
    time_limit_s: float,
    *,
    step_ms: float = STEP_MS,
    jobs: int = 0,
) -> Ours:
    """Plan and prove, round by round, until the best tour has the score of the bound."""
    clock = time.perf_counter(), time.process_time()
    instance, points = instance_of(places), first_points(places, step_ms)
    best, bound, found = 0.0, math.inf, ()
    rounds = 0
    for optimistic in (False, *(True,) * MOST_ROUNDS):
        left = time_limit_s - (time.perf_counter() - clock[0])
        if left <= 0.0 or best >= bound:
            break
        rows = connections(places, travel, points, instance.names, optimistic=optimistic)
        given = instance.with_given(rows)
        method, limit = ("exact", left) if optimistic else ("beam", 0.1 * left)
        options = {"jobs": jobs} if optimistic else {}
        result = adr_opt.solve(given, method, time_limit=limit, **options)
        assert result.plan is not None
        assert adr_opt.check(given, result.plan) == ()
        tour = tuple(
            int(leg.destination.removeprefix("place-"))
            for leg in result.plan.legs
            if leg.destination != "end"
        )
        judged = score(places, travel, tour)
        if not judged.violations and judged.score > best:
            best, found = judged.score, tour
        if optimistic:
            rounds += 1
            assert result.upper_bound is not None
            bound = min(bound, result.upper_bound)
            finer = refined(places, travel, points, tour)
            if result.status != "optimal" or all(map(np.array_equal, finer, points)):
                break
            points = finer
    spent = time.perf_counter() - clock[0], time.process_time() - clock[1]
    return Ours(best, bound, found, rounds, *spent)


def report(folder: Path, time_limit_s: float) -> None:
    """Print the tables: static first, then time-dependent."""
    files = instance_files(folder)
    published = read_optima(folder / "optima.csv")
    for varying in (False, True):
        for path in files:  # what is missing or broken is said before the first of them is planned
            travel_of(path, read_places(path), varying=varying)
    for varying in (False, True):
        print(f"\n{'Time-dependent' if varying else 'Static'} travel times; others are CPLEX 12.6")
        head("instance", "published [score]", "ours", "bound", "time", "time of others")
        rows = [
            _row(path, varying, None if varying else published.get(path.stem), time_limit_s)
            for path in files
        ]
        proven = sum(found.score == found.bound for found, _ in rows)
        seconds = sum(found.time_s for found, _ in rows)
        print(f"\n{proven} of {len(rows)} proven, in {seconds:.1f} s.")
        closed = [(found, known) for found, known in rows if known is not None and known.is_proven]
        if closed:
            same = sum(known.score == found.score == found.bound for found, known in closed)
            taken = sum(found.time_s for found, _ in closed)
            theirs = sum(known.taken_s for _, known in closed)
            print(
                f"Of the {len(closed)} that CPLEX proved, {same} have the same score and are "
                f"proven, in {taken:.1f} s where CPLEX took {theirs:,.1f} s, "
                f"{theirs / taken:,.0f} times as long."
            )


def _row(
    path: Path, varying: bool, known: Optimum | None, time_limit_s: float
) -> tuple[Ours, Optimum | None]:
    """Print results of others and ours on an instance; our score is that of the scorer."""
    places = read_places(path)
    travel = travel_of(path, places, varying=varying)
    ours = plan(places, travel, time_limit_s)
    judged = score(places, travel, ours.tour)
    if judged.violations or judged.score != ours.score:
        raise RuntimeError(f"{places.name}: {judged} is not the {ours.score:g} of our plan")
    star = "" if known is None or known.is_proven else f" ({known.status})"
    row(
        places.name + star,
        "–" if known is None else f"{known.score:g}",
        f"{judged.score:g}",
        f"{ours.bound:g}",
        f"{ours.time_s:,.1f} s",
        "–" if known is None else f"{known.taken_s:,.1f} s",
    )
    return ours, known
