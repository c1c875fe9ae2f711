"""The flown plan in formats of other programs, read back by readers that others wrote."""

from __future__ import annotations

import json
import math
import os
import re
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from gmat_script import fly_script

import adr_opt
from adr_opt.export.flights import FORMATS, FRAMES, FlightFile, write_plan
from adr_opt.export.flights.write import ALL_FORMATS
from adr_opt.fly.trajectory import Trajectory, body_states, propagate, sample
from adr_opt.plan.plan import Plan
from adr_opt.problem.instance import Instance
from adr_opt.ui.cli.export import command

ROOT = Path(__file__).parents[2]
EXTERNAL = Path(os.environ.get("ADR_OPT_EXTERNAL_DATA", ROOT / "../shared/data")) / "ccsds"


@pytest.fixture(scope="module")
def tiny() -> Instance:
    return adr_opt.generate("tiny", 0)


@pytest.fixture(scope="module")
def plan(tiny: Instance) -> Plan:
    plan = adr_opt.solve(tiny, "greedy-guarded").plan
    assert plan is not None
    assert len(plan.legs) > 1
    return plan


@pytest.fixture(scope="module")
def flight(tiny: Instance, plan: Plan) -> Trajectory:
    return sample(tiny, plan, 60.0)


def seconds(instance: Instance, label: str) -> float:
    """Time since the epoch of a label in UTC."""
    time = datetime.fromisoformat(label.removesuffix("Z")).replace(tzinfo=UTC)
    return (time - instance.epoch) / timedelta(seconds=1)


def at(flight: Trajectory, phase: int, time_s: float) -> tuple[np.ndarray, np.ndarray]:
    """State on an arc, given by its number, at any time."""
    arc = [arc for _, arc in flight.arcs()][phase]
    r, v = propagate(arc.positions_m[0], arc.velocities_m_s[0], [time_s - arc.start_s])
    return r[0], v[0]


def test_oem_has_the_states_of_the_flight(
    tiny: Instance, plan: Plan, flight: Trajectory, tmp_path: Path
) -> None:
    """Read by ``oem``: one segment for each arc, and every state is the flight's at that time."""
    oem = pytest.importorskip("oem")
    assert write_plan(tiny, plan, tmp_path / "plan.oem").end_s == flight.end_s
    read = oem.OrbitEphemerisMessage.open(tmp_path / "plan.oem")
    arcs = [arc for _, arc in flight.arcs()]
    assert len(read.segments) == len(arcs)
    for number, (segment, arc) in enumerate(zip(read.segments, arcs, strict=True)):
        assert segment.metadata["REF_FRAME"] == "EME2000"
        assert segment.metadata["TIME_SYSTEM"] == "UTC"
        assert segment.metadata["CENTER_NAME"] == "EARTH"
        states = list(segment.states)
        assert len(states) == arc.times_s.size
        for state in states[:: max(1, len(states) // 5)]:
            time = seconds(tiny, state.epoch.isot)
            r, v = at(flight, number, time)
            assert np.linalg.norm(1e3 * state.position - r) < 1e-3
            assert np.linalg.norm(1e3 * state.velocity - v) < 1e-5
    assert read.segments[0].metadata["START_TIME"].isot == "2026-01-01T00:00:00.000000"


def test_oem_arrives_at_the_destination(tiny: Instance, plan: Plan, tmp_path: Path) -> None:
    """At the end of each leg's approach the ephemeris is within 6 cm of the destination."""
    oem = pytest.importorskip("oem")
    write_plan(tiny, plan, tmp_path / "plan.oem")
    text = (tmp_path / "plan.oem").read_text(encoding="ascii")
    phases = re.findall(r"^COMMENT leg (\d+), .*: ([a-z0-9-]+)$", text, re.MULTILINE)
    segments = oem.OrbitEphemerisMessage.open(tmp_path / "plan.oem").segments
    assert len(phases) == len(segments)
    arrived = 0
    for (number, phase), segment in zip(phases, segments, strict=True):
        if phase == "approach":
            leg = plan.legs[int(number) - 1]
            *_, last = segment.states
            time = seconds(tiny, last.epoch.isot)
            goal = body_states(tiny, leg.destination, time)[0][0]
            assert time == pytest.approx(leg.arrival_s, abs=1e-6)
            assert np.linalg.norm(1e3 * last.position - goal) < 0.06
            arrived += 1
    assert arrived == len(plan.legs)


def test_oem_interpolates_as_it_says(tiny: Instance, plan: Plan, tmp_path: Path) -> None:
    """Hermite's polynomial of degree 7 through four states is the flight to a millimetre."""
    interpolate = pytest.importorskip("scipy.interpolate")
    path = write_plan(tiny, plan, tmp_path / "plan.oem", step_s=60.0)
    arc = max((arc for _, arc in path.arcs()), key=lambda arc: arc.times_s.size)
    k = arc.times_s.size // 2
    four = slice(k - 1, k + 3)
    nodes = np.repeat(arc.times_s[four] - arc.times_s[k], 2)
    values = np.empty((8, 3))
    values[0::2], values[1::2] = arc.positions_m[four], arc.velocities_m_s[four]
    middle = 0.5 * (arc.times_s[k + 1] - arc.times_s[k])
    guess = interpolate.KroghInterpolator(nodes, values)(middle)
    true = propagate(arc.positions_m[k], arc.velocities_m_s[k], [middle])[0][0]
    assert np.linalg.norm(guess - true) < 1e-3
    text = (tmp_path / "plan.oem").read_text(encoding="ascii")
    assert text.count("INTERPOLATION = HERMITE\nINTERPOLATION_DEGREE = 7\n") == text.count(
        "META_START"
    )


def test_both_messages_pass_a_second_reader(tiny: Instance, plan: Plan, tmp_path: Path) -> None:
    """``ccsds-ndm``, which is made from the standard's schema, reads the same numbers."""
    ndm_io = pytest.importorskip("ccsds_ndm.ndm_io")
    path = write_plan(tiny, plan, tmp_path / "plan.oem", file=FlightFile(frame="TEME"))
    read = ndm_io.NdmIo().from_path(tmp_path / "plan.oem")
    segments = read.body.segment
    assert len(segments) == sum(1 for _ in path.arcs())
    for segment, (_, arc) in zip(segments, path.arcs(), strict=True):
        assert segment.metadata.ref_frame == "TEME"
        assert len(segment.data.state_vector) == arc.times_s.size
        first = segment.data.state_vector[0]
        assert float(first.x.value) == pytest.approx(arc.positions_m[0][0] / 1e3, abs=1e-5)

    write_plan(tiny, plan, tmp_path / "plan.opm")
    data = ndm_io.NdmIo().from_path(tmp_path / "plan.opm").body.segment.data
    burns = [burn for leg in plan.legs for burn in leg.impulses]
    assert len(data.maneuver_parameters) == len(burns)
    for read_burn, burn in zip(data.maneuver_parameters, burns, strict=True):
        assert read_burn.man_ref_frame == "EME2000"
        assert seconds(tiny, read_burn.man_epoch_ignition) == pytest.approx(burn.time_s, abs=1e-6)
        assert [
            1e3 * float(getattr(read_burn, f"man_dv_{axis}").value) for axis in (1, 2, 3)
        ] == pytest.approx(burn.delta_v_m_s, abs=1e-8)


def flown_opm(path: Path, instance: Instance, until_s: float) -> tuple[np.ndarray, int]:
    """Where the state and the manoeuvres of an OPM lead, by the file alone."""
    ndm_io = pytest.importorskip("ccsds_ndm.ndm_io")
    data = ndm_io.NdmIo().from_path(path).body.segment.data
    start = data.state_vector
    now = seconds(instance, start.epoch)
    r = 1e3 * np.array([float(getattr(start, axis).value) for axis in ("x", "y", "z")])
    v = 1e3 * np.array([float(getattr(start, f"{axis}_dot").value) for axis in ("x", "y", "z")])
    for burn in data.maneuver_parameters:
        time = seconds(instance, burn.man_epoch_ignition)
        r, v = (s[0] for s in propagate(r, v, [time - now]))
        v = v + 1e3 * np.array([float(getattr(burn, f"man_dv_{axis}").value) for axis in (1, 2, 3)])
        now = time
    return propagate(r, v, [until_s - now])[0][0], len(data.maneuver_parameters)


def test_opm_leads_to_the_destination(tiny: Instance, plan: Plan, tmp_path: Path) -> None:
    """Flown by the file alone, each leg ends at its destination within a decimetre."""
    for number, leg in enumerate(plan.legs, start=1):
        write_plan(tiny, plan, tmp_path / "leg.opm", leg=number)
        end, burns = flown_opm(tmp_path / "leg.opm", tiny, leg.arrival_s)
        goal = body_states(tiny, leg.destination, leg.arrival_s)[0][0]
        assert burns == len(leg.impulses)
        assert np.linalg.norm(end - goal) < 0.1


def test_opm_of_a_whole_plan_drifts_by_decimetres(tmp_path: Path) -> None:
    """Over a week of legs, without docking, residuals and rounding add up to less than 5 m."""
    instance = adr_opt.generate("nominal", 0)
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    write_plan(instance, plan, tmp_path / "plan.opm")
    last = plan.legs[-1]
    end, _ = flown_opm(tmp_path / "plan.opm", instance, last.arrival_s)
    goal = body_states(instance, last.destination, last.arrival_s)[0][0]
    assert 1e-3 < np.linalg.norm(end - goal) < 5.0


def test_czml_is_read_and_shows_the_flight(
    tiny: Instance, plan: Plan, flight: Trajectory, tmp_path: Path
) -> None:
    """Read by ``czml3``: all bodies, the chaser, a path for each arc; positions of the flight."""
    czml3 = pytest.importorskip("czml3")
    write_plan(tiny, plan, tmp_path / "plan.czml")
    packets = czml3.Document.load(tmp_path / "plan.czml").packets
    arcs = list(flight.arcs())
    assert len({packet.id for packet in packets}) == len(packets)
    assert len(packets) == 1 + len(tiny.names) + 1 + len(arcs)
    by_id = {packet.id: packet for packet in packets}
    paths = [packet for packet in packets if packet.path is not None]
    assert len(paths) == len(arcs)

    raw = {packet["id"]: packet for packet in json.loads((tmp_path / "plan.czml").read_text())}
    assert by_id["chaser"].position is not None
    assert len(raw["chaser"]["position"]) == len(arcs)
    for piece, (_, arc) in zip(raw["chaser"]["position"], arcs, strict=True):
        assert piece["referenceFrame"] == "INERTIAL"
        start, end = piece["interval"].split("/")
        assert seconds(tiny, start) == pytest.approx(arc.start_s, abs=1e-6)
        assert seconds(tiny, end) == pytest.approx(arc.end_s, abs=1e-6)
        samples = np.array(piece["cartesian"]).reshape(-1, 4)
        assert seconds(tiny, piece["epoch"]) + samples[:, 0] == pytest.approx(arc.times_s, abs=2e-6)
        assert np.abs(samples[:, 1:] - arc.positions_m).max() < 0.01
    for name in tiny.names:
        samples = np.array(raw[f"body/{name}"]["position"]["cartesian"]).reshape(-1, 4)
        true = body_states(tiny, name, samples[:, 0])[0]
        assert np.abs(samples[:, 1:] - true).max() < 0.1


def test_czml_colours_phases_alike(tiny: Instance, plan: Plan, tmp_path: Path) -> None:
    """Arcs of one phase have one colour, arcs of others another; refuelling is not service."""
    path = write_plan(tiny, plan, tmp_path / "plan.czml")
    packets = json.loads((tmp_path / "plan.czml").read_text())
    shown = [packet for packet in packets if "path" in packet]
    colours: dict[str, set] = {}
    for packet, (leg, arc) in zip(shown, path.arcs(), strict=True):
        phase = arc.phase
        if phase == "service" and leg.leg.destination == tiny.stations[0].name:
            phase = "refuelling"
        colour = packet["path"]["material"]["solidColor"]["color"]["rgba"]
        colours.setdefault(phase, set()).add(tuple(colour))
    assert len(colours) >= 6
    assert all(len(found) == 1 for found in colours.values())
    assert len(set.union(*colours.values())) == len(colours)


def test_gmat_script_flies_the_mission(tiny: Instance, plan: Plan, tmp_path: Path) -> None:
    """Every name is created before it is used, and the sequence arrives at each destination."""
    write_plan(tiny, plan, tmp_path / "plan.script")
    text = (tmp_path / "plan.script").read_text(encoding="ascii")
    reports, clock = fly_script(text)
    assert len(reports) == len(plan.legs)
    for chaser, goal in reports:
        assert np.linalg.norm(chaser - goal) < 0.1
    assert clock == pytest.approx(plan.legs[-1].end_s, abs=1e-3)
    assert "GMAT Earth.Mu = 398600.4418;" in text
    assert "GMAT Chaser.Epoch = '01 Jan 2026 00:00:00.000';" in text


def test_gmat_script_of_one_leg_in_another_frame(
    tiny: Instance, plan: Plan, tmp_path: Path
) -> None:
    """A leg alone begins when its chaser is ready, at a whole millisecond; ICRF is made first."""
    instance = tiny.replace(epoch=datetime(2026, 2, 3, 4, 5, 6, 789_123, tzinfo=UTC))
    plan = plan.replace(instance=plan.instance.replace(sha256=instance.sha256))
    write_plan(instance, plan, tmp_path / "leg.script", leg=2, file=FlightFile(frame="ICRF"))
    text = (tmp_path / "leg.script").read_text(encoding="ascii")
    assert text.index("Create CoordinateSystem EarthICRF;") < text.index("Create Spacecraft")
    assert "EarthMJ2000Eq" not in text
    ready = instance.epoch + timedelta(seconds=plan.legs[1].ready_s)
    stated = re.search(r"GMAT Chaser\.Epoch = '(.*)';", text)[1]
    begin = datetime.strptime(stated, "%d %b %Y %H:%M:%S.%f").replace(tzinfo=UTC)
    assert abs(begin - ready) <= timedelta(milliseconds=0.501)
    reports, clock = fly_script(text)
    assert len(reports) == 1
    assert np.linalg.norm(reports[0][0] - reports[0][1]) < 0.1
    span = (begin - ready).total_seconds()
    assert clock + span == pytest.approx(plan.legs[1].end_s - plan.legs[1].ready_s, abs=2e-6)


def test_every_format_says_what_it_was_made_from(
    tiny: Instance, plan: Plan, tmp_path: Path
) -> None:
    """Each file names the instance and its digest; eccentric ones say that they approximate."""
    bent = tiny.replace(
        targets=tuple(
            target.replace(orbit=target.orbit.replace(eccentricity=0.001))
            for target in tiny.targets
        )
    )
    bent_plan = adr_opt.solve(bent, "greedy-guarded").plan
    assert bent_plan is not None
    for format in FORMATS:
        for instance, of in ((tiny, plan), (bent, bent_plan)):
            write_plan(instance, of, tmp_path / "file", file=FlightFile(format))
            said = (tmp_path / "file").read_text(encoding="utf-8")
            said = " ".join(re.sub(r"^(COMMENT|%) ", "", line) for line in said.splitlines()[:20])
            assert f"sha256 {instance.sha256}" in said
            assert ("eccentric" in said) == (instance is bent)


def test_names_of_any_kind_are_written(tiny: Instance, tmp_path: Path) -> None:
    """Names with line breaks, quotes, other scripts or none of GMAT's letters spoil no file."""
    odd = ["Ж", "a'b\nMETA_START", "a-b", "a b", "%", "x" * 300]
    instance = tiny.replace(
        targets=tuple(
            target.replace(name=odd[number] if number < len(odd) else target.name)
            for number, target in enumerate(tiny.targets)
        )
    )
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    assert set(plan.destinations) & set(odd)
    for format in FORMATS:
        write_plan(instance, plan, tmp_path / f"plan.{format}")
    for format in ("oem", "opm", "script"):
        assert (tmp_path / f"plan.{format}").read_bytes().isascii()
    assert len(fly_script((tmp_path / "plan.script").read_text())[0]) == len(plan.legs)
    oem = pytest.importorskip("oem")
    read = oem.OrbitEphemerisMessage.open(tmp_path / "plan.oem")
    assert len(read.segments) == sum(1 for _ in sample(instance, plan).arcs())


def test_times_beyond_the_calendar_are_refused(tiny: Instance, plan: Plan, tmp_path: Path) -> None:
    """What ends after the year 9999 is one sentence, and no file."""
    late = tiny.replace(epoch=datetime(9999, 12, 31, 23, 0, tzinfo=UTC))
    late_plan = plan.replace(instance=plan.instance.replace(sha256=late.sha256))
    for format in ("oem", "opm", "czml"):  # a script counts seconds from its beginning
        with pytest.raises(adr_opt.InputError, match="years 1 to 9999"):
            write_plan(late, late_plan, tmp_path / "plan", file=FlightFile(format))
    assert list(tmp_path.iterdir()) == []


def test_the_command_line_offers_what_there_is() -> None:
    """The choices of ``export`` are the formats and frames of the package."""
    choices = {option.name: getattr(option.type, "choices", None) for option in command.params}
    assert tuple(choices["format_"]) == ALL_FORMATS
    assert tuple(choices["frame"]) == FRAMES


@pytest.mark.external
@pytest.mark.skipif(not EXTERNAL.is_dir(), reason=f"there is no folder {EXTERNAL}")
def test_the_reader_reads_messages_of_others() -> None:
    """The reader that passes our messages is one that reads the standard's examples."""
    ndm_io = pytest.importorskip("ccsds_ndm.ndm_io")
    read = 0
    for path in sorted([*EXTERNAL.glob("OPMExample?.txt"), *EXTERNAL.glob("OEMExample?.txt")]):
        try:
            message = ndm_io.NdmIo().from_path(path)
        except Exception:
            continue
        segments = message.body.segment
        for segment in segments if isinstance(segments, list) else [segments]:
            states = segment.data.state_vector
            for state in states if isinstance(states, list) else [states]:
                assert math.isfinite(float(state.x.value))
        read += 1
    assert read >= 10
