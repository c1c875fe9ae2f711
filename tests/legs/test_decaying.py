"""Legs to orbits that decay: their phases are quadratic in time, in planners and in `check`."""

from __future__ import annotations

import math

import numpy as np
import pytest
from seeds import over_seeds

import adr_opt
from adr_opt.analysis import replan
from adr_opt.common.constants import DAY_S, MU_M3_S2
from adr_opt.common.errors import InputError
from adr_opt.fly.flight import fly_mean
from adr_opt.fly.flight.retargeted import true_state
from adr_opt.fly.trajectory.bodies import body_states
from adr_opt.judge.check.leg import Physics
from adr_opt.judge.check.sequences import ways_after
from adr_opt.kernels.orbits import elements, ephemeris
from adr_opt.legs.connection_finder import ConnectionFinder
from adr_opt.legs.nearest_pairs import neighbours
from adr_opt.legs.timetable import Timetable
from adr_opt.mission.certify import certificate_of
from adr_opt.mission.mission import Mission


def decaying(
    seed: int,
    targets: int = 8,
    *,
    most_m_per_day: float = 600.0,
    days: float = 4.0,
    drift_days: float = 0.0,
) -> adr_opt.Instance:
    """A field whose targets decay, some of them upwards, and one that does not."""
    rng = np.random.default_rng(seed)
    field = adr_opt.generate("nominal", seed, targets=targets)
    decays = [None, *rng.uniform(-0.3, 1.0, targets - 1) * most_m_per_day]
    transfer = field.transfer.replace(max_drift_s=drift_days * DAY_S, drift_step_s=0.5 * DAY_S)
    return field.replace(
        dynamics="j2",
        transfer=transfer,
        mission=field.mission.replace(duration_s=days * DAY_S),
        targets=tuple(
            target.replace(decay_m_per_day=None if decay is None else float(decay))
            for target, decay in zip(field.targets, decays, strict=True)
        ),
    )


def steady(instance: adr_opt.Instance, decay: float | None = None) -> adr_opt.Instance:
    """The same field, whose targets decay by as much as said."""
    return instance.replace(
        targets=tuple(target.replace(decay_m_per_day=decay) for target in instance.targets)
    )


def test_the_phase_of_a_decaying_orbit_is_that_of_its_shrinking_axis() -> None:
    """The rate of the argument of latitude grows as Kepler's third law says of the radius."""
    rng = np.random.default_rng(2)
    for _ in range(100):
        radius, decay = rng.uniform(6.8e6, 8.0e6), rng.uniform(-500.0, 500.0)
        row = np.array(
            ephemeris.body_row(radius, 1.5, 0.3, 0.7, oblateness_m2=0.0, decay_m_per_day=decay)
        )
        day = rng.uniform(1.0, 5.0)
        shrunk = radius - decay * day
        expected = math.sqrt(MU_M3_S2 / shrunk**3)
        assert ephemeris.latitude_rate_at(row, day * DAY_S) == pytest.approx(expected, rel=3e-6)
        times = np.linspace(0.0, day * DAY_S, 20001)
        rates = elements.latitude_rates(row, times)
        gained = elements.latitudes(row, times)[-1] - elements.latitudes(row, 0.0)
        assert gained == pytest.approx(np.trapezoid(rates, times), rel=1e-12)


@over_seeds(range(6), gate=2)
def test_connections_of_a_barely_decaying_orbit_are_those_of_a_steady_one(seed: int) -> None:
    """A decay of a nanometre a day changes no connection, though another code finds them."""
    field = decaying(seed, targets=5)
    before, after = (Mission(steady(field, decay)).connecting for decay in (None, 1e-9))
    for i in range(6):
        for j in range(1, 6):
            if i == j:
                continue
            one, other = before.of_pair(i, j, 0.1), after.of_pair(i, j, 0.1)
            assert one.departure.size == other.departure.size > 0
            assert np.abs(one.departure - other.departure).max() < 1e-4
            assert np.abs(one.arrival - other.arrival).max() < 1e-4
            assert np.abs(one.delta_v - other.delta_v).max() < 1e-5


@over_seeds(range(8), gate=2)
def test_plans_to_decaying_orbits_hold(seed: int) -> None:
    """Plans of several planners pass `check`, within their bounds, and not without the decay."""
    field = decaying(seed, drift_days=2.0 if seed % 2 else 0.0)
    best = 0.0
    for method in ("greedy", "beam", "exact"):
        plan = adr_opt.solve(field, method, time_limit=60.0).plan
        assert adr_opt.check(field, plan) == ()
        best = max(best, plan.objective)
        if plan.upper_bound is not None:
            assert best <= plan.upper_bound + 1e-9
    other = steady(field)
    told = plan.replace(instance=plan.instance.replace(sha256=other.sha256))
    assert adr_opt.check(other, told)


@over_seeds(range(6), gate=1)
def test_plans_to_decaying_orbits_are_flown_for_what_they_say(seed: int) -> None:
    """Between circles burns retargeted to the bodies' own motion cost what the plan says.

    Less what burns of one instant save as one vector: the price counts each of them.
    """
    field = decaying(seed)
    plan = adr_opt.solve(field, "beam", time_limit=60.0).plan
    flown = fly_mean(field, plan)
    assert flown.problems == {}
    for number, leg in enumerate(plan.legs, 1):
        assert 0.0 < leg.at_once_m_s < 0.27
        said = leg.delta_v_m_s - leg.at_once_m_s
        assert flown.flown[number] == pytest.approx(said, abs=0.01)


def test_rows_on_demand_know_of_decay() -> None:
    """What is asked for is what a table that is built holds."""
    field, rng = decaying(3), np.random.default_rng(3)
    bodies, worth = len(field.names), 20.0
    field = field.replace(transfer=field.transfer.replace(delta_v_resolution_m_s=0.1))
    held = Timetable(field, time_value_m_s_per_h=worth)
    asked = Timetable(field, time_value_m_s_per_h=worth, examined=neighbours(field, bodies))
    found = others = 0
    for _ in range(1000):
        i, j = rng.choice(bodies, 2, replace=False)
        ready = float(rng.uniform(0.0, 3.0 * DAY_S))
        (cost, arrival), (own, own_arrival) = held.lookup(i, j, ready), asked.lookup(i, j, ready)
        if own == math.inf:
            continue
        found += 1
        off = own - cost + worth / 3600.0 * (own_arrival - arrival)
        others += not -1e-3 <= off <= 0.1 + 1e-3
    assert found > 300
    assert others <= found / 50  # nearly coplanar pairs, of which lists and rows miss some each


def test_states_of_bodies_follow_the_decay() -> None:
    """On the circle and on the ellipse a body is where its argument of latitude says."""
    field = decaying(1)
    target = field.targets[2]
    assert target.orbit is not None
    eccentric = field.replace(
        targets=(
            *field.targets[:2],
            target.replace(orbit=target.orbit.replace(eccentricity=0.01)),
            *field.targets[3:],
        )
    )
    times = np.linspace(0.0, 4.0 * DAY_S, 50)
    row = field.orbits()[field.names.index(target.name)]
    for t, position in zip(times, body_states(field, target.name, times)[0], strict=True):
        assert position == pytest.approx(ephemeris.state_at(row, t)[0], abs=1e-3)
    orbit, decay = eccentric.targets[2].orbit, target.decay_m_per_day
    assert orbit is not None
    assert decay
    true = body_states(eccentric, target.name, times, true_orbits=True)[0]
    for t, position in zip(times, true, strict=True):
        state = true_state(orbit, eccentric.oblateness_m2, float(t), decay)
        assert position == pytest.approx(state[:3], abs=0.1)


def test_what_leaves_decay_out_says_so() -> None:
    """Refinement refuses an instance with a decay in one sentence."""
    field = decaying(0, targets=4, days=2.0)
    plan = adr_opt.solve(field, "exact", time_limit=60.0).plan
    with pytest.raises(InputError, match=r"decays, but flights in true dynamics"):
        adr_opt.refine(field, plan)


@over_seeds(range(6), gate=2)
def test_proofs_about_decaying_orbits_are_verified(seed: int) -> None:
    """`verify` recomputes the connections of decaying orbits and finds all of them."""
    field = decaying(seed, targets=5, days=3.0, drift_days=1.0 if seed % 2 else 0.0)
    solved = adr_opt.solve(field, "exact", time_limit=60.0)
    verdict = adr_opt.verify(field, solved.plan, certificate_of(field, solved))
    assert verdict.verified, verdict.reasons


@over_seeds(range(6), gate=1)
def test_every_sequence_to_a_decaying_orbit_is_there(seed: int) -> None:
    """What `verify` finds by the physics of `check` is among the connections, and as good."""
    field = decaying(seed, targets=3, most_m_per_day=3000.0 * (-1) ** seed, days=4.0)
    connecting, physics = ConnectionFinder(field), Physics.of(field, None)
    looked = 0
    for i, j in ((1, 2), (2, 3), (3, 2)):
        found = connecting.of_pair(i, j, connecting.planning_resolution_m_s)
        for time in np.arange(0.0, field.mission.duration_s, 2500.0):
            for way in ways_after(field, physics, None, i, j, float(time)):
                if way.arrival > field.mission.duration_s or way.delta_v > 3000.0:
                    continue
                looked += 1
                most = way.delta_v + connecting.planning_resolution_m_s + 1e-4
                as_good = (
                    (found.departure >= way.departure - way.early - 16.002)
                    & (found.arrival <= way.arrival + 1e-3)
                    & (found.delta_v <= most)
                )
                assert as_good.any()
    assert looked > 300


@over_seeds(range(4), gate=1)
def test_the_rest_of_a_mission_starts_from_decaying_targets(seed: int) -> None:
    """A chaser that is at a target goes on from where the decay has carried that."""
    field = decaying(seed)
    plan = adr_opt.solve(field, "beam", time_limit=60.0).plan
    at_s = plan.legs[1].end_s + 60.0
    made = replan(field, plan, at_s)
    assert adr_opt.check(made.instance, made.plan) == ()
    (state,) = made.states
    assert state.body is not None
    for time in np.linspace(0.0, 4.0 * DAY_S, 9):
        rows = [
            instance.orbits()[instance.names.index(name)]
            for instance, name in ((field, state.body), (made.instance, made.instance.chaser.name))
        ]
        positions = [ephemeris.state_at(row, time)[0] for row in rows]
        assert positions[1] == pytest.approx(positions[0], abs=1e-6)
