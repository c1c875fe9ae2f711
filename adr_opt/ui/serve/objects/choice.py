"""A mission of chosen objects, made as ``import`` makes it."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from ....common.errors import InputError
from ....problem.instance import Instance
from ....sources import catalogue
from ....sources.catalogue.finding import Finder
from ....sources.catalogue.records import ElementSet
from ....sources.ephemerides.imported import with_ephemerides
from .import_options import ImportWanted


class MissionMade(NamedTuple):
    """A mission with an account of its making.

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
        """The account as JSON data."""
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
