"""Refined legs of low thrust in other programs' formats: their thrust, read back and flown."""

from __future__ import annotations

import json
import math
import re
from datetime import UTC, datetime
from functools import cache
from itertools import chain, pairwise
from pathlib import Path

import numpy as np
import pytest
from conftest import Cli
from electric_fields import electric
from gmat_script import fly_script
from scipy.integrate._ivp import dop853_coefficients as rule

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M, J2, MU_M3_S2
from adr_opt.common.errors import InputError
from adr_opt.export.flights import FlightFile, write_plan
from adr_opt.export.flights.czml_packets import rgba
from adr_opt.export.flights.refined_oem import write_refined
from adr_opt.export.flights.thrust_history import thrust_windows
from adr_opt.fly.refine.bodies import moved, state_of
from adr_opt.fly.trajectory.axes import axes_of
from adr_opt.plan.phases import COLOURS
from adr_opt.plan.plan import Plan
from adr_opt.plan.refined_plan import RefinedLeg, RefinedPlan
from adr_opt.problem.frame import Frame
from adr_opt.problem.instance import Instance

Array = np.ndarray

MISS_M = 5.0
"""Largest distance from a stand-off, of legs of weeks."""


@cache
def mission() -> tuple[Instance, Plan, RefinedPlan]:
    """A drawn mission of low thrust, its plan, and that refined."""
    instance = electric(1, targets=6)
    plan = adr_opt.solve(instance, method="greedy-guarded").plan
    assert plan is not None
    return instance, plan, adr_opt.refine(instance, plan)


def pull(position: Array) -> Array:
    """Acceleration in the field of J2."""
    r = float(np.linalg.norm(position))
    zonal = 1.5 * J2 * (EARTH_RADIUS_M / r) ** 2
    high = 5.0 * (position[2] / r) ** 2
    return -MU_M3_S2 / r**3 * position * (1.0 + zonal * (np.array([1.0, 1.0, 3.0]) - high))


def pushed(state: Array, times: Array, forces: Array, mass_kg: float, flow: float) -> Array:
    """A state after forces that are linear between times, in steps of the order 8 (DOP853)."""
    stages = np.zeros((rule.N_STAGES, 6))
    for at, step in enumerate(np.diff(times)):
        for number in range(rule.N_STAGES):
            share = rule.C[number]
            now = state + step * (rule.A[number, :number] @ stages[:number])
            force = forces[at] + share * (forces[at + 1] - forces[at])
            mass = mass_kg - flow * (times[at] - times[0] + share * step)
            stages[number] = np.r_[now[3:], pull(now[:3]) + force / mass]
        state = state + step * (rule.B @ stages)
    return state


def coast(position: Array, velocity: Array, times: list[float]) -> tuple[Array, Array]:
    """Free motion as the refined plan has it."""
    state = moved(np.concatenate([position, velocity]), times[0], "j2")
    return state[None, :3], state[None, 3:]


def events(leg: RefinedLeg) -> dict[str, Array]:
    """States of a leg by event; burns are left out."""
    return {state.event: state_of(state) for state in leg.states if state.event != "burn"}


class Tank:
    """The engine of a script, with the history of thrust beside it; notes each window's mass."""

    def __init__(self, script: str, history: str) -> None:
        epoch = epoch_of(re.search(r"GMAT Chaser\.Epoch = '(.+)';", script)[1])
        self.segments = []
        for block in history.split("BeginThrust ")[1:]:
            head, rows = block.split("ModelThrustAndMassRate\n")
            named = dict(line.split(" = ") for line in head.splitlines()[1:])
            assert named["Thrust_Vector_Interpolation_Method"] == "Linear"
            assert named["Thrust_Vector_Coordinate_System"] == "EarthMJ2000Eq"
            table = np.array([line.split() for line in rows.splitlines()[:-1]], dtype=float)
            table[:, 0] += (epoch_of(named["Start_Epoch"]) - epoch).total_seconds()
            self.segments.append(table)
        self.mass = self.dry = math.nan
        self.flown: list[tuple[float, float]] = []
        self.departures: list[float] = []

    def fuel(self, fields: dict[str, dict[str, str]], fuel_kg: float) -> None:
        """Fill the tank at the beginning of a leg."""
        self.dry = float(fields["Chaser"]["DryMass"])
        self.mass = self.dry + fuel_kg
        self.departures.append(self.mass)

    def push(self, state: Array, since_s: float, duration_s: float) -> Array:
        """Thrust as the one segment has it that lasts so long."""
        end = since_s + duration_s
        (table,) = (one for one in self.segments if one[0, 0] < since_s and end < one[-1, 0])
        assert since_s - table[0, 0] < 4e-3
        assert table[-1, 0] - end < 4e-3
        inside = table[:, 0][(table[:, 0] > since_s + 1e-5) & (table[:, 0] < end - 1e-5)]
        times = np.r_[since_s, inside, end]
        forces = np.array([np.interp(times, table[:, 0], table[:, axis]) for axis in (1, 2, 3)]).T
        flow = table[0, 4]
        state = pushed(state, times, forces, self.mass, flow)
        before, self.mass = self.mass, self.mass - flow * duration_s
        self.flown.append((before, self.mass))
        return state

    def impulse(self, size_m_s: float, exhaust_m_s: float) -> None:
        """Take the propellant of an impulse."""
        self.mass *= math.exp(-size_m_s / exhaust_m_s)


def epoch_of(label: str) -> datetime:
    return datetime.strptime(label, "%d %b %Y %H:%M:%S.%f").replace(tzinfo=UTC)


@pytest.mark.slow
def test_forces_between_points_lead_to_the_stand_off() -> None:
    """Piecewise linear forces arrive within metres of each stand-off; ΔV and masses are equal."""
    _, _, refined = mission()
    for leg in refined.legs:
        state, now = events(leg)["departure"], leg.states[0].time_s
        windows = thrust_windows(leg, refined.gravity)
        for one in windows:
            state = moved(state, one.start_s - now, refined.gravity)
            state = pushed(state, one.times_s, one.forces_n, one.before_kg, one.flow_kg_s)
            now = one.end_s
            assert np.diff(one.times_s)[:-1] == pytest.approx(30.0)
            sizes = np.linalg.norm(one.forces_n, axis=1)
            assert sizes == pytest.approx(leg.thrust.force_n, rel=1e-3)
        state = moved(state, leg.standoff_s - now, refined.gravity)
        miss = np.linalg.norm(state[:3] - events(leg)["stand-off"][:3])
        assert miss < MISS_M
        assert np.linalg.norm(state[3:] - events(leg)["stand-off"][3:]) < 1e-2
        spent = leg.thrust.exhaust_m_s * math.log(leg.thrust.mass_kg / windows[-1].after_kg)
        assert spent == pytest.approx(leg.thrust.delta_v_m_s, abs=1e-6)


@pytest.mark.slow
def test_a_script_with_its_history_flies_the_mission(tmp_path: Path) -> None:
    """Flown by both files alone, legs arrive within metres, as heavy as the plan has them."""
    instance, _, refined = mission()
    write_refined(instance, refined, tmp_path / "tug.script", file=FlightFile("script"))
    script = (tmp_path / "tug.script").read_text(encoding="ascii")
    history = (tmp_path / "tug.thrust").read_text(encoding="ascii")
    assert "GMAT Thrust.FileName = 'tug.thrust';" in script
    names = re.findall(r"BeginThrust \{(\w+)\}", history)
    assert re.search(r"AddThrustSegment = \{(.+)\};", script)[1].split(", ") == names
    assert len(set(names)) == sum(len(thrust_windows(leg, "j2")) for leg in refined.legs)
    tank = Tank(script, history)
    reports, clock = fly_script(script, coast, engine=tank)
    assert len(reports) == len(refined.legs) > 1
    for chaser, goal in reports:
        assert np.linalg.norm(chaser - goal) < MISS_M
    assert clock == pytest.approx(refined.legs[-1].done_s - refined.legs[0].ready_s, abs=2e-3)
    assert tank.departures == pytest.approx([leg.thrust.mass_kg for leg in refined.legs])
    last = refined.legs[-1].thrust
    assert tank.mass == pytest.approx(last.mass_kg - last.propellant_kg, abs=1e-6)
    spent = math.fsum(last.exhaust_m_s * math.log(one / after) for one, after in tank.flown)
    planned = math.fsum(leg.thrust.delta_v_m_s for leg in refined.legs)
    assert spent == pytest.approx(planned, abs=1e-5)


def blocks(text: str, name: str) -> list[tuple[dict[str, str], list[list[str]]]]:
    """Keywords and rows of each section of an OCM."""
    found = []
    for body in re.findall(rf"^{name}_START\n(.*?)^{name}_STOP$", text, re.DOTALL | re.MULTILINE):
        lines = [line for line in body.splitlines() if not line.startswith("COMMENT")]
        fields = dict(line.split(" = ") for line in lines if " = " in line)
        found.append((fields, [line.split() for line in lines if " = " not in line]))
    return found


@pytest.mark.slow
def test_an_ocm_leads_to_every_stand_off(tmp_path: Path) -> None:
    """Flown by the message alone, thrust and impulses of each leg end at its target."""
    instance, _, refined = mission()
    write_refined(
        instance, refined, tmp_path / "a.ocm", file=FlightFile("ocm", object_id="2031-007A")
    )
    text = (tmp_path / "a.ocm").read_text(encoding="ascii")
    ((about, _),) = blocks(text, "META")
    assert about["INTERNATIONAL_DESIGNATOR"] == "2031-007A"

    def since(label: str) -> float:
        time = datetime.fromisoformat(label).replace(tzinfo=UTC)
        return (time - instance.epoch).total_seconds()

    ((trajectory, states),) = blocks(text, "TRAJ")
    assert trajectory["TRAJ_TYPE"] == "CARTPV"
    assert len(states) == len(refined.legs)
    ((physics, _),) = blocks(text, "PHYS")
    mass = float(physics["WET_MASS"].split()[0])
    assert mass == pytest.approx(refined.legs[0].thrust.mass_kg, abs=1e-6)
    tables = blocks(text, "MAN")
    for leg, row in zip(refined.legs, states, strict=True):
        now, state = since(row[0]), 1e3 * np.array(row[1:], dtype=float)
        mass = first = leg.thrust.mass_kg
        own = [one for one in tables if one[0]["MAN_ID"].startswith(f"LEG-{leg.leg}-")]
        for fields, rows in own[:-1]:
            names = fields["MAN_COMPOSITION"].split(", ")
            table = {name: [line[at] for line in rows] for at, name in enumerate(names)}
            ends = [at + 1 for at, on in enumerate(table["THR_INTERP"]) if on == "OFF"]
            times = np.array([since(label) for label in table["TIME_ABSOLUTE"]])
            forces = np.array([table[f"THR_{axis}"] for axis in "XYZ"], dtype=float).T
            lost = np.array(table["DELTA_MASS"], dtype=float)
            for begin, end in zip([0, *ends], ends, strict=False):
                part = slice(begin, end)
                state = moved(state, times[begin] - now, "j2")
                flow = -lost[part].sum() / (times[end - 1] - times[begin])
                state = pushed(state, times[part], forces[part], mass, flow)
                mass, now = mass + lost[part].sum(), times[end - 1]
            spent = np.array(table["THR_ISP"], dtype=float)[0] * 9.80665 * math.log(first / mass)
            assert len(own) > 2 or spent == pytest.approx(leg.thrust.delta_v_m_s, abs=1e-5)
        impulses = own[-1][1]
        assert len(impulses) == len(leg.impulses)
        for label, _, lost_kg, *parts in impulses:
            state = moved(state, since(label) - now, "j2")
            state[3:] += 1e3 * np.array(parts, dtype=float)
            mass, now = mass + float(lost_kg), since(label)
        state = moved(state, leg.arrival_s - now, "j2")
        assert np.linalg.norm(state[:3] - events(leg)["arrival"][:3]) < MISS_M
        assert mass == pytest.approx(leg.thrust.mass_kg - leg.thrust.propellant_kg, abs=1e-6)


def spans(said: str) -> tuple[datetime, datetime]:
    """Both ends of an interval."""
    start, end = (datetime.fromisoformat(label.removesuffix("Z")) for label in said.split("/"))
    return start, end


@pytest.mark.slow
def test_czml_has_the_path_and_the_windows(tmp_path: Path) -> None:
    """Samples are the states of the plan; halos and colours are of the windows of thrust."""
    instance, _, refined = mission()
    tracks = write_refined(instance, refined, tmp_path / "a.czml", file=FlightFile("czml"))
    packets = json.loads((tmp_path / "a.czml").read_text(encoding="utf-8"))
    named = {packet["id"]: packet for packet in packets}
    assert len(named) == len(packets)
    assert {f"body/{body.name}" for body in refined.bodies} <= set(named)
    chaser = named["chaser"]
    assert len(chaser["position"]) == len(tracks)
    for part, track in zip(chaser["position"], tracks, strict=True):
        samples = np.array(part["cartesian"]).reshape(-1, 4)
        assert np.abs(samples[:, 1:] - track.arc.positions_m).max() < 1e-3
        assert samples[:, 0] == pytest.approx(track.arc.times_s - track.arc.start_s, abs=1e-6)
    colours = chaser["point"]["color"]
    for one, after in pairwise(colours):
        assert spans(one["interval"])[1] <= spans(after["interval"])[0]
    on = [part["interval"] for part in colours if part["rgba"] == rgba(COLOURS["thrust"])["rgba"]]
    halos = [named[f"leg {leg.leg}/thrust"]["availability"] for leg in refined.legs]
    assert on == list(chain.from_iterable(halos))
    for leg, when in zip(refined.legs, halos, strict=True):
        lasts = math.fsum((end - start).total_seconds() for start, end in map(spans, when))
        assert lasts == pytest.approx(math.fsum(arc.on_s for arc in leg.thrust.arcs), abs=1e-3)
    write_refined(instance, refined, tmp_path / "b.czml", file=FlightFile("czml"), leg=2)
    shown = {packet["id"] for packet in json.loads((tmp_path / "b.czml").read_text("utf-8"))}
    ends = {refined.legs[1].origin, refined.legs[1].destination}
    assert {name for name in shown if name.startswith("body/")} == {f"body/{name}" for name in ends}


@pytest.mark.slow
def test_what_cannot_be_written_is_refused(cli: Cli, tmp_path: Path) -> None:
    """Burns of one direction, plans that are not refined and bad names end with status 2."""
    instance, _, refined = mission()
    instance.save("i.json")
    refined.save("r.json")
    refined.save("r.thrust")
    impulsive = adr_opt.generate("tiny", 0)
    impulsive.save("tiny.json")
    adr_opt.solve(impulsive, "greedy-guarded").plan.save("p.json")
    for mission_path, plan_path, out, said in (
        ("i.json", "r.json", "a.opm", "has a fixed direction"),
        ("tiny.json", "p.json", "a.ocm", "is for refined plans"),
        ("i.json", "r.thrust", "r.script", "this is the input"),
        ("i.json", "r.json", "it's.script", "without quotation marks"),
    ):
        done = cli("export", mission_path, plan_path, "--out", out)
        assert done.status == 2
        assert done.err.count("\n") == 1
        assert said in done.err
        assert not Path(out).exists()
    Path("b.thrust").mkdir()
    assert cli("export", "i.json", "r.json", "--out", "b.script").status == 2
    assert not Path("b.script").exists()
    with pytest.raises(InputError, match="refine the plan"):
        write_plan(impulsive, Plan.load("p.json"), tmp_path / "a.ocm")


def test_impulses_are_written_as_an_ocm(tmp_path: Path) -> None:
    """A refined plan of impulses has tables of impulses alone, and masses only if it knows them."""
    instance = adr_opt.generate("tiny", 0)
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    refined = adr_opt.refine(instance, plan)
    write_refined(instance, refined, tmp_path / "a.ocm", file=FlightFile("ocm"))
    text = (tmp_path / "a.ocm").read_text(encoding="ascii")
    assert not blocks(text, "PHYS")
    tables = blocks(text, "MAN")
    assert [len(rows) for _, rows in tables] == [len(leg.impulses) for leg in refined.legs]
    sizes = [
        math.hypot(*(1e3 * float(part) for part in row[2:])) for _, rows in tables for row in rows
    ]
    assert math.fsum(sizes) == pytest.approx(refined.flown_delta_v_m_s, abs=1e-6)


SECTIONS = {"META": "metadata", "TRAJ": "traj", "PHYS": "phys", "MAN": "man", "PERT": "pert"}


def as_xml(text: str) -> str:
    """An OCM in the notation that ``ccsds-ndm`` reads, keyword by keyword."""
    told = {"metadata": "", "data": ""}
    for name, body in re.findall(r"^(\w+)_START\n(.*?)^\1_STOP$", text, re.DOTALL | re.MULTILINE):
        inside = ""
        for line in body.splitlines():
            comment = re.fullmatch(r"COMMENT (.*)", line)
            field = re.fullmatch(r"(\w+) = (.*?)(?: \[(\S+)\])?", line)
            if comment:
                inside += f"<COMMENT>{comment[1]}</COMMENT>"
            elif field and field[3] and name != "MAN":
                inside += f'<{field[1]} units="{field[3]}">{field[2]}</{field[1]}>'
            elif field:
                value = line.partition(" = ")[2]
                inside += f"<{field[1]}>{value}</{field[1]}>"
            else:
                inside += f"<{name.lower()}Line>{line}</{name.lower()}Line>"
        part, tag = ("metadata", "") if name == "META" else ("data", SECTIONS[name])
        told[part] += f"<{tag}>{inside}</{tag}>" if tag else inside
    created = re.search("CREATION_DATE = (.*)", text)[1]
    return (
        '<?xml version="1.0" encoding="UTF-8"?><ocm id="CCSDS_OCM_VERS" version="3.0">'
        f"<header><CREATION_DATE>{created}</CREATION_DATE><ORIGINATOR>ADR-OPT</ORIGINATOR></header>"
        f"<body><segment><metadata>{told['metadata']}</metadata><data>{told['data']}</data>"
        "</segment></body></ocm>"
    )


def test_an_ocm_keeps_to_the_schema(tmp_path: Path) -> None:
    """Keywords, values and units are those of the schema, by which another reader finds them."""
    ndm_io = pytest.importorskip("ccsds_ndm.ndm_io")
    instance, _, refined = mission()
    write_refined(instance, refined, tmp_path / "a.ocm", file=FlightFile("ocm"), leg=1)
    text = (tmp_path / "a.ocm").read_text(encoding="ascii")
    read = ndm_io.NdmIo().from_string(as_xml(text)).body.segment.data
    assert len(read.traj[0].traj_line) == 1
    assert float(read.phys.wet_mass.value) == pytest.approx(refined.legs[0].thrust.mass_kg)
    rows = [row for _, rows in blocks(text, "MAN") for row in rows]
    assert [line.split() for man in read.man for line in man.man_line] == rows
    assert {man.man_ref_frame for man in read.man} == {"EME2000"}


@pytest.mark.parametrize("has_thrust", [True, False])
def test_units_of_an_ocm_are_of_all_that_follows_the_time(has_thrust: bool, tmp_path: Path) -> None:
    """A table of manoeuvres has a unit for each column but the time tag, or readers refuse it."""
    instance = adr_opt.generate("tiny", 0)
    if has_thrust:
        instance, _, refined = mission()
    else:
        refined = adr_opt.refine(instance, adr_opt.solve(instance, "greedy-guarded").plan)
    write_refined(instance, refined, tmp_path / "a.ocm", file=FlightFile("ocm"), leg=1)
    tables = blocks((tmp_path / "a.ocm").read_text(encoding="ascii"), "MAN")
    assert {"THRUST" in fields["MAN_ID"] for fields, _ in tables} == {has_thrust, False}
    for fields, rows in tables:
        columns = fields["MAN_COMPOSITION"].split(", ")
        assert columns[0] == "TIME_ABSOLUTE"
        assert len(fields["MAN_UNITS"].strip("[]").split(", ")) == len(columns) - 1
        assert {len(row) for row in rows} == {len(columns)}


@pytest.mark.slow
def test_thrust_is_turned_with_the_states(tmp_path: Path) -> None:
    """In GCRF forces are those in TEME, turned; the history of a script is in its own axes."""
    pytest.importorskip("astropy")
    instance, _, refined = mission()
    instance = instance.replace(frame=Frame(name="TEME", axes_epoch=instance.epoch))
    refined = refined.replace(instance=refined.instance.replace(sha256=instance.sha256))
    found = {}
    for frame in ("TEME", "GCRF"):
        file = FlightFile("ocm", frame)
        write_refined(instance, refined, tmp_path / "a.ocm", file=file, leg=1)
        fields, rows = blocks((tmp_path / "a.ocm").read_text(encoding="ascii"), "MAN")[0]
        assert fields["MAN_REF_FRAME"] == frame
        assert ("MAN_FRAME_EPOCH" in fields) == (frame == "TEME")
        found[frame] = np.array([row[3:6] for row in rows], dtype=float)
    matrix = axes_of(instance, "GCRF").matrix
    assert np.abs(found["GCRF"] - found["TEME"] @ matrix.T).max() < 1e-12
    assert np.abs(found["GCRF"] - found["TEME"]).max() > 1e-5
    write_refined(
        instance, refined, tmp_path / "a.script", file=FlightFile("script", "GCRF"), leg=1
    )
    history = (tmp_path / "a.thrust").read_text(encoding="ascii")
    assert "Thrust_Vector_Coordinate_System = EarthICRF" in history
    force = np.array(history.split("ModelThrustAndMassRate\n")[1].splitlines()[1].split()[1:4])
    assert force.astype(float) == pytest.approx(found["GCRF"][0], abs=1e-12)
