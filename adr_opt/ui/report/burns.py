"""Burns of a plan and of its refined version: a table of the page, and its CSV file."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ...common.errors import InputError
from ...fly.trajectory.clock import UtcClock
from ...fly.trajectory.sampling import SHORTEST_ARC_S
from ...plan.phases import LABELS
from ...plan.plan import Plan
from ...plan.refined_plan import RefinedPlan
from ...plan.routes import owners
from ...problem.instance import Instance
from ..plot.strands import Track
from .tables import Column, table_of
from .text import NOTHING, clock, escape, fixed, in_chart

PLANNED, REFINED = "planned", "refined"

_COLUMNS = """
burns chaser leg origin destination phase time_s utc delta_v_m_s x_m_s y_m_s z_m_s
radial_m_s along_track_m_s cross_track_m_s
"""
COLUMNS = tuple(_COLUMNS.split())
"""Columns of the CSV file: context of the burn, time, and ΔV in the frame of the elements and in
that of the chaser; the last three are empty if unknown."""

Local = tuple[float, float, float]


@dataclass(frozen=True)
class ReportedBurn:
    """A burn of a leg.

    Attributes
    ----------
    of : {"planned", "refined"}
    leg : int
        Number of the leg, from 1.
    phase : str
    time_s : float
        Since the epoch [s].
    delta_v_m_s : (3,) tuple of float
        In the inertial frame of the elements [m/s].
    local_m_s : (3,) tuple of float or None
        Away from the Earth, along the track and across it, of the orbit before the burn; None
        where that is not known [m/s].
    """

    of: str
    leg: int
    phase: str
    time_s: float
    delta_v_m_s: Local
    local_m_s: Local | None

    @property
    def size_m_s(self) -> float:
        """ΔV of the burn [m/s]."""
        return math.hypot(*self.delta_v_m_s)


def impulses(
    plan: Plan, tracks: tuple[Track, ...], refined: RefinedPlan | None = None
) -> tuple[ReportedBurn, ...]:
    """Burns of a plan in the order of its legs, then those of the refined one.

    Parameters
    ----------
    plan : Plan
    tracks : tuple of Track
        The plan as flown; without them local frames are not known.
    refined : RefinedPlan, optional
    """
    return (*_planned(plan, tracks), *(() if refined is None else _refined(refined)))


def _planned(plan: Plan, tracks: tuple[Track, ...]) -> Iterator[ReportedBurn]:
    for number, leg in enumerate(plan.legs, start=1):
        arcs = [track for track in tracks if track.leg == number]
        for burn in leg.all_impulses:
            begun = next(
                (arc for arc in arcs if abs(arc.times_s[0] - burn.time_s) < SHORTEST_ARC_S), None
            )
            local = None
            if begun is not None:
                before = begun.first_m_s - np.array(burn.delta_v_m_s)
                local = local_m_s(begun.first_m, before, burn.delta_v_m_s)
            yield ReportedBurn(PLANNED, number, burn.phase, burn.time_s, burn.delta_v_m_s, local)


def _refined(refined: RefinedPlan) -> Iterator[ReportedBurn]:
    for leg in refined.legs:
        for burn in leg.impulses:
            states = [s for s in leg.states if abs(s.time_s - burn.time_s) < SHORTEST_ARC_S]
            local = None
            if states:
                before = np.array(states[-1].velocity_m_s) - np.array(burn.delta_v_m_s)
                local = local_m_s(states[-1].position_m, before, burn.delta_v_m_s)
            yield ReportedBurn(REFINED, leg.leg, burn.phase, burn.time_s, burn.delta_v_m_s, local)


def local_m_s(
    position_m: npt.ArrayLike, velocity_m_s: npt.ArrayLike, vector_m_s: npt.ArrayLike
) -> Local:
    """A vector in the local orbital frame: radial, along-track, cross-track [m/s]."""
    r, v = np.asarray(position_m, dtype=float), np.asarray(velocity_m_s, dtype=float)
    up, normal = r / np.linalg.norm(r), np.cross(r, v)
    side = normal / np.linalg.norm(normal)
    axes = np.stack([up, np.cross(side, up), side])
    radial, along, across = (axes @ np.asarray(vector_m_s, dtype=float)).tolist()
    return radial, along, across


def of_page(instance: Instance, plan: Plan, burns: Sequence[ReportedBurn]) -> dict[str, Any]:
    """Data from which the page's script makes the CSV file.

    Returns
    -------
    dict
        ``columns``, and ``rows`` of: planned or refined, leg, phase, time [s], ΔV [m/s] in three
        components, and local ones or None. ``legs`` are chaser, origin and destination of each.
    """
    whose = owners(instance, plan)
    only = instance.chasers[0].name
    return {
        "columns": COLUMNS,
        "rows": [
            [
                burn.of,
                burn.leg,
                burn.phase,
                burn.time_s,
                *burn.delta_v_m_s,
                *((None, None, None) if burn.local_m_s is None else burn.local_m_s),
            ]
            for burn in burns
        ],
        "legs": [
            [in_chart(name) for name in (whose.get(number, only), leg.origin, leg.destination)]
            for number, leg in enumerate(plan.legs, start=1)
        ],
    }


def section(instance: Instance, plan: Plan, burns: Sequence[ReportedBurn]) -> str:
    """The section with the tables of burns; empty where there are none."""
    if not instance.has_trajectories:
        return ""
    mine = [burn for burn in burns if burn.of == PLANNED]
    others = [burn for burn in burns if burn.of == REFINED]
    inside = _table("Burns", instance, plan, mine)
    if others:
        inside += f"<h3>Refined</h3>{_table('Refined burns', instance, plan, others)}"
    return (
        "<section>\n<h2>Burns</h2>\n<p>Radial is away from the Earth, along-track as the chaser "
        "flies, cross-track along the normal of its orbit, each of the orbit before the burn. The "
        "file has the components in the frame of the elements too.</p>\n"
        '<p><button type="button" class="file" id="csv">Download CSV</button></p>\n'
        f"{inside}\n</section>"
    )


def _table(caption: str, instance: Instance, plan: Plan, burns: Sequence[ReportedBurn]) -> str:
    whose = owners(instance, plan)
    try:
        calendar = UtcClock(instance).labels([burn.time_s for burn in burns]) if burns else []
    except InputError:  # times that no calendar has; the check says what is wrong with them
        calendar = [NOTHING] * len(burns)

    def _local(burn: ReportedBurn, axis: int) -> str:
        return NOTHING if burn.local_m_s is None else fixed(burn.local_m_s[axis], 3)

    columns: list[Column | bool] = [
        ("burn", "n", lambda at, burn, date: str(at)),
        bool(whose) and ("chaser", "", lambda at, burn, _: escape(whose.get(burn.leg, NOTHING))),
        ("leg", "n", lambda at, burn, date: str(burn.leg)),
        ("phase", "", lambda at, burn, date: LABELS.get(burn.phase, burn.phase)),
        ("time", "n", lambda at, burn, date: clock(burn.time_s)),
        ("UTC", "n", lambda at, burn, date: date[:19].replace("T", " ")),
        ("ΔV m/s", "n", lambda at, burn, date: fixed(burn.size_m_s, 3)),
        ("radial", "n", lambda at, burn, date: _local(burn, 0)),
        ("along-track", "n", lambda at, burn, date: _local(burn, 1)),
        ("cross-track", "n", lambda at, burn, date: _local(burn, 2)),
    ]
    items = zip(itertools.count(1), burns, calendar, strict=False)
    return table_of(caption, columns, items, lambda at, burn, date: f'data-of="{burn.leg}"')
