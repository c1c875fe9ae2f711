"""When targets may be captured: intervals, and light and contacts by another library."""

from __future__ import annotations

import json
from datetime import timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Cli

import adr_opt
from adr_opt.analysis.windows import STATIONS, CaptureConditions, GroundStation, windows_of
from adr_opt.analysis.windows.intervals import common, lasting, positive, shrunk
from adr_opt.common.constants import EARTH_RADIUS_M
from adr_opt.fly.trajectory.bodies import body_states
from adr_opt.legs.service_limits import service_begins
from adr_opt.plan.plan import Plan
from adr_opt.problem.capture_windows import joined
from adr_opt.problem.instance import Instance
from adr_opt.ui.plot.gantt import gantt_chart

NEAR_DEG = 0.05
"""How well the Sun and the stations are known."""


def test_lists_of_intervals_are_sets_of_times() -> None:
    """Joined, common, shrunk and lasting intervals hold the times that they should, in order."""
    rng, times = np.random.default_rng(8), np.linspace(0.0, 100.0, 4001)

    def drawn(count: int) -> np.ndarray:
        return joined([np.sort(rng.uniform(0.0, 100.0, (count, 2)), axis=1)])

    def held(intervals: np.ndarray) -> np.ndarray:
        return ((times[:, None] >= intervals[:, 0]) & (times[:, None] <= intervals[:, 1])).any(1)

    for _ in range(300):
        raw = [np.sort(rng.uniform(0.0, 100.0, (n, 2)), axis=1) for n in rng.integers(0, 6, 2)]
        both = joined(raw)
        assert (held(both) == held(raw[0]) | held(raw[1])).all()
        assert (np.diff(both.ravel()) >= 0.0).all()
        one, other = drawn(int(rng.integers(0, 7))), drawn(int(rng.integers(0, 7)))
        assert (held(common(one, other)) == held(one) & held(other)).all()
        inner = shrunk(one, 2.0)
        assert (held(inner) <= held(one)).all()
        assert inner.shape == lasting(one, 4.0).shape


def test_no_interval_is_missed_for_being_short() -> None:
    """Humps above zero and dips below it between samples are found, with their edges."""
    rng = np.random.default_rng(9)
    for _ in range(300):
        period, phase = rng.uniform(60.0, 400.0), rng.uniform(0.0, 400.0)
        level = np.cos(np.pi * rng.uniform(0.0, 1.0) * 10.0 ** rng.uniform(-3.0, 0.0))
        rate = 2.0 * np.pi / period
        for sign in (1.0, -1.0):

            def wave(t: np.ndarray, of: tuple[float, ...] = (sign, rate, phase, level)) -> Any:
                return of[0] * (np.cos(of[1] * (t - of[2])) - of[3])

            found = positive(wave, 0.0, 2000.0, 20.0)
            half = np.arccos(level) / rate
            middles = phase + period * np.arange(-8, 40)
            humps = np.column_stack([middles - half, middles + half])
            if sign < 0.0:
                humps = np.column_stack([humps[:-1, 1], humps[1:, 0]])
            expected = common(humps, np.array([[0.0, 2000.0]]))
            expected = lasting(expected, 0.5)
            assert lasting(found, 0.5) == pytest.approx(expected, abs=0.01)


@pytest.fixture(scope="module")
def field() -> Instance:
    """Objects of every inclination."""
    instance = adr_opt.generate("nominal", 612, targets=3)
    targets = (
        each.replace(orbit=each.orbit.replace(inclination_deg=inclination, eccentricity=0.01))
        for each, inclination in zip(instance.targets, (98.0, 74.0, 20.0), strict=True)
    )
    mission = instance.mission.replace(duration_s=86400.0)
    return instance.replace(targets=tuple(targets), mission=mission)


def seen_deg(
    instance: Instance, name: str, times: np.ndarray, station: GroundStation | None
) -> np.ndarray:
    """Height of the Sun's lower limb above a spherical Earth, or elevation at a station [deg]."""
    units = pytest.importorskip("astropy.units")
    coordinates = pytest.importorskip("astropy.coordinates")
    clock = pytest.importorskip("astropy.time").Time(
        [instance.epoch + timedelta(seconds=float(t)) for t in times]
    )
    positions = body_states(instance, name, times, true_orbits=True)[0]
    space = coordinates.TEME(
        coordinates.CartesianRepresentation(*positions.T, unit=units.m), obstime=clock
    )
    if station is not None:
        place = coordinates.EarthLocation(
            lat=station.latitude_deg * units.deg,
            lon=station.longitude_deg * units.deg,
            height=station.altitude_m * units.m,
        )
        fixed = space.transform_to(coordinates.ITRS(obstime=clock))
        local = coordinates.AltAz(obstime=clock, location=place)
        topocentric = coordinates.ITRS(
            fixed.cartesian - place.get_itrs(clock).cartesian, obstime=clock, location=place
        )
        return np.asarray(topocentric.transform_to(local).alt.deg)
    there = space.transform_to(coordinates.GCRS(obstime=clock)).cartesian.xyz.to_value(units.m).T
    sun = coordinates.get_sun(clock).cartesian.xyz.to_value(units.m).T - there
    radii, away = np.linalg.norm(there, axis=1), np.linalg.norm(sun, axis=1)
    zenith = np.arccos(np.sum(there * sun, axis=1) / radii / away)
    dip = np.arccos(EARTH_RADIUS_M / radii)
    return np.degrees(np.pi / 2 - zenith + dip - np.arcsin(6.957e8 / away))


@pytest.mark.parametrize("name", [None, "svalbard", "kourou", "weilheim"])
def test_light_and_contacts_are_those_of_another_library(field: Instance, name: str | None) -> None:
    """Wherever the other one sees the Sun or the target by more than a margin, so do windows."""
    station = None if name is None else STATIONS[name]
    asked = (
        CaptureConditions(light=True) if station is None else CaptureConditions(stations=(station,))
    )
    times = np.linspace(0.0, 86400.0, 2881)
    found = windows_of(field, asked)
    for target, intervals in found.items():
        heights = seen_deg(field, target, times, station) - (0.0 if station is None else 5.0)
        held = ((times[:, None] >= intervals[:, 0]) & (times[:, None] <= intervals[:, 1])).any(1)
        sure = np.abs(heights) > NEAR_DEG
        assert (held == (heights > 0.0))[sure].all()
        inner = intervals[(intervals > 0.0) & (intervals < 86400.0)]
        if inner.size:
            edges = seen_deg(field, target, inner, station) - (0.0 if station is None else 5.0)
            assert np.abs(edges).max() < NEAR_DEG


def test_conditions_hold_together(field: Instance) -> None:
    """More conditions leave less time, a contact of either station suffices, and windows bind."""
    narrow = field.replace(
        targets=tuple(each.replace(window_s=(20000.0, 60000.0)) for each in field.targets)
    )
    two = STATIONS["svalbard"], STATIONS["kourou"]
    bright = windows_of(narrow, CaptureConditions(light=True))
    apart = [windows_of(narrow, CaptureConditions(stations=(each,))) for each in two]
    every = windows_of(
        narrow, CaptureConditions(light=True, stations=two, margin_s=10.0, sun_angle_deg=20.0)
    )
    angled = windows_of(narrow, CaptureConditions(sun_angle_deg=20.0))
    for name, intervals in every.items():
        wanted = common(bright[name], joined(each[name] for each in apart))
        wanted = shrunk(common(wanted, angled[name]), 10.0)
        assert intervals == pytest.approx(wanted, abs=0.01)
        assert ((intervals >= 20010.0) & (intervals <= 59990.0)).all()


def test_the_verb_writes_what_it_reads(cli: Cli, field: Instance) -> None:
    """Windows of a file are times that it leaves, and a target that has none is named."""
    Path("a.json").write_text(field.to_json(), encoding="utf-8")
    Path("s.csv").write_text("name,latitude_deg,longitude_deg,altitude_m\nhere,50,8,100\n")
    first = cli("windows", "a.json", "--light", "--out", "w.csv", "--json")
    assert first.status == 0, first
    again = cli("windows", "a.json", "--within", "w.csv", "--json", "--capture", "60")
    before, after = (json.loads(each.out)["targets"] for each in (first, again))
    assert before.keys() == after.keys()
    for name, row in before.items():
        assert after[name] == pytest.approx(row, abs=0.01)
    none = cli("windows", "a.json", "--contact", "here", "--stations", "s.csv", "--capture", "9e4")
    assert none.status == 0
    assert none.err.count("can never be captured") == len(field.targets)


def test_an_instance_with_its_windows_is_planned(cli: Cli, field: Instance) -> None:
    """What the verb writes is an instance whose plans capture in light, and `check` agrees."""
    Path("a.json").write_text(field.to_json(), encoding="utf-8")
    line = "windows a.json --light --capture 60 --out w.csv --into lit.json --quiet"
    assert cli(*line.split()).status == 0
    lit = adr_opt.load("lit.json")
    assert all(target.capture_s == 60.0 for target in lit.targets)
    planned = cli("solve", "lit.json", "--method", "greedy", "--out", "p.json", "--quiet")
    assert planned.status == 0
    assert cli(*["check", "lit.json", "p.json"]).status == 0
    plan = Plan.load("p.json")
    assert plan.legs
    targets = {target.name: target for target in lit.targets}
    for leg in plan.legs:
        if leg.destination in targets:
            begins = service_begins(lit, leg)
            within = lit.intervals_of(targets[leg.destination])
            assert ((within[:, 0] <= begins) & (begins + 60.0 <= within[:, 1] + 1e-5)).any()
    bands = gantt_chart(lit, plan, headed=True).series[0]
    assert bands.name == "may be captured"
    assert set(bands.legs) <= set(range(1, len(plan.legs) + 1))


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("--into ../lit.json", "in the same folder"),
        ("--contact nowhere", "no such station"),
        ("--mask 91", "mask_deg"),
        ("--margin -1", "margin_s"),
        ("--capture inf", "--capture"),
        ("--stations a.json --contact here", "the first line must be"),
        ("--within a.json", "the first line must be"),
        ("--within bad.csv", "line 2"),
        ("--within other.csv", "'other' is not a target"),
    ],
)
def test_bad_conditions_are_refused(cli: Cli, field: Instance, line: str, said: str) -> None:
    """One sentence says what is wrong, and nothing is written."""
    Path("a.json").write_text(field.to_json(), encoding="utf-8")
    Path("bad.csv").write_text("target,opens_s,closes_s\ndebris-001,9,3\n")
    Path("other.csv").write_text("target,opens_s,closes_s\nother,3,9\n")
    outcome = cli("windows", "a.json", "--light", "--out", "w.csv", *line.split())
    assert outcome.status == 2
    assert said in outcome.err
    assert not Path("w.csv").exists()
