"""Set packing: it keeps to its time, and what it says of the least is no more than the least."""

from __future__ import annotations

import itertools
import math
import time

import numpy as np
import pytest
from random_rules import random_campaign
from scipy.optimize import LinearConstraint
from scipy.sparse import csc_array

from adr_opt.mission.problem import Problem
from solvers.columns import route_enumeration
from solvers.columns.route_enumeration import EnumerationAnswer, Finish
from solvers.routes.set_packing import PRESOLVED, cheapest_of
from solvers.walks.walks import WalkBound


def drawn(columns: int, rows: int, seed: int) -> LinearConstraint:
    """Columns of about a quarter of the rows each, no row twice."""
    rng = np.random.default_rng(seed)
    taken = rng.random((rows, columns)).argsort(axis=0) < rng.integers(
        rows // 5, rows // 3, columns
    )
    return LinearConstraint(csc_array(taken.astype(float)), -np.inf, np.ones(rows))


def test_the_time_limit_is_kept_however_many_columns_there_are():
    """Six times as many columns as are simplified first take hardly more time than they may."""
    columns = 6 * PRESOLVED
    disjoint = drawn(columns, 50, 0)
    sizes = np.asarray(disjoint.A.sum(axis=0)).ravel()
    constraints = [
        disjoint,
        LinearConstraint(np.ones((1, columns)), -np.inf, 3.0),
        LinearConstraint(sizes[None, :], 38.0, np.inf),
    ]
    began = time.process_time()
    found = cheapest_of(-sizes, constraints, 0.5)
    assert time.process_time() - began < 6.0
    assert found.taken is None or sizes[found.taken].sum() >= 38.0


@pytest.mark.parametrize("seed", range(5))
def test_the_least_is_that_of_all_choices(seed):
    """What is proven is no more than the cheapest choice costs, and none where there is none."""
    rng = np.random.default_rng(seed)
    columns, disjoint = 9, drawn(9, 10, seed)
    costs, worths = rng.uniform(0.0, 2.0, columns), rng.integers(1, 4, columns).astype(float)
    best, most = math.inf, 0.0
    for chosen in itertools.product((0.0, 1.0), repeat=columns):
        if (disjoint.A @ np.array(chosen) <= 1.0).all():
            most = max(most, worths @ chosen)
            best = min(best, costs @ chosen if worths @ chosen >= 3.0 else math.inf)
    found = cheapest_of(
        costs, [disjoint, LinearConstraint(worths[None, :], 3.0, np.inf)], 10.0, gap=0.0
    )
    assert found.solved
    assert found.least <= best + 1e-6
    assert (found.taken is None) == (best == math.inf)
    if found.taken is not None:
        assert costs[found.taken].sum() == pytest.approx(best)
    none = cheapest_of(
        costs, [disjoint, LinearConstraint(worths[None, :], most + 1.0, np.inf)], 10.0
    )
    assert none == (None, math.inf, True)


def test_the_end_of_a_proof_asks_for_the_time_when_it_packs(monkeypatch):
    """Labels that take most of what is left leave no more than the rest to the packing."""
    campaign = Problem(random_campaign(3))
    bounds = [(WalkBound(kind.mission, 50.0), 0) for kind in campaign.kinds]
    asked, left = [], [60.0]

    def recorded(costs, constraints, time_limit_s, gap=None):
        asked.append(time_limit_s)
        return cheapest_of(costs, constraints, time_limit_s, gap)

    def enough() -> bool:
        left[0] = 2.0
        return False

    original = route_enumeration.Search.search

    def searched(self, threshold, most_labels, is_enough):
        is_enough()
        return original(self, threshold, most_labels, is_enough)

    monkeypatch.setattr(route_enumeration, "cheapest_of", recorded)
    monkeypatch.setattr(route_enumeration.Search, "search", searched)
    none = np.zeros(len(campaign.names))
    most = np.full(len(campaign.kinds), campaign.total_worth)
    answer, _ = Finish(campaign, bounds).ask(1e-3, none, most, 10**6, enough, lambda: left[0])
    assert answer is not EnumerationAnswer.UNKNOWN
    assert asked == [2.0]
