"""Lambert arcs about the Moon, and the rules of ESA's travelling salesperson."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from from_outside import DATA, broken, external
from outside.kttsp import costs, kepler, lambert
from outside.kttsp.reading import Problem, Tour, read_problem, read_tour, tour_of
from outside.kttsp.scoring import score

from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError

FOLDER = DATA / "kttsp"
SMALL = FOLDER / "small.kttsp"
MU = kepler.MU_MOON_M3_S2

pytestmark = external("kttsp")


@pytest.fixture(scope="module")
def problem():
    return read_problem(SMALL)


def ends(seed):
    """Two positions about the Moon and a time between them of up to ten revolutions."""
    rng = np.random.default_rng(seed)
    r_1, r_2 = rng.normal(size=3), rng.normal(size=3)
    r_1 *= rng.uniform(3e6, 2e7) / np.linalg.norm(r_1)
    r_2 *= rng.uniform(3e6, 2e7) / np.linalg.norm(r_2)
    return r_1, r_2, rng.uniform(0.02, 10.0) * 2.0 * math.pi * math.sqrt(1.2e7**3 / MU)


def arcs(r_1, r_2, seconds, most=20):
    found = np.empty((4 * most + 2, 6))
    return found[: lambert.arcs(r_1, r_2, seconds, MU, most, found)]


def test_the_instance_is_read(problem):
    """The small instance has 49 targets and the limits that its header names."""
    assert problem.targets == 49
    assert problem.name == "small"
    assert (problem.begin_d, problem.least_flight_d, problem.longest_d) == (0.0, 0.001, 200.0)
    assert (problem.most_m_s, problem.most_exception_m_s, problem.exceptions) == (100.0, 600.0, 5)


def test_bodies_move_on_ellipses(problem):
    """A state has the energy of its axis, comes back after a period, and moves as it says."""
    for elements in problem.elements[::7]:
        period = 2.0 * math.pi * math.sqrt(elements[0] ** 3 / MU)
        times = np.array([0.0, 1e5, 1e5 + 1.0, 1e5 - 1.0, 1e5 + 3.0 * period])
        positions, velocities = kepler.states_of(elements, times)
        energy = 0.5 * (velocities**2).sum(axis=1) - MU / np.linalg.norm(positions, axis=1)
        assert energy == pytest.approx(-0.5 * MU / elements[0], rel=1e-12)
        assert positions[4] == pytest.approx(positions[1], abs=1e-3)
        assert (positions[2] - positions[3]) / 2.0 == pytest.approx(velocities[1], abs=1e-3)
        height = np.cross(positions[1], velocities[1])
        tilt = math.acos(height[2] / np.linalg.norm(height))
        assert tilt == pytest.approx(abs(elements[2]), abs=1e-9)


def test_the_sixth_element_is_the_mean_anomaly(problem):
    """At t = 0 a target is where its sixth element says if that is the mean anomaly."""
    for axis, eccentricity, _, _, _, mean in problem.elements:
        elements = np.array([axis, eccentricity, 0.3, 0.0, 0.0, mean])
        positions, velocities = kepler.states_of(elements, np.zeros(1))
        cosine = (1.0 - np.linalg.norm(positions[0]) / axis) / eccentricity
        sine = positions[0] @ velocities[0] / (eccentricity * math.sqrt(MU * axis))
        anomaly = math.atan2(sine, cosine)
        assert math.cos(anomaly - eccentricity * sine - mean) == pytest.approx(1.0, abs=1e-12)


def test_the_anomaly_solves_its_equation():
    """E − e sin E is the mean anomaly, to rounding, up to eccentricities of 0.9."""
    for mean in np.linspace(-7.0, 7.0, 41):
        for eccentricity in (0.0, 0.01, 0.5, 0.9):
            anomaly = kepler.eccentric_anomaly(mean, eccentricity)
            assert anomaly - eccentricity * math.sin(anomaly) == pytest.approx(mean, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_arcs_are_those_of_another_solver(seed):
    """All arcs with up to three revolutions are those that boinor finds, and there are no more."""
    izzo = pytest.importorskip("boinor.core.iod").izzo
    r_1, r_2, seconds = ends(seed)
    found = arcs(r_1, r_2, seconds, 3)
    wanted = []
    for prograde in (True, False):
        for revolutions in range(4):
            for low in (True, False) if revolutions else (True,):
                try:
                    pair = izzo(MU, r_1, r_2, seconds, revolutions, prograde, low, 50, 1e-10)
                except ValueError:
                    continue
                wanted.append(np.concatenate(pair))
    assert len(found) == len(wanted)
    for arc in wanted:
        assert np.abs(found - arc).max(axis=1).min() < 1e-4


@pytest.mark.parametrize("seed", range(6))
def test_arcs_arrive(seed):
    """Flown from the first position, every arc is at the second one in time."""
    integrate = pytest.importorskip("scipy.integrate").solve_ivp
    r_1, r_2, seconds = ends(seed)

    def falling(_, state):
        return np.concatenate([state[3:], -MU * state[:3] / np.linalg.norm(state[:3]) ** 3])

    found = arcs(r_1, r_2, seconds)
    assert len(found) >= 2
    for arc in found[:: max(1, len(found) // 8)]:
        begin = np.concatenate([r_1, arc[:3]])
        flown = integrate(falling, (0.0, seconds), begin, "DOP853", rtol=1e-12, atol=1e-6).y[:, -1]
        assert flown[:3] == pytest.approx(r_2, abs=10.0)
        assert flown[3:] == pytest.approx(arc[3:], abs=1e-2)


def test_arcs_near_the_line_through_the_centre_are_arcs():
    """Between ends less than a few degrees apart every arc takes the time that it was asked for.

    Steps that are not kept between bounds end anywhere there, at arcs that miss by thousands of
    kilometres.
    """
    random = np.random.default_rng(0)
    for _ in range(20_000):
        angle, share = 10.0 ** random.uniform(-3.0, -1.0), random.uniform(0.97, 1.0)
        chord = math.sqrt(1.0 + share**2 - 2.0 * share * math.cos(angle))
        ratio = random.choice([-1, 1]) * math.sqrt(1.0 - chord / (0.5 * (1.0 + share + chord)))
        revolutions = int(random.integers(1, 8))
        shortest, at = lambert.least_flight(ratio, revolutions)
        for off in (-1e-3, 1e-3):
            assert lambert.flight(at + off * (1.0 - abs(at)), ratio, revolutions) > shortest
        wanted = shortest * (1.0 + 10.0 ** random.uniform(-6.0, 0.0))
        for upper in (False, True):
            guess = lambert._guess_round(wanted, revolutions, upper)
            x = lambert.invert(wanted, ratio, revolutions, upper, guess)
            assert (x > at) == upper
            assert lambert.flight(x, ratio, revolutions) == pytest.approx(wanted, rel=1e-7)


def test_a_line_with_the_centre_has_no_arc():
    """Opposite positions have no plane, so that no arc is found, and no leg."""
    assert len(arcs(np.array([1e7, 0.0, 0.0]), np.array([-2e7, 0.0, 0.0]), 1e5)) == 0


def test_the_quick_look_hides_no_leg(problem):
    """Legs within a limit are the same whether dearer ones are looked at or not."""
    rng = np.random.default_rng(5)
    departures, flights = np.sort(rng.uniform(0.0, 50.0, 40)), np.linspace(0.2, 6.0, 30)
    met = 0
    for i, j in ((0, 5), (18, 46), (11, 4), (34, 23), (12, 10)):
        times = departures * DAY_S, flights * DAY_S
        pair = problem.elements[i], problem.elements[j]
        whole, quick = np.empty((40, 30)), np.empty((40, 30))
        costs.pair_costs(*pair, *times, np.inf, whole)
        costs.pair_costs(*pair, *times, 600.0, quick)
        assert np.array_equal(np.isfinite(quick), whole <= 600.0)
        assert np.array_equal(quick[np.isfinite(quick)], whole[whole <= 600.0])
        met += int(np.isfinite(quick).sum())
        departure, arrival, cost = costs.connections(problem, i, j, departures, flights, 600.0)
        assert np.array_equal(cost, quick[np.isfinite(quick)])
        assert (arrival > departure).all()
    assert met > 0


def test_matrices_hold_the_shortest_legs(problem):
    """A matrix has the first flight of the grid that is cheap enough, and its ΔV."""
    three = Problem("three", *list(vars(problem).values())[1:-1], problem.elements[[34, 23, 18]])
    departures, flights = np.array([0.0, 1.0]), np.linspace(0.05, 2.0, 40)
    duration, delta_v = costs.matrices(three, departures, flights, 600.0)
    assert np.isinf(duration[:, range(3), range(3)]).all()
    places = np.argwhere(np.isfinite(duration))
    assert len(places)
    for d, i, j in places:
        legs = [costs.delta_v_m_s(three, i, j, departures[d], flight) for flight in flights]
        first = next(place for place, leg in enumerate(legs) if leg <= 600.0)
        assert duration[d, i, j] == flights[first] * DAY_S
        assert delta_v[d, i, j] == legs[first]


@pytest.fixture(scope="module")
def legal(problem):
    """Four targets, and a legal tour of them found by trying flights."""
    four = Problem("four", *list(vars(problem).values())[1:-1], problem.elements[[34, 23, 18, 46]])
    ready, departures, flights = 0.0, [], []
    for leg in range(3):
        for flight in np.arange(0.05, 5.0, 0.05):
            if costs.delta_v_m_s(four, leg, leg + 1, ready, flight) <= 600.0:
                break
        departures.append(ready)
        flights.append(flight)
        ready += flight
    return four, Tour(np.array(departures), np.array(flights), np.arange(4))


def test_a_legal_tour_lasts_until_its_last_arrival(legal):
    """The duration of a tour is its last arrival, and nothing is broken."""
    four, tour = legal
    found = score(four, tour)
    assert found.violations == ()
    assert found.duration_d == tour.departures_d[-1] + tour.flights_d[-1]
    assert found.exceptions == sum(leg > 100.0 for leg in found.delta_v_m_s)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda leaves, flies, order: (leaves - [0.0, 0.0, 0.01], flies, order), "leg 2: leaves"),
        (lambda leaves, flies, order: (leaves, flies * 1e-9, order), "leg 0: a flight"),
        (lambda leaves, flies, order: (leaves + 200.0, flies, order), "d in all"),
        (lambda leaves, flies, order: (leaves, flies * 0.2, order), "m/s"),
        (lambda leaves, flies, order: (leaves, flies, np.zeros(4, int)), "once"),
    ],
)
def test_broken_rules_are_named(legal, change, said):
    """A tour that breaks a rule is told by a sentence about that rule."""
    four, tour = legal
    found = score(four, Tour(*change(*vars(tour).values())))
    assert any(said in sentence for sentence in found.violations), found.violations


def test_too_many_exceptions_are_named(legal):
    """Legs over the usual limit are counted, and told where there are too many."""
    four, tour = legal
    values = vars(four) | {"most_m_s": 1e-3, "exceptions": 2}
    found = score(Problem(**values), tour)
    assert found.exceptions == 3
    assert any("3 legs over" in sentence for sentence in found.violations)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("p kttsp", "p tsp", "not the one line 'p kttsp"),
        ("200.0 100.0", "100.0", "line 3: 5 values instead of 6"),
        ("p kttsp", "c kttsp", "no line 'p kttsp"),
        ("600.0 5", "600.0 5.5", "5.5 exceptions"),
        ("1.496861100e+07", "-1.496861100e+07", "no closed orbit"),
        ("1.496861100e+07", "far", "'far' is no finite number"),
    ],
)
def test_broken_instances_are_refused(tmp_path, old, new, said):
    """An instance that is not what it should be is refused with file, line and reason."""
    with pytest.raises(InputError, match=said):
        read_problem(broken(tmp_path, SMALL, old, new))


def test_solutions_are_read_or_refused(tmp_path):
    """A submitted file gives its tour; one without figures, or with too few, a sentence."""
    path = tmp_path / "small.json"
    path.write_text(json.dumps([{"decisionVector": [0.0, 2.0, 1.0, 1.5, 2, 0, 1]}]))
    tour = read_tour(path, 3)
    assert list(tour.order) == [2, 0, 1]
    assert list(tour.departures_d) == [0.0, 2.0]
    with pytest.raises(InputError, match="7 figures instead of 10"):
        read_tour(path, 4)
    with pytest.raises(InputError, match="whole numbers"):
        tour_of(np.array([0.0, 2.0, 1.0, 1.5, 2.5, 0.0, 1.0]), 3, "it")
    for text in ("{", "[]", '[{"decisionVector": ["a"]}]', '[{"decisionVector": [NaN]}]'):
        path.write_text(text)
        with pytest.raises(InputError, match="decisionVector"):
            read_tour(path, 3)
