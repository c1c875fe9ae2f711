"""Worth of removals: sums over pairs, sets, floors, fragments, lifetimes, masses and sizes."""

from __future__ import annotations

import itertools
import math
import os
from dataclasses import replace
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from catalogue_files import field
from scipy.integrate import quad, solve_ivp

from adr_opt.common.constants import EARTH_RADIUS_M, MU_M3_S2
from adr_opt.common.errors import InputError
from adr_opt.kernels.orbits.collisions import collision
from adr_opt.problem.air import YEAR_S, lifetimes, table
from adr_opt.sources import worth
from adr_opt.sources.catalogue import ElementSet
from adr_opt.sources.worth.bodies import STAGES, cylinder
from adr_opt.sources.worth.breakup import EXPOSURES, KINDS, area_shares, fragment_years
from adr_opt.sources.worth.pairs import mean_speeds, with_one

DATA = Path(os.environ.get("ADR_OPT_EXTERNAL_DATA", "../shared/data"))

HEADER = (
    "#JCAT\tSatcat\tPiece\tType\tName\tMass\tMassFlag\tDryMass\tDryFlag\tLength\tLFlag\tDiameter\t"
    "DFlag\n"
)
STAGE = "S10000\t10000\t1960-001A\tR2\tSTAGE\t30000\t \t 8900\t?\t10.4\t \t 3.9\t \n"
PAYLOAD = "S10001\t10001\t1961-002B\tP\tPAY\t 1200\t \t 800\t \t 3.0\t \t-\t \n"
UNKNOWN = "S10002\t10002\t1962-003C\tP\tPAY 2\t0\t?\t-\t-\t-\t-\t-\t-\n"
PART = "A00047\t10000\t1960-001A\tC\tPART\t 50\t \t 50\t \t 1.0\t \t 1.0\t \n"
GHOST = "S10003\t10003\t1963-004D\tZ\tGHOST\t 5\t \t 5\t \t 1.0\t \t 1.0\t \n"


def measured(count: int, seed: int = 0) -> worth.Bodies:
    """Drawn objects with drawn masses and sizes."""
    random = np.random.default_rng(seed)
    measures = {
        at: worth.Measures(10.0 ** random.uniform(0.0, 4.0), random.uniform(0.2, 6.0))
        for at in range(count)
    }
    return worth.bodies_of(field(count, seed), None, measures)


@pytest.fixture(scope="module")
def made() -> worth.RemovalWorth:
    """The worth of 60 drawn objects."""
    return worth.worth_of(measured(60), 50.0)


def pair(made: worth.RemovalWorth, i: int, j: int) -> float:
    """Fragment-years of two objects, by their numbers in the catalogue."""
    first, second = sorted(int(place) for place in made._places(np.array([i, j])))
    return float(collision(made._objects, made._tables, first, second)[1])


def test_worths_alone_are_sums_over_pairs(made: worth.RemovalWorth) -> None:
    """Each worth is the sum of the object's pairs, and the total counts each pair once."""
    count = len(made.bodies)
    for i in range(0, count, 7):
        sums = sum(pair(made, i, j) for j in range(count) if j != i)
        assert made.alone[i] == pytest.approx(sums, rel=1e-12)
    every = sum(pair(made, i, j) for i, j in itertools.combinations(range(count), 2))
    assert made.total == pytest.approx(every, rel=1e-12)
    assert made.cells.sum() == pytest.approx(2.0 * every, rel=1e-12)
    assert np.array_equal(made.cells, made.cells.T)
    for i in range(0, count, 7):
        others = [pair(made, i, j) if j != i else 0.0 for j in range(count)]
        assert made.partner_worths[i] == max(others)
        assert others[made.partners[i]] == max(others)


def test_a_set_counts_pairs_within_it_once(made: worth.RemovalWorth) -> None:
    """The worth of a set is what all pairs without it lack of all pairs."""
    random = np.random.default_rng(1)
    for size in (1, 2, 10, 40, 60):
        chosen = random.choice(len(made.bodies), size, replace=False)
        left = [at for at in range(len(made.bodies)) if at not in set(chosen.tolist())]
        rest = sum(pair(made, i, j) for i, j in itertools.combinations(left, 2))
        assert made.of_set(chosen) == pytest.approx(made.total - rest, rel=1e-9)
    assert made.of_set(range(60)) == pytest.approx(made.total, rel=1e-12)
    with pytest.raises(InputError, match="twice"):
        made.of_set([1, 1])


def test_floors_add_up_to_at_most_the_worth_of_any_set(made: worth.RemovalWorth) -> None:
    """No set of candidates avoids less than its floors, nor more than its worths alone."""
    random = np.random.default_rng(2)
    prizes = worth.prizes_of(made, 25)
    for _ in range(200):
        places = random.choice(25, random.integers(1, 26), replace=False)
        avoided = made.of_set(prizes.candidates[places])
        assert prizes.floors[places].sum() <= avoided * (1.0 + 1e-12)
        assert avoided <= made.alone[prizes.candidates[places]].sum() * (1.0 + 1e-12)
        assert prizes.unit * prizes.prizes[places].sum() <= avoided * (1.0 + 1e-12)
    # With all of them the floor is sharp.
    assert prizes.floors.sum() == pytest.approx(made.of_set(prizes.candidates))


def test_prizes_are_whole_multiples_of_the_unit(made: worth.RemovalWorth) -> None:
    """Prizes are floors in units, rounded down; by default the largest has five digits."""
    for unit in (None, 0.37, 1.0):
        prizes = worth.prizes_of(made, 0, unit)
        assert len(prizes.prizes) == len(made.bodies)
        assert np.array_equal(prizes.prizes, np.floor(prizes.prizes))
        rest = prizes.floors - prizes.unit * prizes.prizes
        assert np.all(rest > -1e-9)
        assert np.all(rest < prizes.unit * (1.0 + 1e-9))
    assert 10_000 <= worth.prizes_of(made, 10).prizes.max() < 100_000


def test_results_do_not_depend_on_threads_or_order() -> None:
    """One thread or three give the same bits, and the order of the catalogue does not matter."""
    bodies = measured(40, 3)
    one, three = (worth.worth_of(bodies, 30.0, jobs=jobs) for jobs in (1, 3))
    assert np.array_equal(one.alone, three.alone)
    assert np.array_equal(one.partners, three.partners)
    order = np.random.default_rng(0).permutation(40)
    records = [bodies.records[at] for at in order]
    measures = {
        place: worth.Measures(bodies.masses[at], bodies.sizes[at]) for place, at in enumerate(order)
    }
    other = worth.worth_of(worth.bodies_of(records, None, measures), 30.0)
    assert other.alone == pytest.approx(one.alone[order], rel=1e-12)


def test_the_best_set_begins_with_the_best_object(made: worth.RemovalWorth) -> None:
    """Each addition avoids at least as much as any other one would."""
    candidates = made.best(20)
    chosen = made.best_set(4, candidates)
    for size in range(4):
        own = made.of_set(chosen[: size + 1])
        for other in candidates:
            if int(other) not in chosen[:size]:
                assert made.of_set([*chosen[:size], int(other)]) <= own * (1.0 + 1e-12)
    assert with_one(made._objects, made._tables, 0, np.array([0]))[0] == 0.0


def test_prizes_fall_with_the_year_of_removal() -> None:
    """A removal avoids what collides after it: from the start all, at the horizon nothing."""
    bodies = measured(40, 5)
    years = (0.0, 1.0, 7.5, 20.0, 49.0, 50.0)
    made = [worth.worth_of(bodies, 50.0, since_years=year) for year in years]
    assert np.array_equal(made[0].alone, worth.worth_of(bodies, 50.0).alone)
    for sooner, later in pairwise(made):
        assert np.all(later.alone <= sooner.alone * (1.0 + 1e-12))
        assert later.total < sooner.total
    assert np.all(made[-1].alone <= 1e-12 * made[0].alone.max())
    prizes = worth.prizes_of(made[0], 20, later=made[1:4])
    assert np.all(np.diff(np.stack([prizes.prizes, *prizes.falling]), axis=0) <= 0.0)
    rows = [row.split(",") for row in prizes.prizes_csv().splitlines()]
    assert rows[0] == ["object", "prize", "mass", "prize_until"]
    assert all(row[1] == "0" and len(row[3].split()) == 3 for row in rows[1:])


def test_worth_grows_with_the_horizon_and_falls_with_activity() -> None:
    """Longer horizons see more fragment-years, an active Sun fewer."""
    bodies = measured(40, 4)
    by_years = [worth.worth_of(bodies, years).total for years in (10.0, 25.0, 50.0, 100.0)]
    assert by_years == sorted(by_years)
    by_activity = [worth.worth_of(bodies, 50.0, name).total for name in ("low", "mean", "high")]
    assert by_activity == sorted(by_activity, reverse=True)


def test_a_collision_is_catastrophic_from_forty_joules_per_gram() -> None:
    """Above 40 J/g the fragments are those of both masses, below those of mass times speed."""
    records = [
        ElementSet("A", "", 1, field(1)[0].epoch, 14.2, 0.002, 71.0, 0.0, 0.0, 0.0),
        ElementSet("B", "", 2, field(1)[0].epoch, 14.2, 0.002, 98.0, 0.0, 0.0, 0.0),
    ]
    speed_km_s = math.sqrt(MU_M3_S2 / (EARTH_RADIUS_M + 825e3)) / 1e3
    relative = speed_km_s * mean_speeds()[round(71 / 2), 49]
    for light, catastrophic in ((0.5, False), (50.0, True)):
        bodies = worth.bodies_of(
            records, None, {0: worth.Measures(5000.0, 3.0), 1: worth.Measures(light, 3.0)}
        )
        made = worth.worth_of(bodies, 50.0)
        assert (0.5e6 * light * relative**2 / 5000.0 > 40e3) == catastrophic
        assert (made.catastrophic[0] > 0.0) == catastrophic
        effective = 5000.0 + light if catastrophic else light * relative
        fragments = 0.1 * 0.1**-1.71 * effective**0.75
        stay = made.alone[0] / made.encounters[0] / fragments
        assert 0.0 < stay < 0.5 * 50.0**2


def test_fragment_years_are_those_of_lives_within_the_horizon() -> None:
    """High up all fragments outlast the horizon, T²/2; low down each counts its life only."""
    years, step = fragment_years(40.0, "mean")
    assert years.shape[0] == len(KINDS)
    assert step * (EXPOSURES - 1) == pytest.approx(40.0)
    assert years[:, -1, -1] == pytest.approx(0.5 * 40.0**2, rel=0.06)
    assert np.all(years[:, :, 0] == 0.0)
    assert np.all(np.diff(years, axis=2) >= 0.0)
    assert np.all(years[:, 0, -1] < 40.0 * 0.1)


@pytest.mark.parametrize("kind", KINDS)
def test_areas_of_fragments_are_a_distribution(kind: str) -> None:
    """Shares add up to 1 and are centred where the breakup model has them."""
    areas, shares = area_shares(kind)
    assert shares.sum() == pytest.approx(1.0)
    assert 0.05 < 10.0 ** float(shares @ np.log10(areas)) < 0.4


@pytest.mark.parametrize(("altitude_km", "area"), [(600.0, 0.1), (800.0, 0.0046)])
def test_lifetimes_on_circles_are_integrals_of_the_density(altitude_km: float, area: float) -> None:
    """A circle comes down in the integral of da / (ρ Cd A/m sqrt(μ a))."""
    altitudes, logs = table("mean")

    def slowness(altitude: float) -> float:
        density = math.exp(np.interp(altitude, altitudes, logs))
        return 1.0 / (density * 2.2 * area * math.sqrt(MU_M3_S2 * (EARTH_RADIUS_M + altitude)))

    expected = quad(slowness, 120e3, 1e3 * altitude_km, points=altitudes[1:20], limit=500)[0]
    radius = EARTH_RADIUS_M + 1e3 * altitude_km
    found = lifetimes(np.array([[radius, radius]]), np.array([area]), "mean", 1e6)[0]
    assert found == pytest.approx(expected / YEAR_S, rel=0.02)


def test_lifetimes_of_ellipses_are_those_of_averaged_motion() -> None:
    """An ellipse comes down when Gauss's equations, averaged over its anomaly, say so."""
    altitudes, logs = table("high")
    nodes, weights = np.polynomial.legendre.leggauss(200)
    anomalies = 0.5 * math.pi * (nodes + 1.0)

    def rates(_: float, state: np.ndarray) -> list[float]:
        axis, eccentricity = state
        part = eccentricity * np.cos(anomalies)
        density = np.exp(np.interp(axis * (1.0 - part) - EARTH_RADIUS_M, altitudes, logs))
        drag = 2.2 * 0.02 * math.sqrt(MU_M3_S2 * axis)
        speed = np.sqrt((1.0 + part) / (1.0 - part))
        down = 0.5 * weights @ (density * speed * (1.0 + part))
        round_ = 0.5 * weights @ (density * speed * (1.0 - eccentricity**2) * np.cos(anomalies))
        return [-drag * down, -drag * round_ / axis]

    def low(_: float, state: np.ndarray) -> float:
        return float(state[0] * (1.0 - state[1]) - EARTH_RADIUS_M - 130e3)

    low.terminal = True  # type: ignore[attr-defined]
    perigee, apogee = EARTH_RADIUS_M + 350e3, EARTH_RADIUS_M + 1200e3
    axis = 0.5 * (perigee + apogee)
    flown = solve_ivp(
        rates, (0.0, 1e10), [axis, (apogee - perigee) / (apogee + perigee)], events=low, rtol=1e-7
    )
    found = lifetimes(np.array([[perigee, apogee]]), np.array([0.02]), "high", 1e6)[0]
    assert found == pytest.approx(flown.t[-1] / YEAR_S, rel=0.03)


def written(text: str, folder: Path) -> Path:
    """A satcat file."""
    path = folder / "satcat.tsv"
    path.write_text(text, encoding="utf-8")
    return path


def test_masses_are_dry_for_stages_with_flags_and_unknowns(tmp_path: Path) -> None:
    """A stage has its dry mass, a payload its mass; flags are kept, 0 and - are unknown."""
    text = HEADER + "# Updated 2026 Jan  4 0710:39\n" + STAGE + PAYLOAD + UNKNOWN + PART + GHOST
    satcat = worth.read_satcat(written(text, tmp_path))
    stage, payload, unknown = (satcat.by_number[number] for number in (10000, 10001, 10002))
    assert (stage.kind, stage.mass) == ("rocket body", (8900.0, True))
    assert (stage.length, stage.diameter) == ((10.4, False), (3.9, False))
    assert (payload.kind, payload.mass, payload.diameter) == ("payload", (1200.0, False), None)
    assert (unknown.mass, unknown.length) == (None, None)
    assert 10003 not in satcat.by_number
    assert satcat.updated == "2026 Jan  4"


def test_sources_go_from_the_table_to_defaults(tmp_path: Path) -> None:
    """A table goes before the satcat, this before the element set, and defaults come last."""
    satcat = worth.read_satcat(written(HEADER + STAGE + PAYLOAD + UNKNOWN, tmp_path))
    records = [replace(record, name="THING") for record in field(6)]
    records[2] = replace(records[2], mass_kg=77.0)
    records[3] = replace(records[3], name="OLD R/B", bstar=0.0)
    records[4] = replace(records[4], name="OLD DEB", size="MEDIUM")
    records[5] = replace(records[5], decays=datetime(2020, 1, 1, tzinfo=UTC))
    bodies = worth.bodies_of(records, satcat, {1: worth.Measures(mass=5.0)})
    assert bodies.mass_sources == (
        "satcat, uncertain",
        "table",
        "element set",
        "default: rocket body",
        "default: debris",
    )
    assert bodies.masses[:3].tolist() == [8900.0, 5.0, 77.0]
    assert bodies.kinds == ("rocket body", "payload", "payload", "rocket body", "debris")
    assert bodies.sizes[0] == pytest.approx(cylinder(10.4, 3.9))
    assert bodies.area_sources[0] == "size and mass"
    assert bodies.areas[0] == pytest.approx(0.25 * math.pi * bodies.sizes[0] ** 2 / 8900.0)
    assert bodies.areas[4] == pytest.approx(12.741621 * records[4].bstar / 2.2)
    assert bodies.area_sources[3:] == ("default: rocket body", "B*")
    assert (bodies.matched, bodies.left_out) == (3, {"decayed": 1})


def test_excluded_names_are_counted() -> None:
    """Objects left out by name are not among the bodies."""
    bodies = worth.bodies_of(field(5), excluded=("OBJECT 3*",))
    assert (len(bodies), bodies.left_out) == (4, {"excluded": 1})


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "no object in it"),
        ("hello\n", "no line of columns"),
        (HEADER, "no object in it"),
        (HEADER.replace("DryMass", "Dry"), "line 1: no column DryMass"),
        (HEADER + STAGE.replace("8900", "-5"), "line 2: DryMass = -5: must not be negative"),
        (HEADER + STAGE.replace("8900", "heavy"), "line 2: DryMass = 'heavy': must be a number"),
        (HEADER + "S1\t1\n", "line 2: 2 columns of 13"),
    ],
)
def test_bad_satcats_are_refused(text: str, said: str, tmp_path: Path) -> None:
    """One sentence names the file, the line and the fault."""
    with pytest.raises(InputError, match=said):
        worth.read_satcat(written(text, tmp_path))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "empty"),
        ("object,weight\n", "give the columns"),
        ("object,mass\n10000,-3\n", "line 2: mass = -3: must be positive"),
        ("object,mass\n10000,x\n", "must be a number"),
        ("object,mass\n10000\n", "1 values under 2 columns"),
        ("object,mass\n99,3\n98,3\n", "none of its 2 objects, '99' for one, is in the catalogue"),
        ("object,mass\n10000,3\n10000,3\n", "already has a row"),
    ],
)
def test_bad_tables_are_refused(text: str, said: str, tmp_path: Path) -> None:
    """One sentence names the file, the line and the fault."""
    path = tmp_path / "t.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=said):
        worth.read_measures(path, field(3))


def test_a_table_may_have_more_objects_than_the_catalogue(tmp_path: Path) -> None:
    """Rows of other objects are told apart, wherever they stand; those of the catalogue count."""
    path = tmp_path / "t.csv"
    path.write_text("object,mass\n99,3\n10001,5\nGONE,4\n", encoding="utf-8")
    table = worth.read_measures(path, field(3))
    assert table.known == {1: worth.Measures(mass=5.0)}
    assert table.strange == ("99", "GONE")


@pytest.mark.parametrize("mark", STAGES)
def test_stage_families_weigh_what_their_source_says(mark: str) -> None:
    """The name of a stage gives its mass, also among words; debris and other stages keep theirs."""
    names = (mark, f"OLD {mark} 7", mark.replace("R/B", "DEB"), f"X{mark}", "SL-14 R/B")
    records = [replace(each, name=name) for each, name in zip(field(5), names, strict=True)]
    bodies = worth.bodies_of(records)
    assert bodies.masses[:2].tolist() == [STAGES[mark].mass] * 2
    assert bodies.mass_sources[:2] == ("stage family",) * 2
    assert all(source.startswith("default") for source in bodies.mass_sources[2:])
    assert bodies.masses[4] == 1400.0
    assert sum(bodies.default_masses.values()) == 3
    assert bodies.default_masses["rocket body 1400 kg"] >= 2


def test_the_page_has_the_stage_families() -> None:
    """Names and masses of the page are those of the module."""
    page = Path("docs/worth.md").read_text(encoding="utf-8")
    for mark, stage in STAGES.items():
        assert f"`{mark.removesuffix(' R/B')}`" in page
        assert f"{stage.mass:,.0f}" in page


@pytest.mark.external
@pytest.mark.skipif(not DATA.is_dir(), reason=f"no folder {DATA} (ADR_OPT_EXTERNAL_DATA)")
def test_the_sample_of_the_general_catalog_is_read() -> None:
    """Seven objects; the last stage has a dry mass that is certain and a mass that is not."""
    satcat = worth.read_satcat(DATA / "gcat/satcat-sample.tsv")
    assert (len(satcat), satcat.updated) == (7, "2026 Jan  4")
    assert satcat.by_number[47].mass == (600.0, False)
    assert satcat.by_number[12].mass == (22.0, False)
    assert satcat.by_number[22].mass == (41.0, False)
    assert satcat.by_number[29].kind == "payload"
