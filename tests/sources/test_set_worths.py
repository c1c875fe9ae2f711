"""Worths of sets from a file: identities, restrictions, and files that are refused."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from catalogue_files import field

from adr_opt.common.errors import InputError
from adr_opt.sources import worth


def drawn(count: int, seed: int) -> worth.SetWorths:
    """Worths of objects that share more or less of them with each other."""
    random = np.random.default_rng(seed)
    pairs = np.triu(random.exponential(1.0, (count, count)), 1)
    pairs += pairs.T
    alone = pairs.sum(axis=1) * (1.0 + random.exponential(1.0, count))
    return worth.SetWorths(
        tuple(f"object {at}" for at in range(count)), alone, pairs, 0.01, float(alone.sum()), 50.0
    )


@pytest.fixture(scope="module")
def prizes() -> worth.RemovalPrizes:
    """Prizes of 20 of 40 drawn objects."""
    random = np.random.default_rng(5)
    measures = {
        at: worth.Measures(10.0 ** random.uniform(0.0, 4.0), random.uniform(0.2, 6.0))
        for at in range(40)
    }
    bodies = worth.bodies_of(field(40, 5), None, measures)
    return worth.prizes_of(worth.worth_of(bodies, 50.0), 20)


@pytest.fixture
def path(prizes: worth.RemovalPrizes, tmp_path: Path) -> Path:
    """The file of their pairs."""
    path = tmp_path / "pairs.json"
    path.write_text(worth.pairs_json(prizes), encoding="utf-8")
    return path


def test_a_set_of_one_is_worth_what_it_is_alone() -> None:
    """Of 2,000 single objects the floor is at most the worth of the set, which is that alone."""
    for seed in range(50):
        made = drawn(40, seed)
        for at, name in enumerate(made.names):
            assert made.floors[at] <= made.of_set([name]) == made.alone[at]


def test_floors_and_worths_alone_enclose_every_set() -> None:
    """Of 5,000 sets the worth lies between the sums of floors and of worths alone, and grows."""
    random = np.random.default_rng(1)
    for seed in range(50):
        made = drawn(30, seed)
        for _ in range(100):
            chosen = random.choice(30, random.integers(2, 31), replace=False)
            names = [made.names[at] for at in chosen]
            avoided = made.of_set(names)
            assert made.floors[chosen].sum() <= avoided * (1.0 + 1e-12)
            assert avoided < made.alone[chosen].sum()
            assert made.of_set(names[:-1]) <= avoided * (1.0 + 1e-12)
        assert made.floors.sum() == pytest.approx(made.of_set(made.names))


def test_floors_among_fewer_candidates_are_higher() -> None:
    """Worths of sets stay for some of the candidates, and floors come closer to those alone."""
    made = drawn(30, 3)
    some = made.among(made.names[20:5:-2])
    places = list(range(20, 5, -2))
    assert np.all(some.floors >= made.floors[places])
    assert some.of_set(some.names[:4]) == pytest.approx(made.of_set(some.names[:4]))
    assert some.digest != made.digest
    for wrong, said in ((("object 1", "moon"), "'moon' is unknown"), (("object 1",) * 2, "twice")):
        with pytest.raises(InputError, match=said):
            made.among(wrong)


def test_a_file_has_the_worths_of_the_catalogue(prizes: worth.RemovalPrizes, path: Path) -> None:
    """Sets, floors and the sum of all pairs read from the file are those that were written."""
    made, found = worth.load_set_worths(path), prizes.worth
    assert made.prize_unit == prizes.unit
    assert made.total == pytest.approx(found.total, rel=1e-9)
    assert made.floors == pytest.approx(prizes.floors, rel=1e-8)
    assert [int(text) for text in made.references] == [
        found.bodies.records[at].number for at in prizes.candidates
    ]
    random = np.random.default_rng(0)
    for _ in range(50):
        places = random.choice(20, random.integers(1, 21), replace=False)
        own = made.of_set(made.names[at] for at in places)
        assert own == pytest.approx(found.of_set(prizes.candidates[places]), rel=1e-8)


def less(content: dict[str, Any]) -> None:
    content["pairs"][0].pop()


def negative(content: dict[str, Any]) -> None:
    content["pairs"][0][0] = -1.0


def shared(content: dict[str, Any]) -> None:
    content["objects"][0]["alone"] = 1e-9


def twice(content: dict[str, Any]) -> None:
    content["objects"][1]["name"] = content["objects"][0]["name"]


def other(content: dict[str, Any]) -> None:
    content["format"] = "adr-opt-plan/2"


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (less, "must have a row for each of 20 objects"),
        (negative, "pairs"),
        (shared, "more than its worth alone"),
        (twice, "occurs twice"),
        (other, "format"),
    ],
)
def test_bad_files_are_refused(
    spoil: Callable[[dict[str, Any]], None], said: str, path: Path
) -> None:
    """One sentence names the file and the fault."""
    content = json.loads(path.read_text(encoding="utf-8"))
    spoil(content)
    path.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(InputError, match=said) as caught:
        worth.load_set_worths(path)
    assert str(path) in str(caught.value)


def test_files_have_a_limit(prizes: worth.RemovalPrizes, monkeypatch: pytest.MonkeyPatch) -> None:
    """More candidates than a file may have are refused before anything is written."""
    monkeypatch.setattr("adr_opt.sources.worth.worth_file.MOST_OBJECTS", 19)
    with pytest.raises(InputError, match="--pairs: 20 candidates, but the file has at most 19"):
        worth.pairs_json(prizes)
