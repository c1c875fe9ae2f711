"""Masses and sizes of a catalogue for ``worth`` and ``scenario``, and what is said of them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

from ...common.wording import counted

if TYPE_CHECKING:
    from ...sources.catalogue import ElementSet
    from ...sources.worth import Bodies, Satcat

FEW = 0.5
"""Share of objects found in the satcat below which another date is suspected."""


def measured_bodies(
    records: Sequence[ElementSet],
    satcat: Satcat | None,
    satcat_path: str | None,
    table_path: str | None,
    excluded: Collection[str],
) -> tuple[Bodies, list[str]]:
    """Orbits, masses and sizes, and notes: rows without an object, masses that are defaults.

    Raises
    ------
    InputError
        As for :func:`adr_opt.sources.worth.read_measures`.
    """
    from ...sources import worth

    table = None if table_path is None else worth.read_measures(table_path, records)
    bodies = worth.bodies_of(records, satcat, table and table.known, excluded)
    notes = []
    if table is not None and table.strange:
        notes.append(
            f"note: {table_path}: {counted(len(table.strange), 'object')} not in the catalogue, "
            f"{table.strange[0]!r} for one; left out"
        )
    if satcat is not None and bodies.matched < FEW * len(bodies):
        of_when = f"the file of {satcat.updated}" if satcat.updated else "the file"
        notes.append(
            f"warning: {satcat_path}: {of_when} has {bodies.matched} of "
            f"{counted(len(bodies), 'object')}; the others have default masses"
        )
    defaults = bodies.default_masses
    if satcat is None and defaults:
        notes.append(
            f"note: {sum(defaults.values())} of {counted(len(bodies), 'mass', 'masses')} are "
            "defaults: "
            + ", ".join(f"{what} {count}" for what, count in defaults.items())
            + "; --satcat or --table knows them better"
        )
    return bodies, notes
