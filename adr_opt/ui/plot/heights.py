"""Altitude against time."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...common.constants import DAY_S
from ...fly.trajectory.kepler import Array
from ...plan.palette import ZONE
from ...plan.plan import Plan
from ...problem.instance import Instance
from .chart import DAYS, KM_M, Box, Chart, ChartAxis, days
from .draw import draw
from .strands import DrawnArc, strands

ALTITUDES = ChartAxis("altitude [km]")


def altitude_chart(
    instance: Instance, plan: Plan, tracks: tuple[DrawnArc, ...], *, by_chaser: bool
) -> Chart:
    """Altitudes of flown arcs [km] against days; ``by_chaser`` as in :func:`.strands`."""

    def course(track: DrawnArc) -> Array:
        return np.column_stack([days(track.times_s), track.altitudes_m / KM_M])

    lines = strands(instance, plan, tracks, course, 1.8, by_chaser=by_chaser)
    return Chart(tuple(lines), DAYS, ALTITUDES)


def zones(instance: Instance) -> tuple[Box, ...]:
    """The keep-out zones as boxes."""
    return tuple(
        Box(
            name="keep-out zone",
            colour=ZONE,
            phase="zone",
            of=(zone,),
            x=(zone.start_s / DAY_S, zone.end_s / DAY_S),
            y=(zone.min_altitude_m / KM_M, zone.max_altitude_m / KM_M),
        )
        for zone in instance.keep_out_zones
    )


def keep_out_zones(ax: Any, instance: Instance) -> Any:
    """Add the keep-out zones as shaded boxes, altitude [km] against time [days]."""
    return draw(ax, Chart(zones(instance), DAYS, ALTITUDES))
