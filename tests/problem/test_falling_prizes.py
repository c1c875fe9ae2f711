"""Prizes that fall with the end of the service: the field, its refusals, and what plans collect."""

from __future__ import annotations

import math

import pytest
from brute_force import brute_force
from random_rules import falling_field, falling_mission
from seeds import over_kinds
from timed_fields import timed_mission

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.export.tables import write_matrix
from adr_opt.mission.mission import Mission
from adr_opt.problem.bodies import prize_at
from adr_opt.problem.settings import Objective


def test_a_prize_is_that_of_the_first_time_that_the_service_keeps():
    """An entry counts up to its time, the time included, and what is left after the last."""
    levels = ((10.0, 5.0), (20.0, 3.0))
    found = [prize_at(1.0, levels, end_s) for end_s in (0.0, 10.0, 10.1, 20.0, 20.1)]
    assert found == [5.0, 5.0, 3.0, 3.0, 1.0]


@pytest.mark.parametrize(
    ("levels", "prize", "said"),
    [
        (((10.0, 1.0), (20.0, 2.0)), 1.0, "may only fall"),
        (((20.0, 2.0), (10.0, 1.0)), 1.0, "must rise"),
        (((10.0, 2.0), (10.0, 1.0)), 1.0, "must rise"),
        (((10.0, 2.0),), 3.0, "may not exceed"),
        (((-1.0, 2.0),), 1.0, "prize_until"),
        (((10.0, -2.0),), 0.0, "prize_until"),
        ((), 1.0, "prize_until"),
        (((10.0, math.sqrt(2.0)),), 0.3, "no common unit"),
        (((10.0, 1e9),), 1.0, "at most 67108864"),
    ],
)
def test_a_prize_that_cannot_fall_so_is_one_sentence(levels, prize, said):
    """Prizes rise, times fall, or there is no common unit: refused, with the field's name."""
    instance = adr_opt.generate("tiny", 0)
    first, *others = instance.targets

    def made() -> adr_opt.Instance:
        falls = first.replace(prize=prize, prize_until=levels)
        return instance.replace(targets=(falls, *others))

    with pytest.raises(InputError, match=said) as refused:
        made()
    assert "\n" not in str(refused.value)


def test_what_cannot_plan_them_says_so(tmp_path):
    """Tours, the least ΔV, the environment and files of routing problems, in one sentence each."""
    instance = adr_opt.generate("tiny", 0)
    falls = tuple(each.replace(prize_until=((9000.0, 2.0),)) for each in instance.targets)
    instance = instance.replace(targets=falls)
    toured = instance.replace(transfer=instance.transfer.replace(max_leg_s=1e5))
    timed = timed_mission(0)
    later = [each.replace(prize=1.0, prize_until=((9000.0, 2.0),)) for each in timed.targets]
    timed = timed.replace(targets=tuple(later))
    for odd, method, said in (
        (toured, "greedy", r"longest leg \(field transfer.max_leg_s\)"),
        (toured, "auto", "rules of tours beyond tours"),
        (timed, "auto", "prizes that fall beyond lists of connections"),
    ):
        with pytest.raises(InputError, match=f"'{method}' does not follow {said}"):
            adr_opt.solve(odd, method)
    with pytest.raises(InputError, match="option cost"):
        adr_opt.solve(instance, "exact", cost=True)
    with pytest.raises(InputError, match="prizes that fall"):
        adr_opt.solve(instance, "ppo")
    for suffix in (".vrp", ".oplib"):
        with pytest.raises(InputError, match="prize_until"):
            write_matrix(Mission(instance), tmp_path / f"out{suffix}", [0.0])


def test_the_end_is_proven_least_among_plans_that_collect_as_much():
    """With duration as cost, `exact --option cost=true` knows the times of prizes."""
    proven = 0
    for seed in range(12):
        instance = falling_field(seed).replace(objective=Objective(cost="duration"))
        prizes, cost, _ = brute_force(Mission(instance))
        if not math.isfinite(prizes):
            continue
        plan = adr_opt.solve(instance, "exact", time_limit=60.0, cost=True).plan
        assert plan.objective == pytest.approx(prizes), seed
        assert plan.cost_status == "optimal", seed
        assert plan.cost == pytest.approx(cost, abs=1e-5), seed
        proven += 1
    assert proven > 5


@over_kinds("seeds", falls=(range(200), 8))
def test_the_cost_of_prizes_that_fall_is_bounded(seeds):
    """`auto` states no cost bound above the least cost, and calls none least that is not."""
    proven = 0
    for seed in seeds:
        mission = Mission(falling_mission(seed))
        prizes, cost, _ = brute_force(mission)
        if not math.isfinite(prizes):
            continue
        plan = adr_opt.solve(mission, "auto", time_limit=60.0).plan
        assert plan.objective == pytest.approx(prizes), seed
        if plan.cost_bound is None:
            continue
        assert plan.cost_bound <= cost * (1.0 + 1e-9) + 1e-6, seed
        if plan.cost_status == "optimal":
            assert plan.cost == pytest.approx(cost, rel=2e-6, abs=1e-5), seed
            proven += 1
    assert proven > 0.3 * len(seeds)


@pytest.mark.parametrize("greatest", [60000.3, 3000000.1])
def test_small_losses_of_large_prizes_are_not_overlooked(greatest):
    """A service that keeps its prize is preferred, however little of it would be lost."""
    instance = adr_opt.generate("tiny", 0)
    first, second, *others = (each.replace(prize=50000.0) for each in instance.targets)
    plain = instance.replace(targets=(first, second.replace(prize=0.1), *others))
    mission = Mission(plain)
    body = plain.first_target
    early = mission.schedules.fronts((body,))[-1].ready.min()
    cut_s = 0.5 * (float(early) + float(mission.time((body,)).ends[-1]))
    falls = first.replace(prize=round(greatest - 0.1, 6), prize_until=((cut_s, greatest),))
    made = Mission(plain.replace(targets=(falls, *plain.targets[1:]))).time((body,))
    assert made.ends[-1] <= cut_s
    assert made.objective == pytest.approx(greatest, abs=1e-6)


def test_losses_that_no_number_can_hold_beside_costs_are_refused():
    """Millions of units and a tank of a million km/s: one sentence before anything is planned."""
    instance = adr_opt.generate("tiny", 0)
    chaser = instance.chaser.replace(tank=instance.chaser.tank.replace(delta_v_m_s=1e9))
    targets = tuple(
        each.replace(prize=0.0, prize_until=((9000.0, 1e6),)) for each in instance.targets
    )
    other = instance.replace(
        chasers=(chaser,), targets=(targets[0].replace(prize=1.0), *targets[1:])
    )
    with pytest.raises(InputError, match="round the prizes"):
        adr_opt.solve(other, "greedy")


def test_a_plan_that_counts_prizes_of_another_time_is_refused():
    """`check` reads the prize at the end of the service, or of the tow that follows at once."""
    fallen = towed = 0
    for seed in range(40):
        instance = falling_mission(seed)
        plan = adr_opt.solve(instance, "greedy-guarded").plan
        if plan is None:
            continue
        assert adr_opt.check(instance, plan) == (), seed
        targets = {each.name: each for each in instance.targets}
        legs = [leg for leg in plan.legs if leg.destination in targets]
        counted = math.fsum(targets[leg.destination].prize_at(leg.free_s) for leg in legs)
        assert plan.objective == pytest.approx(counted), seed
        towed += sum(leg.tow is not None for leg in legs)
        most = math.fsum(targets[leg.destination].greatest_prize for leg in legs)
        if most > counted + 1e-9:
            fallen += 1
            rules = {each.rule for each in adr_opt.check(instance, plan.replace(objective=most))}
            assert "objective" in rules, seed
    assert fallen > 5
    assert towed > 5
