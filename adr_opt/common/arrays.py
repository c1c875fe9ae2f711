"""Arrays from untrusted files: no code is executed, and no header claims more than is stored."""

from __future__ import annotations

import math
import os
import zlib
from typing import Any
from zipfile import BadZipFile, ZipFile

import numpy as np
import numpy.typing as npt


def read_arrays(path: str | os.PathLike[str], most_bytes: float) -> dict[str, npt.NDArray[Any]]:
    """The arrays of an ``npz`` file, by name.

    Raises
    ------
    ValueError
        The file is not an ``npz``, exceeds ``most_bytes`` unpacked, or has an array whose header
        states another size than is stored.
    """
    try:
        with ZipFile(path) as packed:
            if sum(each.file_size for each in packed.infolist()) > most_bytes:
                raise ValueError("too large")
            for each in packed.infolist():
                with packed.open(each) as member:
                    version = np.lib.format.read_magic(member)
                    if version != (1, 0):  # of headers as long as ours never are
                        raise ValueError("another version")
                    shape, _, kind = np.lib.format.read_array_header_1_0(member)
                    if math.prod(shape) * kind.itemsize + member.tell() != each.file_size:
                        raise ValueError("not whole")
        with np.load(path, allow_pickle=False) as content:
            return {name: content[name] for name in content.files}
    except (OSError, EOFError, BadZipFile, RuntimeError, zlib.error) as error:
        # RuntimeErrors are of entries that are encrypted, or packed in a way unknown here.
        raise ValueError("no arrays") from error
