"""The dropped catalogue as the page shows it: columns of all objects."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

from ....common.errors import InputError
from ....sources import catalogue, worth
from ....sources.catalogue.assemble import unique
from ....sources.catalogue.finding import Finder
from ....sources.catalogue.reading import joined
from ....sources.catalogue.records import ElementSet
from ....sources.worth.bodies import DEFAULT

MOST_OBJECTS = 100_000
"""Maximum number of objects that are shown."""


class CatalogueView:
    """Objects of catalogue files, bad rows and older duplicates left out.

    Parameters
    ----------
    parts : iterable of Catalogue
        Content of each file.
    satcat : path, optional
        General Catalog, for masses and kinds.

    Raises
    ------
    InputError
        A file is spoilt, or there are too many objects.
    """

    def __init__(self, parts: Iterable[catalogue.Catalogue], satcat: Path | None) -> None:
        found = joined(parts, skip_bad=True)
        if len(found.records) > MOST_OBJECTS:
            raise InputError(
                f"{len(found.records)} objects; at most {MOST_OBJECTS} are shown, drop a part of "
                "the catalogue"
            )
        self.records = found.records
        self.skipped = len(found.dropped)
        self._satcat = None if satcat is None else worth.read_satcat(satcat)

    @cached_property
    def names(self) -> list[str]:
        """Names as the targets of an instance have them, all different."""
        return unique([record.label for record in self.records], set())

    @cached_property
    def rows(self) -> dict[str, int]:
        """Rows by name."""
        return {name: row for row, name in enumerate(self.names)}

    @cached_property
    def columns(self) -> dict[str, Any]:
        """Columns as JSON data, without worths."""
        seen = catalogue.overview(self.records)
        bodies = worth.bodies_of(self.records, self._satcat)
        known = {id(record): at for at, record in enumerate(bodies.records)}
        at_rows = [known.get(id(record)) for record in self.records]
        return {
            "names": self.names,
            "altitude_km": [round(float(value), 2) for value in seen.altitude_km],
            "eccentricity": [round(float(value), 6) for value in seen.eccentricity],
            "inclination_deg": [round(float(value), 3) for value in seen.inclination_deg],
            "raan_deg": [round(float(value), 3) for value in seen.raan_deg],
            "mass_kg": [
                None
                if at is None or bodies.mass_sources[at].startswith(DEFAULT)
                else round(float(bodies.masses[at]), 1)
                for at in at_rows
            ],
            "kind": [None if at is None else bodies.kinds[at] for at in at_rows],
            "epoch": seen.epoch.isoformat().replace("+00:00", "Z"),
            "skipped": self.skipped,
        }

    def chosen(self, names: Sequence[str]) -> list[ElementSet]:
        """Records by the names that :attr:`names` has.

        Raises
        ------
        InputError
            One is not among them.
        """
        strange = [name for name in names if name not in self.rows]
        if strange:
            raise InputError(f"{strange[0][:80]!r} is no object of the catalogue")
        return [self.records[row] for row in sorted({self.rows[name] for name in names})]

    def by_object(self, values: Mapping[str, float]) -> list[float | None]:
        """Values given by number, name or designator, for each object; None for those without."""
        finder = Finder(self.records)
        found: list[float | None] = [None] * len(self.records)
        for said, value in values.items():
            rows = finder.all(said)
            if len(rows) == 1 and math.isfinite(value):
                found[rows[0]] = value
        return found
