"""Files of labels: the evidence for a certificate's claims on walks.

A file is an ``npz`` with a list for each question about walks, in the order in which they are
asked, as arrays ``0.body``, ``0.time`` and so on, and the digest of the certificate that it belongs
to. What the columns mean, and whether labels show anything, is for ``verify`` to say.
"""

from __future__ import annotations

import hashlib
import io
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..common.arrays import read_arrays
from ..common.errors import InputError
from ..common.files import write_bytes
from ..common.memory import available_bytes
from .certificate import Certificate

Columns = dict[str, npt.NDArray[Any]]


class ColumnKind(NamedTuple):
    """Kind of a column.

    Attributes
    ----------
    whole : bool
        Whether it has integers, or else floating-point numbers.
    axes : int
        How many; the last one is that of labels.
    aside : bool
        Whether it may be left out, and need not be as long as the others.
    """

    whole: bool
    axes: int = 1
    aside: bool = False


def save_lists(
    path: str | os.PathLike[str], certificate: Certificate, lists: Iterable[Columns]
) -> None:
    """Write the lists of a certificate completely or not at all."""
    arrays = {"certificate": np.array(_digest(certificate))}
    for number, columns in enumerate(lists):
        arrays |= {f"{number}.{name}": _narrow(each) for name, each in columns.items()}
    packed = io.BytesIO()
    np.savez_compressed(packed, allow_pickle=False, **arrays)
    write_bytes(path, packed.getvalue())


def load_lists(
    path: str | os.PathLike[str], certificate: Certificate, kinds: Mapping[str, ColumnKind]
) -> list[Columns]:
    """Read the lists of a certificate, as 64-bit numbers.

    Raises
    ------
    InputError
        It is no such file, too large for the memory, or one of another certificate.
    """
    if not Path(path).exists():
        raise InputError(f"{path}: no such file; check the path")
    try:
        arrays = read_arrays(path, 0.25 * available_bytes())
        digest = str(arrays.pop("certificate"))
        count = len({name.partition(".")[0] for name in arrays})
        lists = [_columns(arrays, f"{number}.", kinds) for number in range(count)]
    except (ValueError, KeyError) as error:
        raise InputError(f"{path}: not a file of labels, or too large") from error
    if digest != _digest(certificate):
        raise InputError(f"{path}: holds the labels of another certificate")
    return lists


def _digest(certificate: Certificate) -> str:
    return hashlib.sha256(certificate.to_json().encode()).hexdigest()


def _narrow(column: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Whole numbers in the narrowest integers that hold them."""
    if column.dtype.kind != "i" or not column.size:
        return column
    kind = np.result_type(*(np.min_scalar_type(int(each)) for each in (column.min(), column.max())))
    return column.astype(kind) if kind.kind in "iu" and kind != np.uint64 else column


def _columns(arrays: Columns, prefix: str, kinds: Mapping[str, ColumnKind]) -> Columns:
    """The columns of one list.

    Raises
    ------
    KeyError, ValueError
        It is none.
    """
    found, sizes = Columns(), set()
    for name, kind in kinds.items():
        if kind.aside and prefix + name not in arrays:
            continue
        column = arrays[prefix + name]
        if column.dtype.kind not in ("iu" if kind.whole else "f") or column.ndim != kind.axes:
            raise ValueError(name)
        found[name] = column.astype(np.int64 if kind.whole else np.float64)
        sizes |= set() if kind.aside else {column.shape[-1]}
    if len(sizes) > 1:
        raise ValueError("columns differ in length")
    return found
