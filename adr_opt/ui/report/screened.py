"""The page of ``screen``: approaches of objects to a refined plan, over time."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ...analysis.screening import CloseApproach
from ...common.wording import counted
from ..plot.studies import approaches_chart
from . import tables
from .charts import drawn
from .plain import page, section, table_of
from .text import number

LISTED = 200
"""Maximum number of approaches in the table, the nearest ones."""

MISSES = "Misses against time"

PROBABILITIES = (
    "Probabilities of a collision are those of short encounters, by the integral over the circle "
    "of both radii; if an error is unknown, or the encounter is slow, none is given."
)


def columns(probable: bool) -> list[tables.Column]:
    """Columns of a table of approaches, with probabilities if known."""
    found: list[tables.Column] = [
        ("object", "", lambda each: each.object),
        ("chaser", "", lambda each: each.chaser),
        ("leg", "n", lambda each: each.leg),
        ("time", "", lambda each: each.epoch[:19].replace("T", " ")),
        ("miss, m", "n", lambda each: number(each.miss_m, 0)),
        ("radial", "n", lambda each: number(each.radial_m, 0)),
        ("along", "n", lambda each: number(each.along_m, 0)),
        ("cross", "n", lambda each: number(each.cross_m, 0)),
        ("speed, m/s", "n", lambda each: number(each.speed_m_s, 0)),
        ("age, days", "n", lambda each: number(each.age_days, 1)),
        ("probability", "n", lambda each: _chance(each.probability)),
    ]
    return found if probable else found[:-1]


def knows_probabilities(found: Iterable[CloseApproach]) -> bool:
    """Whether some approach has a probability."""
    return any(each.probability is not None for each in found)


def screening_page(
    name: str, found: Sequence[CloseApproach], distance_m: float, objects: int
) -> str:
    """The HTML of the page.

    Parameters
    ----------
    name : str
        Of the instance.
    found : sequence of CloseApproach
        As :func:`adr_opt.analysis.screening.screen` finds them.
    distance_m : float
        Within which they are reported [m].
    objects : int
        Number of objects that were looked at.
    """
    others = sorted((each for each in found if not each.own), key=lambda each: each.miss_m)
    probable = knows_probabilities(others)
    near = table_of("Nearest approaches", columns(probable), ((each,) for each in others[:LISTED]))
    more = f"The {LISTED} nearest of {len(others)}. " if len(others) > LISTED else ""
    under = (
        f"{name} · {counted(objects, 'object')} · {counted(len(others), 'approach', 'approaches')} "
        f"within {distance_m:g} m, {len(found) - len(others)} of bodies that are visited"
    )
    parts = [
        section(MISSES, "", drawn(approaches_chart(found), MISSES)),
        section("Nearest approaches", more + PROBABILITIES * probable, near if others else ""),
    ]
    return page("Screening", "Approaches to the plan", under, parts)


def _chance(probability: float | None) -> str:
    return "unknown" if probability is None else f"{probability:.1e}"
