"""What chasers keep for their own disposal: as a rule of plans, bounds, certificates and judges."""

from __future__ import annotations

import math

import pytest
from random_rules import disposing_mission, reserving_mission
from seeds import over_kinds, over_seeds
from towed_fields import TANK, field

import adr_opt
from adr_opt.analysis import price
from adr_opt.common.errors import InputError
from adr_opt.problem.chasers import Tank, TankByMass
from adr_opt.problem.rules import RULES


@over_seeds(range(60), gate=8)
def test_the_reserve_alone_makes_the_difference(*, seed: int) -> None:
    """Without it no plan is worse, and `check` refuses with it what overdraws it, and only that."""
    instance = reserving_mission(seed)
    if not RULES["end of life"].binds(instance):
        return
    (chaser,) = instance.chasers
    free = instance.replace(chasers=(chaser.replace(end_of_life_m_s=None),))
    kept, whole = (adr_opt.solve(each, "auto", iterations=50).plan for each in (instance, free))
    assert kept is not None
    assert whole is not None
    assert kept.objective <= whole.objective
    told = whole.replace(instance=whole.instance.replace(sha256=instance.sha256))
    broken = {one.rule for one in adr_opt.check(instance, told)} - {"delta-v-left", "cost"}
    assert broken <= {"delta-v", "upper-bound", "cost-bound", "connection"}
    if kept.objective < whole.objective:
        assert "delta-v" in broken


@over_kinds(
    "draw, seeds", kept=(reserving_mission, range(40), 4), left=(disposing_mission, range(40), 3)
)
def test_an_order_is_priced_as_it_is_planned(draw, seeds) -> None:  # type: ignore[no-untyped-def]
    """`price` keeps the reserve and releases objects by the same rules as planners."""
    for seed in seeds:
        instance = draw(seed)
        plan = adr_opt.solve(instance, "greedy").plan
        if plan is None or instance.objective.cost != "delta-v":
            continue
        made = price(instance, plan)
        assert made.holds, seed
        assert made.plan().cost <= plan.cost + 1e-6, seed
        assert adr_opt.check(instance, made.plan()) == (), seed


def test_a_reserve_is_propellant_of_the_empty_chaser() -> None:
    """Burnt at the end of a plan, without kits, it gives the ΔV that is stated."""
    instance = field("j2")
    chaser = instance.chaser.replace(end_of_life_m_s=200.0)
    plan = adr_opt.solve(instance.replace(chasers=(chaser,)), "greedy").plan
    assert plan is not None
    last = plan.legs[-1]
    assert last.mass_kg is not None
    left = TANK["isp_s"] * 9.80665 * math.log(last.mass_kg / TANK["dry_mass_kg"])
    assert left == pytest.approx(last.delta_v_left_m_s + 200.0, abs=1e-6)


def test_no_more_is_kept_than_there_is() -> None:
    """A reserve as large as the tank is refused; a smaller one leaves the rest of it."""
    chaser = field().chaser
    assert chaser.usable is chaser.tank
    for tank, most in ((Tank(delta_v_m_s=300.0, initial_delta_v_m_s=100.0), 100.0),):
        in_orbit = chaser.replace(start="anywhere", tank=tank)
        with pytest.raises(InputError, match="keep less of it"):
            in_orbit.replace(end_of_life_m_s=most)
        less = in_orbit.replace(end_of_life_m_s=40.0)
        assert (less.usable.delta_v_m_s, less.spent_m_s) == (260.0, 200.0)
    tank = TankByMass(dry_mass_kg=100.0, propellant_kg=50.0, isp_s=300.0)
    less = chaser.replace(tank=tank, end_of_life_m_s=300.0)
    assert less.usable.delta_v_m_s == pytest.approx(tank.delta_v_m_s - 300.0)
