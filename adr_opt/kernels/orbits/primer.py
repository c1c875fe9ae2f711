"""Directions and places of low thrust: those of the primer vector on a circle.

What a small thrust does to a circular orbit in a revolution is, by Gauss's equations,

    ȧ = 2a/V · T,  ė_x = (2 T cos u + R sin u)/V,  ė_y = (2 T sin u − R cos u)/V,
    i̇ = N cos u / V,  Ω̇ sin i = N sin u / V,

with R outward, T ahead, N along the momentum, and u the argument of latitude. The ΔV of a wanted
change of all five is least where thrust has the direction of

    p(u) = (A sin u − B cos u,  C + 2 (A cos u + B sin u),  D cos u + E sin u)

and is on where p is longest (D. F. Lawden, Optimal Trajectories for Space Navigation, 1963, chapter
5; J.-P. Marec, Optimal Space Trajectories, 1979, section 5). The five numbers are a *law*: A and B
change the eccentricity, C the size, D and E the plane.
"""

import math

from ..core.compile import inlined, kernel

PEAK_SAMPLES = 90
"""Number of places searched for the longest primer vector."""


@inlined
def pushed(law, u):
    """The vector p at an argument of latitude: outward, ahead, and along the momentum."""
    c, s = math.cos(u), math.sin(u)
    return (
        law[0] * s - law[1] * c,
        law[2] + 2.0 * (law[0] * c + law[1] * s),
        law[3] * c + law[4] * s,
    )


@inlined
def length(law, u):
    """Length of p at an argument of latitude."""
    radial, along, across = pushed(law, u)
    return math.sqrt(radial * radial + along * along + across * across)


@kernel
def peak(law):
    """Largest length of p on a revolution.

    Parameters
    ----------
    law : (5,) float64
        A to E.
    """
    step = 2.0 * math.pi / PEAK_SAMPLES
    best = 0
    highest = -1.0
    for at in range(PEAK_SAMPLES):
        found = length(law, at * step)
        if found > highest:
            best, highest = at, found
    # Between samples by a parabola: the peak is then smooth in the law.
    before, after = length(law, (best - 1) * step), length(law, (best + 1) * step)
    curved = before - 2.0 * highest + after
    return highest - 0.125 * (after - before) ** 2 / curved if curved < 0.0 else highest
