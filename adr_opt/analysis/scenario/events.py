"""Rates of a year, and its collisions and explosions as drawn (docs/scenarios.md)."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ...common.constants import EARTH_RADIUS_M
from ...common.errors import InputError
from ...kernels.orbits.collisions import CollidingObjects, CollisionTables
from ...kernels.orbits.drawn_collisions import HitKeys, drawn_collisions, fragment_hits
from ...kernels.orbits.encounters import LEAST_WIDTH_M
from ...kernels.orbits.keyed_draws import keyed_draws
from ...sources.worth.air import FLOAT, YEAR_S
from ...sources.worth.breakup import CATASTROPHIC_J_KG, FRAGMENTS
from ...sources.worth.pairs import block_ends, mean_speeds, threads
from .clouds import FragmentRings, fragment_area_m2
from .population import ObjectPopulation
from .records import Collision, Explosion, YearRates
from .settings import KINDS, ScenarioSettings

COLLISIONS, EXPLOSIONS, EXPLOSION_TIMES, CAPTURES, CAMPAIGNS, FRAGMENT_HITS = range(1, 7)
"""Kinds of draws."""

MOST_HITS = 1000
"""Collisions that a block of pairs may have in a year."""


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
