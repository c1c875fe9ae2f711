"""Size: timetables, first bounds, and growth of plans, time and memory with the number of targets.

python bench/scale.py timetable
python bench/scale.py targets                             # nominal, 50 to 10,000 targets
python bench/scale.py targets --dense --targets 200 500   # against the table of all pairs
python bench/scale.py targets --family large --targets 1500 --chasers 2
python bench/scale.py limits --processor     # every method, by rows and by orbits
python bench/scale.py paces                               # work of a timetable, in seconds
"""

from __future__ import annotations

import math
import resource
import subprocess
import sys
import time
from itertools import product
from statistics import fmean, median
from typing import Literal

import numpy as np
from fields import INSTANCES, on_rows
from tables import alone, experiment, head, row, timed, times_s

import adr_opt
from adr_opt.common.clock import count_processor_time, now_s
from adr_opt.common.errors import InputError
from adr_opt.common.processors import usable_cores
from adr_opt.common.progress import silent
from adr_opt.common.stop import MaxIterations
from adr_opt.kernels.tables.timetable_making import WAVE
from adr_opt.legs.connection_finder import estimate
from adr_opt.legs.nearest_pairs import nearest_pairs
from adr_opt.mission.problem import Problem
from adr_opt.problem.support import follows_all
from adr_opt.run.methods import PLANNERS, names, spec
from adr_opt.run.table_budget import looked_at
from adr_opt.sources.generator.families import FAMILIES
from solvers.progress.gap import GapTracker
from solvers.proof.proof import Proof, ProofOptions


def first_bound(mission: adr_opt.Mission, jobs: int) -> float:
    """The first bound of a proof, with the usual options."""
    certificate = GapTracker(mission, silent)
    proof = Proof(mission, certificate, MaxIterations(1), ProofOptions(jobs=jobs))
    proof.begin()
    proof.close()
    return certificate.bound


def _spread(what: str, times: list[float], unit: str = "s", scale: float = 1.0) -> None:
    """A row with least, median and greatest of some times."""
    least, most = min(times), max(times)
    row(what, *(f"{scale * each:.3g} {unit}" for each in (least, median(times), most)))


def timetable(runs: int = 9) -> None:
    """Speed of timetable, greedy plan and first bound, on one core and on all, and of processes.

    Medians of several runs in one process after a warm-up.
    """
    instance = adr_opt.generate("nominal", 0)
    built = adr_opt.Timetable(instance)
    cores, entries = usable_cores(), built.entries
    head("work", "min", "median", "max")
    one, many = (
        times_s(lambda jobs=jobs: adr_opt.Timetable(instance, jobs), runs) for jobs in (1, cores)
    )
    for name, times in ((f"{entries} entries, 1 core", one), (f"the same, {cores} cores", many)):
        least_median_most = min(times), median(times), max(times)
        cells = (f"{t:.3f} s ({t / entries * 1e6:.3f} µs/entry)" for t in least_median_most)
        row(f"timetable, {name}", *cells)
    row(f"speed-up on {cores} cores", "", f"{median(one) / median(many):.2f} ×", "")
    mission = adr_opt.Mission(instance, built)
    mission.rules  # noqa: B018  the arrays of the rules are part of a ready timetable
    plans = [adr_opt.solve(mission, "greedy").runtime_s for _ in range(runs)]
    _spread("greedy sequence from a ready timetable", plans, "ms", 1e3)
    whole = times_s(lambda: adr_opt.solve(mission, "greedy"), runs)
    _spread("the same with legs, burns and reasons", whole, "ms", 1e3)
    for jobs in dict.fromkeys((1, cores)):
        times = times_s(lambda jobs=jobs: first_bound(mission, jobs), runs)
        on = "1 core" if jobs == 1 else f"{jobs} cores"
        bound = f"{first_bound(mission, jobs):g}"
        _spread(f"first bound of {bound} from a ready timetable, {on}", times)
    file = str(INSTANCES / "nominal" / "nominal-000.json")
    for name, words in (
        ("import adr_opt", ["-c", "import adr_opt"]),
        ("solve --method greedy", ["-m", "adr_opt", "solve", file, "--method", "greedy"]),
    ):
        command = [sys.executable, *words]
        times = times_s(
            lambda command=command: subprocess.run(command, check=True, capture_output=True), 5
        )
        _spread(f"process: {name}", times)


def _measured(
    family: str, seed: int, sizes: dict[str, int], limit_s: float, dense: bool
) -> dict[str, float]:
    """Plan one instance, and say what it took."""
    # What is compiled on first use is not measured.
    adr_opt.solve(adr_opt.generate("tiny", 0), "auto", iterations=2)
    instance = adr_opt.generate(family, seed, **sizes)
    began = time.perf_counter()
    problem = Problem(instance)
    if dense:
        problem.build(None)
    spent = time.perf_counter() - began
    result = adr_opt.solve(problem, "auto", time_limit=max(1.0, limit_s - spent))
    return {
        "wall_s": time.perf_counter() - began,
        "near": looked_at(problem.missions[0].timetable),
        "visits": result.objective,
        "bound": result.upper_bound,
        "memory_gib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20,
        "violations": 1 if result.plan is None else len(adr_opt.check(instance, result.plan)),
    }


def targets(
    family: str = "nominal",
    targets: tuple[int, ...] = (50, 100, 200, 500, 1000, 2000, 5000, 10_000),
    chasers: int = 1,
    limit: float = 60.0,
    seeds: int = 1,
    dense: bool = False,
) -> None:
    """Growth of plans, time and memory with the number of targets.

    Every run is a process of its own: drawn, planned by `auto` within the limit, and checked.
    *Near* is for how many destinations of each body the timetable has room and time, or at how many
    planners look that ask for rows on demand; *bound* is what no plan is worth more than, of all
    pairs, and *gap* how far below it the plan is; *all s* is everything from the instance on.
    Exponents are those of the line through all points from 1,000 targets on (of logarithms). With
    `--dense` the same limit is spent on the table of all pairs, as far as it goes.
    """
    head("targets", "near", "visits", "bound", "gap", "all s", "GiB", "violations")
    several = {"chasers": chasers} if chasers > 1 else {}
    large = []
    for count in targets:
        sizes = {"targets": count, **several}
        found = [alone(_measured, family, seed, sizes, limit, dense) for seed in range(seeds)]
        of = {key: fmean(each[key] for each in found) for key in found[0]}
        bounded = math.isfinite(of["bound"])
        row(
            count,
            f"{of['near']:.0f}",
            f"{of['visits']:.1f}",
            f"{of['bound']:.1f}" if bounded else "–",
            f"{100.0 * (1.0 - of['visits'] / of['bound']):.1f} %" if bounded else "–",
            f"{of['wall_s']:.1f}",
            f"{of['memory_gib']:.2f}",
            f"{sum(each['violations'] for each in found):.0f}",
        )
        large += [(count, of)] if count >= 1000 else []
    if len(large) > 1:
        counts = np.log([count for count, _ in large])
        for key in ("wall_s", "memory_gib", "visits"):
            slope = np.polyfit(counts, np.log([of[key] for _, of in large]), 1)[0]
            print(f"\n{key} grows as targets^{slope:.2f} from 1000 targets on")


def paces(families: tuple[str, ...] = (), pairs: int = 200) -> None:
    """Time to build a pair of a timetable on one core, per departure event, by processor time."""
    head("field", "events", "connections of a pair", "a pair", "per event", "expected")
    fields = {name: adr_opt.generate(name, 0) for name in families or FAMILIES}
    if not families:
        fields["rows"] = on_rows(200)
    for name, instance in fields.items():
        size, near = estimate(instance), nearest_pairs(instance, (), WAVE)
        adr_opt.Timetable(instance, 1, pairs=near, most=pairs)  # kernels are loaded
        built, _, spent = timed(
            lambda: adr_opt.Timetable(instance, 1, pairs=near, most=pairs)  # noqa: B023
        )
        row(
            name,
            size.events,
            f"{sum(built.connecting.counts.values()) / built.built:.0f}",
            f"{spent / built.built * 1e6:.0f} µs",
            f"{spent / built.built / size.events * 1e6:.2f} µs",
            f"{size.event_s * 1e6:.2f} µs",
        )


def _field(kind: str, targets: int, chasers: int = 1, seed: int = 0) -> adr_opt.Instance:
    """A field by rows, or a nominal one by orbits, for some chasers that are all alike."""
    made = (
        on_rows(targets, seed=seed)
        if kind == "rows"
        else adr_opt.generate("nominal", seed, targets=targets)
    )
    fleet = (made.chaser.replace(name=f"chaser-{number}") for number in range(1, chasers + 1))
    return made.replace(chasers=tuple(fleet))


def _within(
    kind: str, targets: int, chasers: int, method: str, limit_s: float, seed: int, processor: bool
) -> dict[str, float]:
    """Plan one field within a limit: time of the first plan and of everything, and the prizes."""
    adr_opt.solve(_field(kind, 12, chasers), method, time_limit=2.0)
    instance = _field(kind, targets, chasers, seed)
    if processor:
        count_processor_time()
    first, began = [math.nan], now_s()

    def heard(incumbent: float, bound: float) -> None:
        if math.isnan(first[0]) and incumbent > -math.inf:
            first[0] = now_s() - began

    result = adr_opt.solve(instance, method, time_limit=limit_s, progress=heard, seed=seed)
    took_s = now_s() - began
    return {
        "first_s": took_s if math.isnan(first[0]) else first[0],
        "took_s": took_s,
        "prizes": result.objective,
        "violations": 0 if result.plan is None else len(adr_opt.check(instance, result.plan)),
    }


def limits(
    kinds: tuple[Literal["rows", "orbits"], ...] = ("rows", "orbits"),
    targets: tuple[int, ...] = (50, 500, 5000),
    chasers: tuple[int, ...] = (1, 3),
    limit: tuple[float, ...] = (1.0, 10.0, 30.0),
    methods: tuple[str, ...] = (),
    seed: int = 0,
    processor: bool = False,
) -> None:
    """Within each limit, what every method takes, how much of that to its first plan, its prizes.

    Every run is a process of its own, in which the method has practised. *Late* marks those that
    take more than 1.2 times the limit and half a second. With `--processor` all times, and the
    limit, are those of processors, of all threads together, whatever else the machine does.
    """
    head("field", "chasers", "method", *(f"{each:g} s: all, first plan, prizes" for each in limit))
    for kind, count, fleet in product(kinds, targets, chasers):
        for method in methods or names(PLANNERS):
            if not follows_all(_field(kind, 5, fleet), spec(method).follows):
                continue
            cells = []
            for limit_s in limit:
                try:
                    found = alone(_within, kind, count, fleet, method, limit_s, seed, processor)
                except InputError:  # too large a field for it
                    cells.append("refused")
                    continue
                cells.append(
                    f"{found['took_s']:.2f}, {found['first_s']:.2f}, {found['prizes']:g}"
                    + " late" * (found["took_s"] > 1.2 * limit_s + 0.5)
                    + f" {found['violations']:g} violations" * (found["violations"] > 0)
                )
            row(f"{count} by {kind}", fleet, f"`{method}`", *cells)


if __name__ == "__main__":
    sys.exit(experiment(__doc__, timetable, targets, paces, limits))
