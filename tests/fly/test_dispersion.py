"""Flights with errors: burns that err as Gates says, corrected on the way, and what tanks need."""

from __future__ import annotations

import dataclasses
import json
import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from conftest import Cli, refused
from drifting_plans import drifting_instance, drifting_plan
from plans import moved_to, solved, unjudged

import adr_opt
from adr_opt.fly.dispersion import Dispersion, FlightErrors, Quantile, sample_flights, usable_tank
from adr_opt.fly.dispersion.feedback import LegPart, fly, parts_of
from adr_opt.fly.dispersion.flown_leg import fly_exactly
from adr_opt.fly.flight.tanks import legs_by_tank, tanks_of
from adr_opt.plan.refined_plan import RefinedPlan
from adr_opt.problem.instance import Instance
from adr_opt.problem.uncertainty import Uncertainty

NONE = FlightErrors(0.0, 0.0, 0.0, 0.0)


@cache
def mission(freedom: str = "free") -> tuple[Instance, RefinedPlan]:
    """A tiny mission under J2, refined."""
    instance = adr_opt.generate("tiny", 0).replace(dynamics="j2")
    return instance, adr_opt.refine(instance, solved(instance), freedom=freedom)


@cache
def sampled(flights: int = 400, **changes: float) -> Dispersion:
    """Flights of it with errors."""
    return sample_flights(*mission(), flights, FlightErrors(**changes))


def first_part(freedom: str = "free", corrections: int = 1) -> LegPart:
    return parts_of(mission(freedom)[1].legs[0], "j2", corrections)[0]


def unguided(part: LegPart) -> LegPart:
    """The part without feedback."""
    return dataclasses.replace(part, gains=(None,) * len(part.gains))


@pytest.mark.parametrize("freedom", ["free", "planned"])
def test_without_errors_a_flight_is_the_refined_one(freedom: str) -> None:
    """With no errors every flight takes the refined ΔV, meets its stand-offs and does not wait."""
    instance, refined = mission(freedom)
    found = sample_flights(instance, refined, 20, NONE)
    for leg, flown in zip(refined.legs, found.legs, strict=True):
        assert flown.mean_delta_v_m_s == pytest.approx(leg.flown_delta_v_m_s, abs=1e-4)
        assert flown.standoff_miss_m.value < 0.01
        assert flown.arrival_miss_m.value < 0.01
    assert found.waits_s.value == found.late_share == 0.0
    assert found.linearity.standoff_m < 0.1
    assert found.linearity.delta_v_m_s < 1e-3


def test_burns_err_along_and_across_as_said() -> None:
    """Sizes err by the share that is said, directions by the angle about both axes, unbiased."""
    errors = FlightErrors(burn_magnitude=0.01, burn_pointing_deg=2.0)
    burn = np.array([30.0, -40.0, 120.0])
    drawn = np.random.default_rng(0).standard_normal((3, 40000))
    error = errors.of_burns(np.repeat(burn[:, None], 40000, axis=1), drawn) - burn[:, None]
    along = burn / 130.0
    side = np.cross(along, [1.0, 0.0, 0.0])
    side /= np.linalg.norm(side)
    wanted = {
        "along": (along, 1.3),
        "side": (side, 130.0 * math.radians(2.0)),
        "up": (np.cross(along, side), 130.0 * math.radians(2.0)),
    }
    for direction, sigma in wanted.values():
        part = direction @ error
        assert part.std() == pytest.approx(sigma, rel=0.02)
        assert abs(part.mean()) < 4.0 * sigma / 200.0
    assert not errors.of_burns(np.zeros((3, 5)), drawn[:, :5]).any()


@pytest.mark.parametrize("freedom", ["free", "planned"])
def test_flights_are_nearly_linear(freedom: str) -> None:
    """Flown exactly, flights take and miss as much, to a small share of what errors cost."""
    found = sample_flights(*mission(freedom), 200, FlightErrors())
    extra = found.delta_v_m_s.value - found.refined_delta_v_m_s
    assert extra > 1.0
    assert found.linearity.flights == 10
    assert found.linearity.delta_v_m_s < 0.02 * extra
    worst = max(leg.standoff_miss_m.value for leg in found.legs)
    assert found.linearity.standoff_m < max(0.1 * worst, 5.0)


@pytest.mark.slow
def test_weeks_of_drift_are_nearly_linear() -> None:
    """Errors that grow for weeks are still led back, and exact flights say the same."""
    instance, plan = drifting_instance(), drifting_plan()
    refined = adr_opt.refine(instance, plan)
    found = sample_flights(instance, refined, 100)
    extra = found.delta_v_m_s.value - found.refined_delta_v_m_s
    assert found.linearity.delta_v_m_s < 0.1 * extra
    assert found.legs[1].standoff_miss_m.value < 1000.0


def test_the_derivatives_are_those_of_the_flight() -> None:
    """A little more in each burn, flown, moves the end by what the linear part says."""
    part = unguided(first_part())
    nothing, zeros = np.zeros(6), np.zeros((part.times.size, 3))
    for at in range(part.times.size):
        more = part.impulses.copy()
        more[at] += (0.003, -0.002, 0.004)
        _, moved = fly_exactly(dataclasses.replace(part, impulses=more), nothing, zeros, NONE)
        said = part.states @ part.effects[at] @ (more[at] - part.impulses[at])
        assert np.linalg.norm(moved[:3] - said[:3]) < 0.01 * np.linalg.norm(said[:3]) + 0.01
    off = np.array([20.0, -10.0, 30.0, 0.01, 0.02, -0.03])
    _, moved = fly_exactly(part, off, zeros, NONE)
    said = part.states @ part.beginning @ off
    assert np.linalg.norm(moved[:3] - said[:3]) < 0.01 * np.linalg.norm(said[:3])


def test_corrections_lead_back() -> None:
    """Without feedback flights miss by many times as much; more corrections miss by less."""
    part = first_part()
    rng = np.random.default_rng(1)
    errors = FlightErrors()
    begun = errors.of_departure(rng.standard_normal((6, 300)))
    drawn = rng.standard_normal((part.times.size, 3, 300))
    led = fly(part, begun, drawn, errors).miss
    left = fly(unguided(part), begun, drawn, errors)
    median, without = (np.median(np.linalg.norm(m[:3], axis=0)) for m in (led, left.miss))
    assert median < 0.2 * without
    none, some = (
        sample_flights(*mission(), 300, corrections=number).leg_standoff_miss_m for number in (0, 1)
    )
    assert np.median(some) < 0.2 * np.median(none)


@pytest.mark.parametrize("freedom", ["free", "planned"])
def test_what_a_stop_leaves_wrong_is_corrected_on_the_approach(freedom: str) -> None:
    """Chasers meet their targets within metres, and without pure corrections ten times worse."""
    none, two = (
        [leg.arrival_miss_m.value for leg in sample_flights(*mission(freedom), 300, **said).legs]
        for said in ({"corrections": 0}, {"corrections": 2})
    )
    assert max(two) < 5.0
    assert np.median(two) < 0.1 * np.median(none)


def test_the_first_burn_knows_nothing() -> None:
    """The burn that begins a leg is made as planned, whatever the state; the next is not."""
    part = first_part()
    first = int(np.flatnonzero(part.impulses.any(axis=1))[0])
    assert all(gain is None for gain in part.gains[: first + 1])
    assert all(gain is not None for gain in part.gains[first + 1 :])


def test_larger_errors_need_more() -> None:
    """Twice the errors at the same draws miss by twice as much uncorrected, and cost more."""
    twice = {
        "burn_magnitude": 0.01,
        "burn_pointing_deg": 1.0,
        "navigation_position_m": 20.0,
        "navigation_velocity_m_s": 0.02,
    }
    part = unguided(first_part())
    drawn = np.random.default_rng(2).standard_normal((part.times.size + 2, 3, 100))
    missed = [
        fly(part, errors.of_departure(drawn[:2].reshape(6, 100)), drawn[2:], errors).miss
        for errors in (FlightErrors(), FlightErrors(**twice))
    ]
    assert np.allclose(missed[1], 2.0 * missed[0], rtol=1e-6, atol=1e-6)
    small, large = sampled(), sampled(**twice)
    assert np.median(large.leg_standoff_miss_m / small.leg_standoff_miss_m) > 2.0
    assert large.delta_v_m_s.value > small.delta_v_m_s.value > small.refined_delta_v_m_s


def test_totals_are_those_of_the_legs() -> None:
    """Tanks and the whole are sums over legs, flight by flight."""
    found = sampled()
    whole = Quantile.of(found.leg_delta_v_m_s.sum(axis=0), 0.95)
    assert found.delta_v_m_s == whole
    assert found.tanks[0].first_leg == 1
    assert sum(tank.last_leg - tank.first_leg + 1 for tank in found.tanks) == len(found.legs)
    for tank in found.tanks:
        rows = found.leg_delta_v_m_s[tank.first_leg - 1 : tank.last_leg]
        assert tank.delta_v_m_s == Quantile.of(rows.sum(axis=0), 0.95)


def test_the_seed_decides_and_threads_do_not() -> None:
    """Same seed, same flights, with any number of threads; another seed, others."""
    one, three, other = (
        sample_flights(*mission(), 50, seed=seed, jobs=jobs)
        for seed, jobs in ((3, 1), (3, 3), (4, 1))
    )
    assert one.to_dict() == three.to_dict()
    assert one.delta_v_m_s != other.delta_v_m_s


def test_a_quantile_knows_how_well_it_is_known() -> None:
    """The interval holds the true quantile in some 95 of 100 samples, and few draws have none."""
    rng = np.random.default_rng(0)
    held = 0
    for _ in range(1000):
        found = Quantile.of(rng.exponential(size=500), 0.95)
        assert found.low is not None
        assert found.high is not None
        assert found.low <= found.value <= found.high
        held += found.low <= -math.log(0.05) <= found.high
    assert 0.93 < held / 1000 < 0.98
    few = Quantile.of(np.arange(20.0), 0.95)
    assert (few.value, few.high) == (18.0, None)


def test_a_tank_that_errors_break_is_named() -> None:
    """A tank that is just enough without errors is not enough with them, in most flights."""
    instance, refined = mission()
    need = max(tank.refined_delta_v_m_s for tank in sampled().tanks)
    tight = instance.with_limits(delta_v_m_s=need + 0.01)
    same = moved_to(tight, refined)
    found = sample_flights(tight, same, 200)
    assert len(found.broken_tanks) == 1
    assert found.broken_tanks[0].breaks_share > 0.5
    assert not sampled().broken_tanks


def test_flights_that_miss_by_far_wait() -> None:
    """Half the distance of the stand-off and more is a revolution of waiting, counted by flight."""
    found = sampled(burn_magnitude=0.1, burn_pointing_deg=8.0)
    far = found.leg_standoff_miss_m > 500.0
    assert 0.0 < far.mean() < 1.0
    assert [leg.waits_share for leg in found.legs] == pytest.approx(far.mean(axis=1).tolist())
    assert 5000.0 < found.waits_s.value < 7000.0 * len(found.legs)
    instance, refined = mission()
    departures = [leg.states[0].time_s for leg in refined.legs[1:]]
    departures.append(instance.mission.duration_s)
    spare = [at - leg.end_s for at, leg in zip(departures, refined.legs, strict=True)]
    assert not any(5000.0 < one < 7000.0 for one in spare), "a revolution decides"
    short = np.array(spare) < 6000.0
    assert short.any()
    assert found.late_share == pytest.approx(far[short].any(axis=0).mean())


def test_wrong_parameters_are_one_sentence() -> None:
    """What cannot be flown is said."""
    instance, refined = mission()
    with pytest.raises(adr_opt.InputError, match=r"burn_magnitude = -0\.1: must lie between"):
        FlightErrors(burn_magnitude=-0.1)
    with pytest.raises(adr_opt.InputError, match="navigation_position_m = nan"):
        FlightErrors(navigation_position_m=math.nan)
    with pytest.raises(adr_opt.InputError, match="flights = 0"):
        sample_flights(instance, refined, 0)
    with pytest.raises(adr_opt.InputError, match="corrections = 11"):
        sample_flights(instance, refined, 5, corrections=11)
    with pytest.raises(adr_opt.InputError, match="seed = -1"):
        sample_flights(instance, refined, 5, seed=-1)
    with pytest.raises(adr_opt.InputError, match="share = 1"):
        sample_flights(instance, refined, 5, share=1.0)
    with pytest.raises(adr_opt.InputError, match="belongs to the instance"):
        sample_flights(adr_opt.generate("tiny", 2), refined, 5)
    with pytest.raises(adr_opt.InputError, match=r"leg \d: a flight with errors leads"):
        sample_flights(instance, refined, 10, FlightErrors(0.2, 10.0, 1e5, 100.0), corrections=0)
    with pytest.raises(adr_opt.InputError, match="no legs"):
        sample_flights(instance, unjudged(instance, refined.replace(legs=())), 5)


def test_fly_tells_of_errors(cli: Cli) -> None:
    """`fly --samples` prints quantiles and JSON, and ends with 1 where 95 % break a tank."""
    instance, refined = mission()
    Path("my.json").write_text(instance.to_json(), encoding="utf-8")
    refined.save("refined.json")
    told = cli("fly", "my.json", "refined.json", "--samples", "200", "--seed", "5")
    assert told.status == 0, told.err
    assert "200 flights with errors of 0.005 of a burn, 0.5°, 10 m and 0.01 m/s" in told.out
    assert "flown without linearisation, 10 flights differ" in told.out
    as_json = cli(
        "fly my.json refined.json --samples 200 --burn-pointing-error 1 "
        "--burn-magnitude-error 0.02 --navigation-position-error 100 "
        "--navigation-velocity-error 0.1 --corrections 1 --json"
    )
    found = json.loads(as_json.out)["errors"]
    errors = FlightErrors(0.02, 1.0, 100.0, 0.1)
    wanted = sample_flights(instance, refined, 200, errors, corrections=1).to_dict()
    assert found == json.loads(json.dumps(wanted))
    need = max(tank.refined_delta_v_m_s for tank in sampled().tanks)
    tight = instance.with_limits(delta_v_m_s=need + 0.01)
    Path("tight.json").write_text(tight.to_json(), encoding="utf-8")
    moved_to(tight, refined).save("same.json")
    assert cli("fly", "tight.json", "same.json").status == 0
    broken = cli("fly", "tight.json", "same.json", "--samples", "200")
    assert broken.status == 1
    assert "is not enough" in broken.out


def test_errors_go_with_samples_of_refined_plans(cli: Cli) -> None:
    """Errors without a number of flights, or of a plan as solved, are refused in a sentence."""
    instance, refined = mission()
    Path("my.json").write_text(instance.to_json(), encoding="utf-8")
    solved(instance).save("plan.json")
    refined.save("refined.json")
    refused(cli("fly", "my.json", "refined.json", "--seed", "1"), "--seed needs --samples")
    refused(cli("fly", "my.json", "plan.json", "--samples", "9"), "plan.json: flights with errors")
    refused(cli("fly", "my.json", "refined.json", "--samples", "0"), "flights = 0")
    refused(
        cli("fly", "my.json", "refined.json", "--samples", "9", "--burn-pointing-error", "80"),
        "burn_pointing_deg = 80",
    )
    refused(
        cli("fly", "my.json", "refined.json", "--out-uncertainty", "u.json"),
        "--out-uncertainty needs --samples",
    )
    refused(
        cli("fly", "my.json", "refined.json", "--samples", "9", "--out-uncertainty", "my.json"),
        "my.json: this is the input",
    )


def test_without_errors_the_usable_share_is_planned_over_refined() -> None:
    """Flights without errors leave each tank the share that planned legs are of refined ones."""
    instance, refined = mission()
    found = usable_tank(instance, refined, sample_flights(instance, refined, 20, NONE))
    tanks = tanks_of(instance, refined)
    shares = [tank.planned_delta_v_m_s / (tank.flown_delta_v_m_s or 0.0) for tank in tanks]
    middle, spread = float(np.mean(shares)), math.sqrt(3.0) * float(np.std(shares))
    assert found.least == pytest.approx(min(middle - spread, 1.0), abs=1e-6)
    assert found.most == pytest.approx(min(middle + spread, 1.0), abs=1e-6)


def test_the_usable_share_has_the_moments_of_the_flights() -> None:
    """The uniform share has mean and deviation of planned over flown ΔV of the tanks of flights."""
    instance, refined = mission()
    drawn = sampled(burn_magnitude=0.05, burn_pointing_deg=3.0)
    # Legs that take half as much again, so that nothing is cut off at a full tank.
    flights = dataclasses.replace(drawn, leg_delta_v_m_s=1.5 * drawn.leg_delta_v_m_s)
    found = usable_tank(instance, refined, flights)
    row = {leg.leg: at for at, leg in enumerate(refined.legs)}
    shares = np.concatenate(
        [
            sum(leg.planned_delta_v_m_s for leg in one.legs)
            / flights.leg_delta_v_m_s[[row[leg.leg] for leg in one.legs]].sum(axis=0)
            for one in legs_by_tank(instance, refined)
        ]
    )
    assert found.most < 1.0
    assert found.moments == pytest.approx((shares.mean(), shares.std()), rel=1e-9)


def test_fly_writes_an_uncertainty_that_rehearse_reads(cli: Cli) -> None:
    """`--out-uncertainty` writes the usable share of tanks, and rehearsals fly with it."""
    instance, refined = mission()
    instance.save("my.json")
    solved(instance).save("plan.json")
    refined.save("refined.json")
    written = cli(
        "fly my.json refined.json --samples 50 --burn-magnitude-error 0.1 --out-uncertainty "
        "learnt.json"
    )
    assert "wrote learnt.json" in written.err
    learnt = Uncertainty.load("learnt.json")
    flights = sample_flights(instance, refined, 50, FlightErrors(burn_magnitude=0.1))
    assert learnt == Uncertainty(tanks=usable_tank(instance, refined, flights))
    rehearsed = cli("rehearse my.json plan.json --uncertainty learnt.json --samples 20 --json")
    assert rehearsed.status == 0, rehearsed.err
