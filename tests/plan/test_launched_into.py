"""Launches into orbits: where chasers are placed, what first legs take, and what is lifted."""

from __future__ import annotations

from functools import cache

import pytest
from random_rules import launched_mission
from seeds import over_seeds

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.fly.flight.fly import fly
from adr_opt.fly.refine.all_legs import refine
from adr_opt.judge.admit import admit
from adr_opt.kernels.orbits import ephemeris
from adr_opt.legs.families.ends import AllEnds
from adr_opt.plan.launched import as_launched
from adr_opt.plan.plan import InstanceReference, Plan
from adr_opt.problem.instance import Instance

LAUNCH = {"altitude_m": 650e3, "inclination_deg": 82.96}


@cache
def planned(most: int | None = None) -> tuple[Instance, Plan]:
    """Rocket bodies near 83°, and two chasers that are launched into a circle below them."""
    field = adr_opt.generate("removal", seed=0, targets=8)
    targets = [each for each in field.targets if each.orbit.inclination_deg > 80.0]
    of_each = {"start": {"launch": LAUNCH}, "max_targets": most}
    chasers = tuple(each.replace(**of_each) for each in field.chasers[:2])
    instance = field.replace(targets=tuple(targets), chasers=chasers)
    plan = adr_opt.solve(instance, "greedy-guarded", time_limit=60.0).plan
    assert all(route.legs for route in plan.routes)
    return instance, plan


def test_first_legs_are_flown_as_said() -> None:
    """From the circle, in the target's plane, the first legs take what is planned within 1 %."""
    instance, plan = planned()
    assert adr_opt.check(instance, plan) == ()
    flight, number = fly(instance, plan), 1
    for route in plan.routes:
        said = route.legs[0].delta_v_m_s
        assert route.legs[0].kind == "short"
        assert flight.legs[number - 1].miss_m < 1.0
        assert flight.legs[number - 1].true_delta_v_m_s == pytest.approx(said, rel=0.01)
        number += len(route.legs)


@pytest.mark.slow
def test_plans_are_refined_from_the_circle() -> None:
    """Refined legs begin where the chaser is launched to, and their judge finds nothing."""
    instance, plan = planned(1)
    refined = refine(instance, plan, freedom="planned", jobs=1)
    assert admit(instance, refined).holds
    assert not refined.missing


@over_seeds(range(40), gate=6)
def test_a_launch_is_an_orbit_of_its_own_from_then_on(seed: int) -> None:
    """Where a first leg leaves, the row that it is priced by is the orbit that is flown."""
    instance = launched_mission(seed)
    plan = adr_opt.solve(instance, "greedy-guarded", time_limit=60.0).plan
    starts = {} if plan is None else {each.chaser: each.legs for each in plan.routes if each.legs}
    number = {name: body for body, name in enumerate(instance.names)}
    rows = as_launched(instance, plan).orbits()
    for chaser in instance.chasers:
        if chaser.launch is None or chaser.name not in starts:
            continue
        leg, home = starts[chaser.name][0], number[chaser.name]
        priced = AllEnds(instance).of(home, number[leg.destination]).leaving
        for element in (ephemeris.node_at, ephemeris.latitude_at, ephemeris.radius_at):
            said, flown = (float(element(row, leg.leaves_s)) for row in (priced, rows[home]))
            off = (said - flown) % (2.0 * 3.141592653589793) if said < 1e5 else said - flown
            assert min(off, 2.0 * 3.141592653589793 - off) == pytest.approx(0.0, abs=1e-6)


def test_a_launcher_lifts_so_much_and_no_more() -> None:
    """A plan whose chaser is too heavy is refused, and plans keep to what is lifted."""
    instance, plan = planned()
    heaviest = max(leg.mass_kg for route in plan.routes for leg in route.legs[:1])
    lifted = instance.chasers[0].tank.dry_mass_kg + 60.0
    assert heaviest > lifted
    start = {"launch": LAUNCH | {"launcher": [[500e3, lifted + 150.0], [800e3, lifted - 150.0]]}}
    chasers = tuple(each.replace(start=start) for each in instance.chasers)
    limited = instance.replace(chasers=chasers)
    assert chasers[0].most_kg == pytest.approx(lifted)
    other = InstanceReference(name=limited.name, sha256=limited.sha256)
    assert "delta-v" in {each.rule for each in adr_opt.check(limited, plan.replace(instance=other))}
    made = adr_opt.solve(limited, "greedy-guarded", time_limit=60.0).plan
    assert adr_opt.check(limited, made) == ()
    for route in made.routes:
        assert all(leg.mass_kg <= lifted for leg in route.legs)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"dynamics": "two-body", "transfer": {}}, "planes that drift"),
        ({"mission": {"duration_s": 1e7, "launch_separation_s": 5.0}}, "available_s"),
    ],
)
def test_what_cannot_be_launched_is_refused(changes: dict[str, object], said: str) -> None:
    """One sentence says what is wrong with the mission of a launch."""
    instance, _ = planned()
    with pytest.raises(InputError, match=said):
        instance.replace(**changes)


@pytest.mark.parametrize(
    ("launcher", "said"),
    [
        ([[700e3, 500.0], [800e3, 400.0]], "given from"),
        ([[800e3, 500.0], [600e3, 900.0]], "ascending"),
        ([[600e3, 50.0], [800e3, 40.0]], "lifts 47.5 kg"),
    ],
)
def test_what_no_launcher_is_is_refused(launcher: list[list[float]], said: str) -> None:
    """One sentence says what is wrong with a launcher."""
    instance, _ = planned()
    with pytest.raises(InputError, match=said):
        instance.chasers[0].replace(start={"launch": LAUNCH | {"launcher": launcher}})
