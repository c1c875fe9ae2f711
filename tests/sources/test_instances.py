"""Instance files: the format, the generator, and what is committed."""

from __future__ import annotations

import importlib.util
import math
import os
import sys
from itertools import pairwise
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from hand_made import RADIUS_M, hand_made
from worth import fit as fit_of

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M
from adr_opt.problem import instance as instance_module
from adr_opt.sources.generator import FAMILIES, by_name, clouds
from adr_opt.sources.generator.stream import at_percentile
from adr_opt.sources.library import Entry, Library, load_library

ROOT = Path(__file__).parents[2]
INSTANCES = ROOT / "instances"
EXTERNAL = Path(os.environ.get("ADR_OPT_EXTERNAL_DATA", ROOT.parent / "shared" / "data"))
CATALOGUE = EXTERNAL / "omm" / "celestrak_2025-04_iridium-33-debris.csv"
COMMITTED = sorted(
    path for name in FAMILIES for path in (INSTANCES / name).glob("*-[0-9][0-9][0-9].json")
)


def test_twenty_nominal_and_some_tiny_are_committed():
    """instances/ holds nominal-000…019 and tiny ones."""
    names = {path.stem for path in COMMITTED}
    assert {f"nominal-{seed:03d}" for seed in range(20)} <= names
    assert sum(name.startswith("tiny") for name in names) >= 10


@pytest.mark.parametrize("path", COMMITTED, ids=lambda path: path.stem)
def test_committed_files_are_what_the_generator_gives(path):
    """Each committed instance is, byte for byte, what its family and seed generate."""
    family, _, seed = path.stem.rpartition("-")
    assert path.read_bytes() == adr_opt.generate(family, int(seed)).to_json().encode()


def test_hand_made_file():
    """The hand-made file is the instance that the tests work out on paper."""
    path = INSTANCES / "tiny" / "hand-made.json"
    assert path.read_bytes() == hand_made().to_json().encode()


def test_more_chasers_and_stations_leave_the_field_as_it_is():
    """Further chasers and stations have names of their own, start in turn, and change no target."""
    plain = adr_opt.generate("nominal", 3)
    made = adr_opt.generate("nominal", 3, chasers=3, stations=2)
    assert made.targets == plain.targets
    assert made.stations[0] == plain.stations[0]
    assert [chaser.name for chaser in made.chasers] == ["chaser-1", "chaser-2", "chaser-3"]
    assert [chaser.start.station for chaser in made.chasers] == ["station", "station-2", "station"]
    assert len({chaser.tank for chaser in made.chasers}) == 1
    alone = adr_opt.generate("rocket-bodies", 3)
    several = adr_opt.generate("rocket-bodies", 3, chasers=3)
    assert several.targets == alone.targets
    assert several.stations == ()
    orbits = [chaser.start.orbit for chaser in several.chasers]
    assert orbits[0] == alone.chaser.start.orbit
    assert len(set(orbits)) == 3
    for changed in (made, several):
        assert by_name(changed.name) == changed
    with pytest.raises(adr_opt.InputError):
        adr_opt.generate("rocket-bodies", 3, stations=2)


BELT = ["tiny", "nominal", "reduced-time", "reduced-fuel", "campaign", "large"]


@pytest.mark.parametrize("name", FAMILIES)
def test_families(name):
    """Instances of a family have its size, duration and budget, and its station."""
    family = FAMILIES[name]
    sizes = set()
    for seed in range(40 if name == "tiny" else 5):
        made = adr_opt.generate(name, seed)
        sizes.add(len(made.targets))
        assert made.mission.duration_s == family.duration_s
        assert len(made.chasers) == family.chasers
        assert {chaser.tank.delta_v_m_s for chaser in made.chasers} == {family.delta_v_m_s}
        assert [station.orbit for station in made.stations] == [family.station] * (
            family.station is not None
        )
        assert made.dynamics == ("j2" if family.drifts else "two-body")
        assert {target.prize for target in made.targets} == {1.0}
    assert sizes == set(range(family.targets[0], family.targets[1] + 1))


@pytest.mark.parametrize("name", BELT)
def test_the_belt_is_within_the_calibrated_spread(name):
    """Altitudes, inclinations and planes of the families of the belt are those of the study."""
    for seed in range(5):
        for target in adr_opt.generate(name, seed).targets:
            altitude = target.orbit.semi_major_axis_m - EARTH_RADIUS_M
            assert 700e3 <= altitude <= 800e3
            assert 95.0 <= target.orbit.inclination_deg <= 97.0
            assert -1.0 <= target.orbit.raan_deg <= 1.0
            assert target.orbit.eccentricity == 0.0


def test_families_share_fields():
    """nominal, its two variants and campaign of one seed have the same debris; large begins so."""
    fields = {
        adr_opt.generate(name, 5).targets
        for name in ("nominal", "reduced-time", "reduced-fuel", "campaign")
    }
    assert fields == {adr_opt.generate("large", 5).targets[:50]}


def test_cloud_follows_its_numbers():
    """Many fragments have the percentiles, limits and rank correlations that the family states."""
    orbits = [t.orbit for t in adr_opt.generate("cloud", 0, targets=20000).targets]
    a = np.array([orbit.semi_major_axis_m for orbit in orbits])
    e = np.array([orbit.eccentricity for orbit in orbits])
    perigee = (a * (1.0 - e) - EARTH_RADIUS_M) / 1e3
    difference = 2.0 * a * e / 1e3
    inclination = np.array([orbit.inclination_deg for orbit in orbits])
    raan = np.array([orbit.raan_deg for orbit in orbits])
    for drawn, values in (
        (perigee, clouds.PERIGEE_KM),
        (difference, clouds.APOGEE_MINUS_PERIGEE_KM),
        (inclination, clouds.INCLINATION_DEG),
    ):
        assert drawn.min() >= values[0] - 0.01
        assert drawn.max() <= values[-1] + 0.01
        for percentile, value in zip(clouds.PERCENTILES[1:-1], values[1:-1], strict=True):
            assert 100.0 * (drawn <= value).mean() == pytest.approx(percentile, abs=1.5)
    assert np.abs(raan).max() <= clouds.HALF_WIDTH_DEG
    assert np.histogram(raan, 4)[0] / raan.size == pytest.approx(np.full(4, 0.25), abs=0.02)

    def rank_correlation(x, y):
        return np.corrcoef(np.argsort(np.argsort(x)), np.argsort(np.argsort(y)))[0, 1]

    assert rank_correlation(perigee, difference) == pytest.approx(0.0, abs=0.03)
    assert rank_correlation(inclination, difference) == pytest.approx(
        clouds.INCLINATION_WITH_DIFFERENCE, abs=0.03
    )
    assert rank_correlation(raan, inclination) == pytest.approx(
        clouds.RAAN_WITH_INCLINATION, abs=0.03
    )
    for angle in ("argument_of_perigee_deg", "true_anomaly_deg"):
        drawn = np.array([getattr(orbit, angle) for orbit in orbits])
        assert np.histogram(drawn, 4, (0.0, 360.0))[0] / drawn.size == pytest.approx(
            np.full(4, 0.25), abs=0.02
        )


@pytest.mark.external
@pytest.mark.skipif(not CATALOGUE.is_file(), reason=f"no {CATALOGUE}")
def test_cloud_is_fitted_to_the_catalogue():
    """The numbers of the family are those that the script reads off the public catalogue."""
    fit = fit_of(CATALOGUE)
    assert fit.objects == 121
    assert fit.perigee == pytest.approx(clouds.PERIGEE_KM, abs=0.051)
    assert fit.difference == pytest.approx(clouds.APOGEE_MINUS_PERIGEE_KM, abs=0.051)
    assert fit.inclination == pytest.approx(clouds.INCLINATION_DEG, abs=0.00051)
    assert round(fit.half_width, 1) == clouds.HALF_WIDTH_DEG
    assert round(fit.inclination_with_difference, 2) == clouds.INCLINATION_WITH_DIFFERENCE
    assert round(fit.raan_with_inclination, 2) == clouds.RAAN_WITH_INCLINATION


def test_cloud_has_missions():
    """A planner visits a good part of a cloud, refuels, and its plan says it is approximate."""
    made = adr_opt.generate("cloud", 0)
    assert made.is_approximate
    plan = adr_opt.solve(made, "beam").plan
    assert adr_opt.check(made, plan) == ()
    assert 20 <= plan.objective < 50
    assert "station" in plan.destinations
    assert any("approximation" in note for note in plan.notes)


def test_at_percentile():
    """Between known percentiles values are linear, at the ends they are the extremes."""
    knots, values = (0.0, 50.0, 100.0), (1.0, 2.0, 6.0)
    assert [at_percentile(knots, values, share) for share in (0.0, 0.25, 0.5, 0.75, 1.0)] == [
        1.0,
        1.5,
        2.0,
        4.0,
        6.0,
    ]
    drawn = [at_percentile(clouds.PERCENTILES, clouds.PERIGEE_KM, k / 1000) for k in range(1001)]
    assert all(low < high for low, high in pairwise(drawn))


def script(path: Path) -> ModuleType:
    """A script of the repository as a module."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look themselves up there
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("every", [9, pytest.param(1, marks=pytest.mark.slow)])
def test_the_library_is_what_the_generator_gives(every):
    """Every instance of the library has the SHA-256 that is listed, and the sizes are as told."""
    library = load_library(INSTANCES / "library.json")
    assert {name: len(library.of_family(name)) for name in FAMILIES} == {
        "tiny": 10,
        "nominal": 100,
        "reduced-time": 100,
        "reduced-fuel": 100,
        "cloud": 20,
        "large": 35,
        "rocket-bodies": 20,
        "sso": 20,
        "campaign": 20,
        "removal": 20,
        "electric": 20,
        "fragment-cloud": 5,
    }
    for entry in library.instances[::every]:
        assert entry.generate().name == entry.name
    for path in COMMITTED[::every]:
        assert library.find(path.stem).sha256 == adr_opt.load(path).sha256


def test_every_family_has_a_readme_that_states_it():
    """instances/FAMILY/README.md gives number of targets, days, budget and seeds."""
    library = load_library(INSTANCES / "library.json")
    for name, family in FAMILIES.items():
        said = (INSTANCES / name / "README.md").read_text(encoding="utf-8")
        low, high = family.targets
        size = f"{low}–{high}" if high > low else f"{low}"
        days = f"{family.duration_s / 86400.0:g} days"
        budget = f"{family.delta_v_m_s / 1000.0:.3g} km/s"
        plain = [entry for entry in library.of_family(name) if "-n" not in entry.name]
        seeds = f"seeds 0–{len(plain) - 1}"
        for fact in (f"{size} targets", days, budget, seeds):
            assert fact in said, (name, fact)


def test_the_version_of_the_library_is_stated():
    """instances/README.md cites the version that library.json has."""
    library = load_library(INSTANCES / "library.json")
    assert f"version {library.version}" in (INSTANCES / "README.md").read_text(encoding="utf-8")


def test_names_lead_to_instances():
    """A name gives the instance of that name; other names are refused with an example."""
    for name in ("nominal-042", "reduced-fuel-000", "cloud-003-z6", "tiny-1234", "large-001-n5-z2"):
        assert by_name(name).name == name
    assert by_name("nominal-042") == adr_opt.generate("nominal", 42)
    for name in (
        "nominal",
        "nominal-7",
        "huge-001",
        "nominal-007 ",
        "nominal-0042",
        "nominal-001-z0",
    ):
        with pytest.raises(adr_opt.InputError, match=r"nominal-042|write it as"):
            by_name(name)


@pytest.mark.slow
def test_a_library_that_does_not_fit_is_noticed(tmp_path, capsys):
    """Another checksum is told with exit 1, wrong input with exit 2, and the rest is written."""
    write = script(INSTANCES / "write.py")
    good = load_library(INSTANCES / "library.json").find("tiny-001")
    bad = Entry(name="tiny-002", sha256="0" * 64)
    path = tmp_path / "library.json"
    path.write_text(Library(version="1.0", instances=(good, bad)).to_json())
    out = tmp_path / "out"
    assert write.main(["--library", str(path), "--out", str(out)]) == 1
    assert "generated with sha256" in capsys.readouterr().err
    assert [file.name for file in out.glob("*/*")] == ["tiny-001.json"]
    assert (out / "tiny" / "tiny-001.json").read_bytes() == (
        INSTANCES / "tiny" / "tiny-001.json"
    ).read_bytes()
    assert write.main(["--library", str(path), "huge"]) == 2
    assert write.main(["--library", str(path), "large"]) == 2
    assert write.main(["--library", str(tmp_path / "absent.json")]) == 2
    assert write.main(["--library", str(path), "--renew", "one"]) == 2
    path.write_text(path.read_text().replace("tiny-002", "tiny-001"))
    assert write.main(["--library", str(path)]) == 2
    assert "listed twice" in capsys.readouterr().err
    assert write.main(["--out", str(path), "tiny"]) == 2
    assert "cannot be created" in capsys.readouterr().err


def test_zones_do_not_change_the_field():
    """Drawing zones leaves the targets alone; zones lie where the model says."""
    plain, zoned = adr_opt.generate("nominal", 4), adr_opt.generate("nominal", 4, zones=6)
    assert plain.targets == zoned.targets
    assert len(zoned.keep_out_zones) == 6
    for zone in zoned.keep_out_zones:
        assert zone.min_altitude_m >= 680e3
        assert zone.max_altitude_m <= 830e3
        assert 10e3 - 1 <= zone.max_altitude_m - zone.min_altitude_m <= 25e3 + 1
        assert 6 * 3600 - 1 <= zone.end_s - zone.start_s <= 24 * 3600 + 1


def test_eccentric_orbit_becomes_its_mean_circle():
    """An eccentric orbit is planned with r = a and u = argument of perigee + mean anomaly."""
    orbit = instance_module.Orbit(
        semi_major_axis_m=7.2e6,
        eccentricity=0.05,
        inclination_deg=50.0,
        raan_deg=10.0,
        argument_of_perigee_deg=40.0,
        true_anomaly_deg=200.0,
    )
    radius, _, _, u = orbit.circular_elements()
    assert radius == 7.2e6
    true = math.radians(200.0)
    eccentric = math.atan2(math.sqrt(1 - 0.05**2) * math.sin(true), 0.05 + math.cos(true))
    mean = eccentric - 0.05 * math.sin(eccentric)
    assert math.remainder(u - math.radians(40.0) - mean, 2 * math.pi) == pytest.approx(0, abs=1e-12)


def sequence_by_hand(theta, matching):
    """ΔV of the first leg of the hand-made instance by the formulas of docs/model.md [m/s].

    Between equal circles θ apart, both at the node: with no revolution the sequence flies three
    half ellipses, and the target is a stand-off δ further than three half revolutions.
    """
    mu, radius, standoff, fraction = 3.986004418e14, RADIUS_M, 1e3, 0.75
    time = (3.0 * math.pi + standoff / radius) * math.sqrt(radius**3 / mu)

    def arcs(phasing):
        corner = phasing + fraction * (radius - phasing)
        return (radius, phasing), (phasing, corner), (corner, radius)

    low, high = radius - 50e3, radius + 50e3
    while low < (middle := 0.5 * (low + high)) < high:
        flown = math.pi / math.sqrt(8.0 * mu) * sum(sum(ends) ** 1.5 for ends in arcs(middle))
        low, high = (middle, high) if flown < time else (low, middle)

    def speed(at, other):
        return math.sqrt(2.0 * mu * other / (at * (at + other)))

    first, second, third = arcs(middle)
    circle = math.sqrt(mu / radius)
    v1, v2 = speed(*first[::-1]), speed(*second)
    turn = math.sqrt(v1**2 + v2**2 - 2.0 * v1 * v2 * math.cos(theta))
    circles = abs(speed(*first) - circle) + turn
    circles += abs(speed(*third) - speed(*second[::-1])) + abs(circle - speed(*third[::-1]))
    least = math.hypot(matching, 2.0 * math.sqrt(v1 * v2) * math.sin(0.5 * theta))
    return max(circles, least) + 0.5 * circle / radius * standoff


def test_eccentricity_costs():
    """A leg costs the larger of its sequence and of matching with the turn, and the plan says so.

    Matching alone is v·|Δe|/2: little of it rides on the burns of the sequence, more costs more.
    """
    made = hand_made()
    assert made.transfer.standoff_m == 1e3
    assert made.transfer.first_leg_fraction == 0.75
    north = made.targets[0]
    theta, circle = math.radians(1.0), math.sqrt(3.986004418e14 / RADIUS_M)
    round_one = adr_opt.Timetable(made).lookup("station", "north", 0.0)
    grown = []
    for eccentricity in (0.0, 1e-4, 0.01, 0.05):
        orbit = north.orbit.replace(eccentricity=eccentricity)
        changed = made.replace(targets=(north.replace(orbit=orbit), *made.targets[1:]))
        delta_v, duration = adr_opt.Timetable(changed).lookup("station", "north", 0.0)
        expected = sequence_by_hand(theta, 0.5 * circle * eccentricity)
        assert delta_v == pytest.approx(expected, rel=1e-9)
        assert duration == round_one[1]
        grown.append(delta_v - round_one[0])
    assert grown[:2] == [0.0, 0.0]
    assert 1.0 < grown[2] < grown[3]
    result = adr_opt.solve(changed, "greedy-guarded")
    assert any("approximation" in note for note in result.plan.notes)
    assert adr_opt.check(changed, result.plan) == ()


def test_replace_validates():
    """A variant made by replace() obeys the same rules as a file."""
    with pytest.raises(adr_opt.InputError, match="delta_v_m_s"):
        hand_made().chaser.tank.replace(delta_v_m_s=-1.0)
    with pytest.raises(adr_opt.InputError, match="duration_s"):
        hand_made().with_limits(duration_s=-1.0)
