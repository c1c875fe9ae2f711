"""Peers: other solvers on the same fields, and drawn orienteering with time windows.

    python bench/peers.py fields --family nominal --count 4 --limit 10
    python bench/peers.py fields --family campaign --count 5 --limit 60
    python bench/peers.py windows --count 8 --limits 60 --pyvrp 20 --rows R/windows.jsonl
    python bench/peers.py windows --count 3 --chasers 2 --limits 1 10 --pyvrp 10

Needs ``pip install -e '.[peers]'``.
"""

from __future__ import annotations

import csv
import math
import sys
from collections.abc import Callable
from functools import partial
from importlib.metadata import version
from pathlib import Path
from statistics import mean
from typing import Any, Literal, NamedTuple

from contest.didppy_slots import didppy_promise
from contest.orienteering import KINDS, Places, by_pyvrp, collected, draw, instance_of
from contest.ortools_static import ortools_promise
from contest.promise import STATISTICS, Promise, need
from contest.pyvrp_static import pyvrp_promise
from fields import best_known, ready
from tables import experiment, head, kept, row, timed

import adr_opt
from adr_opt.common.clock import count_processor_time
from adr_opt.common.files import write_text
from adr_opt.mission.certified import certify_routes
from adr_opt.mission.order_repair import as_it_is, mended
from adr_opt.mission.problem import Problem
from adr_opt.run.methods import spec

STATIC = {"pyvrp": ("PyVRP", pyvrp_promise), "ortools": ("OR-Tools routing", ortools_promise)}
"""Peers that plan on static costs, with the names that they are shown by."""


class Result(NamedTuple):
    """Result of a method on an instance; NaN for claims that it does not make."""

    visits: float
    promised: float
    bound: float
    build_s: float
    solve_s: float


def checked(problem: Problem, result: adr_opt.Result) -> float:
    """The objective of a result whose plan ``check`` finds nothing wrong with."""
    if result.plan is None:
        return 0.0
    violations = adr_opt.check(problem.instance, result.plan)
    if violations:
        raise RuntimeError(f"{result.method} on {problem.instance.name}: {violations[0]}")
    return result.objective


def kept_of(
    problem: Problem, promise: Promise, follow: Callable[..., tuple[int, ...]], seed: int = 0
) -> float:
    """The objective of what is left of a promise when its routes are timed exactly in a way."""
    pairs = zip(problem.missions, promise.routes, strict=True)
    routes = [follow(mission, route) for mission, route in pairs]
    return checked(problem, certify_routes(problem, "peer", routes, seed=seed, runtime_s=0.0))


def promise_of(name: str, variant: str, problem: Problem, limit_s: float, seed: int) -> Promise:
    """What a peer promises; the variant is a statistic, "early", or nothing."""
    if name in STATIC:
        _, plans = STATIC[name]
        return plans(problem, time_limit_s=limit_s, seed=seed, statistic=variant)
    (mission,) = problem.missions
    return didppy_promise(mission, time_limit_s=limit_s, earlier_is_better=variant == "early")


def fields(
    family: str = "nominal",
    instances: tuple[Path, ...] = (),
    count: int = 4,
    limit: float = 10.0,
    seed: int = 0,
    static: tuple[Literal[STATISTICS], ...] = ("mean", "best"),
    peers: tuple[Literal["pyvrp", "ortools", "didppy", "didppy-early"], ...] | None = None,
    ours: tuple[str, ...] = ("auto", "beam", "ortools"),
) -> None:
    """PyVRP and OR-Tools' routing on static costs, DIDPPy on a model in slots, and ours.

    Same instances, time limit, seed and one core each. Every clock starts with a ready timetable;
    building a peer's model from it is not charged to the peer and is listed as *build*. What a peer
    *promises* is the number of targets that its own model visits; what it *keeps* is left of that
    when the plan is timed exactly on the timetable and passes ``check``. How each peer is used is
    said in ``contest/``.

    *As it is*: the legal beginning of its order, its own refuelling stops included. *Mended*: the
    same order with and without its stops, with and without keeping the way to the station open; a
    move that is not legal is made after a refuelling stop, or else left out. The best of all these
    counts.

    Several chasers are the vehicles of PyVRP and of OR-Tools' routing; what plans for one chaser is
    left out. Each one's order is timed by itself, and *gap* is how far a plan is from the best
    bound there is, of ``instances/best-known.csv`` or proven by one of our methods.
    """
    given = [adr_opt.load(path) for path in instances]
    given = given or [adr_opt.generate(family, number) for number in range(count)]
    several = any(len(instance.chasers) > 1 for instance in given)
    others = peers or (("pyvrp", "ortools") if several else ("pyvrp", "didppy", "didppy-early"))
    if several:
        ours = tuple(name for name in ours if spec(name).several)
        others = tuple(name for name in others if name in STATIC)
    contests = []
    for name in others:
        package, _, variant = name.partition("-")
        need(package)
        contests += [(package, one) for one in (static if package in STATIC else [variant])]
    warm = ready(adr_opt.generate("tiny", 0, chasers=2 if several else 1))
    for name in ours:  # compile before the clock starts
        adr_opt.solve(warm, name, time_limit=20.0, iterations=3)
    rows: dict[str, list[Result]] = {}
    bounds: list[float] = []
    known = {each["sha256"]: each["upper_bound"] for each in best_known().values()}
    for instance in given:
        problem = ready(instance)
        bounds.append(float(known.get(problem.sha256) or math.inf))
        for name in ours:
            jobs = {"jobs": 1} if spec(name).uses_cores else {}
            made, wall, _ = timed(
                lambda: adr_opt.solve(problem, name, time_limit=limit, seed=seed, **jobs)  # noqa: B023
            )
            visits = checked(problem, made)
            bounds[-1] = min(bounds[-1], made.upper_bound)
            rows.setdefault(name, []).append(Result(visits, visits, made.upper_bound, 0.0, wall))
        for name, variant in contests:
            promise = promise_of(name, variant, problem, limit, seed)
            shown = f"{STATIC[name][0]}, {variant}" if name in STATIC else "DIDPPy, 240 s"
            shown += ", earlier is better" if variant == "early" else ""
            for way, follow in (("as it is", as_it_is), ("mended", mended)):
                visits = kept_of(problem, promise, follow, seed)
                rows.setdefault(f"{shown}, {way}", []).append(Result(visits, *promise[1:5]))
    used = dict.fromkeys(package for package, _ in contests)
    packages = ", ".join(f"{package} {version(package)}" for package in used)
    named = ", ".join(instance.name for instance in given)
    print(f"{packages}; time limit {limit:g} s, seed {seed}, one core; instances {named}")
    head(
        *("method", "visits, mean", "visits by instance", "promised, mean", "kept", "bound, mean"),
        *(["gap, mean"] if several else []),
        *("build", "solve, max"),
    )
    for method, found in sorted(rows.items(), key=lambda item: -mean(r.visits for r in item[1])):
        promised, bound = sum(r.promised for r in found), mean(r.bound for r in found)
        gap = mean(1.0 - r.visits / most for r, most in zip(found, bounds, strict=True))
        row(
            method,
            f"{mean(r.visits for r in found):.2f}",
            " ".join(f"{r.visits:g}" for r in found),
            f"{promised / len(found):.2f}",
            f"{100.0 * sum(r.visits for r in found) / promised:.0f} %" if promised else "–",
            f"{bound:.2f}{'†' * method.startswith('DIDPPy')}" if math.isfinite(bound) else "–",
            *([f"{100.0 * gap:.1f} %" if all(map(math.isfinite, bounds)) else "–"] * several),
            f"{mean(r.build_s for r in found):.1f} s",
            f"{max(r.solve_s for r in found):.1f} s",
        )
    if any(method.startswith("DIDPPy") for method in rows):
        print("\n† of the rounded model, no bound on the mission")


def planned(
    places: Places, method: str, limit_s: float, chasers: int, seed: int, options: dict[str, Any]
) -> dict[str, Any]:
    """Plan a drawn instance within a limit; the plan is checked, and scored by the tours alone."""
    instance = instance_of(places, chasers)
    result = adr_opt.solve(instance, method, time_limit=limit_s, seed=seed, **options)
    prizes = 0.0
    if result.plan is not None:
        assert adr_opt.check(instance, result.plan) == ()
        for route in result.plan.routes:
            tour = [int(leg.destination[6:]) for leg in route.legs if leg.destination[0] == "p"]
            prizes += float(collected(places, tour))
        assert prizes == result.objective
    proven = result.status == "optimal"
    bound = result.upper_bound if math.isfinite(result.upper_bound) else None
    return {"prizes": prizes, "bound": bound, "proven": proven, "time_s": result.runtime_s}


def windows(
    kinds: tuple[Literal[KINDS], ...] = KINDS,
    count: int = 2,
    places: int = 100,
    limits: tuple[float, ...] = (60.0,),
    method: str = "auto",
    pyvrp: float | None = None,
    chasers: int = 1,
    seed: int = 0,
    processor: bool = False,
    rows: Path | None = None,
    keep: Path = Path(__file__).parent / "curves" / "windows.csv",
) -> None:
    """Drawn orienteering with time windows: plans and proofs against the best known.

    Draws instances of each of four kinds and plans each within each limit. The best known prizes of
    an instance are the largest of all that were found here, by PyVRP too, and kept in the table of
    ``--keep``. Every plan passes ``check`` and is scored again by the tour alone. Rows that the
    file of ``--rows`` has are not planned again. ``--processor``: limits are of processor time, on
    one core, whatever else runs.
    """
    options = {"jobs": 1} if processor and spec(method).uses_cores else {}
    if processor:  # kernels are compiled before
        planned(draw(KINDS[0], 0, 10), method, 2.0, chasers, seed, options)
        count_processor_time()
    best: dict[str, float] = {}
    if keep.exists():
        with keep.open(encoding="utf-8", newline="") as file:
            best = {one["instance"]: float(one["prizes"]) for one in csv.DictReader(file)}
    shown, theirs = [f"{method}, {limit:g} s" for limit in limits], dict[str, float]()
    head("instance", "best known", *(["PyVRP"] if pyvrp else []), *shown)
    found: dict[float, list[tuple[str, dict[str, Any]]]] = {limit: [] for limit in limits}
    for one in (draw(kind, drawn, places) for kind in kinds for drawn in range(count)):
        name, cells = f"{one.name}-{places}", list[str]()
        name += f"-by-{chasers}" if chasers > 1 else ""
        if pyvrp:
            key = {"instance": name, "method": "pyvrp", "limit_s": pyvrp, "seed": seed}
            ask = partial(by_pyvrp, one, pyvrp, seed, chasers)
            theirs[name] = kept(rows, key, lambda: {"prizes": float(ask())})["prizes"]  # noqa: B023
            best[name] = max(best.get(name, 0.0), theirs[name])
            cells.append(f"{theirs[name]:g}")
        for limit in limits:
            key = {"instance": name, "method": method, "limit_s": limit, "seed": seed}
            made = kept(
                rows,
                key,
                lambda: planned(one, method, limit, chasers, seed, options),  # noqa: B023
            )
            found[limit].append((name, made))
            best[name] = max(best.get(name, 0.0), made["prizes"])
            bound = f"≤ {math.inf if made['bound'] is None else made['bound']:.0f}"
            bound = "proven" if made["proven"] else bound
            cells.append(f"{made['prizes']:g}, {bound}, {made['time_s']:.1f} s")
        row(name, f"{best[name]:g}", *cells)
        lines = [f"{known},{prizes:g}" for known, prizes in sorted(best.items())]
        write_text(keep, "\n".join(["instance,prizes", *lines, ""]))
    for limit, some in found.items():
        behind = [100.0 * (1.0 - made["prizes"] / best[name]) for name, made in some]
        print(
            f"\n{method}, {limit:g} s: behind the best known by {mean(behind):.2f} % in the mean "
            f"and {max(behind):.1f} % at most, {sum(made['proven'] for _, made in some)} of "
            f"{len(some)} proven"
        )
        shares = [made["prizes"] / theirs[name] for name, made in some if theirs.get(name)]
        if shares:
            print(f"Of PyVRP's prizes {mean(shares):.3f} in the mean, {min(shares):.3f} at least")


if __name__ == "__main__":
    sys.exit(experiment(__doc__, fields, windows))
