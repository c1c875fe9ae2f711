"""From a catalogue to an instance: filters, the station, names, warnings."""

from __future__ import annotations

import json
import math
import time
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest
from catalogue_files import SPELLINGS, as_csv, as_json, field, omm_fields, one

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M
from adr_opt.sources.catalogue import Filters, MissionOutline, read, to_instance
from adr_opt.sources.catalogue.reading import read_bytes
from adr_opt.sources.catalogue.selection import densest, normals, plane_angles

pytest.importorskip("sgp4.api")


def test_filters_keep_what_is_inside() -> None:
    """Each filter keeps exactly the orbits between its limits, and says what it left out."""
    records = field(200)
    everything = to_instance(records).instance
    filters = Filters(
        altitude_km=(700.0, 900.0), inclination_deg=(60.0, 90.0), raan_deg=(300.0, 60.0)
    )
    made = to_instance(records, filters=filters)

    def inside(target: adr_opt.problem.bodies.Target) -> bool:
        orbit = target.orbit
        return (
            700e3 <= orbit.semi_major_axis_m - EARTH_RADIUS_M <= 900e3
            and 60.0 <= orbit.inclination_deg <= 90.0
            and (orbit.raan_deg >= 300.0 or orbit.raan_deg <= 60.0)
        )

    wanted = [target for target in everything.targets if inside(target)]
    assert 0 < len(wanted) < 100
    assert list(made.instance.targets) == wanted
    assert set(made.counts) == {"altitude", "inclination", "raan"}
    assert sum(made.counts.values()) == len(records) - len(wanted)
    assert made.read == len(records)


@pytest.mark.parametrize(
    ("pattern", "count"),
    [("object 3 deb", 3), ("OBJECT ? DEB", 27), ("*9[0-6] DEB", 14), ("ROCKET", 0), ("deb", 200)],
)
def test_name_patterns(pattern: str, count: int) -> None:
    """Patterns fit whole names and other texts parts of them, whatever the case."""
    filters = Filters(names=(pattern,))
    names = [record.name.lower() for record in field(200)]
    assert sum(filters.match_name(record) for record in field(200)) == {
        "object 3 deb": names.count("object 3 deb"),
        "OBJECT ? DEB": sum(len(name) == len("object 3 deb") for name in names),
    }.get(pattern, count)


def test_raan_range_through_zero_and_all_around() -> None:
    """Ranges of RAAN go eastwards, through 0 if need be; 0:360 is everything."""
    elements = np.zeros((4, 6))
    elements[:, 3] = np.radians([355.0, 5.0, 15.0, -20.0])
    for limits, outside in (
        ((350.0, 10.0), [False, False, True, True]),
        ((-10.0, 10.0), [False, False, True, True]),
        ((0.0, 360.0), [False, False, False, False]),
        ((5.0, 15.0), [True, False, False, True]),
    ):
        assert list(Filters(raan_deg=limits).outside(elements)["raan"]) == outside


def test_the_densest_plane_has_most_neighbours() -> None:
    """The station's plane is the centre of the largest group within two degrees (brute force)."""
    random = np.random.default_rng(5)
    elements = np.zeros((300, 6))
    elements[:, 0] = EARTH_RADIUS_M + random.uniform(600e3, 900e3, 300)
    elements[:, 2] = np.radians(random.uniform(80.0, 100.0, 300))
    elements[:, 3] = np.radians(random.uniform(0.0, 40.0, 300))
    found = densest(elements)
    near = np.array(
        [plane_angles(elements, row[2], row[3]) < math.radians(2.0) for row in elements]
    )
    group = near[near.sum(axis=1).argmax()]
    assert found[0] == np.median(elements[group, 0])
    centre = normals(elements[group]).mean(axis=0)
    assert normals(found[None])[0] == pytest.approx(centre / np.linalg.norm(centre), abs=1e-12)


def test_max_targets_are_the_nearest_planes() -> None:
    """With --max-targets the planes nearest to the station's stay, in the order of the file."""
    records = field(100)
    made = to_instance(records, station="750,86.4,120", max_targets=10)
    everything = to_instance(records, station="750,86.4,120").instance
    home = everything.stations[0].orbit
    assert (home.inclination_deg, home.raan_deg, home.true_anomaly_deg) == (86.4, 120.0, 0.0)
    station = adr_opt.kernels.orbits.ephemeris.frame(*np.radians([86.4, 120.0]))[2]

    def angle(target: adr_opt.problem.bodies.Target) -> float:
        _, i, o, _ = target.orbit.circular_elements()
        return math.acos(station @ adr_opt.kernels.orbits.ephemeris.frame(i, o)[2])

    nearest = sorted(everything.targets, key=angle)[:10]
    kept = made.instance.targets
    assert {target.name for target in kept} == {target.name for target in nearest}
    assert [t.name for t in kept] == [t.name for t in everything.targets if t in kept]
    assert made.counts == {"max-targets": 90}


def test_a_station_at_an_object() -> None:
    """An object told by number, name or designator is the station and no target."""
    records = field(5)
    for told in ("10002", "object 2 deb", records[2].object_id):
        instance = to_instance(records, station=told).instance
        assert instance.stations[0].name == "OBJECT 2 DEB 10002"
        assert len(instance.targets) == 4
        assert instance.stations[0].orbit == to_instance(records).instance.targets[2].orbit


def test_names_of_targets_are_unique() -> None:
    """Objects of one name are told apart by their numbers, or else counted."""
    records = field(98)
    names = to_instance(records).instance.names
    assert len(set(names)) == 99
    assert {"OBJECT 0 DEB 10000", "OBJECT 0 DEB 10097"} <= set(names)
    fields = omm_fields(records[0]) | {"NORAD_CAT_ID": None, "OBJECT_ID": None}
    odd = [
        one(json.dumps(fields | {"OBJECT_NAME": name})) for name in ("station", "x\x1b[2J\ud800")
    ]
    assert to_instance(odd).instance.names == ("station", "station (2)", "x?[2J?")
    called = to_instance([one(json.dumps(fields | {"OBJECT_NAME": "chaser"}))]).instance
    assert (called.names, called.chaser.name) == (("station", "chaser"), "chaser-1")


def test_the_same_catalogue_gives_the_same_file() -> None:
    """All spellings of a catalogue give one instance file, byte for byte."""
    records = field(30)
    texts = {
        to_instance(read_bytes(write(records).encode(), "a.txt"), max_targets=20).instance.to_json()
        for write in SPELLINGS.values()
    }
    assert len(texts) == 1


def test_an_imported_instance_is_planned_and_checked() -> None:
    """An instance made of a catalogue loads, is planned by greedy and passes the check."""
    instance = to_instance(field(400), max_targets=15, station="800,86.4,100").instance
    result = adr_opt.solve(instance, method="greedy-guarded")
    assert result.objective >= 1.0
    assert adr_opt.check(instance, result.plan) == ()


@pytest.mark.slow
def test_a_catalogue_of_24000_objects_takes_less_than_5_s(tmp_path: Path) -> None:
    """24,000 objects are read, propagated, filtered and made an instance in under 5 s of work."""
    path = tmp_path / "all.csv"
    path.write_text(as_csv(field(24_000)), encoding="utf-8")
    begin = time.process_time()
    found = read(path)
    made = to_instance(found, filters=Filters(inclination_deg=(80.0, 90.0)), max_targets=100)
    assert time.process_time() - begin < 5.0
    assert made.read == 24_000
    assert len(made.instance.targets) == 100


def test_warnings_name_days_altitudes_and_numbers() -> None:
    """Old elements, unreachable altitudes and too many targets are warned of, with numbers."""
    records = field(10)
    # Half a day: time for a leg, and too little for drag to show.
    assert to_instance(records, mission=MissionOutline(duration_s=43_200.0)).warnings == ()
    late = max(record.epoch for record in records) + timedelta(days=30)
    later = MissionOutline(epoch=late, duration_s=43_200.0)
    (warning,) = to_instance(records, mission=later).warnings
    assert "10 of 10 objects are more than 7 days from the epoch" in warning
    assert "30." in warning
    high = one(as_json(records[:1]).replace(str(records[0].mean_motion_rev_day), "2.0"))
    (warning,) = to_instance([high], mission=MissionOutline(duration_s=172_800.0)).warnings
    assert "2 of 2 bodies are outside the altitudes of phasing, 300 to 2000 km" in warning
