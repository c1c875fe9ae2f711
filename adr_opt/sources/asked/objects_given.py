"""The choice of objects of an import as options give it."""

from __future__ import annotations

from collections.abc import Iterable

from ...common.errors import InputError
from .fitting import check_positive


def check_objects(names: Iterable[str], max_targets: int | None) -> None:
    """Refuse names that choose nothing, and a number of targets that is none.

    Parameters
    ----------
    names : iterable of str
        Parts of names, or patterns.
    max_targets : int or None

    Raises
    ------
    InputError
    """
    if any(not name.strip() for name in names):
        raise InputError("--name '': give a part of a name or a pattern")
    check_positive(max_targets=max_targets)
