"""Lists of closed labels: no list proves what is false, and a forged one proves nothing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np
import numpy.typing as npt
import pytest
from random_rules import falling_mission
from seeds import over_seeds
from varied_fields import variant
from verify_fields import FEW, laden, legs_for, proven, refuelling, towing_and_laden, worths_of

from adr_opt.common.errors import InputError
from adr_opt.judge.verify import verify
from adr_opt.judge.verify.closed import ClosedLabels, dominates, ends_of, is_answer, why_open
from adr_opt.judge.verify.legs import losses_of
from adr_opt.judge.verify.lists import ListedLabels, Lists
from adr_opt.judge.verify.walk_questions import WalkQuestion, walk_question, walks_reach
from adr_opt.plan.certificate import ProvenCut
from adr_opt.problem.instance import Instance
from solvers.labels import expand

Rng = np.random.Generator
KINDS = (variant, laden, towing_and_laden, refuelling, falling_mission)


@dataclass
class Claim:
    """A claim on the walks of a mission, drawn, with and without which it can be proven."""

    instance: Instance
    gains: list[Fraction]
    remembered: npt.NDArray[np.bool_]
    cuts: tuple[ProvenCut, ...]

    @classmethod
    def drawn(cls, seed: int) -> Claim:
        """Multipliers, memories and cuts of any size."""
        instance, rng = KINDS[seed % len(KINDS)](seed), np.random.default_rng([72, seed])
        worths, first = worths_of(instance, Fraction(0)), instance.first_target
        bodies, share = len(worths), rng.choice([0.3, 0.9, 1.0])
        paid = (
            rng.uniform(0.0, 1.0, bodies)
            * rng.integers(0, 2, bodies)
            * (np.arange(bodies) >= first)
        )
        gains = [worth - Fraction(float(each)) for worth, each in zip(worths, paid, strict=True)]
        remembered = rng.random((bodies, bodies)) < share
        cuts: list[ProvenCut] = []
        for _ in range(int(rng.integers(0, 3)) if bodies - first > 2 else 0):
            rows = rng.choice(np.arange(first, bodies), 3, replace=False).tolist()
            names, toll = instance.names, float(rng.uniform(0.2, 1.0))
            drawn = tuple(names[body] for body in rows)
            cuts.append(ProvenCut(targets=drawn, memory=names, multiplier=toll))
        return cls(instance, gains, remembered, tuple(cuts))

    def ask(self, most: Fraction, **changed: object) -> WalkQuestion:
        """The question about that much."""
        what = {"gains": self.gains, "cuts": self.cuts, **changed}
        return walk_question(
            legs_for(self.instance),
            what["gains"],
            self.remembered,
            most,
            20.0,
            what["cuts"],
            losses=losses_of(self.instance),
        )

    def listed(self, question: WalkQuestion, **changed: object) -> ListedLabels:
        """What a list for another question has of labels that are no answers."""
        legs, about, starts = self.ask(self.least, **changed)
        labels = expand.expand(legs, about, starts).labels
        return ListedLabels(
            labels._replace(odd=labels.odd[: question.question.cuts.rows.shape[0]]), None
        )

    @cached_property
    def least(self) -> Fraction:
        """The least sixteenth that no walk collects, by bisection."""
        low, high = 0, int(16 * sum(max(gain, Fraction(0)) for gain in self.gains)) + 1
        while high - low > 1:
            middle = (low + high) // 2
            if walks_reach(self.ask(Fraction(middle, 16))).reached:
                low = middle
            else:
                high = middle
        return Fraction(high, 16)

    @cached_property
    def true(self) -> WalkQuestion:
        """The question about that much."""
        return self.ask(self.least)

    @cached_property
    def false(self) -> WalkQuestion:
        """The one about the sixteenth before, which a walk collects."""
        return self.ask(self.least - Fraction(1, 16))


def true_list(question: WalkQuestion) -> ListedLabels:
    """A list, and who dominates what, as a file has them."""
    lists = Lists()
    assert not walks_reach(question, lists).reached
    return lists.checked[0]


def refused(question: WalkQuestion, listed: ListedLabels) -> bool:
    """Whether a list shows nothing, with its rows and without."""
    legs, about, starts = question
    search = expand.finder(legs, about, listed.labels)
    return why_open(legs, about, listed.labels, starts, listed.find(search)) is not None


@over_seeds(range(100), gate=5)
def test_no_list_proves_what_is_false(seed):
    """Where a walk is an answer, no list is accepted, whatever is left out of it or bent."""
    claim, rng = Claim.drawn(seed), np.random.default_rng([73, seed])
    false = claim.false
    legs, about, starts = false
    monkey = pytest.MonkeyPatch()
    monkey.setattr(expand, "is_answer", lambda *of: np.zeros(of[2].body.size, dtype=np.bool_))
    every = expand.expand(legs, about, starts).labels
    monkey.undo()
    good = every.at(~is_answer(legs, about, every))
    for share in (0.0, 0.02, 0.3):
        left = good.at(rng.random(good.body.size) >= share)
        bent = left._replace(
            time=left.time - rng.choice([0.0, 1e3], left.time.size),
            left=left.left + rng.choice([0.0, 50.0], left.left.size),
            memory=left.memory & rng.integers(0, 2**20, left.memory.shape),
            value=np.minimum(left.value + rng.integers(0, 2) * (about.need >> 3), about.need - 1),
        )
        for forged in (left, bent):
            if forged.body.size:
                assert refused(false, ListedLabels(forged, None))


Forgery = Callable[[Claim, ListedLabels, Rng], tuple[WalkQuestion, ListedLabels]]


def of_rows(claim: Claim, listed: ListedLabels) -> ClosedLabels:
    """What the rows of a list are said to dominate."""
    legs, about, starts = claim.true
    parts = [starts, *ends_of(legs, about, listed.labels)]
    return ClosedLabels(*(np.concatenate(each, axis=-1) for each in zip(*parts, strict=True)))


def needed(claim: Claim, labels: ClosedLabels, rng: Rng) -> int:
    """A label that no other one stands for."""
    legs, about, _ = claim.true
    for row in rng.permutation(labels.body.size):
        others = labels.at(np.delete(np.arange(labels.body.size), row))
        if expand.finder(legs, about, others)(labels.at([row]))[0] < 0:
            return int(row)
    raise AssertionError("no label is needed")


def dropped(claim: Claim, listed: ListedLabels, rng: Rng) -> tuple[WalkQuestion, ListedLabels]:
    """A label is left out."""
    kept = np.delete(np.arange(listed.labels.body.size), needed(claim, listed.labels, rng))
    return claim.true, ListedLabels(listed.labels.at(kept), None)


def shifted(claim: Claim, listed: ListedLabels, rng: Rng) -> tuple[WalkQuestion, ListedLabels]:
    """A label is said to be ready later."""
    time = listed.labels.time.copy()
    time[needed(claim, listed.labels, rng)] += float(rng.uniform(1e-6, 1e4))
    return claim.true, listed._replace(labels=listed.labels._replace(time=time))


def forgotten(claim: Claim, listed: ListedLabels, rng: Rng) -> tuple[WalkQuestion, ListedLabels]:
    """A target is taken from the memory of a label, which then has more legs."""
    legs = claim.true.legs
    most = of_rows(claim, listed).body.size
    for row in rng.permutation(listed.labels.body.size):
        for body in range(legs.terms.bodies):
            memory = listed.labels.memory.copy()
            memory[0, row] &= ~(1 << body)
            forged = listed._replace(labels=listed.labels._replace(memory=memory))
            if of_rows(claim, forged).body.size > most:
                return claim.true, forged
    return dropped(claim, listed, rng)


def misled(claim: Claim, listed: ListedLabels, rng: Rng) -> tuple[WalkQuestion, ListedLabels]:
    """A row is that of a label that does not dominate, or of none."""
    legs, about, _ = claim.true
    ends, size, rows = of_rows(claim, listed), listed.labels.body.size, listed.row.copy()
    at = int(rng.integers(ends.body.size))
    for row in [*rng.permutation(size)[:5].tolist(), int(rng.choice([-1, size]))]:
        one = listed.labels.at([row % size])
        if row in (-1, size) or not dominates(legs, about, one, ends.at([at])).all():
            rows[at] = row
    return claim.true, listed._replace(row=rows)


def other_unit(claim: Claim, listed: ListedLabels, rng: Rng) -> tuple[WalkQuestion, ListedLabels]:
    """The list is for prizes in another unit, by which they are less."""
    share = Fraction(1, int(rng.integers(2, 30)))
    return claim.false, claim.listed(claim.false, gains=[share * each for each in claim.gains])


def other_multiplier(
    claim: Claim, listed: ListedLabels, rng: Rng
) -> tuple[WalkQuestion, ListedLabels]:
    """The list is for multipliers by which targets give less than they do."""
    more = Fraction(float(rng.uniform(0.1, 3.0)))
    return claim.ask(claim.least, gains=[gain + more for gain in claim.gains]), listed


def other_cut(claim: Claim, listed: ListedLabels, rng: Rng) -> tuple[WalkQuestion, ListedLabels]:
    """The list is for cuts by which walks pay what they do not pay."""
    toll, names = float(rng.uniform(0.1, 2.0)), claim.instance.names
    bodies = np.arange(claim.instance.first_target, len(claim.gains))
    rows = tuple(names[body] for body in rng.choice(bodies, 3, replace=False))
    cut = ProvenCut(targets=rows, memory=names, multiplier=toll)
    return claim.false, claim.listed(claim.false, cuts=(*claim.cuts, cut))


def other_threshold(
    claim: Claim, listed: ListedLabels, rng: Rng
) -> tuple[WalkQuestion, ListedLabels]:
    """The list is for more than what is said that no walk collects."""
    return claim.ask(claim.least - Fraction(int(rng.integers(1, 17)), 16)), listed


FORGERIES: list[Forgery] = [
    dropped,
    shifted,
    forgotten,
    misled,
    other_unit,
    other_multiplier,
    other_cut,
    other_threshold,
]


@pytest.fixture(scope="module")
def claims() -> list[tuple[Claim, ListedLabels]]:
    """Claims that need some labels, and their lists."""
    found = []
    for claim in map(Claim.drawn, range(200)):
        if claim.least > Fraction(1, 16) and len(claim.gains) - claim.instance.first_target > 2:
            listed = true_list(claim.true)
            if 3 < listed.labels.body.size < 400:
                found.append((claim, listed))
        if len(found) == 5:
            return found
    raise AssertionError("too few claims")


@pytest.mark.parametrize("draws", [2, pytest.param(200, marks=pytest.mark.slow)])
@pytest.mark.parametrize("forge", FORGERIES, ids=lambda forge: forge.__name__)
def test_forged_lists_are_refused(claims, forge, draws):
    """A list that is changed, or is for another question, is refused; how many are, is printed."""
    accepted = []
    for number in range(draws):
        claim, listed = claims[number % len(claims)]
        rng = np.random.default_rng([FORGERIES.index(forge), number])
        accepted += [] if refused(*forge(claim, listed, rng)) else [number]
    print(f"{forge.__name__}: {draws - len(accepted)} of {draws} refused")
    assert accepted == []


def test_lists_that_are_not_forged_are_accepted(claims):
    """As they were made, in any order, and with or without the rows of those that dominate."""
    for claim, listed in claims:
        order = np.random.default_rng(1).permutation(listed.labels.body.size)
        assert not refused(claim.true, listed)
        assert not refused(claim.true, ListedLabels(listed.labels, None))
        assert not refused(claim.true, ListedLabels(listed.labels.at(order), None))


def test_a_file_of_labels_stands_in_for_a_search(tmp_path, monkeypatch):
    """What is written is read back and verified without a search; a broken file is one sentence."""
    instance = variant(1)
    _, certificate = proven(instance)
    path = tmp_path / "labels.npz"
    assert verify(instance, None, certificate, connections=FEW, save_labels=path).verified
    monkeypatch.setattr(expand, "expand", None)
    monkeypatch.setattr(expand, "_covering", None)
    assert verify(instance, None, certificate, connections=FEW, labels=path).verified
    monkeypatch.undo()
    other = certificate.replace(method="other")
    with pytest.raises(InputError, match="labels of another certificate"):
        verify(instance, None, other, connections=FEW, labels=path)
    path.write_bytes(path.read_bytes()[:-30])
    with pytest.raises(InputError, match="not a file of labels"):
        verify(instance, None, certificate, connections=FEW, labels=path)
    with pytest.raises(InputError, match="no such file"):
        verify(instance, None, certificate, connections=FEW, labels=tmp_path / "none.npz")


def test_a_label_that_is_worse_in_anything_dominates_none(claims):
    """Each dominates itself; if later, poorer, elsewhere, or remembering or counting more, not."""
    paying = 0
    for claim, listed in claims:
        legs, about, _ = claim.true
        labels, heavy = listed.labels, legs.terms.cargo.heavy
        assert dominates(legs, about, labels, labels).all()
        worse = [
            labels._replace(body=(labels.body + 1) % legs.terms.bodies),
            labels._replace(kits=labels.kits - 1),
            labels._replace(time=np.nextafter(labels.time, np.inf)),
            labels._replace(left=np.nextafter(labels.left, -np.inf)),
            labels._replace(value=labels.value - 1),
            labels._replace(worth=labels.worth - 1),
            labels._replace(memory=labels.memory | 1 << 40),
        ]
        worse += [labels._replace(kits=labels.kits + 1)] if heavy else []
        worse += [labels._replace(counts=labels.counts + 1)] if labels.counts.size else []
        for each in worse:
            assert not dominates(legs, about, each, labels).any()
        if about.cuts.toll.size and about.cuts.toll[0] > 0:
            owing = labels._replace(odd=labels.odd | 1)
            assert (dominates(legs, about, owing, labels) == (labels.odd[0] & 1 == 1)).all()
            ahead = owing._replace(value=labels.value + about.cuts.toll[0])
            assert dominates(legs, about, ahead, labels).all()
            paying += 1
    assert paying > 0


def test_numbers_that_are_none_are_refused(claims):
    """No label is infinite, at no place, of fewer words, or so poor that it would wrap round."""
    claim, listed = claims[0]
    legs, about, starts = claim.true
    labels = listed.labels
    for column, number in (
        ("value", -(2**63)),
        ("value", 2**62),
        ("worth", -(2**63)),
        ("body", -1),
        ("body", 10**6),
        ("kits", -1),
        ("kits", 10**6),
        ("time", np.nan),
        ("left", np.inf),
    ):
        numbers = getattr(labels, column).copy()
        numbers[-1] = number
        forged = labels._replace(**{column: numbers})
        why = why_open(legs, about, forged, starts, listed.find(lambda ends: ends.body))
        assert why == "a label has no body of the instance, or a value that is not a number", column
    none = labels._replace(memory=labels.memory[:0])
    why = why_open(legs, about, none, starts, listed.find(lambda ends: ends.body))
    assert why == "labels have another number of memory words or counts than walks"


def test_a_finder_can_neither_skip_nor_change_what_it_is_asked(claims):
    """Rows of another shape are refused, and writing into the question changes nothing."""
    claim, listed = claims[0]
    legs, about, starts = claim.true
    one = starts.at([0])

    def first(ends: ClosedLabels) -> np.ndarray:
        for own, column in zip(listed.labels.at([0]), ends, strict=True):
            column[...] = own
        return np.zeros(ends.body.size, np.int64)

    def none(ends: ClosedLabels) -> np.ndarray:
        return np.empty(0, np.int64)

    for find in (none, lambda ends: np.int64(0), lambda ends: np.zeros((1, ends.body.size), int)):
        why = why_open(legs, about, listed.labels, one, find)
        assert why == "no label covers the end of a leg, or a start"
    later = one._replace(time=listed.labels.time[[0]] - 1.0)
    assert why_open(legs, about, listed.labels, later, first) is not None
