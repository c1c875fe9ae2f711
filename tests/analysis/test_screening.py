"""Screening: every approach is found, and is what SGP4 and the refined plan say."""

from __future__ import annotations

import csv
import json
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest
from conftest import Cli
from serve_catalogue import catalogue

import adr_opt
from adr_opt.analysis.screening import Approach, screen
from adr_opt.analysis.screening.flown import FlownArc, flown_arcs
from adr_opt.common.errors import InputError
from adr_opt.plan.refined_plan import RefinedPlan
from adr_opt.problem.frame import Frame
from adr_opt.problem.instance import Instance
from adr_opt.sources.catalogue.reading import read_bytes
from adr_opt.sources.catalogue.records import ElementSet

sgp4 = pytest.importorskip("sgp4.api")
pytest.importorskip("erfa")

DISTANCE_M = 250_000.0
"""Far enough that a few objects come near in hours."""


@pytest.fixture(scope="module")
def refined() -> tuple[Instance, RefinedPlan]:
    """A short plan with a frame, refined."""
    drawn = adr_opt.generate("nominal", 711, targets=4)
    epoch = datetime.fromisoformat("2026-01-03T06:00:00+00:00")
    instance = drawn.replace(
        dynamics="j2",
        epoch=epoch,
        frame=Frame(name="TEME", axes_epoch=epoch),
        mission=drawn.mission.replace(duration_s=50_000.0),
    )
    plan = adr_opt.solve(instance, "greedy").plan
    assert plan is not None
    assert plan.legs
    return instance, adr_opt.refine(instance, plan)


@pytest.fixture(scope="module")
def records() -> tuple[ElementSet, ...]:
    """Objects on orbits near those of the plan."""
    return tuple(read_bytes(catalogue(60, seed=5), "drawn").records)


def distances(
    arc: FlownArc, record: ElementSet, instance: Instance, times: np.ndarray
) -> np.ndarray:
    """Distances of an object from a chaser by python-sgp4 alone [m]."""
    satellite = sgp4.Satrec.twoline2rv(*record_lines(record))
    since_s = (instance.epoch - record.epoch).total_seconds()
    places = [satellite.sgp4_tsince((since_s + t) / 60.0)[1] for t in times]
    return np.linalg.norm(1e3 * np.array(places) - arc.at(times)[:, :3], axis=1)


def record_lines(record: ElementSet) -> list[str]:
    """Its two lines in the catalogue."""
    lines = catalogue(60, seed=5).decode().splitlines()
    at = next(row for row, line in enumerate(lines) if line.startswith(f"1 {record.number:05d}U"))
    return lines[at : at + 2]


def nearest(
    arc: FlownArc, record: ElementSet, instance: Instance, step_s: float
) -> list[tuple[float, float]]:
    """Times and values of all least distances within the limit, ends included, by small steps."""
    times = np.append(np.arange(arc.times_s[0], arc.times_s[-1], step_s), arc.times_s[-1])
    far = distances(arc, record, instance, times)
    padded = np.concatenate([[np.inf], far, [np.inf]])
    found = []
    for at in np.flatnonzero((far <= padded[:-2]) & (far <= padded[2:]) & (far < 2.0 * DISTANCE_M)):
        low, high = times[max(at - 1, 0)], times[min(at + 1, times.size - 1)]
        for _ in range(3):
            inner = np.linspace(low, high, 41)
            values = distances(arc, record, instance, inner)
            best = int(values.argmin())
            low, high = inner[max(best - 1, 0)], inner[min(best + 1, 40)]
        if values.min() <= DISTANCE_M:
            found.append((float(inner[best]), float(values.min())))
    return found


def test_no_approach_is_missed(
    refined: tuple[Instance, RefinedPlan], records: tuple[ElementSet, ...]
) -> None:
    """Small steps on all arcs find the same approaches, at the same times and distances."""
    instance, plan = refined
    found = list(screen(instance, plan, records, distance_m=DISTANCE_M))
    assert len(found) > 10
    for arc in flown_arcs(instance, plan):
        for record in records:
            for time_s, miss_m in nearest(arc, record, instance, 10.0):
                same = [
                    each
                    for each in found
                    if each.object == record.label
                    and each.leg == arc.leg
                    and abs(each.time_s - time_s) < 0.5
                ]
                assert same, (arc.leg, arc.phase, record.label, time_s, miss_m)
                assert same[0].miss_m == pytest.approx(miss_m, abs=1.0)
                if same[0].speed_m_s > 100.0:
                    assert same[0].time_s == pytest.approx(time_s, abs=0.01)
                found.remove(same[0])
    assert all(each.miss_m > DISTANCE_M - 1.0 for each in found)


def test_an_approach_has_its_parts(
    refined: tuple[Instance, RefinedPlan], records: tuple[ElementSet, ...]
) -> None:
    """Radial, along and cross make up the miss, the age is that of the elements, times ascend."""
    instance, plan = refined
    found = screen(instance, plan, records, distance_m=DISTANCE_M)
    by_label = {record.label: record for record in records}
    assert [each.time_s for each in found] == sorted(each.time_s for each in found)
    for each in found:
        parts = each.radial_m, each.along_m, each.cross_m
        assert np.linalg.norm(parts) == pytest.approx(each.miss_m, rel=1e-9)
        since = (instance.epoch - by_label[each.object].epoch).total_seconds() + each.time_s
        assert each.age_days == pytest.approx(since / 86400.0, abs=1e-6)
        assert not each.own
    closer = screen(instance, plan, records, distance_m=0.5 * DISTANCE_M)
    assert set(closer) == {each for each in found if each.miss_m <= 0.5 * DISTANCE_M}


def test_bodies_that_are_visited_are_told_apart(
    refined: tuple[Instance, RefinedPlan], records: tuple[ElementSet, ...]
) -> None:
    """An object with the designator of the body that a leg leaves or leads to is its own."""
    instance, plan = refined
    (first, *_) = instance.targets
    same_id = first.replace(object_id=records[0].object_id)  # the one of all records
    named = instance.replace(targets=(same_id, *instance.targets[1:]))
    reference = plan.instance.model_copy(update={"sha256": named.sha256})
    assert plan.planned is not None
    planned = plan.planned.replace(instance=reference)
    made = adr_opt.refine(named, planned)
    legs = {leg.leg for leg in made.legs if first.name in (leg.origin, leg.destination)}
    found = screen(named, made, records, distance_m=DISTANCE_M)
    assert legs
    assert {each.own for each in found} == {True, False}
    assert all(each.own == (each.leg in legs) for each in found)


def test_the_verb_writes_all_approaches(cli: Cli, refined: tuple[Instance, RefinedPlan]) -> None:
    """The file has a row for each, and the same stand in the JSON text."""
    instance, plan = refined
    instance.save("a.json")
    plan.save("r.json")
    Path("c.tle").write_bytes(catalogue(40, seed=5))
    call = "screen", "a.json", "r.json", "c.tle", "--distance", "2.5e5"
    outcome = cli(*call, "--out", "s.csv", "--json")
    assert outcome.status == 0, outcome
    said = json.loads(outcome.out)
    with Path("s.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["epoch"] for row in rows] == [each["epoch"] for each in said["approaches"]]
    assert said["objects"] == 40
    assert set(rows[0]) == set(Approach.__dataclass_fields__)
    told = cli(*call)
    assert "nearest approaches" in told.out


def test_what_cannot_be_screened_is_refused(
    cli: Cli, refined: tuple[Instance, RefinedPlan], records: tuple[ElementSet, ...]
) -> None:
    """A field without a frame, a distance of nothing, and a catalogue that is none."""
    instance, plan = refined
    nowhere = instance.replace(frame=None)
    made = adr_opt.refine(nowhere, adr_opt.solve(nowhere, "greedy").plan)
    with pytest.raises(InputError, match="has no frame"):
        screen(nowhere, made, records)
    with pytest.raises(InputError, match="distance_m"):
        screen(instance, plan, records, distance_m=0.0)
    instance.save("a.json")
    plan.save("r.json")
    outcome = cli("screen", "a.json", "r.json", "a.json", "--out", "s.csv")
    assert outcome.status == 2
    assert not Path("s.csv").exists()
