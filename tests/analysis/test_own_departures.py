"""A plan of one's own departures: what `check` accepts, or a sentence that says why not."""

from __future__ import annotations

import pytest

import adr_opt
from adr_opt import plan_of
from adr_opt.common.errors import InputError
from adr_opt.mission.mission import Mission
from adr_opt.problem.chasers import AtStation

DAY_S = 86400.0


def legs_of(plan, *, arrivals=True):
    """The legs of each chaser as `plan_of` takes them."""
    return {
        route.chaser: [
            (leg.destination, leg.departure_s, leg.arrival_s)[: 3 if arrivals else 2]
            for leg in route.legs
        ]
        for route in plan.routes
    }


def same(made, plan):
    """Whether two plans fly the same legs, and leave out the same targets for the same reasons."""
    assert made.routes == plan.routes
    assert (made.objective, made.cost, made.unvisited) == (
        plan.objective,
        plan.cost,
        plan.unvisited,
    )


FIELDS = {
    "two-body": lambda: adr_opt.generate("tiny", 0),
    "refuelled": lambda: adr_opt.generate("reduced-fuel", 0, targets=14),
    "zones": lambda: adr_opt.generate("tiny", 3, zones=4),
    "drifting": lambda: adr_opt.generate("sso", 0, targets=5).with_limits(duration_s=30 * DAY_S),
    "launched": lambda: adr_opt.generate("removal", 0, targets=6, chasers=2),
    "campaign": lambda: adr_opt.generate("campaign", 0, targets=12),
    "towed": lambda: adr_opt.generate(
        "tiny",
        0,
        towed_kg=200.0,
        disposal={"circle_m": 400e3},
        tank={"dry_mass_kg": 800.0, "propellant_kg": 2000.0, "isp_s": 310.0},
    ),
}


@pytest.mark.parametrize("field", FIELDS)
def test_the_departures_of_a_plan_give_it_again(field: str) -> None:
    """Legs, burns, tows, tanks and reasons of a plan follow from its departures and arrivals."""
    instance = FIELDS[field]()
    plan = adr_opt.solve(instance, "auto", time_limit=2.0).plan
    assert plan.legs
    made = plan_of(instance, legs_of(plan))
    same(made, plan)
    same(plan_of(instance, legs_of(plan, arrivals=False)), plan)
    assert adr_opt.check(instance, made) == ()
    assert (made.method, made.status) == (
        "own departures",
        "feasible" if made.unvisited else "optimal",
    )


def test_any_connection_may_be_taken_and_waiting_is_flown() -> None:
    """Rows of a pair make legs at their own times, the chaser waiting until they depart."""
    instance = adr_opt.generate("tiny", 0)
    mission = Mission(instance)
    found = mission.timetable.connections("station", "debris-003")
    for row in range(0, found.departure.size, max(1, found.departure.size // 12)):
        departure, arrival = float(found.departure[row]), float(found.arrival[row])
        ends = arrival + mission.rules.service[mission.timetable.index("debris-003")]
        if found.delta_v[row] > instance.chaser.tank.delta_v_m_s or ends > 1.5 * DAY_S:
            continue
        plan = plan_of(mission, [("debris-003", departure, arrival)])
        (leg,) = plan.legs
        assert (leg.departure_s, leg.arrival_s) == pytest.approx((departure, arrival))
        assert leg.delta_v_m_s == pytest.approx(found.delta_v[row])
        assert adr_opt.check(instance, plan) == ()
        in_time = found.arrival + ends - arrival <= 1.5 * DAY_S
        cheapest = found.delta_v[(abs(found.departure - departure) < 1.0) & in_time].min()
        (leg,) = plan_of(mission, [("debris-003", departure)]).legs
        assert leg.delta_v_m_s == pytest.approx(cheapest)


def test_what_lookup_tells_is_a_leg() -> None:
    """A planner that asks `lookup` when it is ready hands on that time and the arrival."""
    instance = adr_opt.generate("tiny", 5)
    mission = Mission(instance)
    legs, time, body, left = [], 0.0, "station", instance.chaser.tank.delta_v_m_s
    for name in mission.names[1:]:
        delta_v, arrival = mission.timetable.lookup(body, name, time)
        end = arrival + mission.rules.service[mission.timetable.index(name)]
        if delta_v > left or end > instance.mission.duration_s:
            continue
        legs.append((name, time, arrival))
        time, body, left = end, name, left - delta_v
    assert len(legs) > 1
    plan = plan_of(instance, legs)
    assert [leg.arrival_s for leg in plan.legs] == pytest.approx([each[-1] for each in legs])
    assert plan.legs[-1].delta_v_left_m_s == pytest.approx(left)


def test_what_is_left_open_is_flown_at_least_cost() -> None:
    """Bodies alone are an order at its best, and a time that is given restricts that leg alone."""
    instance = adr_opt.generate("tiny", 0)
    best = adr_opt.solve(instance, "exact").plan
    order = list(best.destinations)
    same(plan_of(instance, order), best)
    found = Mission(instance).timetable.connections("station", order[0])
    later = float(found.departure[found.departure > best.legs[0].departure_s + 1.0][0])
    plan = plan_of(instance, [(order[0], later), *order[1:]])
    assert plan.legs[0].departure_s == later
    assert plan.destinations == best.destinations
    assert plan.cost > best.cost


def test_a_way_back_is_added_and_a_last_refuelling_left_out() -> None:
    """Plans end as all plans do: at the station where they must, and without a needless stop."""
    instance = adr_opt.generate("tiny", 0)
    bound = instance.replace(chasers=(instance.chaser.replace(end=AtStation(station="station")),))
    there_and_back = plan_of(bound, ["debris-003"])
    assert there_and_back.destinations == ("debris-003", "station")
    leg = there_and_back.legs[0]
    plan = plan_of(instance, [("debris-003", leg.departure_s, leg.arrival_s), "station"])
    assert plan.legs == (leg,)
    cheapest = plan_of(instance, ["debris-003"]).legs[0]
    said = refused(instance, [("debris-003", cheapest.departure_s, cheapest.arrival_s), "station"])
    assert said.startswith(
        "leg 2, to 'station', has no connection that is in time and takes no more"
    )


def refused(instance, legs) -> str:
    with pytest.raises(InputError) as raised:
        plan_of(instance, legs)
    assert "\n" not in str(raised.value)
    return str(raised.value)


def test_what_is_wrong_is_one_sentence() -> None:
    """Each mistake is named with the leg and the numbers that tell how far off it is."""
    instance = adr_opt.generate("tiny", 0)
    plan = adr_opt.solve(instance, "exact").plan
    first, second, *_ = (leg for route in legs_of(plan).values() for leg in route)
    departs, arrives = first[1:]
    named = f"'{first[0]}'"
    assert (
        refused(instance, [(first[0], departs + 60.0)])
        == f"leg 1, from 'station' to {named}: no connection departs at {departs + 60.0:.10g} s; "
        f"the nearest one departs at {departs:.10g} s"
    )
    said = refused(instance, [(first[0], departs, arrives + 30.0)])
    assert f"no connection arrives at {arrives + 30.0:.10g} s and departs at" in said
    assert f"the nearest one arrives at {arrives:.10g} s" in said
    there = Mission(instance).timetable.connections(first[0], second[0])
    early = there.departure[there.departure < arrives][-1]
    said = refused(instance, [first, (second[0], early)])
    assert f"leg 2, to '{second[0]}', departs at {early:.10g} s, but the chaser is free at" in said
    late = there.departure.argmax()
    said = refused(instance, [first, (second[0], there.departure[late], there.arrival[late])])
    assert "ends at" in said
    said = refused(instance.with_limits(delta_v_m_s=20.0), [first])
    assert said.startswith(f"leg 1, to {named}, needs ")
    assert said.endswith(" m/s, but only 20 m/s are left")
    assert "which was visited before" in refused(instance, [first, second, first])
    assert "no target was visited since" in refused(instance, [("station", 0.0)])
    assert "'debris-999' is not a body of" in refused(instance, [("debris-999", 0.0)])
    assert "'nobody' is not a chaser of 'tiny-000'" in refused(instance, {"nobody": [first]})


@pytest.mark.parametrize(
    "leg",
    [
        ("debris-001", -1.0),
        ("debris-001", float("nan")),
        ("debris-001", "soon"),
        1.5,
        ("debris-001", 0.0, 1.0, 2.0),
        (),
        None,
    ],
)
def test_what_is_no_leg_is_refused(leg) -> None:
    """A leg of another form is answered with the forms that there are."""
    said = refused(adr_opt.generate("tiny", 0), [leg])
    assert said.startswith(f"leg {leg!r}: give (body, departure) or")


def test_rules_of_the_whole_plan_are_said_too() -> None:
    """Required targets, targets of two chasers and tanks of stations are looked at in the end."""
    instance = adr_opt.generate("tiny", 0)
    *others, last = instance.targets
    lacking = instance.replace(targets=(*others, last.replace(required=True)))
    assert f"the best attempt misses '{last.name}'" in refused(lacking, ["debris-003"])
    pair = adr_opt.generate("tiny", 0, chasers=2)
    twice = [["debris-003"], ["debris-003"]]
    assert "'debris-003' is visited twice" in refused(pair, twice)
    assert "a list of legs for each of 2 chasers" in refused(pair, ["debris-003"])
    plan = plan_of(pair, [["debris-003"], ["debris-004"]])
    assert [route.legs[0].destination for route in plan.routes] == ["debris-003", "debris-004"]


def test_stations_that_run_empty_are_judged() -> None:
    """More refuellings than a station has are a sentence, and not a plan."""
    field = adr_opt.generate("reduced-fuel", 0, targets=14)
    plan = adr_opt.solve(field, "beam").plan
    refuellings = sum(leg.destination == "station" for leg in plan.legs)
    assert refuellings > 0
    short = field.replace(stations=(field.stations[0].replace(max_refuellings=refuellings - 1),))
    assert "refuel" in refused(short, legs_of(plan))


def test_a_launch_is_at_the_time_that_is_stated() -> None:
    """A chaser may be launched later than it could, and neither sooner nor with a flight."""
    instance = adr_opt.generate("removal", 0, targets=4)
    first, second = (chaser.name for chaser in instance.chasers[:2])
    opens_s, target = instance.available_s[1][0], instance.targets[0].name
    later_s = opens_s + 86400.0
    for leg in ((target, later_s), (target, later_s, later_s)):
        plan = adr_opt.plan_of(instance, {second: [leg]})
        assert [(each.departure_s, each.arrival_s) for each in plan.legs] == [(later_s, later_s)]
        assert adr_opt.check(instance, plan) == ()
    for leg, said in (
        ((target, opens_s - 60.0), "may not before"),
        ((target, later_s, later_s + 60.0), "a launch takes no time"),
    ):
        with pytest.raises(InputError, match=said):
            adr_opt.plan_of(instance, {second: [leg]})
    assert adr_opt.plan_of(instance, {first: [target]}).legs[0].departure_s == 0.0
