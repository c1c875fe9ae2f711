"""The instances as missions, with functions of time that are exact.

Along a way the distance driven is a function of time that rises from zone to zone. Who arrives
when it has risen by the length of the way: breakpoints are where one leaves, or arrives, as a zone
begins, and in between both speeds are constant.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from tables import head, kept, row, timed

import adr_opt
from adr_opt.problem.bodies import Station, Target
from adr_opt.problem.chasers import AtStation, Chaser, Tank
from adr_opt.problem.given import only
from adr_opt.problem.given_functions import of_breakpoints
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import GivenFile, MissionSettings, Objective, TransferSettings

from ..reading import FloatArray
from .reading import BEST, Roads, instance_files, read_best, read_roads
from .scoring import score

PROVEN = 1e-6
"""Relative gap up to which an end counts as least."""

ROUNDED = 0.005 + 1e-9
"""Known ends are rounded to hundredths."""


class Ours(NamedTuple):
    """The planned tour.

    Attributes
    ----------
    tour : tuple of int
        Customers; none without a plan.
    end, bound : float
        Infinite without a plan; no tour ends before the bound.
    labels : int
    processor_s : float
        Of planning and proving.
    """

    tour: tuple[int, ...]
    end: float
    bound: float
    labels: int
    processor_s: float


def breakpoints(edges: FloatArray, speeds: FloatArray, length: float) -> FloatArray:
    """Departures and arrivals of a way, shape (breakpoints, 2).

    Parameters
    ----------
    edges : (zones + 1,) float64
    speeds : (zones,) float64
    length : float
    """
    driven = np.concatenate([[0.0], np.cumsum(speeds * np.diff(edges))])
    last = driven[-1] - length
    if last < 0.0:
        return np.empty((0, 2))
    at = np.concatenate([driven, driven - length, [0.0, last]])
    at = np.unique(at[(at >= 0.0) & (at <= last)])
    leaves, lands = np.interp(at, driven, edges), np.interp(at + length, driven, edges)
    return np.column_stack([leaves, np.maximum.accumulate(lands)])


def _name(roads: Roads, place: int) -> str:
    return {roads.start: "begin", roads.end: "end"}.get(place, f"place-{place:02d}")


def _functions(roads: Roads) -> Iterator[tuple[str, str, FloatArray, float]]:
    known: dict[tuple[int, float], FloatArray] = {}
    for i, j in np.argwhere(roads.cluster >= 0).tolist():
        key = int(roads.cluster[i, j]), float(roads.distance[i, j])
        if key not in known:
            known[key] = breakpoints(roads.edges, roads.speeds[key[0]], key[1])
        if known[key].size:
            yield _name(roads, i), _name(roads, j), known[key], 0.0


def instance_of(roads: Roads) -> Instance:
    """One chaser from depot to depot that has to visit all customers and to end first."""
    latest = min(roads.latest, float(roads.closes[roads.end]))
    made = Instance(
        name=f"tdtsptw-{roads.name}",
        epoch=datetime(2026, 1, 1, tzinfo=UTC),
        stations=(Station(name="begin"), Station(name="end")),
        targets=tuple(
            Target(
                name=_name(roads, place),
                prize=1.0,
                required=True,
                window_s=(float(roads.opens[place]), float(roads.closes[place])),
            )
            for place in roads.customers
        ),
        chasers=(
            Chaser(
                name="van",
                start=AtStation(station="begin"),
                end=AtStation(station="end"),
                available_s=(float(roads.opens[roads.start]), None),
                tank=Tank(delta_v_m_s=1.0),
            ),
        ),
        mission=MissionSettings(duration_s=latest, service_s=0.0, refuel_revolutions=0.0),
        objective=Objective(cost="duration"),
        transfer=TransferSettings(given=GivenFile(functions="roads.json")),
    )
    return made.with_given(only(of_breakpoints(_functions(roads), made.names)))


def plan(roads: Roads, time_limit_s: float, *, jobs: int = 0) -> Ours:
    """Plan and prove the least end, and check the plan."""
    instance = instance_of(roads)
    result, _, spent = timed(
        lambda: adr_opt.solve(instance, "auto", time_limit=time_limit_s, jobs=jobs)
    )
    labels = int(result.counters["labels"])
    if result.plan is None:
        return Ours((), np.inf, 0.0, labels, spent)
    broken = adr_opt.check(instance, result.plan)
    if broken:
        raise RuntimeError(f"{roads.name}: the plan is not legal: {broken[0]}")
    tour = tuple(
        int(leg.destination.removeprefix("place-"))
        for leg in result.plan.legs
        if leg.destination != "end"
    )
    return Ours(tour, result.plan.cost, result.plan.cost_bound or 0.0, labels, spent)


def report(folder: Path, time_limit_s: float, cells: Path | None, count: int | None) -> None:
    """Print the table of all instances, or of some that are drawn, row by row."""
    files, best = instance_files(folder), read_best(folder / BEST)
    if count is not None:
        files = drawn(files, best, count)
    for path in files:  # what is broken is said before the first of them is planned
        read_roads(path)
    head("instance", "known", "ours", "bound", "gap", "labels", "processor time")
    proven, same, others = list[str](), list[str](), list[str]()
    for path in files:
        key = {"instance": path.stem, "time_limit_s": time_limit_s}
        one = kept(cells, key, lambda path=path: _planned(path, time_limit_s))
        end, bound, known = one["end"], one["bound"], best.get(path.stem, math.nan)
        is_proven = end is not None and end <= bound * (1.0 + PROVEN)
        proven += [path.stem] * is_proven
        if is_proven and not math.isnan(known):
            (same if abs(end - known) <= ROUNDED else others).append(path.stem)
        row(
            path.stem,
            "–" if math.isnan(known) else f"{known:.2f}",
            "–" if end is None else f"{end:.2f}",
            f"{bound:.2f}",
            "proven" if is_proven else "–" if end is None else f"{100 * (1 - bound / end):.2f} %",
            f"{one['labels']:,}",
            f"{one['processor_s']:.1f} s",
        )
    print(
        f"\n{len(proven)} of {len(files)} proven: {len(same)} that were known, with the same end, "
        f"{len(proven) - len(same) - len(others)} that were not, and with other ends than known: "
        f"{', '.join(others) or 'none'}."
    )


def _planned(path: Path, time_limit_s: float) -> dict[str, Any]:
    """Our result for an instance; the end is that of the scorer."""
    roads = read_roads(path)
    ours, end = plan(roads, time_limit_s), None
    if ours.tour:
        judged = score(roads, ours.tour)
        if judged.violations or abs(judged.end - ours.end) > 1e-5:
            raise RuntimeError(f"{roads.name}: {judged} is not the {ours.end:g} of our plan")
        end = judged.end
    return {**ours._asdict(), "tour": list(ours.tour), "end": end}


def drawn(files: list[Path], best: dict[str, float], count: int) -> list[Path]:
    """Some of the largest instances, always the same: half of them with a known end."""
    most = max(int(path.stem.split("_")[0]) for path in files)
    largest = [path for path in files if int(path.stem.split("_")[0]) == most]
    is_open = [math.isnan(best.get(path.stem, math.nan)) for path in largest]
    found = []
    for wanted in (False, True):
        those = [path for path, one in zip(largest, is_open, strict=True) if one == wanted]
        found += random.Random(0).sample(those, min(count, len(those)))
    return sorted(found)
