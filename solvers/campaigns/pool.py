"""Routes that were met, and the best plan that can be put together from them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import csc_array

from adr_opt.campaign import Campaign, Routes

LEAST_COST = 1e-3
"""Of two choices worth the same the cheaper one: all costs together count for less than so many
steps of prize."""


@dataclass(frozen=True)
class Column:
    """A route that a chaser of a kind can fly.

    Attributes
    ----------
    kind : int
    targets : frozenset of int
    worth, cost : float
    route : tuple of int
    """

    kind: int
    targets: frozenset[int]
    worth: float
    cost: float
    route: tuple[int, ...]


def packing(campaign: Campaign, columns: Sequence[tuple[int, frozenset[int]]]) -> LinearConstraint:
    """No target on two of the columns taken, and no more of a kind than there are chasers.

    Parameters
    ----------
    campaign : Campaign
    columns : sequence of (kind, targets)
    """
    bodies, kinds = len(campaign.names), len(campaign.kinds)
    rows, ends = [], [0]
    for kind, targets in columns:
        rows += [*sorted(targets), bodies + kind]
        ends.append(len(rows))
    matrix = csc_array(
        (np.ones(len(rows)), np.array(rows), np.array(ends)), shape=(bodies + kinds, len(columns))
    )
    most = np.ones(bodies + kinds)
    most[bodies:] = [len(kind.chasers) for kind in campaign.kinds]
    return LinearConstraint(matrix, -np.inf, most)


def dealt(campaign: Campaign, flown: Iterable[tuple[int, tuple[int, ...]]]) -> Routes:
    """Routes of kinds given to chasers of these kinds; nothing to the others."""
    routes: list[tuple[int, ...]] = [()] * len(campaign.missions)
    free = [list(kind.chasers) for kind in campaign.kinds]
    for kind, route in flown:
        routes[free[kind].pop(0)] = route
    return tuple(routes)


class Pool:
    """The cheapest route met for each set of targets and kind of chaser.

    Parameters
    ----------
    campaign : Campaign
    """

    def __init__(self, campaign: Campaign) -> None:
        self._campaign = campaign
        self._first = campaign.instance.first_target
        self._columns: dict[tuple[int, frozenset[int]], Column] = {}

    def columns(self) -> list[Column]:
        """All of them, in the order in which their sets were met."""
        return list(self._columns.values())

    def take(self, other: Pool) -> None:
        """Keep the routes of another pool that are new or cheaper."""
        for column in other.columns():
            known = self._columns.get((column.kind, column.targets))
            if known is None or column.cost < known.cost:
                self._columns[column.kind, column.targets] = column

    def add(self, kind: int, route: Iterable[int]) -> Column | None:
        """Keep a route that a chaser of a kind can fly to an end; None if it cannot."""
        mission = self._campaign.kinds[kind].mission
        moves = mission.closed(route)
        targets = frozenset(j for j in moves if j >= self._first)
        known = self._columns.get((kind, targets))
        if known is not None and known.route == moves:
            return known
        schedule = mission.time(moves)
        if schedule.made < len(moves) or not mission.may_stop(moves):
            return None
        if known is not None and known.cost <= schedule.cost:
            return known
        column = Column(kind, targets, self._campaign.collected(targets), schedule.cost, moves)
        self._columns[kind, targets] = column
        return column

    def best(self, columns: Sequence[Column], time_limit_s: float) -> Routes | None:
        """The plan worth most that some columns make, by set packing with HiGHS.

        Parameters
        ----------
        columns : sequence of Column
        time_limit_s : float
            Then the best so far, if there is one.
        """
        if not columns or time_limit_s <= 0.0:
            return None
        campaign = self._campaign
        step = campaign.prize_step or 1e-3 * max(column.worth for column in columns) or 1.0
        chasers = len(campaign.missions)
        dearest = math.fsum(sorted(column.cost for column in columns)[-chasers:])
        price = LEAST_COST * step / max(dearest, 1e-9)
        gain = np.array([column.worth - price * column.cost for column in columns])
        found = milp(
            -gain,
            integrality=np.ones(len(columns)),
            bounds=Bounds(0.0, 1.0),
            constraints=packing(campaign, [(column.kind, column.targets) for column in columns]),
            options={"time_limit": time_limit_s},
        )
        if found.x is None:
            return None
        taken = [columns[at] for at in np.flatnonzero(found.x > 0.5).tolist()]
        return dealt(self._campaign, [(column.kind, column.route) for column in taken])
