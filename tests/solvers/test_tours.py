"""Campaigns as one tour through time: the search and the bound against trying everything."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from solvers.tours import bound as bounds
from solvers.tours import cell_walks
from solvers.tours.bound import Bounding, FirstPrices, Tangent, bound, memories, neighbourhoods
from solvers.tours.costs import FORBIDDEN, TimeGrid, TourCosts, TourExpense, blocks, nearby
from solvers.tours.population import Annealing, Population, crossed, first_tour

GRID = TimeGrid(least_gap=1, apart=3, unit_m_s=1.0)
EXPENSE = TourExpense(20.0, 0.0, 2e-6, 2000.0, 30.0, 3334.0, 5000.0, most_missions=9)
QUICK = Annealing(hot=8.0, chunk=20, most=4, wide=20, near=20, missions=2, iterations=200)


def drawn(seed, targets=4, gaps=3, times=10):
    """Costs by pair, gap and time that favour other pairs at other times; some legs are none."""
    random = np.random.default_rng(seed)
    cost = random.integers(50, 3000, (targets, targets, gaps, times)).astype(np.uint16)
    cost[random.random(cost.shape) < 0.2] = FORBIDDEN
    cost[range(targets), range(targets)] = FORBIDDEN
    return cost


def expense_of(legs):
    """Expense of a mission by its legs; infinite beyond its tank."""
    mass = EXPENSE.dry_kg + EXPENSE.kit_kg
    for leg in reversed(legs):
        mass = mass * math.exp(leg / EXPENSE.exhaust_m_s) + EXPENSE.kit_kg
    carried = mass - EXPENSE.dry_kg
    if carried - (len(legs) + 1) * EXPENSE.kit_kg > EXPENSE.most_propellant_kg:
        return math.inf
    return EXPENSE.fixed + EXPENSE.per_kg_squared * carried**2


def every_tour(cost, missions=None):
    """Least expense of all orders, cuts and times, by trying them; or with a number of missions."""
    targets, _, gaps, times = cost.shape

    def rest(left, last, now, legs, launched=1):
        if not left:
            return expense_of(legs) if missions in (None, launched) else math.inf
        best = math.inf
        for one in left:
            others = left - {one}
            for gap in range(gaps):
                then = now + GRID.least_gap + gap
                if then < times and cost[last, one, gap, now] != FORBIDDEN:
                    leg = float(cost[last, one, gap, now])
                    best = min(best, rest(others, one, then, [*legs, leg], launched))
            paid = expense_of(legs)
            for then in range(now + GRID.apart, times):
                best = min(best, paid + rest(others, one, then, [], launched + 1))
        return best

    every = frozenset(range(targets))
    starts = itertools.product(every, range(times))
    return min(rest(every - {one}, one, now, []) for one, now in starts)


@pytest.fixture(scope="module", params=range(4))
def tried(request):
    cost = drawn(request.param, targets=3 + request.param % 2, times=8)
    return cost, every_tour(cost)


def judged_apart(cost, tour):
    """Expense of a tour at its own times, with all its rules asked for."""
    targets, _, gaps, times = cost.shape
    assert sorted(tour.order) == list(range(targets))
    assert tour.begins[0]
    assert min(tour.at) >= 0
    assert max(tour.at) < times
    total, legs = 0.0, []
    for k in range(1, targets):
        step = tour.at[k] - tour.at[k - 1]
        if tour.begins[k]:
            assert step >= GRID.apart
            total += expense_of(legs)
            legs = []
            continue
        assert GRID.least_gap <= step < GRID.least_gap + gaps
        units = cost[tour.order[k - 1], tour.order[k], step - GRID.least_gap, tour.at[k - 1]]
        assert units != FORBIDDEN
        legs.append(float(units))
    return total + expense_of(legs)


def planned(cost, seed, generations, cores=1):
    """Tours of a population after some generations."""
    found = Population(cost, GRID, EXPENSE, QUICK, lambda: 0.0, seed=seed, cores=cores)
    for _ in range(generations):
        found.advance()
    return found.tours


def test_the_search_finds_what_trying_everything_finds(tried):
    """On tiny campaigns tours are legal, cost what they say, and the best is the best of all."""
    cost, least = tried
    tours = planned(cost, 3, 5)
    for tour in tours:
        assert judged_apart(cost, tour) == pytest.approx(tour.expense, rel=1e-6)
        assert tour.expense >= least - 1e-4
    assert tours[0].expense <= 1.05 * least


def test_the_search_is_the_same_again():
    """A seed and a number of generations give the same tours, however many threads there are."""
    cost = drawn(9, targets=6, times=20)
    first, *others = (planned(cost, 5, 4, cores) for cores in (1, 1, 2))
    for again in others:
        assert len(again) == len(first)
        for one, other in zip(first, again, strict=True):
            assert one.expense == other.expense
            assert (one.order == other.order).all()
            assert (one.at == other.at).all()


def test_a_crossed_tour_has_every_target_once():
    """Whatever two tours are crossed, each target has one place, and missions begin in time."""
    cost = drawn(11, targets=9, times=30)
    least = np.zeros((*cost.shape[:2], blocks(cost.shape[3])), np.uint16)
    nearby(cost, least)
    costs = TourCosts(cost, least)
    for seed in range(200):
        parents = tuple(
            first_tour(costs, GRID, EXPENSE, 2 * seed + k, 1 + seed % 4) for k in range(2)
        )
        made = crossed(costs, GRID, EXPENSE, parents, seed)
        assert sorted(made.order) == list(range(9))
        assert made.begins[0]


@pytest.mark.parametrize("remembered", [0, 1, 2])
@pytest.mark.parametrize("carried_kg", [300.0, 1500.0, 4000.0])
def test_no_bound_exceeds_the_best_tour(tried, remembered, carried_kg):
    """Whatever is remembered and wherever the expense is made linear, bounds lie below the best."""
    cost, least = tried
    cells = np.ascontiguousarray(cost.transpose(3, 0, 1, 2))
    tangent = Tangent.at(EXPENSE, carried_kg)
    memory = memories(neighbourhoods(cells, remembered))
    found = bound(cells, GRID, EXPENSE, tangent, memory, Bounding(rounds=60))
    assert found.value <= least + 1e-9
    again = bound(
        cells, GRID, EXPENSE, tangent, memory, Bounding(rounds=0), FirstPrices(found.prices)
    )
    assert again.value == pytest.approx(found.value, abs=1e-3)


@pytest.mark.parametrize("missions", [1, 2, 3])
@pytest.mark.parametrize("carried_kg", [200.0, 1500.0, 4000.0])
def test_no_bound_on_so_many_missions_exceeds_their_best_tour(tried, missions, carried_kg):
    """With the number of missions given, bounds lie below the best tour that has as many."""
    cost, least = tried
    cells = np.ascontiguousarray(cost.transpose(3, 0, 1, 2))
    memory = memories(neighbourhoods(cells, 2))
    tangent = Tangent.at(EXPENSE, carried_kg)
    own = every_tour(cost, missions)
    assert own >= least
    settings = Bounding(rounds=60)
    found = bound(cells, GRID, EXPENSE, tangent, memory, settings, FirstPrices(missions=missions))
    assert found.value <= own + 1e-9
    fixed = (cells, GRID, EXPENSE, tangent, memory)
    first = FirstPrices(found.prices, missions, found.fee)
    again = bound(*fixed, Bounding(rounds=0), first)
    assert again.value == pytest.approx(found.value, abs=1e-3)
    random = np.random.default_rng(missions)
    for _ in range(10):
        prices = random.normal(8.0, 12.0, cells.shape[1])
        fee = random.normal(0.0, 40.0)
        asked = bound(*fixed, Bounding(rounds=0), FirstPrices(prices, missions, fee))
        assert asked.value <= own


def test_prices_of_any_kind_give_bounds(tried):
    """Random prices, also large and negative ones, never give more than the best tour costs."""
    cost, least = tried
    cells = np.ascontiguousarray(cost.transpose(3, 0, 1, 2))
    memory = memories(neighbourhoods(cells, 2))
    random = np.random.default_rng(0)
    for _ in range(30):
        tangent = Tangent.at(EXPENSE, random.uniform(60.0, 6000.0))
        prices = random.normal(8.0, 12.0, cells.shape[1])
        settings = Bounding(rounds=0, levels=int(random.integers(2, 6)))
        found = bound(cells, GRID, EXPENSE, tangent, memory, settings, FirstPrices(prices))
        assert found.value <= least


def cheapest_walk(cost, tangent, prices):
    """The least cost of missions one after another, of any targets, at fixed prices; 0 for none.

    All missions are tried, each target once in each of them, with what tangents say of their mass.
    """
    targets, _, gaps, times = cost.shape
    ended = [0.0] * times
    for end in range(times):
        # Backwards: targets of a mission, when it is at the first of them, and the mass on arrival.
        going = [((last,), end, EXPENSE.dry_kg + EXPENSE.kit_kg) for last in range(targets)]
        ended[end] = ended[end - 1] if end else 0.0
        while going:
            done, at, mass = going.pop()
            before = ended[at - GRID.apart] if at >= GRID.apart else 0.0
            paid = tangent.fixed + tangent.per_kg * mass - sum(prices[one] for one in done)
            ended[end] = min(ended[end], before + paid)
            for one, gap in itertools.product(set(range(targets)) - set(done), range(gaps)):
                since = at - GRID.least_gap - gap
                if since >= 0 and cost[one, done[0], gap, since] != FORBIDDEN:
                    grown = math.exp(float(cost[one, done[0], gap, since]) / EXPENSE.exhaust_m_s)
                    going.append(((one, *done), since, mass * grown + EXPENSE.kit_kg))
    return ended[-1]


@pytest.mark.slow
def test_walks_are_no_dearer_than_missions_at_any_price():
    """At fixed prices no mission beats the cheapest walk, however few the masses; many meet it."""
    met = 0
    for seed in range(60):
        random = np.random.default_rng(seed)
        count = int(random.integers(4, 6))
        cost = random.integers(300, 3000, (count, count, 3, 10)).astype(np.uint16)
        cost[random.random(cost.shape) < 0.2] = FORBIDDEN
        cost[range(count), range(count)] = FORBIDDEN
        cells = np.ascontiguousarray(cost.transpose(3, 0, 1, 2))
        tangent = Tangent.at(EXPENSE, random.uniform(200.0, 6000.0))
        launch = 10.0 + tangent.per_kg * EXPENSE.dry_kg * random.uniform(0.1, 1.0)
        prices = random.uniform(0.5, 2.5, count) * launch
        true = prices.sum() + cheapest_walk(cost, tangent, prices)
        for remembered in (0, 1, count - 1):
            memory = memories(neighbourhoods(cells, remembered))
            for levels in (2, 3, 5, 40):
                settings = Bounding(rounds=0, levels=levels)
                found = bound(cells, GRID, EXPENSE, tangent, memory, settings, FirstPrices(prices))
                assert found.value <= true + 1e-9, (seed, remembered, levels)
        met += found.value >= true - 1e-4 * prices.sum()
    assert met > 40


def test_a_label_is_hidden_by_one_that_is_no_worse_at_any_mass():
    """One that remembers no more and costs no more at each level, and no other one."""
    random = np.random.default_rng(1)
    hidden = 0
    for _ in range(2000):
        masks, values = random.integers(0, 8, 3), random.integers(0, 4, (3, 3)).astype(float)
        mask, value = int(random.integers(0, 8)), random.integers(1, 5, 3).astype(float)
        wanted = any(
            one & ~mask == 0 and (row <= value).all()
            for one, row in zip(masks.tolist(), values, strict=True)
        )
        assert cell_walks.is_hidden(masks, values, 3, mask, value) == wanted
        hidden += wanted
    assert 200 < hidden < 1800


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_traced_walks_cost_in_the_mean_what_the_sweep_says(kind):
    """Walks drawn from the cheapest mixture cost, less their prices, its value in the mean."""
    traced = 0
    for seed in range(12):
        cells = np.ascontiguousarray(drawn(seed, times=20).transpose(3, 0, 1, 2))
        random = np.random.default_rng(seed)
        tangent = Tangent.at(EXPENSE, 6000.0)
        prices = random.uniform(0.5, 2.5, 4) * (tangent.per_kg * 2500.0)
        memory = memories(neighbourhoods(cells, seed % 4))
        walks = bounds._Walks(cells, GRID, EXPENSE, tangent, memory, 12, kind)
        value = walks.value(prices, 0.0) - prices.sum()
        missing, missions, carried_kg = walks.missing(prices, 0.0, random)
        per_mission = tangent.fixed + tangent.per_kg * (EXPENSE.dry_kg + carried_kg)
        cost = missions * per_mission - prices @ (1.0 - missing)
        assert cost == pytest.approx(value, rel=0.03, abs=1e-6), seed
        traced += missions > 0
    assert traced > 8


@pytest.mark.parametrize("seed", range(20))
def test_a_tangent_never_exceeds_the_expense(seed):
    """Missions of any mass cost at least what a tangent of the expense says."""
    random = np.random.default_rng(seed)
    tangent = Tangent.at(EXPENSE, random.uniform(60.0, 6000.0))
    for carried_kg in random.uniform(0.0, 8000.0, 25):
        true = EXPENSE.fixed + EXPENSE.per_kg_squared * carried_kg**2
        assert tangent.fixed + tangent.per_kg * (EXPENSE.dry_kg + carried_kg) <= true + 1e-9
