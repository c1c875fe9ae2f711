"""Observations as defined in the published study.

Visited mask, ΔV and time left, six elements of the chaser and of every target, which
:data:`PUBLISHED_ELEMENTS` names in order, with unit and scale.
"""

import math

from ..core.compile import kernel
from ..core.memory import borrowed
from ..orbits.ephemeris import inclination_at, latitude_at, node_at, radius_at
from .choice_rows import clip, turned
from .choices import DEGREES, LIMIT, PER_50_KM
from .episodes import BODIES, HOME, make_mask

PUBLISHED_ELEMENTS = (
    "semi-major axis less the station's [50 km]",
    "eccentricity",
    "inclination less the station's [deg]",
    "RAAN less the station's [deg]",
    "argument of perigee [half turns]",
    "true anomaly now [half turns]",
)


@kernel
def observe_published(pool, episodes, order, first, last, out, mask, legal):
    """Observations ``published`` of the episodes ``order[first:last]``.

    Parameters
    ----------
    order : (episodes,) int32
    out : (episodes, 7·targets + 8) float32
        Written: visited (targets), ΔV left / budget, time left / duration, six elements of the
        chaser, six of each target; elements as :data:`PUBLISHED_ELEMENTS`.
    mask : (episodes, actions) bool
        Written: legal actions.
    legal : (episodes,) int32
        Written: number of legal actions.
    """
    pool, episodes = borrowed(pool), borrowed(episodes)
    out, mask, legal = borrowed(out), borrowed(mask), borrowed(legal)
    targets = mask.shape[1] - 1
    for place in range(first, last):
        e = order[place]
        slot = episodes.slot[e]
        legal[e] = make_mask(pool, episodes, e, mask[e])
        for j in range(targets):
            out[e, j] = 1.0 if episodes.visited[e, j + 1] else 0.0
        out[e, targets] = clip(episodes.left[e] / episodes.budget[e], 0.0, LIMIT)
        out[e, targets + 1] = clip(1.0 - episodes.time[e] / episodes.duration[e], 0.0, LIMIT)
        orbits = pool.orbits[slot]
        for row in range(targets + 1):
            j = episodes.body[e] if row == 0 else row
            at = targets + 2 + 6 * row
            # Rows beyond a field are zero, so that one network takes fields of every size.
            if j >= pool.counts[slot, BODIES]:
                for column in range(6):
                    out[e, at + column] = 0.0
                continue
            now = episodes.time[e]
            orbit, home = orbits[j], orbits[HOME]
            u = latitude_at(orbit, now)
            radius = radius_at(orbit, now) - radius_at(home, now)
            inclination = inclination_at(orbit, now) - inclination_at(home, now)
            raan = turned(node_at(orbit, now) - node_at(home, now))
            out[e, at] = clip(radius * PER_50_KM, -LIMIT, LIMIT)
            # Bodies move on circles (docs/model.md section 1): e and the perigee are 0, ν is u.
            out[e, at + 1] = 0.0
            out[e, at + 2] = clip(inclination * DEGREES, -LIMIT, LIMIT)
            out[e, at + 3] = clip(raan * DEGREES, -LIMIT, LIMIT)
            out[e, at + 4] = 0.0
            out[e, at + 5] = clip(turned(u) / math.pi, -1.0, 1.0)
