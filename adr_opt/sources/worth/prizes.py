"""Prizes for instances: additive worths, in whole multiples of a unit, as CSV files."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...common.constants import DAY_S
from ...common.errors import InputError
from ...problem.air import FLOAT, YEAR_S
from ..catalogue.records import ElementSet
from ..csv_table import csv_text
from .bodies import ends_km
from .pairs import INDICES
from .worth import UNIT, RemovalWorth

DIGITS = 5
"""Digits of the largest prize, unless a unit is given."""

_DETAILS = """
object name prize unit worth_alone floor kind mass_kg mass_source size_m size_source
area_to_mass_m2_kg area_source perigee_km apogee_km inclination_deg lifetime_years
encounters_per_year catastrophic_per_year worst_partner worst_partner_worth
"""
DETAILS = tuple(_DETAILS.split())
"""Columns of the file of details; worths are in fragment-years, the prize in units."""


@dataclass(frozen=True)
class RemovalPrizes:
    """Prizes of the candidates for removal.

    Attributes
    ----------
    worth : RemovalWorth
    candidates : (candidate,) int64
        Objects, the largest worth alone first.
    floors : (candidate,) float64
        Worths that add up [fragment-years].
    unit : float
        [fragment-years].
    prizes : (candidate,) float64
        Floors in whole units, rounded down, so that no set is overrated.
    falling : tuple of (candidate,) float64
        Prizes of removals by the end of each year, the first one first; empty for prizes that do
        not fall.
    """

    worth: RemovalWorth
    candidates: INDICES
    floors: FLOAT
    unit: float
    prizes: FLOAT
    falling: tuple[FLOAT, ...] = ()

    @property
    def unit_text(self) -> str:
        """The unit in words."""
        return f"{self.unit:g} {UNIT}"

    def prizes_csv(self) -> str:
        """Table of prizes and masses, as read by ``import --prizes``.

        A removal after the last year of falling prizes is worth nothing that is known.
        """
        bodies = self.worth.bodies
        rows = [
            (
                reference(bodies.records[at]),
                "0" if self.falling else f"{prize:.0f}",
                f"{bodies.masses[at]:.6g}",
                *self._until(place),
            )
            for place, (at, prize) in enumerate(zip(self.candidates, self.prizes, strict=True))
        ]
        return csv_text(
            ("object", "prize", "mass", *(["prize_until"] if self.falling else [])), rows
        )

    def _until(self, place: int) -> tuple[str, ...]:
        """Falling prizes of a candidate, each with the days by which it has to be removed."""
        if not self.falling:
            return ()
        return (
            " ".join(
                f"{year * YEAR_S / DAY_S:g}:{prizes[place]:.0f}"
                for year, prizes in enumerate(self.falling, start=1)
            ),
        )

    def details_csv(self) -> str:
        """Table of all data on the candidates, with the columns :data:`DETAILS`."""
        return csv_text(DETAILS, [self._detail(place) for place in range(len(self.candidates))])

    def _detail(self, place: int) -> tuple[object, ...]:
        worth, at = self.worth, int(self.candidates[place])
        bodies = worth.bodies
        record, partner = bodies.records[at], int(worth.partners[at])
        perigee_km, apogee_km = ends_km(record)
        return (
            reference(record),
            record.label,
            f"{self.prizes[place]:.0f}",
            self.unit_text,
            f"{worth.alone[at]:.8g}",
            f"{self.floors[place]:.8g}",
            bodies.kinds[at],
            f"{bodies.masses[at]:.6g}",
            bodies.mass_sources[at],
            f"{bodies.sizes[at]:.4g}",
            bodies.size_sources[at],
            f"{bodies.areas[at]:.4g}",
            bodies.area_sources[at],
            f"{perigee_km:.1f}",
            f"{apogee_km:.1f}",
            f"{record.inclination_deg:.3f}",
            f"{worth.lives[at]:.4g}",
            f"{worth.encounters[at]:.5g}",
            f"{worth.catastrophic[at]:.5g}",
            "" if partner < 0 else bodies.records[partner].label,
            f"{worth.partner_worths[at]:.5g}",
        )


def usual_unit(largest: float) -> float:
    """The power of ten with which the largest floor is a prize of :data:`DIGITS` digits."""
    return 10.0 ** (math.floor(math.log10(largest)) - DIGITS + 1) if largest > 0.0 else 1.0


def prizes_of(
    worth: RemovalWorth,
    candidates: int,
    unit: float | None = None,
    jobs: int = 0,
    *,
    later: Sequence[RemovalWorth] = (),
) -> RemovalPrizes:
    """Prizes of the objects of the largest worth.

    Parameters
    ----------
    worth : RemovalWorth
    candidates : int
        Number of them; 0 for all objects. The fewer, the closer floors are to worths alone.
    unit : float, optional
        [fragment-years]; by default the power of ten with which the largest prize has
        :data:`DIGITS` digits.
    jobs : int
        Number of threads; 0 for all cores.
    later : sequence of RemovalWorth
        Of removals at the end of each year, for prizes that fall.

    Raises
    ------
    InputError
        A number is out of range.
    """
    if candidates < 0:
        raise InputError(f"--candidates {candidates}: must be at least 0, for all objects")
    if unit is not None and not 0.0 < unit < math.inf:
        raise InputError(f"--unit {unit:g}: must be a positive number of {UNIT}")
    chosen = worth.best(candidates or len(worth.bodies))
    floors = np.maximum(worth.floors(chosen, jobs), 0.0)
    if unit is None:
        unit = usual_unit(float(floors.max()))
    falling = []
    most = np.floor(floors / unit)
    for each in later:
        # Rounding of sums must not let a prize rise.
        most = np.minimum(most, np.floor(np.maximum(each.floors(chosen, jobs), 0.0) / unit))
        falling.append(most)
    return RemovalPrizes(worth, chosen, floors, unit, np.floor(floors / unit), tuple(falling))


def reference(record: ElementSet) -> str:
    """Number, designator or name by which a table denotes an object."""
    return str(record.number) if record.number else record.designator or record.label
