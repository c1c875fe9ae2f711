"""Integrated and averaged flight with low thrust, and the primer vector that steers it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, MU_M3_S2
from adr_opt.fly.refine.bodies import near_circle
from adr_opt.judge.refined.thrust import is_dark
from adr_opt.kernels.orbits import coast, mean_thrusting, primer, sunlight, thrusting
from adr_opt.kernels.orbits.gravity import FIELDS
from adr_opt.kernels.orbits.thrusting import Push, ThrustArcs

EXHAUST_M_S = 15e3


def circle(rng: np.random.Generator) -> np.ndarray:
    """State on a circle in a random plane."""
    r = EARTH_RADIUS_M + rng.uniform(600e3, 1000e3)
    inclination, node, place = rng.uniform(0.5, 2.6), rng.uniform(0.0, 6.0), rng.uniform(0.0, 6.0)
    ci, si, co, so = (f(a) for a in (inclination, node) for f in (math.cos, math.sin))
    along, ahead = np.array([co, so, 0.0]), np.array([-so * ci, co * ci, si])
    c, s, v = math.cos(place), math.sin(place), math.sqrt(MU_M3_S2 / r)
    return np.r_[r * (c * along + s * ahead), v * (c * ahead - s * along)]


def arcs(rng: np.random.Generator, spans: tuple[float, float]) -> ThrustArcs:
    """Two arcs with random laws, a day and eight days after the beginning."""
    laws = rng.normal(size=(2, 5))
    least = np.array([0.4 * primer.peak(law) for law in laws])
    return ThrustArcs(laws, least, np.array([1.0, 8.0]) * DAY_S, np.array(spans))


@pytest.mark.parametrize("seed", range(20))
def test_the_primer_is_what_thrust_is_worth(seed: int) -> None:
    """A short thrust changes the elements, weighed by a law, by the length of the primer vector."""
    rng = np.random.default_rng(seed)
    state, law = circle(rng), rng.normal(size=5)
    zonals, seconds = FIELDS["two-body"], 20.0
    start = thrusting.elements_of(state, 0.0)
    u = start[6] - math.atan2(start[4], start[3])
    one = ThrustArcs(law[None], np.zeros(1), np.zeros(1), np.array([seconds]))
    # The Sun is on one side or, half a year on, on the other.
    for since in (8e8, 8e8 + 182.6 * DAY_S):
        push, now = Push(0.05, EXHAUST_M_S, 300.0, since), start.copy()
        _, _, left = thrusting.fly(now, seconds, push, one, zonals, np.empty((0, 3)))
        if left < 1e-6:
            break
    assert left < 1e-6
    free = state.copy()
    coast.coast(free, seconds, zonals, np.empty((0, 0)))
    a, b = (near_circle(each, zonals) for each in (thrusting.state_of(now), free))
    change = a - b
    weighed = law[0] * change[1] + law[1] * change[2] + law[2] * change[0] / (2.0 * b[0])
    weighed += law[3] * change[3] + law[4] * math.sin(b[3]) * change[4]
    speed = math.sqrt(MU_M3_S2 / b[0])
    middle = u + 0.5 * seconds * speed / b[0]
    expected = 0.05 / 300.0 * seconds / speed * primer.length(law, middle)
    assert weighed == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("field", sorted(FIELDS))
def test_without_thrust_the_flight_is_a_coast(field: str) -> None:
    """Without thrust the integration in longitude ends where the one in time does."""
    state = circle(np.random.default_rng(3))
    now = thrusting.elements_of(state, 0.0)
    none = ThrustArcs(np.empty((0, 5)), np.empty(0), np.empty(0), np.empty(0))
    thrusting.fly(
        now, 30.0 * DAY_S, Push(1.0, EXHAUST_M_S, 300.0, 0.0), none, FIELDS[field], np.empty((0, 3))
    )
    coast.coast(state, 30.0 * DAY_S, FIELDS[field], np.empty((0, 0)))
    assert np.linalg.norm((thrusting.state_of(now) - state)[:3]) < 0.01


@pytest.mark.parametrize("seed", range(10))
def test_thrust_lasts_as_long_as_asked_and_is_off_in_the_shadow(seed: int) -> None:
    """Windows add up to the time asked for, follow each other, and lie in sunlight."""
    rng = np.random.default_rng(seed)
    state, since = circle(rng), rng.uniform(8e8, 9e8)
    spans = rng.uniform(2e4, 1e5), rng.uniform(2e4, 1e5)
    push, wanted = Push(0.05, EXHAUST_M_S, 300.0, since), arcs(rng, spans)
    now, room = thrusting.elements_of(state, 0.0), np.empty((2000, 3))
    count, mass, left = thrusting.fly(now, 16.0 * DAY_S, push, wanted, FIELDS["j2"], room)
    windows = room[:count]
    assert left == 0.0
    for number, span in enumerate(spans):
        lengths = np.diff(windows[windows[:, 2] == number, :2], axis=1)
        assert lengths.sum() == pytest.approx(span, abs=1e-5)
    assert mass == pytest.approx(300.0 - 0.05 / EXHAUST_M_S * sum(spans), abs=1e-9)
    edges = windows[:, :2].ravel()
    assert (np.diff(edges) >= 0.0).all()
    times = np.sort(np.r_[edges, windows[:, :2].mean(axis=1)])
    again = thrusting.elements_of(state, 0.0)
    states = thrusting.follow(again, times, windows, wanted.laws, push, FIELDS["j2"])
    for time, there in zip(times, states, strict=True):
        assert not is_dark(thrusting.elements_of(there, time)[[0, 1, 2, 3, 4, 6]], since + time)


@pytest.mark.slow
def test_thrust_is_off_in_the_shortest_shadows() -> None:
    """Spirals whose planes are about to leave the shadow, or to enter it, thrust in sunlight."""
    rng = np.random.default_rng(1)
    law, zonals = np.array([[0.0, 0.0, -1.0, 0.0, 0.0]]), FIELDS["j2"]
    grazes = 0
    for _ in range(60):
        since = rng.uniform(8e8, 9e8)
        sun = np.array(sunlight.sun_direction(since))
        r = EARTH_RADIUS_M + rng.uniform(600e3, 1000e3)
        # The Sun's height above the plane at which the orbit passes some kilometres off the shadow.
        height = math.acos(min((EARTH_RADIUS_M + rng.uniform(-2e4, 3e4)) / r, 1.0))
        height = 0.5 * math.pi - height
        across = np.cross(sun, rng.normal(size=3))
        across /= np.linalg.norm(across)
        normal = math.sin(height) * sun + math.cos(height) * across
        start = np.cross(normal, rng.normal(size=3))
        start /= np.linalg.norm(start)
        state = np.r_[r * start, math.sqrt(MU_M3_S2 / r) * np.cross(normal, start)]
        push = Push(0.3, EXHAUST_M_S, 300.0, since)
        wanted = ThrustArcs(law, np.zeros(1), np.zeros(1), np.array([3.0 * DAY_S]))
        now, room = thrusting.elements_of(state, 0.0), np.empty((500, 3))
        count, _, _ = thrusting.fly(now, 2.0 * DAY_S, push, wanted, zonals, room)
        windows = room[:count]
        grazes += count > 1
        times = np.concatenate([np.arange(begin, end, 30.0) for begin, end, _ in windows])
        again = thrusting.elements_of(state, 0.0)
        states = thrusting.follow(again, times, windows, law, push, zonals)
        for time, there in zip(times, states, strict=True):
            assert not is_dark(thrusting.elements_of(there, time)[[0, 1, 2, 3, 4, 6]], since + time)
    assert grazes > 10


@pytest.mark.slow
def test_windows_of_half_a_revolution_end_in_sunlight() -> None:
    """A window that begins nearly half a revolution before the shadow ends before it, too."""
    rng = np.random.default_rng(2)
    law, zonals, ends = np.array([[0.0, 0.0, 1.0, 0.0, 0.0]]), FIELDS["j2"], 0
    for _ in range(400):
        state, since = circle(rng), rng.uniform(8e8, 9e8)
        start, push = thrusting.elements_of(state, 0.0), Push(0.05, EXHAUST_M_S, 300.0, since)
        one, room = ThrustArcs(law, np.zeros(1), np.zeros(1), np.array([5e3])), np.empty((9, 3))
        count, _, _ = thrusting.fly(start.copy(), 6e3, push, one, zonals, room)
        if count < 2:
            continue
        # From places about half a revolution before the end of the first window.
        end = room[0, 1]
        back = thrusting.follow(start.copy(), np.array([end]), room[:0], law, push, zonals)[0]
        for before in np.linspace(3.08, 3.13, 12):
            earlier = back.copy()
            pace = math.sqrt(MU_M3_S2 / np.linalg.norm(back[:3]) ** 3)
            coast.coast(earlier, -before / pace, zonals, np.empty((0, 0)))
            begin = end - before / pace
            now = thrusting.elements_of(earlier, begin)
            arc = ThrustArcs(law, np.zeros(1), np.array([begin]), np.array([9e3]))
            found, _, _ = thrusting.fly(now, end + 3e3, push, arc, zonals, room)
            times = room[:found, 1]
            states = thrusting.follow(
                thrusting.elements_of(earlier, begin), times, room[:found], law, push, zonals
            )
            for time, there in zip(times, states, strict=True):
                place = thrusting.elements_of(there, time)[[0, 1, 2, 3, 4, 6]]
                assert not is_dark(place, since + time)
                ends += 1
    assert ends > 500


@pytest.mark.parametrize("seed", range(10))
def test_the_average_predicts_the_integration(seed: int) -> None:
    """What thrust does by averaged and by integrated motion differs by little of the ΔV."""
    rng = np.random.default_rng(seed)
    state, since = circle(rng), rng.uniform(8e8, 9e8)
    push, wanted = Push(0.05, EXHAUST_M_S, 300.0, since), arcs(rng, (9e4, 9e4))
    start = near_circle(state, FIELDS["j2"])
    ends = []
    for spans in (wanted.spans, np.zeros(2)):
        now, these = thrusting.elements_of(state, 0.0), wanted._replace(spans=spans)
        thrusting.fly(now, 16.0 * DAY_S, push, these, FIELDS["j2"], np.empty((0, 3)))
        mean, _, left = mean_thrusting.fly(start, 0.0, 16.0 * DAY_S, push, these)
        assert left < 1.0
        ends.append(mean - near_circle(thrusting.state_of(now), FIELDS["j2"]))
    speed = math.sqrt(MU_M3_S2 / start[0])
    costs = speed * np.array([0.5 / start[0], 0.5, 0.5, 1.0, math.sin(start[3])])
    off = (ends[0] - ends[1])[:5]
    off[4] = math.remainder(off[4], math.tau)
    assert np.abs(off * costs).max() < 0.05 * (2.0 * 9e4 * 0.05 / 300.0)
