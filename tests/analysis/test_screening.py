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
import adr_opt.ui.plot
from adr_opt.analysis.screening import (
    CloseApproach,
    avoiding,
    collision_probability,
    read_errors,
    screen,
)
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


def test_approaches_can_be_drawn(
    refined: tuple[Instance, RefinedPlan], records: tuple[ElementSet, ...]
) -> None:
    """A mark for each stands at its day and its miss."""
    pyplot = pytest.importorskip("matplotlib.pyplot")
    found = screen(*refined, records, distance_m=DISTANCE_M)
    figure, ax = pyplot.subplots()
    drawn = adr_opt.ui.plot.approaches(ax, found).lines
    places = {(float(x), float(y)) for line in drawn for x, y in zip(*line.get_data(), strict=True)}
    assert places == {(each.time_s / 86400.0, each.miss_m / 1000.0) for each in found}
    pyplot.close(figure)


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


@pytest.mark.parametrize("beside", [False, True])
def test_plans_keep_clear_of_conjunctions(
    refined: tuple[Instance, RefinedPlan], records: tuple[ElementSet, ...], beside: bool
) -> None:
    """What comes near a plan, in a transfer or beside a body, comes near no plan around it."""
    instance, plan = refined
    stays = ("service", "wait")
    found = screen(instance, plan, records, distance_m=4.0 * DISTANCE_M)
    there = [each for each in found if (each.phase in stays) == beside and each.time_s > 1e4]
    near = min(there, key=lambda each: each.miss_m)
    chosen = [record for record in records if record.label == near.object]
    unsafe = avoiding(instance, chosen, avoid_m=near.miss_m + 1.0)
    (conflict, *_) = unsafe(plan)
    assert near.object in conflict.said
    around = adr_opt.solve_refined(instance, "greedy", unsafe=unsafe)
    assert around.holds
    assert around.refined is not None
    assert around.plan is not None
    assert len(around.rounds) > 1
    assert conflict.said in around.rounds[0].troubles
    assert unsafe(around.refined) == ()
    assert adr_opt.check(instance, around.plan) == ()


def test_what_is_in_the_way_all_the_time_is_told(
    refined: tuple[Instance, RefinedPlan], records: tuple[ElementSet, ...]
) -> None:
    """Where no plan keeps clear, the last conflicts are named; legs before them may remain."""
    instance, _ = refined
    unsafe = avoiding(instance, records, avoid_m=2e7)
    found = adr_opt.solve_refined(instance, "greedy", unsafe=unsafe, rounds=2)
    assert not found.holds
    assert "passes" in found.reason


def test_a_probability_is_avoided_as_well(
    refined: tuple[Instance, RefinedPlan], records: tuple[ElementSet, ...], tmp_path: Path
) -> None:
    """An approach counts where its probability is too high, however far it is."""
    instance, plan = refined
    (tmp_path / "e.csv").write_text(ERRORS, encoding="utf-8")
    errors = read_errors(tmp_path / "e.csv")
    found = screen(instance, plan, records, distance_m=DISTANCE_M, errors=errors)
    likely = [each for each in found if each.probability is not None and not each.own]
    most = sorted(each.probability for each in likely)[len(likely) // 2]
    half = {each.time_s for each in likely if each.probability >= most}
    asked = {"avoid_m": 1.0, "most_probability": most, "within_m": DISTANCE_M}
    unsafe = avoiding(instance, records, errors=errors, **asked)
    assert {each.time_s for each in unsafe(plan)} == half
    with pytest.raises(InputError, match="give them"):
        avoiding(instance, records, most_probability=1e-4)


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
    assert set(rows[0]) == set(CloseApproach.__dataclass_fields__) - {"states"}
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


ERRORS = """object,radius_m,cr_r_m2,ct_r_m2,ct_t_m2,cn_r_m2,cn_t_m2,cn_n_m2
chaser,3,100,20,400,0,0,100
*,2,1e8,0,4e8,0,1e6,1e8
"""
"""Errors of a chaser and of all other objects."""


def test_a_probability_is_that_of_a_published_case() -> None:
    """The circle of the first Omitron case of NASA's CARA analysis tools, to three digits."""
    first = np.array([378.39559, 4305.721887, 5752.767554])
    second = np.array([374.5180598, 4307.560983, 5751.130418])
    rates = np.array([2.360800244, 5.580331936, -4.322349039])
    rate = np.array([-5.388125081, -3.946827739, 3.322820358]) - rates
    one = [
        [44.5757544811362, 81.6751751052616, -67.8687662707124],
        [81.6751751052616, 158.453402956163, -128.616921644857],
        [-67.8687662707124, -128.616921644858, 105.490542562701],
    ]
    other = [
        [2.31067077720423, 1.69905293875632, -1.4170164577661],
        [1.69905293875632, 1.24957388457206, -1.04174164279599],
        [-1.4170164577661, -1.04174164279599, 0.869260558223714],
    ]
    found = collision_probability(second - first, rate, np.array(one) + np.array(other), 0.020)
    assert found == pytest.approx(2.70601573490125e-05, rel=1e-3)


def test_a_probability_is_that_of_drawn_positions() -> None:
    """Of drawn relative positions so many pass within the radius, wide and narrow ones."""
    rng = np.random.default_rng(7_130_001)
    for scale in (0.02, 0.5, 3.0, 40.0):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        covariance = turn @ np.diag((scale * np.array([0.5, 1.0, 3.0])) ** 2) @ turn.T
        rate = rng.normal(size=3)
        along = rate / np.linalg.norm(rate)
        apart = rng.normal(size=3)
        apart -= (apart @ along) * along
        drawn = rng.multivariate_normal(apart, covariance, size=200_000)
        passes = np.linalg.norm(drawn - np.outer(drawn @ along, along), axis=1)
        share = float(np.mean(passes <= 1.5))
        found = collision_probability(apart, rate, covariance, 1.5)
        assert found == pytest.approx(share, abs=5.0 * np.sqrt(share * (1.0 - share) / 2e5) + 1e-9)


def test_messages_are_read_by_another_library(
    cli: Cli, refined: tuple[Instance, RefinedPlan]
) -> None:
    """Each approach that is no visit has its message, with both states a miss apart in GCRF."""
    ndm_io = pytest.importorskip("ccsds_ndm.ndm_io")
    instance, plan = refined
    instance.save("a.json")
    plan.save("r.json")
    Path("c.tle").write_bytes(catalogue(40, seed=5))
    Path("e.csv").write_text(ERRORS, encoding="utf-8")
    call = "screen", "a.json", "r.json", "c.tle", "--distance", "2.5e5", "--errors", "e.csv"
    outcome = cli(*call, "--messages", "m", "--json")
    assert outcome.status == 0, outcome
    listed = [each for each in json.loads(outcome.out)["approaches"] if not each["own"]]
    files = sorted(Path("m").iterdir())
    assert len(files) == len(listed) > 3
    assert any(each["probability"] for each in listed)
    for file, each in zip(files, listed, strict=True):
        read = ndm_io.NdmIo().from_path(file)
        about = read.body.relative_metadata_data
        assert about.tca == each["epoch"].removesuffix("Z")
        assert float(about.miss_distance.value) == pytest.approx(each["miss_m"], abs=1e-3)
        assert (about.collision_probability is None) == (each["probability"] is None)
        states = []
        for segment in read.body.segment:
            assert segment.metadata.ref_frame.value == "GCRF"
            state = segment.data.state_vector
            states.append([float(axis.value) for axis in (state.x, state.y, state.z)])
        apart_m = 1e3 * np.linalg.norm(np.subtract(*states))
        assert apart_m == pytest.approx(each["miss_m"], abs=0.01)
    again = cli(*call, "--messages", "m")
    assert again.status == 2
    assert "exists already" in again.err


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("a,0,1,0,1,0,0,1", "radius_m = 0"),
        ("a,1,1,2,1,0,0,1", "positive definite"),
        ("a,1,x,0,1,0,0,1", "must be a number"),
        ("a,1,nan,0,1,0,0,1", "positive definite"),
        (",1,1,0,1,0,0,1", "a name is missing"),
    ],
)
def test_errors_that_are_none_are_refused(line: str, said: str, tmp_path: Path) -> None:
    """A row says what is wrong with it, with its line."""
    path = tmp_path / "e.csv"
    path.write_text(ERRORS.splitlines()[0] + "\n" + line + "\n", encoding="utf-8")
    with pytest.raises(InputError, match=f"line 2: .*{said}"):
        read_errors(path)
