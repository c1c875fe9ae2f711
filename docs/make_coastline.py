"""Make the coastline of the report from Natural Earth, as world-atlas packs it.

    npm pack world-atlas@2.0.2 && tar xzf world-atlas-2.0.2.tgz
    python docs/make_coastline.py package/land-110m.json    # into adr_opt/ui/report/coast

The file is a TopoJSON of the land at 1:110 million, with rings that run through the antimeridian.
Each ring is cut there, and rounded to tenths of a degree, 11 km, finer than the data are.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

PLACE = Path(__file__).parents[1] / "adr_opt/ui/report/coast/coastline.json"
UNITS = 10
"""In a degree."""

EDGE = 180.0

Point = tuple[float, float]


def rings(topology: dict[str, Any]) -> Iterator[list[Point]]:
    """The closed lines of all land: longitude and latitude [°]."""
    (left, low), (across, up) = (topology["transform"][key] for key in ("translate", "scale"))
    arcs = []
    for deltas in topology["arcs"]:
        x = y = 0
        arc = []
        for dx, dy in deltas:
            x, y = x + dx, y + dy
            arc.append((left + across * x, low + up * y))
        arcs.append(arc)
    for land in topology["objects"]["land"]["geometries"]:
        for polygon in land["arcs"]:
            for numbers in polygon:
                ring: list[Point] = []
                for number in numbers:
                    arc = arcs[number] if number >= 0 else arcs[~number][::-1]
                    ring += arc[bool(ring) :]
                yield ring


def cut(ring: list[Point]) -> Iterator[list[Point]]:
    """A ring as lines that stay on the map; what runs along the antimeridian is no coast."""
    line = [ring[0]]
    for (x, y), (to_x, to_y) in pairwise(ring):
        ahead = to_x + 2.0 * EDGE * round((x - to_x) / (2.0 * EDGE))
        if ahead == x and abs(x) == EDGE:
            yield line
            line = []
        elif ahead != to_x:
            edge = math.copysign(EDGE, x)
            crossing = y + (edge - x) / (ahead - x) * (to_y - y)
            yield [*line, (edge, crossing)]
            line = [(-edge, crossing)]
        line.append((to_x, to_y))
    yield line


def packed(line: list[Point]) -> list[int]:
    """A line in units: the first point, and then what each is beyond the last; none twice."""
    found: list[int] = []
    at = (0, 0)
    for point in line:
        x, y = (round(UNITS * value) for value in point)
        if not found or (x, y) != at:
            found += [x - at[0], y - at[1]]
            at = (x, y)
    return found


def coastline(topology: dict[str, Any]) -> dict[str, Any]:
    """All lines with at least two points, as the page reads them."""
    lines = [packed(line) for ring in rings(topology) for line in cut(ring)]
    return {"units": UNITS, "lines": [line for line in lines if len(line) > 2]}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Make the coastline of the report.")
    parser.add_argument("land", type=Path, help="land-110m.json of world-atlas")
    parser.add_argument("--out", type=Path, default=PLACE, metavar="FILE")
    typed = parser.parse_args()
    made = coastline(json.loads(typed.land.read_text(encoding="utf-8")))
    typed.out.write_text(json.dumps(made, separators=(",", ":")) + "\n", encoding="utf-8")
    points = sum(len(line) for line in made["lines"]) // 2
    print(
        f"{typed.out}: {len(made['lines'])} lines of {points} points, "
        f"{typed.out.stat().st_size / 1000:.0f} kB"
    )
