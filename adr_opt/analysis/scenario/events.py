"""Rates of a year, and its collisions and explosions as drawn (docs/scenarios.md)."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ...common.constants import EARTH_RADIUS_M
from ...common.errors import InputError
from ...kernels.orbits.collisions import CollidingObjects, CollisionTables
from ...kernels.orbits.drawn_collisions import drawn_collisions
from ...kernels.orbits.keyed_draws import keyed_draws
from ...sources.worth.air import FLOAT
from ...sources.worth.breakup import CATASTROPHIC_J_KG, FRAGMENTS
from ...sources.worth.lifetimes import YEAR_S
from ...sources.worth.pairs import block_ends, threads
from ...sources.worth.speeds import mean_speeds
from .population import ObjectPopulation
from .records import Collision, Explosion, YearRates
from .settings import KINDS, ScenarioSettings

COLLISIONS, EXPLOSIONS, EXPLOSION_TIMES, CAPTURES, CAMPAIGNS = 1, 2, 3, 4, 5
"""Kinds of draws."""

MOST_HITS = 1000
"""Collisions that a block of pairs may have in a year."""


def collisions_of(
    population: ObjectPopulation, seed: int, year: int, jobs: int
) -> tuple[YearRates, list[Collision]]:
    """Rates of all pairs, and the collisions drawn for the year.

    Parameters
    ----------
    population : ObjectPopulation
    seed, year : int
    jobs : int
        Number of threads, 0 for all cores; results do not depend on it.

    Raises
    ------
    InputError
        So many collisions happen that the year cannot be taken as one step.
    """
    if len(population) < 2:
        return YearRates(0.0, 0.0, 0.0), []
    bodies = population.bodies
    order = np.argsort(bodies.shells[:, 0], kind="stable")
    count = len(order)
    shells, tilts, widths, masses = (
        np.ascontiguousarray(column[order])
        for column in (bodies.shells, bodies.tilts, 0.5 * bodies.sizes, bodies.masses)
    )
    whole = np.zeros(count, dtype=np.int64)
    objects = CollidingObjects(shells, tilts, widths, masses, np.zeros(count), whole, whole)
    tables = CollisionTables(
        mean_speeds(), np.zeros((2, 2, 2)), 0.0, 1.0, 1.0, FRAGMENTS, CATASTROPHIC_J_KG, YEAR_S
    )
    numbers = np.ascontiguousarray(population.numbers[order])

    def block(ends: tuple[int, int]) -> tuple[FLOAT, FLOAT]:
        sums, hits = np.zeros(3), np.zeros((MOST_HITS, 6))
        keys = (seed, year, COLLISIONS)
        found = drawn_collisions(objects, tables, numbers, keys, *ends, sums, hits)
        if found > MOST_HITS:
            raise InputError(
                f"year {year}: more than {MOST_HITS} collisions; the population is too dense for "
                "steps of a year"
            )
        return sums, hits[:found]

    with ThreadPoolExecutor(threads(jobs)) as pool:
        parts = list(pool.map(block, block_ends(count)))
    sums = np.sum([part for part, _ in parts], axis=0)
    collisions = []
    for _, hits in parts:
        for i, j, time, radius, made, catastrophic in hits.tolist():
            pair = sorted((int(i), int(j)), key=lambda at: (-masses[at], numbers[at]))
            collisions.append(
                Collision(
                    time, int(numbers[pair[0]]), int(numbers[pair[1]]), radius - EARTH_RADIUS_M,
                    made, bool(catastrophic),
                )
            )  # fmt: skip
    return YearRates(*sums.tolist()), sorted(collisions)


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
