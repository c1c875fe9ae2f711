"""Screening of ten days against a drawn catalogue: time, memory, and brute force."""

from __future__ import annotations

import csv
import resource
import tempfile
from pathlib import Path

import numpy as np
from population import write_population
from scipy.optimize import minimize_scalar
from tables import head, row, timed

import adr_opt
from adr_opt.analysis.screening import CloseApproach, screen
from adr_opt.analysis.screening.flown import FlownArc, flown_arcs
from adr_opt.common.constants import DAY_S
from adr_opt.plan.refined_plan import RefinedPlan
from adr_opt.problem.frame import Frame
from adr_opt.problem.instance import Instance
from adr_opt.sources import catalogue

FEW = 20
"""Objects that brute force moves at once."""


def flown(days: float, seed: int) -> tuple[Instance, RefinedPlan]:
    """A refined plan in a drawn cloud, of at least so many days."""
    drawn = adr_opt.generate("cloud", seed)
    instance = drawn.replace(frame=Frame(name="TEME", axes_epoch=drawn.epoch))
    plan = adr_opt.solve(instance, "greedy").plan
    assert plan is not None
    legs = [leg for leg in plan.legs if leg.departure_s < days * DAY_S]
    short = instance.with_limits(duration_s=max(legs[-1].done_s, days * DAY_S))
    plan = adr_opt.solve(short, "greedy").plan
    assert plan is not None
    return short, adr_opt.refine(short, plan, jobs=1)


def screened(
    objects: int = 24_000,
    days: float = 10.0,
    checked: int = 2_000,
    checked_days: float = 1.0,
    events: int = 50,
    seed: int = 7,
) -> None:
    """Time and memory of screening; what each second of python-sgp4 finds, and what it misses.

    ``checked`` objects, drawn, are moved by python-sgp4 alone, initialised from the same file, each
    second of the first ``checked_days``; ``events`` of all days are found once more by it alone.
    """
    instance, refined = flown(days, seed)
    arcs = list(flown_arcs(instance, refined))
    span = (arcs[-1].times_s[-1] - arcs[0].times_s[0]) / DAY_S
    with tempfile.TemporaryDirectory() as folder:
        path, _ = write_population(Path(folder), objects, seed)
        records = catalogue.read([path]).records
        with path.open(encoding="utf-8") as lines:
            rows = list(csv.DictReader(lines))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    found, wall_s, processor_s = timed(lambda: screen(instance, refined, records))
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    head(
        "objects",
        "days",
        "approaches within 5 km",
        "s",
        "processor s",
        "GB in all",
        "of them before",
    )
    row(
        *(len(records), f"{span:.1f}", len(found), f"{wall_s:.0f}", f"{processor_s:.0f}"),
        *(f"{each * 1024 / 1e9:.2f}" for each in (after, before)),
    )
    some = np.random.default_rng(seed).choice(len(rows), min(checked, len(rows)), replace=False)
    wide_m, until_s = 50e3, arcs[0].times_s[0] + checked_days * DAY_S
    mine = [
        each
        for each in screen(instance, refined, [records[at] for at in some], distance_m=wide_m)
        if each.time_s < until_s - 10.0
    ]
    head("what", "found", "missing", "miss m", "time s above 100 m/s")
    row(
        f"{some.size} objects, {checked_days:g} days",
        *_brute(instance, arcs, rows, some, until_s, wide_m, mine),
    )
    chosen = np.random.default_rng(seed).permutation(len(found))[:events]
    row("python-sgp4 alone", *_alone(instance, arcs, rows, [found[at] for at in chosen]))


def _satellite(line: dict[str, str]):
    """A satellite of python-sgp4 by a row of a file of elements."""
    from sgp4 import omm
    from sgp4.api import Satrec

    satellite = Satrec()
    omm.initialize(satellite, line)
    return satellite


def _days(instance: Instance) -> tuple[float, float]:
    from sgp4.api import jday

    now = instance.epoch
    return jday(now.year, now.month, now.day, now.hour, now.minute, now.second)


def _least(instance: Instance, arc: FlownArc, satellite, near_s: float) -> tuple[float, float]:
    """Time and value of the least distance about a time, by python-sgp4 alone."""
    day, fraction = _days(instance)

    def apart_m(time_s: float) -> float:
        _, position, _ = satellite.sgp4(day, fraction + time_s / DAY_S)
        return float(np.linalg.norm(1e3 * np.array(position) - arc.at(np.array([time_s]))[0, :3]))

    low, high = max(near_s - 2.0, arc.times_s[0]), min(near_s + 2.0, arc.times_s[-1])
    best = minimize_scalar(apart_m, bounds=(low, high), method="bounded", options={"xatol": 1e-6})
    ends = [(apart_m(each), each) for each in (low, high)]
    miss_m, time_s = min([(float(best.fun), float(best.x)), *ends])
    return time_s, miss_m


def _brute(instance, arcs, rows, some, until_s, wide_m, mine):
    """Least distances of each second, against those that were found."""
    from sgp4.api import SatrecArray

    day, fraction = _days(instance)
    left = {(each.object_id, each.leg, round(each.time_s)): each for each in mine}
    count, missing, worst_m, worst_s = 0, 0, 0.0, 0.0
    for at in range(0, some.size, FEW):
        lines = [rows[each] for each in some[at : at + FEW]]
        satellites = [_satellite(line) for line in lines]
        array = SatrecArray(satellites)
        for arc in arcs:
            last = min(arc.times_s[-1], until_s)
            if arc.times_s.size < 2 or arc.times_s[0] >= last:
                continue
            times = np.append(np.arange(arc.times_s[0], last, 1.0), last)
            _, places, _ = array.sgp4(np.full(times.size, day), fraction + times / DAY_S)
            far = np.linalg.norm(1e3 * places - arc.at(times)[None, :, :3], axis=2)
            padded = np.pad(far, ((0, 0), (1, 1)), constant_values=np.inf)
            least = (far <= padded[:, :-2]) & (far <= padded[:, 2:]) & (far < wide_m + 16e3)
            for one, sample in np.argwhere(least):
                time_s, miss_m = _least(instance, arc, satellites[one], float(times[sample]))
                if miss_m > wide_m - 1.0 or time_s > until_s - 11.0:
                    continue
                count += 1
                name = lines[one]["OBJECT_ID"]
                keys = ((name, arc.leg, round(time_s) + by) for by in (0, -1, 1))
                same = next((left[key] for key in keys if key in left), None)
                if same is None:
                    missing += 1
                    continue
                worst_m = max(worst_m, abs(same.miss_m - miss_m))
                if same.speed_m_s > 100.0:
                    worst_s = max(worst_s, abs(same.time_s - time_s))
    return count, missing, f"{worst_m:.3f}", f"{worst_s:.4f}"


def _alone(instance, arcs, rows, events: list[CloseApproach]):
    """The same events by python-sgp4 alone."""
    by_id, worst_m, worst_s = {line["OBJECT_ID"]: line for line in rows}, 0.0, 0.0
    for each in events:
        arc = next(
            arc
            for arc in arcs
            if arc.leg == each.leg
            and arc.times_s[0] - 1e-6 <= each.time_s <= arc.times_s[-1] + 1e-6
            and arc.phase == each.phase
        )
        time_s, miss_m = _least(instance, arc, _satellite(by_id[each.object_id]), each.time_s)
        worst_m = max(worst_m, abs(each.miss_m - miss_m))
        if each.speed_m_s > 100.0:
            worst_s = max(worst_s, abs(each.time_s - time_s))
    return len(events), 0, f"{worst_m:.3f}", f"{worst_s:.4f}"
