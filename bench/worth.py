"""What `worth` takes and finds: time, rates against Monte Carlo, lifetimes, a synthetic population.

    python bench/worth.py
    python bench/worth.py --pairs 5 --points 100000

Every part is drawn from a seed. The Monte Carlo only moves points on orbits
(`bench/harness/moving_points.py`).
"""

from __future__ import annotations

import argparse
import itertools
import math
import resource
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from harness.moving_points import NEAR_RAD, MovingOrbit, moving_rate
from machine import heading
from population import write_population

from adr_opt.common.constants import EARTH_RADIUS_M
from adr_opt.kernels.orbits.encounters import BLUR_M, encounter_rate
from adr_opt.sources import catalogue, worth
from adr_opt.sources.worth.air import ACTIVITIES, YEAR_S, lifetimes
from adr_opt.sources.worth.pairs import mean_speeds

LARGE, MIDDLE = 24_000, 20_000
"""Objects of the population that is timed, and of that whose ranks are told."""

DODGING = ("RELAY*", "HIGH RELAY*")
"""Constellations of the population, whose satellites are taken to dodge."""

SINGULAR = {
    "one circle, 71°": ((847.5, 852.5, 71.0), (847.5, 852.5, 71.0)),
    "circles at one altitude, 71° and 82°": ((847.5, 852.5, 71.0), (847.5, 852.5, 82.0)),
    "circles 1 km apart": ((847.5, 852.5, 71.0), (848.5, 853.5, 82.0)),
    "one shell, 71°": ((840, 850, 71.0), (840, 850, 71.0)),
    "one perigee": ((840, 850, 71.0), (840, 860, 82.0)),
    "equal inclinations": ((700, 800, 98.0), (750, 900, 98.0)),
    "both 0.1° off polar": ((840, 850, 89.9), (842, 860, 89.9)),
    "0.1° off polar, and polar": ((840, 850, 89.9), (842, 860, 90.0)),
    "80° and 99.9°": ((840, 850, 80.0), (842, 860, 99.9)),
}
"""Pairs near the singular ones: altitudes of perigee and apogee [km], inclination [degrees]."""

ECCENTRIC = {
    "eccentricity 0.05, and a circle": ((700, 1500, 65.0), (850, 855, 71.0)),
    "eccentricity 0.26, and a circle": ((300, 5000, 65.0), (850, 855, 71.0)),
    "transfer orbit, and a circle": ((250, 35786, 28.0), (850, 855, 71.0)),
    "two transfer orbits": ((250, 35786, 28.0), (500, 20000, 50.0)),
    "two shells, both at 3°": ((700, 800, 3.0), (750, 900, 3.0)),
}
"""Pairs for which speeds along the radius matter."""

NEAR_POLES_RAD = 0.0005
"""Arguments of latitude that count as equal where the rate depends on the last degree."""

Row = tuple[float, float, float]


def orbit(row: Row) -> MovingOrbit:
    """An orbit of altitudes [km] and an inclination [degrees]."""
    return MovingOrbit(
        EARTH_RADIUS_M + 1e3 * row[0], EARTH_RADIUS_M + 1e3 * row[1], math.radians(row[2])
    )


def closed(one: MovingOrbit, other: MovingOrbit) -> float:
    """The closed form of a pair whose radii add up to 1 m [1/s]."""
    shells = np.array([[each.perigee, each.apogee] for each in (one, other)])
    tilts = np.array([one.tilt, other.tilt])
    return float(encounter_rate(shells, tilts, np.full(2, 0.5), mean_speeds(), 0, 1)[0])


def drawn_pairs(
    bodies: worth.Bodies, count: int, random: np.random.Generator
) -> Iterator[tuple[MovingOrbit, MovingOrbit]]:
    """Pairs of a population whose shells meet."""
    while count:
        i, j = random.choice(len(bodies), 2, replace=False)
        low, high = bodies.shells[[i, j], 0].max(), bodies.shells[[i, j], 1].min()
        if high > low:
            count -= 1
            yield tuple(MovingOrbit(*bodies.shells[at], bodies.tilts[at]) for at in (i, j))  # type: ignore[misc]


def compared(
    one: MovingOrbit, other: MovingOrbit, points: int, random: np.random.Generator
) -> tuple[float, float]:
    """Closed form over Monte Carlo, less 1, and the standard error.

    Ends of shells are spread for the Monte Carlo where the closed form spreads them: where they
    nearly agree. Where inclinations nearly add up to 180° it takes more points.
    """
    ends = abs(one.perigee - other.perigee), abs(one.apogee - other.apogee)
    blur_m = BLUR_M if min(ends) < 4.0 * BLUR_M else 0.0
    polar = abs(math.degrees(one.tilt + other.tilt) - 180.0) < 1.0
    some, near = (6 * points, NEAR_POLES_RAD) if polar else (points, NEAR_RAD)
    rate, error = moving_rate(one, other, some, blur_m, random, near)
    return closed(one, other) / rate - 1.0, error / rate


def print_rates(bodies: worth.Bodies, pairs: int, points: int) -> None:
    """Print the closed form against Monte Carlo."""
    random = np.random.default_rng(0)
    print(f"\n## Encounter rates against {points:,} moved points on each orbit\n")
    print("| pair | closed form over Monte Carlo | standard error |\n|---|---|---|")
    offs, errors = zip(
        *(compared(*pair, points, random) for pair in drawn_pairs(bodies, pairs, random)),
        strict=True,
    )
    print(
        f"| {pairs} drawn pairs: mean, largest | {np.mean(offs):+.2%}, "
        f"{max(offs, key=abs):+.2%} | {np.median(errors):.2%}, {max(errors):.2%} |"
    )
    for name, rows in itertools.chain(SINGULAR.items(), ECCENTRIC.items()):
        off, error = compared(*(orbit(row) for row in rows), points, random)
        print(f"| {name} | {off:+.2%} | {error:.2%} |")


def print_lifetimes() -> None:
    """Print lifetimes on circles, by activity."""
    print("\n## Years in orbit from 600 / 800 / 1,000 km\n")
    print("| activity | 0.1 m²/kg | 0.0046 m²/kg |\n|---|---|---|")
    radii = EARTH_RADIUS_M + np.array([600e3, 800e3, 1000e3])
    shells = np.column_stack((radii, radii))
    for activity in ACTIVITIES:
        cells = (
            " / ".join(
                f"{life:,.3g}" for life in lifetimes(shells, np.full(3, area), activity, 1e5)
            )
            for area in (0.1, 0.0046)
        )
        print(f"| {activity} | {' | '.join(cells)} |")


def print_derelicts() -> None:
    """Print the encounters among 20 stages and 77 satellites about 850 km."""
    random = np.random.default_rng(0)
    middle = EARTH_RADIUS_M + 1e3 * random.uniform(800.0, 900.0, 97)
    half = 1e3 * random.uniform(2.5, 12.0, 97)
    shells = np.column_stack((middle - half, middle + half))
    stages = np.arange(97) < 20
    tilts = np.radians(np.where(stages, 71.0, random.choice([71.0, 82.5, 98.5], 97)))
    widths = np.where(stages, 3.5, 1.5)
    rates = [
        encounter_rate(shells, tilts, widths, mean_speeds(), i, j)[0]
        for i, j in itertools.combinations(range(97), 2)
    ]
    print(f"\n97 derelicts about 850 km: {sum(rates) * YEAR_S:.2g} encounters a year among them.")


def bodies_of(folder: Path, count: int, excluded: tuple[str, ...] = ()) -> worth.Bodies:
    """The population, read from its files."""
    path, satcat = write_population(folder, count)
    return worth.bodies_of(
        catalogue.read(path).records, worth.read_satcat(satcat), excluded=excluded
    )


def print_time(folder: Path, years: float) -> None:
    """Print the time for the largest population, files included."""
    worth.worth_of(bodies_of(folder, 200), years)
    begin = time.perf_counter()
    bodies = bodies_of(folder, LARGE)
    read = time.perf_counter()
    made = worth.worth_of(bodies, years, jobs=2)
    summed = time.perf_counter()
    worth.prizes_of(made, 200, jobs=2)
    done = time.perf_counter()
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(
        f"\n## {LARGE:,} objects, all pairs, {years:g} years, two cores\n\n"
        f"{read - begin:.1f} s to draw and read, {summed - read:.1f} s for all pairs, "
        f"{done - summed:.1f} s for the prizes of 200 candidates; at most {memory:.2f} GiB."
    )


def print_population(bodies: worth.Bodies, years: float, which: str) -> None:
    """Print the best objects of a population with reasons, and what sets take off."""
    told = worth.answer(worth.prizes_of(worth.worth_of(bodies, years), 200), None)
    print(
        f"\n## {which}\n\n{told['objects']:,} objects, {told['total']:,.0f} fragment-years in "
        f"{years:g} years, {told['catastrophic_per_year']:.2g} catastrophic collisions a year.\n"
    )
    print("| object | alone | floor | reason |\n|---|---|---|---|")
    for each in told["best"]:
        print(
            f"| {each['name']} | {each['worth_alone']:.0f} | {each['floor']:.0f} "
            f"| {each['reason']} |"
        )
    print("\n| set | avoided | of all | sum alone | sum of floors |\n|---|---|---|---|---|")
    for each in told["sets"]:
        print(
            f"| {each['size']} | {each['worth']:,.0f} | {each['share']:.1%} "
            f"| {each['sum_alone']:,.0f} ({each['sum_alone'] / each['worth'] - 1.0:+.1%}) "
            f"| {each['sum_floors']:,.0f} |"
        )


def main() -> None:
    """Print all parts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--years", type=float, default=50.0)
    parser.add_argument("--pairs", type=int, default=40)
    parser.add_argument("--points", type=int, default=800_000)
    call = parser.parse_args()
    print(heading())
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        print_time(folder, call.years)
        every = bodies_of(folder, MIDDLE)
        print_rates(every, call.pairs, call.points)
        print_lifetimes()
        print_derelicts()
        print_population(every, call.years, "All objects passive")
        passive = bodies_of(folder, MIDDLE, DODGING)
        print_population(passive, call.years, "Without both constellations, which dodge")


if __name__ == "__main__":
    main()
