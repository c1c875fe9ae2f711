"""The co-elliptic sequence: laws that must hold for every geometry."""

from __future__ import annotations

import math

import numpy as np
import pytest
import rows
from one_window import one_window

from adr_opt.common.constants import EARTH_RADIUS_M, MU_M3_S2
from adr_opt.kernels.legs import burns as burn_kernels
from adr_opt.kernels.legs import co_elliptic, sequences, zones
from adr_opt.kernels.orbits import ephemeris

CASES = 3000


def random_orbit(rng: np.random.Generator) -> np.ndarray:
    return rows.row(
        EARTH_RADIUS_M + rng.uniform(350e3, 1900e3),
        rng.uniform(0.0, math.pi),
        rng.uniform(-math.pi, math.pi),
        rng.uniform(-7.0, 7.0),
    )


def near(rng: np.random.Generator, orbit: np.ndarray) -> np.ndarray:
    """A neighbour: at times coplanar, at times of equal radius, at times both."""
    kind = rng.integers(4)
    radius = rng.uniform(-100e3, 100e3) if kind in (0, 1) else 0.0
    inclination, raan = rng.uniform(-0.02, 0.02, 2) if kind in (0, 2) else (0.0, 0.0)
    latitude = rng.uniform(0.0, 2.0 * math.pi) - orbit[3]
    return rows.changed(orbit, radius=radius, inclination=inclination, raan=raan, latitude=latitude)


def pairs(seed: int = 0):
    """Random pairs, some near each other, each with a departure event and the target's lead."""
    rng = np.random.default_rng(seed)
    rule = rows.rule()
    for case in range(CASES):
        i = random_orbit(rng)
        j = near(rng, i) if case % 2 else random_orbit(rng)
        pair = co_elliptic.prepare(i, j, 0.0, rule, 0.0)
        first, half_turns = co_elliptic.first_departure(pair)
        event = int(rng.integers(0, 200))
        departure = first + event * math.pi / pair.rate_i
        lead = co_elliptic.target_lead(pair, departure, half_turns + event)
        yield i, j, pair, departure, lead


def best_sequence(pair, rule, departure, lead):
    """The sequence chosen by someone whom no window keeps waiting and no deadline hurries."""
    return sequences.best_sequence(pair, rule, departure, lead, one_window(), 0, departure)


def test_node_line():
    """The line of nodes lies in both planes, and theta is the angle between the normals."""
    rng = np.random.default_rng(1)
    for _ in range(CASES):
        i, j = random_orbit(rng), random_orbit(rng)
        alpha_i, alpha_j, theta = ephemeris.relative_node(i[1], i[2], j[1], j[2])
        xi, yi, hi = ephemeris.frame(i[1], i[2])
        xj, yj, hj = ephemeris.frame(j[1], j[2])
        in_i = math.cos(alpha_i) * xi + math.sin(alpha_i) * yi
        in_j = math.cos(alpha_j) * xj + math.sin(alpha_j) * yj
        cross = np.cross(hi, hj)
        assert in_i == pytest.approx(in_j, abs=1e-9 / max(theta, 1e-6)), (i, j)
        assert in_i == pytest.approx(cross / np.linalg.norm(cross), abs=1e-9 / max(theta, 1e-6))
        assert theta == pytest.approx(
            math.atan2(np.linalg.norm(cross), float(hi @ hj)), abs=1e-12
        ), (i, j)


def test_equatorial_planes_share_a_line():
    """Two equatorial orbits with different RAANs still get one and the same line."""
    for inclination in (0.0, math.pi):
        alpha_i, alpha_j, theta = ephemeris.relative_node(inclination, 0.3, inclination, 1.1)
        xi, yi, _ = ephemeris.frame(inclination, 0.3)
        xj, yj, _ = ephemeris.frame(inclination, 1.1)
        assert theta < 1e-15
        in_i = math.cos(alpha_i) * xi + math.sin(alpha_i) * yi
        in_j = math.cos(alpha_j) * xj + math.sin(alpha_j) * yj
        assert in_i == pytest.approx(in_j, abs=1e-15)


def test_nearly_coplanar_planes_keep_their_digits():
    """Planes 1e-8 rad apart give the same node as planes 1e-4 rad apart in the same direction."""
    base_i, base_o = 1.6, 0.7
    wide = ephemeris.relative_node(base_i, base_o, base_i + 3e-4, base_o + 4e-4)
    close = ephemeris.relative_node(base_i, base_o, base_i + 3e-8, base_o + 4e-8)
    assert close[0] == pytest.approx(wide[0], abs=1e-3)
    assert close[2] == pytest.approx(wide[2] * 1e-4, rel=1e-3)


def test_departure_is_at_the_node():
    """At a departure event the chaser is on the line of nodes, and Δ is the target's lead there."""
    for i, j, pair, departure, lead in pairs(2):
        if pair.theta < 1e-3:
            continue
        position, _ = ephemeris.state_at(i, departure)
        _, _, hi = ephemeris.frame(i[1], i[2])
        _, _, hj = ephemeris.frame(j[1], j[2])
        node = np.cross(hi, hj) / np.linalg.norm(np.cross(hi, hj))
        assert abs(position @ node) / i[0] == pytest.approx(1.0, abs=1e-9), (i, j, departure)
        # Turning the chaser's direction about h_j by Δ gives the target's direction.
        outward = position / i[0]
        ahead = np.cross(hj, outward)
        target, _ = ephemeris.state_at(j, departure)
        expected = math.cos(lead) * outward + math.sin(lead) * ahead
        assert target / j[0] == pytest.approx(expected, abs=1e-6), (i, j, departure)


def test_phase_condition():
    """Every chosen sequence takes the time of its phasing radius and ends δ behind the target."""
    rule = rows.rule()
    found = 0
    for i, j, pair, departure, lead in pairs(3):
        best = best_sequence(pair, rule, departure, lead)
        if not math.isfinite(best.delta_v):
            continue
        found += 1
        r = best.phasing_radius
        rc = r + 0.75 * (j[0] - r)
        time = sum(
            math.pi * math.sqrt(a**3 / MU_M3_S2)
            for a in (0.5 * (i[0] + r), 0.5 * (r + rc), 0.5 * (rc + j[0]))
        ) + best.revolutions * 2.0 * math.pi * math.sqrt(r**3 / MU_M3_S2)
        assert best.flight_time == pytest.approx(time, rel=1e-13), (i, j, departure)
        angle = pair.rate_j * best.flight_time + lead - 3.0 * math.pi - 1000.0 / j[0]
        assert math.remainder(angle, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9), (i, j)
        assert rule.min_radius - 1e-3 <= r <= rule.max_radius + 1e-3
    assert found > CASES // 2


def every_sequence(pair, rule, lead):
    """All (k, m) by brute force, with bisection for the radius: (cost, T, k, ΔV)."""
    for k in range(rule.max_phasing_revolutions + 1):
        low = pair.shortest + k * pair.shortest_lap
        high = pair.longest + k * pair.longest_lap
        for m in range(-k - 3, 8):
            turn = (2 * k + 3) * math.pi - lead + rule.standoff / pair.radius_j + 2 * math.pi * m
            time = turn / pair.rate_j
            if not low <= time <= high:
                continue
            a, b = rule.min_radius, rule.max_radius
            for _ in range(60):
                r = 0.5 * (a + b)
                flown = co_elliptic.flight_time(pair.radius_i, pair.radius_j, 0.0, 0.0, 0.75, r)[0]
                flown += k * co_elliptic.lap_time(r, 0.0)[0]
                a, b = (r, b) if flown < time else (a, r)
            delta_v = co_elliptic.leg_delta_v(pair, rule, k, 0.5 * (a + b), 0.0, time, pair.turn)
            yield delta_v + rule.time_value * time, time, k, delta_v


@pytest.mark.parametrize("time_value", [0.0, 20.0, 75.0])
def test_choice_is_the_least_cost_of_all(time_value):
    """The pruned search returns what trying every (k, m) returns."""
    rule = rows.rule(time_value_m_s_per_h=time_value)
    for number, (i, j, pair, departure, lead) in enumerate(pairs(4)):
        if number % 15:
            continue
        best = best_sequence(pair, rule, departure, lead)
        costs = sorted(every_sequence(pair, rule, lead))
        if not costs:
            assert math.isinf(best.delta_v), (i, j)
            continue
        assert best.delta_v + rule.time_value * best.flight_time == pytest.approx(
            costs[0][0], rel=1e-10
        ), (i, j, departure)
        if len(costs) == 1 or costs[1][0] > costs[0][0] + 1e-6:
            assert best.revolutions == costs[0][2], (i, j, departure)


@pytest.mark.parametrize("highest_m", [rows.HIGHEST_M, EARTH_RADIUS_M + 36e6])
def test_phasing_costs_at_least_what_its_time_says(highest_m):
    """No sequence costs less than its turn and the swing of its flight time, far or near."""
    rule = rows.rule()._replace(max_radius=highest_m)
    rng = np.random.default_rng(12)
    for _ in range(CASES):
        i = random_orbit(rng)
        i[0] = rng.uniform(rule.min_radius, rng.choice([rows.HIGHEST_M, highest_m]))
        j = near(rng, i) if rng.random() < 0.5 else random_orbit(rng)
        rule = rule._replace(first_leg_fraction=rng.choice([0.0, 0.5, 0.75, 1.0]))
        matching = rng.choice([0.0, 100.0])
        pair = co_elliptic.prepare(i, j, matching, rule, 0.0)
        k = int(rng.integers(0, 13))
        least, most = rule.min_radius, highest_m
        r = pair.reference + rng.choice([1.0, 1e-2, 1e-4]) * rng.uniform(
            least - pair.reference, most - pair.reference
        )
        time = co_elliptic.flight_time(i[0], j[0], 0.0, 0.0, rule.first_leg_fraction, r)[0]
        time += k * co_elliptic.lap_time(r, 0.0)[0]
        price = co_elliptic.leg_delta_v(pair, rule, k, r, 0.0, time, pair.turn)
        laps = 2.0 - rule.first_leg_fraction + 2.0 * k
        swing = pair.swing * abs(time - pair.flight - k * pair.lap) / laps
        assert pair.turning + swing <= price * (1.0 + 1e-9) + 1e-6, (i, j, r, k)
        assert pair.swing > 0.0


@pytest.mark.parametrize("time_value", [0.0, 20.0, 300.0])
def test_choice_keeps_to_a_window(time_value):
    """A sequence too long for the deadline is out, and one too short for the opening waits."""
    rule = rows.rule(time_value_m_s_per_h=time_value)
    rng = np.random.default_rng(10)
    waits = out = none = 0
    for number, (i, j, pair, departure, lead) in enumerate(pairs(4)):
        if number % 15:
            continue
        every = list(every_sequence(pair, rule, lead))
        if not every:
            continue
        # Between the shortest and the longest sequence, but not where rounding decides.
        shortest, longest = min(row[1] for row in every), max(row[1] for row in every)
        latest = rng.uniform(shortest - 1e3, longest + 1e3)
        earliest = rng.uniform(shortest - 1e3, latest)
        window = one_window(departure + earliest, departure + latest)
        best = sequences.best_sequence(pair, rule, departure, lead, window, 0, departure)
        costs = sorted(
            (delta_v + rule.time_value * max(time, earliest), time, k)
            for _, time, k, delta_v in every
            if time <= latest
        )
        out += len(costs) < len(every)
        if not costs:
            assert math.isinf(best.delta_v), (i, j)
            none += 1
            continue
        stated = best.delta_v + rule.time_value * max(best.flight_time, earliest)
        assert stated == pytest.approx(costs[0][0], rel=1e-10), (i, j, departure)
        assert best.flight_time <= latest
        waits += best.flight_time < earliest
    assert waits > 10
    assert out > 50
    assert none > 0


def test_floor_is_below_every_sequence():
    """The floor that ends the search is at most the ΔV of any sequence."""
    rng = np.random.default_rng(5)
    rule = rows.rule()
    for i, j, pair, _, _ in pairs(5):
        r = rng.uniform(rule.min_radius, rule.max_radius)
        for k in (0, 1, 5):
            assert (
                pair.floor_delta_v
                <= co_elliptic.turned_delta_v(pair, rule, k, r, pair.turn, pair.matching) + 1e-9
            ), (i, j)


@pytest.mark.parametrize("ellipse", [False, True])
def test_burns_add_up_to_the_cost(ellipse):
    """The magnitudes of the burn vectors sum to the ΔV, in time order from the departure on."""
    rule = rows.rule(ellipse=ellipse)
    for i, j, _, departure, lead in pairs(6):
        pair = co_elliptic.prepare(i, j, 0.0, rule, ephemeris.EPOCH_S)
        best = best_sequence(pair, rule, departure, lead)
        if not math.isfinite(best.delta_v):
            continue
        times, vectors, phases = burn_kernels.burns(
            i, j, pair, rule, departure, best.revolutions, best.phasing_radius
        )
        assert np.linalg.norm(vectors, axis=1).sum() == pytest.approx(best.delta_v, abs=1e-6), (
            i,
            j,
        )
        assert np.all(np.diff(times) >= 0.0)
        assert np.all(np.diff(phases) >= 0)
        assert times[0] == departure
        begun = times[-len(rule.approach)]
        assert begun == pytest.approx(departure + best.flight_time, abs=1e-6)
        lasting = rule.approach_revolutions * ephemeris.period(j[0])
        assert times[-1] - begun == pytest.approx(lasting, rel=1e-12)


def test_blocked_sequences_touch_a_zone_and_others_do_not():
    """A keep-out zone blocks a sequence exactly when its sampled altitude profile enters it."""
    rng = np.random.default_rng(7)
    rule = rows.rule()
    blocked_cases = clear_cases = 0
    for number, (i, j, pair, departure, lead) in enumerate(pairs(8)):
        if number % 6 or number > 1800:
            continue
        best = best_sequence(pair, rule, departure, lead)
        if not math.isfinite(best.delta_v):
            continue
        bottom = rng.uniform(min(i[0], j[0]) - 30e3, max(i[0], j[0]) + 30e3)
        start = departure + rng.uniform(-0.5, 1.0) * best.flight_time
        zone = (bottom, bottom + 15e3, start, start + 3000.0)
        zoned = rows.rule(zones=[zone])
        blocked = zones.is_blocked(pair, zoned, best.revolutions, best.phasing_radius, departure)
        times, radii = altitude_profile(i, j, pair, rule, departure, best)
        inside = (zone[0] <= radii) & (radii <= zone[1]) & (zone[2] <= times) & (times <= zone[3])
        if inside.any():
            assert blocked, (i, j, departure, zone)
            blocked_cases += 1
        else:
            clear_cases += 1
            if blocked:
                # Only a touch between two samples may be missed: widen the zone a little.
                near_it = (
                    (zone[0] - 200.0 <= radii)
                    & (radii <= zone[1] + 200.0)
                    & (zone[2] - 15.0 <= times)
                    & (times <= zone[3] + 15.0)
                )
                assert near_it.any(), (i, j, departure, zone)
    assert blocked_cases > 20
    assert clear_cases > 20


def altitude_profile(i, j, pair, rule, departure, best):
    """Radius against time from departure to arrival, by Kepler's equation on each arc."""
    r = best.phasing_radius
    rc = r + rule.first_leg_fraction * (j[0] - r)
    times, radii = [], []
    now = departure

    def arc(r1, r2, now):
        a, e = 0.5 * (r1 + r2), abs(r2 - r1) / (r1 + r2)
        eccentric = np.linspace(0.0, math.pi, 600)
        clock = (eccentric - e * np.sin(eccentric)) * math.sqrt(a**3 / MU_M3_S2)
        radius = a * (1.0 - e * np.cos(eccentric))
        if r1 > r2:
            clock, radius = clock[-1] - clock[::-1], radius[::-1]
        times.extend(now + clock)
        radii.extend(radius)
        return now + clock[-1]

    def circle(radius, now, length):
        moments = np.linspace(now, now + length, 2000)
        times.extend(moments)
        radii.extend(np.full(moments.size, radius))
        return now + length

    now = arc(i[0], r, now)
    now = circle(r, now, best.revolutions * co_elliptic.lap_time(r, 0.0)[0])
    now = arc(r, rc, now)
    now = arc(rc, j[0], now)
    circle(j[0], now, rule.approach_revolutions * ephemeris.period(j[0]))
    return np.array(times), np.array(radii)


def test_zone_makes_the_next_best_fly():
    """With its best sequence blocked, a leg flies another one that is not, at its true cost."""
    rule = rows.rule()
    detours = 0
    for number, (_, _, pair, departure, lead) in enumerate(pairs(9)):
        if number % 10:
            continue
        best = best_sequence(pair, rule, departure, lead)
        if not math.isfinite(best.delta_v) or best.revolutions == 0:
            continue
        r = best.phasing_radius
        zoned = rows.rule(zones=[(r - 50.0, r + 50.0, -1e9, 1e9)])
        other = best_sequence(pair, zoned, departure, lead)
        if not math.isfinite(other.delta_v):
            continue
        detours += 1
        assert not zones.is_blocked(pair, zoned, other.revolutions, other.phasing_radius, departure)
        w = rule.time_value
        assert other.delta_v + w * other.flight_time >= best.delta_v + w * best.flight_time
    assert detours > 20
