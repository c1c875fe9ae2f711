"""Keep-out zones, drawn independently of the field (docs/model.md section 6)."""

from __future__ import annotations

from ...common.constants import HOUR_S
from ...problem.settings import KeepOutZone
from .stream import stream

PURPOSE = 1
"""Number of the stream: zones leave the field of a seed unchanged."""

ZONE_ALTITUDE_KM = (680.0, 830.0)
ZONE_THICKNESS_KM = (10.0, 25.0)
ZONE_LENGTH_H = (6.0, 24.0)


def draw_zones(seed: int, count: int, duration_s: float) -> tuple[KeepOutZone, ...]:
    """Keep-out zones within 680–830 km, 10–25 km thick, 6–24 h long (docs/model.md section 6)."""
    uniform = stream(seed, PURPOSE)
    zones = []
    for _ in range(count):
        thickness = uniform(*ZONE_THICKNESS_KM)
        bottom = uniform(ZONE_ALTITUDE_KM[0], ZONE_ALTITUDE_KM[1] - thickness)
        length = HOUR_S * uniform(*ZONE_LENGTH_H)
        start = uniform(0.0, max(0.0, duration_s - length))
        zones.append(
            KeepOutZone(
                min_altitude_m=round(1e3 * bottom, 3),
                max_altitude_m=round(1e3 * (bottom + thickness), 3),
                start_s=round(start, 3),
                end_s=round(start + length, 3),
            )
        )
    return tuple(zones)
