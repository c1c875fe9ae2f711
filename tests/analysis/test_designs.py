"""Designs of campaigns: what each changes, what plans cost and avoid, and what bounds exclude."""

from __future__ import annotations

import itertools
import math
from functools import cache

import numpy as np
import pytest
from rated_fields import rated, worths_of_sets
from seeds import first_of

import adr_opt
from adr_opt.analysis import Axis, CampaignPrices, DesignStudy, design_study, parse_axis, tradeoff
from adr_opt.analysis.design import Design, DesignPoint, designs_of, pareto_front
from adr_opt.analysis.design.designs import designed
from adr_opt.analysis.design.rating import rating_of
from adr_opt.analysis.design.study import with_neighbours
from adr_opt.analysis.design.work import DesignWork
from adr_opt.common.constants import DAY_S, STANDARD_GRAVITY_M_S2
from adr_opt.common.errors import InputError
from adr_opt.problem.instance import Instance
from adr_opt.sources.worth import SetWorths

YEAR_S = 365.25 * DAY_S

PRICES = CampaignPrices(launch=10.0, kit=2.0, kilogram=0.05)

WITNESS_S = 5.0
"""For a plan of a set; where none is found the set says nothing."""

LIMIT_S = 60.0
"""A guard against hanging: all fields here are proven in a second."""


@cache
def made() -> DesignStudy:
    """One or two launches, with two numbers of kits."""
    field = rated(targets=4)
    return design_study(
        field,
        [Axis("launches", (1.0, 2.0)), Axis("kits", (1.0, 2.0))],
        worths=worths_of_sets(field),
        prices=PRICES,
        time_limit=LIMIT_S,
    )


def one(kind: str, value: float) -> Design:
    """A design that varies one limit."""
    return Design(((kind, value),))


def test_each_axis_changes_what_it_says() -> None:
    """Launches, years between them, kits, tank, dry mass, start and duration, and nothing else."""
    field = rated(chasers=2)
    assert len(designed(field, one("launches", 1.0)).chasers) == 1
    more = designed(field, one("launches", 5.0)).chasers
    assert [chaser.name for chaser in more] == [f"chaser-{n}" for n in range(1, 6)]
    assert [chaser.available_s[0] / DAY_S for chaser in more] == [0.0, 20.0, 40.0, 60.0, 80.0]
    assert {chaser.tank for chaser in more} == {field.chasers[0].tank}
    half = designed(field, one("separation", 0.5 * YEAR_S)).available_s
    assert [since / YEAR_S for since, _ in half] == [0.0, 0.5]
    later = designed(field, one("start", 7.0 * DAY_S)).available_s
    assert [since / DAY_S for since, _ in later] == [7.0, 27.0]
    moved = designed(field, one("launch", 0.5 * YEAR_S))
    assert [since / YEAR_S for since, _ in moved.available_s] == pytest.approx(
        [0.5, 0.5 + 20.0 * DAY_S / YEAR_S]
    )
    assert moved.mission.duration_s == field.mission.duration_s + 0.5 * YEAR_S
    lifted = [
        chaser.replace(start={"launch": {"altitude_m": 5e5, "inclination_deg": 98.0}})
        for chaser in field.chasers
    ]
    higher = designed(field.replace(chasers=tuple(lifted)), one("altitude", 6e5))
    assert {chaser.launch.altitude_m for chaser in higher.chasers} == {6e5}
    for kind, value, found in (
        ("kits", 4.0, lambda chaser: chaser.kits),
        ("dry-mass", 300.0, lambda chaser: chaser.tank.dry_mass_kg),
        ("propellant", 55.0, lambda chaser: chaser.tank.propellant_kg),
        ("isp", 220.0, lambda chaser: chaser.tank.isp_s),
    ):
        changed = designed(field, one(kind, value))
        assert {found(chaser) for chaser in changed.chasers} == {value}
        assert changed.targets == field.targets
        assert changed.mission == field.mission
    assert designed(field, one("duration", 30.0 * DAY_S)).mission.duration_s == 30.0 * DAY_S
    assert designed(field, one("budget", 5.0)) == field


def test_stated_intervals_of_launches_give_way() -> None:
    """`separation` holds where the file keeps launches further apart."""
    field = rated(chasers=2)
    apart = field.replace(mission=field.mission.replace(launch_separation_s=50.0 * DAY_S))
    found = designed(apart, one("separation", 10.0 * DAY_S))
    assert [since / DAY_S for since, _ in found.available_s] == [0.0, 10.0]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("launches=0,1", "positive"),
        ("launches=1.5", "whole numbers"),
        ("launches=999", "more than 200"),
        ("separation=-1,1", "at least 0"),
        ("budget=-1,1", "positive"),
        ("thrust=0.1,0.2", "has low thrust"),
    ],
)
def test_bad_values_are_refused(text: str, said: str) -> None:
    """One sentence says what is wrong with a value, before anything is planned."""
    with pytest.raises(InputError, match=said):
        design_study(rated(), [parse_axis(text)], prices=PRICES)


def test_what_is_not_there_cannot_be_varied() -> None:
    """Kits without targets that take them, masses of tanks in ΔV, intervals of chosen launches."""
    tiny = adr_opt.generate("tiny", 0)
    for kind, said in (
        ("kits", "takes a kit"),
        ("dry-mass", "without masses"),
        ("isp", "without masses"),
        ("altitude", "launched into an orbit"),
    ):
        with pytest.raises(InputError, match=said):
            designed(tiny, one(kind, 3.0))
    field = rated(chasers=2)
    chosen = field.replace(mission=field.mission.replace(mission_separation_s=DAY_S))
    with pytest.raises(InputError, match="mission_separation_s"):
        designed(chosen, one("separation", DAY_S))
    for axes, said in (
        ([], "nothing is varied"),
        ([Axis("kits", (1.0,))] * 2, "varied twice"),
        ([Axis("delta-v", (1.0,)), Axis("propellant", (1.0,))], "not both"),
    ):
        with pytest.raises(InputError, match=said):
            designs_of(axes)
    with pytest.raises(InputError, match="design_study"):
        tradeoff(field, [Axis("launches", (1.0,))])


def test_worths_and_prices_have_to_be_there() -> None:
    """No price at all, a price of kilograms without masses, no worth of a target: one sentence."""
    field, axes = rated(), [Axis("launches", (1.0,))]
    with pytest.raises(InputError, match="give --launch-cost"):
        design_study(field, axes)
    with pytest.raises(InputError, match="without masses"):
        design_study(adr_opt.generate("tiny", 0), axes, prices=PRICES)
    with pytest.raises(InputError, match="price of a kit: -1 euros"):
        CampaignPrices(kit=-1.0)
    strange = worths_of_sets(rated(targets=1)).among([])
    with pytest.raises(InputError, match="is among the 0 objects"):
        design_study(field, axes, prices=PRICES, worths=strange)
    first = field.targets[0]
    required = field.replace(targets=(first.replace(required=True), *field.targets[1:]))
    known = worths_of_sets(field).among([target.name for target in field.targets[1:]])
    with pytest.raises(InputError, match="is required, but has no worth"):
        design_study(required, axes, prices=PRICES, worths=known)
    part, rating = rating_of(field, known)
    assert rating.left_out == (first.name,)
    assert len(part.targets) == len(field.targets) - 1


def test_the_three_numbers_of_a_point_are_in_order() -> None:
    """Floors add up to at most what the set avoids, and that is at most the bound."""
    study = made()
    assert len(study.points) == study.wanted == 4
    worths = study.rating.worths
    assert worths is not None
    for point in study.points:
        assert point.plan is not None
        assert adr_opt.check(point.instance, point.plan) == ()
        chosen = point.plan.destinations
        assert point.removals == len(chosen)
        floors = dict(zip(worths.names, worths.floors, strict=True))
        assert point.floor == pytest.approx(sum(floors[name] for name in chosen))
        assert point.worth == pytest.approx(worths.of_set(chosen))
        assert point.floor <= point.worth <= point.bound
        assert point.bound <= worths.of_set(worths.names) * (1.0 + 1e-9)
    assert any(point.floor < point.worth < point.bound for point in study.points)


def test_euros_are_those_of_masses_at_launch() -> None:
    """Launches, kits and kilograms of the rocket equation, worked out from the legs."""
    for point in made().points:
        assert point.plan is not None
        euros = 0.0
        for route in point.plan.routes:
            if not route.legs:
                continue
            mass = 200.0
            for leg in reversed(route.legs):
                mass = (mass + 20.0) * math.exp(leg.delta_v_m_s / (300.0 * STANDARD_GRAVITY_M_S2))
            euros += 10.0 + 2.0 * len(route.legs) + 0.05 * mass
        assert point.euros == pytest.approx(euros)


def every_set(
    instance: Instance, worths: SetWorths, prices: CampaignPrices = PRICES
) -> list[tuple[float, float]]:
    """What each set of which a plan is found avoids, and the euros of the plan."""
    names, found = [target.name for target in instance.targets], []
    required = {target.name for target in instance.targets if target.required}
    most = sum(chaser.kits or 0 for chaser in instance.chasers)
    for size in range(1, min(len(names), most) + 1):
        for chosen in itertools.combinations(names, size):
            if not required.issubset(chosen):
                continue
            part = instance.part(chosen)
            targets = tuple(each.replace(required=True) for each in part.targets)
            part = part.replace(targets=targets)
            plan = adr_opt.solve(part, "exact", time_limit=WITNESS_S).plan
            if plan is not None:
                found.append((worths.of_set(chosen), prices.of_plan(part, plan)))
    return found


@pytest.mark.parametrize("seed", first_of(range(8), gate=1))
def test_bounds_hold_for_every_set_within_a_budget(seed: int) -> None:
    """No set of which a plan is found avoids more than the bound, whatever the budget."""
    field = rated(seed, targets=3 if seed == 0 else 4, chasers=2)
    worths = worths_of_sets(field, seed)
    budgets = (26.0, 47.0) if seed == 0 else (26.0, 31.0, 47.0, 60.0)
    study = design_study(
        field, [Axis("budget", budgets)], worths=worths, prices=PRICES, time_limit=LIMIT_S
    )
    sets = every_set(PRICES.applied(field), worths)
    for point, budget in zip(study.points, budgets, strict=True):
        most = max((worth for worth, euros in sets if euros <= budget), default=0.0)
        assert most <= point.bound * (1.0 + 1e-9)
        assert point.euros <= budget
    assert study.points[-1].worth > 0.0


@pytest.mark.parametrize("seed", first_of(range(12), gate=1))
def test_bounds_hold_where_targets_are_required(seed: int) -> None:
    """Required targets that one launch cannot take are no proof against two within the budget.

    Three targets are required, or four; launches have two kits each. The budgets are those of two
    launches with three and four kits, and a little more than the first.
    """
    prices = CampaignPrices(launch=10.0, kit=5.0)
    field = rated(seed, targets=4 if seed == 0 else 5, chasers=2)
    count, size = 3 + seed % 2, len(field.targets)
    field = field.replace(
        targets=tuple(each.replace(required=at < count) for at, each in enumerate(field.targets))
    )
    drawn = worths_of_sets(field, seed)
    alone = np.ones(size)
    alike = SetWorths(drawn.names, alone, np.zeros((size, size)), 1.0, 5.0, 50.0, drawn.names)
    axis = Axis("budget", (35.0, 40.0) if seed == 0 else (35.0, 37.0, 40.0))
    for worths, given in ((drawn, drawn), (alike, None)):
        study = design_study(field, [axis], worths=given, prices=prices, time_limit=LIMIT_S)
        sets = every_set(prices.applied(field), worths, prices)
        for point, budget in zip(study.points, axis.values, strict=True):
            most = max((worth for worth, euros in sets if euros <= budget), default=0.0)
            assert point.worth <= point.bound
            assert most <= point.bound * (1.0 + 1e-9)
        assert sets
        assert study.points[-1].bound > 0.0


def test_no_launch_within_a_budget_is_no_plan() -> None:
    """Below the price of a launch nothing is avoided, and that is proven."""
    study = design_study(rated(), [Axis("budget", (15.0,))], prices=PRICES, time_limit=LIMIT_S)
    (point,) = study.points
    assert (point.plan, point.worth, point.bound, point.euros) == (None, 0.0, 0.0, 0.0)
    assert study.front == ()


def test_prizes_of_the_instance_count_without_worths() -> None:
    """Plan, set and bound are those of `solve` then, and the expense of the file is the price."""
    field = PRICES.applied(rated(chasers=2))
    study = design_study(field, [Axis("kits", (1.0, 2.0))], time_limit=LIMIT_S)
    for point in study.points:
        kits = round(point.design.value("kits") or 0.0)
        own = field.replace(chasers=tuple(each.replace(kits=kits) for each in field.chasers))
        alone = adr_opt.solve(own, time_limit=LIMIT_S)
        assert point.floor == point.worth == alone.objective
        assert point.bound == alone.upper_bound
        assert alone.plan is not None
        assert point.euros == pytest.approx(alone.plan.cost)


def test_the_front_is_that_of_pairwise_comparison() -> None:
    """A point is on it unless another is as good in both and better in one, or equal and before."""
    field = rated()
    for seed in range(200):
        random = np.random.default_rng(seed)
        points = []
        for _ in range(12):
            worth, euros = random.integers(0, 6, 2)
            plan = made().points[0].plan if random.random() < 0.8 else None
            points.append(
                DesignPoint(
                    one("kits", 1.0), field, plan, 0.0, float(worth), 9.0, float(euros), 1, 1
                )
            )

        def beaten(at: int, points: list[DesignPoint] = points) -> bool:
            own = points[at]
            return any(
                other.plan is not None
                and other.worth >= own.worth
                and other.euros <= own.euros
                and ((other.worth, other.euros) != (own.worth, own.euros) or place < at)
                for place, other in enumerate(points)
                if place != at
            )

        expected = {
            at for at, point in enumerate(points) if point.plan is not None and not beaten(at)
        }
        assert set(pareto_front(points)) == expected


def test_a_broken_bound_is_noticed() -> None:
    """A plan that avoids more than a bound allows stops the study, and is no result."""
    field, point = rated(targets=4), made().points[-1]
    part, rating = rating_of(field, worths_of_sets(field))
    work = DesignWork(part, rating, PRICES, "auto", LIMIT_S, 0)
    with pytest.raises(RuntimeError, match="a method is broken"):
        work.point(point.design, point.instance, point.plan, 0.5 * point.worth)


def test_falling_prizes_are_no_worths_of_sets() -> None:
    """A design is compared by worths of one time: targets with a `prize_until` are refused."""
    field = rated()
    first, *others = field.targets
    falls = field.replace(targets=(first.replace(prize_until=((1e6, first.prize),)), *others))
    for worths in (worths_of_sets(field), None):
        with pytest.raises(
            InputError, match="a comparison of designs does not follow prizes that fall"
        ):
            rating_of(falls, worths)


@pytest.mark.slow
def test_bounds_that_are_with_neighbours_hold() -> None:
    """Of launches, kits and budgets at once no set of which a plan is found exceeds a bound."""
    field = rated(targets=3)
    worths = worths_of_sets(field)
    axes = [Axis("launches", (1.0, 2.0)), Axis("kits", (1.0, 2.0)), Axis("budget", (26.0, 47.0))]
    study = design_study(field, axes, worths=worths, prices=PRICES, time_limit=LIMIT_S)
    bounds = {point.design.values: point.bound for point in study.points}
    for design in designs_of(axes[:2]):
        sets = every_set(PRICES.applied(designed(field, design)), worths)
        for budget in axes[2].values:
            most = max((worth for worth, euros in sets if euros <= budget), default=0.0)
            assert most <= bounds[(*design.values, ("budget", budget))] * (1.0 + 1e-9)


def test_plans_and_bounds_are_with_neighbours_where_they_hold() -> None:
    """A design without a plan of its own takes one that it can fly, and the bound of more kits."""
    study = made()
    field, worths = rated(targets=4), study.rating.worths
    work = DesignWork(field, study.rating, PRICES, "auto", LIMIT_S, 0)
    first, last = study.points[0], study.points[-1]
    poor = [
        work.point(point.design, point.instance, None, 3.0 * last.bound)
        for point in study.points[:-1]
    ]
    handed = with_neighbours(work, [*poor, last])
    assert worths is not None
    assert all(point.bound <= last.bound for point in handed)
    for point in handed[:-1]:
        assert point.plan is None or adr_opt.check(point.instance, point.plan) == ()
    assert handed[-1] == last
    again = with_neighbours(work, [first, *study.points[1:]])
    for before, after in zip(study.points, again, strict=True):
        assert after.worth >= before.worth
        assert after.bound <= before.bound


def test_more_budget_takes_the_plan_of_less() -> None:
    """A larger budget without a plan flies that of a smaller one, and a smaller one does not."""
    field = rated(chasers=2)
    worths = worths_of_sets(field)
    study = design_study(
        field, [Axis("budget", (30.0, 80.0))], worths=worths, prices=PRICES, time_limit=LIMIT_S
    )
    small, large = study.points
    assert 0.0 < small.worth < large.worth
    work = DesignWork(field, study.rating, PRICES, "auto", LIMIT_S, 0)
    bare = work.point(large.design, large.instance, None, large.bound)
    assert [point.worth for point in with_neighbours(work, [small, bare])] == [small.worth] * 2
    bare = work.point(small.design, small.instance, None, small.bound)
    assert [point.worth for point in with_neighbours(work, [bare, large])] == [0.0, large.worth]
