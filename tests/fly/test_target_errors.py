"""Flights to targets that are elsewhere than planned: what it takes to find them in time."""

from __future__ import annotations

import dataclasses
import json
import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from conftest import Cli, refused
from plans import solved

import adr_opt
from adr_opt.common.constants import DAY_S, MU_M3_S2
from adr_opt.fly.dispersion import Dispersion, FlightErrors, sample_flights
from adr_opt.fly.dispersion.displaced import DisplacedBodies
from adr_opt.fly.dispersion.feedback import BodiesOff, UncertainEnds, fly, part
from adr_opt.fly.dispersion.flown_leg import fly_exactly, moved
from adr_opt.fly.refine.bodies import moved as coasted
from adr_opt.fly.refine.bodies import state_of
from adr_opt.kernels.orbits import equinoctial
from adr_opt.kernels.orbits.gravity import FIELDS
from adr_opt.kernels.orbits.short_periods import mean_elements
from adr_opt.plan.refined_plan import RefinedBurn, RefinedPlan
from adr_opt.problem.instance import Instance
from adr_opt.sources.uncertainty import TargetError

NONE = FlightErrors(0.0, 0.0, 0.0, 0.0)


@cache
def mission() -> tuple[Instance, RefinedPlan]:
    """A tiny mission under J2, refined."""
    instance = adr_opt.generate("tiny", 0).replace(dynamics="j2")
    return instance, adr_opt.refine(instance, solved(instance))


def elements_error(along_m: float = 0.0, decay_m_per_day: float = 0.0) -> TargetError:
    covariance = np.zeros((7, 7))
    covariance[5, 5], covariance[6, 6] = along_m**2, decay_m_per_day**2
    return TargetError(covariance, "elements")


def rtn_error() -> TargetError:
    """Correlated: an error outward, and one along the track of the velocity that holds it there."""
    wide = np.zeros((7, 3))
    wide[:, 0] = (40.0, 0.0, 0.0, 0.0, -0.08, 0.0, 0.0)
    wide[:, 1] = (0.0, 900.0, 100.0, 0.0, 0.0, 0.1, 0.0)
    wide[:, 2] = (10.0, 0.0, 300.0, 0.05, 0.0, 0.0, 0.0)
    return TargetError(wide @ wide.T)


def test_errors_of_nothing_change_nothing() -> None:
    """With errors that are zero every flight is the one without them, bit for bit."""
    instance, refined = mission()
    plain = sample_flights(instance, refined, 60)
    nothing = {target.name: TargetError(np.zeros((7, 7))) for target in instance.targets}
    found = sample_flights(instance, refined, 60, targets=nothing, known_before_s=100.0)
    assert np.array_equal(found.leg_delta_v_m_s, plain.leg_delta_v_m_s)
    assert np.array_equal(found.leg_standoff_miss_m, plain.leg_standoff_miss_m)
    assert found.to_dict() == plain.to_dict()


def clohessy_wiltshire(n: float, t: float) -> np.ndarray:
    """State at a time by an impulse at zero, in axes outward, along and across.

    W. Clohessy and R. Wiltshire, Journal of the Aerospace Sciences 27(9), 1960.
    """
    s, c = math.sin(n * t), math.cos(n * t)
    return np.array(
        [
            [s / n, 2.0 * (1.0 - c) / n, 0.0],
            [2.0 * (c - 1.0) / n, (4.0 * s - 3.0 * n * t) / n, 0.0],
            [0.0, 0.0, s / n],
            [c, 2.0 * s, 0.0],
            [-2.0 * s, 4.0 * c - 3.0, 0.0],
            [0.0, 0.0, c],
        ]
    )


@pytest.mark.parametrize("along_m", [-2000.0, 500.0, 4000.0])
def test_an_error_along_the_track_takes_what_linear_motion_says(along_m: float) -> None:
    """A target ahead, known a revolution before, costs the least squares of four impulses."""
    radius = 7.1e6
    n = math.sqrt(MU_M3_S2 / radius**3)
    revolution = math.tau / n
    start = np.array([radius, 0.0, 0.0, 0.0, radius * n, 0.0])
    end = 3.0 * revolution
    burns = tuple(
        RefinedBurn(time_s=at, delta_v_m_s=(0.0, 0.0, 0.0), phase="transfer") for at in (0.0, end)
    )
    made = part(
        start, 0.0, burns, end, "two-body", 2, UncertainEnds(tracked_s=end - revolution), blind=True
    )
    ahead = np.array([0.0, 0.0, 0.0, 0.0, 0.0, along_m / radius])
    off = BodiesOff(np.zeros((6, 1)), ahead[:, None])
    drawn = np.zeros((made.times.size, 3, 1))
    flown = fly(made, np.zeros((6, 1)), drawn, NONE, off)
    effects = [clohessy_wiltshire(n, revolution * left) for left in (1.0, 2 / 3, 1 / 3, 0.0)]
    impulses = np.linalg.pinv(np.hstack(effects)) @ [0.0, along_m, 0.0, 0.0, 0.0, 0.0]
    wanted = np.linalg.norm(impulses.reshape(4, 3), axis=1).sum()
    assert 2.0 / 3.0 * abs(along_m) / revolution < wanted < 0.9 * abs(along_m) / revolution
    assert flown.delta_v_m_s[0] == pytest.approx(wanted, rel=2e-3)
    assert np.linalg.norm(flown.miss[:3]) < 1e-3 * abs(along_m)
    spent, miss = fly_exactly(
        made, np.zeros(6), drawn[:, :, 0], NONE, BodiesOff(np.zeros(6), ahead)
    )
    assert spent == pytest.approx(wanted, rel=5e-3)
    assert np.linalg.norm(miss[:3]) < 1e-3 * abs(along_m)
    there = moved(made.goal, ahead)
    assert np.linalg.norm(there[:3] - made.goal[:3]) == pytest.approx(abs(along_m), rel=1e-4)


def test_a_first_burn_knows_its_origin_and_not_the_errors_of_navigation() -> None:
    """The first burn makes up for where the origin is, and for nothing else: the rest comes later.

    Flown exactly it is as large, and without errors of the origin it is that of the plan.
    """
    _, refined = mission()
    leg = refined.legs[0]
    first = next(at for at, burn in enumerate(leg.burns) if burn.phase == "approach")
    made = part(
        state_of(leg.states[0]),
        leg.states[0].time_s,
        leg.burns[:first],
        leg.standoff_s,
        "j2",
        0,
        UncertainEnds(origin=True),
        blind=True,
    )
    begun = np.array([30.0, -20.0, 10.0, 0.02, 0.01, -0.03])
    nowhere, drawn = np.zeros(6), np.zeros((made.times.size, 3))
    ahead = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 3000.0 / 7e6])
    alone = dataclasses.replace(made, gains=(made.gains[0], *[None] * (len(made.gains) - 1)))
    for origin, changes in ((nowhere, False), (ahead, True)):
        off = BodiesOff(origin[:, None], np.zeros((6, 1)))
        spent = fly(alone, begun[:, None], drawn[:, :, None], NONE, off).delta_v_m_s[0]
        without = fly(alone, np.zeros((6, 1)), drawn[:, :, None], NONE, off).delta_v_m_s[0]
        planned = np.linalg.norm(made.impulses, axis=1).sum()
        assert spent == pytest.approx(without, abs=1e-12)
        assert (abs(spent - planned) > 1e-3) == changes
        exact, _ = fly_exactly(alone, begun, drawn, NONE, BodiesOff(origin, nowhere))
        assert exact == pytest.approx(spent, abs=1e-4)


def displaced(error: TargetError, flights: int) -> tuple[DisplacedBodies, str, np.ndarray]:
    """A target with an error, its name and its state at the epoch."""
    instance, refined = mission()
    name = refined.legs[0].destination
    state = next(state_of(body) for body in refined.bodies if body.name == name)
    return DisplacedBodies(instance, refined, {name: error}, flights, 3), name, state


@pytest.mark.parametrize("since_s", [0.0, DAY_S])
@pytest.mark.parametrize("coordinates", ["rtn", "inertial"])
def test_errors_have_their_covariance_at_their_time(coordinates: str, since_s: float) -> None:
    """Errors told in axes of the body, or those of the instance, converge to the covariance."""
    flights = 40000
    error = dataclasses.replace(rtn_error(), coordinates=coordinates, since_s=since_s)
    bodies, name, state = displaced(error, flights)
    bodies.follow(name, [0.0, since_s])
    state = coasted(state, since_s, "j2")
    frame = equinoctial.own_frame(state)
    found = np.linalg.inv(equinoctial.jacobian(state, frame)) @ bodies.at(name, since_s)
    if coordinates == "rtn":
        found = np.kron(np.eye(2), frame) @ found
    sizes = np.sqrt(np.diag(error.covariance)[:6])
    off = (found @ found.T / flights - error.covariance[:6, :6]) / np.outer(sizes, sizes)
    assert np.abs(off).max() < 4.0 / math.sqrt(flights)


def test_errors_are_carried_as_bodies_move() -> None:
    """A day later a body is where its displaced state at the epoch has moved to."""
    bodies, name, state = displaced(rtn_error(), 5)
    bodies.follow(name, [0.0, DAY_S])
    planned = coasted(state, DAY_S, "j2")
    for flight in range(5):
        begun = moved(state, bodies.at(name, 0.0)[:, flight])
        there = coasted(begun, DAY_S, "j2")
        said = moved(planned, bodies.at(name, DAY_S)[:, flight])
        gone = np.linalg.norm(there[:3] - planned[:3])
        assert gone > 300.0
        assert np.linalg.norm(said[:3] - there[:3]) < 0.01 * gone


def test_errors_of_elements_do_not_run_away() -> None:
    """An error of the mean longitude stays as large, and a decay grows by its parabola."""
    for error, grown in ((elements_error(along_m=800.0), False), (elements_error(0, 20.0), True)):
        bodies, name, state = displaced(error, 4)
        bodies.follow(name, [0.0, 2.0 * DAY_S])
        planned = coasted(state, 2.0 * DAY_S, "j2")
        frame = equinoctial.own_frame(planned)
        mean = mean_elements(planned, frame, FIELDS["j2"])
        axis_m = float(mean[0])
        motion = math.sqrt(MU_M3_S2 / axis_m**3) * DAY_S
        for flight in range(4):
            there = mean_elements(
                moved(planned, bodies.at(name, 2.0 * DAY_S)[:, flight]), frame, FIELDS["j2"]
            )
            shift = there - mean
            if grown:
                assert shift[5] * axis_m == pytest.approx(-0.75 * motion * 2.0 * shift[0], rel=0.01)
                assert abs(shift[0]) > 1.0
            else:
                begin = bodies.at(name, 0.0)[5, flight]
                assert shift[5] == pytest.approx(begin, rel=0.02)
                assert abs(shift[0]) < 1e-3 * abs(shift[5]) * axis_m


@cache
def sampled(known_before_s: float | None) -> Dispersion:
    instance, refined = mission()
    errors = {target.name: elements_error(3000.0, 20.0) for target in instance.targets}
    return sample_flights(
        instance, refined, 150, NONE, targets=errors, known_before_s=known_before_s
    )


def test_who_knows_earlier_needs_less() -> None:
    """All targets are reached; the ΔV falls with the time from which they are known."""
    late, revolution, always = (sampled(before) for before in (1000.0, None, 1e9))
    assert late.delta_v_m_s.value > revolution.delta_v_m_s.value + 5.0
    assert revolution.delta_v_m_s.value > always.delta_v_m_s.value + 0.5
    assert always.delta_v_m_s.value > always.refined_delta_v_m_s
    for found in (revolution, always):
        assert found.linearity.flights == 10
        assert found.linearity.delta_v_m_s < 0.02
        assert found.linearity.standoff_m < 1.0
        for leg in found.legs:
            assert leg.standoff_miss_m.value < 10.0
            assert leg.arrival_miss_m.value < 1.0
            assert leg.target_off_m is not None
            assert 4000.0 < leg.target_off_m.value < 20e3


def test_the_next_leg_begins_where_the_target_is() -> None:
    """With an error of the first target alone its own leg and the next one change, and no other."""
    instance, refined = mission()
    name = refined.legs[0].destination
    plain = sample_flights(instance, refined, 30, NONE)
    found = sample_flights(instance, refined, 30, NONE, targets={name: elements_error(2000.0)})
    changed = np.abs(found.leg_delta_v_m_s - plain.leg_delta_v_m_s).max(axis=1) > 1e-9
    met = [name in (leg.origin, leg.destination) for leg in refined.legs]
    assert changed.tolist() == met
    assert sum(met) == 2
    assert [leg.target_off_m is not None for leg in found.legs] == [
        leg.destination == name for leg in refined.legs
    ]
    assert found.uncertain == (name,)


def test_errors_too_large_to_be_flown_are_refused() -> None:
    """A target that may be a quarter of a revolution off, or a lead below zero, is a sentence."""
    instance, refined = mission()
    name = refined.legs[0].destination
    with pytest.raises(adr_opt.InputError, match="km along its track from where it is planned"):
        sample_flights(instance, refined, 9, targets={name: elements_error(5e6)})
    with pytest.raises(adr_opt.InputError, match="known_before_s = -1"):
        sample_flights(instance, refined, 9, known_before_s=-1.0)


def test_the_command_line_takes_a_table(cli: Cli) -> None:
    """`--target-errors` tells how far targets are off; zeros are today's output; a bad table none.

    Stray options and two sources of errors are one sentence.
    """
    instance, refined = mission()
    Path("my.json").write_text(instance.to_json(), encoding="utf-8")
    refined.save("refined.json")
    rows = "".join(f"{target.name},300,2\n" for target in instance.targets)
    Path("errors.csv").write_text(
        f"target,sigma_along_m,sigma_decay_m_per_day\n{rows}", encoding="utf-8"
    )
    zeros = "".join(f"{target.name},0\n" for target in instance.targets)
    Path("zeros.csv").write_text(f"target,sigma_along_m\n{zeros}", encoding="utf-8")
    fly_it = ("fly", "my.json", "refined.json", "--samples", "40")
    told = cli(*fly_it, "--target-errors", "errors.csv", "--known-before", "3000")
    assert told.status == 0, told.err
    assert "target off" in told.out
    assert "may be elsewhere than planned, known 3000 s before the stand-off" in told.out
    found = json.loads(cli(*fly_it, "--target-errors", "errors.csv", "--json").out)["errors"]
    assert found["targets"]["known_before_s"] is None
    assert set(found["targets"]["uncertain"]) == {leg.destination for leg in refined.legs}
    assert found["legs"][0]["target_off_m"]["share"] == 0.95
    assert cli(*fly_it, "--target-errors", "zeros.csv", "--json").out == cli(*fly_it, "--json").out
    Path("bad.csv").write_text("target,sigma_along_m\nnowhere,1\n", encoding="utf-8")
    refused(cli(*fly_it, "--target-errors", "bad.csv"), "bad.csv: line 2: target 'nowhere'")
    refused(cli(*fly_it, "--target-errors", "none.csv"), "none.csv: no such file")
    refused(cli(*fly_it[:3], "--target-errors", "errors.csv"), "--target-errors needs --samples")
    refused(cli(*fly_it[:3], "--element-sets", "a.tle"), "--element-sets needs --samples")
    refused(cli(*fly_it, "--known-before", "9"), "--known-before needs --target-errors")
    refused(
        cli(*fly_it, "--target-errors", "errors.csv", "--element-sets", "a.tle"),
        "exclude each other",
    )
