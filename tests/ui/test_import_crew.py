"""``import`` with launches, tanks by mass, kits, and what is asked of single objects."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from catalogue_files import field

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.plan.cargo import loads_of
from adr_opt.plan.kit_sizes import disposal_m_s
from adr_opt.problem.chasers import Expense, Tank, TankByMass
from adr_opt.problem.disposal import DisposalCircle, DisposalPerigee
from adr_opt.sources import catalogue

pytest.importorskip("sgp4.io")

RECORDS = field(12)
MASSES = ("--dry-mass", "500", "--propellant", "100", "--isp", "300")


def test_launches_tanks_and_kits_reach_the_instance(imported) -> None:
    """Chasers are launched at intervals with tanks by mass, and each target takes a kit."""
    outcome = imported(
        "--duration-days",
        "1461",
        "--no-refuelling",
        "--launches",
        "3",
        "--launch-every",
        "400",
        *MASSES,
        "--kits",
        "5",
        "--kit-mass",
        "40",
    )
    assert outcome.status == 0, outcome
    assert "start at the first target of each chaser; left out: nothing\n" in outcome.err
    assert "3 launches, on day 0, 400, 800\n" in outcome.err
    instance = adr_opt.load("out.json")
    assert instance.stations == ()
    assert [chaser.name for chaser in instance.chasers] == ["chaser-1", "chaser-2", "chaser-3"]
    for number, chaser in enumerate(instance.chasers):
        assert chaser.is_launched
        assert chaser.available_s == (400.0 * DAY_S * number, None)
        assert chaser.tank == TankByMass(dry_mass_kg=500.0, propellant_kg=100.0, isp_s=300.0)
        assert (chaser.kits, chaser.kit_mass_kg) == (5, 40.0)
        assert loads_of(instance, chaser, 0.0) is not None
    assert {target.removal for target in instance.targets} == {"kit"}


def test_expenses_and_separate_launches_reach_the_instance(imported) -> None:
    """Each chaser takes what is said, plans are to take little, and launches lie apart."""
    outcome = imported(
        "--no-refuelling",
        "--launches",
        "3",
        "--launch-separation",
        "2",
        *MASSES,
        "--expense",
        "55,0,2e-6",
    )
    assert outcome.status == 0, outcome
    assert "3 launches, on day 0, 2, 4\n" in outcome.err
    instance = adr_opt.load("out.json")
    assert instance.objective.cost == "expense"
    assert instance.mission.launch_separation_s == 2 * DAY_S
    for chaser in instance.chasers:
        assert chaser.available_s == (0.0, None)
        assert chaser.priced == Expense(fixed=55.0, per_kg_squared=2e-6)
    assert imported("--expense", "3").status == 0
    assert adr_opt.load("out.json").chaser.priced == Expense(fixed=3.0)


def test_chasers_may_share_a_rocket(imported) -> None:
    """No time between launches puts all chasers on one, which a campaign is planned with."""
    assert imported("--launches", "2", "--launch-every", "0").status == 0
    instance = adr_opt.load("out.json")
    assert [chaser.available_s for chaser in instance.chasers] == [(0.0, None)] * 2
    assert instance.mission.launch_separation_s is None
    result = adr_opt.solve(instance, "greedy-guarded")
    assert adr_opt.check(instance, result.plan) == ()
    first, second = (route.legs[0] for route in result.plan.routes)
    assert first.arrival_s == second.arrival_s == 0.0
    assert first.destination != second.destination


def test_services_take_the_days_that_are_said(imported) -> None:
    """Each service of a plan takes so long; without the option it is a revolution of the target."""
    assert imported("--service-days", "0.25", "--delta-v", "6000").status == 0
    instance = adr_opt.load("out.json")
    assert instance.mission.service_s == 0.25 * DAY_S
    assert instance.mission.service_revolutions is None
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    services = [leg for leg in plan.legs if leg.destination not in instance.station_names]
    assert services
    for leg in services:
        assert leg.end_s - leg.arrival_s == pytest.approx(0.25 * DAY_S)
    assert imported("--service-days", "0").status == 0
    assert adr_opt.load("out.json").mission.service_s == 0.0
    assert imported().status == 0
    assert adr_opt.load("out.json").mission.service_revolutions == 1.0


def test_each_option_stands_for_itself(imported) -> None:
    """Launches keep the station, and kits or masses need no launches."""
    assert imported("--launches", "2", "--launch-every", "2").status == 0
    instance = adr_opt.load("out.json")
    assert len(instance.stations) == 1
    assert [chaser.available_s[0] / DAY_S for chaser in instance.chasers] == [0.0, 2.0]
    assert {chaser.tank for chaser in instance.chasers} == {Tank(delta_v_m_s=3000.0)}
    assert {target.removal for target in instance.targets} == {"visit"}
    assert imported("--kits", "2", "--delta-v", "900").status == 0
    chaser = adr_opt.load("out.json").chaser
    assert (chaser.start_name, chaser.kits) == ("station", 2)
    assert chaser.tank == Tank(delta_v_m_s=900.0)
    assert imported(*MASSES).status == 0
    assert adr_opt.load("out.json").chaser.kits is None


def test_launches_into_orbits_reach_the_instance(imported) -> None:
    """All chasers are launched into one circle, by a launcher that lifts so much."""
    called = "--launches", "2", "--launch-every", "1", "--no-refuelling", *MASSES
    lifted = "--launch-into", "500,97.5", "--launcher", "300=900,700=500"
    outcome = imported(*called, *lifted)
    assert outcome.status == 0, outcome
    assert "2 launches, on day 0, 1\n" in outcome.err
    for chaser in adr_opt.load("out.json").chasers:
        assert (chaser.launch.altitude_m, chaser.launch.inclination_deg) == (500e3, 97.5)
        assert chaser.most_kg == pytest.approx(700.0)
    for wrong, said in (
        (("--launch-into", "500"), "ALTITUDE_KM,INCLINATION"),
        (("--launch-into", "500,200"), "180"),
        (("--launch-into", "800,97.5", *lifted[2:]), "given from"),
        (lifted[2:], "give --launch-into"),
    ):
        outcome = imported(*called, *wrong)
        assert outcome.status == 2
        assert said in outcome.err


def test_tows_reach_the_instance(imported) -> None:
    """Each target has the mass that is said, and is towed down to the circle or the perigee."""
    for option, disposal in (
        ("--disposal-altitude", DisposalCircle(circle_m=450.5e3)),
        ("--disposal-perigee", DisposalPerigee(perigee_m=450.5e3)),
    ):
        rules = "--max-lifetime", "25", "--max-uncontrolled", "500", "--end-of-life", "120"
        outcome = imported(*MASSES, "--tow", "900", option, "450.5", *rules)
        assert outcome.status == 0, outcome
        instance = adr_opt.load("out.json")
        assert instance.mission.disposal == disposal
        assert instance.mission.max_lifetime_years == 25.0
        assert instance.mission.max_uncontrolled_kg == 500.0
        assert {chaser.end_of_life_m_s for chaser in instance.chasers} == {120.0}
        assert {(target.removal, target.mass_kg) for target in instance.targets} == {("tow", 900.0)}
        assert loads_of(instance, instance.chaser, 0.0) is not None


def test_kits_are_sized_by_what_they_lead_to(imported) -> None:
    """Each target has the disposal, and kits hold the propellant of the one that takes most."""
    rows = [f"{record.number},{300 + 10 * at}" for at, record in enumerate(RECORDS)]
    Path("m.csv").write_text("\n".join(["object,mass", *rows]) + "\n")
    kits = "--kits", "3", "--kit-mass", "20", "--kit-isp", "220", "--disposal-perigee", "50"
    outcome = imported(*MASSES, *kits, "--prizes", "m.csv", "--max-lifetime", "25")
    assert outcome.status == 0, outcome
    instance = adr_opt.load("out.json")
    assert instance.mission.disposal is None
    assert {target.disposal for target in instance.targets} == {DisposalPerigee(perigee_m=50e3)}
    needs = [
        (target.mass_kg + 20.0) * math.expm1(disposal_m_s(target) / (220.0 * 9.80665))
        for target in instance.targets
    ]
    assert instance.chaser.kit_mass_kg == pytest.approx(20.0 + max(needs))
    assert imported(*MASSES, *kits).err.endswith(
        "its mass_kg is unknown, but sizes its kit; give it\n"
    )


def test_a_distance_to_keep_reaches_the_instance(imported) -> None:
    """``--keep-out`` is that of a safety ellipse, and of nothing else."""
    assert imported("--approach", "safety-ellipse", "--keep-out", "150").status == 0
    assert adr_opt.load("out.json").transfer.kept_out_m == 150.0


def test_deadlines_and_requirements_reach_their_objects(imported) -> None:
    """A deadline closes the window of the object that is meant; a required one has to be done."""
    first, second = RECORDS[3], RECORDS[7]
    outcome = imported(
        "--deadline",
        f"{first.number}=2.5",
        "--deadline",
        f"{second.label}=4",
        "--require",
        second.object_id,
        "--json",
    )
    assert outcome.status == 0, outcome
    assert json.loads(outcome.out)["chasers"] == ["chaser"]
    targets = {target.name: target for target in adr_opt.load("out.json").targets}
    windows = {name: target.window_s for name, target in targets.items()}
    assert windows.pop(first.label) == (0.0, 2.5 * DAY_S)
    assert windows.pop(second.label) == (0.0, 4.0 * DAY_S)
    assert set(windows.values()) == {(0.0, None)}
    assert [name for name, target in targets.items() if target.required] == [second.label]


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (("--launches", "0"), "--launches = 0"),
        (("--launch-every", "9"), "--launch-every: nothing is launched"),
        (("--launches", "2"), "launch 2 is on day 365, and the mission ends on day 7"),
        (("--launches", "2", "--launch-every", "nan"), "--launch-every = nan"),
        (("--launches", "2", "--launch-every", "-1"), "--launch-every = -1: must be"),
        (("--service-days", "-1"), "--service-days = -1: must be a finite number of at least 0"),
        (("--service-days", "nan"), "--service-days = nan"),
        (("--launch-separation", "9"), "--launch-separation: nothing is launched"),
        (("--launches", "3", "--launch-separation", "4"), "launch 3 is on day 8"),
        (("--expense", "much"), "--expense 'much': give one to three numbers"),
        (("--expense", "1,2,3,4"), "give one to three numbers"),
        (("--expense", "-1"), "--expense '-1': "),
        (("--expense", "1,2"), "--expense: the tank is given in ΔV, without masses"),
        (("--kits", "-1"), "--kits = -1"),
        (("--kit-isp", "220"), "--kit-isp: there are no kits"),
        (("--kits", "3", "--kit-isp", "220"), "--kit-isp: no disposal orbit"),
        (("--kit-mass", "3"), "--kit-mass: there are no kits"),
        (("--tow", "0"), "--tow = 0"),
        (("--tow", "900"), "--tow: no disposal orbit"),
        (("--tow", "900", "--disposal-altitude", "500"), "without masses"),
        (("--tow", "9", "--disposal-altitude", "500", "--kits", "3"), "takes a kit or is towed"),
        (("--disposal-altitude", "500"), "nothing is towed"),
        (("--disposal-perigee", "50"), "--disposal-perigee: nothing is towed"),
        (("--max-lifetime", "25"), "--max-lifetime: nothing is towed"),
        (("--max-uncontrolled", "25"), "--max-uncontrolled: nothing is towed"),
        (("--max-uncontrolled", "-1"), "--max-uncontrolled = -1: must be a finite number"),
        (("--end-of-life", "0"), "--end-of-life = 0: must be a positive number"),
        (("--end-of-life", "4000"), "--end-of-life (end_of_life_m_s = 4000.0): the tank has"),
        (
            (*MASSES, "--tow", "9", "--disposal-altitude", "500", "--disposal-perigee", "50"),
            "leave --disposal-altitude out",
        ),
        (
            (*MASSES, "--tow", "9", "--disposal-perigee", "50", "--max-lifetime", "1e3"),
            "--max-lifetime (max_lifetime_years = 1000.0): must be less",
        ),
        (("--keep-out", "500"), "--keep-out (keep_out_m = 500.0): half laps have none"),
        (("--kits", "3", "--kit-mass", "3"), "without masses"),
        (("--dry-mass", "3"), "give all three"),
        ((*MASSES, "--delta-v", "3"), "--delta-v: the tank is given by its mass"),
        ((*MASSES[:4], "--isp", "1e9"), "isp_s"),
        ((*MASSES[:4], "--isp", "inf"), "--isp = inf"),
        (("--delta-v", "0"), "--delta-v = 0"),
        (("--deadline", "90001"), "give an object and days"),
        (("--deadline", "=5"), "give an object and days"),
        (("--deadline", "90001=soon"), "give an object and days"),
        (("--deadline", "90001=-3"), "must be after day 0"),
        (("--deadline", "90001=nan"), "must be after day 0"),
        (("--deadline", "77=3"), "no object has this number or name"),
        (("--deadline", "=", "--quiet"), "give an object and days"),
        (("--require", "nobody"), "no object has this number or name"),
        (("--require", ""), "--require ''"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(imported, options, named) -> None:
    """Options that are out of range, alone or unused: exit 2, one sentence, nothing written."""
    outcome = imported(*options)
    assert (outcome.status, outcome.out) == (2, ""), outcome
    assert outcome.err.count("\n") == 1, outcome.err
    assert named in outcome.err
    assert not Path("out.json").exists()


def test_an_object_is_meant_once_and_is_a_target(imported) -> None:
    """Two deadlines of one object, by any of its names, and objects left out are refused."""
    record = RECORDS[0]
    for options, named in (
        (("--deadline", f"{record.number}=3", "--deadline", f"{record.number}=4"), "already"),
        (("--deadline", f"{record.number}=3", "--deadline", f"{record.label}=4"), "already"),
        (("--require", str(record.number), "--altitude", ":10"), "no object is left"),
        (("--require", str(record.number), "--name", RECORDS[1].label.split()[-1]), "left"),
        (
            ("--station", str(record.number), "--require", str(record.number)),
            "one that is a target",
        ),
    ):
        outcome = imported(*options)
        assert outcome.status == 2, options
        assert named in outcome.err, options


def test_a_crew_in_python() -> None:
    """What the options say is there in Python too, and is refused there as well."""
    crew = catalogue.Crew(launches=2, apart_s=DAY_S, kits=3)
    demands = catalogue.Demands({str(RECORDS[2].number): DAY_S})
    mission = catalogue.MissionOutline(refuelling=False)
    made = catalogue.to_instance(RECORDS, crew=crew, demands=demands, mission=mission)
    assert made.home is None
    assert made.to_dict()["start"] == {
        "name": "chaser-1",
        "from": "at the first target of each chaser",
        "orbit": None,
    }
    assert made.instance.targets[2].window_s == (0.0, DAY_S)
    for wrong in (
        lambda: catalogue.Crew(launches=-1),
        lambda: catalogue.Crew(apart_s=-1.0),
        lambda: catalogue.Crew(kit_mass_kg=1.0),
        lambda: catalogue.Crew(towed_kg=1.0),
        lambda: catalogue.Crew(towed_kg=1.0, disposal=DisposalCircle(circle_m=5e5)),
        lambda: catalogue.Crew(kits=1, towed_kg=1.0, disposal=DisposalCircle(circle_m=5e5)),
        lambda: catalogue.Demands({"x": 0.0}),
    ):
        with pytest.raises(adr_opt.InputError):
            wrong()
