"""Subset-row cuts of a master: separation, prices, and the memory that walks need for them.

For three targets, at most one route of a plan services two of them or more; a mixture of routes may
take half of each of three (Jepsen, Petersen, Spoorendonk and Pisinger 2008). The master has the
whole cut. Labels pay for it only while they remember (:mod:`solvers.labels.row_cuts`), and if that
lets a route through which would have to pay, the memory of the cut grows along this route, as that
of targets does along cycles (limited memory: Pecin, Pessoa, Poggi and Uchoa 2017).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np

from adr_opt.mission.evidence import Cut

from ..labels.row_cuts import ROWS
from ..routes.route_pool import Column

VIOLATED = 0.05
"""Least violation of a new cut."""

PER_ROUND, PER_TARGET = 30, 6
"""Maximum number of new cuts at once, of all and of those with the same target."""

WHOLE = 1e-6
"""Tolerance within which a share in the mixture counts as one or zero."""

SMALL = 1e-9
"""Share in a mixture, and multiplier as a share of the largest prize, that count as zero."""

Rows = tuple[int, ...]


def times_paid(rows: Rows, targets: Iterable[int]) -> int:
    """How often a route of some targets counts in a cut."""
    return sum(j in rows for j in targets) // 2


def violated_rows(routes: Sequence[frozenset[int]], shares: np.ndarray, bodies: int) -> list[Rows]:
    """Three targets each of cuts that a mixture of routes violates, the worst first.

    Parameters
    ----------
    routes : sequence of frozenset of int
        Targets of each.
    shares : (routes,) float64
    bodies : int
    """
    mixed = np.flatnonzero(shares > SMALL)
    services = np.zeros((bodies, mixed.size))
    for column, at in enumerate(mixed.tolist()):
        services[sorted(routes[at]), column] = 1.0
    weighed = services * shares[mixed]
    both = weighed @ services.T
    rows, excess = [np.empty((0, ROWS), dtype=np.int64)], [np.empty(0)]
    for a in range(bodies):
        those = services[a] > 0.0
        # Once for a pair and twice for all three, so taken off twice.
        all_three = weighed[:, those] @ services[:, those].T
        found = both[a][:, None] + both[a][None, :] + both - 2.0 * all_three - 1.0
        b, c = np.nonzero(np.triu(found > VIOLATED, 1))
        after = b > a
        b, c = b[after], c[after]
        rows.append(np.stack([np.full_like(b, a), b, c], axis=1))
        excess.append(found[b, c])
    every, by = np.concatenate(rows), np.concatenate(excess)
    chosen: list[Rows] = []
    used = np.zeros(bodies, dtype=np.int64)
    # Rounded, so that the last digits of a solution do not choose between equals.
    for at in np.argsort(-np.round(by, 6), kind="stable"):
        if used[every[at]].max() < PER_TARGET:
            used[every[at]] += 1
            chosen.append(tuple(int(j) for j in every[at]))
            if len(chosen) == PER_ROUND:
                break
    return chosen


class SubsetRows:
    """The cuts of a master, in the order in which they were found.

    Attributes
    ----------
    rows : list of tuple of int
    """

    def __init__(self) -> None:
        self.rows: list[Rows] = []
        self._memory: list[set[int]] = []

    def add(self, rows: Iterable[Rows], routes: Iterable[tuple[int, ...]]) -> list[Rows]:
        """Add new cuts, with the memory that some routes need to pay them."""
        new = [each for each in rows if each not in self.rows]
        self.rows += new
        self._memory += [set(each) for each in new]
        for route in routes:
            self.remember(route, np.ones(len(self.rows)))
        return new

    def separate(self, columns: Sequence[Column], shares: np.ndarray, bodies: int) -> list[Rows]:
        """Add cuts that a mixture of columns violates; returns the new ones.

        Parameters
        ----------
        columns : sequence of Column
        shares : (columns,) float64
        bodies : int
        """
        violated = violated_rows([column.targets for column in columns], shares, bodies)
        return self.add(
            violated, [columns[at].route for at in np.flatnonzero(shares > WHOLE).tolist()]
        )

    def priced(self, multipliers: np.ndarray) -> tuple[Cut, ...]:
        """The cuts that have a multiplier.

        Parameters
        ----------
        multipliers : (cuts,) float64
        """
        return tuple(
            Cut(rows, frozenset(memory), float(multiplier))
            for rows, memory, multiplier in zip(self.rows, self._memory, multipliers, strict=True)
            if multiplier > 0.0
        )

    def paid(self, targets: frozenset[int], multipliers: np.ndarray) -> float:
        """Payment of a route of some targets for cuts."""
        return sum(
            float(multipliers[at]) * times_paid(self.rows[at], targets)
            for at in np.flatnonzero(multipliers)
        )

    def remember(self, route: Sequence[int], multipliers: np.ndarray) -> int:
        """Extend memories until a walk along a route pays all cuts that have a multiplier.

        Returns
        -------
        int
            By how many bodies they have grown.
        """
        grown = 0
        for cut in np.flatnonzero(multipliers):
            rows, memory = self.rows[cut], self._memory[cut]
            at = [place for place, body in enumerate(route) if body in rows]
            if len(at) < 2:
                continue
            needed = min((set(route[one:other]) - memory for one, other in pairwise(at)), key=len)
            memory |= needed
            grown += len(needed)
        return grown
