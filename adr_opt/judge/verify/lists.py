"""Lists of closed labels, read from a file or recorded, one for each claim on walks.

A list may have the row of a label that dominates each end of a leg, so that who checks it need not
look for one. Nothing of it is trusted.
"""

from __future__ import annotations

import os
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...plan.certificate import Certificate
from ...plan.label_lists import ColumnKind, load_lists, save_lists
from .closed import ClosedLabels, Finder

Array = npt.NDArray[Any]

KINDS = {
    name: ColumnKind(name not in ("time", "left"), 1 + (name in ("counts", "memory", "odd")))
    for name in ClosedLabels._fields
} | {"row": ColumnKind(whole=True, aside=True)}
"""Columns of a file."""


class ListedLabels(NamedTuple):
    """The list of labels for one claim.

    Attributes
    ----------
    labels : ClosedLabels
    row : (ends,) int64 or None
        For the starts, and for the ends of the legs of each label, in order of legs, the row of a
        label that dominates it.
    """

    labels: ClosedLabels
    row: Array | None

    def find(self, search: Finder) -> Finder:
        """Rows of the file in order; rows of a search if there is no file."""
        if self.row is None:
            return search
        rows, at = self.row, 0

        def told(ends: ClosedLabels) -> Array:
            nonlocal at
            part, at = rows[at : at + ends.body.size], at + ends.body.size
            return np.append(part, np.full(ends.body.size - part.size, -1))

        return told


class Lists:
    """The lists of a certificate, to be checked in order or to be written.

    Parameters
    ----------
    listed : sequence of Listed
        Those to be checked; where there are no more, they are made.
    """

    def __init__(self, *listed: ListedLabels) -> None:
        self._given = list(listed)
        self.checked: list[ListedLabels] = []

    def next(self) -> ListedLabels | None:
        """The list of the next claim, if the file has one."""
        return self._given.pop(0) if self._given else None

    def save(self, path: str | os.PathLike[str], certificate: Certificate) -> None:
        """Write the lists that were checked."""
        rows = ({} if row is None else {"row": row} for _, row in self.checked)
        columns = (labels._asdict() for labels, _ in self.checked)
        save_lists(path, certificate, map(dict.__or__, columns, rows))

    @classmethod
    def load(cls, path: str | os.PathLike[str], certificate: Certificate) -> Lists:
        """Read the lists of a certificate, see :func:`.label_lists.load_lists`."""
        listed = load_lists(path, certificate, KINDS)
        rows = [columns.pop("row", None) for columns in listed]
        return cls(*map(ListedLabels, (ClosedLabels(**columns) for columns in listed), rows))
