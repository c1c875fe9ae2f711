"""Drift legs in closed form: exact rates, whole laps, and the least sum of both burns.

Hours become days to months. The chaser leaves for a drift orbit whose node moves faster or slower,
waits there, and closes what is left on arrival. With y and z what the first burn changes of the
size and of the inclination, v_y and v_z all there is to change, and X what is then left of the node
on arrival, all in m/s, a leg costs (sizes are differences of circular speeds, V_i − V(r), which a
Hohmann transfer costs to second order in the change of radius)

    ΔV = min over (y, z) of hypot( X(y, z), N₁ + N₂ ),
    N₁ = hypot(y, z, E),    N₂ = hypot(v_y − y, v_z − z, E),

E being what the eccentricity vectors ask for at either end. The node is split between both burns in
proportion to N₁ and N₂, which makes the sum of the two burns least. X counts the rates of the node
*on* the drift orbit and on the half ellipses beside it, Ω̇(a, i), instead of changes in proportion.

The chaser has to meet the target, too, so the drift orbit makes a whole number of laps more or less
than the target. In longitudes λ = u + Ω cos ī, with half ellipses of t_1, t_2 and t_3 (out, back to
the co-elliptic orbit, and to the stand-off), T_c = T − t_1 − t_2 − t_3 − approach of them all,

    λ_i(t_s) + Σ (π + Ω̇ cos ī t_h) + λ̇(r) T_c = λ_j(t_f − approach) − lead − 2πk,

which leaves radii r_k a comb apart. The leg takes the cheaper of the two teeth about the optimum of
free phase. Teeth are half a lap away at most, which is 90 m/s for a leg of a day and 1 m/s for one
of three months.
"""

import numpy as np

from ..core.compile import kernel
from . import drift_pair
from .drift_free import first_guess, free_phase
from .drift_laps import split


@kernel
def split_of(pair, task):
    """Split of a drift leg, solved from its first guess."""
    climb, tilt = first_guess(pair, task)
    return split(pair, task, free_phase(pair, task, climb, tilt))


@kernel
def best_split(pair, departure, arrival):
    """Best split of the drift leg between two times."""
    return split_of(pair, drift_pair.task(pair, departure, arrival))


@kernel
def delta_v(pair, departure, arrival):
    """ΔV of the drift leg between two times, infinite if the target cannot be met [m/s]."""
    return best_split(pair, departure, arrival).delta_v


@kernel
def shape_share(pair, departure, arrival):
    """ΔV due to eccentricity: the excess over the same leg between circles [m/s]."""
    leg = drift_pair.task(pair, departure, arrival)
    circles = drift_pair.task_of(pair, departure, arrival, 0.0)
    return max(split_of(pair, leg).delta_v - split_of(pair, circles).delta_v, 0.0)


@kernel
def splits(pair, departures, arrivals):
    """Splits of the drift legs between given departures and arrivals.

    Parameters
    ----------
    pair : DriftPair
    departures : (d,) float64
    arrivals : (a,) float64
        [s].

    Returns
    -------
    (d, a, 4) float64
        The fields of :class:`Split` [m/s].
    """
    found = np.empty((departures.size, arrivals.size, 4))
    for d in range(departures.size):
        for a in range(arrivals.size):
            each = best_split(pair, departures[d], arrivals[a])
            found[d, a, 0], found[d, a, 1] = each.delta_v, each.climb
            found[d, a, 2], found[d, a, 3] = each.tilt, each.along
    return found
