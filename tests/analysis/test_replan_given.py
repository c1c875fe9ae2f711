"""Going on where connections are given: they lead from bodies, and so from where a chaser is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import Cli
from on_from import Field, most, rest_of, violations
from random_rules import (
    carrying,
    given_field,
    given_mission,
    mixed_campaign,
    random_campaign,
    with_given_costs,
)
from toy_roads import HOUR_S, solved

import adr_opt
from adr_opt.analysis import replan
from adr_opt.plan.plan import Plan
from adr_opt.problem.chasers import InOrbit, Tank
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import MissionSettings


def drawn(seed: int) -> tuple[Instance, Plan | None]:
    """One chaser or several over random connections, by turns with kits, and some plan."""
    make = (
        given_mission,
        lambda n: random_campaign(n, given_field),
        lambda n: mixed_campaign(n, given_field),
    )[seed % 3]
    instance = make(seed)
    if seed % 2:
        instance = carrying(instance, seed)
    return instance, adr_opt.solve(
        instance, "greedy" if seed % 4 < 2 else "auto", time_limit=2
    ).plan


@pytest.mark.slow
def test_what_is_flown_and_the_rest_are_one_mission() -> None:
    """At any time, with targets lost or legs kept, they stay as they were, and `check` passes."""
    at_targets = idle = 0
    for seed in range(26):
        instance, plan = drawn(seed)
        if plan is None or not plan.legs:
            continue
        rng = np.random.default_rng([20, seed])
        at_s = float(rng.uniform(0.0, instance.mission.duration_s))
        made = rest_of(instance, plan, at_s, rng, seed)
        if made is None:
            continue
        at_targets += sum(state.is_at_target for state in made.states)
        idle += any(state.idle_kits for state in made.states)
    assert at_targets > 15
    assert idle < 5


def simple(seed: int) -> tuple[Instance, Plan]:
    """Six places without a station, and the best plan."""
    field = adr_opt.generate("tiny", seed, targets=6)
    rng = np.random.default_rng([21, seed])
    start = InOrbit(orbit=field.stations[0].orbit)
    bare = field.replace(
        stations=(),
        chasers=(field.chaser.replace(start=start, tank=Tank(delta_v_m_s=500.0)),),
        mission=MissionSettings(duration_s=90_000.0, service_s=900.0),
        targets=tuple(target.replace(prize=float(rng.integers(1, 5))) for target in field.targets),
    )
    # Orbits may only be left out of an instance whose connections are given already.
    instance = with_given_costs(with_given_costs(bare, rng), rng, orbits=bool(seed % 2))
    plan = adr_opt.solve(instance, "exact", time_limit=30.0).plan
    assert plan is not None
    return instance, plan


@pytest.mark.parametrize("seed", range(4))
def test_the_rest_is_the_best_there_is(seed: int) -> None:
    """Nothing collects more on from the place where the chaser is, in the rows of the whole."""
    instance, plan = simple(seed)
    field = Field(
        instance.given.of_pair,
        {target.name: target.prize for target in instance.targets},
        dict.fromkeys(instance.names, instance.mission.service_s),
        instance.mission.duration_s,
        lambda name, left_m_s: left_m_s,
    )
    fell = 0
    times = (leg.end_s + wait_s for leg in plan.legs for wait_s in (-1.0, 3000.0))
    for at_s in (min(time, instance.mission.duration_s) for time in times):
        ahead = [leg.destination for leg in plan.legs if leg.leaves_s >= at_s]
        for lost in ([], ahead[:1]):
            made = replan(instance, plan, at_s, lost=lost, method="exact", time_limit=60.0)
            (state,) = made.states
            done = {leg.destination for leg in state.legs}
            todo = frozenset(field.prizes) - done - set(lost)
            left_m_s = 500.0 - sum(leg.delta_v_m_s for leg in state.legs)
            best = most(field, state.body, max(at_s, state.legs[-1].end_s), left_m_s, todo)
            assert made.prize_after == best, (at_s, lost)
            fell += made.prize_after < made.prize_before
    assert fell > 0


def test_who_has_to_return_does_so_without_another_target() -> None:
    """The way home is left, also where all targets are done or lost."""
    instance, plan = solved()
    names = [target.name for target in instance.targets]
    for number, leg in enumerate(plan.legs[:-1], start=1):
        lost = [name for name in names if name not in plan.destinations[:number]]
        made = replan(instance, plan, leg.end_s, lost=lost)
        assert made.plan is not None
        assert violations(instance, made) == ()
        (route,) = made.whole()
        assert [each.destination for each in route.legs] == [*plan.destinations[:number], "depot"]


def test_files_of_the_rest_leave_those_of_the_whole_alone(cli: Cli) -> None:
    """In one folder, several rests have connections of their own, and all files can be read."""
    instance, plan = solved()
    instance.save("roads.json")
    plan.save("plan.json")
    hours = f"{plan.legs[0].end_s / HOUR_S}h"
    for number, lost in enumerate(([], ["--lost", plan.destinations[1]])):
        outcome = cli(
            "replan roads.json plan.json --at",
            hours,
            *lost,
            "--out",
            f"rest-{number}.json",
            "--out-instance",
            f"rest-instance-{number}.json",
        )
        assert outcome.status == 0, outcome
    assert cli("check", "roads.json", "plan.json").status == 0
    for number in range(2):
        checked = cli("check", f"rest-instance-{number}.json", f"rest-{number}.json")
        assert checked.status == 0, checked
    assert len(list(Path().glob("*.parquet"))) == 3
