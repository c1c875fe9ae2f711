"""`check` finds what is wrong: every kind of tampering with a good plan is reported."""

from __future__ import annotations

import every_sequence
import judge
import pytest
from hand_made import OPTIMAL_PLAN, PERIOD_S, hand_made
from plans import with_legs

import adr_opt
from adr_opt.mission.certified import certify
from adr_opt.plan.expense import cost_of_routes
from adr_opt.plan.plan import Plan, Unvisited
from adr_opt.problem.settings import KeepOutZone


@pytest.fixture(scope="module")
def mission() -> adr_opt.Mission:
    return adr_opt.Mission(hand_made())


@pytest.fixture(scope="module")
def plan(mission) -> Plan:
    result = certify(mission, "by-hand", OPTIMAL_PLAN, seed=0, runtime_s=0.0)
    assert result.plan is not None
    return result.plan


def change_leg(plan: Plan, number: int, **changes) -> Plan:
    legs = list(plan.legs)
    legs[number] = legs[number].replace(**changes)
    return with_legs(plan, tuple(legs))


def rules_broken(mission, plan) -> set[str]:
    return {violation.rule for violation in adr_opt.check(mission.instance, plan)}


def test_good_plan_passes(mission, plan):
    """The worked-out plan has no violation."""
    assert adr_opt.check(mission.instance, plan) == ()


@pytest.mark.parametrize(
    ("field", "by", "rule"),
    [
        ("ready_s", 1.0, "ready"),
        ("departure_s", 1.0, "departure"),
        ("arrival_s", 1.0, "arrival"),
        ("end_s", 1.0, "service"),
        ("delta_v_m_s", -1.0, "cost"),
        ("delta_v_left_m_s", 1.0, "delta-v-left"),
        ("phasing_revolutions", 1, "phasing"),
        ("eccentricity_delta_v_m_s", 1.0, "eccentricity"),
    ],
)
def test_every_number_of_a_leg_is_checked(mission, plan, field, by, rule):
    """A wrong number in a leg is reported under the rule it breaks."""
    for number, leg in enumerate(plan.legs):
        wrong = change_leg(plan, number, **{field: getattr(leg, field) + by})
        assert rule in rules_broken(mission, wrong), number


def test_any_event_from_ready_on_may_be_taken(plan):
    """A leg may leave at a later crossing of the node, but not at one before the chaser is ready.

    Half a revolution later bodies that move alike are all on the other side of the Earth.
    """
    instance = hand_made(periods=20.0)
    plan = plan.replace(instance=plan.instance.replace(sha256=instance.sha256))
    leg = plan.legs[3]
    for events, refused in ((1, False), (3, False), (-1, True)):
        by = events * 0.5 * PERIOD_S
        burns = tuple(
            burn.replace(
                time_s=burn.time_s + by, delta_v_m_s=tuple(-part for part in burn.delta_v_m_s)
            )
            for burn in leg.burns
        )
        moved = leg.replace(
            departure_s=leg.departure_s + by,
            arrival_s=leg.arrival_s + by,
            end_s=leg.end_s + by,
            burns=burns,
        )
        later = with_legs(plan, (*plan.legs[:3], moved))
        later = later.replace(cost=cost_of_routes(instance, later.routes))
        violations = adr_opt.check(instance, later)
        assert [violation.rule for violation in violations] == ["departure"] * refused, events
        assert all("before the chaser is ready" in violation.message for violation in violations)


def test_any_flyable_sequence_may_be_taken():
    """Every (k, m) of a departure is accepted, at its own ΔV, and none at another one's."""
    instance = adr_opt.generate("tiny", 1).with_limits(delta_v_m_s=1e4)
    accepted = 0
    for sequence in every_sequence.of_pair(instance, 0, 2, 0.0, 6000.0)[0]:
        plan = judge.plan_of(instance, [(0, 2, sequence)])
        assert adr_opt.check(instance, plan) == ()
        accepted += 1
        leg = plan.legs[0]
        for changes in (
            {
                "delta_v_m_s": leg.delta_v_m_s - 0.01,
                "delta_v_left_m_s": leg.delta_v_left_m_s + 0.01,
            },
            {"phasing_revolutions": leg.phasing_revolutions + 1},
        ):
            assert adr_opt.check(instance, with_legs(plan, (leg.replace(**changes),))) != ()
    assert accepted > 5


def test_the_edges_of_zones_are_checked(plan):
    """A leg that arrives in the moment in which a zone closes is refused, and not one before it."""
    last = plan.legs[-1]
    for early, refused in ((0.0, True), (1e-3, False)):
        zone = KeepOutZone(
            min_altitude_m=699e3,
            max_altitude_m=701e3,
            start_s=last.arrival_s + early,
            end_s=last.arrival_s + 1e3,
        )
        instance = hand_made().replace(keep_out_zones=(zone,))
        stated = plan.replace(instance=plan.instance.replace(sha256=instance.sha256))
        found = [(one.leg, one.rule) for one in adr_opt.check(instance, stated)]
        assert found == [(4, "zone")] * refused


def test_burns_are_checked(mission, plan):
    """A turned, a delayed, a missing and a renamed burn are each reported."""
    leg = plan.legs[0]
    first = leg.burns[0]
    x, y, z = leg.burns[1].delta_v_m_s
    for burns in (
        (first, leg.burns[1].replace(delta_v_m_s=(x, z, y)), *leg.burns[2:]),
        (first.replace(time_s=first.time_s + 1.0), *leg.burns[1:]),
        leg.burns[1:],
        (first.replace(phase="phasing"), *leg.burns[1:]),
    ):
        assert "burns" in rules_broken(mission, change_leg(plan, 0, burns=burns))


def test_order_rules(mission, plan):
    """Visiting twice, refuelling unearned, jumping, and strangers are each reported."""
    south, refuel, north, _ = plan.legs
    assert "order" in rules_broken(mission, with_legs(plan, (south, refuel, south)))
    assert "refuelling" in rules_broken(mission, with_legs(plan, (south, refuel, refuel)))
    assert "refuelling" in rules_broken(mission, with_legs(plan, (refuel,)))
    assert "chain" in rules_broken(mission, with_legs(plan, (south, north)))
    stranger = change_leg(plan, 0, destination="nobody")
    assert "body" in rules_broken(mission, stranger)
    assert "order" in rules_broken(mission, change_leg(plan, 0, destination="station"))


def test_budgets(plan):
    """The same legs break a shorter mission and a smaller budget."""
    for variant, rule in (
        (hand_made(periods=13.0), "duration"),
        (hand_made(delta_v_m_s=250.0), "delta-v"),
    ):
        other = plan.replace(instance=plan.instance.replace(sha256=variant.sha256))
        found = {violation.rule for violation in adr_opt.check(variant, other)}
        assert rule in found


def test_totals(mission, plan):
    """Objective, bound, gap, status and the list of unvisited targets are checked."""
    assert "objective" in rules_broken(mission, plan.replace(objective=4.0))
    assert "bound" in rules_broken(mission, plan.replace(upper_bound=2.0, gap=-0.5))
    assert "gap" in rules_broken(mission, plan.replace(upper_bound=4.0, gap=0.1))
    assert "gap" in rules_broken(mission, plan.replace(gap=0.1))
    assert "status" in rules_broken(mission, plan.replace(status="optimal"))
    assert "unvisited" in rules_broken(mission, plan.replace(unvisited=()))
    for extra in ("north", "nobody"):
        listed = (*plan.unvisited, Unvisited(target=extra, reason="duration"))
        assert "unvisited" in rules_broken(mission, plan.replace(unvisited=listed))
    twice = plan.unvisited * 2
    assert "unvisited" in rules_broken(mission, plan.replace(unvisited=twice))
    proven = plan.replace(upper_bound=3.0, gap=0.0, status="optimal")
    assert adr_opt.check(mission.instance, proven) == ()


def test_certificates_that_contradict_themselves(mission, plan):
    """A status that bound and gap do not bear out is reported, whatever the prizes are worth."""
    for status, upper_bound, gap in (
        ("optimal", 4.0, 0.25),
        ("optimal", None, None),
        ("feasible", 3.0, 0.0),
        ("infeasible", 4.0, 0.25),
        ("infeasible", None, None),
        ("unknown", None, None),
    ):
        stated = plan.replace(status=status, upper_bound=upper_bound, gap=gap)
        assert rules_broken(mission, stated) == {"status"}, stated.status
    assert "gap" in rules_broken(mission, plan.replace(upper_bound=4.0, gap=None))
    assert "bound" in rules_broken(mission, plan.replace(upper_bound=-1.0, gap=0.0))

    worth = 1e-7
    instance = mission.instance.replace(
        targets=tuple(target.replace(prize=worth) for target in mission.instance.targets)
    )
    poor = plan.replace(
        instance=plan.instance.replace(sha256=instance.sha256),
        objective=3.0 * worth,
        upper_bound=4.0 * worth,
        gap=0.25,
    )
    assert adr_opt.check(instance, poor) == ()
    for wrong, rule in (
        (poor.replace(status="optimal"), "status"),
        (poor.replace(objective=2.9 * worth, gap=0.275), "objective"),
        (poor.replace(upper_bound=2.9 * worth, gap=1.0 - 3.0 / 2.9), "bound"),
    ):
        assert rule in {violation.rule for violation in adr_opt.check(instance, wrong)}


def test_figures_in_the_plans_own_favour_gain_nothing(mission, plan):
    """Legs whose times and ΔV are stated better than they are do not stretch the limits."""
    legs = tuple(
        leg.replace(
            ready_s=leg.ready_s - 0.9e-3 * (number > 0),
            arrival_s=leg.arrival_s - 0.9e-3,
            end_s=leg.end_s - 0.9e-3,
            delta_v_m_s=leg.delta_v_m_s - 0.9e-4,
        )
        for number, leg in enumerate(plan.legs)
    )
    spent = sum(leg.delta_v_m_s for leg in plan.legs[2:])
    for changes in ({"duration_s": plan.legs[-1].end_s - 1e-5}, {"delta_v_m_s": spent - 1e-5}):
        instance = mission.instance.with_limits(**changes)
        budget = instance.chaser.tank.delta_v_m_s
        lefts = [budget - plan.legs[0].delta_v_m_s, budget, budget - plan.legs[2].delta_v_m_s]
        lefts.append(lefts[-1] - plan.legs[3].delta_v_m_s)
        flattered = with_legs(
            plan,
            (leg.replace(delta_v_left_m_s=left) for leg, left in zip(legs, lefts, strict=True)),
            instance=plan.instance.replace(sha256=instance.sha256),
        )
        flattered = flattered.replace(cost=cost_of_routes(instance, flattered.routes))
        found = {violation.rule for violation in adr_opt.check(instance, flattered)}
        assert found == {"duration" if "duration_s" in changes else "delta-v"}


def test_all_violations_are_listed(mission, plan):
    """Two independent mistakes give at least two violations, each with its leg."""
    wrong = change_leg(plan, 0, delta_v_m_s=1.0)
    wrong = change_leg(wrong, 2, end_s=1.0)
    legs = {violation.leg for violation in adr_opt.check(mission.instance, wrong)}
    assert {1, 3} <= legs


def test_other_instance(plan):
    """A plan of another instance is refused, not judged."""
    with pytest.raises(adr_opt.InputError, match="belongs to"):
        adr_opt.check(hand_made(delta_v_m_s=301.0), plan)
