"""Altitude against time, with phases and keep-out zones."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ....plan.plan import Plan
from ....problem.instance import Instance
from ...plot.chart import Box, Series
from ...plot.heights import altitude_chart, zones
from ...plot.tracks import Track
from ..text import number
from .parts import Figure, figure, named, of_arcs, period, said, time_axis


def altitude(instance: Instance, plan: Plan, tracks: tuple[Track, ...]) -> Figure:
    """The chaser's altitude in km against days, one trace per phase; zones as boxes beneath.

    Where there are several chasers, each has traces and a colour of its own.
    """

    def more(one: Series) -> dict[str, Any]:
        if not isinstance(one, Box):
            return of_arcs(one, "<br>%{y:.1f} km at day %{x:.3f}")
        (zone,), (low, high) = one.of, one.y
        text = f"keep-out zone {number(low)}–{number(high)} km<br>"
        return named(instance, False) | said(text + period(zone.start_s, zone.end_s))

    chart = altitude_chart(instance, plan, tracks, by_chaser=True)
    chart = replace(chart, series=(*chart.series, *zones(instance)))
    return figure(chart, more, xaxis=time_axis(instance, plan), **named(instance, True))
