"""Low thrust in instances: what is refused, and what stands in files."""

from __future__ import annotations

from typing import Any

import pytest
from electric_fields import electric

import adr_opt
from adr_opt.problem.instance import Instance, instance_of


def changed(chaser: dict[str, Any], **fields: Any) -> Instance:
    """An electric mission with changes of its chaser and of fields."""
    content = electric(0).model_dump(mode="json")
    content["chasers"][0] |= chaser
    for name, value in fields.items():
        content[name] = content[name] | value if isinstance(value, dict) else value
    return instance_of(content)


@pytest.mark.parametrize(
    ("chaser", "fields", "sentence"),
    [
        ({"tank": {"delta_v_m_s": 500.0}}, {}, "the tank is given in ΔV, without masses"),
        ({"thrust_n": 0.0}, {}, "thrust_n"),
        ({"thrust_n": None, "duty_cycle": 0.5}, {}, "the chaser has no thrust"),
        ({"duty_cycle": 0.0}, {}, "duty_cycle"),
        ({"duty_cycle": 1.5}, {}, "duty_cycle"),
        ({}, {"transfer": {"max_drift_s": 0.0}}, "days to months"),
        ({}, {"dynamics": "two-body", "transfer": {"max_drift_s": 0.0}}, "days to months"),
    ],
)
def test_what_makes_no_sense_is_refused(
    chaser: dict[str, Any], fields: dict[str, Any], sentence: str
):
    """One sentence says what is wrong with a thrust."""
    with pytest.raises(adr_opt.InputError, match=sentence) as caught:
        changed(chaser, **fields)
    assert "\n" not in str(caught.value)


def test_plans_of_chemical_chasers_are_none_of_electric_ones():
    """A drift leg breaks the rules for a chaser with low thrust, and the other way round."""
    electric_one = electric(3)
    result = adr_opt.solve(electric_one, "greedy", time_limit=5.0)
    assert result.plan is not None
    content = electric_one.model_dump(mode="json")
    for field in ("thrust_n", "duty_cycle"):
        del content["chasers"][0][field]
    chemical = instance_of(content)
    other = adr_opt.solve(chemical, "greedy", time_limit=5.0)
    assert other.plan is not None
    for instance, plan in ((chemical, result.plan), (electric_one, other.plan)):
        swapped = plan.replace(
            instance=plan.instance.replace(name=instance.name, sha256=instance.sha256)
        )
        found = {violation.rule for violation in adr_opt.check(instance, swapped)}
        assert "kind" in found


def test_dates_and_costs_of_low_thrust_are_checked():
    """A leg that costs less than it does, leaves early or takes too long breaks the rules."""
    instance = electric(3)
    result = adr_opt.solve(instance, "greedy", time_limit=5.0)
    assert result.plan is not None
    leg = result.plan.legs[0]
    for changes, rule in (
        ({"delta_v_m_s": 0.9 * leg.delta_v_m_s}, "manoeuvres"),
        ({"delta_v_m_s": 1.1 * leg.delta_v_m_s}, "manoeuvres"),
        ({"arrival_s": leg.arrival_s - 60.0}, "manoeuvres"),
        ({"arrival_s": leg.departure_s}, "drift"),
    ):
        route = result.plan.routes[0]
        spoilt = result.plan.replace(
            routes=(route.replace(legs=(leg.replace(**changes), *route.legs[1:])),)
        )
        assert rule in {violation.rule for violation in adr_opt.check(instance, spoilt)}, changes


def test_a_thrust_too_low_for_any_leg_is_said():
    """With next to no thrust there is no leg, and the plan names the quickest one."""
    content = electric(3).model_dump(mode="json")
    content["chasers"][0]["thrust_n"] = 2e-4
    result = adr_opt.solve(instance_of(content), "greedy", time_limit=5.0)
    assert result.objective == 0.0
    (said,) = (note for note in result.notes if "too low" in note)
    assert "the quickest, from 'chaser-0' to 'debris-" in said
    enough = adr_opt.solve(electric(3), "greedy", time_limit=5.0)
    assert not any("too low" in note for note in enough.notes)


def test_arcs_are_flyable_as_stated():
    """Arcs that leave something of the orbit, or thrust too short or for too little, are wrong."""
    instance = electric(3)
    result = adr_opt.solve(instance, "greedy", time_limit=5.0)
    assert result.plan is not None
    assert not adr_opt.check(instance, result.plan)
    route = result.plan.routes[0]
    leg = route.legs[0]
    assert leg.manoeuvres is not None
    one, other = leg.manoeuvres
    assert leg.departure_s == one.start_s < one.end_s < other.start_s < other.end_s < leg.arrival_s
    for changes in (
        {"size_m_s": one.size_m_s + 0.1},
        {"inclination_deg": one.inclination_deg + 1e-4},
        {"raan_deg": one.raan_deg + 1e-3},
        {"delta_v_m_s": one.delta_v_m_s - 0.1},
        {"end_s": one.end_s - 100.0},
        {"start_s": one.start_s + 1.0},
        {"window_deg": 45.0},
        {"window_deg": 0.0},
        {"size_m_s": 1e6},
        {"size_m_s": -1e300},
        {"argument_of_latitude_deg": one.argument_of_latitude_deg + 1.0},
    ):
        spoilt = leg.replace(manoeuvres=(one.replace(**changes), other))
        plan = result.plan.replace(routes=(route.replace(legs=(spoilt, *route.legs[1:])),))
        found = {violation.rule for violation in adr_opt.check(instance, plan)}
        assert "manoeuvres" in found, changes
    without = result.plan.replace(
        routes=(route.replace(legs=(leg.replace(manoeuvres=None), *route.legs[1:])),)
    )
    assert "manoeuvres" in {violation.rule for violation in adr_opt.check(instance, without)}
