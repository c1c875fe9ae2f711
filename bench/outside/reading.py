"""Numbers out of text files, with one sentence where they are not what they should be."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from adr_opt.common.errors import InputError
from adr_opt.common.files import read_text

FloatArray = npt.NDArray[np.float64]


def filled_lines(path: Path) -> Iterator[tuple[int, str]]:
    """Lines that hold something, with their numbers from 1."""
    for number, line in enumerate(read_text(path).splitlines(), 1):
        if line.strip():
            yield number, line.strip()


def numbers_of(text: str, count: int, where: str, separator: str | None = None) -> list[float]:
    """So many finite numbers of a text; one separator after the last is allowed."""
    parts = [part for part in text.strip().split(separator) if part.strip()]
    try:
        values = [float(part) for part in parts]
    except ValueError:
        values = []
    if len(values) != count or not np.isfinite(values).all():
        raise InputError(f"{where}: not {count} finite numbers; give the file as it is")
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
