"""Orienteering as missions with functions of time, planned and proven by `auto`."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

import numpy as np
from tables import head, row, timed

import adr_opt
from adr_opt.common.clock import count_processor_time
from adr_opt.problem.bodies import Station, Target
from adr_opt.problem.chasers import AtStation, Chaser, Tank
from adr_opt.problem.given import only
from adr_opt.problem.given_functions import of_breakpoints
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


class Ours(NamedTuple):
    """The planned tour.

    Attributes
    ----------
    score, bound : float
        Of the best tour, and what no tour exceeds.
    tour : tuple of int
    rounds : int
        How many optimistic instances were planned.
    processor_s : float
        Of planning and proving.
    """

    score: float
    bound: float
    tour: tuple[int, ...]
    rounds: int
    processor_s: float


def latest_ms(places: Places) -> float:
    """Latest end of the tour."""
    return min(float(places.closes_ms[-1]), float(places.opens_ms[0]) + places.longest_ms)


def _name(places: Places, place: int) -> str:
    return {0: "begin", places.count - 1: "end"}.get(place, f"place-{place:02d}")


def _functions(places: Places, travel: FloatArray) -> Iterator[tuple[str, str, FloatArray, float]]:
    """Start of service as a function of that before: services are part of the ways."""
    zero, end = float(places.opens_ms[0]), latest_ms(places)
    slots = FIRST_MS + SLOT_MS * np.arange(travel.shape[2])
    for i in range(places.count - 1):
        ready = places.opens_ms[i] + places.service_ms[i], end + places.service_ms[i]
        leaves = np.unique([*ready, *slots[(slots > ready[0]) & (slots < ready[1])]])
        for j in range(1, places.count):
            if i != j:
                lands = leaves + np.interp(leaves, slots, travel[i, j])
                points = np.column_stack([leaves - places.service_ms[i], lands])
                points = np.maximum(points - zero, 0.0) / 1e3
                yield _name(places, i), _name(places, j), points, 0.0


def instance_of(places: Places, travel: FloatArray) -> Instance:
    """One chaser from the first place to the last; services are part of connections.

    A chaser that is at a place has not been served there yet, so windows are those in which service
    begins, and the tank is of no account.
    """
    zero = float(places.opens_ms[0])
    made = Instance(
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
        transfer=TransferSettings(given=GivenFile(functions="ways.json")),
    )
    return made.with_given(only(of_breakpoints(_functions(places, travel), made.names)))


def plan(places: Places, travel: FloatArray, time_limit_s: float) -> Ours:
    """Plan and prove a tour."""
    instance = instance_of(places, travel)
    result, _, spent = timed(
        lambda: adr_opt.solve(instance, "auto", time_limit=time_limit_s, jobs=1)
    )
    assert result.plan is None or adr_opt.check(instance, result.plan) == ()
    tour = tuple(
        int(leg.destination.removeprefix("place-"))
        for leg in (result.plan.legs if result.plan else ())
        if leg.destination != "end"
    )
    rounds = int(result.counters["optimistic"])
    return Ours(score(places, travel, tour).score, result.upper_bound, tour, rounds, spent)


def report(folder: Path, time_limit_s: float) -> None:
    """Print the tables: static first, then time-dependent; all times are of one processor."""
    count_processor_time()
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
        seconds = sum(found.processor_s for found, _ in rows)
        print(f"\n{proven} of {len(rows)} proven, in {seconds:.1f} s.")
        closed = [(found, known) for found, known in rows if known is not None and known.is_proven]
        if closed:
            same = sum(known.score == found.score == found.bound for found, known in closed)
            taken = sum(found.processor_s for found, _ in closed)
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
        f"{ours.processor_s:,.1f} s",
        "–" if known is None else f"{known.taken_s:,.1f} s",
    )
    return ours, known
