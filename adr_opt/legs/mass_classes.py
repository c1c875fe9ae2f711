"""Connections of chasers with low thrust by class of mass (docs/model.md section 11.4)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from ..kernels.legs.found import ConnectionArrays
from .connections import Connections
from .families.family import LegFamily, PairEnds


def of_mass(ends: PairEnds, mass_kg: float | None) -> PairEnds:
    """The ends of a pair for chasers of a class with a largest mass [kg]; None for the heaviest."""
    if ends.drive is None or mass_kg is None:
        return ends
    return ends._replace(drive=ends.drive._replace(heaviest_kg=mass_kg))


def lighter(
    family: LegFamily,
    ends: PairEnds,
    heaviest: ConnectionArrays,
    classes_kg: Sequence[float],
    resolution_m_s: float,
) -> Iterator[tuple[float, ConnectionArrays]]:
    """The connections of a pair by class of mass, without those that heavier classes dominate.

    Parameters
    ----------
    family : LegFamily
        That knows of masses.
    ends : PairEnds
    heaviest : ConnectionArrays
        Those of the heaviest class.
    classes_kg : sequence of float
        Largest mass of each lighter class, the heaviest first [kg].
    resolution_m_s : float
        A connection that saves no more than this is dominated [m/s].
    """
    known = ConnectionArrays(*(column[heaviest.family == family.number] for column in heaviest))
    for mass_kg in classes_kg:
        found = family.of_class(of_mass(ends, mass_kg), known, resolution_m_s)
        yield mass_kg, found
        known = _joined((known, found))


def by_departure(classes: Iterable[tuple[float, ConnectionArrays]]) -> Connections:
    """Connections of several classes together, from their largest masses [kg], +inf for any."""
    masses_kg, parts = zip(*classes, strict=True)
    mass_kg = np.repeat(masses_kg, [part.departure.size for part in parts])
    found = ConnectionArrays(*map(np.concatenate, zip(*parts, strict=True)))
    order = np.lexsort((found.arrival, found.departure))
    found = ConnectionArrays(*(column[order] for column in found))
    return Connections(
        found.departure,
        found.arrival,
        found.delta_v,
        found.revolutions,
        found.family,
        mass_kg[order],
    )


def _joined(parts: tuple[ConnectionArrays, ConnectionArrays]) -> ConnectionArrays:
    """Connections in order of departure."""
    found = ConnectionArrays(*map(np.concatenate, zip(*parts, strict=True)))
    order = np.argsort(found.departure, kind="stable")
    return ConnectionArrays(*(column[order] for column in found))
