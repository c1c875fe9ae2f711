"""A mission of chosen objects, made as ``import`` makes it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ....common.errors import InputError
from ....problem.instance import Instance
from ....sources import catalogue
from ....sources.catalogue.finding import Finder
from ....sources.catalogue.records import ElementSet
from ....sources.ephemerides.imported import with_ephemerides


def mission_of(
    records: Sequence[ElementSet],
    prizes: Path | None,
    messages: Sequence[Path],
    place: Path,
) -> Instance:
    """The mission that ``import`` makes of objects, by default with one chaser.

    Parameters
    ----------
    records : sequence of ElementSet
        The objects; those that SGP4 cannot bring to the epoch are left out.
    prizes : path, optional
        Table of prizes, as ``--prizes`` takes it.
    messages : sequence of path
        OEM files, as ``--oem`` takes them.
    place : path
        Folder for the instance file with its ephemerides, where there are messages.

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
        skip_bad=True,
        demands=catalogue.Demands(wishes=of_these),
    )
    if not messages:
        return made.instance
    fitted = with_ephemerides(made, place / "instance.json", messages)
    fitted.write(place / "instance.json")
    return Instance.load(place / "instance.json")
