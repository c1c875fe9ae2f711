"""The dropped catalogue as columns, and the mission made of chosen objects."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from ....common.errors import InputError
from ....problem.instance import Instance
from ....sources import catalogue, worth
from ....sources.catalogue.assemble import unique
from ....sources.catalogue.finding import Finder
from ....sources.catalogue.reading import joined
from ....sources.catalogue.records import ElementSet
from ....sources.ephemerides.imported import with_ephemerides
from ....sources.worth.bodies import DEFAULT
from .import_options import ImportWanted

MOST_OBJECTS = 100_000
"""Maximum number of objects shown."""


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
            raise InputError(f"{strange[0][:80]!r} is not an object of the catalogue")
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


class MissionMade(NamedTuple):
    """A mission with a record of its import.

    Attributes
    ----------
    instance : Instance
    counts : dict
        Number of chosen objects that are no targets, by reason.
    warnings : tuple of str
    """

    instance: Instance
    counts: dict[str, int]
    warnings: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """The record as JSON data."""
        return {
            "targets": len(self.instance.targets),
            "left_out": self.counts,
            "warnings": list(self.warnings),
        }


def mission_of(
    records: Sequence[ElementSet],
    wanted: ImportWanted,
    prizes: Path | None,
    messages: Sequence[Path],
    folder: Callable[[], Path],
) -> MissionMade:
    """The mission that ``import`` makes of objects, by default with one chaser.

    Parameters
    ----------
    records : sequence of ElementSet
        The objects; those that SGP4 cannot bring to the epoch are left out.
    wanted : ImportWanted
    prizes : path, optional
        Table of prizes, as ``--prizes`` takes it.
    messages : sequence of path
        OEM files, as ``--oem`` takes them.
    folder : callable
        Makes a folder for the instance file with its ephemerides; it is removed again.

    Raises
    ------
    InputError
        As of ``import``.
    """
    finder = Finder(records)
    wishes = () if prizes is None else catalogue.read_wishes(prizes)
    of_these = tuple(wish for wish in wishes if len(finder.all(wish.said)) == 1)
    if prizes is not None and not of_these:
        raise InputError("none of the chosen objects has a prize in the table; choose others")
    made = catalogue.to_instance(
        catalogue.Catalogue(tuple(records)),
        filters=wanted.filters,
        max_targets=wanted.max_targets,
        station=wanted.station,
        skip_bad=True,
        mission=wanted.mission,
        crew=wanted.crew,
        demands=replace(wanted.demands, wishes=of_these),
    )
    if not (messages or wanted.ephemerides):
        return MissionMade(made.instance, made.counts, made.warnings)
    place = folder()
    try:
        fitted = with_ephemerides(made, place / "instance.json", messages)
        fitted.write(place / "instance.json")
        instance = Instance.load(place / "instance.json")
    finally:
        shutil.rmtree(place, ignore_errors=True)
    return MissionMade(instance, made.counts, made.warnings)
