"""Scenarios: identities of futures, draws against rates, failures, resumption, tables."""

from __future__ import annotations

import csv
import itertools
import json
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from catalogue_files import field

import adr_opt
from adr_opt.analysis.scenario import (
    AltitudeShells,
    Launch,
    Scenario,
    ScenarioSettings,
    removals_csv,
    scenario,
    scenario_answer,
    yearly_csv,
)
from adr_opt.analysis.scenario.answer import outside
from adr_opt.analysis.scenario.branch import Branch
from adr_opt.analysis.scenario.campaign import campaign, drifted, offer
from adr_opt.analysis.scenario.events import (
    FragmentCloud,
    collisions_of,
    fragment_area_m2,
    fragments_by_shell,
    rings_of,
)
from adr_opt.analysis.scenario.futures import ScenarioStart
from adr_opt.analysis.scenario.population import ObjectPopulation, population_of
from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M
from adr_opt.common.errors import InputError
from adr_opt.kernels.orbits.decay import after_drag, drag_time
from adr_opt.kernels.orbits.encounters import encounter_rate
from adr_opt.problem.air import DRAG_COEFFICIENT, YEAR_S, lifetimes, table
from adr_opt.problem.orbit import Orbit
from adr_opt.sources import catalogue, worth
from adr_opt.sources.worth.breakup import area_shares
from adr_opt.sources.worth.pairs import mean_speeds

RECORDS = field(40)

LARGE = {
    at: worth.Measures(10.0 ** (1 + 2 * (at % 3)), 300.0 * (1 + at % 2))
    for at in range(len(RECORDS))
}
"""Sizes with which some of 40 objects collide every few years."""

NONE = rings_of([], 0.0, "mean", drag=True)

SOME = AltitudeShells(500.0, 1500.0, 20)


@pytest.fixture(scope="module")
def bodies() -> worth.Bodies:
    """Forty drawn objects, huge, and half of them intact."""
    made = worth.bodies_of(RECORDS, None, LARGE)
    kinds = tuple(("payload", "rocket body", "debris", "debris")[at % 4] for at in range(len(made)))
    return replace(made, kinds=kinds, areas=np.full(len(made), 0.01))


@pytest.fixture(scope="module")
def people(bodies: worth.Bodies) -> ObjectPopulation:
    """The same at one epoch."""
    return population_of(bodies, max(record.epoch for record in RECORDS))[0]


@pytest.fixture(scope="module")
def template() -> adr_opt.Instance:
    """A campaign of two launches that last a year and a half."""
    return catalogue.to_instance(
        RECORDS[:6],
        mission=catalogue.MissionOutline(duration_s=540.0 * DAY_S, refuelling=False),
        crew=catalogue.Crew(launches=2, apart_s=30.0 * DAY_S, kits=2, service_s=5.0 * DAY_S),
    ).instance


def settings(**more: Any) -> ScenarioSettings:
    """Settings whose plans do not depend on the clock."""
    usual: dict[str, Any] = {
        "years": 5,
        "every": 2,
        "targets": 6,
        "method": "greedy",
        "time_limit_s": 1e3,
        "shells": SOME,
    }
    return ScenarioSettings(**{**usual, **more})


def lived(start: ScenarioStart, seed: int = 0, *, removes: bool = True) -> Iterator[Any]:
    """Each year's population before and after it, and its record."""
    branch = Branch.of(start, seed, campaign, removes=removes)
    for _ in range(start.settings.years + 1):
        before = branch.population
        record = branch.live()
        yield before, branch.population, record


def test_both_futures_are_equal_where_every_campaign_is_lost(
    bodies: worth.Bodies, template: adr_opt.Instance
) -> None:
    """Lost campaigns remove nothing, are repeated in the next year, and change no number."""
    made = scenario(bodies, template, settings(years=3, campaign_failure=1.0, explosions=0.02))
    told = scenario_answer(made)
    assert told["with"] == told["without"]
    assert any(told["with"]["fragments"]["mean"])
    assert [each["failed"] for each in told["campaigns"]] == [1] * 3
    assert removals_csv(made).count("\n") == 1


def test_missed_captures_change_nothing(bodies: worth.Bodies, template: adr_opt.Instance) -> None:
    """Campaigns that are flown and capture nothing leave both futures equal."""
    made = scenario(bodies, template, settings(years=2, capture_failure=1.0))
    told = scenario_answer(made)
    assert told["campaigns"][0]["missed"] > 0
    assert told["with"] == told["without"]
    assert told["removed"]["mean"] == 0.0


def test_nothing_changes_without_drag_events_and_campaigns(bodies: worth.Bodies) -> None:
    """Objects and rates stay the same for all years."""
    made = scenario(bodies, None, settings(drag=False, collisions=False, years=30))
    for case in ("with", "without"):
        first, *others = made.futures[0][case]
        assert sum(map(sum, first.objects)) == len(bodies)
        assert all(record == first for record in others)


def test_totals_add_up_and_removed_objects_never_return(
    people: ObjectPopulation, template: adr_opt.Instance
) -> None:
    """Objects by shell are the list; each year's changes add up; a number that is gone stays so."""
    launches = (Launch(1, 3, "payload", 500.0, 2.0, 700.0, 710.0, 98.0, 2),)
    epoch = max(record.epoch for record in RECORDS)
    start = ScenarioStart(people, epoch, template, launches, settings(explosions=0.02))
    gone: set[int] = set()
    removals = 0
    for before, after, record in lived(start):
        there = len(before) + record.launched
        assert sum(map(sum, record.objects)) == there
        assert not gone & set(after.numbers.tolist())
        left = set(before.numbers.tolist()) - set(after.numbers.tolist())
        assert not gone & left
        gone |= left
        removed = {number for number, _, _ in record.removed}
        assert removed <= left
        lost = len(left) - len(removed) - record.decayed
        assert record.took_place[1] <= lost <= record.took_place[1] + 2 * record.took_place[0]
        assert len(after) == there - len(left)
        assert list(after.numbers) == sorted(set(after.numbers.tolist()))
        assert after.bodies.shells.shape == (len(after), 2)
        removals += len(removed)
    assert removals > 3


def test_futures_share_their_draws(people: ObjectPopulation, template: adr_opt.Instance) -> None:
    """What collides with campaigns collides at the same time without, as long as both are there."""
    start = ScenarioStart(people, RECORDS[0].epoch, template, (), settings(years=8, every=5))
    both = [list(lived(start, 3, removes=removes)) for removes in (True, False)]
    shared = 0
    for (with_them, _, one), (without, _, other) in zip(*both, strict=True):
        common = set(with_them.numbers.tolist()) & set(without.numbers.tolist())
        hits = [
            {hit for hit in record.collisions if {hit.one, hit.other} <= common}
            for record in (one, other)
        ]
        assert hits[0] == hits[1]
        shared += len(hits[0])
    assert shared > 2
    others = [record.collisions for _, _, record in lived(start, 4)]
    assert others != [record.collisions for _, _, record in both[0]]


def test_rates_are_those_of_worth(people: ObjectPopulation) -> None:
    """Encounters and catastrophic ones of all pairs are the sums of `worth`, on any threads."""
    rates, hits = collisions_of(people, NONE, 0, 0, 1)
    made = worth.worth_of(people.bodies, 50.0)
    assert rates.encounters == pytest.approx(0.5 * made.encounters.sum(), rel=1e-12)
    assert rates.catastrophic == pytest.approx(0.5 * made.catastrophic.sum(), rel=1e-12)
    assert 0.0 < rates.catastrophic < rates.encounters
    assert collisions_of(people, NONE, 0, 0, 3) == (rates, hits)


def test_collisions_are_drawn_as_often_as_their_rates_say(people: ObjectPopulation) -> None:
    """Over many seeds and years the mean number and fragments of collisions are as expected."""
    years = [collisions_of(people, NONE, seed, year, 1) for seed in range(150) for year in range(4)]
    rates = years[0][0]
    counts = np.array([len(hits) for _, hits in years])
    made = np.array([sum(hit.fragments for hit in hits) for _, hits in years])
    assert counts.sum() > 100
    for found, expected in ((counts, rates.encounters), (made, rates.fragments)):
        # Once a year at most: a pair that is certain to meet meets once.
        error = found.std() / np.sqrt(len(found))
        assert abs(found.mean() - expected) < 3.5 * error + 0.03 * expected
    times = [hit.time for _, hits in years for hit in hits]
    assert abs(np.mean(times) - 0.5) < 4.0 / np.sqrt(12.0 * len(times)) + 0.03


def test_rates_with_fragments_are_those_of_objects_like_them(people: ObjectPopulation) -> None:
    """A ring of fragments counts as its number of objects of their size, mass and altitude."""
    clouds = [
        FragmentCloud(0.0, 750e3, (4e5, 0.0), 1.3, 100),
        FragmentCloud(0.5, 800e3, (0.0, 3e5), 0.9, 101),
    ]
    rings = rings_of(clouds, 3.0, "mean", drag=True)
    assert rings.counts.sum() == pytest.approx(
        fragments_by_shell(clouds, 3.0, SOME, "mean", drag=True).sum(), rel=1e-3
    )
    bare, _ = collisions_of(people, NONE, 0, 0, 1)
    rates, hits = collisions_of(people, rings, 0, 0, 1)
    assert rates[:2] == bare[:2]
    wide = np.sqrt(fragment_area_m2() / np.pi)
    encounters = catastrophic = made = 0.0
    for radius, tilt, count, mass in zip(*rings[:4], strict=True):
        for at in range(len(people)):
            pair = np.array([people.bodies.shells[at], (radius - 2500.0, radius + 2500.0)])
            rate, _, speed = encounter_rate(
                pair,
                np.array([people.bodies.tilts[at], tilt]),
                np.array([0.5 * people.bodies.sizes[at], wide]),
                mean_speeds(),
                0,
                1,
            )
            heavy = 0.5 * mass * speed**2 >= 40e3 * people.bodies.masses[at]
            whole = mass + people.bodies.masses[at] if heavy else mass * speed / 1e3
            encounters += YEAR_S * rate * count
            catastrophic += YEAR_S * rate * count * heavy
            made += YEAR_S * rate * count * 0.1 * 0.1**-1.71 * whole**0.75
    assert rates.fragment_encounters == pytest.approx(encounters)
    assert rates.fragment_catastrophic == pytest.approx(catastrophic)
    assert rates.fragments - bare.fragments == pytest.approx(made)
    assert 0.0 < catastrophic < encounters
    assert {hit.other for hit in hits if hit.other < 0} <= {-101, -102}


def test_fragments_hit_as_often_as_their_rates_say(people: ObjectPopulation) -> None:
    """Over many seeds and years collisions with fragments come as often as expected, both kinds."""
    cloud = FragmentCloud(0.0, 750e3, (40.0, 40.0), 1.3, 100)
    rings = rings_of([cloud], 0.0, "mean", drag=False)
    years = [collisions_of(people, rings, seed, 0, 1) for seed in range(200)]
    rates = years[0][0]
    every = [[hit for hit in hits if hit.other == -101] for _, hits in years]
    heavy = [sum(hit.catastrophic for hit in hits) for hits in every]
    for counts, expected in (
        ([len(hits) for hits in every], rates.fragment_encounters),
        (heavy, rates.fragment_catastrophic),
    ):
        assert sum(counts) > 15
        error = np.std(counts) / np.sqrt(len(counts))
        assert abs(np.mean(counts) - expected) < 3.5 * error + 0.05 * expected


def test_missed_captures_are_not_removed_and_the_rest_is_planned_anew(
    people: ObjectPopulation, template: adr_opt.Instance
) -> None:
    """If every capture fails nothing is removed; if some do, others follow, each object once."""
    given = settings(capture_failure=0.5)
    offered = offer(template, people, set(), given, 0, 0.0, 1)
    flown = [campaign(offered, given, seed, 0) for seed in range(3)]
    assert any(each is not None and each.replanned for each in flown)
    for each in flown:
        assert each is not None
        numbers = [attempt.number for attempt in each.attempts]
        assert len(set(numbers)) == len(numbers)
        assert list(each.attempts) == sorted(each.attempts)
        assert each.replanned <= sum(not attempt.succeeded for attempt in each.attempts)
        assert all(0.0 < attempt.time_s <= 540.0 * DAY_S for attempt in each.attempts)
    never = campaign(offered, settings(capture_failure=1.0), 0, 0)
    assert never is not None
    assert never.attempts
    assert not any(attempt.succeeded for attempt in never.attempts)


def test_targets_are_the_best_floors_that_no_campaign_under_way_takes(
    people: ObjectPopulation, template: adr_opt.Instance
) -> None:
    """Prizes are floors of the offered set in whole units; limits and objects taken are kept."""
    given = settings(altitude_km=(600.0, 900.0), targets=8)
    offered = offer(template, people, {1, 2, 3}, given, 4, 0.5, 1)
    instance = offered.instance
    assert instance is not None
    assert instance.epoch == template.epoch + timedelta(days=4.5 * 365.25)
    assert not set(offered.numbers.values()) & {1, 2, 3}
    places = [people.numbers.tolist().index(number) for number in offered.numbers.values()]
    made = worth.worth_of(people.bodies, 50.0)
    floors = made.floors(np.array(places))
    for target, floor, at in zip(instance.targets, floors, places, strict=True):
        assert target.prize == int(target.prize)
        assert target.prize * offered.unit == pytest.approx(floor, abs=offered.unit)
        assert 600e3 <= people.altitudes_m[at] <= 900e3
        assert target.removal == "kit"
        assert target.mass_kg == people.bodies.masses[at]
        assert target.orbit is not None
        assert target.orbit.semi_major_axis_m == pytest.approx(people.orbits[at, :2].mean())


def test_what_breaks_up_before_its_removal_is_not_removed(people: ObjectPopulation) -> None:
    """Of removals and break-ups of one object, the first one takes place."""
    start = ScenarioStart(
        people, RECORDS[0].epoch, None, (), settings(explosions=1.0, collisions=False)
    )
    whole = people.numbers[people.kinds != 2].tolist()
    branch = Branch.of(start, 0, campaign, removes=True)
    branch.pending = [(0.5, number) for number in whole]
    record = branch.live()
    early = {each.one for each in record.explosions if each.time < 0.5}
    assert {number for number, _, _ in record.removed} == set(whole) - early
    assert record.void == record.took_place[1] == len(early)
    assert len(branch.clouds) == len(early)
    assert 0 < len(early) < len(whole)


def test_a_later_campaign_leaves_objects_of_one_under_way(
    bodies: worth.Bodies, template: adr_opt.Instance
) -> None:
    """Campaigns that overlap capture no object twice."""
    made = scenario(bodies, template, settings(every=1, years=3))
    flown = [record.campaign for record in made.futures[0]["with"] if record.campaign]
    captured = [each.number for one in flown for each in one.attempts if each.succeeded]
    assert len(flown) == 3
    assert len(set(captured)) == len(captured) > 6


@pytest.fixture(scope="module")
def resumed(bodies: worth.Bodies, template: adr_opt.Instance, tmp_path_factory: Any) -> Any:
    """A scenario with all that can happen, its folder, and a way to run it again."""
    folder = tmp_path_factory.mktemp("years")
    given = settings(
        seeds=2, capture_failure=0.3, campaign_failure=0.3, explosions=0.01, every=1, years=2
    )
    launches = (Launch(1, 2, "rocket body", 1000.0, 4.0, 800.0, 810.0, 71.0),)

    def run(**more: Any) -> Scenario:
        return scenario(bodies, template, replace(given, **more), launches=launches, folder=folder)

    return run(), folder, run


@pytest.mark.parametrize("lines", [0, 2, 5])
def test_a_killed_run_goes_on_to_the_same_file(resumed: Any, lines: int) -> None:
    """Whatever was written of a future, even half a line, the rest is as it was."""
    made, folder, run = resumed
    path = folder / "years.jsonl"
    parts = path.read_bytes().splitlines(keepends=True)
    assert [(row["key"]["seed"], row["key"]["year"]) for row in map(json.loads, parts[1:])] == [
        (seed, year) for seed in range(2) for year in range(3)
    ]
    path.write_bytes(b"".join(parts[:lines]) + parts[lines][:40])
    again = run()
    rows = [json.loads(line) | {"seconds": 0.0} for line in path.read_bytes().splitlines()[1:]]
    assert rows == [json.loads(line) | {"seconds": 0.0} for line in parts[1:]]
    assert again.futures == made.futures
    assert yearly_csv(again) == yearly_csv(made)


def test_plans_are_kept_for_other_verbs(resumed: Any) -> None:
    """Each campaign that was launched has its instance and first plan, which `check` accepts."""
    made, folder, _ = resumed
    flown = {
        f"seed-{seed}-year-{year}": record.campaign
        for seed, each in enumerate(made.futures)
        for year, record in enumerate(each["with"])
        if record.campaign is not None and not record.campaign.failed
    }
    assert {path.name for path in (folder / "plans").iterdir()} == {
        f"{name}{ending}" for name in flown for ending in (".json", ".plan.json")
    }
    for name, its in flown.items():
        instance = adr_opt.load(folder / "plans" / f"{name}.json")
        plan = adr_opt.load_plan(folder / "plans" / f"{name}.plan.json")
        assert adr_opt.check(instance, plan) == ()
        assert len(plan.legs) == its.planned > 0


def wrong_years(line: bytes) -> Iterator[bytes]:
    """Lines with a value of another type, a row too short or too long, or a number without end."""
    spoils: tuple[Callable[[dict[str, Any]], object], ...] = (
        lambda year: year["rates"].__setitem__(0, "much"),
        lambda year: year["rates"].__setitem__(1, math.nan),
        lambda year: year["rates"].pop(),
        lambda year: year["objects"].append("x"),
        lambda year: year["collisions"].append([0.5, 1, 2, 7e5, 3.0]),
        lambda year: year["collisions"].append([0.5, 1, -(10**30), 7e5, 3.0, True]),
        lambda year: year["explosions"].append([0.5, 1.5]),
        lambda year: year["campaign"][-1].append([0.5, 1, 2, 3.0, True]),
        lambda year: year["campaign"].pop(),
        lambda year: year.__setitem__("void", None),
        lambda year: year.pop("removed"),
    )
    for spoil in spoils:
        content = json.loads(line)
        spoil(content["value"]["with"])
        yield json.dumps(content).encode() + b"\n"


def test_files_of_another_scenario_are_refused(resumed: Any) -> None:
    """Other settings, other content and lines that are no years are refused in one sentence."""
    _, folder, run = resumed
    with pytest.raises(InputError, match="other settings"):
        run(explosions=0.5)
    path = folder / "years.jsonl"
    content = path.read_bytes()
    lines = content.splitlines(keepends=True)
    try:
        for wrong in wrong_years(lines[1]):
            path.write_bytes(lines[0] + wrong)
            of = "a study" if b"NaN" in wrong else "scenario"  # no file has such a number
            with pytest.raises(InputError, match=rf"years\.jsonl: line 2: not a row of {of};"):
                run()
            assert path.read_bytes() == lines[0] + wrong
        other = json.loads(lines[2]) | {"key": json.loads(lines[1])["key"]}
        path.write_bytes(lines[0] + json.dumps(other).encode() + b"\n")
        with pytest.raises(InputError, match="a different year"):
            run()
        path.write_bytes(b"year,objects\n")
        with pytest.raises(InputError, match=r"not a file of a study \(scenario\)"):
            run()
        path.unlink()
        (folder / "seed-0.jsonl").write_bytes(b"")
        with pytest.raises(InputError, match=r"has files of adr-opt 1\.0"):
            run()
        (folder / "seed-0.jsonl").unlink()
    finally:
        path.write_bytes(content)


def test_tables_have_what_happened(resumed: Any) -> None:
    """Means of removals by species and shell, and of objects by year, are those of the records."""
    made, _, _ = resumed
    rows = list(
        csv.DictReader(
            removals_csv(made, {"payload": "Su", "rocket body": "B", "debris": "N"}).splitlines()
        )
    )
    removed = [record.removed for each in made.futures for record in each["with"]]
    count = sum(map(len, removed)) - outside(made)
    assert count > 4
    assert sum(float(row["removed"]) for row in rows) == pytest.approx(count / 2)
    for row in rows:
        shell = int(row["shell"])
        assert row["control"] == f"u_r_{row['species']}{shell}"
        assert float(row["shell_low_km"]) == SOME.edges_km[shell - 1]
        assert float(row["shell_high_km"]) == SOME.edges_km[shell]
        assert row["species"] in ("Su", "B", "N")
    whole = removals_csv(made, dict.fromkeys(("payload", "rocket body", "debris"), "X"))
    merged = list(csv.DictReader(whole.splitlines()))
    places = {(row["year"], row["shell"]) for row in rows}
    assert {(row["year"], row["shell"]) for row in merged} == places
    assert len(merged) == len(places)
    assert sum(float(row["removed"]) for row in merged) == pytest.approx(count / 2)
    yearly = list(csv.DictReader(yearly_csv(made).splitlines()))
    told = scenario_answer(made)
    for case, year in itertools.product(("with", "without"), range(3)):
        its = [row for row in yearly if (row["case"], row["year"]) == (case, str(year))]
        for name, is_one in (("fragments", True), ("objects", False)):
            numbers = [
                float(row["number"]) for row in its if (row["species"] == "fragment") == is_one
            ]
            assert sum(numbers) == pytest.approx(told[case][name]["mean"][year], rel=1e-6)
    less = told["difference"]["objects"]["mean"]
    assert less == pytest.approx(
        np.subtract(told["with"]["objects"]["mean"], told["without"]["objects"]["mean"])
    )
    before = np.cumsum([0.0, *told["with"]["catastrophic"]["mean"]])[:-1]
    assert told["with"]["catastrophic_before"]["mean"] == pytest.approx(before)


def test_orbits_after_years_are_those_of_their_lifetimes() -> None:
    """An object followed year by year comes down when its lifetime is over, circle or ellipse."""
    altitudes, logs = table("mean")
    for low, high, area in ((600.0, 600.0, 0.05), (450.0, 900.0, 0.02), (700.0, 705.0, 0.1)):
        ends = EARTH_RADIUS_M + 1e3 * np.array([[low, high]])
        ballistic = np.array([DRAG_COEFFICIENT * area])
        life = drag_time(*ends[0], altitudes, logs, np.inf) / ballistic[0] / YEAR_S
        whole = lifetimes(ends, np.array([area]), "mean", 1e4)[0]
        assert life == pytest.approx(whole)
        steps = 40
        for step in range(1, steps + 1):
            before = ends.copy()
            after_drag(ends, ballistic, altitudes, logs, YEAR_S * life / steps)
            assert np.all(ends <= before)
            left = drag_time(*ends[0], altitudes, logs, np.inf) / ballistic[0] / YEAR_S
            assert left == pytest.approx(life * (1.0 - step / steps), abs=0.02 * life)


def test_planes_drift_by_their_nodal_rate(people: ObjectPopulation) -> None:
    """A year later nodes are where the rate of the mean orbit takes them; stations likewise."""
    later, down = people.a_year_later("mean", drag=False)
    assert len(down) == 0
    assert np.array_equal(later.orbits[:, :3], people.orbits[:, :3])
    axis = float(people.orbits[0, :2].mean())
    degrees = -2.06474e14 * (axis / 1e3) ** -3.5 * np.cos(people.orbits[0, 2])  # a day
    node = np.degrees(people.orbits[0, 3]) + degrees * 365.25
    assert (np.degrees(later.orbits[0, 3]) - node + 180.0) % 360.0 - 180.0 == pytest.approx(
        0.0, abs=2.0
    )
    orbit = Orbit(
        semi_major_axis_m=axis,
        eccentricity=0.0,
        inclination_deg=98.0,
        raan_deg=10.0,
        argument_of_perigee_deg=0.0,
        true_anomaly_deg=5.0,
    )
    turned = drifted(orbit, 10.0 * DAY_S)
    rate = -2.06474e14 * (axis / 1e3) ** -3.5 * np.cos(np.radians(98.0))
    assert turned.raan_deg == pytest.approx(10.0 + 10.0 * rate, rel=2e-3)
    assert turned.true_anomaly_deg == 5.0


def test_fragments_come_down_by_their_area_over_mass() -> None:
    """The number of a cloud in orbit is the share whose lifetime is longer; without drag all."""
    cloud = FragmentCloud(2.0, 700e3, (100.0, 50.0), 1.2, 7)
    ends = np.full((1, 2), EARTH_RADIUS_M + 700e3)
    for after in (0.0, 1.0, 10.0, 60.0):
        found = fragments_by_shell([cloud], 2.0 + after, SOME, "mean", drag=True)
        expected = 0.0
        for kind, count in (("rocket body", 100.0), ("spacecraft", 50.0)):
            areas, shares = area_shares(kind)
            lives = lifetimes(np.repeat(ends, len(areas), axis=0), areas, "mean", 1e3)
            expected += count * shares[lives > after].sum()
        assert found.sum() == pytest.approx(expected, rel=0.02)
        assert found[SOME.numbers(np.array([760e3]))[0]] == 0.0
        still = fragments_by_shell([cloud], 2.0 + after, SOME, "mean", drag=False)
        assert still[SOME.numbers(np.array([700e3]))[0]] == pytest.approx(150.0)
    assert found[0] < found.sum() < 120.0


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        ({"years": 201}, "--years 201"),
        ({"years": 0}, "--years 0"),
        ({"every": 0}, "--every 0"),
        ({"worth_years": 300.0}, "--worth-years 300"),
        ({"explosions": -0.1}, "--explosions -0.1"),
        ({"capture_failure": 1.5}, "--capture-failure 1.5"),
        ({"targets": 0}, "--targets 0"),
        ({"seeds": 0}, "--seeds 0"),
        ({"time_limit_s": 0.0}, "--time-limit 0"),
        ({"activity": "stormy"}, "stormy"),
    ],
)
def test_settings_out_of_range_are_refused(more: dict[str, Any], sentence: str) -> None:
    """Each setting out of range is named with its value."""
    with pytest.raises(InputError, match=sentence):
        settings(**more)


def test_templates_that_no_later_year_can_have_are_refused(
    bodies: worth.Bodies, template: adr_opt.Instance, tmp_path: Path
) -> None:
    """Two-body motion, keep-out zones and missing targets are refused before any work."""
    moved = template.transfer.replace(max_drift_s=0.0)
    for other, field_name in (
        (template.replace(dynamics="two-body", transfer=moved), "dynamics"),
        (template.replace(targets=()), "no target"),
    ):
        with pytest.raises(InputError, match=field_name):
            scenario(bodies, other, settings(), folder=tmp_path / "never")
    assert not (tmp_path / "never").exists()
