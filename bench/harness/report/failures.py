"""Failures, a sentence for each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

Row = dict[str, Any]

TOLERANCE = 1e-6
"""Relative difference by which a plan may not exceed a bound, and below which it meets it."""


def failures(rows: Sequence[Row], bounds: Sequence[Row], short: Mapping[str, str]) -> list[str]:
    """A sentence for everything that went wrong."""
    said = []
    for row in rows:
        where = f"{row['suite']}, field {row['field']}, iteration {row['iteration']}"
        if row["outcome"] != "legal":
            said.append(f"{where}: {short[row['method']]}: {row['outcome']}: {row['message']}")
        elif row["bound"] is not None and row["objective"] > row["bound"] * (1.0 + TOLERANCE):
            said.append(
                f"{where}: {short[row['method']]}: a legal plan of {row['objective']:g} "
                f"contradicts the proven bound of {row['bound']:g}"
            )
    for bound in bounds:
        if bound["message"] is not None:
            said.append(
                f"{bound['suite']}, field {bound['field']}, iteration {bound['iteration']}: "
                f"bound {bound['bound']}: {bound['message']}"
            )
    return said
