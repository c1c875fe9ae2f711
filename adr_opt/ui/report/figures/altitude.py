"""Altitude against time, with phases and keep-out zones."""

from __future__ import annotations

from ....common.constants import DAY_S
from ....plan.palette import LABELS, ZONE
from ....plan.plan import Plan
from ....problem.instance import Instance
from ...plot.axes import KM_M
from ...plot.tracks import Track, joined
from ..text import number
from .parts import Figure, column, days, legend, named, period, repeated, strands, time_axis


def altitude(instance: Instance, plan: Plan, tracks: tuple[Track, ...]) -> Figure:
    """The chaser's altitude in km against days, one trace per phase; zones as boxes beneath.

    Where there are several chasers, each has traces and a colour of its own.
    """
    traces = legend(instance)
    for phase, found, colour, about in strands(instance, plan, tracks):
        lengths = [len(track.times_s) for track in found]
        traces.append(
            {
                "type": "scatter", "mode": "lines", **about,
                "x": days(joined([track.times_s for track in found])),
                "y": column(joined([track.altitudes_m for track in found]) / KM_M, 2),
                "customdata": repeated([track.leg for track in found], lengths),
                "line": {"color": colour, "width": 1.8},
                "hovertemplate": f"{LABELS[phase]}, %{{text}}<br>%{{y:.1f}} km at day %{{x:.3f}}"
                "<extra></extra>",
            }
        )  # fmt: skip
    shapes = []
    for zone in instance.keep_out_zones:
        x = [zone.start_s / DAY_S, zone.end_s / DAY_S]
        y = [zone.min_altitude_m / KM_M, zone.max_altitude_m / KM_M]
        shapes.append(
            {
                "type": "rect", "layer": "below", "x0": x[0], "x1": x[1], "y0": y[0], "y1": y[1],
                "fillcolor": ZONE, "opacity": 0.28, "line": {"width": 1, "color": ZONE},
            }
        )  # fmt: skip
        traces.append(
            {
                "type": "scatter", "mode": "markers", "name": "keep-out zone",
                "meta": {"phase": "zone"}, **named(instance, False),
                "x": [sum(x) / 2.0], "y": [sum(y) / 2.0],
                "marker": {"color": ZONE, "size": 7, "symbol": "x-thin", "line": {"width": 1.5,
                           "color": ZONE}},
                "hovertemplate": f"keep-out zone {number(y[0])}–{number(y[1])} km<br>"
                f"{period(zone.start_s, zone.end_s)}<extra></extra>",
            }
        )  # fmt: skip
    layout = {
        "xaxis": time_axis(instance, plan),
        "yaxis": {"title": {"text": "altitude [km]"}},
        "shapes": shapes,
        **named(instance, True),
    }
    return {"data": traces, "layout": layout}
