"""Mission rules: legal moves and steps agree with each other and with the model."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hand_made import BEYOND, FAR, NORTH, OPTIMAL_PLAN, OPTIMUM, PERIOD_S, SOUTH, STATION, hand_made
from random_rules import random_mission

import adr_opt
from adr_opt.kernels.rules import rules as kernels
from adr_opt.kernels.rules.resources import Resources
from adr_opt.legs.corrections import Corrections
from adr_opt.problem.chasers import AtStation, InOrbit


@pytest.fixture(scope="module")
def mission() -> adr_opt.Mission:
    return adr_opt.Mission(hand_made())


def legal(mission, body, time, left, since_refuel, visited=()) -> set[int]:
    """All legal moves of a chaser that has done some targets."""
    rules = mission.rules
    done = np.zeros(len(mission.names), dtype=bool)
    done[list(visited)] = True
    mask = np.empty_like(done)
    state = kernels.State(body, Resources(time, left, since_refuel, len(visited), 0))
    count = kernels.legal_moves(rules, state, done, mask)
    assert count == mask.sum()
    return set(np.flatnonzero(mask))


def test_start(mission):
    """Docked at the start one may go to every affordable target, but not refuel."""
    assert legal(mission, STATION, 0.0, 300.0, 0) == {NORTH, BEYOND, SOUTH}


def test_visited_targets_are_out(mission):
    """A visited target is no move any more."""
    assert legal(mission, STATION, 0.0, 300.0, 0, [NORTH]) == {BEYOND, SOUTH}


def test_refuelling_must_be_earned_and_affordable(mission):
    """The station is a move after a visit, if the ΔV reaches it."""
    assert legal(mission, NORTH, 2e4, 160.0, 1, [NORTH]) == {STATION, BEYOND}
    assert legal(mission, NORTH, 2e4, 160.0, 0, [NORTH]) == {BEYOND}
    assert legal(mission, BEYOND, 2e4, 160.0, 1, [BEYOND]) == {NORTH}


def test_service_must_end_in_time(mission):
    """A move is legal only if its service ends within the mission."""
    end = mission.rules.duration
    assert legal(mission, STATION, end - 3.6 * PERIOD_S, 1e5, 0) == {NORTH, BEYOND, SOUTH, FAR}
    assert legal(mission, STATION, end - 2.9 * PERIOD_S, 1e5, 0) == set()


def test_worked_out_plan(mission):
    """The optimum worked out on paper is legal, has its value, ends and ΔV as worked out."""
    timing = mission.time(OPTIMAL_PLAN)
    assert timing.made == 4
    assert timing.objective == OPTIMUM
    assert timing.ends / PERIOD_S == pytest.approx([3.0, 6.5, 10.0, 13.5], abs=1e-3)
    assert timing.lefts == pytest.approx([168.4, 300.0, 168.4, 36.8], abs=0.2)


def test_bodies_may_be_given_by_name(mission):
    """A sequence of names is timed as that of numbers is, also mixed with them."""
    names = [mission.names[j] for j in OPTIMAL_PLAN]
    by_number = mission.time(OPTIMAL_PLAN)
    for sequence in (names, [names[0], *OPTIMAL_PLAN[1:]]):
        timing = mission.time(sequence)
        assert timing.made == 4
        assert timing.ends.tolist() == by_number.ends.tolist()
    result = adr_opt.solve(mission, "local-search", start=names, time_limit=30.0, iterations=1)
    assert result.objective == OPTIMUM
    assert mission.time([]).made == 0


@pytest.mark.parametrize(
    ("sequence", "named"),
    [
        (["nowhere"], "'nowhere' is not a body of 'hand-made'"),
        ([1, "nowhere"], "'nowhere'"),
        ([5], "bodies 0 to 4"),
        ([-1], "bodies 0 to 4"),
        ([1.5], "by their numbers or their names"),
        ([None], "by their numbers or their names"),
    ],
)
def test_what_is_no_body_is_refused_in_one_sentence(mission, sequence, named):
    """Unknown names, numbers out of range and what is neither raise InputError."""
    with pytest.raises(adr_opt.InputError, match=named):
        mission.time(sequence)


def test_replay_stops_at_the_first_illegal_move(mission):
    """Timing a sequence with an illegal move reports the legal beginning only."""
    for sequence, made in (
        ((NORTH, NORTH), 1),
        ((STATION,), 0),
        ((SOUTH, STATION, STATION), 2),
        ((NORTH, BEYOND, STATION), 2),
        ((FAR,), 0),
    ):
        assert mission.time(sequence).made == made, sequence


def replayed(mission, sequence):
    """How many moves of a sequence can be made, their ΔV, and the state then."""
    rules = mission.rules
    visited = np.zeros(len(mission.names), dtype=bool)
    moves = np.array(sequence, dtype=np.int64)
    ends, lefts = np.empty((2, moves.size))
    return kernels.replay(rules, moves, kernels.beginning(rules), visited, ends, lefts)


def random_walks(walks=8):
    """Random walks over legal moves of missions with all kinds of rules: mission, sequence, state.

    Legal moves are looked up anew before each move.
    """
    rng = np.random.default_rng(0)
    instances = [random_mission(seed) for seed in range(40)]
    instances += [adr_opt.generate("tiny", seed, zones=2) for seed in range(5)]
    instances.append(hand_made(periods=60.0, delta_v_m_s=900.0))
    for instance in instances:
        mission = adr_opt.Mission(instance)
        rules = mission.rules
        for _ in range(walks):
            sequence, state = [], kernels.beginning(rules)
            while True:
                done = {j for j in sequence if not rules.is_station[j]}
                has = state.resources
                moves = legal(mission, state.body, has.time, has.left, has.since, done)
                yield mission, sequence, state, moves
                if not moves:
                    break
                sequence = [*sequence, int(rng.choice(sorted(moves)))]
                made, _, state = replayed(mission, sequence)
                assert made == len(sequence)


def test_steps_agree_with_legal_moves():
    """Random walks over legal moves replay exactly; one illegal move is never accepted."""
    longest = 0
    for mission, sequence, state, moves in random_walks():
        for j in set(range(len(mission.names))) - moves:
            assert replayed(mission, [*sequence, j])[0] == len(sequence)
        targets = [j for j in sequence if not mission.rules.is_station[j]]
        assert len(set(targets)) == len(targets) == state.resources.serviced
        assert state.resources.time <= mission.rules.duration
        longest = max(longest, len(sequence))
    assert longest > 4


def test_what_steps_can_do_a_schedule_can_do_as_cheaply():
    """The best schedule of an order makes at least the moves that the layer's connections make.

    And if it makes them all it costs no more, since those connections are some of all.
    """
    compared = cheaper = 0
    for mission, sequence, state, moves in random_walks(3):
        if moves or not sequence:
            continue
        schedule = mission.time(sequence)
        _, delta_v, _ = replayed(mission, sequence)
        cost = delta_v + mission.instance.time_m_s_per_s * (
            state.resources.time - mission.rules.ready
        )
        if mission.instance.objective.cost == "duration":
            cost = state.resources.time
        assert schedule.made == len(sequence)
        assert schedule.cost <= cost + 1e-6
        compared += 1
        cheaper += schedule.cost < cost - 1e-3
    assert compared > 50
    assert cheaper > 20


def test_guard_asks_every_station():
    """The way back is open if it leads to any station, and shut if the only near one is useless."""
    instance = hand_made()
    (station,) = instance.stations
    near = station.replace(name="near beyond", orbit=instance.targets[1].orbit)
    remote = station.replace(name="remote", orbit=instance.targets[3].orbit)
    for others, expected in (((), False), ((near,), True), ((remote,), False)):
        mission = adr_opt.Mission(instance.replace(stations=(station, *others)))
        body = mission.names.index("beyond")
        state = kernels.State(body, Resources(2e4, 40.0, 1, 1, 0))
        assert kernels.has_way_back(mission.rules, state) == expected
    adrift = instance.chaser.replace(start=InOrbit(orbit=station.orbit))
    mission = adr_opt.Mission(instance.replace(stations=(), chasers=(adrift,)))
    state = kernels.State(BEYOND, Resources(2e4, 40.0, 1, 1, 0))
    assert kernels.has_way_back(mission.rules, state)


def test_guard_knows_a_dead_end(mission):
    """Where no transfer leads back at all, a way back is asked for while it would be of use."""
    barred = mission.corrected(Corrections({("beyond", "station", "short"): math.inf}, {}))
    last = mission.rules.duration - mission.rules.shortest_sortie
    for time, expected in ((2e4, False), (last, True)):
        state = kernels.State(BEYOND, Resources(time, 1e5, 1, 1, 0))
        assert kernels.has_way_back(mission.rules, state)
        assert kernels.has_way_back(barred.rules, state) == expected


def test_guard_lets_go_at_the_end(mission):
    """When no service fits after a refuelling any more, no way back is asked for."""
    last = mission.rules.duration - mission.rules.shortest_sortie
    for time, expected in ((last - 5.0 * PERIOD_S, False), (last - 2.0 * PERIOD_S, True)):
        state = kernels.State(BEYOND, Resources(time, 40.0, 1, 1, 0))
        assert kernels.has_way_back(mission.rules, state) == expected


def test_no_move_leads_away_from_the_end_for_good():
    """Where the mission has to end at a station, a move after which none is reached is illegal."""
    instance = hand_made()
    ends = instance.chaser.replace(end=AtStation(station="station"))
    mission = adr_opt.Mission(instance.replace(chasers=(ends,)))
    # Of 300 m/s some 263 go to beyond, and as much would be the way back.
    assert legal(mission, STATION, 0.0, 300.0, 0) == {NORTH, SOUTH}
    # In the last eight periods two moves have time, and three do not.
    late = mission.rules.duration - 8.0 * PERIOD_S
    assert legal(mission, STATION, late, 1e5, 0) == {NORTH, BEYOND, SOUTH, FAR}
    assert legal(mission, NORTH, late + 3.0 * PERIOD_S, 1e5, 1, [NORTH]) == {STATION}
