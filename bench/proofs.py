"""Proofs: what they take, what verifying them takes, and those of campaigns by columns alone.

python bench/proofs.py verify nominal --count 20
python bench/proofs.py lists nominal-000 nominal-018
python bench/proofs.py columns campaign 0-19 --limit 120
python bench/proofs.py set-up
python bench/proofs.py captures 0-19
"""

from __future__ import annotations

import resource
import sys
import time
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from fields import INSTANCES, best_known, falling, numbers, ready
from tables import alone, experiment, head, row, timed

import adr_opt
from adr_opt.analysis.windows import STATIONS, CaptureConditions, windows_of
from adr_opt.analysis.windows.intervals import lasting
from adr_opt.common.errors import InputError
from adr_opt.common.progress import silent
from adr_opt.common.stop import MaxIterations
from adr_opt.judge.verify.lists import Lists
from adr_opt.mission.certify import certificate_of
from adr_opt.mission.result import Result
from adr_opt.plan.certificate import Certificate
from adr_opt.problem.instance import Instance
from adr_opt.sources.library import load_library
from solvers.columns.proof import ColumnProof
from solvers.progress.gap import GapTracker
from solvers.proof.proof import Proof, ProofOptions
from solvers.routes.route_pool import RoutePool


def _proven(instance: Instance, method: str, limit_s: float) -> tuple[Result, Certificate]:
    result = adr_opt.solve(instance, method, time_limit=limit_s)
    return result, certificate_of(instance, result)


def verify(
    *families: str,
    first: int = 0,
    count: int | None = None,
    method: str = "exact",
    limit: float = 300.0,
) -> None:
    """Cost of verifying a proof, against that of the proof.

    For each field of the families in the library a proof, its certificate, and ``verify`` of both
    with the 1,000 connections that are sampled by default. Processor time of all threads, with
    kernels that are compiled already, and wall time beside it; both begin with the instance.
    """
    library = load_library(INSTANCES / "library.json")
    tiny = library.of_family("tiny")[0].generate()
    proven, certificate = _proven(tiny, method, 60.0)  # compiles
    adr_opt.verify(tiny, proven.plan, certificate)
    head(
        *("field", "objective", "bound", "bound verified", "proof, processor s", "wall s"),
        *("`verify`, processor s", "wall s", "ratio", "labels", "bytes", "verified"),
    )
    ratios = []
    last = None if count is None else first + count
    for entry in (one for family in families for one in library.of_family(family)[first:last]):
        try:
            (result, certificate), wall, cpu = timed(
                lambda entry=entry: _proven(entry.generate(), method, limit)
            )
        except InputError as error:
            row(entry.name, *[""] * 10, error)
            continue
        verdict, own_wall, own_cpu = timed(
            lambda: adr_opt.verify(entry.generate(), result.plan, certificate)  # noqa: B023
        )
        ratios.append(own_cpu / cpu)
        row(
            entry.name,
            *(f"{each:g}" for each in (result.objective, result.upper_bound, verdict.upper_bound)),
            *(f"{each:.1f}" for each in (cpu, wall, own_cpu, own_wall)),
            f"{ratios[-1]:.2f}",
            f"{verdict.labels:,}",
            f"{len(certificate.to_json()):,}",
            "yes" if verdict.verified else "no: " + "; ".join(verdict.reasons),
        )
    if ratios:
        print(
            f"\nRatio of processor times: median {median(ratios):.2f}, largest {max(ratios):.2f}, "
            f"of {len(ratios)}."
        )


def lists(*fields: str, certificates: str = "", limit: float = 300.0) -> None:
    """Cost of checking a proof by its list of closed labels.

    For each field of the library its certificate in ``instances/certificates``, or in a folder of
    ``--certificates``, or that of a proof by ``exact``. Without sampled connections: ``verify``
    makes the list and writes it, and checks it once more from the file, with the rows of labels
    that dominate.
    """
    head(
        *("field", "bound", "labels made", "labels in the list", "ends", "list, MB"),
        *("without ends", "made and checked, processor s", "checked, processor s", "verified"),
    )
    library = load_library(INSTANCES / "library.json")
    kept = Path(certificates) if certificates else INSTANCES / "certificates"
    for name in fields:
        (entry,) = (
            each for each in library.of_family(name.rpartition("-")[0]) if each.name == name
        )
        shipped = kept / f"{name}.json.gz"
        if shipped.exists():
            certificate = adr_opt.load_certificate(shipped)
        else:
            certificate = _proven(entry.generate(), "exact", limit)[1]
        with TemporaryDirectory() as folder:
            path = Path(folder) / "labels.npz"
            made, _, making = _verified(entry.generate(), certificate, save_labels=path)
            given = Lists.load(path, certificate)
            sizes = [path.stat().st_size]
            listed = []
            while (each := given.next()) is not None:
                listed.append(each)
            given.checked = [each._replace(row=None) for each in listed]
            given.save(Path(folder) / "narrow.npz", certificate)
            sizes.append((Path(folder) / "narrow.npz").stat().st_size)
            checked, _, checking = _verified(entry.generate(), certificate, labels=path)
        row(
            name,
            f"{checked.upper_bound:g}",
            f"{made.labels:,}",
            f"{sum(each.labels.body.size for each in listed):,}",
            f"{sum(each.row.size for each in listed):,}",
            *(f"{size / 1e6:.2f}" for size in sizes),
            *(f"{each:.1f}" for each in (making, checking)),
            "yes" if checked.verified else "no: " + "; ".join(checked.reasons),
        )


def _verified(
    instance: Instance, certificate: Certificate, **files: Path
) -> tuple[adr_opt.Verdict, float, float]:
    """The verdict on the bound alone, wall time and processor time."""
    return timed(lambda: adr_opt.verify(instance, None, certificate, connections=0, **files))


class ProcessorTime:
    """Stopping criterion: seconds of processor time."""

    def __init__(self, limit_s: float) -> None:
        self._end = time.process_time() + limit_s

    def remaining_s(self) -> float:
        """What is left [s]."""
        return self._end - time.process_time()

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether it is over."""
        return self.remaining_s() <= 0.0


def seeds_of(text: str) -> list[int]:
    """Numbers and ranges as typed: 3,8,11-13."""
    parts = [part.partition("-") for part in text.split(",")]
    return [seed for first, _, last in parts for seed in range(int(first), int(last or first) + 1)]


def columns(family: str, seeds: str, limit: float = 120.0, falls: str = "") -> None:
    """Proofs of campaigns by column generation alone, in processor time.

    ``seeds`` are numbers and ranges: 3,8,11-13. Each proof begins with the plan of
    ``instances/best-known.csv``, on one core and with a ready timetable; limits and times are
    seconds of processor time, so that other work on the machine hardly counts. A proof may find a
    better plan. ``--falls 2,1``: every target is worth one number after the other, in equal parts
    of the mission.
    """
    head("field", "known", "plan", "bound", "proven", "cuts", "columns", "labels", "processor time")
    known = best_known()
    for seed in seeds_of(seeds):
        problem = ready(falling(adr_opt.generate(family, seed), numbers(falls)))
        name = problem.instance.name
        tracker, pool = GapTracker(problem, silent), RoutePool(problem)
        routes = [
            tuple(map(int, route.split("-"))) if route else ()
            for route in known[name]["order"].split("/")
        ]
        tracker.offer(*routes)
        for kind, route in zip(problem.kind_of, routes, strict=True):
            pool.add(kind, route)
        begun, stop, began = tracker.incumbent, ProcessorTime(limit), time.process_time()
        proof = ColumnProof(problem, tracker, pool, 0, stop, ProofOptions(jobs=1))
        proof.begin()
        while not (proof.done or tracker.proven or stop.remaining_s() <= 0.0):
            proof.advance(lambda stop=stop: stop.remaining_s() <= 0.0)
        spent, counted = time.process_time() - began, proof.counters
        proof.close()
        row(
            name,
            f"{begun:g}",
            f"{tracker.incumbent:g}",
            f"{tracker.bound:.6g}",
            "yes" if tracker.proven else "no",
            f"{counted['cuts']:g}",
            f"{counted['columns']:g}",
            f"{counted['labels']:,}",
            f"{spent:.1f} s",
        )


FIELDS = (
    ("nominal", 50, 0),
    ("nominal", 50, 6),
    ("nominal", 100, 0),
    ("reduced-time", 50, 0),
    ("reduced-fuel", 50, 0),
    ("cloud", 50, 0),
)
"""Family, targets, zones."""


def resident() -> int:
    """Memory that the process takes now [bytes]."""
    with open("/proc/self/status", encoding="utf-8") as lines:
        return next(1024 * int(line.split()[1]) for line in lines if line.startswith("VmRSS"))


def proof_of(mission: adr_opt.Mission, jobs: int) -> Proof:
    """A proof that gives up at its first labels."""
    options = ProofOptions(jobs=jobs, most_labels=1)
    return Proof(mission, GapTracker(mission, silent), MaxIterations(10**6), options)


def begun(mission: adr_opt.Mission) -> None:
    """Bring a proof as far as its first search."""
    proof = proof_of(mission, 0)
    proof.begin()
    proof.advance(lambda: False)
    proof.close()


def _set_up(family: str, targets: int, zones: int, runs: int) -> tuple[int, float, float]:
    """Entries of a field, time of setting up a proof [s], and memory that it takes [bytes]."""
    begun(adr_opt.Mission(adr_opt.generate("tiny", 0)))
    mission = adr_opt.Mission(adr_opt.generate(family, 0, targets=targets, zones=zones))
    entries = mission.timetable.entries
    before = resident()
    begun(mission)
    peak = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    taken = median(timed(lambda: proof_of(mission, 1).close())[2] for _ in range(runs))
    return entries, taken, peak


def set_up(runs: int = 3) -> None:
    """Set-up cost of a proof per timetable entry: time on one core, and memory.

    Each field in a process of its own, after a warm-up on a tiny one. The time is that of the part
    that cannot be broken off, with one thread; the memory is the peak of the process over what it
    took with a ready timetable, after a first search that ended at its first labels.
    ``solvers.progress.proof_size`` holds the greatest figures, rounded up.
    """
    head("field", "entries", "set-up, 1 core", "per entry", "peak memory", "per entry")
    for family, targets, zones in FIELDS:
        entries, taken, peak = alone(_set_up, family, targets, zones, runs)
        row(
            f"{family}, {targets} targets, {zones} zones",
            entries,
            f"{taken:.2f} s",
            f"{1e6 * taken / entries:.2f} µs",
            f"{peak / 1e6:.0f} MB",
            f"{peak / entries:.0f} B",
        )


SEEN_BY = "svalbard", "troll", "kourou"
"""Stations of which one sees captures: about a hundred passes of each target in a week."""


def captured(instance: Instance, *stations: str) -> Instance:
    """A field whose targets are captured in ten minutes, in light and seen by stations."""
    seen_by = tuple(STATIONS[name] for name in stations)
    found = windows_of(instance, CaptureConditions(light=True, stations=seen_by))
    return instance.with_windows(
        {name: lasting(each, 600.0) for name, each in found.items()}, capture_s=600.0
    )


def captures(seeds: str, limit: float = 60.0) -> None:
    """Proofs and timetables with and without windows of captures.

    Fields of `nominal` in light and contact, and the table of a campaign of two years in light.
    """
    head(
        "field",
        "windows a target",
        "proof, processor s",
        "the same in windows",
        "ratio",
        "plan",
        "in windows",
    )
    adr_opt.solve(captured(adr_opt.generate("tiny", 0), *SEEN_BY), "exact", time_limit=60.0)
    ratios, proven = [], 0
    for seed in seeds_of(seeds):
        plain = adr_opt.generate("nominal", seed)
        made = captured(plain, *SEEN_BY)
        (one, _, before), (other, _, after) = (
            timed(lambda each=each: adr_opt.solve(each, "exact", time_limit=limit))
            for each in (plain, made)
        )
        ratios.append(after / before)
        proven += other.status == "optimal"
        results = (f"{each.objective:g} of {each.upper_bound:g}" for each in (one, other))
        count = median(len(made.intervals_of(target)) for target in made.targets)
        row(made.name, f"{count:g}", f"{before:.1f}", f"{after:.1f}", f"{ratios[-1]:.2f}", *results)
    print(f"\nProven in {limit:g} s: {proven} of {len(ratios)}; ratio {median(ratios):.2f}.\n")
    plain = adr_opt.generate("rocket-bodies", 0)
    made = captured(plain)
    head("field", "windows a target", "timetable, processor s", "in windows", "ratio")
    before_s, after_s = (
        median(timed(lambda each=each: adr_opt.Timetable(each, 1))[2] for _ in range(4))
        for each in (plain, made)
    )
    count = median(len(made.intervals_of(target)) for target in made.targets)
    times = f"{before_s:.2f}", f"{after_s:.2f}", f"{after_s / before_s:.2f}"
    row(plain.name, f"{count:g}", *times)


if __name__ == "__main__":
    sys.exit(experiment(__doc__, verify, lists, columns, set_up, captures))
