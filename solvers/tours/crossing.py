"""Crossing of two tours: missions of one within a span of time, and those of the other around it.

What a mission costs depends on its own time alone, so a good part of a tour stays good in another
one, where the same time is free. Targets that both parts service leave the longer mission, and what
neither services is inserted where it costs least.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from .costs import FAR, TimeGrid, Tour, TourCosts, TourExpense, TourRows
from .inserting import CostRows, PuttingRules, put_back

USUAL_SLOPE = 0.012
"""Cost of another m/s before anything is known of a mission."""

USUAL_KIT = 0.37
"""Cost of another target in a mission, besides legs, before anything is known of it."""


class NoPlace(Exception):
    """No tour was found that has time for all targets."""


class Piece(NamedTuple):
    """A mission of a tour: its targets in order, and when each is reached [steps]."""

    order: list[int]
    at: list[int]


def pieces_of(tour: Tour) -> list[Piece]:
    """Missions of a tour."""
    firsts = [*np.flatnonzero(tour.begins).tolist(), tour.order.size]
    return [Piece(tour.order[a:b].tolist(), tour.at[a:b].tolist()) for a, b in pairwise(firsts)]


def completed(
    costs: TourCosts, grid: TimeGrid, expense: TourExpense, pieces: list[Piece], lacking: np.ndarray
) -> Tour:
    """Missions with all other targets inserted, each where it costs least.

    Parameters
    ----------
    costs : TourCosts
    grid : TimeGrid
    expense : TourExpense
    pieces : list of Piece
        In order of time, with no target twice.
    lacking : (lacking,) int64
        The other targets, in the order of insertion.

    Raises
    ------
    NoPlace
        One has no place.
    """
    count, times = costs.legs.shape[1], costs.legs.shape[3]
    order, begins = np.zeros(count + 1, np.int64), np.zeros(count + 1, np.bool_)
    at, size = np.full(count + 1, times // 2), 0
    for piece in pieces:
        there = slice(size, size + len(piece.order))
        order[there], at[there], begins[size] = piece.order, piece.at, True
        size = there.stop
    usual = np.float32(USUAL_SLOPE * grid.unit_m_s)
    slope, kit = np.full(count + 1, usual), np.full(count + 1, USUAL_KIT)
    rows = [np.full((count, times), FAR, np.float32) for _ in range(2)]
    helpers = [np.full((1, times), FAR, np.float32) for _ in range(2)]
    rules = PuttingRules(
        grid,
        times,
        min(times // 2, 40),
        expense.fixed,
        usual,
        0.25,
        blinks=0.0,
        noise=0.0,
        most_missions=expense.most_missions,
    )
    if lacking.size:
        _, complete = put_back(
            costs,
            TourRows(order, begins, at, slope, kit),
            size,
            lacking,
            lacking.size,
            CostRows(*rows, *helpers),
            rules,
        )
        if not complete:
            raise NoPlace("the horizon has no room for all targets in these missions")
    return Tour(order[:-1].copy(), begins[:-1].copy(), at[:-1].copy(), float("inf"))


def first_tour(
    costs: TourCosts, grid: TimeGrid, expense: TourExpense, seed: int, missions: int
) -> Tour:
    """Missions of one target each, spread over time, into which all others are inserted.

    Raises
    ------
    NoPlace
        One has no place.
    """
    count, times = costs.legs.shape[1], costs.legs.shape[3]
    most = times // grid.apart if grid.apart > 0 else count
    missions = max(1, min(missions, count, most, expense.most_missions))
    drawn = np.random.default_rng(seed).permutation(count)
    when = ((np.arange(missions) + 0.5) * times / missions).astype(np.int64)
    pieces = [
        Piece([one], [at]) for one, at in zip(drawn[:missions].tolist(), when.tolist(), strict=True)
    ]
    return completed(costs, grid, expense, pieces, drawn[missions:].copy())


def crossed(
    costs: TourCosts, grid: TimeGrid, expense: TourExpense, parents: tuple[Tour, Tour], seed: int
) -> Tour:
    """A tour of some missions of the first parent, and of the second around them.

    Raises
    ------
    NoPlace
        A target has no place.
    """
    random = np.random.default_rng(seed)
    one, other = (sorted(pieces_of(each), key=lambda piece: piece.at[0]) for each in parents)
    length = int(random.integers(1, max(2, len(one) // 2 + 1)))
    begin = int(random.integers(0, len(one) - length + 1))
    chosen = one[begin : begin + length]
    taken = {target for piece in chosen for target in piece.order}
    low, high = chosen[0].at[0], max(piece.at[-1] for piece in chosen)
    kept = []
    for piece in other:
        left = [
            (target, at)
            for target, at in zip(piece.order, piece.at, strict=True)
            if target not in taken and (at <= low - grid.apart or at >= high + grid.apart)
        ]
        # A mission about the span of time keeps its longer end.
        before = [each for each in left if each[1] <= low]
        after = [each for each in left if each[1] > low]
        left = max(before, after, key=len) if grid.apart > 0 else left
        if left:
            kept.append(Piece([target for target, _ in left], [at for _, at in left]))
    pieces = sorted([*chosen, *kept], key=lambda piece: piece.at[0])
    while len(pieces) > expense.most_missions:
        pieces.remove(min(pieces, key=lambda piece: len(piece.order)))
    there = {target for piece in pieces for target in piece.order}
    lacking = [target for target in range(costs.legs.shape[0]) if target not in there]
    return completed(costs, grid, expense, pieces, random.permutation(np.array(lacking, np.int64)))
