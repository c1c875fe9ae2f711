"""The arcs of a drift leg: out, drift, back to the co-elliptic orbit, and to the stand-off."""

import math
from typing import NamedTuple

from ...common.constants import MU_M3_S2
from ..core.compile import inlined


class Coast(NamedTuple):
    """The arcs of a drift leg with a given radius of the drift orbit.

    Attributes
    ----------
    drift : float
        Time on the drift orbit [s].
    node_out, node_drift, node_back, node_end : float
        How far the node of an equatorial orbit moves on each arc, which cos i is a factor of [rad].
    phase, phase_slope : float
        Longitude gained until the stand-off [rad], and its derivative by the radius [rad/m].
    longer : float
        Time that the other arcs take more, per radius [s/m].
    per_out, per_back, per_end : float
        Change of their semi-major axes, as a share of them, per radius [1/m].
    """

    drift: float
    node_out: float
    node_drift: float
    node_back: float
    node_end: float
    phase: float
    phase_slope: float
    longer: float
    per_out: float
    per_back: float
    per_end: float


class NodeSeries(NamedTuple):
    """Node difference left to close, as a function of the first burn's change of inclination.

    A polynomial of that change [rad], up to the fifth power, over −V̄ sin ī [rad].
    """

    p0: float
    p1: float
    p2: float
    p3: float
    p4: float
    p5: float


@inlined
def node_at(series, more):
    """Value of a :class:`NodeSeries` for a change of inclination [rad]."""
    p0, p1, p2, p3, p4, p5 = series
    return p0 + more * (p1 + more * (p2 + more * (p3 + more * (p4 + more * p5))))


@inlined
def rates_on(pair, axis):
    """Mean motion with a semi-major axis [rad/s], 1.5 J2 (R/a)², and 1 / a [1/m]."""
    inverse = 1.0 / axis
    motion = math.sqrt(MU_M3_S2 * inverse) * inverse
    return motion, 1.5 * pair.oblateness * inverse * inverse, inverse


@inlined
def half_turn(pair, axis):
    """Time of half a turn [s], its advance of the node times −1 / cos i [rad], and 1 / a [1/m]."""
    motion, pull, inverse = rates_on(pair, axis)
    time = math.pi / (motion * (1.0 + pull * (4.0 * pair.cosine * pair.cosine - 1.0)))
    return time, pull * motion * time, inverse


@inlined
def coast(pair, span, radius):
    """The arcs of a leg with a given radius of the drift orbit and inclination ī in the phase."""
    rj, fraction = pair.linear.radius_j, pair.fraction
    co_elliptic = radius + fraction * (rj - radius)
    out, node_out, per_out = half_turn(pair, 0.5 * (pair.linear.radius_i + radius))
    back, node_back, per_back = half_turn(pair, 0.5 * (radius + co_elliptic))
    end, node_end, per_end = half_turn(pair, 0.5 * (co_elliptic + rj))
    drifting = span - pair.approach - out - back - end
    motion, pull, inverse = rates_on(pair, radius)
    square = pair.cosine * pair.cosine
    pulled = pull * (3.0 * square - 1.0)
    rate = motion * (1.0 + pulled)
    per_out, per_back = 0.5 * per_out, (1.0 - 0.5 * fraction) * per_back
    per_end *= 0.5 * (1.0 - fraction)
    longer = 1.5 * (out * per_out + back * per_back + end * per_end)
    # An arc that takes longer leaves less time to drift.
    slope = -rate * longer - 1.5 * motion * (1.0 + pulled * (7.0 / 3.0)) * drifting * inverse
    phase = 3.0 * math.pi - square * (node_out + node_back + node_end) + rate * drifting
    return Coast(
        drifting,
        -node_out,
        -pull * motion * drifting,
        -node_back,
        -node_end,
        phase,
        slope,
        longer,
        per_out,
        per_back,
        per_end,
    )


@inlined
def moved(arcs, radius, step):
    """The same arcs with a slightly different radius, phase excluded.

    The error is of the second order in the step for the arcs beside the drift, and of the fourth
    for the drift.
    """
    share = step / radius
    drifting = arcs.drift - arcs.longer * step
    # Rates of nodes are as radii to the power of −3.5, their ways on half turns as that of −2.
    scale = drifting / arcs.drift
    scale *= 1.0 - 3.5 * share * (1.0 - 2.25 * share * (1.0 - (11.0 / 6.0) * share))
    twice = -2.0 * step
    return Coast(
        drifting,
        arcs.node_out * (1.0 + twice * arcs.per_out),
        arcs.node_drift * scale,
        arcs.node_back * (1.0 + twice * arcs.per_back),
        arcs.node_end * (1.0 + twice * arcs.per_end),
        arcs.phase,
        arcs.phase_slope,
        arcs.longer,
        arcs.per_out,
        arcs.per_back,
        arcs.per_end,
    )
