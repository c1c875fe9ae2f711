"""Worth of removals by altitude and kind of object, as a chart."""

from __future__ import annotations

import numpy as np

from ...plan.palette import CHASERS
from ...sources.worth import RemovalWorth
from ...sources.worth.bodies import ends_km
from .chart import Chart, ChartAxis, Line

STEP_KM, HIGHEST_KM = 50.0, 2000.0
"""Bands of mean altitude."""

KINDS = ("rocket body", "payload", "debris")


def worth_chart(worth: RemovalWorth) -> Chart:
    """Sums of worths alone in bands of altitude, for each kind of object."""
    bodies = worth.bodies
    altitudes = np.array([sum(ends_km(record)) / 2.0 for record in bodies.records])
    edges = np.arange(0.0, HIGHEST_KM + STEP_KM, STEP_KM)
    lines = []
    for kind, colour in zip(KINDS, CHASERS, strict=False):
        own = np.array([each == kind for each in bodies.kinds])
        sums = np.histogram(altitudes[own], edges, weights=worth.alone[own])[0]
        first = int(np.argmax(edges >= 300.0))
        lines.append(
            Line(
                name=kind,
                colour=colour,
                step=True,
                x=edges[first:].tolist(),
                y=[*sums[first:].tolist(), 0.0],
            )
        )
    title = f"fragment-years by {STEP_KM:g} km"
    return Chart(tuple(lines), ChartAxis("mean altitude [km]"), ChartAxis(title))
