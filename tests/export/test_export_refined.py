"""Refined plans as messages of burns and as scripts; masses and designators in messages."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from datetime import UTC, datetime
from functools import cache
from itertools import pairwise
from pathlib import Path

import launched
import numpy as np
import pytest
import towed_fields
from conftest import Cli
from gmat_script import fly_script
from plans import moved_to

import adr_opt
from adr_opt.export.flights import FlightFile, write_plan
from adr_opt.export.flights.refined_oem import write_refined
from adr_opt.fly.refine.bodies import moved, state_of
from adr_opt.fly.trajectory.axes import axes_of
from adr_opt.plan.plan import Plan
from adr_opt.plan.refined_plan import RefinedPlan
from adr_opt.problem.bodies import Station, Target
from adr_opt.problem.chasers import TankByMass
from adr_opt.problem.frame import Frame
from adr_opt.problem.instance import Instance

pytest.importorskip("astropy")

Array = np.ndarray
EPOCH = datetime(2025, 2, 27, 6, 30, 15, 250_000, tzinfo=UTC)
TANK = TankByMass(dry_mass_kg=400.0, propellant_kg=900.0, isp_s=310.0)


@cache
def mission(gravity: str = "j2") -> tuple[Instance, Plan, RefinedPlan]:
    """A tiny field in TEME, its plan, and that refined."""
    instance = adr_opt.generate("tiny", 0, targets=6)
    instance = instance.replace(
        epoch=EPOCH,
        frame=Frame(name="TEME", axes_epoch=EPOCH),
        dynamics="two-body" if gravity == "two-body" else "j2",
        chasers=(instance.chaser.replace(tank=TANK),),
    )
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    assert len(plan.legs) > 2
    return instance, plan, adr_opt.refine(instance, plan, gravity=gravity)


@cache
def towing() -> tuple[Instance, Plan, RefinedPlan]:
    """The same of a field with tows."""
    instance = towed_fields.field("j2", 2)
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    return instance, plan, adr_opt.refine(instance, plan)


def coasting(one: RefinedPlan, matrix: Array | None) -> Callable[..., tuple[Array, Array]]:
    """Free motion in the field of a refined plan, of states that were turned by a matrix."""
    turn = np.kron(np.eye(2), np.eye(3) if matrix is None else matrix)

    def coast(position: Array, velocity: Array, times: list[float]) -> tuple[Array, Array]:
        state = moved(turn.T @ np.concatenate([position, velocity]), times[0], one.gravity)
        return (turn @ state)[None, :3], (turn @ state)[None, 3:]

    return coast


def seconds(instance: Instance, label: str) -> float:
    return (datetime.fromisoformat(label).replace(tzinfo=UTC) - instance.epoch).total_seconds()


def message(path: Path):
    """What ``ccsds-ndm`` reads of an OPM."""
    ndm_io = pytest.importorskip("ccsds_ndm.ndm_io")
    return ndm_io.NdmIo().from_path(path).body.segment


@pytest.mark.parametrize("frame", ["TEME", None])
@pytest.mark.parametrize("gravity", ["two-body", "j2", "j4"])
def test_opm_of_a_refined_plan_leads_to_every_target(
    gravity: str, frame: str | None, tmp_path: Path
) -> None:
    """Flown by the file alone in its field, each leg ends at its target within a decimetre."""
    instance, _, one = mission(gravity)
    axes = axes_of(instance, frame)
    coast = coasting(one, axes.matrix)
    for leg in one.legs:
        write_refined(instance, one, tmp_path / "a.opm", file=FlightFile("opm", frame), leg=leg.leg)
        read = message(tmp_path / "a.opm")
        assert read.metadata.ref_frame == (frame or "GCRF")
        start = read.data.state_vector
        now = seconds(instance, start.epoch)
        state = 1e3 * np.array(
            [
                float(getattr(start, name).value)
                for name in ("x", "y", "z", "x_dot", "y_dot", "z_dot")
            ]
        )
        assert len(read.data.maneuver_parameters) == len(leg.impulses)
        for burn in read.data.maneuver_parameters:
            assert burn.man_ref_frame == (frame or "GCRF")
            time = seconds(instance, burn.man_epoch_ignition)
            state = np.concatenate(coast(state[:3], state[3:], [time - now]), axis=1)[0]
            state[3:] += [1e3 * float(getattr(burn, f"man_dv_{axis}").value) for axis in (1, 2, 3)]
            now = time
        state = np.concatenate(coast(state[:3], state[3:], [leg.arrival_s - now]), axis=1)[0]
        (goal,) = (state_of(body) for body in one.bodies if body.name == leg.destination)
        goal = moved(goal, leg.arrival_s, one.gravity)
        assert np.linalg.norm(state[:3] - axes.turned(goal[:3])) < 0.1
        assert np.linalg.norm(state[3:] - axes.turned(goal[3:])) < 1e-3


@pytest.mark.parametrize(("gravity", "degree"), [("two-body", 0), ("j2", 2), ("j4", 4)])
def test_gmat_script_of_a_refined_plan_flies_the_mission(
    gravity: str, degree: int, tmp_path: Path
) -> None:
    """From osculating states in GCRF, with the burns of the plan, the sequence arrives."""
    instance, _, one = mission(gravity)
    matrix = axes_of(instance).matrix
    for leg in (None, 2):
        write_refined(instance, one, tmp_path / "a.script", file=FlightFile("script"), leg=leg)
        text = (tmp_path / "a.script").read_text(encoding="ascii")
        assert "DisplayStateType = Cartesian;" in text
        assert "BrouwerMean" not in text
        assert (f"Zonal.GravityField.Earth.Degree = {degree};" in text) == (degree > 0)
        assert "GMAT Chaser.CoordinateSystem = EarthICRF;" in text
        reports, clock = fly_script(text, coasting(one, matrix))
        legs = [each for each in one.legs if leg in (None, each.leg)]
        assert len(reports) == len(legs)
        for chaser, goal in reports:
            assert np.linalg.norm(chaser - goal) < 0.1
        assert clock == pytest.approx(legs[-1].done_s - legs[0].ready_s, abs=2e-3)


def test_a_refined_leg_after_a_tow_begins_where_the_tow_led(tmp_path: Path) -> None:
    """A script of that leg alone, and one of the whole plan, arrive at each target."""
    instance, plan, one = towing()
    after = next(leg for leg in one.legs if leg.tow_before is not None)
    assert plan.lead_ins
    for number, legs in ((None, one.legs), (after.leg, (after,))):
        write_refined(instance, one, tmp_path / "a.script", file=FlightFile("script"), leg=number)
        text = (tmp_path / "a.script").read_text(encoding="ascii")
        reports, _ = fly_script(text, coasting(one, None))
        assert len(reports) == len(legs)
        for chaser, goal in reports:
            assert np.linalg.norm(chaser - goal) < 1.0


def test_ephemerides_of_refined_plans_are_turned(tmp_path: Path) -> None:
    """States of chaser and bodies in GCRF are those in TEME, turned."""
    oem = pytest.importorskip("oem")
    instance, _, one = mission()
    matrix = axes_of(instance, "GCRF").matrix
    for body in (None, one.legs[0].destination):
        found = {}
        for frame in ("TEME", "GCRF"):
            file = FlightFile(frame=frame)
            write_refined(instance, one, tmp_path / "a.oem", file=file, body=body, leg=1)
            read = oem.OrbitEphemerisMessage.open(tmp_path / "a.oem")
            found[frame] = np.array(
                [state.position for segment in read.segments for state in segment.states]
            )
            assert read.segments[0].metadata["REF_FRAME"] == frame
        assert np.abs(found["GCRF"] - found["TEME"] @ matrix.T).max() < 1e-8
        assert np.linalg.norm(found["GCRF"] - found["TEME"], axis=1).max() > 20.0


def test_the_shell_writes_refined_plans_in_every_format(cli: Cli, tmp_path: Path) -> None:
    """What the suffix says is written and counted; bodies and gaps are refused."""
    instance, _, one = mission()
    instance.save("my.json")
    one.save("refined.json")
    for suffix, begin in (
        ("oem", "CCSDS_OEM"),
        ("opm", "CCSDS_OPM"),
        ("ocm", "CCSDS_OCM"),
        ("czml", '[{"id":"document"'),
        ("script", "% Plan by"),
    ):
        done = cli("export", "my.json", "refined.json", "--out", f"a.{suffix}", "--json")
        assert done.status == 0, done.err
        told = json.loads(done.out)
        assert (told["format"], told["legs"]) == (suffix, len(one.legs))
        assert told["frame"] == ("ICRF" if suffix == "czml" else "GCRF")
        assert told["instance_frame"] == "TEME"
        text = Path(f"a.{suffix}").read_text(encoding="utf-8")
        assert text.startswith(begin)
        assert instance.sha256 in text
    gap = one.replace(
        legs=(one.legs[0], *one.legs[2:]),
        status="incomplete",
        missing=({"leg": 2, "reason": "interrupted"},),
    )
    gap.save("gap.json")
    for plan, out, more, said in (
        ("refined.json", "b.opm", ("--body", one.bodies[0].name), "makes no burns"),
        ("refined.json", "b.script", ("--frame", "TEME"), "GMAT has no such axes"),
        ("gap.json", "b.opm", (), "the legs between are not refined"),
        ("gap.json", "b.script", (), "the legs between are not refined"),
    ):
        done = cli("export", "my.json", plan, "--out", out, *more)
        assert done.status == 2
        assert done.err.count("\n") == 1
        assert said in done.err
        assert not Path(out).exists()
    assert cli("export", "my.json", "gap.json", "--out", "b.opm", "--leg", 3).status == 0


def masses(path: Path) -> tuple[float, list[tuple[int, str, float, float]]]:
    """First mass of a message, and leg, phase, mass before it and change of mass of each burn."""
    found = []
    text = path.read_text(encoding="ascii")
    for block in (part.replace("\nCOMMENT ", " ") for part in text.split("\n\n")):
        if "MAN_DELTA_MASS" in block:
            said = re.search(r"leg (\d+), [^\n]*: ([a-z0-9-]+), ([\d.]+) kg before it\n", block)
            lost = re.search(r"\nMAN_DELTA_MASS = (\S+) \[kg\]\n", block)
            found.append((int(said[1]), said[2], float(said[3]), float(lost[1])))
    return float(re.search(r"^MASS = (\S+)", text, re.MULTILINE)[1]), found


def test_masses_of_a_message_are_those_of_the_plan(tmp_path: Path) -> None:
    """Burn by burn propellant goes by the rocket equation, and tanks are filled at the station."""
    instance, plan, one = mission("two-body")
    write_plan(instance, plan, tmp_path / "a.opm")
    first, burns = masses(tmp_path / "a.opm")
    assert len(burns) == sum(len(leg.impulses) for leg in plan.legs)
    assert first == burns[0][2] == pytest.approx(1300.0)
    sizes = [burn.size_m_s for leg in plan.legs for burn in leg.impulses]
    for (_, _, before, lost), size in zip(burns, sizes, strict=True):
        assert lost == pytest.approx(-before * -math.expm1(-size / TANK.exhaust_m_s), abs=2e-6)
    # Legs between circles take their burns, but for what is saved by one vector at a stand-off.
    saved_m_s = 0.0
    for number, leg in enumerate(plan.legs, start=1):
        _, _, before, lost = [burn for burn in burns if burn[0] == number][-1]
        saved_m_s += leg.at_once_m_s
        if leg.destination not in instance.station_names:
            kept = math.exp(saved_m_s / TANK.exhaust_m_s)
            assert before + lost == pytest.approx(leg.mass_kg * kept, abs=1e-3)
        else:
            saved_m_s = 0.0
    for one_burn, after in pairwise(burns):
        refuelled = plan.legs[one_burn[0] - 1].destination in instance.station_names
        if one_burn[0] == after[0] or not refuelled:
            assert after[2] == pytest.approx(one_burn[2] + one_burn[3], abs=2e-6)
    text = (tmp_path / "a.opm").read_text(encoding="ascii")
    assert text.startswith("CCSDS_OPM_VERS = 2.0\n")
    assert "placeholder" not in text

    # Of one leg alone the mass is what those before it have left.
    write_plan(instance, plan, tmp_path / "leg.opm", leg=2)
    second = next(before for number, _, before, _ in burns if number == 2)
    assert masses(tmp_path / "leg.opm")[0] == pytest.approx(second, abs=2e-6)
    write_refined(instance, one, tmp_path / "r.opm", file=FlightFile("opm"))
    assert masses(tmp_path / "r.opm")[0] == pytest.approx(1300.0)
    read = message(tmp_path / "r.opm").data
    assert all(float(burn.man_delta_mass.value) < 0.0 for burn in read.maneuver_parameters)


def test_kits_and_tows_count_in_masses(tmp_path: Path) -> None:
    """A kit stays behind after a leg, and a burn of a tow pushes the object, too."""
    instance, plan, _ = towing()
    write_plan(instance, plan, tmp_path / "a.opm")
    _, burns = masses(tmp_path / "a.opm")
    legs = {number: leg for number, leg in enumerate(plan.legs, start=1) if leg.tow is not None}
    assert legs
    for number in legs:
        own = [burn for burn in burns if burn[0] == number]
        last, (_, phase, before, _) = own[-3], own[-2]
        assert phase == "tow"
        assert before == pytest.approx(last[2] + last[3] + 250.0, abs=1e-3)

    instance, plan = launched.campaign(), launched.planned()
    for route in plan.routes:
        write_plan(instance, plan, tmp_path / "a.opm", chaser=route.chaser)
        first, burns = masses(tmp_path / "a.opm")
        # The first kit stays with the target that it is launched onto, before any burn.
        kits = launched.KIT_KG * (len(route.legs) - 1)
        assert first == pytest.approx(launched.DRY_KG + launched.PROPELLANT_KG + kits, abs=1e-3)
        steps = [after[2] - one[2] - one[3] for one, after in pairwise(burns) if one[0] != after[0]]
        assert steps == pytest.approx([-launched.KIT_KG] * (len(route.legs) - 2), abs=1e-3)


def test_without_masses_a_message_is_one_that_may_do_without(tmp_path: Path) -> None:
    """A tank in m/s has a placeholder, no change of mass, and the version that allows it."""
    instance = adr_opt.generate("tiny", 0)
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    write_plan(instance, plan, tmp_path / "a.opm")
    text = (tmp_path / "a.opm").read_text(encoding="ascii")
    assert text.startswith("CCSDS_OPM_VERS = 3.0\n")
    assert "The mass is a placeholder" in text
    read = message(tmp_path / "a.opm").data
    assert {float(burn.man_delta_mass.value) for burn in read.maneuver_parameters} == {0.0}


def test_designators_of_chasers_and_bodies(cli: Cli) -> None:
    """--object-id names the chaser, a body has the designator of the instance; else UNKNOWN."""
    instance, _, one = mission()
    target = next(body.name for body in one.bodies if body.name not in instance.station_names)
    named = instance.replace(
        targets=tuple(
            each.replace(object_id="1997-051C") if each.name == target else each
            for each in instance.targets
        )
    )
    named.save("my.json")
    moved_to(named, one).save("r.json")
    adr_opt.solve(named, "greedy-guarded").plan.save("plan.json")
    given = ("--object-id", "2031-007A")
    for plan, out, more, said in (
        ("plan.json", "a.oem", (), "UNKNOWN"),
        ("plan.json", "a.opm", given, "2031-007A"),
        ("plan.json", "a.oem", given, "2031-007A"),
        ("r.json", "a.opm", given, "2031-007A"),
        ("r.json", "a.oem", (), "UNKNOWN"),
        ("r.json", "a.oem", ("--body", target), "1997-051C"),
        ("r.json", "a.oem", ("--body", "station"), "UNKNOWN"),
        ("r.json", "a.oem", ("--body", target, *given), "2031-007A"),
    ):
        assert cli("export", "my.json", plan, "--out", out, *more).status == 0
        text = Path(out).read_text(encoding="ascii")
        assert set(re.findall(r"^OBJECT_ID = (.*)$", text, re.MULTILINE)) == {said}
    for wrong in ("", " ", "Ж", "a\nb"):
        done = cli("export", "my.json", "plan.json", "--out", "b.opm", "--object-id", wrong)
        assert done.status == 2
        assert done.err.count("\n") == 1
        assert "--object-id" in done.err
        assert not Path("b.opm").exists()


def test_designators_stand_in_files_that_state_them_only(cli: Cli) -> None:
    """Import keeps them of targets and of a station; a file without any is as it was."""
    plain = adr_opt.generate("tiny", 0)
    assert "object_id" not in plain.to_json()
    cloud = Path(__file__).parents[2] / "examples" / "catalogue" / "cloud.tle"
    made = cli(
        "import", cloud, "--max-targets", 5, "--station", 90001, "--out", "my.json", "--quiet"
    )
    assert made.status == 0
    instance = adr_opt.load("my.json")
    assert instance.stations[0].object_id == "2026-001A"
    assert all(re.fullmatch(r"2026-001[A-Z]{1,3}", one.object_id) for one in instance.targets)
    assert len({one.object_id for one in instance.targets}) == 5
    for kind in (Target, Station):
        for wrong in ("", "Ж", "a\nb", " a"):
            with pytest.raises(ValueError, match="object_id"):
                kind(name="a", object_id=wrong)
