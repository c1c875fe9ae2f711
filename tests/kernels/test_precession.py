"""Short transfers between planes that drift: events, node and phase on arrival, what is listed."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
import rows
from drift_cases import FAMILIES_DEG, drawn, fly, pair_of, pairs
from rows import FloatArray, oblate_rule, rule

import adr_opt
from adr_opt.common.constants import DAY_S, OBLATENESS_M2, SLACK_S
from adr_opt.fly.flight.mean_flight import MeanDynamics
from adr_opt.kernels.legs import burns as burn_kernels
from adr_opt.kernels.legs import (
    co_elliptic,
    connections,
    departure_events,
    drifting_connections,
    precession,
)
from adr_opt.kernels.legs.departure_events import Times
from adr_opt.kernels.legs.found import ConnectionArrays
from adr_opt.kernels.orbits import columns
from adr_opt.legs.connection_finder import ConnectionFinder
from adr_opt.problem.settings import TransferSettings

WEEK_S = 7.0 * DAY_S
NO_DRIFT = Times(0.0, DAY_S, 0.0, 1e9)


@pytest.fixture(scope="module")
def truth() -> MeanDynamics:
    pytest.importorskip("boinor")
    return MeanDynamics()


def connections_of(
    i: FloatArray, j: FloatArray, extra_m_s: float, rule, times: Times, last_s: float, least: float
) -> ConnectionArrays:
    """All connections of two rows of orbits: short ones, and drifts if they may take a while."""
    rest = rule, times, last_s, least
    shorts = drifting_connections.short_ones(i, j, extra_m_s, *rest)
    if times.longest < times.step:
        return shorts
    return drifting_connections.with_drifts(i, j, *rest, shorts)


def heights(i: FloatArray, j: FloatArray, times: FloatArray) -> FloatArray:
    """How far the chaser is above the plane of the target, in sines."""
    (u, node), (_, other) = (
        (
            orbit[columns.ARGUMENT_OF_LATITUDE] + orbit[columns.LATITUDE_RATE] * times,
            orbit[columns.RAAN] + orbit[columns.RAAN_RATE] * times,
        )
        for orbit in (i, j)
    )
    ci, si = math.cos(i[columns.INCLINATION]), math.sin(i[columns.INCLINATION])
    cj, sj = math.cos(j[columns.INCLINATION]), math.sin(j[columns.INCLINATION])
    d = other - node
    found: FloatArray = np.cos(u) * sj * np.sin(d) + np.sin(u) * (si * cj - ci * sj * np.cos(d))
    return found


def crossings(i: FloatArray, j: FloatArray, duration: float) -> FloatArray:
    """When the chaser crosses the plane of the target, by sampling and bisection [s]."""
    step = math.pi / i[columns.LATITUDE_RATE] / 40.0
    times = np.arange(0.0, duration + step, step)
    sign = heights(i, j, times) > 0.0
    at = np.flatnonzero(sign[1:] != sign[:-1])
    low, high = times[at], times[at + 1]
    for _ in range(50):
        middle = 0.5 * (low + high)
        before = (heights(i, j, middle) > 0.0) == sign[at]
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return low[low <= duration]


@pytest.mark.parametrize("inclination_deg", FAMILIES_DEG)
def test_every_crossing_of_a_year_is_an_event(inclination_deg):
    """Events are the crossings of the target's plane, none missed and none doubled in a year.

    The planes come into line meanwhile, and out of it. Where they nearly coincide, the line moves
    as fast as the chaser, and one event may be somewhere else.
    """
    rng = np.random.default_rng(int(inclination_deg))
    aligned = 0
    for apart in (0.3, -0.02, 0.001):
        first = drawn(rng, inclination_deg, 40.0)
        second = drawn(rng, inclination_deg + apart, 40.0, altitudes_m=(900e3, 1e6))
        rates = [orbit.row(OBLATENESS_M2)[columns.RAAN_RATE] for orbit in (first, second)]
        # In line after half a year.
        ahead = math.degrees((rates[0] - rates[1]) * 0.5 * 365.0 * DAY_S)
        pair = pair_of(first, second.replace(raan_deg=40.0 + ahead))
        made = co_elliptic.prepare(pair.i, pair.j, 0.0, oblate_rule(), 0.0)
        half_turns, numbers = departure_events.events_of(made, 365.0 * DAY_S, 0.0)
        expected = crossings(pair.i, pair.j, 365.0 * DAY_S)
        assert np.all(np.diff(half_turns) == 1)
        assert numbers[:, 0].size == expected.size, pair
        off = np.abs(numbers[:, 0] - expected) > 1e-4
        assert np.count_nonzero(off) <= (2 if abs(apart) < 0.1 else 0), pair
        assert np.all(numbers[:, 4][off] < 5e-4)
        assert np.all(np.diff(numbers[:, 0]) > 0.0)
        aligned += numbers[:, 4].min() < 0.5 * numbers[6].max()
    assert aligned == 3


def test_events_keep_their_spacing():
    """With a spacing, some of all events are left, none much closer and none much farther apart."""
    for pair in pairs(1, 24):
        made = co_elliptic.prepare(pair.i, pair.j, 0.0, oblate_rule(), 0.0)
        every = departure_events.events_of(made, 60.0 * DAY_S, 0.0)[1][:, 0]
        for spacing in (1e4, DAY_S, 2.5 * DAY_S):
            some = departure_events.events_of(made, 60.0 * DAY_S, spacing)[1][:, 0]
            assert np.isin(np.round(some, 3), np.round(every, 3)).all()
            gaps = np.diff(some)
            # The line of nodes itself moves meanwhile, by half a revolution at most.
            half_period = math.pi / made.rate_i
            assert gaps.min() > spacing - half_period
            assert gaps.max() < spacing + 2.0 * half_period


@pytest.mark.slow
def test_listed_transfers_fly_to_the_stand_off(truth):
    """Burns lead to the target's plane and the stand-off in it, and add up to what is listed.

    The plane after the turn, carried by the arcs, is the target's on arrival; the departure listed
    is at most a step before the first burn, and never after it.
    """
    law = oblate_rule()
    rng = np.random.default_rng(2)
    flown = 0
    for pair in pairs(3, 420):
        found = connections_of(pair.i, pair.j, 0.0, law, NO_DRIFT, WEEK_S, 0.1)
        assert np.all(found.departure >= 0.0)
        assert np.all(found.arrival <= WEEK_S)
        for c in rng.choice(found.departure.size, min(5, found.departure.size), replace=False):
            times, vectors, phases = burn_kernels.burns_between(
                pair.i,
                pair.j,
                0.0,
                law,
                found.departure[c],
                found.arrival[c],
                int(found.revolutions[c]),
            )
            case = (pair, found.departure[c], found.arrival[c], found.revolutions[c])
            early = times[0] - found.departure[c]
            assert -precession.ROUNDING_S <= early <= precession.STEP_S + 2e-3, case
            met = fly(truth, pair, times, vectors, law.standoff)
            assert met.behind < 0.5, case
            assert met.tilted < 1e-9, case
            # An eccentric target drifts otherwise than its circle, on which the approach is flown.
            circle = rows.row(*pair.j[:4], oblateness=OBLATENESS_M2)
            other = np.abs(pair.j - circle)[[columns.RAAN_RATE, columns.LATITUDE_RATE]].sum()
            assert met.arrival < 0.7 + 2.0 * pair.j[0] * other * (times[-1] - times[-2]), case
            assert met.arrival < 0.7 or pair.orbit_j.eccentricity > 0.0
            burnt = np.linalg.norm(vectors, axis=1).sum() + burn_kernels.eccentric_share(
                pair.i, pair.j, 0.0, law, times[0], found.arrival[c], int(found.revolutions[c])
            )
            assert burnt == pytest.approx(found.delta_v[c], abs=1e-6), case
            assert list(phases) == sorted(phases)
            flown += 1
    assert flown > 1500


@pytest.mark.parametrize("count", [12, pytest.param(36, marks=pytest.mark.slow)])
@pytest.mark.parametrize("resolution", [0.0, 0.1])
def test_without_oblateness_connections_are_those_of_two_bodies(resolution, count):
    """With J2 = 0 the same connections come out, to rounding: thousands of several families."""
    law = rule()
    compared = 0
    for pair in pairs(4, count, oblateness=0.0):
        expected = connections.of_pair(pair.i, pair.j, 3.0, law, WEEK_S, resolution)
        found = connections_of(pair.i, pair.j, 3.0, law, NO_DRIFT, WEEK_S, resolution)
        # Where two cost the same to the last digits, rounding may keep either.
        assert abs(found.departure.size - expected.departure.size) <= 2, pair
        table = np.column_stack(expected[:3])
        for row in np.column_stack(found[:3]):
            # A departure may be listed up to a step early.
            there = (
                (table[:, 0] - row[0] > -1e-3)
                & (table[:, 0] - row[0] < precession.STEP_S)
                & (np.abs(table[:, 1] - row[1]) < 1e-3)
            )
            cost = table[there, 2]
            if cost.size and np.min(np.abs(cost - row[2])) < 1e-6:
                compared += 1
    assert compared > 550 * count


@pytest.mark.parametrize("count", [4, pytest.param(18, marks=pytest.mark.slow)])
def test_no_connection_dominates_another(count):
    """Of short and long ones together hardly any is worth nothing beside another one.

    One in a hundred is allowed for: on crossings whose arrivals lie seconds apart, the sifting of
    short ones keeps what it cannot compare.
    """
    law = oblate_rule()
    both = all_ = superfluous = 0
    for number, pair in enumerate(pairs(5, count, spread_deg=6.0)):
        times = Times(DAY_S * (number % 2), DAY_S, 40.0 * DAY_S, 1500.0)
        resolution = (0.1, 1.0, 5.0)[number % 3]
        found = connections_of(pair.i, pair.j, 0.0, law, times, 60.0 * DAY_S, resolution)
        listed = np.column_stack(found[:3])
        assert np.all(np.diff(found.departure) >= 0.0)
        for c, row in enumerate(listed):
            better = (
                (listed[:, 0] >= row[0] + precession.STEP_S)
                & (listed[:, 1] <= row[1])
                & (listed[:, 2] <= row[2] + resolution)
            )
            better[c] = False
            assert not better.any() or found.revolutions[c] >= 0, (pair, row, listed[better])
            superfluous += better.any()
        all_ += len(listed)
        assert np.all(found.delta_v <= 1500.0)
        both += bool((found.revolutions >= 0).any() and (found.revolutions < 0).any())
    assert both > count / 4
    assert superfluous <= 0.01 * all_


def test_no_sequence_is_missed():
    """Each sequence of each event, settled by itself, is dominated by one that is listed.

    Up to ten minutes: of those that meet the target on one crossing the cheapest is listed.
    """
    law = oblate_rule(k_max=6)
    duration, missed, all_ = 1.5 * DAY_S, 0, 0
    for pair in pairs(6, 18):
        made = co_elliptic.prepare(pair.i, pair.j, 0.0, law, 0.0)
        found = connections_of(pair.i, pair.j, 0.0, law, NO_DRIFT, duration, 0.1)
        lap = 2.0 * math.pi / made.rate_j
        approach = law.approach_revolutions * lap
        half_turns, numbers = departure_events.events_of(made, duration, 0.0)
        for event, k in itertools.product(range(half_turns.size), range(7)):
            departure, _, alpha_i, alpha_j = numbers[event, :4]
            high = made.longest + k * made.longest_lap
            met = departure + made.shortest + k * made.shortest_lap
            while met < departure + high + lap:
                about = precession.meeting(made, law, half_turns[event], alpha_j, met)
                met += lap
                way = precession.fixed_point(
                    made, law, half_turns[event], k, departure, about, alpha_i, alpha_j
                )
                arrival = way.stand_off + approach
                if not math.isfinite(way.delta_v) or arrival > duration + SLACK_S:
                    continue
                if way.departure < 0.0:
                    continue
                all_ += 1
                as_good = (
                    (found.departure >= way.departure - precession.STEP_S - 600.0)
                    & (found.arrival <= arrival + 600.0)
                    & (found.delta_v <= way.delta_v + 0.2)
                )
                missed += not as_good.any()
    assert all_ > 3000
    assert missed == 0


def test_oblateness_that_fades_leads_to_two_body_motion():
    """A thousandth of J2 changes what a pair costs by about a thousandth of what J2 changes."""
    law = rule()
    for whole in pairs(7, 6):
        made = []
        for share in (0.0, 1e-3, 1.0):
            oblateness = share * OBLATENESS_M2
            pair = pair_of(whole.orbit_i, whole.orbit_j, oblateness)
            prepared = co_elliptic.prepare(
                pair.i, pair.j, 0.0, law._replace(oblateness=oblateness), 0.0
            )
            event = precession.first_event(prepared)
            made.append((event.time, event.theta, prepared.flight, prepared.lap))
        plain, faint, full = (np.array(values) for values in made)
        assert np.abs(faint - plain) == pytest.approx(
            1e-3 * np.abs(full - plain), rel=0.05, abs=1e-9
        )


def test_departures_between_planes_that_nearly_coincide_are_found_again() -> None:
    """However near planes are, the departure of a listed transfer is found again."""
    rng = np.random.default_rng(5)
    field = adr_opt.generate("rocket-bodies", 0)
    first, second = field.targets[:2]
    listed = 0
    for scale in 10.0 ** rng.uniform(-1.5, 0.5, 25):
        tilt_deg, node_deg = scale * rng.normal(0.0, [0.02, 0.3])
        orbit = first.orbit.replace(
            inclination_deg=first.orbit.inclination_deg + tilt_deg,
            raan_deg=(first.orbit.raan_deg + node_deg) % 360.0,
        )
        instance = field.replace(targets=(first, second.replace(orbit=orbit)))
        instance = instance.with_limits(duration_s=20.0 * DAY_S).replace(
            transfer=TransferSettings(delta_v_resolution_m_s=0.1)
        )
        connecting = ConnectionFinder(instance)
        leaving, orbits, extra, rule = connecting.inputs
        for i, j in ((1, 2), (2, 1)):
            found = connecting.find(i, j, 0.1)
            pair = co_elliptic.prepare(leaving[i], orbits[j], extra[i, j], rule, 0.0)
            approach = rule.approach_revolutions * 2.0 * math.pi / pair.rate_j
            for c in range(found.departure.size):
                departure = precession.leaving(
                    pair,
                    rule,
                    found.revolutions[c],
                    found.departure[c],
                    found.arrival[c] - approach,
                )
                late = departure - found.departure[c]
                assert -precession.ROUNDING_S <= late <= precession.STEP_S + precession.ROUNDING_S
            listed += found.departure.size
    assert listed > 10_000
