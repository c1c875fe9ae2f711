"""Results of each method on each instance, and their table."""

from __future__ import annotations

import csv
import math
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import adr_opt
from adr_opt.mission.certified import certify_routes
from adr_opt.mission.order_repair import as_it_is, mended
from adr_opt.mission.problem import Problem, problem_of
from adr_opt.run.front import spec_of

from .didppy_slots import didppy_promise
from .ortools_static import ortools_promise
from .pyvrp_static import pyvrp_promise

BEST_KNOWN = Path(__file__).resolve().parents[2] / "instances" / "best-known.csv"
"""Bounds of the instances of the library."""

STATIC = {"pyvrp": ("PyVRP", pyvrp_promise), "ortools": ("OR-Tools routing", ortools_promise)}
"""Peers that plan on static costs, with the names that they are shown by."""

NOT_THEIRS = {
    "PyVRP": "one matrix for all times; a tank is a load that targets have, the mean static ΔV of "
    "the cheapest legs to them, and no load that legs have",
    "OR-Tools routing": "one matrix for all times; tanks and refuelling are the mission's",
}
"""Features of campaigns that peers cannot express, for the footnotes."""


@dataclass(frozen=True)
class Row:
    """Result of one method on one instance; NaN for claims that it does not make."""

    method: str
    instance: str
    visits: float
    promised: float
    bound: float
    build_s: float
    solve_s: float


def legal(mission: adr_opt.Mission, order: Sequence[int], seed: int = 0) -> float:
    """The objective of an order of bodies that ``check`` finds nothing wrong with.

    Raises
    ------
    RuntimeError
        There is a violation.
    """
    return legal_routes(problem_of(mission), [order], seed)


def legal_routes(problem: Problem, routes: Sequence[Sequence[int]], seed: int = 0) -> float:
    """The same of an order for each chaser."""
    result = certify_routes(problem, "peer", routes, seed=seed, runtime_s=0.0)
    return checked(problem, result)


def checked(problem: Problem, result: adr_opt.Result) -> float:
    """The objective of a result whose plan ``check`` finds nothing wrong with."""
    if result.plan is None:
        return 0.0
    violations = adr_opt.check(problem.instance, result.plan)
    if violations:
        raise RuntimeError(f"{result.method} on {problem.instance.name}: {violations[0]}")
    return result.objective


def peer_rows(
    name: str,
    variant: str,
    problem: Problem,
    *,
    time_limit_s: float,
    seed: int,
    slot_s: float,
    jobs: int,
) -> list[Row]:
    """A peer's rows: its orders as they are, and mended; the variant is a statistic or "early"."""
    if name in STATIC:
        shown, promised = STATIC[name]
        promise = promised(problem, time_limit_s=time_limit_s, seed=seed, statistic=variant)
        label = f"{shown}, {variant}"
    else:
        early = variant == "early"
        (mission,) = problem.missions
        promise = didppy_promise(
            mission, time_limit_s=time_limit_s, slot_s=slot_s, earlier_is_better=early, threads=jobs
        )
        label = f"DIDPPy, {slot_s:g} s" + (", earlier is better" if early else "")
    ways: tuple[tuple[str, Callable[..., tuple[int, ...]]], ...] = (
        ("as it is", as_it_is),
        ("mended", mended),
    )
    return [
        Row(
            f"{label}, {way}",
            problem.instance.name,
            legal_routes(problem, timed(problem, promise.routes, follow), seed),
            promise.visits,
            promise.bound,
            promise.build_s,
            promise.solve_s,
        )
        for way, follow in ways
    ]


def timed(
    problem: Problem, routes: Sequence[Sequence[int]], follow: Callable[..., tuple[int, ...]]
) -> list[tuple[int, ...]]:
    """Remainder of each chaser's route, timed exactly in a way."""
    return [follow(*each) for each in zip(problem.missions, routes, strict=True)]


def our_row(name: str, problem: Problem, *, time_limit_s: float, seed: int, jobs: int) -> Row:
    """One of our planners."""
    cores = jobs if spec_of(name).uses_cores else None
    began = time.perf_counter()
    result = adr_opt.solve(problem, name, time_limit=time_limit_s, seed=seed, jobs=cores)
    wall = time.perf_counter() - began
    visits = checked(problem, result)
    return Row(name, problem.instance.name, visits, visits, result.upper_bound, 0.0, wall)


def table(rows: Sequence[Row], bounds: Mapping[str, float] | None = None) -> str:
    """Means over instances, the best method first, in Markdown.

    Parameters
    ----------
    rows : sequence of Row
    bounds : mapping of str to float, optional
        By instance: what no plan exceeds. Then the table says how far from it each method is.
    """
    lines = [
        "| method | visits, mean | visits by instance | promised, mean | kept | bound, mean | "
        + ("gap, mean | " if bounds else "")
        + "build | solve, max |",
        "|---|---|---|---|---|---|" + ("---|" if bounds else "") + "---|---|",
    ]
    methods = dict.fromkeys(row.method for row in rows)
    mine = {method: [row for row in rows if row.method == method] for method in methods}
    means = {m: statistics.mean(row.visits for row in some) for m, some in mine.items()}
    for method in sorted(methods, key=lambda m: -means[m]):
        some = mine[method]
        promised = sum(row.promised for row in some)
        kept = f"{100.0 * sum(row.visits for row in some) / promised:.0f} %" if promised else "–"
        bound = statistics.mean(row.bound for row in some)
        own_model = "†" if method.startswith("DIDPPy") else ""
        lines.append(
            f"| {method} | {means[method]:.2f} | {' '.join(f'{row.visits:g}' for row in some)} | "
            f"{promised / len(some):.2f} | {kept} | "
            + (f"{bound:.2f}{own_model}" if math.isfinite(bound) else "–")
            + (f" | {mean_gap(some, bounds)}" if bounds else "")
            + f" | {statistics.mean(row.build_s for row in some):.1f} s | "
            f"{max(row.solve_s for row in some):.1f} s |"
        )
    if any(row.method.startswith("DIDPPy") for row in rows):
        lines += ["", "† of the rounded model, no bound on the mission"]
    named = {method.partition(",")[0] for method in methods}
    notes = [f"- {name}: {what}" for name, what in NOT_THEIRS.items() if name in named]
    if bounds and notes:
        lines += ["", *notes]
    return "\n".join(lines)


def mean_gap(rows: Sequence[Row], bounds: Mapping[str, float]) -> str:
    """Mean distance of a method's visits from bounds; a dash if an instance has none."""
    if not all(math.isfinite(bounds[row.instance]) for row in rows):
        return "–"
    return (
        f"{100.0 * statistics.mean(1.0 - row.visits / bounds[row.instance] for row in rows):.1f} %"
    )


def best_bounds(rows: Sequence[Row], problems: Sequence[Problem]) -> dict[str, float]:
    """The least bound of each instance that holds for it: known, or proven here; +inf for none."""
    with BEST_KNOWN.open(encoding="utf-8", newline="") as file:
        known = {row["sha256"]: row["upper_bound"] for row in csv.DictReader(file)}
    bounds = {each.instance.name: float(known.get(each.sha256) or math.inf) for each in problems}
    for row in rows:
        if not row.method.startswith("DIDPPy"):
            bounds[row.instance] = min(bounds[row.instance], row.bound)
    return bounds
