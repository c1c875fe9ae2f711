"""Cards of timetables and of samples from them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...common.card import Card, CardTable, days
from ...common.wording import counted

if TYPE_CHECKING:
    from ...legs.matrices import Matrices
    from ...legs.timetable import Timetable


def of_timetable(timetable: Timetable) -> Card:
    """The card of a timetable."""
    bodies = len(timetable.names)
    pairs = "all pairs" if timetable.is_whole else f"the nearest {timetable.built} pairs"
    holds = [pairs, f"{timetable.entries:,} entries"]
    if timetable.is_on_demand:
        holds = ["rows on demand"]
    facts = (f"{bodies} bodies", *holds, f"{timetable.time_value_m_s_per_h:g} m/s per hour")
    return Card("Timetable", f"of {timetable.instance.name!r}", facts)


def of_matrices(matrices: Matrices) -> Card:
    """The card of matrices; on a page, with ΔV at the first departure as far as it fits."""
    facts = [
        counted(len(matrices.departures), "departure"),
        counted(len(matrices.names), "body", "bodies"),
        matrices.choice,
    ]
    reached = np.isfinite(matrices.delta_v) & (matrices.duration > 0.0)
    details = []
    if reached.any():
        values = matrices.delta_v[reached]
        details.append(("ΔV", f"{values.min():,.1f} to {values.max():,.1f} m/s"))
        hours = matrices.duration[reached] / 3600.0
        details.append(("from ready to arrival", f"{hours.min():,.2f} to {hours.max():,.2f} h"))
    if not len(matrices.departures):
        return Card("Matrices", "", tuple(facts), tuple(details))
    first, most = matrices.departures[0], 12
    names, costs = matrices.names[:most], matrices.delta_v[0, :most, :most]
    rows = [
        (name, *(f"{value:,.0f}" for value in row)) for name, row in zip(names, costs, strict=True)
    ]
    details.append(("below", f"ΔV [m/s] when ready on day {days(float(first))}"))
    return Card("Matrices", "", tuple(facts), tuple(details), (CardTable(("from", *names), rows),))
