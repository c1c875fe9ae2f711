"""Observations, number by number, against plain Python on the timetable's public lookups."""

from __future__ import annotations

import math

import numpy as np
import pytest
from plain_world import revolution_s
from random_rules import drifting_field

from adr_opt import Instance, Mission, generate
from adr_opt.kernels.episodes import episodes as kernels
from adr_opt.kernels.episodes.choices import (
    CHOICE_FIELDS,
    LIMIT,
    LOOKED_AHEAD,
    MISSION_FIELDS,
    NEAREST,
    ONWARD,
)
from adr_opt.kernels.episodes.published import PUBLISHED_ELEMENTS
from adr_opt.learning.episodes import Board, FieldPool, new_episodes, published_size, start
from adr_opt.legs.nearest_pairs import PERIODS, places_of

MU = 398600.4418e9
HOUR = 3600.0


class Slow:
    """A state of a mission, and what there is to see of it, by the book."""

    def __init__(self, mission: Mission, sequence: list[int]) -> None:
        self.mission = mission
        limits = mission.instance.mission
        self.budget = mission.instance.chaser.tank.delta_v_m_s
        self.duration = limits.duration_s
        orbits = [orbit.circular_elements() for orbit in mission.instance.body_orbits]
        self.radius, self.inclination, self.raan, self.latitude = zip(*orbits, strict=True)
        self.dynamics = mission.instance.dynamics
        self.rate = [
            2.0 * math.pi / revolution_s(orbit, self.dynamics)
            for orbit in mission.instance.body_orbits
        ]
        self.service = [
            2.0 * math.pi / n * (limits.service_revolutions or 0.0) + (limits.service_s or 0.0)
            for n in self.rate
        ]
        self.service[0] = 2.0 * math.pi / self.rate[0] * limits.refuel_revolutions
        self.bodies = range(len(orbits))
        self.body, self.now, self.left, self.since = 0, 0.0, self.budget, 0
        self.visited: set[int] = set()
        for j in sequence:
            delta_v, end = self.move(self.body, self.now, j)
            assert delta_v <= self.left
            assert end <= self.duration
            self.left = self.budget if j == 0 else self.left - delta_v
            self.body, self.now = j, end
            self.since = 0 if j == 0 else self.since + 1
            self.visited |= {j} - {0}

    def move(self, i: int, ready: float, j: int) -> tuple[float, float]:
        """ΔV and end of service."""
        if i == j:
            return math.inf, math.inf
        delta_v, arrival = self.mission.timetable.lookup(i, j, ready)
        return delta_v, arrival + self.service[j]

    def node(self, j: int) -> float:
        """RAAN of a body now."""
        if self.dynamics == "two-body":
            return self.raan[j]
        orbit = self.mission.instance.body_orbits[j]
        p = orbit.semi_major_axis_m * (1.0 - orbit.eccentricity**2)
        n = math.sqrt(MU / orbit.semi_major_axis_m**3)
        strength = 1.5 * 1.08262668e-3 * (6378137.0 / p) ** 2 * n
        return self.raan[j] - strength * math.cos(self.inclination[j]) * self.now

    def allowed(self, j: int) -> bool:
        """Unvisited, or a refuelling that is earned."""
        if j == 0:
            return self.since > 0
        return j not in self.visited

    def legal(self, j: int) -> bool:
        """Allowed, and within ΔV and time."""
        delta_v, end = self.move(self.body, self.now, j)
        return self.allowed(j) and delta_v <= self.left and end <= self.duration

    def nearest(self, j: int) -> list[int]:
        """Targets nearest to a body in the present period of the mission, nearest first."""
        periods = PERIODS if self.dynamics == "j2" else 1
        length = self.duration / periods
        period = min(int(self.now / length), periods - 1)
        points = np.nan_to_num(places_of(self.mission.instance, (period + 0.5) * length))
        away = np.linalg.norm(points - points[j], axis=1)
        others = sorted((k for k in self.bodies if k not in (0, j)), key=lambda k: away[k])
        # As many of the station as of a target.
        return others[: min(NEAREST, len(self.bodies) - 2)]

    def cost(self, j: int) -> float:
        """Hours and ΔV of a move."""
        delta_v, end = self.move(self.body, self.now, j)
        return (end - self.now) / HOUR + delta_v / 450.0

    def onward(self, j: int, left: float) -> list[tuple[float, float, float]]:
        """Cost [h], ΔV and hours of moves after a move, the cheapest first."""
        legal = sorted((k for k in self.bodies if k and self.legal(k)), key=self.cost)
        if j not in legal[:LOOKED_AHEAD]:
            return []
        end = self.move(self.body, self.now, j)[1]
        found = []
        for k in [k for k in self.nearest(j) if k not in self.visited][:ONWARD]:
            delta_v, then = self.move(j, end, k)
            if delta_v <= left and then <= self.duration:
                hours = (then - end) / HOUR
                found.append((hours + delta_v / 450.0, delta_v, hours))
        return sorted(found)


def bounded(value: float, low: float = 0.0) -> float:
    return min(max(value, low), LIMIT)


def wrapped(angle: float) -> float:
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def slow_move(slow: Slow, j: int) -> dict[str, float]:
    """What :data:`CHOICE_FIELDS` say of a move in a certain world."""
    s = slow
    delta_v, end = s.move(s.body, s.now, j) if s.allowed(j) or j == 0 else (math.inf, math.inf)
    hours = (end - s.now) / HOUR
    connected = math.isfinite(end)
    after = s.left - delta_v
    if j == 0:
        after = s.budget if s.body else -math.inf
    back_v, back_end = 0.0, end
    if end <= s.duration and j != 0:
        back_v, back_end = s.move(j, end, 0)
    following = s.onward(j, after) if j else []
    near = s.nearest(j)
    sine = math.sin(s.inclination[0])
    cosine = math.cos(s.inclination[0])
    phase = [s.latitude[k] + s.now * s.rate[k] + cosine * s.node(k) for k in (j, s.body)]
    tilt = math.degrees(s.inclination[j] - s.inclination[s.body])
    turn = math.degrees(wrapped(s.node(j) - s.node(s.body))) * sine
    values = [
        float(s.legal(j)),
        float(j == 0),
        float(s.allowed(j) and j != s.body),
        bounded(delta_v / 1e3),
        bounded(delta_v / max(s.left, 1.0)),
        bounded(hours / 10.0),
        bounded((end - s.now) / max(s.duration - s.now, 1.0)),
        bounded((hours + delta_v / 450.0) / 10.0),
        bounded(after / 1e3, -LIMIT),
        bounded((s.duration - end) / 36e3, -LIMIT),
        bounded(back_v / 1e3),
        bounded((after - back_v) / 1e3, -LIMIT),
        float(back_v <= after and back_end <= s.duration),
        bounded((back_end - end) / 36e3) if connected and math.isfinite(back_end) else LIMIT,
        bounded(following[0][1] / 1e3) if following else LIMIT,
        bounded(following[0][2] / 10.0) if following else LIMIT,
        bounded(following[0][0] / 10.0) if following else LIMIT,
        bounded(following[1][0] / 10.0) if len(following) > 1 else LIMIT,
        len([k for k in near if k not in s.visited]) / len(near),
        bounded((s.radius[j] - s.radius[s.body]) / 50e3, -LIMIT),
        bounded(tilt, -LIMIT),
        bounded(turn, -LIMIT),
        bounded(math.hypot(tilt, turn)),
        bounded((s.radius[j] - s.radius[0]) / 50e3, -LIMIT),
        bounded(math.degrees(s.inclination[j] - s.inclination[0]), -LIMIT),
        bounded(math.degrees(wrapped(s.node(j) - s.node(0))) * sine, -LIMIT),
        wrapped(phase[0] - phase[1]) / math.pi,
        float(j != 0),
        float(j != 0),
        0.0,
        1.0,
        0.0 if connected else LIMIT,
        float(s.legal(j)),
        *[s.service[j] / 36e3] * 3,
    ]
    return dict(zip(CHOICE_FIELDS, values, strict=True))


def slow_mission(slow: Slow) -> list[float]:
    """What :data:`MISSION_FIELDS` say."""
    s = slow
    left_s = s.duration - s.now
    unvisited = len(s.bodies) - 1 - len(s.visited)
    station_v, station_end = s.move(s.body, s.now, 0)
    reachable = s.body == 0 or (station_v <= s.left and station_end <= s.duration)
    return [
        s.left / 1e3,
        s.left / max(s.budget, 1.0),
        s.budget / 1e3,
        left_s / 604800.0,
        left_s / s.duration,
        s.duration / 604800.0,
        unvisited / 50.0,
        sum(s.legal(j) for j in s.bodies) / (unvisited + 1),
        float(s.body == 0),
        float(s.since > 0),
        bounded((s.radius[s.body] - s.radius[0]) / 50e3, -LIMIT),
        bounded(math.degrees(s.inclination[s.body] - s.inclination[0]), -LIMIT),
        bounded(
            math.degrees(wrapped(s.node(s.body) - s.node(0))) * math.sin(s.inclination[0]), -LIMIT
        ),
        float(reachable),
        bounded(left_s / HOUR / max(unvisited, 1) / 10.0),
    ]


def random_states(
    instance: Instance, seed: int, count: int
) -> list[tuple[Mission, FieldPool, kernels.Episodes, list[int]]]:
    """States that random legal moves lead to, cheap ones more often, so that many make many."""
    mission = Mission(instance)
    pool = FieldPool.of(mission)
    rng = np.random.default_rng(seed)
    targets = len(instance.targets)
    found = []
    for number in range(count):
        episodes = new_episodes(1, targets + 1)
        start(pool, episodes, 0, 0, instance.chaser.tank.delta_v_m_s, instance.mission.duration_s)
        board, rewards = Board("choices", 1, targets), np.zeros(1, dtype=np.float32)
        sequence: list[int] = []
        for _ in range(number):
            board.observe(pool.arrays, episodes, 0, 1)
            if not board.legal[0]:
                break
            cost = board.arrays["moves"][0, :, 7] + rng.exponential(0.3, size=targets + 1)
            action = int(np.where(board.mask[0], cost, np.inf).argmin())
            kernels.act(pool.arrays, episodes, 0, 1, np.array([action]), rewards)
            sequence.append(int(kernels.body_of(action, targets)))
        found.append((mission, pool, episodes, sequence))
    return found


FIELDS = {
    "fourteen": generate("reduced-time", 41, targets=14),
    "zones": generate("reduced-time", 44, targets=13, zones=12),
    "tight": generate("tiny", 3).with_limits(delta_v_m_s=700.0),
    "cloud": generate("cloud", 5, targets=12).with_limits(duration_s=2.5 * 86400.0),
    "nodes": generate("reduced-time", 42, targets=12).replace(dynamics="j2"),
    "waiting": drifting_field(np.random.default_rng(4), 150 * 86400.0, targets=9),
}


@pytest.mark.parametrize("name", FIELDS)
def test_every_number_of_choices_is_what_its_name_says(name: str) -> None:
    """CHOICE_FIELDS and MISSION_FIELDS agree with plain Python for every move of random states."""
    instance = FIELDS[name]
    targets = len(instance.targets)
    compared = 0
    for mission, pool, episodes, sequence in random_states(instance, 1, 11):
        board = Board("choices", 1, targets)
        board.observe(pool.arrays, episodes, 0, 1)
        slow = Slow(mission, sequence)
        seen = board.choices
        wanted_mission = np.clip(slow_mission(slow), -LIMIT, LIMIT)
        np.testing.assert_allclose(seen.mission[0], wanted_mission, rtol=0.0, atol=2e-6)
        for j in slow.bodies:
            row = kernels.action_of(j, targets)
            assert board.mask[0, row] == slow.legal(j)
            if j in slow.visited:
                assert not seen.moves[0, row].any()
                continue
            wanted = slow_move(slow, j)
            for column, field in enumerate(CHOICE_FIELDS):
                compared += 1
                got = float(seen.moves[0, row, column])
                assert abs(got - wanted[field]) <= 3e-6, (sequence, j, field, got, wanted[field])
        assert board.legal[0] == sum(slow.legal(j) for j in slow.bodies)
    assert compared > 1000


@pytest.mark.parametrize("name", FIELDS)
def test_every_number_of_published_is_what_the_space_says(name: str) -> None:
    """``published`` is visited mask, shares of ΔV and time left, and six elements of each body."""
    instance = FIELDS[name]
    targets = len(instance.targets)
    for mission, pool, episodes, sequence in random_states(instance, 3, 6):
        board = Board("published", 1, targets)
        board.observe(pool.arrays, episodes, 0, 1)
        slow = Slow(mission, sequence)
        wanted = [float(j in slow.visited) for j in slow.bodies if j != 0]
        wanted += [slow.left / slow.budget, 1.0 - slow.now / slow.duration]
        for j in (slow.body, *(j for j in slow.bodies if j != 0)):
            wanted += [
                bounded((slow.radius[j] - slow.radius[0]) / 50e3, -LIMIT),
                0.0,
                bounded(math.degrees(slow.inclination[j] - slow.inclination[0]), -LIMIT),
                bounded(math.degrees(wrapped(slow.node(j) - slow.node(0))), -LIMIT),
                0.0,
                wrapped(slow.latitude[j] + slow.now * slow.rate[j]) / math.pi,
            ]
        assert len(wanted) == published_size(targets)
        assert len(PUBLISHED_ELEMENTS) == 6
        np.testing.assert_allclose(board.arrays[0], wanted, rtol=0.0, atol=3e-6)
        assert [board.mask[0, kernels.action_of(j, targets)] for j in slow.bodies] == [
            slow.legal(j) for j in slow.bodies
        ]


@pytest.mark.parametrize("name", ["choices", "published"])
def test_an_observation_depends_on_the_state_alone(name: str) -> None:
    """What a board held before, and the order of the episodes, leave no trace."""
    instance = FIELDS["tight"]
    targets = len(instance.targets)
    mission = Mission(instance)
    # Room for more bodies than the field has, as in a pool of fields of many sizes.
    room = targets + 3
    pool = FieldPool(2, room + 1, mission.timetable.most_events + 2)
    pool.install(0, Mission(generate("tiny", 8)))
    pool.install(0, mission)
    count = 12
    episodes = new_episodes(count, room + 1)
    for index in range(count):
        start(pool, episodes, index, 0, 300.0 + 60.0 * index, 1.5 * 86400.0)
    board = Board(name, count, room)
    rewards = np.zeros(count, dtype=np.float32)
    rng = np.random.default_rng(0)
    shrunk = 0
    before = np.zeros_like(board.mask)
    while True:
        board.order = rng.permutation(count).astype(np.int32)
        board.observe(pool.arrays, episodes, 0, 5)
        board.observe(pool.arrays, episodes, 5, count)
        fresh = Board(name, count, room)
        fresh.observe(pool.arrays, episodes, 0, count)
        seen, wanted = board.arrays, fresh.arrays
        for key in wanted if isinstance(wanted, dict) else [slice(None)]:
            np.testing.assert_array_equal(seen[key], wanted[key])
        np.testing.assert_array_equal(board.mask, fresh.mask)
        np.testing.assert_array_equal(board.legal, board.mask.sum(axis=1))
        # Targets that were legal, are still open and are legal no more: what used to be stale.
        shrunk += int((before[:, :-1] & ~board.mask[:, :-1] & ~episodes.visited[:, 1:]).sum())
        before = board.mask.copy()
        assert not board.mask[:, targets:room].any()
        if isinstance(wanted, dict):
            assert not wanted["moves"][:, targets:room].any()
        if not board.legal.any():
            break
        actions = (board.mask * rng.random(board.mask.shape)).argmax(axis=1)
        alive = np.flatnonzero(board.legal).astype(np.int32)
        kernels.act(pool.arrays, episodes, 0, alive.size, actions, rewards, alive)
    assert shrunk > 0


def test_names_count_the_numbers() -> None:
    """There is one name for every number, and none twice among the choices and the mission."""
    assert len(CHOICE_FIELDS) == 36
    assert len(MISSION_FIELDS) == 15
    assert len(set(CHOICE_FIELDS)) == len(CHOICE_FIELDS)
    assert len(set(MISSION_FIELDS)) == len(MISSION_FIELDS)
