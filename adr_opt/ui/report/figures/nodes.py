"""Nodes against time, with the arcs on which the chaser drifts."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....plan.plan import Plan
from ....problem.instance import Instance
from ...plot.chart import Series
from ...plot.nodes import nodes_chart
from ...plot.tracks import Track
from ..text import in_chart
from .parts import Figure, figure, named, of_arcs, said, time_axis

LEAST_ROOM_DEG = 0.05


def nodes(instance: Instance, plan: Plan, tracks: tuple[Track, ...]) -> Figure:
    """RAAN in degrees against days, less the common drift; bodies thin, the chaser thick."""

    def more(one: Series) -> dict[str, Any]:
        if not one.of:
            return of_arcs(one, "<br>%{y:.2f}° at day %{x:.2f}")
        names = [in_chart(name) for name in one.of]
        return {"opacity": 0.75} | said("%{text}<br>%{y:.2f}° at day %{x:.2f}", names)

    chart = nodes_chart(instance, plan, tracks, by_chaser=True)
    return figure(
        chart, more, xaxis=time_axis(instance, plan), yaxis=_range(chart.series),
        **named(instance, True),
    )  # fmt: skip


def _range(lines: tuple[Series, ...]) -> dict[str, Any]:
    """Where the chaser and the bodies that it goes to are; of the others what is near them."""
    near = np.concatenate([np.empty(0), *(one.y for one in lines if one.name != "not visited")])
    near = np.round(near[~np.isnan(near)], 4)
    if not near.size:
        return {}
    low, high = float(near.min()), float(near.max())
    room = max(0.08 * (high - low), LEAST_ROOM_DEG)
    return {"range": [round(low - room, 4), round(high + room, 4)]}
