"""The page of ``worth``: dangerous pairs of groups, and the effect of removals."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ...common.wording import counted
from ...sources.worth import RemovalPrizes, RemovalWorth
from ...sources.worth.answer import figure
from ...sources.worth.worth import CELL_DEG, CELL_KM, LEVELS, TILTS
from ..plot.studies import worth_chart
from . import tables
from .charts import drawn
from .plain import page, row, section, table_of
from .tables import table
from .text import escape, fixed, number

PAIRS = 12
"""Maximum number of pairs of cells in the table."""

BY_ALTITUDE = "Worth by altitude"

PUBLISHED = (
    "A public list of 2025 credits its first ten objects with 30 % of the debris-generating "
    "potential in low orbits and its first fifty with half. Those figures belong to the real "
    "catalogue and to another measure; with a real catalogue in this page the shares stand here."
)

ASSUMED = (
    "Nodes and perigees count as random, objects as passive and at their present altitude until "
    "they come down; no launches and no explosions. Operating satellites that dodge are therefore "
    "rated too high. Nodes of a family with one inclination stay random only roughly over decades."
)


def worth_page(prizes: RemovalPrizes, told: Mapping[str, Any]) -> str:
    """The HTML of the page.

    Parameters
    ----------
    prizes : RemovalPrizes
    told : mapping
        The answer of ``worth``, see :func:`adr_opt.sources.worth.answer.answer`.
    """
    worth = prizes.worth
    under = (
        f"{worth.years:g} years · {worth.activity} solar activity · {figure(worth.total)} "
        f"fragment-years expected of all pairs"
    )
    parts = [
        section(
            "Most worth removing",
            f"Expected fragment-years of 10 cm and more that each removal avoids, and the floor "
            f"that adds up among {counted(len(prizes.candidates), 'candidate')}. Prizes are whole "
            f"multiples of {prizes.unit_text}.",
            _best(told["best"]),
        ),
        section("Removed as a set", PUBLISHED, _sets(told["sets"])) if told["sets"] else "",
        section(
            "By altitude and inclination",
            "Share of the worth of all objects, by mean altitude and inclination.",
            _map(worth),
        ),
        section(
            "Who is dangerous to whom",
            "The pairs of such groups with the largest shares of all expected fragment-years.",
            _pairs(worth),
        ),
        section(BY_ALTITUDE, "", drawn(worth_chart(worth), BY_ALTITUDE)),
        section("Sources", _matches(told), _sources(told)),
        section("Assumptions", ASSUMED, ""),
    ]
    title = f"Fragment-years of {number(told['objects'])} objects"
    return page("Worth of removals", title, under, parts)


def _best(best: Iterable[Mapping[str, Any]]) -> str:
    columns: list[tables.Column] = [
        ("object", "", lambda each: f"<b>{escape(each['name'])}</b>"),
        ("prize", "n", lambda each: number(each["prize"], 0)),
        ("alone", "n", lambda each: figure(each["worth_alone"])),
        ("floor", "n", lambda each: figure(each["floor"])),
        (
            "reason",
            "",
            lambda each: ("name", f'<div style="min-width:36ch">{escape(each["reason"])}</div>'),
        ),
    ]
    return tables.table_of("Most worth removing", columns, ((each,) for each in best))


def _sets(sets: Iterable[Mapping[str, Any]]) -> str:
    columns: list[tables.Column] = [
        ("objects", "n", lambda each: str(each["size"])),
        ("fragment-years avoided", "n", lambda each: figure(each["worth"])),
        ("of all", "n", lambda each: f"{fixed(100.0 * each['share'], 1)} %"),
        ("sum alone", "n", lambda each: figure(each["sum_alone"])),
        ("sum of floors", "n", lambda each: figure(each["sum_floors"])),
    ]
    return table_of("Removed as a set", columns, ((each,) for each in sets))


def _map(worth: RemovalWorth) -> str:
    """Shares as squares, darker for more."""
    shares = worth.cells.sum(axis=1).reshape(LEVELS, TILTS)
    shares = shares / max(float(shares.sum()), 1e-300)
    levels = np.flatnonzero(shares.sum(axis=1) > 0.0)
    low, high = (int(levels.min()), int(levels.max())) if len(levels) else (0, 0)
    across, up, left, top = 36, 24, 96, 4
    width, height = left + TILTS * across + 4, top + (high - low + 1) * up + 40
    parts = []
    largest = max(float(shares.max()), 1e-300)
    for level in range(low, high + 1):
        y = top + (high - level) * up
        parts.append(f'<text x="{left - 8}" y="{y + 16}" text-anchor="end">{_level(level)}</text>')
        for tilt in range(TILTS):
            share = float(shares[level, tilt])
            if share <= 0.0:
                continue
            x = left + tilt * across
            shade = max((share / largest) ** 0.5, 0.05)
            where = f"{_level(level)} km, {_tilt(tilt)}: {share:.2%}"
            parts.append(
                f'<rect x="{x}" y="{y}" width="{across - 2}" height="{up - 2}" '
                f'fill="var(--accent)" opacity="{shade:.2f}"><title>{where}</title></rect>'
            )
    for tilt in range(0, TILTS + 1, 3):
        parts.append(
            f'<text x="{left + tilt * across}" y="{height - 22}" text-anchor="middle">'
            f"{tilt * CELL_DEG:g}°</text>"
        )
    parts.append(
        f'<text x="{left + TILTS * across / 2}" y="{height - 4}" text-anchor="middle">'
        "inclination; mean altitude [km] on the left</text>"
    )
    return (
        '<div class="scroll" style="max-height:none" tabindex="0" role="region" aria-label="Map">'
        '<figure class="drawn">'
        f'<svg viewBox="0 0 {width} {height}" style="min-width:560px;max-width:900px" role="img" '
        f'aria-label="Worth by altitude and inclination">{"".join(parts)}</svg></figure></div>'
    )


def _pairs(worth: RemovalWorth) -> str:
    once = np.triu(worth.cells)
    np.fill_diagonal(once, 0.5 * np.diagonal(once))
    order = np.argsort(-once, axis=None)[:PAIRS]
    total = max(worth.total, 1e-300)
    rows = []
    for at in order:
        one, other = divmod(int(at), len(once))
        if once[one, other] <= 0.0:
            break
        share = fixed(100.0 * float(once[one, other]) / total, 1)
        rows.append(row((("", _cell(one)), ("", _cell(other)), ("n", f"{share} %"))))
    headings = (("objects at", ""), ("with objects at", ""), ("share", "n"))
    return table("Who is dangerous to whom", headings, rows)


def _cell(cell: int) -> str:
    level, tilt = divmod(cell, TILTS)
    return f"{_level(level)} km, {_tilt(tilt)}"


def _level(level: int) -> str:
    low = level * CELL_KM
    return f"over {low:g}" if level == LEVELS - 1 else f"{low:g}–{low + CELL_KM:g}"


def _tilt(tilt: int) -> str:
    return f"{tilt * CELL_DEG:g}–{(tilt + 1) * CELL_DEG:g}°"


def _matches(told: Mapping[str, Any]) -> str:
    satcat = told["satcat"]
    if satcat is None:
        return "No satcat was given."
    of_when = f" of {satcat['updated']}" if satcat["updated"] else ""
    return (
        f"The General Catalog{of_when} (J. McDowell, planet4589.org/space/gcat, CC BY 4.0) has "
        f"{satcat['matched']} of the objects."
    )


def _sources(told: Mapping[str, Any]) -> str:
    names = {"masses": "mass", "sizes": "size", "areas": "area over mass"}
    rows = [
        row((("", name), ("", escape(source)), ("n", str(count))))
        for key, name in names.items()
        for source, count in sorted(told[key].items(), key=lambda pair: -pair[1])
    ]
    return table("Sources", (("quantity", ""), ("source", ""), ("objects", "n")), rows)
