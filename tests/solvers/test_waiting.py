"""Labels that wait and legs that are stale: what dominates what, against plain comparisons."""

from __future__ import annotations

import numpy as np
import pytest

import adr_opt
from adr_opt.kernels.rules.loads import Loads
from adr_opt.kernels.rules.resources import COUNT_BITS, CountLimits, kits_alone
from adr_opt.mission.mission import Mission
from solvers.labels.pending import is_preceded, more_room, next_of, pending_room, send, take
from solvers.labels.row_cuts import CutTolls
from solvers.labels.waiting import (
    Labels,
    LabelTerms,
    Waiting,
    arrive,
    candidate_of,
    is_dominated,
    keep,
    larger,
    room,
)
from solvers.networks.arrays import Network
from solvers.networks.network import LOOK_BACK, build

LABELS = 900

LIMITED = CountLimits(*(9 for _ in CountLimits._fields))
"""Counts that all matter."""


def random_labels(rng: np.random.Generator, words: int) -> Labels:
    """Labels of few different values and amounts, and of memories that are often nested."""
    memory = rng.integers(0, 2**62, (LABELS, words))
    for _ in range(4):
        memory &= rng.integers(0, 2**62, (LABELS, words))
    none, value = np.zeros(LABELS, dtype=np.int32), rng.integers(-2, 3, LABELS) << 16
    return Labels(
        none,
        none,
        value,
        value,
        rng.integers(0, 300, LABELS) * 10.0,
        rng.integers(0, 2, LABELS),
        none.astype(np.int16),
        rng.integers(0, 2, LABELS) * 1.0,
        memory,
    )


def with_kits(labels: Labels, rng: np.random.Generator) -> Labels:
    """The same with none or one kit aboard each."""
    return labels._replace(counts=labels.counts + kits_alone(rng.integers(0, 2, LABELS)))


def carrying(what: str) -> Loads | None:
    """Loads that tell labels apart by their kits, or by having fewer of them, or not at all."""
    if what == "nothing":
        return None
    nothing = np.zeros((2, 2))
    kits, full, flown = np.ones(2, np.int64), np.zeros(2), np.zeros(2)
    return Loads(3000.0, kits, full, full, nothing, nothing, what == "weights", flown)


def random_tolls(rng: np.random.Generator, words: int) -> CutTolls:
    """Tolls of cuts, some of them nothing, whose bits are a part of those of memories."""
    bits = rng.integers(0, 2**62, words)
    toll = rng.integers(0, 3, 63 * words) << 15
    return CutTolls(np.zeros((2, words), np.int64), bits, toll)


def owed_more(labels: Labels, one: int, other: int, cuts: CutTolls) -> int:
    """Sum of the tolls of the bits that one label has and another has not."""
    beyond = labels.memory[one] & ~labels.memory[other] & cuts.bits
    return sum(
        int(cuts.toll[at]) for at in range(63 * beyond.size) if beyond[at // 63] >> at % 63 & 1
    )


def dominates(
    labels: Labels,
    one: int,
    other: int,
    compared: np.ndarray,
    what: str = "nothing",
    cuts: CutTolls | None = None,
) -> bool:
    """Whether one label dominates another, written once more."""
    services, kits = labels.counts & ((1 << COUNT_BITS) - 1), labels.counts >> 2 * COUNT_BITS
    more = int(kits[one]) - int(kits[other])
    return bool(
        (what == "nothing" or more == 0 or (what == "counts" and more > 0))
        and labels.value[one] - (0 if cuts is None else owed_more(labels, one, other, cuts))
        >= labels.value[other]
        and labels.left[one] >= labels.left[other]
        and services[one] <= services[other]
        and labels.worth[one] >= labels.worth[other]
        and not np.any(labels.memory[one] & ~labels.memory[other] & compared)
    )


def waits(waiting: Waiting, body: int) -> set[int]:
    """The labels in a list."""
    return {int(label) for label in waiting.label[body, : waiting.size[body]] if label >= 0}


@pytest.mark.parametrize("what", ["nothing", "counts", "weights"])
@pytest.mark.parametrize("whole", [True, False])
@pytest.mark.parametrize("words", [1, pytest.param(2, marks=pytest.mark.slow)])
@pytest.mark.parametrize("tolled", [False, True])
def test_exactly_those_wait_that_none_dominates(tolled, words, whole, what):
    """A list holds the labels that no other one dominates by the memory compared, as it grows."""
    rng = np.random.default_rng(words)
    labels = random_labels(rng, words)
    loads = carrying(what)
    if loads is not None:
        labels = with_kits(labels, rng)
    compared = np.full(words, -1) if whole else rng.integers(0, 2**62, words)
    cuts = random_tolls(rng, words) if tolled else None
    if cuts is not None:
        compared &= ~cuts.bits
    terms, waiting = LabelTerms(loads, LIMITED, cuts), room(2, words, 16)
    alive: set[int] = set()
    refused = 0
    for label in range(LABELS):
        candidate, memory = candidate_of(labels, label), labels.memory[label]
        dominated = any(dominates(labels, other, label, compared, what, cuts) for other in alive)
        assert dominated == is_dominated(waiting, labels, 1, candidate, memory, compared, terms)
        if not arrive(waiting, labels, 1, label, compared, terms):
            waiting = larger(waiting, words)
            assert arrive(waiting, labels, 1, label, compared, terms)
        refused += dominated
        if not dominated:
            beaten = {n for n in alive if dominates(labels, label, n, compared, what, cuts)}
            alive = alive - beaten | {label}
        assert waits(waiting, 1) == alive
        if label % 37 == 0:
            keep(waiting, 1, waiting.label[1] >= 0, 2 * words)
            assert waits(waiting, 1) == alive
            assert waiting.size[1] == len(alive)
    assert 0 < refused < LABELS
    assert waits(waiting, 0) == set()


@pytest.mark.parametrize("words", [1, 2])
@pytest.mark.parametrize("tolled", [False, True])
def test_all_that_are_sent_arrive_and_precede_others_until_then(tolled, words):
    """Labels on their way to a row are compared with what goes there, and each arrives once."""
    rng = np.random.default_rng(words)
    labels = random_labels(rng, words)
    cuts = random_tolls(rng, words) if tolled else None
    rows, compared = 5, np.full(words, -1) if cuts is None else ~cuts.bits
    pending, grown = pending_room(rows, words, 1), 0
    under_way: list[set[int]] = [set() for _ in range(rows)]
    for label in range(LABELS):
        row = int(rng.integers(rows))
        preceded = any(
            dominates(labels, other, label, compared, cuts=cuts) for other in under_way[row]
        )
        assert preceded == is_preceded(
            pending,
            row,
            labels,
            candidate_of(labels, label),
            labels.memory[label],
            compared,
            LabelTerms(None, LIMITED, cuts),
        )
        while not send(pending, row, labels, label):
            pending, grown = more_room(pending, words), grown + 1
        under_way[row].add(label)
        if label % 97 == 0:
            empty = int(rng.integers(rows))
            for _ in range(len(under_way[empty])):
                under_way[empty].remove(next_of(pending, empty))
                take(pending, empty, words)
            assert next_of(pending, empty) == -1
    assert grown > 2
    for row in range(rows):
        assert (next_of(pending, row) == -1) == (not under_way[row])


def networks() -> list[Network]:
    """Of a field without and one with drift, both small."""
    field = adr_opt.generate("tiny", 0)
    transfer = {"drift_step_s": 43200.0, "max_drift_s": 604800.0, "departure_spacing_s": 20000.0}
    drifting = field.replace(dynamics="j2", transfer=field.transfer.model_copy(update=transfer))
    return [build(Mission(instance), jobs=1) for instance in (field, drifting)]


def test_a_leg_is_stale_exactly_since_an_earlier_one_is_as_good() -> None:
    """Of the rows just before, the last one with a leg no later and no dearer is named."""
    for network in networks():
        stale = 0
        for body in range(network.start.size - 1):
            earlier: dict[int, list[int]] = {}
            for row in range(network.start[body], network.start[body + 1] - 1):
                others = earlier.setdefault(int(network.destination[row]), [])
                since = []
                for leg in range(network.first[row], network.first[row + 1]):
                    as_good = [
                        other
                        for other in others[-LOOK_BACK:]
                        if np.any(
                            (
                                network.landing[network.first[other] : network.first[other + 1]]
                                <= network.landing[leg]
                            )
                            & (
                                network.delta_v[network.first[other] : network.first[other + 1]]
                                <= network.delta_v[leg]
                            )
                        )
                    ]
                    since.append(max(as_good, default=-1))
                    assert network.since[leg] == since[-1]
                assert network.fresh[row] == min(since)
                stale += sum(other >= 0 for other in since)
                others.append(row)
        assert stale > 0
