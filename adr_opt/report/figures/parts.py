"""What the charts share."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from ...instance import Instance
from ...kernels.constants import DAY_S
from ...plan import Plan
from ...plot.axes import since
from ..text import clock, in_chart

Figure = dict[str, Any]


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
    """The leg of each point of lines that :func:`adr_opt.plot.tracks.joined` put together."""
    return [leg for leg, length in zip(legs, lengths, strict=True) for _ in range(length + 1)]


def time_axis(instance: Instance, plan: Plan) -> dict[str, Any]:
    """The common time axis of the charts, from the epoch to the end of the mission."""
    end = max([instance.mission.duration_s, *(leg.end_s for leg in plan.legs[-1:])])
    return {"title": {"text": since(instance)}, "range": [0.0, end / DAY_S or 1.0]}


def leg_title(plan: Plan, number: int) -> str:
    """What hover texts call a leg."""
    leg = plan.legs[number - 1]
    return f"leg {number}: {in_chart(leg.origin)} → {in_chart(leg.destination)}"


def period(start_s: float, end_s: float) -> str:
    """A time window for hover texts."""
    return f"{clock(start_s)} – {clock(end_s)}"
