"""Numbers out of text files, with one sentence where they are not what they should be."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from adr_opt.common.errors import InputError
from adr_opt.common.files import read_text

FloatArray = npt.NDArray[np.float64]


def filled_lines(path: Path, comment: str = "\0") -> Iterator[tuple[int, str]]:
    """Lines that hold something, with their numbers from 1, less those of comment."""
    for number, line in enumerate(read_text(path).splitlines(), 1):
        if line.strip() and not line.startswith(comment):
            yield number, line.strip()


def numbers_of(text: str, count: int, where: str, separator: str | None = None) -> list[float]:
    """The finite numbers of a text.

    Parameters
    ----------
    text : str
    count : int
        How many there must be.
    where : str
        File and line, for errors.
    separator : str, optional
        One after the last number is allowed; blanks without.
    """
    parts = [part.strip() for part in text.strip().split(separator)]
    if parts and not parts[-1]:
        parts.pop()
    if len(parts) != count:
        raise InputError(f"{where}: {len(parts)} values instead of {count}; give the file as it is")
    values = []
    for part in parts:
        try:
            value = float(part)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise InputError(f"{where}: {part!r} is no finite number; give the file as it is")
        values.append(value)
    return values


def read_object(path: Path) -> dict[str, Any]:
    """The JSON object in a file."""
    try:
        content = json.loads(read_text(path))
    except json.JSONDecodeError as error:
        raise InputError(f"{path}: not JSON: {error}; give the file as it is") from None
    if not isinstance(content, dict):
        raise InputError(f"{path}: not a JSON object; give the file as it is")
    return content


def sequence_of(content: dict[str, Any], key: str, where: str) -> list[Any]:
    """A list in a JSON object."""
    if not isinstance(content.get(key), list):
        raise InputError(f"{where}: no list {key!r}; give the file as it is")
    return content[key]  # type: ignore[no-any-return]


def floats_of(content: dict[str, Any], key: str, count: int, where: str) -> tuple[float, ...]:
    """A list of a given number of finite numbers in a JSON object."""
    values = sequence_of(content, key, where)
    if len(values) != count:
        raise InputError(f"{where}: {len(values)} values of {key} instead of {count}")
    for value in values:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise InputError(f"{where}: {value!r} in {key} is no number")
        if not math.isfinite(value):
            raise InputError(f"{where}: {value!r} in {key} is not finite")
    return tuple(float(value) for value in values)
