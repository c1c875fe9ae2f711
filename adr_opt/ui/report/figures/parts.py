"""What the charts share."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ....common.constants import DAY_S
from ....plan.palette import COLOURS, LABELS, PHASES, chaser_colours
from ....plan.plan import Plan
from ....plan.routes import owners, several
from ....problem.instance import Instance
from ...plot.axes import since
from ...plot.tracks import Track
from ..text import clock, in_chart

Figure = dict[str, Any]

FRAME_PX = 70
LONGEST_TICK = 16
"""Longer names are cut beside the chart; the whole name is in the hover text and in the tables."""


def column(values: npt.ArrayLike, digits: int) -> list[float | None]:
    """Numbers for JSON, rounded; a NaN, which makes a gap in a line, becomes null."""
    return [
        None if value != value else value
        for value in np.round(np.asarray(values, dtype=float), digits).tolist()
    ]


def days(times_s: npt.ArrayLike) -> list[float | None]:
    """Times in days, to less than a tenth of a second."""
    return column(np.asarray(times_s, dtype=float) / DAY_S, 6)


def repeated(legs: Iterable[int], lengths: Iterable[int]) -> list[int]:
    """The leg of each point of lines that :func:`adr_opt.ui.plot.tracks.joined` put together."""
    return [leg for leg, length in zip(legs, lengths, strict=True) for _ in range(length + 1)]


def time_axis(instance: Instance, plan: Plan) -> dict[str, Any]:
    """The common time axis of the charts, from the epoch to the end of the mission."""
    last = [route.legs[-1].end_s for route in plan.routes if route.legs]
    end = max([instance.mission.duration_s, *last])
    return {"title": {"text": since(instance)}, "range": [0.0, end / DAY_S or 1.0]}


def leg_title(plan: Plan, number: int) -> str:
    """What hover texts call a leg."""
    leg = plan.legs[number - 1]
    title = f"leg {number}: {in_chart(leg.origin)} → {in_chart(leg.destination)}"
    if len(plan.routes) == 1:
        return title
    before = 0
    for route in plan.routes:
        before += len(route.legs)
        if number <= before:
            return f"{in_chart(route.chaser)}, {title}"
    return title


def named(instance: Instance, are_shown: bool) -> dict[str, Any]:
    """For a layout or a trace: whether there is a legend, or it is in it, for several chasers."""
    return {"showlegend": are_shown} if several(instance) else {}


def legend(instance: Instance, kind: str = "scatter") -> list[dict[str, Any]]:
    """An entry for each of several chasers, which stays when phases are switched off."""
    if not several(instance):
        return []
    nowhere = {axis: [None] for axis in ("xyz" if kind == "scatter3d" else "xy")}
    return [
        {
            "type": kind, "mode": "lines", "name": in_chart(name), **nowhere,
            "line": {"color": colour, "width": 3}, "showlegend": True, "hoverinfo": "skip",
        }
        for name, colour in chaser_colours(instance).items()
    ]  # fmt: skip


class Strand(NamedTuple):
    """What is drawn as one trace: of one phase, and of one chaser where there are several."""

    phase: str
    tracks: list[Track]
    colour: str
    about: dict[str, Any]


def strands(instance: Instance, plan: Plan, tracks: tuple[Track, ...]) -> Iterator[Strand]:
    """The flown arcs as traces: coloured by phase, or by chaser where there are several."""
    whose, colours = owners(instance, plan), chaser_colours(instance)
    for chaser in [each.name for each in instance.chasers]:
        for phase in PHASES:
            found = [
                track
                for track in tracks
                if track.phase == phase and whose.get(track.leg, chaser) == chaser
            ]
            if not found:
                continue
            about: dict[str, Any] = {
                "name": LABELS[phase], "meta": {"phase": phase, "titled": True}
            }  # fmt: skip
            if several(instance):
                about |= {"name": in_chart(chaser), "showlegend": False}
            colour = colours[chaser] if several(instance) else COLOURS[phase]
            yield Strand(phase, found, colour, about)


def period(start_s: float, end_s: float) -> str:
    """A time window for hover texts."""
    return f"{clock(start_s)} – {clock(end_s)}"
