"""Costs from elsewhere: planned, checked, and told apart from the model's.

See docs/model.md section 9.

That plans and proofs are right is for test_all_rules and test_campaigns, which draw given
connections among others.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest
from toy_roads import DEPARTURES, HOUR_S, as_rows, matrices, roads, solved

import adr_opt
from adr_opt.plan.plan import Plan
from adr_opt.problem.chasers import Tank
from adr_opt.problem.given import COLUMNS, of_rows
from adr_opt.problem.settings import MissionSettings


def test_the_toy_is_planned_by_hand() -> None:
    """To the end of the road and back at the least cost; legs are given and burn nothing."""
    instance, plan = solved()
    assert adr_opt.check(instance, plan) == ()
    assert plan.objective == 3.0
    assert {leg.kind for leg in plan.legs} == {"given"}
    assert all(leg.burns == () for leg in plan.legs)
    assert plan.destinations[-1] == "depot"
    assert plan.legs[0].departure_s == 0.0
    # Each half hour makes everything dearer by a tenth, so nobody waits: 25 minutes of road and
    # 10 of service miss every other departure.
    assert [leg.departure_s / HOUR_S for leg in plan.legs] == [0.0, 1.0, 2.0, 3.0]
    assert plan.cost == pytest.approx(3.0 + 3.0 * 1.2 + 3.0 * 1.4 + 9.0 * 1.6)
    assert plan.legs[-1].end_s == 3 * HOUR_S + 4500.0


def test_a_margin_and_a_start_are_kept_to() -> None:
    """With a margin less is spent; a plan may be begun from."""
    instance, plan = solved()
    kept = adr_opt.solve(instance, "exact", time_limit=30.0, margin=0.5)
    assert kept.objective == 0.0 or kept.plan.cost <= 15.0
    again = adr_opt.solve(instance, "local-search", start=plan, time_limit=60.0, iterations=3)
    assert again.objective == plan.objective


def changed(plan: Plan, leg: int, **changes: Any) -> Plan:
    route = plan.routes[0]
    legs = list(route.legs)
    legs[leg] = legs[leg].replace(**changes)
    return plan.replace(routes=(route.replace(legs=tuple(legs)),))


@pytest.mark.parametrize(
    ("leg", "changes", "rule"),
    [
        (1, {"departure_s": 3700.0}, "departure"),
        (1, {"arrival_s": 5000.0}, "arrival"),
        (1, {"delta_v_m_s": 3.0}, "cost"),
        (1, {"delta_v_m_s": 3.6 - 0.9e-4}, None),
        (1, {"kind": "short"}, "given"),
        (1, {"phasing_revolutions": 1}, "given"),
        (1, {"ready_s": 0.0}, "ready"),
        (2, {"end_s": 1.0}, "service"),
    ],
)
def test_check_finds_legs_that_nobody_gave(
    leg: int, changes: dict[str, Any], rule: str | None
) -> None:
    """A leg that is none of the connections is a violation of the rule that it breaks."""
    instance, plan = solved()
    found = adr_opt.check(instance, changed(plan, leg, **changes))
    at_leg = [violation.rule for violation in found if violation.leg == leg + 1]
    assert at_leg == ([] if rule is None else at_leg[:1] and [rule, *at_leg[1:]])
    assert bool(at_leg) == (rule is not None)


def test_check_looks_among_what_planners_leave_out() -> None:
    """A dominated connection may be flown, one before the chaser is ready may not."""
    _, plan = solved()
    rows = as_rows()
    for name, value in zip(COLUMNS, ("depot", "mill", 0.0, 1700.0, 4.0), strict=True):
        rows[name].append(value)
    for name, value in zip(COLUMNS, ("mill", "quay", 2000.0, 5100.0, 3.6), strict=True):
        rows[name].append(value)
    more = adr_opt.Timetable.from_connections(roads(), rows).instance
    reference = plan.instance.replace(sha256=more.sha256)
    first = plan.routes[0].legs[0]
    worse = changed(plan, 0, arrival_s=1700.0, end_s=first.end_s + 200.0, delta_v_m_s=4.0)
    told = {violation.rule for violation in adr_opt.check(more, worse.replace(instance=reference))}
    assert told == {"ready", "delta-v-left", "cost"} - ({"ready"} if False else set())
    early = changed(plan, 1, departure_s=2000.0).replace(instance=reference)
    assert "departure" in {violation.rule for violation in adr_opt.check(more, early)}


def test_a_given_leg_is_none_of_the_model() -> None:
    """On an instance of the model a leg that says it is given is refused, not flown."""
    instance = adr_opt.generate("tiny", 0)
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    found = adr_opt.check(instance, changed(plan, 0, kind="given", burns=()))
    assert [violation.rule for violation in found] == ["given"]


@pytest.mark.parametrize("dynamics", ["two-body", "j2"])
@pytest.mark.parametrize("spacing_s", [0.0, 7000.0])
def test_the_model_given_back_is_the_same_problem(dynamics: str, spacing_s: float) -> None:
    """An instance's own connections as given ones: the same plans, bounds and proofs."""
    instance = adr_opt.generate("tiny", 3)
    instance = instance.replace(
        dynamics=dynamics,
        transfer=instance.transfer.replace(departure_spacing_s=spacing_s),
        # Stated, since over given connections, whose unit is not known, it is nothing by default.
        objective={"time_m_s_per_day": 0.1},
    ).with_time_value(75.0)
    mission = adr_opt.Mission(instance)
    parts: dict[str, list[Any]] = {name: [] for name in COLUMNS}
    for i, origin in enumerate(mission.names):
        for j, destination in enumerate(mission.names):
            found = mission.connecting.of_pair(i, j, mission.connecting.planning_resolution_m_s)
            for name, values in zip(
                COLUMNS,
                (
                    [origin] * found.departure.size,
                    [destination] * found.departure.size,
                    found.departure,
                    found.arrival,
                    found.delta_v,
                ),
                strict=True,
            ):
                parts[name].extend(values)
    back = instance.with_given(of_rows(parts, instance.names)).with_time_value(75.0)
    for method in ("greedy-guarded", "beam", "exact"):
        ours = adr_opt.solve(instance, method, time_limit=60.0, iterations=3)
        theirs = adr_opt.solve(back, method, time_limit=60.0, iterations=3)
        assert theirs.objective == ours.objective, method
        assert theirs.upper_bound == ours.upper_bound, method
        assert theirs.status == ours.status, method
        assert adr_opt.check(back, theirs.plan) == ()
        if spacing_s or dynamics == "j2" or method == "exact":
            assert theirs.plan.cost == pytest.approx(ours.plan.cost, abs=1e-6), method
        if spacing_s or dynamics == "j2":
            assert theirs.sequence == ours.sequence, method
            flown = [(leg.arrival_s, leg.delta_v_m_s) for leg in ours.plan.legs]
            again = [(leg.arrival_s, leg.delta_v_m_s) for leg in theirs.plan.legs]
            assert np.allclose(again, flown, rtol=0.0, atol=1e-3)
    bounds = [
        adr_opt.bound(one, "lagrangian", iterations=5, time_limit=60.0) for one in (instance, back)
    ]
    assert bounds[0].upper_bound == bounds[1].upper_bound


def test_a_very_short_leg_does_not_hold_up_proofs() -> None:
    """Two bodies side by side, a hundredth of a second apart, in a mission of months."""
    days = 86400.0
    instance = roads(
        mission=MissionSettings(duration_s=100 * days, service_s=0.0, refuel_revolutions=0.0)
    )
    duration, cost = matrices()
    duration = np.where(np.isfinite(duration), 20 * days, np.inf)
    duration[:, 1, 2] = duration[:, 2, 1] = 0.01
    table = adr_opt.Timetable.from_matrices(instance, DEPARTURES * 400, duration, cost)
    began = time.process_time()
    result = adr_opt.solve(table.instance, "exact", time_limit=60.0)
    assert result.status == "optimal"
    assert result.objective == 3.0
    assert adr_opt.check(table.instance, result.plan) == ()
    assert time.process_time() - began < 30.0


def test_time_is_worth_what_the_tank_is() -> None:
    """Of given costs nobody knows the unit: an hour is worth a share of the tank, without a cap."""
    instance, _ = solved()
    share = 0.8 * 3.0 * 30.0 / 6.0
    assert instance.time_value_m_s_per_h == pytest.approx(share)
    rich = instance.replace(chasers=[instance.chaser.replace(tank=Tank(delta_v_m_s=3e6))])
    assert rich.time_value_m_s_per_h == pytest.approx(1e5 * share)
