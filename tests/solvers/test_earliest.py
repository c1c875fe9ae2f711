"""Tours that end as early as possible over given arrivals, a few ways of them by exception."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from solvers.tours.earliest import Arrivals, arrivals_of, earliest_tour, exceptions_needed, near_of
from solvers.tours.earliest_arrivals import wanted_by

STEP, TIMES = 0.5, 120


def made_up(seed, count=6, share=0.55):
    """Arrivals that never fall, of usual ways between some places and of exceptions."""
    rng = np.random.default_rng(seed)
    tables = []
    for kind, slow in enumerate((4.0, 1.5)):
        leaves = np.arange(TIMES) * STEP
        taken = rng.uniform(0.3, slow, (count, count, TIMES)) + rng.integers(
            0, 3, (count, count, 1)
        )
        ends = np.flip(np.minimum.accumulate(np.flip(leaves + taken, 2), axis=2), 2)
        ends[rng.random((count, count)) > (share, 0.8)[kind]] = np.inf
        ends[range(count), range(count)] = np.inf
        tables.append(ends)
    return arrivals_of(STEP, *tables, exceptions=2)


def arrives(arrivals, kind, i, j, time):
    """When one arrives, read from the table once more."""
    row, k = arrivals.row[kind, i, j], int(time / arrivals.step)
    if row < 0 or k >= arrivals.arrival.shape[1]:
        return math.inf
    return max(float(arrivals.arrival[row, k]), time)


def by_all_orders(arrivals, latest):
    """The earliest end over all orders of places and all choices of exceptions."""
    count, best = arrivals.near.size, math.inf
    for order in itertools.permutations(range(count)):
        ends = {0: 0.0}
        for i, j in itertools.pairwise(order):
            then = {}
            for used, time in ends.items():
                for kind in range(2):
                    end = arrives(arrivals, kind, i, j, time)
                    if used + kind <= arrivals.exceptions and end <= latest:
                        then[used + kind] = min(then.get(used + kind, math.inf), end)
            ends = then
        best = min(best, *ends.values(), math.inf)
    return best


@pytest.mark.parametrize("seed", range(12))
def test_the_earliest_tour_is_that_of_all_orders(seed):
    """With all states kept the tour found ends when the best of all orders does."""
    arrivals = made_up(seed)
    found = earliest_tour(arrivals, 30.0)
    assert found.whole
    assert found.end == by_all_orders(arrivals, 30.0)


@pytest.mark.parametrize("seed", range(6))
def test_a_tour_can_be_flown_as_it_is_told(seed):
    """The order and the exceptions of a tour lead to its end, and no more exceptions are used."""
    arrivals = made_up(seed)
    found = earliest_tour(arrivals, 60.0)
    assert sorted(found.order) == list(range(6))
    time = 0.0
    for (i, j), kind in zip(itertools.pairwise(found.order), found.exceptional, strict=True):
        time = arrives(arrivals, int(kind), i, j, time)
    assert time == found.end
    assert sum(found.exceptional) <= arrivals.exceptions


def test_narrow_searches_say_what_they_left_out():
    """A search that keeps few states says so, and its tour ends no earlier than the best."""
    met = 0
    for seed in range(12):
        arrivals = made_up(seed)
        whole, narrow = earliest_tour(arrivals, 60.0), earliest_tour(arrivals, 60.0, width=4)
        assert not narrow.whole
        assert narrow.end >= whole.end
        met += narrow.end > whole.end
    assert met


def test_linear_arrivals_lie_between_those_of_the_table():
    """Ready times half-way between two others arrive half-way, except after a jump at the later."""
    line = np.array([1.0, 1.5, 2.0, 9.0, 9.0])
    usual = np.full((2, 2, 5), np.inf)
    usual[0, 1] = line
    tables = arrivals_of(1.0, usual, np.full_like(usual, np.inf), 0, linear=True)
    for begin, end in ((0.0, 1.0), (0.5, 1.25), (1.0, 1.5), (2.5, 9.0)):
        assert earliest_tour(tables, 99.0, begin=begin).end == end
    assert earliest_tour(tables, 99.0, begin=4.5).end == math.inf


@pytest.mark.parametrize("seed", range(20))
def test_no_fewer_exceptions_are_needed(seed):
    """No order of what is left does with fewer exceptions than are said to be needed."""
    rng = np.random.default_rng(seed)
    there = np.triu(rng.random((6, 6)) < 0.35, 1)
    near = near_of(there)
    usual = there | there.T
    for here in range(6):
        left = [place for place in range(6) if place != here and rng.random() < 0.8]
        least = min(
            sum(not usual[i, j] for i, j in itertools.pairwise((here, *order)))
            for order in itertools.permutations(left)
        )
        word = np.uint64(sum(1 << place for place in left))
        assert exceptions_needed(word, here, near) <= least


@pytest.mark.parametrize("seed", range(6))
def test_arrivals_that_do_not_matter_may_be_anything(seed):
    """Arrivals after those that are wanted may be later still, and the best tour stays."""
    arrivals = made_up(seed)
    best = earliest_tour(arrivals, 60.0)
    latest = best.end + 1.0
    wanted = wanted_by(arrivals, earliest_tour(arrivals, latest), latest)
    marks = arrivals.arrival <= wanted
    assert marks.any()
    assert not marks.all()
    later = Arrivals(*arrivals)._replace(
        arrival=np.where(marks, arrivals.arrival, arrivals.arrival + 50.0)
    )
    assert earliest_tour(later, latest).end == best.end
    # What matters does: a tour of them all is gone if they are all later.
    gone = arrivals._replace(arrival=np.where(marks, arrivals.arrival + 50.0, arrivals.arrival))
    assert earliest_tour(gone, best.end).end > best.end


def test_too_many_places_are_refused():
    """More places than a word has bits for are refused."""
    usual = np.zeros((59, 59, 2))
    with pytest.raises(ValueError, match="59 places"):
        earliest_tour(arrivals_of(1.0, usual, usual, 0), 1.0)
