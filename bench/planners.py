"""Planners: visits, bounds, gaps and times over fields, and runs that are stopped early.

    python bench/planners.py quality nominal greedy greedy-guarded beam auto@10 exact@120
    python bench/planners.py quality campaign greedy-guarded auto@60 --chasers 5
    python bench/planners.py quality removal auto@200 --count 10 --falls 2,1
    python bench/planners.py tenth --count 3 --limit 60
    python bench/planners.py without sso rocket-bodies --mechanisms strings --limit 20

A method is NAME[:OPTION=VALUE,…][+BOUND][@SECONDS]. Visits against time are those of
``bench/time_quality.py``.
"""

from __future__ import annotations

import math
import resource
import sys
from collections.abc import Callable
from pathlib import Path
from statistics import mean, median, stdev
from typing import Any, Literal, NamedTuple

from contest.orienteering import KINDS, draw, instance_of
from fields import falling, numbers, ready
from tables import alone, experiment, head, kept, row, timed

import adr_opt
from adr_opt import Instance, Plan
from adr_opt.common.clock import count_processor_time
from adr_opt.common.options import parsed
from adr_opt.fly.flight import fly
from adr_opt.mission.problem import Problem
from adr_opt.plan.plan import InstanceReference
from adr_opt.run import methods as planner
from solvers.planners import local_search, one_route
from solvers.routes.route_search import RouteSearch
from solvers.routes.target_exchange import Exchanges


def parse(spec: str) -> tuple[str, dict[str, str], str | None, float]:
    """Name, options, bound and time limit [s] of a method as typed."""
    rest, _, limit = spec.partition("@")
    rest, _, bound = rest.partition("+")
    name, _, options = rest.partition(":")
    pairs = dict(pair.split("=", 1) for pair in options.split(",") if pair)
    return name, pairs, bound or None, float(limit or 60.0)


def options_of(name: str, texts: dict[str, str]) -> dict[str, Any]:
    """Values of options given as text."""
    kind = planner.options_of(planner.get(name))
    return {key: parsed(kind, key, text) for key, text in texts.items()}


def plans_campaigns(spec: str) -> bool:
    """Whether a method as typed is for several chasers too."""
    name, _, bound, _ = parse(spec)
    named = [planner.spec(name)]
    named += [] if bound is None else [planner.spec(bound, planner.BOUNDS)]
    return all(each.several for each in named)


def worst_miss_m(instance: Instance, plan: Plan) -> float:
    """Largest miss of an arrival, with each chaser flown by itself [m]."""
    chasers = {chaser.name: chaser for chaser in instance.chasers}
    worst = 0.0
    for route in plan.routes:
        alone = instance.replace(chasers=(chasers[route.chaser],))
        reference = InstanceReference(name=alone.name, sha256=alone.sha256)
        flight = fly(alone, plan.replace(instance=reference, routes=(route,)))
        worst = max(worst, flight.worst_miss_m)
    return worst


def solved(problem: Problem, spec: str) -> tuple[adr_opt.Result, float]:
    """The result of a method as typed, and its time by the clock [s]."""
    name, texts, bound, limit = parse(spec)
    options = options_of(name, texts)
    result, wall, _ = timed(
        lambda: adr_opt.solve(problem, name, time_limit=limit, seed=0, bound=bound, **options)
    )
    return result, wall


def measured(problem: Problem, spec: str, plans: Path | None) -> dict[str, Any]:
    """One plan: solved, checked, flown, and written into a folder if there is one."""
    result, wall = solved(problem, spec)
    plan = result.plan
    assert plan is not None
    if plans is not None:
        plans.mkdir(parents=True, exist_ok=True)
        plan.save(plans / f"{problem.instance.name}-{parse(spec)[0]}.json")
    return {
        "objective": result.objective,
        "upper_bound": plan.upper_bound,
        "gap": plan.gap,
        "status": result.status,
        "delta_v_m_s": plan.delta_v_m_s,
        "wall_s": wall,
        "violations": len(adr_opt.check(problem.instance, plan)),
        "miss_m": worst_miss_m(problem.instance, plan),
    }


def _means(spec: str, rows: list[dict[str, Any]]) -> list[str]:
    """The cells of a method: means over fields."""
    values, walls, bounds, gaps = (
        [each[name] for each in rows if each[name] is not None]
        for name in ("objective", "wall_s", "upper_bound", "gap")
    )
    return [
        spec,
        str(len(rows)),
        f"{mean(values):.2f}",
        f"{min(values):g}–{max(values):g}",
        f"{mean(bounds):.2f}" if len(bounds) == len(rows) else "",
        f"{100 * mean(gaps):.2f} %" if len(gaps) == len(rows) else "",
        str(sum(each["status"] == "optimal" for each in rows)),
        f"{median(walls):.3g} s",
        f"{max(walls):.3g} s",
        str(sum(each["violations"] for each in rows)),
        f"{max(each['miss_m'] for each in rows):.1e} m",
    ]


def quality(
    family: str,
    *methods: str,
    count: int = 20,
    targets: int | None = None,
    chasers: int | None = None,
    stations: int | None = None,
    days: float | None = None,
    dynamics: Literal["two-body", "j2"] | None = None,
    falls: str = "",
    out: Path | None = None,
    plans: Path | None = None,
) -> None:
    """Means over the fields of a family, every plan checked, gaps where there is a bound.

    The time limit starts with a ready timetable. Rows go to ``--out`` as JSON lines when they are
    finished, and a run started again skips what is there. ``--falls``: a target is worth one prize
    after the other, in equal parts of the mission. Methods for one chaser are left out where there
    are several.
    """
    sizes = {"targets": targets, "chasers": chasers, "stations": stations}
    changes = {} if dynamics is None else {"dynamics": dynamics}
    marks = [f"{name[0]}{value}" for name, value in sizes.items() if value is not None]
    marks = [f"n{mark[1:]}" if mark[0] == "t" else mark for mark in marks]
    marks += [] if days is None else [f"{days:g}d"]
    marks += [] if dynamics is None else [dynamics]
    marks += [f"falling-{falls.replace(',', '-')}"] if falls else []
    whole = "-".join([family, *marks])

    def field(seed: int) -> Instance:
        instance = adr_opt.generate(family, seed, **sizes)
        if days is not None:
            instance = instance.with_limits(duration_s=86400.0 * days)
            instance = instance.replace(name=f"{whole}-{seed:03d}")
        return falling(instance.replace(**changes), numbers(falls))

    first = field(0)
    able = [spec for spec in methods if len(first.chasers) == 1 or plans_campaigns(spec)]
    if left_out := sorted(set(methods) - set(able)):
        print(f"for one chaser, left out: {', '.join(left_out)}", file=sys.stderr)
    warm = adr_opt.generate("tiny", 0, chasers=min(2, len(first.chasers)))
    for spec in able:  # compile before the clock starts
        name, texts, bound, _ = parse(spec)
        adr_opt.solve(
            warm.replace(dynamics=first.dynamics),
            name,
            time_limit=20.0,
            iterations=3,
            bound=bound,
            **options_of(name, texts),
        )
    rows: dict[str, list[dict[str, Any]]] = {spec: [] for spec in able}
    built: list[tuple[float, float]] = []
    for seed in range(count):
        made: list[Problem] = []

        def problem(seed: int = seed, made: list[Problem] = made) -> Problem:
            if not made:
                one, wall, spent = timed(lambda: ready(field(seed)))
                made.append(one)
                built.append((wall, spent))
            return made[0]

        for spec in able:
            key = {"family": whole, "seed": seed, "method": spec}
            one = kept(
                out, key, lambda spec=spec, problem=problem: measured(problem(), spec, plans)
            )
            rows[spec].append(one)
            print(f"{key} {one['objective']:g} of {one['upper_bound']}", file=sys.stderr)
    print(f"Family `{whole}`, seeds 0–{count - 1}.")
    head(
        *("method", "fields", "visits, mean", "min–max", "bound, mean", "gap, mean", "proven"),
        *("time, median", "max", "violations", "worst miss"),
    )
    for spec, found in rows.items():
        row(*_means(spec, found))
    if built:
        wall, spent = (median(times) for times in zip(*built, strict=True))
        print(f"\nTimetable besides: {wall:.2g} s, {spent:.2g} s on all cores, medians.", end="")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(f"\nPeak memory of this process: {peak:.1f} GB.")


class Stopped(NamedTuple):
    """A field, planned twice.

    Attributes
    ----------
    proven_s : float
        Time of the proof [s].
    optimum, stopped : float
        Prizes of the proven plan, and after a tenth of the time.
    """

    proven_s: float
    optimum: float
    stopped: float


def _planned(instance: Instance, limit_s: float) -> adr_opt.Result:
    """A plan within a limit that starts with a ready timetable."""
    result = adr_opt.solve(ready(instance), "auto", time_limit=limit_s)
    assert result.plan is None or adr_opt.check(instance, result.plan) == ()
    return result


def stopped(instance: Instance, limit_s: float, least_s: float) -> Stopped | None:
    """Plan a field twice; None where the proof takes too long, or hardly any time."""
    whole = _planned(instance, limit_s)
    if whole.status != "optimal" or whole.runtime_s < least_s:
        return None
    early = _planned(instance, 0.1 * whole.runtime_s)
    return Stopped(whole.runtime_s, whole.objective, early.objective if early.plan else 0.0)


def tenth(
    families: tuple[str, ...] = (
        *("nominal", "reduced-time", "rocket-bodies", "campaign", "removal"),
        *KINDS,
    ),
    count: int = 5,
    limit: float = 120.0,
    least: float = 0.5,
) -> None:
    """Runs stopped at a tenth of the time of their proof: the share of the optimum that they have.

    Plans fields by seed from 0 until they are proven, and again within a tenth of that time, from
    nothing, both with a ready timetable. Families are those of ``generate`` and the kinds of drawn
    orienteering. Fields that are not proven within ``--limit``, or within ``--least`` already, are
    left out.
    """
    _planned(adr_opt.generate("tiny", 0), 5.0)  # compiles
    head("family", "proven", "time, median", "share, mean", "share, least")
    every: list[float] = []
    for family in families:
        tried = [
            stopped(
                instance_of(draw(family, seed, 100))
                if family in KINDS
                else adr_opt.generate(family, seed),
                limit,
                least,
            )
            for seed in range(count)
        ]
        found = [each for each in tried if each is not None]
        shares = [each.stopped / each.optimum for each in found]
        cells = ["–"] * 3
        if found:
            seconds = median(each.proven_s for each in found)
            cells = [f"{seconds:.1f} s", f"{mean(shares):.1%}", f"{min(shares):.1%}"]
        row(family, f"{len(found)} of {count}", *cells)
        every += shares
    if every:
        print(f"\n{len(every)} fields: {mean(every):.1%} of the optimum in the mean")


Mechanism = Literal["strings", "recreation", "moves", "completions", "exchanges"]

PLACES: dict[Mechanism, tuple[tuple[Any, str, Any], ...]] = {
    "strings": tuple((each, "strings_of", None) for each in (one_route, local_search)),
    "recreation": tuple((each, "recreate", ()) for each in (one_route, local_search)),
    "moves": ((RouteSearch, "move", None), (RouteSearch, "complete", None)),
    "completions": ((RouteSearch, "complete", None),),
    "exchanges": ((Exchanges, "anneal", False),),
}
"""Where each mechanism of a search is called, and what it returns when it does nothing."""


class Searched(NamedTuple):
    """What a plan collects and spends [m/s], and the mechanisms that its search called."""

    prizes: float
    delta_v_m_s: float
    called: frozenset[Mechanism]


def _searched(
    instance: Instance, method: str, limit_s: float, left_out: Mechanism | None
) -> Searched:
    """A plan within a limit of processor time that starts with a ready timetable."""
    few = instance.replace(targets=instance.targets[:8])
    adr_opt.solve(few, method, time_limit=5.0)  # compiles
    problem, called = ready(instance), set[Mechanism]()

    def replaced(mechanism: Mechanism, usual: Callable[..., Any], nothing: Any) -> Any:
        def does(*given: Any, **named: Any) -> Any:
            called.add(mechanism)
            return nothing if mechanism == left_out else usual(*given, **named)

        return does

    for mechanism, places in PLACES.items():
        for owner, name, nothing in places:
            setattr(owner, name, replaced(mechanism, getattr(owner, name), nothing))
    count_processor_time()
    result = adr_opt.solve(problem, method, time_limit=limit_s)
    assert result.plan is not None
    assert adr_opt.check(instance, result.plan) == ()
    return Searched(result.objective, result.plan.delta_v_m_s, frozenset(called))


def without(
    *families: str,
    mechanisms: tuple[Mechanism, ...] = ("strings", "recreation", "moves", "exchanges"),
    targets: int | None = None,
    chasers: int | None = None,
    falls: str = "",
    method: str = "auto",
    limit: float = 20.0,
    count: int = 6,
    first: int = 400,
) -> None:
    """What mechanisms of a search are worth: plans with all and without one at equal work.

    Work is processor time, each plan is made in a process of its own, and a mechanism is left out
    where the whole search calls it. Families are those of ``generate``, from seed ``--first`` on.
    Leads are those of the whole search, with their standard error; those in ΔV of fields where
    both collect as much.
    """
    head("family", "left out", "prizes", "without", "lead", "lead of each field", "ΔV saved")
    for family in families:
        pairs: dict[Mechanism, list[tuple[Searched, Searched]]] = {}
        for seed in range(first, first + count):
            drawn = adr_opt.generate(family, seed, targets=targets, chasers=chasers)
            instance = falling(drawn, numbers(falls))
            whole = alone(_searched, instance, method, limit, None)
            for mechanism in sorted(whole.called & {*mechanisms}):
                part = alone(_searched, instance, method, limit, mechanism)
                pairs.setdefault(mechanism, []).append((whole, part))
                print(family, seed, mechanism, *whole[:2], *part[:2], file=sys.stderr, flush=True)
        for mechanism, both in pairs.items():
            leads = [whole.prizes - part.prizes for whole, part in both]
            saved = [w.delta_v_m_s - p.delta_v_m_s for w, p in both if w.prizes == p.prizes]
            row(
                *(family, mechanism),
                *(f"{mean(pair[side].prizes for pair in both):.2f}" for side in (0, 1)),
                _with_error(leads),
                " ".join(f"{lead:+g}" for lead in leads),
                _with_error([-each for each in saved]) if saved else "",
            )


def _with_error(values: list[float]) -> str:
    """Mean of values and its standard error."""
    error = stdev(values) / math.sqrt(len(values)) if len(values) > 1 else math.nan
    return f"{mean(values):+.2f} ± {error:.2f}"


if __name__ == "__main__":
    sys.exit(experiment(__doc__, quality, tenth, without))
