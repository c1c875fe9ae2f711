"""What each method did on each instance, and the table of it."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import adr_opt
from adr_opt.front import method_of
from adr_opt.mending import as_it_is, mended
from adr_opt.planner import takes_jobs
from adr_opt.result import certify

from .didppy_slots import didppy_promise
from .pyvrp_static import pyvrp_promise


@dataclass(frozen=True)
class Row:
    """What one method did on one instance; NaN where it promises nothing beyond its plan."""

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
    result = certify(mission, "peer", order, seed=seed, runtime_s=0.0)
    return checked(mission, result)


def checked(mission: adr_opt.Mission, result: adr_opt.Result) -> float:
    """The objective of a result whose plan ``check`` finds nothing wrong with."""
    if result.plan is None:
        return 0.0
    violations = adr_opt.check(mission.instance, result.plan)
    if violations:
        raise RuntimeError(f"{result.method} on {mission.instance.name}: {violations[0]}")
    return result.objective


def peer_rows(
    name: str, variant: str, mission: adr_opt.Mission, *, time_limit_s: float, seed: int,
    slot_s: float, jobs: int,
) -> list[Row]:  # fmt: skip
    """A peer's rows: its order as it is, and mended; the variant is a statistic or "early"."""
    if name == "pyvrp":
        promise = pyvrp_promise(mission, time_limit_s=time_limit_s, seed=seed, statistic=variant)
        label = f"PyVRP, {variant}"
    else:
        early = variant == "early"
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
            mission.instance.name,
            legal(mission, follow(mission, promise.order), seed),
            promise.visits,
            promise.bound,
            promise.build_s,
            promise.solve_s,
        )
        for way, follow in ways
    ]


def our_row(
    name: str, mission: adr_opt.Mission, *, time_limit_s: float, seed: int, jobs: int
) -> Row:
    """One of our planners."""
    cores = jobs if takes_jobs(method_of(name)) else None
    began = time.perf_counter()
    result = adr_opt.solve(mission, name, time_limit=time_limit_s, seed=seed, jobs=cores)
    wall = time.perf_counter() - began
    visits = checked(mission, result)
    return Row(name, mission.instance.name, visits, visits, result.upper_bound, 0.0, wall)


def table(rows: Sequence[Row]) -> str:
    """Means over instances, the best method first, in Markdown."""
    lines = [
        "| method | visits, mean | visits by instance | promised, mean | kept | bound, mean | "
        "build | solve, max |",
        "|---|---|---|---|---|---|---|---|",
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
            + f" | {statistics.mean(row.build_s for row in some):.1f} s | "
            f"{max(row.solve_s for row in some):.1f} s |"
        )
    if any(row.method.startswith("DIDPPy") for row in rows):
        lines += ["", "† of the rounded model, no bound on the mission"]
    return "\n".join(lines)
