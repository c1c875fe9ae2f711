"""Local search: every move keeps a permutation, every timing is exact, nothing gets worse."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from brute_force import brute_force
from calling import call
from hand_made import OPTIMAL_PLAN, OPTIMUM, hand_made
from on_a_layer import replayed

import adr_opt
from adr_opt.common.constants import STATION
from adr_opt.common.progress import silent
from adr_opt.common.stop import Interrupted, MaxIterations
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result
from adr_opt.run.methods import get
from solvers.orders.cooling import AnnealingSchedule
from solvers.orders.timed_order import make_labels, time_order, with_refuelling
from solvers.planners.local_search import WEIGHTS, LocalSearch, local_search
from solvers.planners.local_search.annealing import NAMES, anneal, apply_move

TARGETS = 12


@pytest.fixture(scope="module")
def field() -> Mission:
    """50 targets and a small tank: every plan has to refuel."""
    return Mission(adr_opt.generate("reduced-fuel", 0), threads=1)


@pytest.fixture(scope="module")
def guarded(field: Mission) -> tuple[int, ...]:
    """The guarded greedy plan of the field."""
    stop = MaxIterations(1)
    sequence = get("greedy-guarded")(field, seed=0, stop=stop, progress=silent).sequence
    assert sequence
    return sequence


def improve(mission: Mission, iterations: int = 2, seed: int = 0, **options: Any) -> Result:
    """Search with a reproducible limit."""
    stop = MaxIterations(iterations)
    return call(local_search, mission, seed=seed, stop=stop, **options)


def order_of(mission: Mission, sequence: tuple[int, ...]) -> tuple[npt.NDArray[np.int64], int]:
    """All targets, those of a sequence first, and how many these are."""
    visited = [j for j in sequence if j != STATION]
    others = sorted(set(range(1, len(mission.names))) - set(visited))
    return np.array(visited + others, dtype=np.int64), len(visited)


def test_every_move_has_a_weight() -> None:
    """The moves and their probabilities have the same names, and the latter sum to one."""
    assert set(WEIGHTS) == set(NAMES)
    assert sum(WEIGHTS.values()) == pytest.approx(1.0)


@pytest.mark.parametrize("kind", range(len(NAMES)), ids=NAMES)
def test_move_keeps_a_permutation_and_says_what_changed(kind: int) -> None:
    """A move leaves a permutation; before ``first``, and from ``behind`` on, nothing differs."""
    rng = np.random.default_rng(kind)
    changed = 0
    for _ in range(3000):
        length = int(rng.integers(0, TARGETS + 1))
        before = rng.permutation(np.arange(1, TARGETS + 1))
        after = before.copy()
        first, behind, new_length = apply_move(kind, after, length, rng)
        assert sorted(after) == list(range(1, TARGETS + 1))
        if behind == 0:
            assert (after == before).all()
            continue
        changed += after[:new_length].tolist() != before[:length].tolist()
        assert 0 <= first <= new_length
        assert behind <= new_length
        assert new_length - length == {"insert": 1, "remove": -1}.get(NAMES[kind], 0)
        assert (after[:first] == before[:first]).all()
        if new_length == length:
            assert (after[behind:length] == before[behind:length]).all()
    assert changed > 1000


@pytest.mark.parametrize(
    ("name", "leaves"),
    [
        ("swap", "same"),
        ("relocate", "same"),
        ("reverse", "same"),
        ("replace", "one other"),
        ("substitute", "one other"),
        ("insert", "one more"),
        ("remove", "one less"),
    ],
)
def test_move_does_what_its_name_says(name: str, leaves: str) -> None:
    """Some moves leave the set of visited targets as it is, others change one of them."""
    rng = np.random.default_rng(0)
    kind = NAMES.index(name)
    for _ in range(500):
        length = int(rng.integers(2, TARGETS))
        order = rng.permutation(np.arange(1, TARGETS + 1))
        before = set(order[:length])
        _, behind, new_length = apply_move(kind, order, length, rng)
        assert behind > 0 or name == "remove"
        after = set(order[:new_length])
        gone, come = len(before - after), len(after - before)
        expected = {"same": (0, 0), "one other": (1, 1), "one more": (0, 1), "one less": (1, 0)}
        assert (gone, come) == expected[leaves]


@pytest.mark.parametrize("kind", range(len(NAMES)), ids=NAMES)
def test_annealing_with_one_move_keeps_plans_legal(
    field: Mission, guarded: tuple[int, ...], kind: int
) -> None:
    """With any single move, annealing ends with a legal plan that is at least as good."""
    start = guarded[:-3]  # so that there is room for one more
    order, length = order_of(field, start)
    targets = order.size
    weights = (np.arange(len(NAMES)) >= kind).astype(float)
    schedule = AnnealingSchedule(20.0 / field.rules.duration, 0.3, 0.01, 4000)
    best, prize, last, accepted = anneal(
        field.rules,
        order,
        length,
        make_labels(field),
        make_labels(field),
        weights,
        schedule,
        np.random.default_rng(kind),
    )
    timing = field.time(best)
    assert timing.made == len(best)
    assert timing.objective == prize >= field.time(start).objective
    assert sorted(order) == list(range(1, targets + 1))
    labels = make_labels(field)
    end = time_order(field.rules, order, last, 0, labels, targets, np.empty(targets + 1), math.inf)
    assert end <= field.rules.duration
    assert accepted > 0


def ends_by_brute_force(mission: Mission, order: list[int]) -> list[float]:
    """End of the last service for every legal choice of refuelling stops between targets."""
    ends = []
    for stops in itertools.product((False, True), repeat=len(order) - 1):
        sequence = [order[0]]
        for target, by_station in zip(order[1:], stops, strict=True):
            sequence += [STATION, target] if by_station else [target]
        made, end = replayed(mission, sequence)
        if made == len(sequence):
            ends.append(end)
    return ends


def test_labels_find_the_best_refuelling_stops(field: Mission) -> None:
    """The end of an order is that of the best of all its refuelling choices, but for rare cases.

    A layer knows one connection at a time, so a chaser that is later and poorer can meet a cheaper
    one; labels do not look for that. They never claim an end that no choice has.
    """
    rng = np.random.default_rng(1)
    targets = len(field.names) - 1
    labels = make_labels(field)
    legal = missed = refuellings = 0
    for _ in range(300):
        order = rng.permutation(np.arange(1, targets + 1))
        length = int(rng.integers(1, 7))
        end = time_order(
            field.rules, order, length, 0, labels, targets, np.empty(targets + 1), math.inf
        )
        best = min(ends_by_brute_force(field, order[:length].tolist()), default=math.inf)
        assert end >= best
        legal += best < math.inf
        missed += end != best
        if end < math.inf:
            sequence = with_refuelling(order, length, labels)
            assert [j for j in sequence if j != STATION] == order[:length].tolist()
            assert replayed(field, sequence.tolist()) == (len(sequence), end)
            assert field.time(sequence).made == len(sequence)
            refuellings += int((sequence == STATION).sum())
    assert legal > 100
    assert refuellings > 50
    assert missed <= 0.03 * legal


def test_timing_from_the_middle_equals_timing_from_the_start(field: Mission) -> None:
    """Labels before a change may be kept: the rest comes out as if all were timed anew."""
    rng = np.random.default_rng(2)
    targets = len(field.names) - 1
    kept, fresh = (make_labels(field) for _ in range(2))
    unused = np.empty(targets + 1)
    compared = 0
    for _ in range(300):
        order = rng.permutation(np.arange(1, targets + 1))
        if time_order(field.rules, order, 4, 0, kept, targets, unused, math.inf) == math.inf:
            continue
        order[2:] = rng.permutation(order[2:])
        partly = time_order(field.rules, order, 4, 2, kept, targets, unused, math.inf)
        assert partly == time_order(field.rules, order, 4, 0, fresh, targets, unused, math.inf)
        compared += partly < math.inf
    assert compared > 20


@pytest.mark.parametrize("seed", range(3))
def test_start_plan_is_never_worsened(field: Mission, guarded: tuple[int, ...], seed: int) -> None:
    """From any start plan, good, short or empty, the result is legal and at least as good."""
    for start in (guarded, guarded[:7], ()):
        result = improve(field, 1, seed, start=start, chunk=500, width=10)
        assert result.plan is not None
        assert adr_opt.check(field.instance, result.plan) == ()
        assert result.objective >= field.time(start).objective


def test_interrupted_at_once_the_start_plan_is_returned(
    field: Mission, guarded: tuple[int, ...]
) -> None:
    """Told to stop at once, it returns the start plan as it is."""
    stop = Interrupted()
    stop.interrupt()
    result = local_search(field, seed=0, stop=stop, progress=silent, start=guarded)
    assert result.sequence == guarded


def test_it_improves_greedy(field: Mission, guarded: tuple[int, ...]) -> None:
    """A few iterations collect more than the guarded greedy plan that it begins with."""
    assert improve(field, 3).objective > field.time(guarded).objective


def test_same_seed_same_plan(field: Mission) -> None:
    """The same seed gives the same plan, and different seeds do not all."""
    plans = [improve(field, 1, seed).sequence for seed in (0, 0, 1, 2)]
    assert plans[0] == plans[1]
    assert len(set(plans)) > 1


def test_it_finds_the_worked_out_optimum() -> None:
    """On the hand-made instance it finds the optimal plan from the poor greedy one."""
    result = improve(Mission(hand_made(), threads=1))
    assert result.objective == OPTIMUM
    assert result.sequence == OPTIMAL_PLAN


@pytest.mark.parametrize("seed", range(8))
def test_it_finds_the_optimum_of_tiny_instances(seed: int) -> None:
    """On tiny instances it finds what brute force finds."""
    mission = Mission(adr_opt.generate("tiny", seed), threads=1)
    assert improve(mission).objective == brute_force(mission)[0]


def test_annealing_alone_recovers_a_target_left_out(
    field: Mission, guarded: tuple[int, ...]
) -> None:
    """Without the last target of a plan, some rounds of annealing find as good a plan again."""
    search = LocalSearch(field, guarded[:-1], 0)
    short = search.best.objective
    assert any(search.anneal(20_000, 0.3, 0.01) for _ in range(10))
    assert search.best.objective > short
    assert search.best.sequence is not None
    assert field.time(search.best.sequence).objective == search.best.objective
