"""Observations, number by number, against plain Python on the timetable's public lookups."""

from __future__ import annotations

import math

import numpy as np
import pytest
from plain_world import revolution_s
from random_rules import drifting_field

from adr_opt import Instance, Mission, generate
from adr_opt.kernels.episodes import episodes as kernels
from adr_opt.kernels.episodes.lookahead import (
    CHAIN_FIELDS,
    CHAINS,
    FOLLOWED,
    NOTHING_HOURS,
    SLACK_PER_S,
    UNGUARDED_S,
)
from adr_opt.kernels.episodes.observation import LIMIT, MISSION_FIELDS, MOVE_FIELDS
from adr_opt.kernels.episodes.published import PUBLISHED_ELEMENTS
from adr_opt.kernels.tables.timetable import LEAST_STEPS
from adr_opt.learning.episodes import (
    Board,
    FieldPool,
    move_fields,
    new_episodes,
    published_size,
    start,
)

MU = 398600.4418e9
HOUR = 3600.0
MOST_HOURS = 65.535
"""More is not told of what lies ahead: 16 bits of 0.001 h."""

QUANTUM = 6e-5
"""Half of 0.1 m/s and of 0.001 h, as observations scale them, and their rounding to 32 bits."""


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
        self._lists: dict[tuple[int, int], list[tuple[int, float, float]]] = {}
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

    def way_home(self, j: int, ready: float) -> float:
        """ΔV of the first departure for the station that no zone blocks."""
        while ready <= self.duration:
            delta_v, _ = self.move(j, ready, 0)
            if math.isfinite(delta_v):
                return delta_v
            ready += math.pi / self.rate[j]
        return math.inf

    def allowed(self, j: int) -> bool:
        """Unvisited, or a refuelling that is earned."""
        if j == 0:
            return self.since > 0
        return j not in self.visited

    def legal(self, j: int) -> bool:
        """Allowed, and within ΔV and time."""
        delta_v, end = self.move(self.body, self.now, j)
        return self.allowed(j) and delta_v <= self.left and end <= self.duration

    def angle(self, i: int, j: int) -> float:
        """Angle between two planes, from their normals."""
        a, b = (
            np.array(
                [
                    math.sin(self.raan[k]) * math.sin(self.inclination[k]),
                    -math.cos(self.raan[k]) * math.sin(self.inclination[k]),
                    math.cos(self.inclination[k]),
                ]
            )
            for k in (i, j)
        )
        return math.atan2(float(np.linalg.norm(np.cross(a, b))), float(a @ b))

    def ahead(self, j: int, ready: float) -> list[tuple[int, float, float]]:
        """Target, ΔV and hours of the ten cheapest moves from j, at the next half period of j.

        Where events are not regular, the mission is divided into equal steps instead.
        """
        half = math.pi / self.rate[j]
        if self.dynamics == "j2":
            steps = max(self.mission.timetable.most_events, LEAST_STEPS)
            half = self.mission.rules.duration / steps * (1.0 + 1e-9)
        key = (j, math.ceil(ready / half))
        if key not in self._lists:
            found = []
            for k in self.bodies:
                if k not in (0, j):
                    delta_v, end = self.move(j, key[1] * half, k)
                    hours = (end - key[1] * half) / HOUR
                    if math.isfinite(delta_v):
                        cost = hours + delta_v / 450.0
                        found.append((cost, k, delta_v, min(hours, MOST_HOURS)))
            self._lists[key] = [entry[1:] for entry in sorted(found)[:10]]
        return self._lists[key]

    def chain(self, move: int, worth: float, foresight: float) -> tuple[int, float, float]:
        """Greedy to the end: targets, end and ΔV left."""
        body, now, left, since, visited = (
            self.body,
            self.now,
            self.left,
            self.since,
            set(self.visited),
        )
        choice, count = move, 0
        while choice is not None:
            delta_v, end = self.move(body, now, choice)
            left = self.budget if choice == 0 else left - delta_v
            body, now = choice, end
            since = 0 if choice == 0 else since + 1
            count += choice != 0
            visited.add(choice)
            choices = []
            for k, delta_v, end in self.open_ahead(body, now, left, visited):
                if end < self.duration - UNGUARDED_S and self.way_home(k, end) > left - delta_v:
                    continue
                cost = (end - now) / HOUR + delta_v / worth
                after = self.open_ahead(k, end, left - delta_v, visited | {k})
                if after:
                    cost += foresight * ((after[0][2] - end) / HOUR + after[0][1] / worth)
                else:
                    cost += foresight * NOTHING_HOURS
                choices.append((cost, len(choices), k))
            choice = min(choices)[2] if choices else None
            if choice is None and since > 0 and body != 0:
                delta_v, end = self.move(body, now, 0)
                if delta_v <= left and end <= self.duration:
                    choice = 0
        return count, now, left

    def open_ahead(
        self, body: int, now: float, left: float, visited: set[int]
    ) -> list[tuple[int, float, float]]:
        """Target, ΔV and end of service of those ahead that are open and fit."""
        moves = [(k, *self.move(body, now, k)) for k, _, _ in self.ahead(body, now)]
        return [
            (k, delta_v, end)
            for k, delta_v, end in moves
            if k not in visited and delta_v <= left and end <= self.duration
        ]


def bounded(value: float, low: float = 0.0) -> float:
    return min(max(value, low), LIMIT)


def wrapped(angle: float) -> float:
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def slow_move(slow: Slow, j: int) -> tuple[dict[str, float], set[str]]:
    """What :data:`MOVE_FIELDS` say of a move, and which of them hang on a rounding."""
    s = slow
    delta_v, end = s.move(s.body, s.now, j)
    hours = (end - s.now) / HOUR
    after = s.budget if j == 0 else s.left - delta_v
    in_time = end <= s.duration
    fits = in_time and delta_v <= s.left
    unsure: set[str] = set()
    back_v, back_end, margin, safe = 0.0, end, after, fits
    if in_time and j != 0:
        back_v, back_end = s.move(j, end, 0)
        margin = after - back_v
        safe = back_v <= after and back_end <= s.duration
    elif not in_time:
        back_end = end
    following = []
    if in_time:
        hours_left = (s.duration - end) / HOUR
        for k, next_v, next_h in s.ahead(j, end):
            if k in s.visited:
                continue
            if abs(next_v - after) < 0.06 or abs(next_h - hours_left) < 6e-4:
                unsure |= set(MOVE_FIELDS[14:18])
            if next_v <= after and next_h <= hours_left:
                following.append((next_v, next_h))
    costs = [next_h + next_v / 450.0 for next_v, next_h in following]
    near = sorted((s.angle(j, k), k) for k in s.bodies if k not in (0, j))[:6]
    open_near = [angle for angle, k in near if k not in s.visited]
    sine = math.sin(s.inclination[0])
    cosine = math.cos(s.inclination[0])
    phase = [s.latitude[k] + s.now * s.rate[k] + cosine * s.node(k) for k in (j, s.body)]
    values = [
        float(s.legal(j)),
        float(j == 0),
        float(s.allowed(j)),
        bounded(delta_v / 1e3),
        bounded(delta_v / max(s.left, 1.0)),
        bounded(hours / 10.0),
        bounded((end - s.now) / max(s.duration - s.now, 1.0)),
        bounded((hours + delta_v / 450.0) / 10.0),
        bounded(after / 1e3, -LIMIT),
        bounded((s.duration - end) / 36e3, -LIMIT),
        bounded(back_v / 1e3),
        bounded(margin / 1e3, -LIMIT),
        float(safe),
        bounded((back_end - end) / 36e3) if in_time else 0.0,
        bounded(following[0][0] / 1e3) if following else LIMIT,
        bounded(following[0][1] / 10.0) if following else LIMIT,
        bounded(costs[0] / 10.0) if following else LIMIT,
        bounded(costs[1] / 10.0) if len(following) > 1 else LIMIT,
        len(open_near) / 6.0,
        bounded(math.degrees(sum(open_near) / len(open_near))) if open_near else LIMIT,
        bounded((s.radius[j] - s.radius[s.body]) / 50e3, -LIMIT),
        bounded(math.degrees(s.inclination[j] - s.inclination[s.body]), -LIMIT),
        bounded(math.degrees(wrapped(s.node(j) - s.node(s.body))) * sine, -LIMIT),
        bounded(math.degrees(s.angle(s.body, j))),
        bounded((s.radius[j] - s.radius[0]) / 50e3, -LIMIT),
        bounded(math.degrees(s.inclination[j] - s.inclination[0]), -LIMIT),
        bounded(math.degrees(wrapped(s.node(j) - s.node(0))) * sine, -LIMIT),
        bounded(math.degrees(s.angle(0, j))),
        wrapped(phase[0] - phase[1]) / math.pi,
    ]
    return dict(zip(MOVE_FIELDS, values, strict=True)), unsure


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
        unvisited / (len(s.bodies) - 1),
        unvisited / 50.0,
        sum(s.legal(j) for j in s.bodies) / len(s.bodies),
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
        board, rewards = Board("transfer", 1, targets), np.zeros(1, dtype=np.float32)
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
def test_every_number_of_transfer_is_what_its_name_says(name: str) -> None:
    """MOVE_FIELDS and MISSION_FIELDS agree with plain Python for every move of random states."""
    instance = FIELDS[name]
    targets = len(instance.targets)
    compared = skipped = 0
    for mission, pool, episodes, sequence in random_states(instance, 1, 11):
        board = Board("transfer", 1, targets)
        board.observe(pool.arrays, episodes, 0, 1)
        slow = Slow(mission, sequence)
        seen = board.arrays
        assert isinstance(seen, dict)
        wanted_mission = np.clip(slow_mission(slow), -LIMIT, LIMIT)
        np.testing.assert_allclose(seen["mission"][0], wanted_mission, rtol=0.0, atol=2e-6)
        for j in slow.bodies:
            row = kernels.action_of(j, targets)
            assert board.mask[0, row] == slow.legal(j)
            if j in slow.visited:
                assert not seen["moves"][0, row].any()
                continue
            wanted, unsure = slow_move(slow, j)
            skipped += len(unsure)
            for column, field in enumerate(MOVE_FIELDS):
                if field in unsure:
                    continue
                compared += 1
                slack = QUANTUM if 14 <= column <= 17 else 3e-6
                got = float(seen["moves"][0, row, column])
                assert abs(got - wanted[field]) <= slack, (sequence, j, field, got, wanted[field])
        assert board.legal[0] == sum(slow.legal(j) for j in slow.bodies)
    assert compared > 1000
    assert skipped < compared / 50


@pytest.mark.parametrize("name", FIELDS)
def test_every_number_of_lookahead_is_what_its_name_says(name: str) -> None:
    """The chains of ``lookahead`` agree with plain Python, the rest with ``transfer``."""
    instance = FIELDS[name]
    targets = len(instance.targets)
    compared = 0
    for mission, pool, episodes, sequence in random_states(instance, 2, 9):
        board, plain = Board("lookahead", 1, targets), Board("transfer", 1, targets)
        for each in (board, plain):
            each.observe(pool.arrays, episodes, 0, 1)
        slow = Slow(mission, sequence)
        seen, without = board.arrays, plain.arrays
        assert isinstance(seen, dict)
        assert isinstance(without, dict)
        np.testing.assert_array_equal(seen["mission"], without["mission"])
        np.testing.assert_array_equal(seen["moves"][..., : len(MOVE_FIELDS)], without["moves"])
        ends = {j: slow.move(slow.body, slow.now, j) for j in slow.bodies if slow.legal(j)}
        ranked = sorted(
            (j for j in ends if j), key=lambda j: ends[j][1] / HOUR + ends[j][0] / 450.0
        )
        moves = ranked[:FOLLOWED] + [0] * (0 in ends)
        wanted = np.zeros((targets + 1, len(CHAIN_FIELDS)))
        compares = slice(len(CHAIN_FIELDS) - 4, len(CHAIN_FIELDS) - 2)
        wanted[[kernels.action_of(j, targets) for j in ends], compares] = -LIMIT
        most, slack, followed = {}, {}, {}
        for j in moves:
            followed[j] = [slow.chain(j, *chain) for chain in CHAINS]
            most[j] = max(count for count, _, _ in followed[j])
            slack[j] = max(
                (count + (slow.duration - end) * SLACK_PER_S, -number, left)
                for number, (count, end, left) in enumerate(followed[j])
            )
        for j in moves:
            counts = [count for count, _, _ in followed[j]]
            left_s = [slow.duration - end for _, end, _ in followed[j]]
            wanted[kernels.action_of(j, targets)] = [
                *np.ravel(np.column_stack([np.divide(counts, 10.0), np.divide(left_s, 36e3)])),
                1.0,
                most[j] / 10.0,
                most[j] - max(most.values()),
                slack[j][0] - max(slack.values())[0],
                slack[j][2] / 1e3,
                np.mean(np.array(counts) >= max(most.values())),
            ]
        got = seen["moves"][0, :, len(MOVE_FIELDS) :]
        np.testing.assert_allclose(got, wanted.clip(-LIMIT, LIMIT), rtol=0.0, atol=3e-6)
        compared += len(moves)
    assert compared > 10


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


@pytest.mark.parametrize("name", ["transfer", "lookahead", "published"])
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
    """There is one name for every number, and none twice among the moves and the mission."""
    assert len(MOVE_FIELDS) == 29
    assert len(MISSION_FIELDS) == 16
    assert len(set(MOVE_FIELDS)) == len(MOVE_FIELDS)
    assert len(set(MISSION_FIELDS)) == len(MISSION_FIELDS)
    assert move_fields("lookahead") == MOVE_FIELDS + CHAIN_FIELDS
    assert move_fields("transfer") == MOVE_FIELDS
