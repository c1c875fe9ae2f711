"""The flown plan as states over time."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plans import with_legs

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M, MU_M3_S2
from adr_opt.fly import trajectory
from adr_opt.fly.trajectory import body_positions, body_states, propagate, sample
from adr_opt.kernels.legs.burns import PHASES as BURN_PHASES
from adr_opt.kernels.orbits import ephemeris
from adr_opt.plan.phases import burn_phases
from adr_opt.plan.plan import Plan
from adr_opt.problem.instance import Instance
from adr_opt.problem.orbit import Orbit

DAY_S = 86400.0


@pytest.fixture(scope="module")
def tiny() -> Instance:
    return adr_opt.generate("tiny", 0)


@pytest.fixture(scope="module")
def plan(tiny: Instance) -> Plan:
    plan = adr_opt.solve(tiny, "greedy-guarded").plan
    assert plan is not None
    return plan


def eccentric(instance: Instance, e: float) -> Instance:
    """The same field with all targets on ellipses."""
    return instance.replace(
        targets=tuple(
            target.replace(
                orbit=target.orbit.replace(eccentricity=e, argument_of_perigee_deg=70.0 * number)
            )
            for number, target in enumerate(instance.targets)
        )
    )


def test_arcs_follow_each_other(tiny: Instance, plan: Plan) -> None:
    """Each arc begins when and where the one before ended; docking alone is a step, of cm."""
    path = sample(tiny, plan, 45.0)
    assert [leg.number for leg in path.legs] == list(range(1, len(plan.legs) + 1))
    assert path.start_s == 0.0
    assert path.end_s == plan.legs[-1].end_s
    arcs = [arc for _, arc in path.arcs()]
    for before, after in pairwise(arcs):
        step = np.linalg.norm(after.positions_m[0] - before.positions_m[-1])
        assert after.start_s == pytest.approx(before.end_s, abs=1e-9)
        assert step < (0.06 if after.phase == "service" else 1e-3)
        if after.phase == "service":
            assert step > 0.0


def test_phases_and_times_are_those_of_the_burns(tiny: Instance, plan: Plan) -> None:
    """Between wait and service a leg has an arc for every stretch between two of its burns."""
    for path in sample(tiny, plan).legs:
        leg = path.leg
        assert [arc.phase for arc in path.arcs] == [
            "wait",
            *(burn.phase for burn, after in pairwise(leg.burns) if after.time_s > burn.time_s),
            "service",
        ]
        assert path.arcs[0].start_s == leg.ready_s
        assert path.arcs[1].start_s == leg.departure_s
        assert path.arcs[-1].start_s == leg.arrival_s
        assert path.arcs[-1].end_s == leg.end_s


def test_samples_are_even_dense_and_read_only(tiny: Instance, plan: Plan) -> None:
    """No two samples of an arc are further apart than the step, and none can be changed."""
    for _, arc in sample(tiny, plan, 30.0).arcs():
        steps = np.diff(arc.times_s)
        assert steps.max() <= 30.0 * (1.0 + 1e-9)
        assert steps.min() == pytest.approx(steps.max(), rel=1e-6)
        assert arc.positions_m.shape == arc.velocities_m_s.shape == (arc.times_s.size, 3)
        with pytest.raises(ValueError, match="read-only"):
            arc.positions_m[0] = 0.0


@pytest.mark.parametrize(("family", "seed"), [("tiny", 1), ("nominal", 3)])
def test_states_are_those_of_the_flight(family: str, seed: int) -> None:
    """Every sample is where boinor gets from the origin by the burns, to 2 mm.

    The tolerance is boinor's own: its iteration may end 0.3 mm early on each coast.
    """
    two_body = pytest.importorskip("adr_opt.fly.flight.two_body")
    pytest.importorskip("boinor")
    instance = adr_opt.generate(family, seed)
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    flight = two_body.TwoBody()
    circles = dict(zip(instance.names, instance.body_orbits, strict=True))
    for path in sample(instance, plan, 600.0).legs[:6]:
        leg = path.leg
        origin = flight.circle_at_epoch(circles[leg.origin])
        destination = flight.circle_at_epoch(circles[leg.destination])
        for arc in path.arcs:
            for time, r, v in zip(arc.times_s, arc.positions_m, arc.velocities_m_s, strict=True):
                if arc.phase in ("wait", "service"):
                    state = flight.coast(origin if arc.phase == "wait" else destination, time)
                else:
                    now = leg.burns[0].time_s
                    state = flight.coast(origin, now)
                    for burn in leg.burns:
                        if burn.time_s > arc.start_s:
                            break
                        state = flight.coast(state, burn.time_s - now)
                        state = state[0], state[1] + np.array(burn.delta_v_m_s)
                        now = burn.time_s
                    state = flight.coast(state, time - now)
                assert np.linalg.norm(r - state[0]) < 2e-3
                assert np.linalg.norm(v - state[1]) < 2e-6


def test_a_plan_without_legs_has_no_arcs(tiny: Instance, plan: Plan) -> None:
    """An empty plan is no error: there is nothing to sample, from 0 to 0."""
    path = sample(tiny, with_legs(plan, ()))
    assert path.legs == ()
    assert (path.start_s, path.end_s) == (0.0, 0.0)
    assert list(path.arcs()) == []


def test_phases_that_take_no_time_are_left_out(tiny: Instance) -> None:
    """Without service a leg ends with its approach."""
    instance = tiny.replace(mission=tiny.mission.replace(service_revolutions=0.0))
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    legs = sample(instance, plan).legs
    visits = [path for path in legs if path.leg.destination != instance.stations[0].name]
    assert visits
    assert all(path.arcs[-1].phase == "approach" for path in visits)


@pytest.mark.parametrize("step_s", [0.0, -1.0, math.nan, math.inf, 1e-4])
def test_a_step_that_cannot_be_is_refused(tiny: Instance, plan: Plan, step_s: float) -> None:
    """A step is positive, finite, and long enough for the samples to fit into memory."""
    with pytest.raises(adr_opt.InputError, match="step"):
        sample(tiny, plan, step_s)


def test_plans_that_cannot_be_flown_are_refused(tiny: Instance, plan: Plan) -> None:
    """As in ``fly``: another instance, an unknown body, burns that lead away from the Earth."""
    with pytest.raises(adr_opt.InputError, match="belongs to the instance"):
        sample(adr_opt.generate("tiny", 1), plan)
    leg = plan.legs[0]
    with pytest.raises(adr_opt.InputError, match="leg 1: 'nowhere' is not a body"):
        sample(tiny, with_legs(plan, (leg.replace(destination="nowhere"),)))
    for vector in ((1e5, 0.0, 0.0), (1e9, -1e9, 1e9)):
        burns = (leg.burns[0].replace(delta_v_m_s=vector), *leg.burns[1:])
        with pytest.raises(adr_opt.InputError, match="leg 1: cannot be flown"):
            sample(tiny, with_legs(plan, (leg.replace(burns=burns),)))


@pytest.mark.parametrize(
    "changes",
    [
        {"ready_s": -1e12},
        {"end_s": 1e12},
        {"burn_s": -1e12},
        {"ready_s": 0.0, "arrival_s": 0.0, "end_s": 0.0, "burn_s": 0.0},
    ],
)
def test_absurd_times_end_in_a_sentence(tiny: Instance, plan: Plan, changes: dict) -> None:
    """Times that span ages, or none, are refused before any memory is asked for."""
    leg, times = plan.legs[0], dict(changes)
    if "burn_s" in times:
        time = times.pop("burn_s")
        leg = leg.replace(burns=tuple(burn.replace(time_s=time) for burn in leg.burns))
    with pytest.raises(adr_opt.InputError, match=r"step|leg 1"):
        sample(tiny, with_legs(plan, (leg.replace(**times),)))


def test_bodies_are_on_the_circles_of_the_kernels(tiny: Instance) -> None:
    """The states of bodies are those that the burns were worked out with, eccentric or not."""
    instance = eccentric(tiny, 0.02)
    times = np.linspace(0.0, 7 * DAY_S, 25)
    for name, row in zip(instance.names, instance.orbits(), strict=True):
        positions, velocities = body_states(instance, name, times)
        for time, r, v in zip(times, positions, velocities, strict=True):
            r_0, v_0 = ephemeris.state_at(row, time)
            assert np.linalg.norm(r - r_0) < 1e-4
            assert np.linalg.norm(v - v_0) < 1e-7
    assert body_positions(instance, times).shape == (len(instance.names), 25, 3)
    with pytest.raises(adr_opt.InputError, match="'nowhere' is not a body"):
        body_states(instance, "nowhere", times)


def test_circles_are_their_own_truth(tiny: Instance) -> None:
    """Between circles there is no approximation, so nothing differs."""
    times = np.linspace(0.0, DAY_S, 5)
    assert np.array_equal(
        body_positions(tiny, times), body_positions(tiny, times, true_orbits=True)
    )


def test_true_orbits_have_the_elements_that_are_given() -> None:
    """By vis-viva, by the height of the perigee and by the time of its passage."""
    e, axis = 0.3, 1.2e7
    orbit = Orbit(
        semi_major_axis_m=axis,
        eccentricity=e,
        inclination_deg=63.4,
        raan_deg=40.0,
        argument_of_perigee_deg=250.0,
        true_anomaly_deg=0.0,
    )
    tiny = adr_opt.generate("tiny", 0)
    instance = tiny.replace(targets=(tiny.targets[0].replace(orbit=orbit),))
    name = instance.targets[0].name
    period = 2.0 * math.pi * math.sqrt(axis**3 / MU_M3_S2)
    times = [0.0, 0.5 * period, period]
    (r_p, r_a, again), (v_p, v_a, _) = body_states(instance, name, times, true_orbits=True)
    assert np.linalg.norm(r_p) == pytest.approx(axis * (1.0 - e), rel=1e-12)
    assert np.linalg.norm(r_a) == pytest.approx(axis * (1.0 + e), rel=1e-12)
    assert np.linalg.norm(v_p) / np.linalg.norm(v_a) == pytest.approx((1 + e) / (1 - e), rel=1e-11)
    assert r_p == pytest.approx(again, abs=1e-4)
    assert r_p / np.linalg.norm(r_p) == pytest.approx(orbit.eccentricity_vector() / e, abs=1e-12)
    normal = np.cross(r_p, v_p)
    assert math.degrees(math.acos(normal[2] / np.linalg.norm(normal))) == pytest.approx(63.4)


@settings(max_examples=200, deadline=None)
@given(
    e=st.floats(0.0, 0.97),
    anomaly=st.floats(-math.pi, math.pi),
    after_s=st.floats(-7 * DAY_S, 7 * DAY_S),
)
def test_propagation_obeys_kepler(e: float, anomaly: float, after_s: float) -> None:
    """Whatever the ellipse: the mean anomaly grows with time, and position follows from it."""
    axis = (EARTH_RADIUS_M + 500e3) / (1.0 - e)
    rate = math.sqrt(MU_M3_S2 / axis**3)

    def state(eccentric: float) -> tuple[np.ndarray, np.ndarray]:
        root, divisor = math.sqrt(1.0 - e * e), 1.0 - e * math.cos(eccentric)
        return (
            axis * np.array([math.cos(eccentric) - e, root * math.sin(eccentric), 0.0]),
            axis * rate / divisor * np.array([-math.sin(eccentric), root * math.cos(eccentric), 0]),
        )

    positions, velocities = propagate(*state(anomaly), [after_s])
    # The other way round: from the end point back to its eccentric anomaly and to its time.
    x, y, _ = positions[0] / axis
    end = math.atan2(y / math.sqrt(1.0 - e * e), x + e)
    late = anomaly - e * math.sin(anomaly) + rate * after_s - (end - e * math.sin(end))
    assert abs(math.remainder(late, 2.0 * math.pi)) < 1e-9
    r, v = state(end)
    assert np.linalg.norm(positions[0] - r) < 1e-3
    assert np.linalg.norm(velocities[0] - v) < 1e-6


def test_propagation_refuses_what_is_not_closed() -> None:
    """An escape, a NaN or an absurd time is an error, and no number."""
    r, v = np.array([7e6, 0.0, 0.0]), np.array([0.0, 7.5e3, 0.0])
    for position, velocity, time in (
        (r, 2.0 * v, 10.0),
        (r, v * math.nan, 10.0),
        (r, v, 1e12),
        (r, v, math.nan),
    ):
        with pytest.raises(ArithmeticError):
            propagate(position, velocity, [time])


def test_the_phases_are_named_in_order() -> None:
    """The names of phases are public: burns between wait and service, then those of tows."""
    phases = list(trajectory.PHASES)
    assert phases[0] == "wait"
    assert phases.index("approach") < phases.index("service") < phases.index("tow")
    assert sorted(burn_phases()) == sorted((*BURN_PHASES, "tow", "return"))
