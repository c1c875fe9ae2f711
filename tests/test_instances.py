"""Instance files: the format, the generator, and what is committed."""

from __future__ import annotations

import json
import math
from pathlib import Path

import jsonschema
import pytest
from hand_made import hand_made

import adr_opt
from adr_opt import instance as instance_module
from adr_opt import plan as plan_module
from adr_opt.generator import FAMILIES
from adr_opt.kernels.constants import EARTH_RADIUS_M

INSTANCES = Path(__file__).parents[1] / "instances"
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


def test_known_bytes():
    """The generator's stream is pinned: a change of any digit changes this checksum."""
    assert adr_opt.generate("nominal", 7, zones=6).sha256 == (
        "8df7a658adfc5e3036808a030337a0ce81bdb2cb4937efc436c9310390636352"
    )


@pytest.mark.parametrize("name", FAMILIES)
def test_families(name):
    """Instances of a family have its size, duration and budget, within the calibrated spread."""
    family = FAMILIES[name]
    sizes = set()
    for seed in range(40):
        made = adr_opt.generate(name, seed)
        sizes.add(len(made.targets))
        assert made.mission.duration_s == family.duration_s
        assert made.mission.delta_v_m_s == family.delta_v_m_s
        for target in made.targets:
            altitude = target.orbit.semi_major_axis_m - EARTH_RADIUS_M
            assert 700e3 <= altitude <= 800e3
            assert 95.0 <= target.orbit.inclination_deg <= 97.0
            assert -1.0 <= target.orbit.raan_deg <= 1.0
            assert target.orbit.eccentricity == 0.0
    assert sizes == set(range(family.targets[0], family.targets[1] + 1))


def test_families_share_fields():
    """nominal, reduced-time and reduced-fuel of one seed have the same debris."""
    fields = {adr_opt.generate(name, 5).targets for name in FAMILIES if name != "tiny"}
    assert len(fields) == 1


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


def test_files_survive_a_round_trip(tmp_path):
    """Writing and reading gives the same instance and the same SHA-256."""
    made = adr_opt.generate("tiny", 2, zones=2)
    path = tmp_path / "i.json"
    path.write_text(made.to_json())
    assert adr_opt.load(path) == made
    assert adr_opt.load(path).sha256 == made.sha256


def test_schema_accepts_what_the_program_writes():
    """The published JSON Schemas accept instances and plans, and refuse unknown keys."""
    made = adr_opt.generate("tiny", 2, zones=2)
    schema = instance_module.json_schema()
    document = json.loads(made.to_json())
    jsonschema.validate(document, schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(document | {"colour": "red"}, schema)
    result = adr_opt.solve(made, "greedy-guarded")
    jsonschema.validate(json.loads(result.plan.to_json()), plan_module.json_schema())


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


def test_eccentricity_costs():
    """Matching eccentricity vectors costs v·|Δe|/2, is part of the leg, and the plan says so."""
    made = hand_made()
    north = made.targets[0]
    eccentric = north.replace(orbit=north.orbit.replace(eccentricity=0.01))
    changed = made.replace(targets=(eccentric, *made.targets[1:]))
    before = adr_opt.Timetable(made).lookup("station", "north", 0.0)
    after = adr_opt.Timetable(changed).lookup("station", "north", 0.0)
    speed = math.sqrt(3.986004418e14 / north.orbit.semi_major_axis_m)
    assert after[0] - before[0] == pytest.approx(0.5 * speed * 0.01, rel=1e-12)
    assert after[1] == before[1]
    result = adr_opt.solve(changed, "greedy-guarded")
    assert any("approximation" in note for note in result.plan.notes)
    assert adr_opt.check(changed, result.plan) == ()


def test_replace_validates():
    """A variant made by replace() obeys the same rules as a file."""
    with pytest.raises(adr_opt.InputError, match="delta_v_m_s"):
        hand_made().mission.replace(delta_v_m_s=-1.0)
