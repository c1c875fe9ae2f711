"""Capture windows found for the targets of a mission, and the mission without them."""

from __future__ import annotations

from pathlib import Path

from ...problem.capture_windows import FileWindows
from ...problem.instance import Instance
from .history import History
from .project.plan_files import FIELD, INSTANCE
from .project.results import Results

WINDOWS = "windows.csv"


def place_of(field: Instance, results: Results) -> Path | None:
    """Folder of the result whose windows a mission uses; None if it has its own or none.

    Parameters
    ----------
    field : Instance
    results : Results
    """
    if field.windows is None:
        return None
    for record in reversed(results.all()):
        if record.verb == "windows":
            place = results.place(record.number)
            windows = FileWindows((place / WINDOWS).read_bytes(), {})
            if windows.sha256 == field.windows.sha256:
                return place
    return None


def whose(history: History, results: Results) -> str | None:
    """Origin of targets' windows: "found", or "given" with the mission; None without any."""
    if not history.has_mission or history.draft.field.windows is None:
        return None
    return "given" if place_of(history.draft.field, results) is None else "found"


def without(field: Instance, results: Results) -> Instance:
    """A mission with its original windows.

    Raises
    ------
    InputError
        The result that found others is spoilt.
    """
    place = place_of(field, results)
    return field if place is None else field.with_windows_of(Instance.load(place / FIELD))


def found_for(field: Instance, results: Results, number: int) -> Instance | None:
    """A mission with the windows of a result; None if they were found for another mission.

    Raises
    ------
    InputError
        A result is spoilt.
    """
    made = without(field, results)
    if made.sha256 != results.record(number).instance_sha256:
        return None
    return made.with_windows_of(Instance.load(results.place(number) / INSTANCE))
