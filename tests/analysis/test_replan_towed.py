"""Going on where objects are towed: with one that is still to be towed, or after the last tow."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from on_from import Field, most, rest_of, violations
from plain_world import tow_of
from seeds import first_of, over_kinds, over_seeds
from towed_fields import TANK, drawn

import adr_opt
from adr_opt.analysis import Replanned, price, replan
from adr_opt.analysis.replan.chaser_states import states_at
from adr_opt.common.errors import InputError
from adr_opt.fly.flight import fly
from adr_opt.kernels.orbits import columns, ephemeris
from adr_opt.legs.connection_finder import ConnectionFinder
from adr_opt.plan.after_tows import leaving_orbits
from adr_opt.plan.cargo import followed
from adr_opt.plan.plan import Plan
from adr_opt.problem.chasers import InOrbit
from adr_opt.problem.instance import Instance


@over_kinds("seeds", drawn=(range(36), 4))
def test_what_is_flown_and_the_rest_are_one_mission(seeds: range) -> None:
    """At any time, with targets lost or legs kept, they stay as they were, and `check` passes."""
    put = waits = 0
    for seed in seeds:
        instance = drawn(seed)
        method = "greedy" if seed % 8 < 4 else "auto"
        plan = adr_opt.solve(instance, method, time_limit=2).plan
        if plan is None or not plan.legs:
            continue
        rng = np.random.default_rng([22, seed])
        over_s = max(leg.done_s for leg in plan.legs)
        at_s = min(float(rng.uniform(0.0, 1.05 * over_s)), instance.mission.duration_s)
        made = rest_of(instance, plan, at_s, rng, seed)
        if made is None:
            continue
        put += sum(state.is_put for state in made.states)
        waits += any("waits" in note for note in made.notes)
    assert put > len(seeds) / 6
    assert waits < 5


@cache
def simple(seed: int, dynamics: str = "two-body") -> tuple[Instance, Plan]:
    """Six objects, most of them towed, without a station, and the best plan."""
    field = adr_opt.generate("tiny", seed, targets=6).with_limits(duration_s=130_000.0)
    rng = np.random.default_rng([23, seed])
    start = InOrbit(orbit=field.stations[0].orbit)
    instance = field.replace(
        dynamics=dynamics,
        stations=(),
        chasers=(field.chaser.replace(start=start, tank=TANK),),
        targets=tuple(
            target.replace(
                removal="tow" if number % 3 else "visit",
                mass_kg=250.0,
                prize=float(rng.integers(1, 5)),
            )
            for number, target in enumerate(field.targets)
        ),
        mission=field.mission.replace(disposal={"circle_m": 450e3}),
    )
    plan = adr_opt.solve(instance, "exact", time_limit=30.0).plan
    assert plan is not None
    assert len(plan.lead_ins) > 0
    return instance, plan


def as_enumerated(instance: Instance) -> Field:
    """The connections of the whole, and what targets take of time and of a tank."""
    connecting, number = ConnectionFinder(instance), {n: at for at, n in enumerate(instance.names)}
    tows = {
        target.name: tow_of(target, instance)
        for target in instance.targets
        if target.removal == "tow"
    }
    service = instance.mission.service_revolutions
    stays = {
        target.name: service * ephemeris.revolution_at(instance.orbits()[number[target.name]], 0.0)
        + tows.get(target.name, (0.0,))[0]
        for target in instance.targets
    }
    dry, exhaust = TANK["dry_mass_kg"], 9.80665 * TANK["isp_s"]

    @cache
    def rows(origin: str, destination: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        found = connecting.of_pair(number[origin], number[destination], 0.0)
        return found.departure, found.arrival, found.delta_v

    def after(name: str, left_m_s: float) -> float:
        if name not in tows:
            return left_m_s
        _, delta_v, mass_kg, _ = tows[name]
        both_kg = dry * math.exp(left_m_s / exhaust) + mass_kg
        kept_kg = both_kg * math.exp(-delta_v / exhaust) - mass_kg
        return exhaust * math.log(max(kept_kg, 1e-6) / dry)

    prizes = {target.name: target.prize for target in instance.targets}
    return Field(rows, prizes, stays, instance.mission.duration_s, after)


@pytest.mark.parametrize("dynamics", first_of(["j2", "two-body"], gate=1))
@over_seeds(range(3), gate=1)
def test_the_rest_is_the_best_there_is(seed: int, dynamics: str) -> None:
    """Nothing collects more on from the object that is towed, by the connections of the whole."""
    instance, plan = simple(seed, dynamics)
    field = as_enumerated(instance)
    put = 0
    for before, leg in zip(plan.legs, plan.legs[1:], strict=False):
        at_s = before.end_s + 1.0
        for lost in ([], [leg.destination]):
            (state,) = states_at(instance, plan, at_s)
            if state.legs[-1] != before:
                continue
            made = replan(instance, plan, at_s, lost=lost, method="exact", time_limit=60.0)
            left = followed(
                instance, instance.chaser, [(x.destination, x.delta_v_m_s) for x in state.legs]
            )[-1].left_m_s
            tow_s = before.free_s - before.end_s
            todo = frozenset(field.prizes) - {x.destination for x in state.legs} - set(lost)
            best = most(field, state.body, at_s + tow_s, left, todo)
            assert made.prize_after == best, (at_s, lost)
            assert violations(instance, made) == (), (at_s, lost)
            put += state.is_put
    assert put > 0


def test_a_tow_that_has_begun_leads_into_the_next_leg() -> None:
    """The next leg leaves as the tow ends, so that it has begun with the tow, and is finished."""
    instance, plan = simple(0)
    number = next(iter(plan.lead_ins))
    tow, leg = plan.legs[number - 2].tow, plan.legs[number - 1]
    for share in (0.01, 0.5, 1.0):
        at_s = tow.start_s + share * (tow.end_s - tow.start_s)
        (state,) = states_at(instance, plan, at_s)
        assert state.legs == plan.legs[:number]
    (state,) = states_at(instance, plan, tow.start_s)
    assert state.legs == plan.legs[: number - 1]
    assert state.is_put
    with pytest.raises(InputError, match=f"failed leg {number}: it has begun at {tow.start_s:.0f}"):
        replan(instance, plan, at_s, failed=number)
    with pytest.raises(InputError, match="the leg to it has begun"):
        replan(instance, plan, at_s, lost=[leg.destination])


def test_an_object_is_towed_where_nothing_is_left_to_do() -> None:
    """Who waits with an object for a leg that is lost tows it down now, and not in the past."""
    instance, plan = simple(0)
    number = next(iter(plan.lead_ins))
    before = plan.legs[number - 2]
    at_s = 0.5 * (before.end_s + before.tow.start_s)
    done = plan.destinations[: number - 1]
    lost = [target.name for target in instance.targets if target.name not in done]
    made = replan(instance, plan, at_s, lost=lost)
    (route,) = made.whole()
    assert route.legs[-1].tow.start_s == pytest.approx(at_s)
    assert violations(instance, made) == ()
    late = instance.mission.duration_s + 1.0
    tow = route.legs[-1].tow.replace(end_s=late)
    legs = (*made.plan.legs[:-1], made.plan.legs[-1].replace(tow=tow))
    (whole,) = made.plan.routes
    wrong = made.plan.replace(routes=(whole.replace(legs=legs),))
    assert "duration" in {found.rule for found in adr_opt.check(made.instance, wrong)}


@pytest.mark.parametrize("dynamics", ["two-body", "j2"])
@pytest.mark.slow
def test_after_the_last_tow_a_chaser_is_on_the_disposal_orbit(dynamics: str) -> None:
    """It is where the tow has led, with what is left, and what it flies from there can be flown."""
    instance, plan = simple(1, dynamics)
    instance = instance.replace(objective={"cost": "duration"})
    order = plan.destinations[: min(plan.lead_ins) - 1]
    short = price(instance, {instance.chaser.name: order}).plan()
    end = short.legs[-1].tow
    made = replan(instance, short, end.end_s + 1000.0)
    (state,) = made.states
    assert state.is_released
    assert made.instance.chaser.tank.initial_propellant_kg == pytest.approx(
        short.legs[-1].mass_kg - TANK["dry_mass_kg"]
    )
    body = made.instance.names.index(instance.chaser.name)
    row = made.instance.orbits()[body]
    left = leaving_orbits(instance, None)[instance.names.index(order[-1])]
    for angle in (ephemeris.node_at, ephemeris.latitude_at):
        off = math.remainder(angle(row, end.end_s) - angle(left, end.end_s), 2.0 * math.pi)
        assert abs(off) < 1e-9
    assert row[columns.RADIUS] == left[columns.RADIUS]
    assert adr_opt.check(made.instance, made.plan) == ()
    assert made.prize_after > 0.0
    assert "waits" in made.notes[0]
    assert fly(made.instance, made.plan).worst_miss_m < 0.1


def pair(service_s: float, apart_s: float | None = None) -> tuple[Instance, Plan]:
    """Two chasers that tow two objects each, listed after two that are still to be launched."""
    drawn, _ = simple(1)
    mission = drawn.mission.replace(
        service_revolutions=None, service_s=service_s, launch_separation_s=apart_s
    )
    free = drawn.chaser.replace(name="free", start="anywhere", available_s=(1000.0, None))
    second = drawn.chaser.replace(name="second")
    instance = drawn.replace(
        mission=mission,
        objective={"cost": "duration"},
        chasers=(free, free.replace(name="freer"), drawn.chaser, second),
    )
    towed = [target.name for target in instance.targets if target.removal == "tow"]
    orders = {drawn.chaser.name: towed[:2], "second": towed[:1:-1]}
    plan = price(instance, orders).plan()
    assert len(plan.lead_ins) == 2
    return instance, plan


def replanned(instance: Instance, plan: Plan, at_s: float) -> Replanned:
    """The rest, in which all who are put somewhere are, and that passes."""
    made = replan(instance, plan, at_s, time_limit=60.0)
    assert adr_opt.check(made.instance, made.plan) == ()
    assert violations(instance, made) == ()
    first = {route.chaser: route.legs[0] for route in made.plan.routes if route.legs}
    for state in made.states:
        assert not state.is_put or first[state.chaser.name].destination == state.body
    return made


@pytest.mark.parametrize("apart_s", [None, 20_000.0])
@pytest.mark.parametrize("service_s", [0.0, 5400.0])
def test_who_is_on_the_way_to_an_object_tows_it(service_s: float, apart_s: float | None) -> None:
    """Others do not take it over, though its chaser would be free to begin anywhere else then.

    And the launches that are still to come stay apart.
    """
    instance, plan = pair(service_s, apart_s)
    for number in plan.lead_ins:
        leg = plan.legs[number - 2]
        made = replanned(instance, plan, leg.arrival_s - 5000.0)
        assert any(state.is_put for state in made.states)
        launches = sorted(state.free_s for state in made.states if state.body is None)
        assert launches[1] - launches[0] >= (apart_s or 0.0) - 1e-6


def test_chasers_that_wait_with_objects_do_not_change_places() -> None:
    """Of two who could be put onto either of two objects each is put onto its own at once.

    So nobody has to be kept waiting for that, nor the former plan to be flown on.
    """
    instance, plan = pair(5400.0)
    waits = [plan.legs[number - 2] for number in plan.lead_ins]
    since_s = max(leg.end_s for leg in waits)
    until_s = min(leg.tow.start_s for leg in waits)
    for share in (0.1, 0.3, 0.5, 0.7, 0.9):
        at_s = since_s + share * (until_s - since_s)
        made = replanned(instance, plan, at_s)
        assert sum(state.is_put for state in made.states) == 2
        assert all(state.free_s < at_s + 0.1 for state in made.states)
        assert made.result.method != "former"
