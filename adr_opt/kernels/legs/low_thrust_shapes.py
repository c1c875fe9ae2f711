"""What eccentricities ask for on a low-thrust leg.

Thrust along the orbit in windows of which a part lies in the shadow makes the orbit eccentric. An
arc that changes the speed by y adds 2 y c / V to the eccentricity vector, c being the mean of
(cos u, sin u) over the places at which thrust is on. What is left of the vector w that both arcs
have to make up for, in m/s, takes thrust in other directions besides. With the mean of the square
of the primer vector in place of that of its length (:mod:`..orbits.primer`), its cost and that of
the rest add up as

    ΔV² = f² + w · S⁻¹ w,    S = mean of 5/2 + 3/2 Q(u) − 4 c c',    Q(u) = (cos 2u,  sin 2u;
                                                                             sin 2u, −cos 2u),

f being the ΔV without it, and S over all places in sunlight. With w linear in y, the second term is
a parabola (docs/model.md section 11.7).
"""

import math
from typing import NamedTuple

from ..core.compile import inlined
from .drift_free import Bowl

STEEP = 1e-9
"""Least steepness of a parabola: below it what arcs do cancels out, or there is no shadow."""


class Metric(NamedTuple):
    """A symmetric matrix of two rows."""

    xx: float
    xy: float
    yy: float


class Shapes(NamedTuple):
    """Eccentricities of a leg, in the frame of the node, as they are turned until its arrival.

    Attributes
    ----------
    left_x, left_y : float
        What the eccentricity vector has to change by on arrival if there is no thrust [m/s].
    first, second : (float, float)
        Cosine and sine of the place of thrust of each arc, as turned.
    room : Metric
        S.
    """

    left_x: float
    left_y: float
    first: tuple[float, float]
    second: tuple[float, float]
    room: Metric


@inlined
def room(shadow, turn, share):
    """S of places in sunlight on an orbit whose perigee turns by an angle, times a share."""
    middle = 2.0 * (shadow.middle + turn)
    lit = 1.0 / (math.pi - shadow.half)
    c = math.sin(shadow.half) * lit
    beyond = 0.75 * math.sin(2.0 * shadow.half) * lit + 2.0 * c * c
    level, aside = share * (2.5 - 2.0 * c * c), share * beyond
    along, across = aside * math.cos(middle), aside * math.sin(middle)
    return Metric(level - along, -across, level + along)


@inlined
def bowl(shapes, one, other, climb):
    """The parabola in what the first arc changes of the speed.

    Parameters
    ----------
    shapes : Shapes
    one, other : Lit
        Windows of both arcs.
    climb : float
        What both change [m/s].
    """
    c, s = shapes.first
    x1, y1 = one.toward * c - one.aside * s, one.toward * s + one.aside * c
    c, s = shapes.second
    x2, y2 = other.toward * c - other.aside * s, other.toward * s + other.aside * c
    x, y = 2.0 * (x2 - x1), 2.0 * (y2 - y1)
    x0, y0 = shapes.left_x - 2.0 * x2 * climb, shapes.left_y - 2.0 * y2 * climb
    xx, xy, yy = shapes.room
    per = 1.0 / (xx * yy - xy * xy)
    steepness = per * (yy * x * x - 2.0 * xy * x * y + xx * y * y)
    slope = per * (yy * x * x0 - xy * (x * y0 + x0 * y) + xx * y * y0)
    whole = per * (yy * x0 * x0 - 2.0 * xy * x0 * y0 + xx * y0 * y0)
    if steepness < STEEP:
        return Bowl(0.0, 0.0, whole)
    bottom = -slope / steepness
    return Bowl(steepness, bottom, max(whole + slope * bottom, 0.0))
