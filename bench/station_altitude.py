"""Visits over the altitude of the station: a study in one file, to be copied for others.

    python bench/station_altitude.py --fields 10 --jobs 2 --out altitudes.jsonl

How high should the station fly from which a chaser starts and refuels? Each row is a field of the
study with its station at another altitude, planned by ``beam`` with a fixed amount of work. The
same command goes on from ``--out`` where it was ended, and more fields or altitudes are added.
"""

from __future__ import annotations

import argparse
import math
import statistics
from collections.abc import Sequence
from typing import NamedTuple

from machine import heading

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M
from adr_opt.study import Place, Study, run

WIDTH = 20


class Key(NamedTuple):
    """A field, by its seed, with its station at an altitude."""

    altitude_km: float
    seed: int


class Outcome(NamedTuple):
    """Targets visited, refuellings, and ΔV of all legs [m/s]."""

    visits: int
    refuellings: int
    delta_v_m_s: float


def row(key: Key, place: Place) -> Outcome:
    """The plan of a field with its station at an altitude."""
    field = adr_opt.generate("nominal", key.seed)
    (station,) = field.stations
    orbit = station.orbit.replace(semi_major_axis_m=EARTH_RADIUS_M + 1e3 * key.altitude_km)
    field = field.replace(stations=(station.replace(orbit=orbit),))
    plan = adr_opt.solve(field, "beam", width=WIDTH, time_limit=math.inf).plan
    assert plan is not None  # no target is required
    stops = sum(leg.destination == station.name for leg in plan.legs)
    return Outcome(len(plan.legs) - stops, stops, round(plan.delta_v_m_s, 3))


STUDY: Study[Key, Outcome] = Study(
    "station-altitude",
    1,
    row,
    {"settings": f"nominal, beam of width {WIDTH}"},
    key=Key._asdict,
    to_json=Outcome._asdict,
    from_json=lambda key, value: Outcome(**value),
)


def table(found: dict[Key, Outcome]) -> list[str]:
    """Means over fields for each altitude, as lines of Markdown."""
    lines = ["| station | fields | visits | refuellings | ΔV of a visit |", "|---|---|---|---|---|"]
    for altitude_km in sorted({key.altitude_km for key in found}):
        outcomes = [outcome for key, outcome in found.items() if key.altitude_km == altitude_km]
        visits, refuellings, delta_v = (
            statistics.fmean(values) for values in zip(*outcomes, strict=True)
        )
        lines.append(
            f"| {altitude_km:g} km | {len(outcomes)} | {visits:.1f} | {refuellings:.1f} | "
            f"{delta_v / visits:.0f} m/s |"
        )
    return lines


def main(arguments: Sequence[str] | None = None) -> None:
    """Plan what is missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--fields", type=int, default=10, help="by seed from 0 [10]")
    parser.add_argument("--from-km", type=int, default=500)
    parser.add_argument("--to-km", type=int, default=900)
    parser.add_argument("--step-km", type=int, default=100)
    parser.add_argument("--jobs", type=int, default=1, help="processes; 0 for all cores [1]")
    parser.add_argument("--cluster", help="dask://HOST:PORT in their place")
    parser.add_argument("--out", help="file to go on from")
    asked = parser.parse_args(arguments)
    keys = [
        Key(float(altitude_km), seed)
        for seed in range(asked.fields)
        for altitude_km in range(asked.from_km, asked.to_km + 1, asked.step_km)
    ]
    found = run(STUDY, keys, asked.out, jobs=asked.jobs, cluster=asked.cluster)
    print(heading())
    print("\n".join(table(found)))


if __name__ == "__main__":
    main()
