"""A plan for people: one line per leg and a summary."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..kernels.constants import DAY_S
from ..wording import status_words
from .tables import Row, leg_table

if TYPE_CHECKING:
    from rich.table import Table

    from ..instance import Instance
    from ..plan import Plan

LONG_S = 2.0 * DAY_S
"""Longer spans are told in days."""


def clock(time_s: float) -> str:
    """A time since the epoch as day, hours and minutes; the first day is day 0."""
    minutes = round(time_s / 60.0)
    return f"{minutes // 1440}d {minutes // 60 % 24:02d}:{minutes % 60:02d}"


def span(duration_s: float) -> str:
    """A duration as hours and minutes, or in days if it is long."""
    if duration_s >= LONG_S:
        return f"{duration_s / DAY_S:.1f} d"
    minutes = round(duration_s / 60.0)
    return f"{minutes // 60}:{minutes % 60:02d}"


def timeline(instance: Instance, plan: Plan, width: int | None = None) -> Table:
    """The legs of a plan as a table of at most ``width`` columns, if names can be cut to that."""
    rows = []
    for number, leg in enumerate(plan.legs, start=1):
        refuels = leg.destination in instance.station_names
        texts = (
            clock(leg.departure_s),
            span(leg.departure_s - leg.ready_s),
            f"{leg.delta_v_m_s:.1f}",
            f"{leg.delta_v_left_m_s:.1f}",
            "drift" if leg.kind == "drift" else str(leg.phasing_revolutions),
            clock(leg.arrival_s),
        )
        destination = f"{leg.destination} (refuels)" if refuels else leg.destination
        rows.append(Row(number, leg.origin, destination, texts, bold=refuels))
    headings = ("departs", "wait", "ΔV\nm/s", "left\nm/s", "k", "arrives")
    title = f"{instance.name}: {plan.method}, {status_words(plan.status)}"
    return leg_table(headings, rows, width, title)


def summary(instance: Instance, plan: Plan) -> str:
    """What a plan comes to, in one line; of bound and gap only where there is a bound."""
    refuellings = sum(name in instance.station_names for name in plan.destinations)
    used = plan.legs[-1].end_s if plan.legs else 0.0
    proven: tuple[str, ...] = ()
    if plan.upper_bound is not None and plan.gap is not None:
        proven = (f"bound {plan.upper_bound:.6g}", f"gap {plan.gap:.1%}")
    parts = (
        f"visits {len(plan.legs) - refuellings} of {len(instance.targets)}",
        f"prize {plan.objective:g}",
        f"ΔV {plan.delta_v_m_s:.1f} m/s",
        f"refuellings {refuellings}",
        f"duration {used / DAY_S:.2f} of {instance.mission.duration_s / DAY_S:.2f} d",
        *proven,
        f"runtime {plan.runtime_s:.2f} s",
    )
    return ", ".join(parts)
