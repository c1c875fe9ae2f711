"""The price of time: days of chasers as part of the cost, of its bounds and of `check`."""

from __future__ import annotations

import csv
import json

import pytest
from against_enumeration import bound_of_cost
from brute_force import brute_force
from conftest import Cli, refused
from hand_made import hand_made
from two_chasers import campaign as two_chasers

import adr_opt
from adr_opt.analysis import Axis, frontier, tradeoff
from adr_opt.common.errors import InputError
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.plan.plan import FORMER_MODEL
from adr_opt.problem.chasers import TankByMass
from adr_opt.problem.given import of_rows
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import Objective


@pytest.mark.parametrize("dearer_first", [False, True])
def test_who_is_done_sooner_after_the_last_departure_is_not_overlooked(dearer_first):
    """Of two last legs the dearer one may cost less in the end, whichever of them leaves first.

    Nothing leaves any more once they have come, so that to proofs they land at the same time.
    """
    slow, quick = (100.0, 1000.0, 10.0), (200.0, 500.0, 20.0)
    if dearer_first:
        slow, quick = (200.0, 1000.0, 10.0), (100.0, 500.0, 20.0)
    field = adr_opt.generate("tiny", seed=0, targets=2)
    station, first, second = field.names
    legs = [(station, first, 0.0, 10.0, 1.0), *((first, second, *leg) for leg in (slow, quick))]
    columns = ("origin", "destination", "departure_s", "arrival_s", "delta_v_m_s")
    rows = {name: [leg[at] for leg in legs] for at, name in enumerate(columns)}
    given = of_rows(rows, field.names)
    instance = field.replace(
        mission=field.mission.replace(
            duration_s=5000.0, service_revolutions=None, service_s=0.0, refuel_revolutions=0.0
        ),
        objective=Objective(time_m_s_per_day=8640.0),
    ).with_given(given)
    bound, cost = bound_of_cost(Mission(instance), 20.0, slot_m_s=10.0)
    assert cost == pytest.approx(1.0 + 20.0 + 0.1 * 500.0, abs=1e-6)
    assert bound == pytest.approx(cost, rel=1e-5)


def tows() -> Instance:
    """Two rocket bodies to tow down in two years, with a large tank."""
    tank = TankByMass(dry_mass_kg=1000.0, propellant_kg=3000.0, isp_s=310.0)
    field = adr_opt.generate(
        "rocket-bodies", seed=0, towed_kg=1400.0, disposal={"circle_m": 350e3}, tank=tank
    )
    first = field.first_target
    return field.part([field.names[first + at] for at in (13, 16)])


def test_a_tow_campaign_does_not_loiter():
    """With the default price tows end months earlier, at no more ΔV than the resolution."""
    instance = tows()
    free = instance.replace(objective=Objective(time_m_s_per_day=0.0))
    usual, loitering = (
        adr_opt.solve(each, "auto", time_limit=60.0).plan for each in (instance, free)
    )
    assert adr_opt.check(instance, usual) == adr_opt.check(free, loitering) == ()
    assert usual.objective == loitering.objective == 2.0
    more = usual.delta_v_m_s - loitering.delta_v_m_s
    assert 0.0 <= more <= instance.transfer.delta_v_resolution_m_s
    assert usual.legs[-1].done_s < loitering.legs[-1].done_s - 100.0 * 86400.0


def test_the_default_is_a_resolution_over_the_mission():
    """What is not stated is neither in the file nor in its digest, and prices time all the same."""
    instance = adr_opt.generate("tiny", seed=0)
    assert "time_m_s_per_day" not in instance.to_json()
    days = instance.mission.duration_s / 86400.0
    price = instance.transfer.delta_v_resolution_m_s / days
    stated = instance.replace(objective=Objective(time_m_s_per_day=price))
    assert '"time_m_s_per_day"' in stated.to_json()
    assert stated.sha256 != instance.sha256
    assert Instance.from_json(stated.to_json()) == stated
    costs = {adr_opt.solve(each, "greedy-guarded").plan.cost for each in (instance, stated)}
    assert max(costs) == pytest.approx(min(costs), rel=1e-12)
    free = instance.replace(objective=Objective(time_m_s_per_day=0.0))
    order = adr_opt.solve(instance, "greedy-guarded").sequence
    with_price, without = Mission(instance).time(order), Mission(free).time(order)
    assert without.cost == without.delta_v
    assert with_price.cost == pytest.approx(
        with_price.delta_v + price * with_price.ends[-1] / 86400.0, rel=1e-12
    )
    assert with_price.cost < without.cost + price * without.ends[-1] / 86400.0 + 1e-9


def test_days_count_from_when_each_chaser_may_fly():
    """A chaser that comes late pays from then on, and one that does not fly pays nothing."""
    instance = two_chasers()
    first, second = instance.chasers
    since_s = 0.25 * instance.mission.duration_s
    late = second.replace(available_s=(since_s, None))
    instance = instance.replace(chasers=(first, late), objective=Objective(time_m_s_per_day=20.0))
    plan = adr_opt.solve(instance, "auto", time_limit=60.0).plan
    ends = {route.chaser: route.legs[-1].done_s for route in plan.routes if route.legs}
    assert set(ends) == {first.name, late.name}
    days = (ends[first.name] + ends[late.name] - since_s) / 86400.0
    assert plan.cost == pytest.approx(plan.delta_v_m_s + 20.0 * days, rel=1e-12)
    assert adr_opt.check(instance, plan) == ()
    alone = plan.replace(
        routes=tuple(
            route.replace(legs=()) if route.chaser == late.name else route for route in plan.routes
        )
    )
    kept = [leg for route in alone.routes for leg in route.legs]
    alone = alone.replace(cost=sum(leg.spent_m_s for leg in kept) + 20.0 * ends[first.name] / 86400)
    assert "cost" not in {violation.rule for violation in adr_opt.check(instance, alone)}


def test_check_counts_the_days():
    """`check` refuses a cost without its days; plans of the former model had none by default."""
    instance = adr_opt.generate("tiny", seed=0).replace(objective=Objective(time_m_s_per_day=1.0))
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert adr_opt.check(instance, plan) == ()
    without = plan.replace(cost=plan.delta_v_m_s)
    assert {violation.rule for violation in adr_opt.check(instance, without)} == {"cost"}
    usual = adr_opt.generate("tiny", seed=0)
    plan = adr_opt.solve(usual, "greedy-guarded").plan
    without = plan.replace(cost=plan.delta_v_m_s)
    assert {violation.rule for violation in adr_opt.check(usual, without)} == {"cost"}
    assert adr_opt.check(usual, without.replace(model=FORMER_MODEL)) == ()


@pytest.mark.parametrize("cost", ["duration", "expense"])
def test_only_delta_v_has_a_price_of_time(cost):
    """Where the end or the expense counts, a price of days is refused, and 0 as well."""
    for price in (0.0, 1.0):
        with pytest.raises((InputError, ValueError), match="days are paid for where cost"):
            Objective(cost=cost, time_m_s_per_day=price)
    assert (
        adr_opt.generate("tiny", seed=0)
        .replace(objective=Objective(cost="duration"))
        .time_m_s_per_s
        == 0.0
    )


def test_a_frontier_has_the_least_delta_v_of_each_last_day():
    """For each last day no shorter mission takes less, at the same prize, by enumeration."""
    instance = adr_opt.generate("tiny", seed=2, targets=4)
    made = tradeoff(instance, [Axis("duration", (instance.mission.duration_s,))], time_limit=60.0)
    endings = frontier(made, time_limit=60.0)
    assert len(endings) > 3
    days, spent = [e.last_s for e in endings], [e.delta_v_m_s for e in endings]
    assert sorted(days) == days
    assert sorted(spent, reverse=True) == spent
    ends = brute_force(Mission(instance.replace(objective=Objective(time_m_s_per_day=0.0))))
    assert (endings[-1].prize, endings[-1].delta_v_m_s) == pytest.approx(ends[:2], abs=1e-6)
    for ending in endings:
        shorter = instance.replace(
            mission=instance.mission.replace(duration_s=ending.last_s),
            objective=Objective(time_m_s_per_day=0.0),
        )
        mission = Mission(shorter)
        timed = mission.time(ending.routes[0])
        assert timed.made == len(ending.routes[0])
        assert timed.delta_v == pytest.approx(ending.delta_v_m_s, abs=1e-6)
        assert timed.ends[-1] == pytest.approx(ending.last_s, abs=1e-3)
        price = instance.time_m_s_per_s * ending.last_s
        assert ending.cost == pytest.approx(ending.delta_v_m_s + price, rel=1e-12)
    usual = Mission(instance).time(endings[-1].routes[0])
    assert min(ending.cost for ending in endings) <= usual.cost + 1e-9


def test_a_frontier_of_several_chasers_adds_what_each_takes_by_then():
    """On the frontier of a campaign every chaser is done by the last day, at its least ΔV."""
    whole = two_chasers()
    instance = whole.part([f"debris-00{number}" for number in (3, 4, 5, 6, 8)])
    axes = [Axis("duration", (instance.mission.duration_s,))]
    endings = frontier(tradeoff(instance, axes, time_limit=60.0), time_limit=60.0)
    assert len(endings) > 2
    assert all(all(ending.routes) for ending in endings)
    for ending in endings:
        campaign = Problem(
            instance.replace(
                mission=instance.mission.replace(duration_s=ending.last_s),
                objective=Objective(time_m_s_per_day=0.0),
            )
        )
        timed = [
            mission.time(route)
            for mission, route in zip(campaign.missions, ending.routes, strict=True)
        ]
        assert [each.made for each in timed] == [len(route) for route in ending.routes]
        assert sum(each.delta_v for each in timed) == pytest.approx(ending.delta_v_m_s, abs=1e-6)


def test_the_verb_writes_the_frontier(cli: Cli, tmp_path) -> None:
    """CSV, page and JSON have the same last days; what has no frontier is refused in a sentence."""
    hand_made().save("instance.json")
    outcome = cli(
        "tradeoff instance.json --frontier front.csv --page front.html --time-limit 10 --json"
    )
    assert outcome.status == 0, outcome.err
    stated = json.loads(outcome.out)["frontier"]
    with open("front.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(stated) >= 1
    for row, ending in zip(rows, stated, strict=True):
        assert float(row["last_day"]) * 86400.0 == pytest.approx(ending["last_s"])
        assert float(row["delta_v_m_s"]) == ending["delta_v_m_s"]
        assert json.loads(row["routes"]) == ending["routes"]
    with open("front.html", encoding="utf-8") as file:
        assert file.read().count("Least ΔV against the last day") >= 2
    hand_made().replace(objective=Objective(cost="duration")).save("ends.json")
    refused(cli("tradeoff", "ends.json", "--frontier", "front.csv"), "objective.cost")
    refused(cli("tradeoff", "instance.json"), "nothing is varied")
