"""Distances that fitted orbits leave to the ephemerides of real objects.

    ADR_OPT_EXTERNAL_DATA=FOLDER python bench/ephemerides.py [CATALOGUE...]

Prints a Markdown table for each catalogue: mean elements as SGP4 has them at the epoch, moved by J2
alone, and those fitted to SGP4 over the mission; medians over the 60 targets with the nearest
planes, the 90th percentile along the track, and the worst object. By default the catalogues of that
folder with more than one object are taken, for a week and for a month. Then the rates of nodes that
fits leave, and how far nodes are off with a common rate and with one of each body; and the accuracy
of tables: states of a day between those of messages with a state every 60, 120 and 180 s.
"""

from __future__ import annotations

import math
import os
import sys
import time
from pathlib import Path

import numpy as np
from machine import heading

from adr_opt.common.constants import DAY_S, OBLATENESS_M2
from adr_opt.common.errors import InputError
from adr_opt.kernels.orbits.ephemeris import secular_rates
from adr_opt.problem.fit import Fit
from adr_opt.sources import catalogue
from adr_opt.sources.ephemerides.ephemeris import TurningAxes
from adr_opt.sources.ephemerides.fit import FittedOrbit, fitted, sample_times
from adr_opt.sources.ephemerides.interpolation import interpolated
from adr_opt.sources.ephemerides.left_over import LeftOver, left_over
from adr_opt.sources.ephemerides.of_instance import ByElements

TARGETS = 60
DAYS = (7.0, 30.0)
STEPS_S = (60.0, 120.0, 180.0)


def main() -> None:
    """Measure and print."""
    files = [Path(path) for path in sys.argv[1:]] or _default()
    print(f"{heading()}\n")
    print(
        "| catalogue | days | elements | bodies | epoch km | along km | 90 % | across km "
        "| m/s a leg | worst along the track |\n|---|---|---|---|---|---|---|---|---|---|"
    )
    for path in files:
        for days in DAYS:
            _compare(path, days)
    print(
        "\n| catalogue | days | rate of nodes left °/day | middle 90 % | node off km "
        "| with a common rate | with one of each |\n|---|---|---|---|---|---|---|"
    )
    for path in files:
        for days in DAYS:
            _nodes(path, days)
    print("\n| step s | Lagrange, 8 states: m | Hermite, 4 states: m |\n|---|---|---|")
    for step in STEPS_S:
        _interpolate(files[0], step)


def _default() -> list[Path]:
    folder = Path(os.environ["ADR_OPT_EXTERNAL_DATA"])
    return [*sorted(folder.glob("tle/*.txt")), *sorted(folder.glob("omm/celestrak*.csv"))]


def _bodies(path: Path, days: float) -> list[tuple[ByElements, FittedOrbit]]:
    """Ephemerides of the targets, and their orbits as SGP4 has them at the epoch."""
    made = catalogue.to_instance(
        catalogue.read(path, skip_bad=True),
        max_targets=TARGETS,
        skip_bad=True,
        mission=catalogue.MissionOutline(duration_s=days * DAY_S),
    )
    instance = made.instance
    assert instance.frame is not None
    axes = TurningAxes(instance.epoch, instance.frame)
    found = []
    for target in instance.targets:
        assert target.orbit is not None
        ephemeris = ByElements(target.name, made.records[target.name], instance.epoch, axes)
        try:
            ephemeris.state(np.linspace(0.0, days * DAY_S, 100))
        except InputError as error:
            print(f"left out: {error}", file=sys.stderr)
            continue
        found.append((ephemeris, FittedOrbit(target.orbit, 0.0, Fit())))
    return found


def _compare(path: Path, days: float) -> None:
    bodies = _bodies(path, days)
    before = [left_over(ephemeris, orbit, days * DAY_S) for ephemeris, orbit in bodies]
    begin = time.perf_counter()
    fits = [fitted(ephemeris, days * DAY_S) for ephemeris, _ in bodies]
    each = (time.perf_counter() - begin) / len(bodies)
    after = [
        left_over(ephemeris, fit, days * DAY_S)
        for (ephemeris, _), fit in zip(bodies, fits, strict=True)
    ]
    for name, left in (("SGP4's at the epoch", before), ("fitted", after)):
        print(f"| {path.stem} | {days:g} | {name} | {_row(left)} |")
    print(f"{each * 1e3:.0f} ms a fit", file=sys.stderr)


def _nodes(path: Path, days: float) -> None:
    """Rates of nodes beyond those of J2, and the largest distance of nodes; medians over bodies."""
    times = sample_times(days * DAY_S)
    rates, nodes, arcs = [], [], []
    for ephemeris, _ in _bodies(path, days):
        orbit = fitted(ephemeris, days * DAY_S).orbit
        tilt = math.radians(orbit.inclination_deg)
        rate, _, _ = secular_rates(orbit.semi_major_axis_m, orbit.eccentricity, tilt, OBLATENESS_M2)
        normal = np.cross(*np.split(ephemeris.state(times), 2, axis=1))
        node = np.unwrap(np.arctan2(normal[:, 0], -normal[:, 1])) - rate * times
        rates.append(np.polyfit(times, node, 1)[0])
        nodes.append(node)
        arcs.append(orbit.semi_major_axis_m * math.sin(tilt) / 1e3)
    common = float(np.median(rates))
    off = []
    for taken in (np.zeros(len(rates)), np.full(len(rates), common), np.array(rates)):
        left = [node - rate * times for node, rate in zip(nodes, taken, strict=True)]
        off.append(
            [np.abs(one - one.mean()).max() * arc for one, arc in zip(left, arcs, strict=True)]
        )
    low, high = np.degrees(np.quantile(rates, (0.05, 0.95))) * DAY_S
    print(
        f"| {path.stem} | {days:g} | {math.degrees(common) * DAY_S:.5f} "
        f"| {low:.5f} to {high:.5f} | " + " | ".join(f"{np.median(one):.2f}" for one in off) + " |"
    )


def _row(left: list[LeftOver]) -> str:
    epoch, along, across = (
        np.array([getattr(one, field) for one in left]) / 1e3
        for field in ("epoch_m", "along_m", "across_m")
    )
    speed = np.median([one.leg_m_s for one in left])
    worst = int(np.argmax(along))
    return (
        f"{len(left)} | {np.median(epoch):.2f} | {np.median(along):.2f} | "
        f"{np.quantile(along, 0.9):.2f} | {np.median(across):.2f} | {speed:.1f} | "
        f"{left[worst].body}, {along[worst]:,.1f} km"
    )


def _interpolate(path: Path, step_s: float) -> None:
    """Median over bodies of the largest error within a day."""
    knots = np.arange(-10.0 * step_s, DAY_S + 10.0 * step_s, step_s)
    times = np.linspace(0.0, DAY_S, 5001)
    errors = []
    for ephemeris, _ in _bodies(path, 7.0):
        table, true = ephemeris.state(knots), ephemeris.state(times)
        errors.append(
            [
                np.linalg.norm(
                    (interpolated(knots, table, times, method, 7) - true)[:, :3], axis=1
                ).max()
                for method in ("LAGRANGE", "HERMITE")
            ]
        )
    lagrange, hermite = np.median(errors, axis=0)
    print(f"| {step_s:g} | {lagrange:.4f} | {hermite:.3f} |")


if __name__ == "__main__":
    main()
