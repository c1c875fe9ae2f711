"""The table of a trade-off, as CSV: a row for each point."""

from __future__ import annotations

import csv
import io
import json
import math
import os

from ...common.files import write_text
from .points import Tradeoff

COLUMNS = (
    "instance_sha256",
    "delta_v_m_s",
    "duration_s",
    "method",
    "prize",
    "upper_bound",
    "status",
    "visits",
    "cost",
    "runtime_s",
    "cpu_s",
    "routes",
)

OF_DRIVES = {"thrust": "thrust_n", "isp": "isp_s"}
"""Further columns, after the duration, where these are varied, by the kind of axis."""


def write_table(path: str | os.PathLike[str], made: Tradeoff) -> None:
    """Write the CSV file completely or not at all."""
    kinds = {axis.kind for axis in made.axes}
    at = COLUMNS.index("method")
    drives = (name for kind, name in OF_DRIVES.items() if kind in kinds)
    columns = (*COLUMNS[:at], *drives, *COLUMNS[at:])
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, columns, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    for point in made.points:
        writer.writerow(
            {
                **point.to_dict(),
                "instance_sha256": made.instance.sha256,
                "method": "+".join(point.methods),
                "cost": "nan" if math.isnan(point.cost) else repr(point.cost),
                "runtime_s": f"{point.runtime_s:.3f}",
                "cpu_s": f"{point.cpu_s:.3f}",
                "routes": json.dumps(point.routes, ensure_ascii=False),
            }
        )
    write_text(path, text.getvalue())
