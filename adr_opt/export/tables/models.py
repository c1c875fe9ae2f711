"""Mathematical models of a mission as files, such as ``.lp``, from installed packages.

How a mission is stated for a solver is an answer, not the problem, so the statements live with
the planners; like planners they are found through an entry point. Its name in the group
:data:`MODELS` is the suffix without the dot, and it names a callable ``(mission, path)`` that
writes the file, or raises :class:`adr_opt.common.errors.InputError` with one sentence that says why
not.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import entry_points
from pathlib import Path

from ...common.errors import InputError
from ...common.packages import load
from ...mission.mission import Mission

MODELS = "adr_opt.models"
"""Entry-point group; a package that declares it adds its formats to ``matrix``."""

WriteModel = Callable[[Mission, Path], None]


def suffixes() -> tuple[str, ...]:
    """Suffixes of the installed model formats, with the dot, sorted; nothing is imported."""
    return tuple(sorted({f".{entry.name}" for entry in entry_points(group=MODELS)}))


def writer(suffix: str) -> WriteModel:
    """The writer of files with an installed suffix.

    Raises
    ------
    InputError
        It is declared but cannot be imported.
    """
    (entry, *_) = entry_points(group=MODELS, name=suffix.removeprefix("."))
    try:
        found: WriteModel = load(entry)
    except (ImportError, AttributeError) as error:
        raise InputError(
            f"format {suffix!r} is declared, but cannot be imported ({error}); "
            "reinstall the package that declares it"
        ) from error
    return found
