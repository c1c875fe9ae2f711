"""Missions with windows, other stations and other starts, in all that shows a plan."""

from __future__ import annotations

import json
import re
from itertools import pairwise
from pathlib import Path

import pytest

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.export.flights import write_plan
from adr_opt.export.tables import write_matrix, write_timetable
from adr_opt.fly.trajectory import sample
from adr_opt.plan.plan import Plan
from adr_opt.problem.chasers import AtStation, InOrbit
from adr_opt.problem.instance import Instance
from adr_opt.ui.plot.gantt import segments
from adr_opt.ui.report import page
from adr_opt.ui.report.figures.planes import planes


def two_stations(tiny: Instance) -> Instance:
    """The station, and a depot somewhat above it."""
    station = tiny.stations[0]
    depot = station.orbit.replace(semi_major_axis_m=station.orbit.semi_major_axis_m + 2e4)
    return tiny.replace(stations=(station, station.replace(name="depot", orbit=depot)))


def no_station(tiny: Instance) -> Instance:
    """The chaser begins in an orbit of its own, and never refuels."""
    orbit = tiny.targets[0].orbit.replace(raan_deg=0.3)
    return tiny.replace(
        stations=(), chasers=(tiny.chaser.replace(start=InOrbit(orbit=orbit), max_targets=3),)
    )


def there_and_home(tiny: Instance) -> Instance:
    """The chaser begins in an orbit of its own, and ends at the station, before its time."""
    orbit = tiny.targets[0].orbit.replace(raan_deg=0.3)
    chaser = tiny.chaser.replace(
        start=InOrbit(orbit=orbit), end=AtStation(station="station"), available_s=(600.0, 120e3)
    )
    return tiny.replace(chasers=(chaser,))


def windows(tiny: Instance) -> Instance:
    """One target after the other, so that the chaser arrives before the first window opens."""
    targets = [
        target.replace(window_s=(40e3 + 20e3 * number, 60e3 + 20e3 * number), required=number == 0)
        for number, target in enumerate(tiny.targets)
    ]
    return tiny.replace(targets=tuple(targets))


@pytest.fixture(scope="module", params=[two_stations, no_station, there_and_home, windows])
def flown(request: pytest.FixtureRequest) -> tuple[Instance, Plan]:
    instance = request.param(adr_opt.generate("tiny", 0))
    plan = adr_opt.solve(instance, "exact", time_limit=60.0).plan
    assert plan is not None
    assert plan.legs
    assert adr_opt.check(instance, plan) == ()
    return instance, plan


def test_phases_fill_the_plan_and_are_those_that_are_flown(flown) -> None:
    """Drawn phases follow each other without a gap, and are the arcs of the trajectory."""
    instance, plan = flown
    drawn = segments(instance, plan)
    for before, after in pairwise(drawn):
        assert after.start_s == pytest.approx(before.end_s, abs=1e-6)
    arcs = [
        (path.number, arc.phase, arc.start_s, arc.end_s)
        for path, arc in sample(instance, plan, 600.0).arcs()
    ]
    shown = [
        (one.leg, "service" if one.phase == "refuelling" else one.phase, one.start_s, one.end_s)
        for one in drawn
    ]
    assert [arc[:2] for arc in arcs] == [one[:2] for one in shown]
    for arc, one in zip(arcs, shown, strict=True):
        assert arc[2:] == pytest.approx(one[2:], abs=1e-6)


def test_who_is_early_waits_at_the_target() -> None:
    """Before its window opens the chaser waits there, and service takes as long as elsewhere."""
    instance = windows(adr_opt.generate("tiny", 0))
    plan = adr_opt.solve(instance, "exact", time_limit=60.0).plan
    assert plan is not None
    opens = {target.name: target.window_s[0] for target in instance.targets}
    early = [
        (at, leg)
        for at, leg in enumerate(plan.legs, start=1)
        if leg.arrival_s < opens.get(leg.destination, 0.0)
    ]
    assert early
    services = adr_opt.Mission(instance).rules.service
    for at, leg in early:
        *_, wait, service = [one for one in segments(instance, plan) if one.leg == at]
        assert (wait.phase, service.phase) == ("wait", "service")
        assert (wait.start_s, wait.end_s) == (leg.arrival_s, opens[leg.destination])
        assert service.duration_s == pytest.approx(services[instance.names.index(leg.destination)])


def test_the_report_says_what_is_asked(flown) -> None:
    """The page has its tick, the path, and every rule of the instance in words."""
    instance, plan = flown
    text = page(instance, plan)
    assert "no violations" in text
    assert "cannot be drawn" not in text
    assert ("has to end at station" in text) == isinstance(instance.chaser.end, AtStation)
    assert ("in an orbit of its own" in text) == isinstance(instance.chaser.start, InOrbit)
    assert ("with a window of time" in text) == any(t.window_s[1] for t in instance.targets)
    assert ("1 target required" in text) == any(t.required for t in instance.targets)
    assert ("may service 3 targets" in text) == (instance.chaser.max_targets == 3)
    assert "m/s per hour" not in text


def test_the_planes_begin_where_the_chaser_does(flown) -> None:
    """The line of the chaser begins at its start, and only targets count as visited or not."""
    instance, plan = flown
    chaser, *missed, visited, numbers, stations = planes(instance, plan)["data"]
    start = instance.body_orbits[instance.start]
    assert chaser["y"][0] == pytest.approx(start.inclination_deg, abs=1e-4)
    assert len(stations["x"]) == len(instance.stations)
    assert sum(len(of["x"]) for of in (*missed, visited)) == len(instance.targets)
    targets = {target.name for target in instance.targets}
    visits = [n for n, leg in enumerate(plan.legs, start=1) if leg.destination in targets]
    assert numbers["text"] == [str(n) for n in visits]


def test_the_flight_is_written_in_every_format(flown, tmp_path: Path) -> None:
    """All formats can be written, and in GMAT no two bodies share a name."""
    instance, plan = flown
    for suffix in ("oem", "opm", "czml", "script"):
        write_plan(instance, plan, tmp_path / f"mission.{suffix}", step_s=600.0)
    script = (tmp_path / "mission.script").read_text()
    names = re.findall(r"^Create Spacecraft (\w+);", script, re.MULTILINE)
    assert len(names) == len(set(names))
    assert ("Station" in names) == (len(instance.stations) == 1)
    bodies = {leg.origin for leg in plan.legs} | {leg.destination for leg in plan.legs}
    assert len(names) >= 1 + len(bodies)


def test_formats_with_one_depot_refuse_other_missions(flown, tmp_path: Path) -> None:
    """A mission that does not begin at its only station cannot be a file with one depot."""
    instance, _ = flown
    one = len(instance.stations) == 1 and instance.first_target == 1
    for suffix in ("vrp", "oplib"):
        path = tmp_path / f"costs.{suffix}"
        if one:
            write_matrix(instance, path, 0.0)
        else:
            with pytest.raises(InputError, match="one depot"):
                write_matrix(instance, path, 0.0)
    write_matrix(instance, tmp_path / "costs.tsp", 0.0)
    said = (tmp_path / "costs.tsp").read_text()
    assert ("node 1 is the station" in said) == one


def test_parquet_states_the_prizes_of_the_instance(tmp_path: Path) -> None:
    """What planners add for required targets is no prize."""
    parquet = pytest.importorskip("pyarrow.parquet")
    instance = windows(adr_opt.generate("tiny", 0))
    write_timetable(instance, tmp_path / "costs.parquet")
    metadata = parquet.read_schema(tmp_path / "costs.parquet").metadata
    stated = {body["name"]: body["prize"] for body in json.loads(metadata[b"bodies_json"])}
    assert stated == {"station": 0.0} | {target.name: target.prize for target in instance.targets}
