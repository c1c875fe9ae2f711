"""Mission rules: legal moves and steps agree with each other and with the model."""

from __future__ import annotations

import numpy as np
import pytest
from hand_made import BEYOND, FAR, NORTH, OPTIMAL_PLAN, OPTIMUM, PERIOD_S, SOUTH, STATION, hand_made

import adr_opt
from adr_opt.kernels import rules as kernels


@pytest.fixture(scope="module")
def mission() -> adr_opt.Mission:
    return adr_opt.Mission(hand_made())


def legal(mission, body, time, left, since_refuel, visited=()) -> set[int]:
    rules = mission.rules
    done = np.zeros(len(mission.names), dtype=bool)
    done[list(visited)] = True
    mask = np.empty_like(done)
    count = kernels.legal_moves(rules, body, time, left, since_refuel, done, mask)
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


def test_steps_agree_with_legal_moves():
    """Random walks over legal moves replay exactly; one illegal move is never accepted."""
    rng = np.random.default_rng(0)
    for seed in range(5):
        mission = adr_opt.Mission(adr_opt.generate("tiny", seed, zones=2))
        rules = mission.rules
        size = len(mission.names)
        for _ in range(40):
            sequence, visited, since = [], set(), 0
            body, time, left = STATION, 0.0, rules.budget
            while True:
                moves = legal(mission, body, time, left, since, visited)
                for j in set(range(size)) - moves:
                    assert mission.time([*sequence, j]).made == len(sequence)
                if not moves:
                    break
                j = int(rng.choice(sorted(moves)))
                sequence.append(j)
                timing = mission.time(sequence)
                assert timing.made == len(sequence)
                body, time, left = j, float(timing.ends[-1]), float(timing.lefts[-1])
                since = 0 if j == STATION else since + 1
                visited |= {j} - {STATION}
            assert time <= rules.duration
