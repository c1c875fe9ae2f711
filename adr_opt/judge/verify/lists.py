"""Files of closed labels, which may stand beside a certificate.

A file has the list of each question about walks, in the order in which they are asked, and may have
the row of a label that dominates each end of a leg, so that who checks the list need not look for
one. It says which certificate it belongs to, and is evidence as that is: nothing of it is trusted.
"""

from __future__ import annotations

import hashlib
import io
import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.arrays import read_arrays
from ...common.errors import InputError
from ...common.files import write_bytes
from ...common.memory import available_bytes
from ...plan.certificate import Certificate
from .closed import ClosedLabels, Finder

Array = npt.NDArray[Any]

WHOLE = ("body", "kits", "value", "worth", "counts", "memory", "odd", "row")
"""Columns of integers; the others are of times and ΔV."""


class ListedLabels(NamedTuple):
    """The list of one question.

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
        """Gives the rows of the file, one after the other; those of a search if it has none."""
        if self.row is None:
            return search
        rows, at = self.row, 0

        def told(ends: ClosedLabels) -> Array:
            nonlocal at
            part, at = rows[at : at + ends.body.size], at + ends.body.size
            return np.append(part, np.full(ends.body.size - part.size, -1))

        return told


class Lists:
    """The lists of a certificate, to be checked one after the other, or to be written.

    Parameters
    ----------
    listed : sequence of Listed
        Those to be checked; where there are no more, they are made.
    """

    def __init__(self, *listed: ListedLabels) -> None:
        self._given = list(listed)
        self.checked: list[ListedLabels] = []

    def next(self) -> ListedLabels | None:
        """The list of the next question, if it was given."""
        return self._given.pop(0) if self._given else None

    def save(self, path: str | os.PathLike[str], certificate: Certificate) -> None:
        """Write the lists that were checked."""
        arrays = {"certificate": np.array(_digest(certificate))}
        for number, (labels, row) in enumerate(self.checked):
            columns = labels._asdict() | ({} if row is None else {"row": row})
            arrays |= {f"{number}.{name}": _narrow(each) for name, each in columns.items()}
        packed = io.BytesIO()
        np.savez_compressed(packed, allow_pickle=False, **arrays)
        write_bytes(path, packed.getvalue())

    @classmethod
    def load(cls, path: str | os.PathLike[str], certificate: Certificate) -> Lists:
        """Read the lists of a certificate.

        Raises
        ------
        InputError
            It is no such file, too large for the memory, or one of another certificate. Whether
            labels are closed is for the check to find out.
        """
        if not Path(path).exists():
            raise InputError(f"{path}: no such file; check the path")
        try:
            arrays = read_arrays(path, 0.25 * available_bytes())
            digest = str(arrays.pop("certificate"))
            count = len({name.partition(".")[0] for name in arrays})
            listed = [_listed(arrays, f"{number}.") for number in range(count)]
        except (ValueError, KeyError) as error:
            raise InputError(f"{path}: not a file of labels, or too large a one") from error
        if digest != _digest(certificate):
            raise InputError(f"{path}: the labels of another certificate")
        return cls(*listed)


def _digest(certificate: Certificate) -> str:
    return hashlib.sha256(certificate.to_json().encode()).hexdigest()


def _narrow(column: Array) -> Array:
    """Whole numbers in the narrowest integers that hold them."""
    if column.dtype.kind != "i" or not column.size:
        return column
    kind = np.result_type(*(np.min_scalar_type(int(each)) for each in (column.min(), column.max())))
    return column.astype(kind) if kind.kind in "iu" and kind != np.uint64 else column


def _listed(arrays: dict[str, Array], prefix: str) -> ListedLabels:
    """The list of one question.

    Raises
    ------
    KeyError, ValueError
        It is none.
    """
    columns = [arrays[prefix + name] for name in ClosedLabels._fields]
    row = arrays.get(prefix + "row")
    for name, column in zip((*ClosedLabels._fields, "row"), (*columns, row), strict=True):
        if column is not None and not (
            column.dtype.kind in ("iu" if name in WHOLE else "f")
            and column.ndim == 1 + (name in ("counts", "memory", "odd"))
            and (name == "row" or column.shape[-1] == columns[0].size)
        ):
            raise ValueError(name)
    kinds = [np.int64 if name in WHOLE else np.float64 for name in ClosedLabels._fields]
    labels = ClosedLabels(*(each.astype(kind) for each, kind in zip(columns, kinds, strict=True)))
    return ListedLabels(labels, None if row is None else row.astype(np.int64))
