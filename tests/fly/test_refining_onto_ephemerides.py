"""``refine --ephemerides``: legs between the states that ephemerides report."""

from __future__ import annotations

import json
import math
import os
import pickle
import time
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from catalogue_files import as_json, field
from conftest import Cli, refused
from messages import oem

import adr_opt
from adr_opt.common.constants import DAY_S, MU_M3_S2
from adr_opt.common.errors import InputError
from adr_opt.export.flights.refined_oem import write_refined
from adr_opt.export.flights.write import FlightFile
from adr_opt.fly.dispersion import sample_flights
from adr_opt.fly.flight import fly_refined
from adr_opt.fly.flight.tanks import tanks_of
from adr_opt.fly.refine.bodies import Whereabouts, moved
from adr_opt.fly.refine.ephemeris import tracks
from adr_opt.fly.refine.lessons import Lessons
from adr_opt.fly.refine.one_leg import refine_leg
from adr_opt.fly.refine.reported import ReportedBodies, following_m_s, holding_m_s
from adr_opt.fly.refine.troubles import beginning
from adr_opt.judge.refined import check_refined
from adr_opt.mission.problem import Problem
from adr_opt.plan.plan import Plan
from adr_opt.plan.refined_plan import Missing, RefinedPlan
from adr_opt.problem.chasers import TankByMass
from adr_opt.problem.disposal import DisposalCircle
from adr_opt.problem.frame import Frame
from adr_opt.problem.frame_rotation import from_gcrf, teme_axes
from adr_opt.problem.instance import Instance
from adr_opt.sources import catalogue
from adr_opt.sources.catalogue import ElementSet
from adr_opt.sources.catalogue.propagation import mean_elements
from adr_opt.sources.ephemerides import ephemerides_of
from adr_opt.sources.ephemerides.imported import with_ephemerides
from adr_opt.sources.ephemerides.oem import read_oem
from adr_opt.sources.ephemerides.of_instance import of_contents
from adr_opt.ui.plot.budget import costs_chart
from adr_opt.ui.report.flights import complaints, section
from adr_opt.ui.report.sections import costs_note

sgp4 = pytest.importorskip("sgp4.api")
sgp4_omm = pytest.importorskip("sgp4.omm")
pytest.importorskip("erfa")

EPOCH = datetime(2025, 3, 2, 12, tzinfo=UTC)
TEME = Frame(name="TEME", axes_epoch=EPOCH)
QUICK = "greedy-guarded"

DATA = Path(os.environ.get("ADR_OPT_EXTERNAL_DATA", "../shared/data"))


def records(count: int = 6) -> list[ElementSet]:
    """Element sets of one plane, or nearly so, that a chaser goes round in two days."""
    rng = np.random.default_rng(5)
    return [
        replace(
            record,
            inclination_deg=round(86.4 + float(rng.uniform(-0.05, 0.05)), 4),
            raan_deg=round(120.0 + float(rng.uniform(-0.5, 0.5)), 4),
            mean_motion_rev_day=round(float(rng.uniform(14.3, 14.5)), 8),
        )
        for record in field(count, seed=2)
    ]


class Mission(NamedTuple):
    """An instance with ephemerides beside it, its plan, and the plan refined onto them."""

    instance: Instance
    plan: Plan
    refined: RefinedPlan


@pytest.fixture(scope="module")
def mission(tmp_path_factory: pytest.TempPathFactory) -> Mission:
    """Six objects for two days, with element sets that SGP4 runs."""
    folder = tmp_path_factory.mktemp("onto")
    (folder / "all.json").write_text(as_json(records()), encoding="utf-8")
    outline = catalogue.MissionOutline(epoch=EPOCH, duration_s=2.0 * DAY_S)
    made = catalogue.to_instance(catalogue.read(folder / "all.json"), mission=outline)
    with_ephemerides(made, folder / "my.json").write(folder / "my.json")
    instance = adr_opt.load(folder / "my.json")
    plan = adr_opt.solve(instance, QUICK, time_limit=60.0).plan
    assert plan is not None
    assert len(plan.legs) >= 3
    return Mission(instance, plan, adr_opt.refine(instance, plan, ephemerides=True))


@pytest.fixture
def files(cli: Cli, mission: Mission) -> Mission:
    """The same as files where the command line runs."""
    mission.instance.save("my.json")
    mission.plan.save("plan.json")
    mission.refined.save("refined.json")
    return mission


def by_sgp4_alone(instance: Instance, body: str, time_s: float) -> Any:
    """State of a body by the sgp4 package from the file beside an instance, shape (6,)."""
    assert instance.ephemerides is not None
    assert instance.frame is not None
    (name,) = instance.ephemerides.files
    content = json.loads((Path(instance.folder()) / name).read_text(encoding="utf-8"))
    satellite = sgp4.Satrec()
    sgp4_omm.initialize(satellite, content["bodies"][body])
    begin = instance.epoch - datetime.fromisoformat(content["bodies"][body]["EPOCH"] + "+00:00")
    minutes = (begin.total_seconds() + time_s) / 60.0
    code, position, velocity = satellite.sgp4_tsince(minutes)
    assert code == 0
    (axes,) = teme_axes([instance.epoch + timedelta(seconds=time_s)])
    turn = from_gcrf(instance.frame) @ axes.T
    return 1e3 * np.concatenate((turn @ np.array(position), turn @ np.array(velocity)))


def event(leg: Any, name: str) -> Any:
    """State of the chaser at an event of a leg, and its time."""
    (found,) = (state for state in leg.states if state.event == name)
    return np.array([*found.position_m, *found.velocity_m_s]), found.time_s


def assert_begins_and_ends_on_sgp4(
    instance: Instance, refined: RefinedPlan, most_m: float, most_m_s: float
) -> None:
    """Departure, stand-off and arrival of every leg are states by SGP4."""
    length_m, seen = instance.transfer.standoff_m, 0
    for leg in refined.legs:
        wanted = []
        if leg.origin not in instance.station_names:
            wanted.append((event(leg, "departure"), leg.origin, 0.0))
        if leg.destination not in instance.station_names:
            wanted.append((event(leg, "arrival"), leg.destination, 0.0))
            wanted.append((event(leg, "stand-off"), leg.destination, length_m))
        for (state, time_s), body, behind_m in wanted:
            reported = by_sgp4_alone(instance, body, time_s)
            if behind_m:
                delay_s = behind_m / float(np.linalg.norm(reported[3:]))
                reported = by_sgp4_alone(instance, body, time_s - delay_s)
                reported[3:] += leg.approach_m_s
            assert np.linalg.norm((state - reported)[:3]) < most_m, (leg.leg, body)
            assert np.linalg.norm((state - reported)[3:]) < most_m_s, (leg.leg, body)
            seen += 1
    assert seen >= len(refined.legs)


def test_legs_begin_at_and_close_onto_what_sgp4_reports(mission: Mission) -> None:
    """Departures, stand-offs and arrivals are SGP4's positions and velocities."""
    assert mission.refined.status == "complete"
    assert mission.refined.gravity == "j4"
    assert_begins_and_ends_on_sgp4(mission.instance, mission.refined, 0.05, 5e-5)


def test_workers_elsewhere_get_the_same_ends(mission: Mission) -> None:
    """States at the ends of legs are data: a copy of them, as for a cluster, gives equal legs."""
    legs = mission.plan.legs
    known = ephemerides_of(mission.instance)
    bodies = ReportedBodies(mission.instance, known, "j4", legs)
    copied = pickle.loads(pickle.dumps(bodies))
    for number, leg in enumerate(legs, start=1):
        made = refine_leg(mission.instance, copied, number, leg, "free")
        assert made.burns == mission.refined.legs[number - 1].burns


def test_the_judge_reads_the_ephemerides_itself(mission: Mission) -> None:
    """A refined plan holds in the other integrator, which finds as much ΔV of holding."""
    flight = fly_refined(mission.instance, mission.refined)
    assert flight.holds
    assert flight.onto_ephemerides
    assert flight.worst_miss_m < 0.1
    for leg in flight.legs:
        assert leg.holding_delta_v_m_s is not None
        assert leg.holding_found_m_s is not None
        assert leg.holding_delta_v_m_s == pytest.approx(leg.holding_found_m_s, rel=0.3, abs=0.15)


def test_holding_counts_in_tanks_and_in_no_leg(mission: Mission) -> None:
    """A tank gives the burns of its legs and what holding takes, with errors of burns, too."""
    refined = mission.refined
    assert refined.holding_m_s > 0.0
    spent = math.fsum(leg.spent_m_s for leg in refined.legs)
    assert refined.flown_delta_v_m_s == pytest.approx(spent)
    tanks = tanks_of(mission.instance, refined)
    taken = math.fsum(tank.flown_delta_v_m_s for tank in tanks)
    assert taken == pytest.approx(spent + refined.holding_m_s)
    sampled = sample_flights(mission.instance, refined, 20)
    assert sampled.refined_delta_v_m_s == pytest.approx(taken)
    assert math.fsum(tank.refined_delta_v_m_s for tank in sampled.tanks) == pytest.approx(
        spent, abs=5.0
    )


def test_free_motion_takes_no_holding() -> None:
    """A trajectory of the field takes nothing, and a circle at another rate its thrust."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        radius, faster = rng.uniform(6.8e6, 8e6), rng.choice([0.0, 1e-6, -3e-6])
        rate = math.sqrt(MU_M3_S2 / radius**3)
        span_s = float(rng.uniform(1.0, 30.0)) * math.tau / rate
        times = np.linspace(0.0, span_s, math.ceil(span_s / 240.0) + 1)
        rate *= 1.0 + faster
        c, s = np.cos(rate * times), np.sin(rate * times)
        nothing = np.zeros(times.size)
        states = np.column_stack(
            (radius * c, radius * s, nothing, -radius * rate * s, radius * rate * c, nothing)
        )
        needed = abs(radius * rate**2 - MU_M3_S2 / radius**2) * span_s
        assert following_m_s(states, times, "two-body") == pytest.approx(needed, rel=0.05, abs=1e-5)


def test_plans_without_ephemerides_say_nothing_of_them() -> None:
    """Files of other refined plans have no new field, and what is wrong with one is refused."""
    instance = adr_opt.generate("tiny", 0).replace(dynamics="j2")
    plan = adr_opt.solve(instance, QUICK).plan
    assert plan is not None
    refined = adr_opt.refine(instance, plan)
    assert "ephemerides" not in refined.to_json()
    assert "holding" not in refined.to_json()
    legs = tuple(leg.replace(holding_delta_v_m_s=1.0) for leg in refined.legs)
    with pytest.raises(ValueError, match="holding_delta_v_m_s"):
        refined.replace(legs=legs)
    flight = fly_refined(instance, refined).to_dict()
    assert "holding" not in json.dumps(flight)


def test_the_command_line_refines_onto_ephemerides(cli: Cli, files: Mission) -> None:
    """`refine`, `fly` and the loop take the flag and tell of holding."""
    told = cli("refine", "my.json", "plan.json", "--ephemerides", "--out", "again.json")
    assert told.status == 0
    assert "holding takes an estimated" in told.out
    again = adr_opt.load_refined("again.json")
    assert again.legs == files.refined.legs
    assert again.ephemerides == files.refined.ephemerides
    said = json.loads(
        cli("refine", "my.json", "plan.json", "--ephemerides", "--out", "j.json", "--json").out
    )
    assert said["ephemerides"]["kind"] == "elements"
    assert said["holding_delta_v_m_s"] == again.holding_m_s
    flown = cli("fly", "my.json", "again.json")
    assert flown.status == 0, flown.out
    assert "onto ephemerides" in flown.out
    looped = cli(f"solve my.json --refine --ephemerides --method {QUICK} --refined-out looped.json")
    assert looped.status == 0, looped.err
    assert "of holding beside ephemerides" in looped.out
    assert cli("fly", "my.json", "looped.json").status == 0


def test_errors_follow_from_successive_element_sets(cli: Cli, files: Mission) -> None:
    """`fly --element-sets` compares sets of two epochs, counts who has one, and flies on that."""
    older = records()
    at = older[0].epoch - timedelta(days=3)
    mean = np.degrees(mean_elements(older, at)[0][:, 3:]) % 360.0
    before = [
        replace(
            record,
            epoch=at,
            raan_deg=raan,
            argument_of_perigee_deg=perigee,
            mean_anomaly_deg=anomaly,
            bstar=1.5 * record.bstar,
        )
        for record, (raan, perigee, anomaly) in zip(older[:-1], mean.tolist(), strict=False)
    ]
    Path("now.json").write_text(as_json(older), encoding="utf-8")
    Path("before.json").write_text(as_json(before), encoding="utf-8")
    asked = ["fly", "my.json", "refined.json", "--samples", "30", "--element-sets", "now.json"]
    told = cli(*asked, "--element-sets", "before.json")
    assert told.status == 0, told.err
    assert "5 pairs of element sets of 5 objects" in told.out
    assert "1 target of one set take these" in told.out
    assert "known a revolution before the stand-off" in told.out
    found = json.loads(cli(*asked, "--element-sets", "before.json", "--json").out)["errors"]
    assert found["element_sets"]["by_median"] == [older[-1].label]
    met = {leg.destination for leg in files.refined.legs} - set(files.instance.station_names)
    assert set(found["targets"]["uncertain"]) == met
    alone = cli(*asked)
    assert (alone.status, alone.out) == (2, "")
    assert "no target has element sets of two epochs" in alone.err


def test_the_loop_learns_what_holding_takes(mission: Mission) -> None:
    """Corrected connections cost at least what legs were flown with and holding took."""
    dearer = tuple(leg.replace(holding_delta_v_m_s=300.0) for leg in mission.refined.legs)
    lessons = Lessons(mission.instance)
    lessons.learn(mission.plan, mission.refined.replace(legs=dearer))
    for leg in dearer:
        cost = lessons.corrections.corrected(
            leg.origin, leg.destination, leg.kind, leg.planned_delta_v_m_s
        )
        assert cost >= leg.flown_delta_v_m_s + 300.0 - 1e-6


def tampered(refined: RefinedPlan, **change: Any) -> RefinedPlan:
    """A refined plan with another second leg."""
    legs = list(refined.legs)
    legs[1] = legs[1].replace(**change)
    return refined.replace(legs=tuple(legs))


def test_the_judge_finds_what_is_not_as_reported(cli: Cli, files: Mission) -> None:
    """A departure off its origin, a burn that misses and unstated holding each have status 1."""
    refined = files.refined
    leg = refined.legs[1]
    first, *others = leg.states
    off = first.replace(position_m=(first.position_m[0] + 20.0, *first.position_m[1:]))
    burn, *burns = leg.burns
    more = burn.replace(delta_v_m_s=tuple(1.01 * part for part in burn.delta_v_m_s))
    size = leg.flown_delta_v_m_s + 0.01 * burn.size_m_s
    for change, said in (
        ({"states": (off, *others)}, "missed by more than 10 m or 1 cm/s"),
        ({"burns": (more, *burns), "flown_delta_v_m_s": size}, "missed by more than 10 m"),
        ({"holding_delta_v_m_s": 0.0}, "too little ΔV of holding"),
    ):
        tampered(refined, **change).save("bad.json")
        refused(cli("fly", "my.json", "bad.json"), f"not legal: leg {leg.leg}")
        flown = cli("fly", "my.json", "bad.json", "--unjudged")
        assert flown.status == 1
        assert f"leg {leg.leg} " in flown.out
        assert said in flown.out.replace("state too", "too")


def test_the_judge_reads_ephemerides_itself_or_says_that_it_cannot(files: Mission) -> None:
    """Nothing is found in what was refined, holding is asked for, and lost files are unjudged."""
    instance, plan, refined = adr_opt.load("my.json"), files.plan, files.refined
    assert check_refined(instance, plan, refined) == ()
    held = tampered(refined, holding_delta_v_m_s=0.0)
    assert {one.rule for one in check_refined(instance, plan, held)} == {"holding"}
    Path("my.elements.json").unlink()
    (found,) = check_refined(instance, plan, refined)
    assert found.rule == "unjudged"
    assert "no such file" in found.message


def test_what_cannot_be_refined_onto_ephemerides_is_one_sentence(cli: Cli, files: Mission) -> None:
    """No ephemerides, other ones, none found, a decay without the flag: status 2 and one line."""
    asked = ["refine", "my.json", "plan.json", "--out", "out.json"]
    refused(cli(*asked), "decays", "--ephemerides")
    path = Path("my.elements.json")
    whole = path.read_text(encoding="utf-8")
    path.write_text(whole.replace('"BSTAR": 0.', '"BSTAR": 0.1'), encoding="utf-8")
    refused(cli(*asked, "--ephemerides"), "not the ephemerides that the instance names")
    refused(cli("fly", "my.json", "refined.json"), "not the ephemerides that the instance names")
    path.unlink()
    refused(cli(*asked, "--ephemerides"), "no such file")
    refused(
        cli("solve", "my.json", "--refine", "--ephemerides", "--out", "out.json"), "no such file"
    )
    refused(cli("solve", "my.json", "--ephemerides", "--out", "out.json"), "add --refine")
    assert not Path("out.json").exists()
    plain = adr_opt.generate("tiny", 0)
    plain.save("plain.json")
    refused(cli("solve", "plain.json", "--refine", "--ephemerides"), "has no ephemerides")


MASSES = ["--dry-mass", "300", "--propellant", "100", "--isp", "1500"]


def test_low_thrust_is_one_sentence(cli: Cli) -> None:
    """Such missions are refused with ephemerides before anything is planned."""
    Path("all.json").write_text(as_json(records(3)), encoding="utf-8")
    made = cli(
        "import all.json --epoch",
        EPOCH.isoformat(),
        "--duration-days",
        "2",
        "--ephemerides",
        *MASSES,
        "--thrust",
        "0.5",
        "--max-drift-days",
        "2",
        "--out",
        "my.json",
        "--quiet",
    )
    assert made.status == 0, made.err
    refused(cli("solve", "my.json", "--refine", "--ephemerides"), "does not follow low thrust")


def test_tows_begin_where_sgp4_says(tmp_path: Path) -> None:
    """Tows begin at the states of their objects, and legs at their releases; tanks pay for both.

    Towed objects are fitted without a decay, and held beside until their tow begins. A beginning of
    the plan that ends with a tow begins that at once, on the ephemeris, too.
    """
    round_ones = [replace(record, eccentricity=1e-4) for record in records(4)]
    (tmp_path / "all.json").write_text(as_json(round_ones), encoding="utf-8")
    outline = catalogue.MissionOutline(epoch=EPOCH, duration_s=3.0 * DAY_S)
    tank = TankByMass(dry_mass_kg=500.0, propellant_kg=1000.0, isp_s=310.0)
    crew = catalogue.Crew(tank=tank, towed_kg=100.0, disposal=DisposalCircle(circle_m=450e3))
    made = catalogue.to_instance(catalogue.read(tmp_path / "all.json"), mission=outline, crew=crew)
    with_ephemerides(made, tmp_path / "my.json").write(tmp_path / "my.json")
    instance = adr_opt.load(tmp_path / "my.json")
    assert not any(target.decay_m_per_day for target in instance.targets)
    plan = adr_opt.solve(instance, QUICK, time_limit=60.0).plan
    assert plan is not None
    refined = adr_opt.refine(instance, plan, ephemerides=True)
    assert refined.status == "complete"
    flight = fly_refined(instance, refined)
    assert flight.holds
    assert flight.worst_miss_m < 0.1
    towing = [leg for leg in refined.legs if leg.tow is not None]
    assert len(towing) >= 3
    for leg in towing:
        tow = leg.tow
        assert tow is not None
        begin = by_sgp4_alone(instance, leg.destination, tow.start_s)
        begin[3:] += tow.burns[0].delta_v_m_s
        there = moved(begin, tow.released.time_s - tow.start_s, "j4")
        assert np.linalg.norm(there[:3] - tow.released.position_m) < 0.1
    led = [leg for leg in refined.legs if leg.tow_before is not None]
    assert led
    for leg in led:
        assert leg.tow_before is not None
        assert leg.states[0].position_m == pytest.approx(leg.tow_before.released.position_m)
        assert leg.ready_s == leg.states[0].time_s
        # On the way of the tow the chaser is not held beside the ephemeris of the object.
        planned, known = plan.legs[leg.leg - 1], ephemerides_of(instance)
        assert leg.holding_delta_v_m_s == holding_m_s(known, "j4", planned, led=True)
        assert leg.holding_delta_v_m_s < holding_m_s(known, "j4", planned) - 1e-3
    last = led[-1].leg
    cut = refined.replace(
        legs=tuple(leg for leg in refined.legs if leg.leg != last),
        status="incomplete",
        missing=(Missing(leg=last, reason="cut"),),
    )
    kept = beginning(Problem(instance), plan, cut)
    assert kept is not None
    shorter, flown = kept
    assert len(shorter.legs) == last - 1
    final = flown.legs[-1].tow
    assert final is not None
    assert final.start_s == pytest.approx(flown.legs[-1].end_s)
    assert fly_refined(instance, flown).holds


@pytest.mark.slow
def test_messages_go_round_through_a_refined_plan(tmp_path: Path, mission: Mission) -> None:
    """Messages become an instance, a refined plan and messages again, to less than a metre."""
    sources = tmp_path / "given"
    sources.mkdir()
    paths = []
    for number, record in enumerate(records()):
        known = ephemerides_of(mission.instance).of(record.label)
        text = oem(
            record.label,
            record.object_id,
            EPOCH,
            known.state,
            span_s=(0.0, 2.0 * DAY_S),
            REF_FRAME_EPOCH="2025-03-02T12:00:00",
        )
        paths.append(sources / f"{number}.oem")
        paths[-1].write_text(text, encoding="utf-8")
    (tmp_path / "all.json").write_text(as_json(records()), encoding="utf-8")
    outline = catalogue.MissionOutline(epoch=EPOCH, duration_s=2.0 * DAY_S)
    made = catalogue.to_instance(catalogue.read(tmp_path / "all.json"), mission=outline)
    with_ephemerides(made, tmp_path / "my.json", paths).write(tmp_path / "my.json")
    instance = adr_opt.load(tmp_path / "my.json")
    plan = adr_opt.solve(instance, QUICK, time_limit=60.0).plan
    assert plan is not None
    refined = adr_opt.refine(instance, plan, ephemerides=True)
    assert fly_refined(instance, refined).holds
    leg = refined.legs[0]
    body = leg.destination
    write_refined(instance, refined, tmp_path / "out.oem", body=body)
    write_refined(instance, refined, tmp_path / "chaser.oem")
    (segment,) = read_oem((tmp_path / "out.oem").read_bytes(), "out.oem")
    assert segment.names[0] == body
    back = of_contents(
        "oem",
        {"out.oem": (tmp_path / "out.oem").read_bytes()},
        {body: None},
        epoch=instance.epoch,
        frame=TEME,
    )
    times = np.linspace(leg.ready_s, refined.legs[-1].end_s, 2000)
    given = ephemerides_of(mission.instance).of(body).state(times)
    apart = np.linalg.norm((back.of(body).state(times) - given)[:, :3], axis=1)
    assert apart.max() < 1.0
    served = [
        one
        for one in read_oem((tmp_path / "chaser.oem").read_bytes(), "chaser.oem")
        if one.says("INTERPOLATION", "") == "LAGRANGE"
    ]
    assert len(served) >= len(refined.legs)


def test_the_chaser_is_beside_its_bodies_in_exports(mission: Mission, tmp_path: Path) -> None:
    """Waits and services are the ephemeris of the body; burns alone are written of single legs."""
    instance, refined = mission.instance, mission.refined
    known, bodies = ephemerides_of(instance), Whereabouts.of(instance, refined)
    services = [one for one in tracks(refined, bodies=bodies) if one.arc.phase == "service"]
    legs = [leg for leg in refined.legs if leg.end_s - leg.arrival_s > 60.0]
    assert len(services) == len(legs)
    for track, leg in zip(services, legs, strict=True):
        if leg.destination in known.bodies:
            expected = known.of(leg.destination).state(track.arc.times_s)
            assert np.abs(track.arc.positions_m - expected[:, :3]).max() < 1e-6
    with pytest.raises(InputError, match="give the whereabouts"):
        tracks(refined)
    for format, leg, said in (
        ("script", 1, "bodies of a script do not follow"),
        ("opm", None, "no burns hold the chaser"),
    ):
        with pytest.raises(InputError, match=said):
            write_refined(instance, refined, tmp_path / "x", file=FlightFile(format), leg=leg)
    for format, leg in (("opm", 1), ("ocm", None), ("czml", None)):
        write_refined(instance, refined, tmp_path / f"x.{format}", file=FlightFile(format), leg=leg)


@pytest.mark.parametrize("name", ["TEME", "EME2000"])
def test_other_readers_find_the_chaser_where_sgp4_says(
    name: str, mission: Mission, tmp_path: Path
) -> None:
    """In a message as `oem` and `ccsds-ndm` read it, a leg ends where the package `sgp4` says."""
    third, ndm_io = pytest.importorskip("oem"), pytest.importorskip("ccsds_ndm.ndm_io")
    instance, refined = mission.instance, mission.refined
    assert instance.frame is not None
    frame = instance.frame if name == "TEME" else Frame(name="EME2000")
    turn = from_gcrf(frame) @ from_gcrf(instance.frame).T
    path = tmp_path / "a.oem"
    leg = next(leg for leg in refined.legs if leg.destination not in instance.station_names)
    write_refined(instance, refined, path, file=FlightFile(frame=name), leg=leg.leg)
    read = third.OrbitEphemerisMessage.open(path)
    assert {segment.metadata["REF_FRAME"] for segment in read.segments} == {name}
    listed = [segment.metadata for segment in ndm_io.NdmIo().from_path(path).body.segment]
    assert [one.ref_frame for one in listed] == [name] * len(read.segments)
    ends = [list(segment.states)[-1] for segment in read.segments]
    times = [(end.epoch.utc.to_datetime(timezone=UTC) - instance.epoch) for end in ends]
    gaps = [abs(time.total_seconds() - leg.arrival_s) for time in times]
    docked = ends[int(np.argmin(gaps))]
    assert min(gaps) < 1e-5
    found = 1e3 * np.concatenate((docked.position, docked.velocity))
    reported = by_sgp4_alone(instance, leg.destination, leg.arrival_s)
    assert np.linalg.norm(found[:3] - turn @ reported[:3]) < 0.5
    # The last impulse follows the state that the message ends with.
    found[3:] += turn @ leg.burns[-1].delta_v_m_s
    assert np.linalg.norm(found[3:] - turn @ reported[3:]) < 1e-3


def test_displays_tell_of_ephemerides(mission: Mission) -> None:
    """The chart of costs, the card and the report say what the plan was refined onto."""
    _, _, refined = mission
    shown = {one.name: list(one.y) for one in costs_chart(mission.plan, refined).series}
    assert shown == {
        "planned": [leg.delta_v_m_s for leg in mission.plan.legs],
        "burns": [leg.burns_delta_v_m_s for leg in mission.plan.legs],
        "burns onto ephemerides": [leg.retargeted_delta_v_m_s for leg in refined.legs],
        "refined onto ephemerides": [leg.flown_delta_v_m_s for leg in refined.legs],
    }
    assert "where ephemerides have the bodies" in costs_note(mission.plan, refined)
    assert "onto ephemerides" in repr(refined)
    page = section(mission.instance, None, refined, fly_refined(mission.instance, refined))
    assert "Holding beside the bodies" in page
    assert not complaints(mission.instance, refined, fly_refined(mission.instance, refined))


@cache
def iridium(folder: Path) -> Instance:
    """The 60 objects of Iridium 33 with the nearest planes, for a week."""
    (path,) = DATA.glob("tle/*iridium-33*")
    made = catalogue.to_instance(
        catalogue.read(path, skip_bad=True),
        max_targets=60,
        skip_bad=True,
        mission=catalogue.MissionOutline(duration_s=7.0 * DAY_S),
    )
    with_ephemerides(made, folder / "my.json").write(folder / "my.json")
    return adr_opt.load(folder / "my.json")


@pytest.mark.slow
@pytest.mark.external
@pytest.mark.skipif(not DATA.is_dir(), reason=f"no folder {DATA} (ADR_OPT_EXTERNAL_DATA)")
def test_iridium_33_is_met_where_sgp4_says(tmp_path: Path) -> None:
    """All legs of a week are refined, within 10 m and 1 cm/s of SGP4's states, 30 in a minute."""
    instance = iridium(tmp_path)
    plan = adr_opt.solve(instance, "beam", time_limit=120.0).plan
    assert plan is not None
    began = time.process_time()
    refined = adr_opt.refine(instance, plan, ephemerides=True, jobs=1)
    assert (time.process_time() - began) * 30.0 / len(plan.legs) < 60.0
    assert len(refined.legs) == len(plan.legs) >= 20
    assert refined.flown_delta_v_m_s < plan.delta_v_m_s
    assert_begins_and_ends_on_sgp4(instance, refined, 10.0, 1e-2)
    assert fly_refined(instance, refined).holds
