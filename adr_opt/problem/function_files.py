"""Files of given functions, ``adr-opt-functions/1``: JSON beside the instance file."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from ..common.errors import InputError
from ..common.files import read_model, write_text
from ..common.records import Name, Record
from .given_functions import Functions, of_breakpoints
from .settings import GivenFile

FORMAT: Literal["adr-opt-functions/1"] = "adr-opt-functions/1"

Breakpoint = Annotated[tuple[float, float], Field(strict=False)]
"""Departure and arrival [s]."""


class PairFunction(Record):
    """The function of a pair."""

    origin: Name
    destination: Name
    delta_v_m_s: float = 0.0
    breakpoints_s: Annotated[tuple[Breakpoint, ...], Field(strict=False, min_length=1)]


class FunctionsFile(Record):
    """Functions of time of some pairs."""

    format: Literal["adr-opt-functions/1"]
    functions: Annotated[tuple[PairFunction, ...], Field(strict=False)]


def read_functions(
    instance_path: str | os.PathLike[str], reference: GivenFile, names: tuple[str, ...]
) -> Functions | None:
    """Read the functions that an instance file names, from a file beside it; None if it names none.

    Raises
    ------
    InputError
        No such file, not JSON, or no functions that can be planned on; or others than the instance
        says.
    """
    if reference.functions is None:
        return None
    path = Path(instance_path).parent / reference.functions
    if not path.is_file():
        raise InputError(f"{path}: no such file; put the given functions there")
    content = read_model(path, FunctionsFile)
    rows = (
        (each.origin, each.destination, each.breakpoints_s, each.delta_v_m_s)
        for each in content.functions
    )
    try:
        made = of_breakpoints(rows, names)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    if reference.functions_sha256 not in (None, made.sha256):
        raise InputError(
            f"{path}: not the functions that {instance_path} names in transfer.given: their "
            f"sha256 is {made.sha256}; put the right file there, or leave the field "
            "functions_sha256 out"
        )
    return made


def write_functions(path: str | os.PathLike[str], functions: Functions) -> None:
    """Write functions as JSON, completely or not at all.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    lines = []
    for origin, destination in functions.pairs:
        function = functions.of_pair(origin, destination)
        assert function is not None
        row = {
            "origin": origin,
            "destination": destination,
            "delta_v_m_s": function.cost,
            "breakpoints_s": list(
                zip(function.departure.tolist(), function.arrival.tolist(), strict=True)
            ),
        }
        lines.append("  " + json.dumps(row, ensure_ascii=False))
    body = ",\n".join(lines)
    text = f'{{\n "format": {json.dumps(FORMAT)},\n "functions": [\n{body}\n ]\n}}\n'
    write_text(path, text)
