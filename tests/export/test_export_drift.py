"""The flown plan in formats of other programs, where nodes drift."""

from __future__ import annotations

import json
import re
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path

import numpy as np
import osculating
import pytest
from drifting_plans import DAY_S, drifting_instance, drifting_plan
from gmat_script import fly_script
from scipy.interpolate import CubicHermiteSpline, KroghInterpolator

from adr_opt.export.flights import FORMATS, czml, write_plan
from adr_opt.fly.trajectory import body_states, sample
from adr_opt.fly.trajectory.kepler import drift
from adr_opt.kernels.orbits import columns, ephemeris


def written(tmp_path: Path, format: str, eccentricity: float = 0.0, **options: object) -> str:
    path = tmp_path / f"plan.{format}"
    write_plan(drifting_instance(eccentricity), drifting_plan(eccentricity), path, **options)
    return path.read_text(encoding="utf-8")


def seconds(label: str) -> float:
    """Time since the epoch of a label in UTC."""
    time = datetime.fromisoformat(label.removesuffix("Z")).replace(tzinfo=UTC)
    return (time - drifting_instance().epoch) / timedelta(seconds=1)


def segments(text: str) -> list[tuple[str, np.ndarray]]:
    """Phase, and times and states in metres, of each segment of an OEM."""
    found = []
    for part in text.split("META_STOP")[1:]:
        lines = part.split("META_START")[0].strip().splitlines()
        rows = [line.split() for line in lines if line[:2] == "20"]
        states = [[seconds(row[0]), *(1e3 * float(value) for value in row[1:])] for row in rows]
        comments = " ".join(line.removeprefix("COMMENT ") for line in lines if line[0] == "C")
        found.append((comments.rpartition(": ")[2], np.array(states)))
    return found


@pytest.mark.parametrize("eccentricity", [0.0, 0.003])
@pytest.mark.parametrize("format", FORMATS)
def test_every_format_says_what_its_states_are(
    tmp_path: Path, format: str, eccentricity: float
) -> None:
    """Mean motion under J2 and nothing of two bodies; eccentric orbits were not flown truly."""
    text = written(tmp_path, format, eccentricity)
    said = " ".join(re.sub(r"^(COMMENT|%) ", "", line) for line in text.splitlines()[:30])
    assert "Mean motion under J2 = 1.08262668e-03" in said
    assert "not osculating states" in said
    assert "wo-body motion" not in said
    assert ("an amount that has not been computed" in said) == (eccentricity > 0.0)


def test_oem_leads_through_weeks(tmp_path: Path) -> None:
    """Hermite's interpolation of degree 7, as stated, is the flight to centimetres on every arc.

    With velocities within the plane instead of rates it would be tens of metres off.
    """
    text = written(tmp_path, "oem")
    assert "INTERPOLATION_DEGREE = 7" in text
    flight = [arc for _, arc in sample(drifting_instance(), drifting_plan()).arcs()]
    fine = sample(drifting_instance(), drifting_plan(), 20.0).arcs()
    read = segments(text)
    assert [phase for phase, _ in read] == [arc.phase for arc in flight]
    for (_, states), arc, (_, dense) in zip(read, flight, fine, strict=True):
        assert states.shape[0] == arc.times_s.size
        middle = arc.times_s.size // 2
        window = slice(middle - 2, middle + 2)
        begin = states[window, 0][0]
        inner = (dense.times_s > states[window, 0][1]) & (dense.times_s < states[window, 0][2])
        way = KroghInterpolator(
            np.repeat(states[window, 0] - begin, 2), states[window, 1:].reshape(-1, 3)
        )
        off = way(dense.times_s[inner] - begin) - dense.positions_m[inner]
        assert np.linalg.norm(off, axis=1).max() < 0.05
    drifting = next(arc for arc in flight if arc.phase == "drift")
    dense = next(
        arc
        for _, arc in sample(drifting_instance(), drifting_plan(), 60.0).arcs()
        if arc.phase == "drift"
    )
    wrong = CubicHermiteSpline(drifting.times_s, drifting.positions_m, drifting.velocities_m_s)
    assert np.linalg.norm(wrong(dense.times_s) - dense.positions_m, axis=1).max() > 10.0


def test_oem_is_read_by_others(tmp_path: Path) -> None:
    """``oem`` reads the segments, one for each arc, and every state of them."""
    oem = pytest.importorskip("oem")
    written(tmp_path, "oem", step_s=1800.0)
    read = oem.OrbitEphemerisMessage.open(tmp_path / "plan.oem")
    arcs = [arc for _, arc in sample(drifting_instance(), drifting_plan(), 1800.0).arcs()]
    assert [len(list(segment.states)) for segment in read.segments] == [
        arc.times_s.size for arc in arcs
    ]


def test_opm_of_the_drift_leads_to_the_target(tmp_path: Path) -> None:
    """Flown in the mean dynamics by the file alone, the drift ends at its target; it says so."""
    instance, leg = drifting_instance(), drifting_plan().legs[1]
    text = written(tmp_path, "opm", leg=2)
    assert "a mean state" in text
    values = dict(re.findall(r"^(\w+) = ([-\d.]+) \[km", text, re.MULTILINE))
    state = [1e3 * float(values[axis]) for axis in ("X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT")]
    r, v = np.array(state[:3]), np.array(state[3:])
    now = seconds(re.search(r"^EPOCH = (.*)$", text, re.MULTILINE)[1])
    burns = re.findall(
        r"IGNITION = (\S+)\n(?:.*\n){3}" + r"MAN_DV_\d = (\S+) \[km/s\]\n" * 3, text + "\n"
    )
    assert len(burns) == len(leg.impulses)
    for label, *vector in burns:
        r, v = (s[0] for s in drift(r, v, [seconds(label) - now], instance.oblateness_m2))
        v = v + 1e3 * np.array([float(part) for part in vector])
        now = seconds(label)
    goal = body_states(instance, leg.destination, now)[0][0]
    assert np.linalg.norm(r - goal) < 1.0


def test_czml_draws_a_long_arc_a_revolution_at_a_time(tmp_path: Path) -> None:
    """The drift borrows its states from the chaser and trails half a lap; short arcs are whole."""
    czml3 = pytest.importorskip("czml3")
    text = written(tmp_path, "czml")
    packets = {packet["id"]: packet for packet in json.loads(text)}
    arcs = list(sample(drifting_instance(), drifting_plan()).arcs())
    assert len(packets["chaser"]["position"]) == len(arcs)
    for piece, (_, arc) in zip(packets["chaser"]["position"], arcs, strict=True):
        assert len(piece["cartesian"]) == 4 * arc.times_s.size
    long = {arc.phase for _, arc in arcs if arc.end_s - arc.start_s > DAY_S}
    assert long == {"drift", "wait"}
    shown = [packet for packet in packets.values() if "path" in packet]
    for packet, (_, arc) in zip(shown, arcs, strict=True):
        if arc.end_s - arc.start_s > DAY_S:
            assert packet["position"] == {"reference": "chaser#position"}
            assert 2.0 * packet["path"]["trailTime"] == pytest.approx(6100.0, abs=100.0)
            start, end = packet["availability"].split("/")
            assert seconds(start) == pytest.approx(arc.start_s, abs=1e-6)
            assert seconds(end) == pytest.approx(arc.end_s, abs=1e-6)
        else:
            assert len(packet["position"]["cartesian"]) == 4 * arc.times_s.size
    assert len(czml3.Document.load(tmp_path / "plan.czml").packets) == len(packets)


def test_czml_shows_bodies_when_they_matter(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where all bodies all the time would be too much, each is there during its legs.

    The file says so, and states are those of the drifting bodies.
    """
    instance, plan = drifting_instance(), drifting_plan()
    whole = json.loads(written(tmp_path, "czml"))
    assert {packet["id"] for packet in whole} >= {f"body/{name}" for name in instance.names}
    assert "too much" not in whole[0]["description"]
    monkeypatch.setattr(czml, "MOST_BODY_STATES", 30_000)
    packets = {packet["id"]: packet for packet in json.loads(written(tmp_path, "czml"))}
    assert "body/away" not in packets
    assert "Of 4 bodies the 3 that legs begin or end at" in packets["document"]["description"]
    first, second = plan.legs
    expected = {
        "chaser": (first.ready_s, first.end_s),
        "near": (first.ready_s, second.end_s),
        "far": (second.ready_s, second.end_s),
    }
    for name, (start, end) in expected.items():
        packet = packets[f"body/{name}"]
        shown = [seconds(label) for label in packet["availability"].split("/")]
        assert shown == pytest.approx([start, end], abs=1e-6)
        samples = np.array(packet["position"]["cartesian"]).reshape(-1, 4)
        times = samples[:, 0] + seconds(packet["position"]["epoch"])
        true = body_states(instance, name, times)[0]
        assert np.abs(samples[:, 1:] - true).max() < 0.1


def test_a_body_that_is_met_twice_is_shown_twice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Between legs that have nothing to do with it a body is not there."""
    monkeypatch.setattr(czml, "MOST_BODY_STATES", 10)
    flown = sample(drifting_instance(), drifting_plan())
    there, back = flown.legs
    away = there.leg.replace(origin="away", destination="far")
    later = type(back)(3, back.leg.replace(origin="far", destination="near"), back.arcs)
    odd = type(flown)(
        flown.instance,
        flown.plan,
        flown.step_s,
        (there, type(there)(2, away, back.arcs[:2]), type(later)(3, later.leg, back.arcs[3:])),
    )
    packets = {packet["id"]: packet for packet in json.loads(czml.to_czml(odd))}
    near = packets["body/near"]
    assert len(near["availability"]) == len(near["position"]) == 2
    assert [part["interval"] for part in near["position"]] == near["availability"]


def test_gmat_flies_in_the_field_of_j2_from_mean_orbits(tmp_path: Path) -> None:
    """The script has zonal gravity and the bodies' mean circles, and warns of what is missing."""
    instance, text = drifting_instance(), written(tmp_path, "script")
    for line in (
        "GMAT Zonal.GravityField.Earth.Degree = 2;",
        "GMAT Zonal.GravityField.Earth.Order = 0;",
        "GMAT Zonal.PointMasses = {};",
        "GMAT Fly.FM = Zonal;",
        "GMAT T1_near.DisplayStateType = BrouwerMeanShort;",
    ):
        assert line in text
    assert "TwoBody" not in text
    said = " ".join(line.removeprefix("% ") for line in text.splitlines() if line[:1] == "%")
    assert "docks it all the same" in said
    given = dict(re.findall(r"GMAT T2_far\.BrouwerShort(\w+) = ([\d.]+);", text))
    row = instance.orbits()[instance.names.index("far")]
    assert float(given["SMA"]) == pytest.approx(row[columns.RADIUS] / 1e3)
    assert float(given["INC"]) == pytest.approx(np.degrees(row[columns.INCLINATION]))
    assert float(given["RAAN"]) == pytest.approx(np.degrees(row[columns.RAAN]))
    late = written(tmp_path, "script", leg=2)
    begin = drifting_plan().legs[1].ready_s
    given = dict(re.findall(r"GMAT T2_far\.BrouwerShort(\w+) = ([\d.]+);", late))
    drifted = np.degrees(row[columns.RAAN] + row[columns.RAAN_RATE] * begin) % 360.0
    assert float(given["RAAN"]) == pytest.approx(drifted, abs=1e-6)


@pytest.mark.parametrize("leg", [None, 2])
def test_gmat_script_flies_the_mission_in_the_mean_dynamics(
    tmp_path: Path, leg: int | None
) -> None:
    """With coasts in the mean dynamics, which GMAT has not, the sequence arrives within metres.

    The beginning of a leg is at a whole millisecond, and its duration is that of the plan.
    """
    instance, plan = drifting_instance(), drifting_plan()
    coast = partial(drift, oblateness_m2=instance.oblateness_m2)
    reports, clock = fly_script(written(tmp_path, "script", leg=leg), coast)
    legs = plan.legs if leg is None else plan.legs[leg - 1 : leg]
    assert len(reports) == len(legs)
    for chaser, goal in reports:
        assert np.linalg.norm(chaser - goal) < 5.0
    assert clock == pytest.approx(legs[-1].end_s - legs[0].ready_s, abs=2e-3)


def test_mean_states_are_averages_of_numerical_flight() -> None:
    """From its osculating state a body stays within kilometres of its mean state for a day.

    Averaged over a revolution less than five kilometres along its way are lost: second order in J2.
    """
    row = drifting_instance().orbits()[1].copy()
    for latitude in (0.2, 0.9, 1.8, 3.0):
        row[columns.ARGUMENT_OF_LATITUDE] = latitude
        state = osculating.from_mean_circle(*row[:4])
        along = []
        for after in np.linspace(DAY_S, DAY_S + 5088.0, 6):
            goal, velocity = ephemeris.state_at(row, after)
            found = osculating.coast(state[:3], state[3:], [after])[0][0]
            along.append((found - goal) @ velocity / np.linalg.norm(velocity))
            assert np.linalg.norm(found - goal) < 15e3
        assert abs(np.mean(along)) < 5e3
        assert np.ptp(along) < 3e3


@pytest.mark.parametrize(
    ("leg", "missed_km"), [(1, 0.2), pytest.param(2, 223.0, marks=pytest.mark.slow)]
)
def test_gmat_would_miss_by_as_much_as_the_page_says(
    tmp_path: Path, leg: int, missed_km: float
) -> None:
    """Flown numerically in the field of J2, a script misses as docs/exports.md says.

    From osculating states of first order, which stand in for GMAT's.
    """
    text = written(tmp_path, "script", leg=leg)
    ((chaser, goal),), _ = fly_script(text, osculating.coast, osculating.from_mean_circle)
    assert np.linalg.norm(chaser - goal) / 1e3 == pytest.approx(missed_km, rel=0.2)
    page = (Path(__file__).parents[2] / "docs/exports.md").read_text(encoding="utf-8")
    assert f"{missed_km:g} km" in page
