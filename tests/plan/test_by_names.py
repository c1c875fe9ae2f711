"""Orders of bodies are given by names or by numbers, wherever one gives them."""

from __future__ import annotations

import pytest
from hand_made import hand_made
from two_chasers import HOME, OWN, campaign, planned

import adr_opt
from adr_opt.analysis import price
from adr_opt.common.errors import InputError
from adr_opt.mission.certified import certify
from adr_opt.mission.order_repair import as_it_is, mended

OPTIMAL = ("south", "station", "north", "beyond")


def test_orders_of_one_chaser_are_given_by_names_or_numbers() -> None:
    """Both come to the same plan, at every door."""
    instance = hand_made()
    mission = adr_opt.Mission(instance)
    numbers = [instance.names.index(name) for name in OPTIMAL]
    assert mission.named(numbers) == mission.named(OPTIMAL) == OPTIMAL
    plan = price(instance, OPTIMAL).plan()
    for order in (numbers, [numbers], {instance.chaser.name: OPTIMAL}, plan):
        assert price(instance, order).plan().routes == plan.routes
    made = certify(mission, "by-hand", OPTIMAL, seed=0, runtime_s=0.0)
    assert made.plan.routes == plan.routes
    assert made.sequence == tuple(numbers)
    assert mission.closed((*OPTIMAL, "station")) == tuple(numbers)
    twice = (*OPTIMAL, "south")
    assert as_it_is(mission, twice) == OPTIMAL
    assert mended(mission, twice) == mission.named(mended(mission, [*numbers, numbers[0]]))
    assert instance.part({"south", "beyond"}) == instance.part({numbers[0], numbers[3]})
    assert adr_opt.solve(mission, "local-search", start=OPTIMAL, iterations=5).objective >= 3.0
    assert adr_opt.bound(mission, "exact", start=OPTIMAL, time_limit=60.0).upper_bound == 3.0


def test_orders_of_several_chasers_are_given_by_names_or_numbers() -> None:
    """A route for each chaser, by its name or in the order of the file, or a plan."""
    instance, plan = campaign(), planned()
    orders = plan.orders
    assert list(orders) == [HOME, OWN]
    numbers = [[instance.names.index(name) for name in order] for order in orders.values()]
    wanted = price(instance, orders)
    assert wanted.holds
    for asked in (plan, list(orders.values()), numbers):
        assert price(instance, asked).plan().routes == wanted.plan().routes


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda i: price(i, ["nowhere"]), "'nowhere' is not a body"),
        (lambda i: price(i, [99]), "99 is not a body"),
        (lambda i: price(i, [["south"], ["north"]]), "for each of 1 chaser"),
        (lambda i: price(i, {"nobody": ["south"]}), "'nobody' is not a chaser"),
        (lambda i: i.part(["nowhere"]), "'nowhere' is not a body"),
        (lambda i: adr_opt.Mission(i).closed(["nowhere"]), "'nowhere' is not a body"),
        (lambda i: adr_opt.check(i, OPTIMAL), "check judges a plan"),
    ],
)
def test_what_names_nothing_is_refused(call, said: str) -> None:
    """An order of bodies that are not there, or of too many chasers, is refused in a sentence."""
    with pytest.raises(InputError, match=said) as error:
        call(hand_made())
    assert "\n" not in str(error.value)


def test_one_timetable_serves_all_tanks_and_shorter_missions() -> None:
    """Limits are changed on what is built, and what is planned and proven is as if built anew."""
    instance = adr_opt.generate("tiny", 3, targets=6)
    mission = adr_opt.Mission(instance, margin=0.1)
    longest_s = instance.mission.duration_s
    assert mission.timetable is mission.with_limits(delta_v_m_s=400.0).timetable
    half = mission.with_limits(longest_s / 2, 400.0)
    assert half.margin == 0.1
    assert half.timetable is mission.with_limits(longest_s / 2, 700.0).timetable
    assert half.timetable is half.with_limits(delta_v_m_s=500.0).timetable
    assert half.timetable is not mission.timetable
    for made in (mission.with_limits(delta_v_m_s=400.0), half):
        anew = adr_opt.Mission(
            instance.with_limits(made.instance.mission.duration_s, 400.0), margin=0.1
        )
        assert made.instance == anew.instance
        results = [adr_opt.solve(each, "exact", time_limit=30.0) for each in (made, anew)]
        assert results[0].status == results[1].status == "optimal"
        assert results[0].objective == results[1].objective
        assert adr_opt.check(made.instance, results[0].plan) == ()
    with pytest.raises(InputError, match="begin with the longest mission"):
        half.with_limits(longest_s)
    with pytest.raises(InputError, match="delta_v_m_s"):
        mission.with_limits(delta_v_m_s=-1.0)


def test_campaigns_have_their_limits_changed_too() -> None:
    """All chasers of a campaign get the same tank, over the connections that are known."""
    whole = adr_opt.mission.problem.Problem(campaign())
    small = whole.with_limits(delta_v_m_s=450.0)
    assert {chaser.tank.delta_v_m_s for chaser in small.instance.chasers} == {450.0}
    plan = adr_opt.solve(small, "greedy-guarded").plan
    assert adr_opt.check(small.instance, plan) == ()
