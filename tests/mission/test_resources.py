"""What a route has left: legs change it alike for all, and comparisons mean what they say."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from adr_opt.kernels.rules.loads import Loads
from adr_opt.kernels.rules.resources import (
    ANY,
    CountLimits,
    Resources,
    at,
    columns,
    counts_of,
    dominates,
    extend,
    put,
    with_counts,
)

BODIES, BUDGET = 4, 300.0

LIMITED = CountLimits(*(9 for _ in CountLimits._fields))
"""Counts that all matter."""


def carrying(kit_kg: float, towed_kg: float) -> Loads:
    """A chaser of 500 kg with two kits at most: body 1 takes one, and body 2 is towed."""
    cargo = kit_kg * np.arange(3)
    scale, loss = np.ones((BODIES, 3)), np.zeros((BODIES, 3))
    lighter = np.where(cargo > 0.0, 500.0 + cargo - kit_kg, 500.0)
    scale[1] = np.where(cargo > 0.0, (500.0 + cargo) / lighter, 1.0)
    loss[1] = scale[1] - 1.0
    scale[2] = np.exp(-40.0 / 3000.0)
    loss[2] = (1.0 - scale[2]) * towed_kg / (500.0 + cargo)
    full = np.array([300.0, 290.0, 280.0])
    flown = np.array([0.0, 0.0, 40.0, 0.0])
    return Loads(3000.0, np.array([0, 1, 0, 0]), full, full, scale, loss, kit_kg > 0.0, flown)


CARRIED = [None, carrying(0.0, 900.0), carrying(12.0, 900.0)]


def some(rng: np.random.Generator, loads: Loads | None, number: int) -> list[Resources]:
    """Resources of few different amounts, so that many are equal or comparable."""
    return [
        Resources(
            float(rng.integers(3)),
            60.0 * float(rng.integers(1, 5)),
            1,
            int(rng.integers(1, 3)),
            0 if loads is None else int(rng.integers(3)),
        )
        for _ in range(number)
    ]


@pytest.mark.parametrize("loads", CARRIED)
def test_to_dominate_is_an_order(loads: Loads | None) -> None:
    """All dominate themselves, two that dominate one another are equal, and it is passed on."""
    found = some(np.random.default_rng(0), loads, 14)
    strict = 0
    for one, other in itertools.product(found, repeat=2):
        if dominates(one, other, loads, LIMITED):
            strict += one != other
            assert not dominates(other, one, loads, LIMITED) or one == other
            assert all(
                dominates(one, third, loads, LIMITED)
                for third in found
                if dominates(other, third, loads, LIMITED)
            )
        else:
            assert one != other
    assert strict > 5


@pytest.mark.parametrize("loads", CARRIED)
@pytest.mark.parametrize(
    ("better", "worse"),
    [
        ({"time": 1.0}, {"time": 2.0}),
        ({"left": 100.0}, {"left": 99.0}),
        ({"serviced": 1}, {"serviced": 2}),
    ],
)
def test_each_resource_counts(loads: Loads | None, better: dict, worse: dict) -> None:
    """Of two routes that differ in one resource only the one with more of it dominates."""
    usual = Resources(1.0, 100.0, 1, 1, 0)
    one, other = usual._replace(**better), usual._replace(**worse)
    assert dominates(one, other, loads, LIMITED)
    assert not dominates(other, one, loads, LIMITED)


def test_what_does_not_limit_tells_none_apart() -> None:
    """Counts are compared only where there is a limit to them."""
    one, other = Resources(1.0, 100.0, 2, 2, 0), Resources(1.0, 100.0, 1, 1, 0)
    free = CountLimits(*(ANY for _ in CountLimits._fields))
    assert dominates(one, other, None, free)
    assert not dominates(one, other, None, LIMITED)


def test_counts_are_packed_without_loss() -> None:
    """Packed counts give back the same resources, up to the largest numbers there are."""
    for has in (*some(np.random.default_rng(3), CARRIED[1], 6), Resources(1.0, 2.0, ANY, ANY, ANY)):
        assert with_counts(has.time, has.left, counts_of(has)) == has


def test_kits_will_do_unless_they_weigh() -> None:
    """With more kits everything is possible that is with fewer, except where kits are heavy."""
    usual = Resources(1.0, 100.0, 1, 1, 1)
    for loads, expected in ((CARRIED[1], True), (CARRIED[2], False)):
        assert dominates(usual._replace(kits=2), usual, loads, LIMITED) == expected
        assert not dominates(usual, usual._replace(kits=2), loads, LIMITED)


@pytest.mark.parametrize("loads", CARRIED)
def test_who_dominates_does_so_after_any_leg(loads: Loads | None) -> None:
    """What one route has left dominates another's still after the same leg, or that cannot fly."""
    rng, kept = np.random.default_rng(1), 0
    found = some(rng, loads, 25)
    for one, other in itertools.product(found, repeat=2):
        if one == other or not dominates(one, other, loads, LIMITED):
            continue
        for body in range(BODIES):
            refuels, end = body == 0, 5.0
            after = extend(one, body, refuels, 30.0, end, loads, BUDGET)
            then = extend(other, body, refuels, 30.0, end, loads, BUDGET)
            assert after.since == then.since == (0 if refuels else 2)
            if then.left >= 0.0:
                assert dominates(after, then, loads, LIMITED) or (
                    refuels and after.kits != then.kits
                )
                kept += 1
    assert kept > 50


def test_columns_give_back_what_was_put_there() -> None:
    """Resources of many routes side by side are those that were written, at any number of axes."""
    found = some(np.random.default_rng(2), CARRIED[1], 6)
    held = columns((2, 3))
    for place, has in zip(np.ndindex(2, 3), found, strict=True):
        put(held, place, has)
    assert [at(held, place) for place in np.ndindex(2, 3)] == found
