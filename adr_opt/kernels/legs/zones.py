"""Whether a keep-out zone forbids a sequence (docs/model.md section 6)."""

import math

from ...common.constants import TURN_RAD
from ..core.compile import kernel
from ..core.memory import borrowed
from .co_elliptic import SQRT_MU, lap_time, pace


@kernel
def half_ellipse_clock(r1, r2, r):
    """Share of a half ellipse's time, from apsis r1 to apsis r2, that passes from r1 to r."""
    e = abs(r2 - r1) / (r1 + r2)
    if e == 0.0:
        return 0.0
    # (1 − r/a) / e without its cancellation, which costs seconds on nearly circular arcs.
    cosine = min(1.0, max(-1.0, ((r1 - r) + (r2 - r)) / abs(r2 - r1)))
    anomaly = math.acos(cosine)
    since_perigee = (anomaly - e * math.sin(anomaly)) / math.pi
    return since_perigee if r2 > r1 else 1.0 - since_perigee


@kernel
def half_ellipse_meets(r1, r2, start, end, zone):
    """Whether a half ellipse flown from start to end is ever in an active zone."""
    low, high = zone[0], zone[1]
    if max(r1, r2) < low or min(r1, r2) > high or end < zone[2] or start > zone[3]:
        return False
    if r1 == r2:
        return True
    # The radius is monotone along the arc, so the stay in the band is one closed interval.
    first = start + (end - start) * half_ellipse_clock(r1, r2, min(max(r1, low), high))
    last = start + (end - start) * half_ellipse_clock(r1, r2, min(max(r2, low), high))
    return first <= zone[3] and last >= zone[2]


@kernel
def is_blocked(pair, rule, revolutions, r, departure):
    """Whether a keep-out zone forbids the sequence (docs/model.md section 6).

    The zones are closed in altitude and in time. The arcs and the phasing circle are tested
    moment by moment: an arc is blocked only if it is inside the band while the window is open.
    The approach is flown on the target's own orbit; it counts from stand-off to arrival.
    """
    ri, rj = pair.radius_i, pair.radius_j
    rc = r + rule.first_leg_fraction * (rj - r)
    scale = math.pi / SQRT_MU
    a1, a2, a3 = 0.5 * (ri + r), 0.5 * (r + rc), 0.5 * (rc + rj)
    t1 = departure + scale * a1 * math.sqrt(a1) * pace(a1, pair.widening_i)
    t2 = t1 + revolutions * lap_time(r, pair.widening_j)[0]
    t3 = t2 + scale * a2 * math.sqrt(a2) * pace(a2, pair.widening_j)
    t4 = t3 + scale * a3 * math.sqrt(a3) * pace(a3, pair.widening_j)
    t5 = t4 + rule.approach_revolutions * TURN_RAD / pair.rate_j
    zones = borrowed(rule.zones)
    for z in range(zones.shape[0]):
        zone = zones[z]
        if t5 < zone[2] or departure > zone[3]:
            continue
        if zone[0] <= r <= zone[1] and t1 <= zone[3] and t2 >= zone[2]:
            return True
        if zone[0] <= rj <= zone[1] and t4 <= zone[3] and t5 >= zone[2]:
            return True
        if (
            half_ellipse_meets(ri, r, departure, t1, zone)
            or half_ellipse_meets(r, rc, t2, t3, zone)
            or half_ellipse_meets(rc, rj, t3, t4, zone)
        ):
            return True
    return False


@kernel
def any_closed(zones, start, end):
    """Whether any zone is active during a flight."""
    zones, closed = borrowed(zones), False
    for z in range(zones.shape[0]):
        closed = closed or (zones[z, 2] <= end and start <= zones[z, 3])
    return closed
