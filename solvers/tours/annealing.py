"""Ruin and recreate of a tour, by annealing on its true expense."""

import math
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.memory import borrowed

from .costs import BLOCK, FAR, FORBIDDEN, TourRows, expense_of
from .inserting import CostRows, PuttingRules, put_back
from .sweeps import backwards

MOST_GROWTH = 30.0
"""Maximum ratio to the mass of an empty chaser; heavier ones count as too heavy."""

TOO_DEAR = 0.05
"""Cost per m/s of such a chaser."""

LEAST_MARGINAL = 0.002
"""Least slope per kilogram, so that tiny missions do not attract everything."""


class RuinRules(NamedTuple):
    """Extent of removals from a tour, and rules of reinsertion.

    Attributes
    ----------
    most : int
        Targets that are taken out at once.
    wide, near : int
        See :class:`~.inserting.PuttingRules`.
    blinks : float
        Share of places that are overlooked.
    noise : float
        Largest random error of the costs of places, in temperatures.
    """

    most: int
    wide: int
    near: int
    blinks: float
    noise: float


class TourTimes(NamedTuple):
    """A tour: order, beginnings of missions, and approximate time of each target."""

    order: np.ndarray
    begins: np.ndarray
    at: np.ndarray


@kernel
def judged(cost, tour, size, behind, grid, expense, fresh):
    """True expense of a tour at times optimal for its slopes.

    Parameters
    ----------
    tour : TourRows
        Times are filled, and what another target costs in a mission besides legs.
    size : int
    behind : (targets, times) float32
    grid : Grid
    expense : TourExpense
    fresh : (targets + 1,) float32
        Is filled: slopes as these missions have them.

    Returns
    -------
    float
        Infinite where there is no way through.
    """
    order, begins, at, slope, kit = borrowed(tour)
    times, gaps = cost.shape[3], cost.shape[2]
    # ``behind[j][t]`` is the least cost from target j at time t to the end. So the least of the
    # first row is that of the tour, and the next time is always the one that attains it: no time is
    # tried twice, and none has to be taken back.
    best, now = FAR, -1
    first = behind[order[0]]
    for t in range(times):
        if first[t] < best:
            best, now = first[t], t
    if now < 0:
        return np.inf
    at[0] = now
    legs = np.zeros(size)
    for k in range(1, size):
        row = behind[order[k]]
        best, then = FAR, -1
        if begins[k]:
            for t in range(max(0, now + grid.apart), times):
                if row[t] < best:
                    best, then = row[t], t
        else:
            for g in range(gaps):
                t = now + grid.least_gap + g
                if t >= times:
                    break
                units = cost[order[k - 1], order[k], g, now]
                if units == FORBIDDEN:
                    continue
                found = row[t] + slope[k] * np.float32(units)
                if found < best:
                    best, then = found, t
                    legs[k] = units * grid.unit_m_s
        if then < 0:
            return np.inf
        at[k] = now = then
    # At these times the expense is the true one, exponential in the legs and not linear as with
    # slopes. What a unit of a leg adds here is its slope the next time: a tour whose times are best
    # at its own slopes is one that no small change of a time makes cheaper.
    total, end = 0.0, size
    while end > 0:
        # Mass backwards to the first of the mission, then what a unit of each leg adds to it.
        mass, begin = expense.dry_kg + expense.kit_kg, end - 1
        while not begins[begin] and begin > 0:
            mass = mass * math.exp(legs[begin] / expense.exhaust_m_s) + expense.kit_kg
            if mass > MOST_GROWTH * expense.dry_kg:
                mass = MOST_GROWTH * expense.dry_kg
                total += TOO_DEAR * legs[begin]
            begin -= 1
        carried = mass - expense.dry_kg
        spent, marginal = expense_of(expense, carried, end - begin)
        total += spent
        marginal = max(marginal, LEAST_MARGINAL)
        growth, left = 1.0, mass
        per_unit = marginal * grid.unit_m_s / expense.exhaust_m_s
        for k in range(begin, end):
            if k > begin:
                # Without the kits that were left before, times what grew on the way.
                growth = min(growth * math.exp(legs[k] / expense.exhaust_m_s), MOST_GROWTH)
            else:
                left = mass - expense.kit_kg
            if k > begin:
                fresh[k] = np.float32(per_unit * max(left, expense.dry_kg))
                left -= expense.kit_kg * growth
            else:
                fresh[k] = np.float32(per_unit * left)
            kit[k] = marginal * expense.kit_kg * math.sqrt(mass / expense.dry_kg)
        end = begin
    return total


@inlined
def marked_string(marks, begin, count):
    """Mark some neighbours in a tour."""
    for k in range(begin, begin + count):
        marks[k] = True


@kernel
def marked(least, order, begins, at, size, most, marks):
    """Mark the targets to be removed from a tour.

    Returns
    -------
    int
        Where a mission is to be cut in two as well; −1 for nowhere.
    """
    # Whatever is marked, put_back finds places for it or the trial is dropped: so kinds are free to
    # differ, and each is for one fault of a tour: a stretch in a bad order, two stretches that
    # would do better together, neighbours that are apart, single targets, a mission too many or too
    # few.
    for k in range(size):
        marks[k] = False
    count = min(np.random.randint(2, most + 1), size - 1)
    kind = np.random.random()
    if kind < 0.25:
        marked_string(marks, np.random.randint(0, size - count + 1), count)
    elif kind < 0.4:
        half = max(1, count // 2)
        for _ in range(2):
            marked_string(marks, np.random.randint(0, size - half + 1), half)
    elif kind < 0.7:
        # Strings about those that a target could be reached from, or could reach, cheaply.
        seed = np.random.randint(0, size)
        near = np.empty(size)
        for k in range(size):
            there = min(at[k] // BLOCK, least.shape[2] - 1)
            one = least[order[k], order[seed], there]
            other = least[order[seed], order[k], there]
            near[k] = min(one, other) * (0.5 + np.random.random())
        near[seed] = -1.0
        rank = np.argsort(near)
        length = np.random.randint(1, 4)
        gone, place = 0, 0
        while gone < count and place < size:
            begin = max(0, min(size - length, rank[place] - np.random.randint(0, length)))
            for k in range(begin, begin + length):
                if not marks[k] and gone < count:
                    marks[k] = True
                    gone += 1
            place += 1
    elif kind < 0.9:
        for _ in range(count):
            marks[np.random.randint(0, size)] = True
    elif kind < 0.95:
        begin = np.random.randint(0, size)
        while begin > 0 and not begins[begin]:
            begin -= 1
        end = begin + 1
        while end < size and not begins[end]:
            end += 1
        if end - begin < min(size, 2 * most):
            marked_string(marks, begin, end - begin)
    else:
        for _ in range(count // 2):
            marks[np.random.randint(0, size)] = True
        return np.random.randint(0, size)
    return -1


@kernel
def anneal(costs, tour, grid, expense, iterations, seed, heat, rules):
    """Ruin and recreate a tour.

    Parameters
    ----------
    costs : TourCosts
    tour : TourTimes
    grid : TimeGrid
    expense : TourExpense
    iterations, seed : int
    heat : float
        Temperature, in units of expense.
    rules : RuinRules

    Returns
    -------
    best : float
        Its expense on the grid.
    tour : TourTimes
        The best one; that at which the search stood last is in the arguments.
    """
    np.random.seed(seed)
    cost, least = costs
    order, begins, at = tour
    most, wide = rules.most, rules.wide
    count, times = order.size, cost.shape[3]
    ahead, behind = np.full((count, times), FAR), np.full((count, times), FAR)
    rows = CostRows(ahead, behind, np.full((1, times), FAR), np.full((1, times), FAR))
    usual = np.float32(0.012 * grid.unit_m_s)
    slope, kit = np.full(count + 1, usual), np.full(count + 1, 0.37)
    now, cut = np.zeros(count + 1, np.int64), np.zeros(count + 1, np.bool_)
    when = np.zeros(count + 1, np.int64)
    trial, trial_cut = now.copy(), cut.copy()
    trial_at, trial_slope, trial_kit = when.copy(), slope.copy(), kit.copy()
    fresh = slope.copy()
    here = TourRows(now, cut, when, slope, kit)
    there = TourRows(trial, trial_cut, trial_at, trial_slope, trial_kit)
    marks, bag = np.zeros(count, np.bool_), np.zeros(count, np.int64)
    now[:count], cut[:count], when[:count] = order, begins, at
    present = np.inf
    for _ in range(4):
        when[:] = times // 2
        backwards(cost, here, grid, times, count - 1, count, behind)
        present = judged(cost, here, count, behind, grid, expense, fresh)
        slope[:] = fresh
    best = present
    order[:], begins[:], at[:] = now[:count], cut[:count], when[:count]
    best_order, best_begins, best_at = order.copy(), begins.copy(), at.copy()
    putting = PuttingRules(
        grid,
        wide,
        rules.near,
        expense.fixed + expense.per_kg * expense.kit_kg,
        usual,
        0.25,
        rules.blinks,
        rules.noise * heat,
        expense.most_missions,
    )
    # ``here`` is the tour at which the search stands, with the slopes that it was judged by, and
    # ``there`` a trial. A trial is written anew from ``here`` each time, so it may be left in any
    # state; it becomes ``here`` only after it was judged, complete and at times of its own.
    for _ in range(iterations):
        split = marked(least, now, cut, when, count, most, marks)
        if split >= 0 and cut.sum() >= expense.most_missions:
            split = -1
        # A mission whose first target is taken out begins with the next one that stays.
        size, lost, pending = 0, 0, False
        for k in range(count):
            pending = pending or cut[k] or k == split
            if marks[k]:
                bag[lost] = now[k]
                lost += 1
                continue
            trial[size], trial_cut[size], trial_at[size] = now[k], pending or size == 0, when[k]
            trial_slope[size], trial_kit[size] = slope[k], kit[k]
            size, pending = size + 1, False
        if size == 0 or (lost == 0 and split < 0):
            continue
        for item in range(lost - 1, 0, -1):
            other = np.random.randint(0, item + 1)
            bag[item], bag[other] = bag[other], bag[item]
        size, complete = put_back(costs, there, size, bag, lost, rows, putting)
        if not complete:
            continue
        found = judged(cost, there, size, behind, grid, expense, fresh)
        if found < present + 3.0 * heat:
            # Once more with the slopes of what came out.
            trial_slope[:] = fresh
            backwards(cost, there, grid, wide, size - 1, size, behind)
            found = judged(cost, there, size, behind, grid, expense, fresh)
        if found < present - heat * math.log(1.0 - np.random.random()):
            present = found
            now[:], cut[:], when[:] = trial, trial_cut, trial_at
            slope[:], kit[:] = fresh, trial_kit
            if present < best - 1e-9:
                best = present
                best_order[:], best_begins[:] = now[:count], cut[:count]
                best_at[:] = when[:count]
    order[:], begins[:], at[:] = now[:count], cut[:count], when[:count]
    return best, TourTimes(best_order, best_begins, best_at)
