"""Rates of a year, its collisions and explosions, and their fragments (docs/scenarios.md)."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import NamedTuple

import numpy as np

from ...common.constants import EARTH_RADIUS_M
from ...common.errors import InputError
from ...kernels.orbits.collisions import CollidingObjects, CollisionTables
from ...kernels.orbits.drawn_collisions import HitKeys, drawn_collisions, fragment_hits
from ...kernels.orbits.encounters import LEAST_WIDTH_M
from ...kernels.orbits.keyed_draws import keyed_draws
from ...problem.air import DRAG_COEFFICIENT, FLOAT, HIGHEST_M, LOWEST_M, YEAR_S, circular_drag_times
from ...sources.worth.breakup import (
    ALTITUDE_STEP_M,
    CATASTROPHIC_J_KG,
    FRAGMENTS,
    area_shares,
    fragment_sizes,
)
from ...sources.worth.breakup import KINDS as BREAKUP_KINDS
from ...sources.worth.pairs import INDICES, block_ends, mean_speeds, threads
from .futures import Collision, Explosion, YearRates
from .population import ObjectPopulation
from .settings import KINDS, AltitudeShells, ScenarioSettings

EXPLOSION_FRAGMENTS = 6.0 * 0.1**-1.6
"""Fragments of 10 cm and more of an explosion (Johnson et al., 2001, equation 2)."""


GROUP = 5
"""Bins of area over mass in a ring."""

LEAST_COUNT = 1e-3
"""Least number of fragments of a ring."""


class FragmentCloud(NamedTuple):
    """Fragments of one event.

    Attributes
    ----------
    year : float
        When they were made.
    altitude_m : float
        Where; fragments start on circles there.
    counts : (float, float)
        Of rocket bodies and of spacecraft, as :data:`.breakup.KINDS`.
    tilt : float
        Inclination of the heavier object [rad].
    number : int
        Of the cloud: that of the object that broke up, the lighter of two.
    """

    year: float
    altitude_m: float
    counts: tuple[float, float]
    tilt: float
    number: int


class FragmentRings(NamedTuple):
    """Fragments in orbit, grouped into rings of similar ones, cloud by cloud.

    Attributes
    ----------
    radii, tilts : (ring,) float64
        [m], [rad].
    counts, masses : (ring,) float64
        Numbers, and the mass of each [kg].
    clouds : (ring,) int64
        :attr:`FragmentCloud.number`.
    """

    radii: FLOAT
    tilts: FLOAT
    counts: FLOAT
    masses: FLOAT
    clouds: INDICES


@cache
def _falls(activity: str) -> tuple[FLOAT, FLOAT]:
    """Altitudes [m], and the logarithms of drag times of circles there [ln s m²/kg]."""
    count = round((HIGHEST_M - LOWEST_M) / ALTITUDE_STEP_M) + 1
    altitudes = np.linspace(LOWEST_M, HIGHEST_M, count)
    return altitudes, np.log(circular_drag_times(altitudes, activity))


@cache
def _areas(kind: str) -> tuple[FLOAT, FLOAT]:
    return area_shares(kind)


def fragment_area_m2() -> float:
    """Mean cross-section of a fragment (Johnson et al., 2001, equation 8)."""
    return float((0.556945 * fragment_sizes() ** 2.0047077).mean())


def _at(
    cloud: FragmentCloud, kind: str, year: float, activity: str, *, drag: bool
) -> tuple[FLOAT, FLOAT]:
    """Equation 2: altitudes of a cloud's fragments by area over mass [m], and their shares.

    The share of those that are down is 0.
    """
    areas, shares = _areas(kind)
    if not drag:
        return np.full(len(areas), cloud.altitude_m), shares
    altitudes, logs = _falls(activity)
    # Higher fragments count as there.
    whole = np.exp(np.interp(cloud.altitude_m, altitudes, logs))
    gone = DRAG_COEFFICIENT * areas * YEAR_S * (year - cloud.year)
    left = whole - gone
    at_m = np.interp(np.log(np.where(left > 0.0, left, 1.0)), logs, altitudes)
    at_m = np.where(gone > 0.0, at_m, cloud.altitude_m)
    return at_m, np.where(left > 0.0, shares, 0.0)


def fragments_by_shell(
    clouds: list[FragmentCloud], year: float, shells: AltitudeShells, activity: str, *, drag: bool
) -> FLOAT:
    """Numbers of fragments in orbit at a time, shape (shells + 2,).

    Parameters
    ----------
    clouds : list of FragmentCloud
        Made before that time.
    year : float
    shells : AltitudeShells
    activity : str
    drag : bool
    """
    found = np.zeros(shells.count + 2)
    for cloud in clouds:
        for kind, count in zip(BREAKUP_KINDS, cloud.counts, strict=True):
            at_m, shares = _at(cloud, kind, year, activity, drag=drag)
            np.add.at(found, shells.numbers(at_m), count * shares)
    return found


def rings_of(
    clouds: list[FragmentCloud], year: float, activity: str, *, drag: bool
) -> FragmentRings:
    """Fragments in orbit at a time, :data:`GROUP` bins of area over mass in a ring."""
    rows: list[tuple[float, float, float, float, int]] = []
    area_m2 = fragment_area_m2()
    for cloud in clouds:
        for kind, count in zip(BREAKUP_KINDS, cloud.counts, strict=True):
            at_m, shares = _at(cloud, kind, year, activity, drag=drag)
            masses = area_m2 / _areas(kind)[0]
            for first in range(0, len(shares), GROUP):
                some = shares[first : first + GROUP]
                number = count * some.sum()
                if number > LEAST_COUNT:
                    part = some / some.sum()
                    radius = EARTH_RADIUS_M + float(at_m[first : first + GROUP] @ part)
                    mass = float(masses[first : first + GROUP] @ part)
                    rows.append((radius, cloud.tilt, float(number), mass, cloud.number))
    radii, tilts, counts, ring_masses = np.array([row[:4] for row in rows]).reshape(-1, 4).T.copy()
    numbers = np.array([row[4] for row in rows], dtype=np.int64)
    return FragmentRings(radii, tilts, counts, ring_masses, numbers)


COLLISIONS, EXPLOSIONS, EXPLOSION_TIMES, CAPTURES, CAMPAIGN_LOSSES, FRAGMENT_HITS = range(1, 7)
"""Kinds of draws."""

MOST_HITS = 1000
"""Maximum number of collisions of a block of pairs in a year."""


Found = tuple[FLOAT, FLOAT]
"""Sums of rates, and a row for each drawn collision."""


def collisions_of(
    population: ObjectPopulation, rings: FragmentRings, seed: int, year: int, jobs: int
) -> tuple[YearRates, list[Collision]]:
    """Rates of all pairs and of all objects with fragments, and the collisions drawn for the year.

    Parameters
    ----------
    population : ObjectPopulation
    rings : FragmentRings
    seed, year : int
    jobs : int
        Number of threads, 0 for all cores; results do not depend on it.

    Raises
    ------
    InputError
        Collisions are too frequent for the year to be taken as one step.
    """
    bodies = population.bodies
    order = np.argsort(bodies.shells[:, 0], kind="stable")
    shells, tilts, widths, masses = (
        np.ascontiguousarray(column[order])
        for column in (bodies.shells, bodies.tilts, 0.5 * bodies.sizes, bodies.masses)
    )
    numbers = np.ascontiguousarray(population.numbers[order])
    count = len(numbers)
    tables = CollisionTables(
        mean_speeds(), np.zeros((2, 2, 2)), 0.0, 1.0, 1.0, FRAGMENTS, CATASTROPHIC_J_KG, YEAR_S
    )
    objects = _objects(shells, tilts, widths, masses)
    half = 0.5 * LEAST_WIDTH_M
    wide = math.sqrt(fragment_area_m2() / math.pi)
    both = _objects(
        np.concatenate((shells, np.column_stack((rings.radii - half, rings.radii + half)))),
        np.concatenate((tilts, rings.tilts)),
        np.concatenate((widths, np.full(len(rings.radii), wide))),
        np.concatenate((masses, rings.masses)),
    )

    of = HitKeys(numbers, rings.counts, rings.clouds)

    def pairs(ends: tuple[int, int], sums: FLOAT, hits: FLOAT) -> int:
        keys = (seed, year, COLLISIONS)
        return int(drawn_collisions(objects, tables, numbers, keys, *ends, sums, hits))

    def with_fragments(ends: tuple[int, int], sums: FLOAT, hits: FLOAT) -> int:
        keys = (seed, year, FRAGMENT_HITS)
        return int(fragment_hits(both, tables, of, keys, *ends, sums, hits))

    def block(ends: tuple[int, int]) -> tuple[Found, Found]:
        return _found(pairs, ends, year), _found(with_fragments, ends, year)

    with ThreadPoolExecutor(threads(jobs)) as pool:
        parts = list(pool.map(block, block_ends(count)))
    first, second = (
        np.sum([np.zeros(3), *(part[which][0] for part in parts)], axis=0).tolist()
        for which in (0, 1)
    )
    collisions = []
    for found, (_, hits) in parts:
        for i, j, time, radius, made, catastrophic in found[1].tolist():
            pair = sorted((int(i), int(j)), key=lambda at: (-masses[at], numbers[at]))
            collisions.append(
                Collision(
                    time,
                    int(numbers[pair[0]]),
                    int(numbers[pair[1]]),
                    radius - EARTH_RADIUS_M,
                    made,
                    bool(catastrophic),
                )
            )
        for i, cloud, time, radius, made, catastrophic in hits.tolist():
            altitude_m = radius - EARTH_RADIUS_M
            one, fragment = int(numbers[int(i)]), -1 - int(cloud)
            collisions.append(Collision(time, one, fragment, altitude_m, made, bool(catastrophic)))
    rates = YearRates(first[0], first[1], first[2] + second[2], second[0], second[1])
    return rates, sorted(collisions)


def _objects(shells: FLOAT, tilts: FLOAT, widths: FLOAT, masses: FLOAT) -> CollidingObjects:
    whole = np.zeros(len(tilts), dtype=np.int64)
    return CollidingObjects(shells, tilts, widths, masses, np.zeros(len(tilts)), whole, whole)


def _found(
    draw: Callable[[tuple[int, int], FLOAT, FLOAT], int], ends: tuple[int, int], year: int
) -> Found:
    sums, hits = np.zeros(3), np.zeros((MOST_HITS, 6))
    found = draw(ends, sums, hits)
    if found > MOST_HITS:
        raise InputError(
            f"year {year}: more than {MOST_HITS} collisions; the population is too dense for "
            "steps of a year"
        )
    return sums, hits[:found]


def explosions_of(
    population: ObjectPopulation, settings: ScenarioSettings, seed: int, year: int
) -> list[Explosion]:
    """Explosions drawn for a year; debris does not explode."""
    if settings.explosions == 0.0:
        return []
    whole = population.numbers[population.kinds != KINDS.index("debris")]
    drawn = keyed_draws(seed, year, EXPLOSIONS, whole)
    exploding = whole[drawn < settings.explosions]
    times = keyed_draws(seed, year, EXPLOSION_TIMES, exploding)
    return sorted(map(Explosion, times.tolist(), exploding.tolist()))
