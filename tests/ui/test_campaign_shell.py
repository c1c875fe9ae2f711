"""Campaigns around their planners: what is printed, flown and refined is told per chaser."""

from __future__ import annotations

import json
import math
import re

import pytest
from conftest import Cli, refused
from two_chasers import HOME, OWN, campaign, planned

import adr_opt
from adr_opt.fly.dispersion import sample_flights
from adr_opt.fly.flight import fly, fly_refined
from adr_opt.fly.refine.troubles import beginning
from adr_opt.plan.plan import Plan
from adr_opt.plan.refined_plan import RefinedPlan
from adr_opt.plan.routes import routes_of
from adr_opt.problem.instance import Instance


@pytest.fixture(scope="module", params=["two-body", "j2"])
def mission(request: pytest.FixtureRequest) -> tuple[Instance, Plan]:
    return campaign(request.param), planned(request.param)


@pytest.fixture(scope="module")
def refined(mission: tuple[Instance, Plan]) -> RefinedPlan:
    return adr_opt.refine(*mission)


def write(instance: Instance, plan: Plan | None = None) -> None:
    """The files that the command line is given."""
    with open("my.json", "w", encoding="utf-8") as file:
        file.write(instance.to_json())
    if plan is not None:
        plan.save("plan.json")


def test_legs_are_counted_through_all_routes(mission: tuple[Instance, Plan]) -> None:
    """Each leg is a chaser's, under its number in the plan; a chaser without a route has none."""
    instance, plan = mission
    numbers = {
        one.chaser.name: [number for number, _ in one.legs] for one in routes_of(instance, plan)
    }
    assert numbers == {HOME: [1, 2, 3], OWN: [4, 5, 6, 7]}
    alone = plan.replace(routes=plan.routes[1:])
    assert [(one.chaser.name, len(one.legs)) for one in routes_of(instance, alone)] == [
        (OWN, 4),
        (HOME, 0),
    ]


def test_a_route_of_nobody_is_refused_in_one_sentence(cli: Cli) -> None:
    """Whatever reads a plan names the chaser that is unknown, or has a route already."""
    instance, plan = campaign(), planned()
    for wrong, said in (("ghost", "is not a chaser"), (OWN, "more than one route")):
        routes = (plan.routes[0].replace(chaser=wrong), plan.routes[1])
        write(instance, plan.replace(routes=routes))
        for verb in (["fly"], ["refine", "--out", "r.json"], ["export", "--out", "a.czml"]):
            refused(cli(verb[0], "my.json", "plan.json", *verb[1:]), wrong, said)


def test_solve_tells_each_chaser_and_what_is_left_out(cli: Cli) -> None:
    """`solve` prints the legs, the tanks and the time of each chaser, and why targets are left."""
    instance = campaign()
    write(instance)
    outcome = cli("solve", "my.json", "--method", "exact", "--time-limit", 60, "--out", "p.json")
    assert outcome.status == 0, outcome.err
    plan = adr_opt.load_plan("p.json")
    lines = outcome.out.splitlines()
    home, own = (
        next(
            i
            for i, line in enumerate(lines)
            if line.startswith(f"{instance.name}: ") and line.rstrip().endswith(f": {name}")
        )
        for name in (HOME, OWN)
    )
    for number, leg in enumerate(plan.legs, start=1):
        at = next(i for i, line in enumerate(lines) if f"│   {number} │ {leg.origin} → " in line)
        assert (home < at < own) == (number <= 3)
        assert leg.destination in lines[at]
    told = {
        name: next(line for line in lines if line.startswith(f"{name}: ")) for name in (HOME, OWN)
    }
    assert told[HOME].count("tank ") == 1
    assert told[OWN].count("tank ") == 2
    used = plan.legs[5].delta_v_m_s + plan.legs[6].delta_v_m_s
    assert f"tank 2 {used:.1f} of 400 m/s in " in told[OWN]
    assert "visits 3, " in told[OWN]
    for left in plan.unvisited:
        assert any(
            line.startswith(f"left out, {left.reason} (") and left.target in line for line in lines
        )
    assert lines[-2].startswith("2 chasers, visits 6 of 8, ")
    assert lines[-1].startswith("flown in two-body motion: 7 short legs planned with ")
    assert re.search(r"left in each tank: \w+ [\d.]+; \w+ [\d.]+, [\d.]+ m/s$", lines[-1])
    json_outcome = cli("solve", "my.json", "--method", "exact", "--json", "--quiet")
    assert [route["chaser"] for route in json.loads(json_outcome.out)["routes"]] == [HOME, OWN]


def test_one_chaser_is_told_as_before(cli: Cli) -> None:
    """Where there is one chaser, `solve`, `fly` and `refine` name none, in words and in JSON."""
    instance = adr_opt.generate("tiny", 0).replace(dynamics="j2")
    write(instance)
    assert "chaser" not in cli("solve", "my.json", "--out", "plan.json", "--quiet").out
    assert "chaser" not in cli("fly", "my.json", "plan.json").out
    assert "chaser" not in cli("fly", "my.json", "plan.json", "--json").out
    assert "chaser" not in cli("refine", "my.json", "plan.json", "--out", "r.json").out
    told = adr_opt.load_refined("r.json").replace(planned=None)
    assert "chaser" not in told.to_json()
    assert "chaser" not in cli("fly", "my.json", "r.json", "--samples", 20, "--json").out


def test_a_flight_counts_the_tanks_of_each_chaser(mission: tuple[Instance, Plan]) -> None:
    """Every leg arrives, and is counted in the tank of the chaser that flies it."""
    instance, plan = mission
    flight = fly(instance, plan)
    assert flight.worst_miss_m < 1.0
    tanks = [
        (tank.chaser, tank.tank, tank.first_leg, tank.last_leg, tank.budget_m_s)
        for tank in flight.tanks
    ]
    assert tanks == [(HOME, 1, 1, 3, 500.0), (OWN, 1, 4, 5, 400.0), (OWN, 2, 6, 7, 400.0)]
    planned_m_s = {one.chaser: one.planned_delta_v_m_s for one in flight.chasers}
    for route in plan.routes:
        assert planned_m_s[route.chaser] == pytest.approx(sum(e.delta_v_m_s for e in route.legs))
    assert sum(planned_m_s.values()) == pytest.approx(plan.delta_v_m_s)


@pytest.mark.slow
def test_a_tank_that_breaks_names_its_chaser(cli: Cli) -> None:
    """On eccentric orbits some tank breaks: `fly` says whose, and its exit status is 1."""
    instance, plan = campaign(eccentricity=0.02), planned(eccentricity=0.02)
    assert adr_opt.check(instance, plan) == ()
    broken = fly(instance, plan).broken_tanks
    assert broken
    write(instance, plan)
    outcome = cli("fly", "my.json", "plan.json", "--out", "noted.json")
    assert outcome.status == 1
    for tank in broken:
        assert f"tank {tank.tank} of {tank.chaser!r} (leg" in outcome.out
        assert f"tank {tank.tank} of {tank.chaser!r}" in adr_opt.load_plan("noted.json").notes[-1]
    told = json.loads(cli("fly", "my.json", "plan.json", "--json").out)
    assert [chaser["chaser"] for chaser in told["chasers"]] == [HOME, OWN]
    assert any(not chaser["holds"] for chaser in told["chasers"])


def test_refined_legs_know_their_chaser(
    mission: tuple[Instance, Plan], refined: RefinedPlan
) -> None:
    """A refined campaign is complete and flies, each leg from the tank of its own chaser."""
    instance, _ = mission
    assert refined.status == "complete"
    assert [leg.chaser for leg in refined.legs] == 3 * [HOME] + 4 * [OWN]
    assert RefinedPlan.from_json(refined.to_json()) == refined
    flight = fly_refined(instance, refined)
    assert flight.holds
    assert [(tank.chaser, tank.first_leg, tank.last_leg) for tank in flight.tanks] == [
        (HOME, 1, 3),
        (OWN, 4, 5),
        (OWN, 6, 7),
    ]
    nobody = refined.replace(legs=tuple(leg.replace(chaser=None) for leg in refined.legs))
    with pytest.raises(adr_opt.InputError, match="leg 1: leg: chaser = None, but in the plan"):
        fly_refined(instance, nobody)


def test_errors_are_counted_tank_by_tank(
    mission: tuple[Instance, Plan], refined: RefinedPlan
) -> None:
    """Flights with errors take from each tank the sum of its own legs, flight by flight."""
    instance, _ = mission
    flown = sample_flights(instance, refined, 50)
    assert [(tank.chaser, tank.tank, tank.budget_m_s) for tank in flown.tanks] == [
        (HOME, 1, 500.0),
        (OWN, 1, 400.0),
        (OWN, 2, 400.0),
    ]
    for tank, rows in zip(flown.tanks, (slice(0, 3), slice(3, 5), slice(5, 7)), strict=True):
        spent = sorted(flown.leg_delta_v_m_s[rows].sum(axis=0))
        assert tank.delta_v_m_s.value == pytest.approx(spent[math.ceil(0.95 * 50) - 1])
    # The last leg of the first chaser ends with the mission, not before the second one leaves.
    assert flown.late_share == 0.0


def test_legs_of_a_chaser_follow_each_other() -> None:
    """What is refined is a chain for each chaser; one that is broken is named with its chaser."""
    instance, plan = campaign(), planned()
    home, own = plan.routes
    torn = own.replace(legs=own.legs[:1] + own.legs[2:])
    with pytest.raises(adr_opt.InputError, match="leg 5: chain: starts at 'station'"):
        adr_opt.refine(instance, plan.replace(routes=(home, torn)))


def test_each_chaser_keeps_the_beginning_that_holds(
    mission: tuple[Instance, Plan], refined: RefinedPlan
) -> None:
    """Where a chaser's tank breaks only its own route is cut, and what is left passes `check`."""
    instance, plan = mission
    from adr_opt.mission.problem import Problem

    last = refined.legs[2]
    burn = last.burns[0]
    worse = tuple(100.0 * part for part in burn.delta_v_m_s)
    spent = last.flown_delta_v_m_s + 99.0 * burn.size_m_s
    broken = last.replace(
        burns=(burn.replace(delta_v_m_s=worse), *last.burns[1:]), flown_delta_v_m_s=spent
    )
    assert spent > 500.0
    found = beginning(
        Problem(instance),
        plan,
        refined.replace(legs=(*refined.legs[:2], broken, *refined.legs[3:])),
    )
    assert found is not None
    shorter, kept = found
    assert adr_opt.check(instance, shorter) == ()
    assert [len(route.legs) for route in shorter.routes] == [2, 4]
    assert [(leg.leg, leg.chaser) for leg in kept.legs] == [
        *((number, HOME) for number in (1, 2)),
        *((number, OWN) for number in (3, 4, 5, 6)),
    ]
    assert fly_refined(instance, kept).holds


@pytest.mark.parametrize("dynamics", ["two-body", "j2"])
def test_a_campaign_is_planned_until_it_holds(dynamics: str) -> None:
    """On eccentric orbits, with the plan's own burns, a campaign is planned until it holds."""
    instance = campaign(dynamics, 0.02)
    found = adr_opt.solve_refined(
        instance, "exact", freedom="planned", time_limit=30.0, iterations=20
    )
    assert found.holds, found.reason
    assert len(found.rounds) > 1
    assert found.plan is not None
    assert found.refined is not None
    assert adr_opt.check(instance, found.plan) == ()
    assert fly_refined(instance, found.refined).holds
    assert [route.chaser for route in found.plan.routes] == [HOME, OWN]
    bodies = {name: number for number, name in enumerate(instance.names)}
    assert found.result.routes == tuple(
        tuple(bodies[leg.destination] for leg in route.legs) for route in found.plan.routes
    )


@pytest.mark.parametrize(
    "call",
    [
        *(
            ("matrix", "my.json", "--at", 0, "--out", f"m.{kind}")
            for kind in ("npz", "vrp", "oplib")
        ),
        *(("matrix", "my.json", "--out", f"m.{kind}") for kind in ("lp", "parquet")),
        ("solve", "my.json", "--method", "beam", "--quiet"),
        ("bound", "my.json", "--method", "lagrangian", "--quiet"),
    ],
)
def test_what_is_for_one_chaser_says_so(cli: Cli, call: tuple[object, ...]) -> None:
    """What does not know several chasers ends with one sentence that says so."""
    write(campaign())
    refused(cli(*call), "chasers", "only one")


def test_the_environment_is_for_one_chaser() -> None:
    """A campaign cannot be played; the sentence says why."""
    env = pytest.importorskip("adr_opt.learning.environment")
    with pytest.raises(adr_opt.InputError, match="2 chasers, but this works with one"):
        env.MissionEnv(campaign()).reset(seed=0)
