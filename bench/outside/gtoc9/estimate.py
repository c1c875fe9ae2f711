"""The ΔV of legs of GTOC9 by the closed form of long transfers.

The first order of what planning is done with: :mod:`adr_opt.kernels.legs.drift` (docs/model.md
section 3) between mean orbits with secular J2 rates. No phase and no flight: J of this estimate and
J of a flown plan are two figures.
"""

from __future__ import annotations

from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, OBLATENESS_M2
from adr_opt.kernels.legs import drift_linear as drift

from ..reading import FloatArray
from .campaign import Removals

LIMITS_M = 6600e3, EARTH_RADIUS_M + 2000e3
"""Limits of the drift orbit, as radii. The contest asks for perigees above 6600 km; there is no
other limit in it, and none of the winning legs comes near this upper one."""


def legs_m_s(mission: Removals, rows: FloatArray) -> tuple[float, ...]:
    """ΔV of the legs of a mission at its times, by the estimate."""
    found = []
    for one, other in zip(mission.stops[:-1], mission.stops[1:], strict=True):
        pair = drift.prepare(rows[one.debris], rows[other.debris], *LIMITS_M, OBLATENESS_M2, 0.0)
        times = one.departure_d * DAY_S, other.arrival_d * DAY_S
        found.append(float(drift.delta_v(pair, *times)))
    return tuple(found)
