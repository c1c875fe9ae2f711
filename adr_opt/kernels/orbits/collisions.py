"""Expected fragment-years of collisions, for all pairs of many objects (docs/worth.md)."""

from typing import NamedTuple

import numpy as np

from ..core.compile import inlined, kernel
from ..core.memory import borrowed
from .encounters import between, encounter_rate


class CollidingObjects(NamedTuple):
    """Objects as arrays, in ascending order of perigee.

    Attributes
    ----------
    shells : (object, 2) float64
        Radii of perigee and apogee [m].
    tilts : (object,) float64
        Inclinations [rad].
    widths : (object,) float64
        Radii [m].
    masses : (object,) float64
        [kg].
    lives : (object,) float64
        Time that they stay, at most the horizon [years].
    kinds : (object,) int64
        Kind of fragments that they break up into.
    cells : (object,) int64
        Cell of altitude and inclination that they count in.
    """

    shells: np.ndarray
    tilts: np.ndarray
    widths: np.ndarray
    masses: np.ndarray
    lives: np.ndarray
    kinds: np.ndarray
    cells: np.ndarray


class CollisionTables(NamedTuple):
    """Tables and constants that give the weight of a collision.

    Attributes
    ----------
    speeds : (tilt, tilt) float64
        Mean relative speed of encounters over the speed of both, by inclinations from 0° to 180°.
    years : (kind, altitude, exposure) float64
        Fragment-years per yearly fragment [years²].
    floor, rise : float
        Lowest radius of that table, and its step [m].
    exposure : float
        Step of durations of that table [years].
    fragments : float
        Fragments of an effective mass of 1 kg.
    threshold : float
        Energy over mass of a catastrophic collision [J/kg].
    year : float
        [s].
    """

    speeds: np.ndarray
    years: np.ndarray
    floor: float
    rise: float
    exposure: float
    fragments: float
    threshold: float
    year: float


@inlined
def outcome(objects, tables, i, j):
    """Encounter rate of a pair, and the fragments of a collision between the two.

    Parameters
    ----------
    objects : CollidingObjects
    tables : CollisionTables
    i, j : int

    Returns
    -------
    rate : float
        [1/year].
    radius : float
        Where they meet [m].
    made : float
        Equation 4: number of fragments.
    catastrophic : bool
    """
    rate, radius, speed = encounter_rate(
        objects.shells, objects.tilts, objects.widths, tables.speeds, i, j
    )
    if rate == 0.0:
        return 0.0, 0.0, 0.0, False
    light = min(objects.masses[i], objects.masses[j])
    heavy = max(objects.masses[i], objects.masses[j])
    catastrophic = 0.5 * light * speed**2 >= tables.threshold * heavy
    effective = light + heavy if catastrophic else light * speed / 1000.0
    return rate * tables.year, radius, tables.fragments * effective**0.75, catastrophic


@kernel
def collision(objects, tables, i, j):
    """Encounter rate of a pair, and its expected fragment-years.

    Parameters
    ----------
    objects : CollidingObjects
    tables : CollisionTables
    i, j : int

    Returns
    -------
    rate : float
        [1/year].
    worth : float
        Equation 8: expected fragment-years within the horizon.
    catastrophic : bool
    """
    rate, radius, made, catastrophic = outcome(objects, tables, i, j)
    if rate == 0.0:
        return 0.0, 0.0, False
    exposure = min(objects.lives[i], objects.lives[j]) / tables.exposure
    row = (radius - tables.floor) / tables.rise
    stay = objects.masses[i] * between(tables.years[objects.kinds[i]], row, exposure)
    stay += objects.masses[j] * between(tables.years[objects.kinds[j]], row, exposure)
    worth = rate * made * stay / (objects.masses[i] + objects.masses[j])
    return rate, worth, catastrophic


@kernel
def all_collisions(objects, tables, first, last, sums, partners, cells):
    """Sums over the pairs of each object of a block with all objects after it.

    Parameters
    ----------
    objects : CollidingObjects
    tables : CollisionTables
    first, last : int
        Objects of the block, which ends before the last.
    sums : (object, 4) float64
        Increased: worth, encounter rate, rate of catastrophic ones, largest worth of a pair.
    partners : (object,) int64
        Set: the other object of that pair.
    cells : (cell, cell) float64
        Increased: worth of pairs of two cells; each pair once, in the cell of the first object.
    """
    objects, tables = borrowed(objects), borrowed(tables)
    for i in range(first, last):
        for j in range(i + 1, objects.tilts.size):
            if objects.shells[j, 0] >= objects.shells[i, 1]:
                break
            rate, worth, catastrophic = collision(objects, tables, i, j)
            cells[objects.cells[i], objects.cells[j]] += worth
            for one, other in ((i, j), (j, i)):
                sums[one, 0] += worth
                sums[one, 1] += rate
                if catastrophic:
                    sums[one, 2] += rate
                if worth > sums[one, 3]:
                    sums[one, 3] = worth
                    partners[one] = other


@kernel
def worths_with(objects, tables, one, some):
    """Worth of the pairs that one object forms with each of several others.

    Parameters
    ----------
    objects : CollidingObjects
    tables : CollisionTables
    one : int
    some : (n,) int64

    Returns
    -------
    (n,) float64
        0 for the object itself [fragment-years].
    """
    found = np.zeros(some.size)
    for place in range(some.size):
        if some[place] != one:
            first, second = min(one, some[place]), max(one, some[place])
            found[place] = collision(objects, tables, first, second)[1]
    return found


@kernel
def shared_worths(objects, tables, some, first, last, sums):
    """Worth that each object of a set shares with the rest of the set, for a block of rows.

    Parameters
    ----------
    objects : CollidingObjects
    tables : CollisionTables
    some : (n,) int64
        In ascending order.
    first, last : int
        Rows of the block, which ends before the last.
    sums : (n,) float64
        Increased [fragment-years].
    """
    objects, tables = borrowed(objects), borrowed(tables)
    for row in range(first, last):
        for column in range(row + 1, some.size):
            if objects.shells[some[column], 0] >= objects.shells[some[row], 1]:
                break
            worth = collision(objects, tables, some[row], some[column])[1]
            sums[row] += worth
            sums[column] += worth
