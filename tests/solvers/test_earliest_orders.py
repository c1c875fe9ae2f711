"""Orders of all targets with the earliest end: their times, their search, and all of them."""

from __future__ import annotations

import itertools
import math

import numpy as np
from seeds import over_seeds

from solvers.orders import all_orders, earliest_order, earliest_search
from solvers.orders.quickest_legs import QuickestLegs, arrives, leaves, quickest_legs, shortest


def drawn(seed: int, targets: int) -> tuple[QuickestLegs, list[tuple[int, int, float, float]]]:
    """Connections between a start, which is body 0, and some targets."""
    rng = np.random.default_rng(seed)
    rows = []
    for i, j in itertools.product(range(targets + 1), range(1, targets + 1)):
        for _ in range(int(rng.integers(0, 9)) if i != j else 0):
            departure, flight = float(rng.integers(0, 40)), float(rng.integers(1, 12))
            rows.append((i, j, departure, departure + flight))
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    legs = quickest_legs((columns[0], columns[1]), *columns[2:], bodies=targets + 1)
    return legs, rows


def end_of(rows: list[tuple[int, int, float, float]], order: tuple[int, ...]) -> float:
    """Earliest end of an order, from all rows."""
    free = 0.0
    for pair in itertools.pairwise((0, *order)):
        free = min((row[3] for row in rows if row[:2] == pair and row[2] >= free), default=math.inf)
    return free


@over_seeds(range(60), gate=3)
def test_tables_say_what_the_rows_say(seed: int) -> None:
    """The earliest end and the latest departure of a pair are those among all of its rows."""
    legs, rows = drawn(seed, 4)
    for i, j in itertools.product(range(5), range(1, 5)):
        mine = [row for row in rows if row[:2] == (i, j)]
        for time in np.arange(-0.5, 60.0, 2.5):
            end = min((row[3] for row in mine if row[2] >= time), default=math.inf)
            assert arrives(legs, i, j, time) == end
            latest = max((row[2] for row in mine if row[3] <= time), default=-math.inf)
            assert leaves(legs, i, j, time) == latest


@over_seeds(range(100), gate=6)
def test_times_of_an_order_are_those_of_enumeration(seed: int) -> None:
    """Earliest times are right, and latest times are the last that suffice."""
    legs, rows = drawn(seed, 4)
    rng = np.random.default_rng(seed)
    order = 1 + rng.permutation(4)
    course = earliest_order.new_order(order, 0, 0.0, 5)
    earliest_order.time_forth(legs, course, 0, 4, 0, 4)
    for length in range(1, 5):
        assert course.early[order[length - 1]] == end_of(rows, tuple(order[:length]))
    end = course.early[order[3]]
    for deadline in (30.0, 45.0, min(end, 100.0)):
        earliest_order.time_back(legs, course, 0, 4, 4, -1, deadline)
        for body in range(5):
            assert (course.late[body] >= course.early[body]) == (end <= deadline)


@over_seeds(range(60), gate=3)
def test_the_search_finds_the_best_of_all_orders(seed: int) -> None:
    """On few targets the search, and the one over all sets, end as early as the best order."""
    legs, rows = drawn(seed, 5)
    ends = [end_of(rows, order) for order in itertools.permutations(range(1, 6))]
    best, end = all_orders.earliest_of_all(legs, 0, 0.0, 1, math.inf)
    assert end == min(ends)
    if math.isinf(end):
        assert best.size == 0
        return
    assert end_of(rows, tuple(best)) == end
    apart = shortest(legs)
    near = np.argsort(np.minimum(apart, apart.T)[:, 1:], axis=1, kind="stable") + 1
    annealing = earliest_search.Cooling(3.0, 0.1, 3000, 100.0, 0.2)
    found, found_end, length = earliest_search.search(
        legs,
        0,
        0.0,
        np.arange(1, 6),
        0,
        near,
        np.zeros(6),
        annealing,
        np.random.default_rng(seed),
        np.zeros(1, dtype=np.bool_),
    )
    assert length == found.size == 5
    assert end_of(rows, tuple(found)) == found_end == end
