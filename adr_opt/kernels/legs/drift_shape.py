"""Price of a drift leg by free burns, from the difference of the eccentricity vectors.

At either end burns ahead that change the speed by y change the eccentricity vector by as much as
V̄ |Δe| / 2 = y at no cost, in whichever direction (docs/model.md section 3.6). So with
n₁ + n₂ = max(|y| + |v_y − y|, V̄ |Δe| / 2) in the plane of the orbit, drifts are split where

    M = hypot( X, hypot(n₁, z) + hypot(n₂, v_z − z) )

is least. The component of Δe across the line on which the plane is turned takes burns along the
radius, which ride on the turn or outgrow it, as in :mod:`.free_burns`: the price is M with that.
"""

import math

from ..core.compile import inlined
from .free_burns import ROOT_3

CLOSER_M_S = 1e-10
"""As CLOSE_M_S of :mod:`.drift`, where the price is not what is least at the split [m/s]."""


@inlined
def in_plane(pair, shape, climb):
    """Squares of the in-plane ΔV at either end, for a y [m²/s²].

    Parameters
    ----------
    pair : DriftPair
    shape, climb : float
        E and y [m/s].
    """
    rest = pair.climb - climb
    if not pair.free:
        return climb * climb + shape * shape, rest * rest + shape * shape
    one, other = abs(climb), abs(rest)
    more = max(shape - 0.5 * (one + other), 0.0)
    return (one + more) * (one + more), (other + more) * (other + more)


@inlined
def directed(pair, task, climb, node, turn):
    """Price of a split by its M [m/s].

    Parameters
    ----------
    pair : DriftPair
    task : Task
    climb, node, turn : float
        y, X and N₁ + N₂ [m/s].
    """
    tilt, square = pair.linear.tilt, node * node + turn * turn
    line = node * node + tilt * tilt
    if line == 0.0 or task.shape == 0.0:
        return math.sqrt(square)
    # V̄ / 2 times the part of Δe across the line on which plane and node are turned.
    side = abs(tilt * task.shape_y - node * task.shape_x) / math.sqrt(line)
    planar = max(abs(climb) + abs(pair.climb - climb), 2.0 * task.shape)
    theta = max(square - planar * planar, 0.0)
    apart = side + 0.5 * ROOT_3 * math.sqrt(theta)
    ridden = 4.0 * side * side + theta if 12.0 * side * side < theta else apart * apart
    return math.sqrt(square + side / planar * (ridden - side * side - theta))
