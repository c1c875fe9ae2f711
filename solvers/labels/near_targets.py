"""What walks remember before any search: at each body the targets nearest to it.

Cycles that are worth flying are short, so a walk that returns to a target does so by bodies near to
it. Where those remember it from the first search on, fewer searches are needed to learn that
(ng-routes: Baldacci, Mingozzi and Roberti 2011).
"""

from __future__ import annotations

import numpy as np

from adr_opt.mission.evidence import WORD

from ..networks.arrays import Network

REMEMBERED = 8
"""Number of targets remembered at each body."""


def remember_near(
    neighbourhood: np.ndarray, network: Network, first_target: int, m_s_per_s: float
) -> None:
    """Add the nearest targets to the memory at each body.

    Parameters
    ----------
    neighbourhood : (bodies, words) int64
        What walks remember at each body; written.
    network : Network
    first_target : int
    m_s_per_s : float
        Price of time: as near as two bodies is the cheapest leg between them, either way.
    """
    bodies = network.start.size - 1
    row = np.repeat(np.arange(network.departure.size), np.diff(network.first))
    origin = np.repeat(np.arange(bodies), np.diff(network.start))[row]
    taken_s = network.departure[network.landing] - network.departure[row]
    goes_on = np.isfinite(taken_s)  # after the others nothing leaves any more
    legs = network.delta_v[goes_on] + m_s_per_s * taken_s[goes_on]
    cost = np.full((bodies, bodies), np.inf)
    np.minimum.at(cost, (origin[goes_on], network.destination[row][goes_on]), legs)
    cost = np.minimum(cost, cost.T)[:, first_target:]
    for body in range(bodies):
        near = np.argsort(cost[body], kind="stable")[:REMEMBERED]
        for j in first_target + near[np.isfinite(cost[body, near])]:
            neighbourhood[body, j // WORD] |= np.int64(1) << np.int64(j % WORD)
