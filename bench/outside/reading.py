"""Files of benchmarks, with one sentence where they are not as they were published."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import wraps
from pathlib import Path
from typing import Concatenate, ParamSpec, TypeVar

import numpy as np
import numpy.typing as npt

from adr_opt.common.errors import InputError
from adr_opt.common.files import read_text

FloatArray = npt.NDArray[np.float64]
More, Read = ParamSpec("More"), TypeVar("Read")


def published(
    read: Callable[Concatenate[Path, More], Read],
) -> Callable[Concatenate[Path, More], Read]:
    """A reader that refuses in one sentence whatever is not as it was published."""

    @wraps(read)
    def reading(path: Path, *more: More.args, **options: More.kwargs) -> Read:
        try:
            return read(path, *more, **options)
        except InputError:
            raise
        except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
            raise InputError(
                f"{path}: not as published: {error!r}; give the file as it is"
            ) from None

    return reading


def filled_lines(path: Path) -> Iterator[str]:
    """Lines that hold something."""
    for line in read_text(path).splitlines():
        if line.strip():
            yield line.strip()


def numbers_of(text: str, count: int, separator: str | None = None) -> list[float]:
    """So many finite numbers of a text; one separator after the last is allowed."""
    values = [float(part) for part in text.strip().split(separator) if part.strip()]
    if len(values) != count or not np.isfinite(values).all():
        raise ValueError(f"{text[:80]!r} has not {count} finite numbers")
    return values
