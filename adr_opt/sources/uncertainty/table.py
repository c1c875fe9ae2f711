"""Tables of errors of targets, ``adr-opt-target-errors/1``: CSV or JSON.

Each row names a body and gives standard deviations or a covariance at the epoch of the instance, in
axes outward, along the track and across it. In CSV the lower triangle of a covariance stands in
columns named as by CCSDS 508.0-B (Conjunction Data Message), with their units.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, ValidationError, model_validator

from ...common.errors import InputError
from ...common.files import parse_model, read_text
from ...common.records import Name, Record
from ...common.sentences import sentence
from ...problem.instance import Instance
from ..catalogue.records import shown
from ..csv_table import csv_number, csv_rows
from .message_covariances import of_message
from .target_error import TargetError

Sigma = Annotated[float, Field(ge=0.0, le=1e6)]
SixBySix = Annotated[
    tuple[Annotated[tuple[float, ...], Field(strict=False, min_length=6, max_length=6)], ...],
    Field(strict=False, min_length=6, max_length=6),
]

SIGMAS = (
    "sigma_radial_m",
    "sigma_along_m",
    "sigma_across_m",
    "sigma_radial_m_s",
    "sigma_along_m_s",
    "sigma_across_m_s",
)
DECAY = "sigma_decay_m_per_day"


class TargetErrorRow(Record):
    """A row: the error of one body."""

    target: Name
    sigma_radial_m: Sigma | None = None
    sigma_along_m: Sigma | None = None
    sigma_across_m: Sigma | None = None
    sigma_radial_m_s: Sigma | None = None
    sigma_along_m_s: Sigma | None = None
    sigma_across_m_s: Sigma | None = None
    sigma_decay_m_per_day: Sigma | None = None
    covariance_rtn: SixBySix | None = None

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        said = [name for name in SIGMAS if getattr(self, name) is not None]
        if self.covariance_rtn is not None and said:
            raise ValueError(f"field {said[0]}: the row has a covariance, too; keep one of them")
        return self

    def error(self) -> TargetError:
        """The error that the row states."""
        covariance = np.zeros((7, 7))
        if self.covariance_rtn is not None:
            covariance[:6, :6] = self.covariance_rtn
        else:
            covariance[:6, :6] = np.diag([(getattr(self, name) or 0.0) ** 2 for name in SIGMAS])
        covariance[6, 6] = (self.sigma_decay_m_per_day or 0.0) ** 2
        return TargetError(covariance)


class TargetErrorsFile(Record):
    """The file in JSON."""

    format: Literal["adr-opt-target-errors/1"]
    targets: Annotated[tuple[TargetErrorRow, ...], Field(strict=False, min_length=1)]


def _triangle() -> Iterator[tuple[str, int, int]]:
    """Columns of a covariance in CSV, with row and column of the matrix."""
    names, units = ("r", "t", "n", "rdot", "tdot", "ndot"), ("m2", "m2_s", "m2_s2")
    for row, first in enumerate(names):
        for column, second in enumerate(names[: row + 1]):
            yield f"c{first}_{second}_{units[(row > 2) + (column > 2)]}", row, column


TRIANGLE = tuple(_triangle())
COLUMNS = ("target", *SIGMAS, DECAY, *(name for name, _, _ in TRIANGLE))


def read_table(path: str | os.PathLike[str], bodies: Collection[str]) -> dict[str, TargetError]:
    """Errors of bodies by name.

    Parameters
    ----------
    path : path
        CSV, or JSON, which begins with a brace.
    bodies : collection of str
        Names of all bodies of the instance.

    Raises
    ------
    InputError
        It cannot be read, a column or a value is wrong, a row names no body or one twice, or
        states what is no covariance.
    """
    text = read_text(path).removeprefix("\ufeff")
    if text.lstrip().startswith("{"):
        content = parse_model(text, TargetErrorsFile, str(path))
        rows = [(f"{path}: targets[{at}]", row) for at, row in enumerate(content.targets)]
    else:
        rows = list(_csv_rows(text, str(path)))
    found: dict[str, TargetError] = {}
    for where, row in rows:
        if row.target not in bodies:
            raise InputError(f"{where}: target {shown(row.target)!r}: no such body in the instance")
        if row.target in found:
            raise InputError(f"{where}: target {shown(row.target)!r} already has a row; keep one")
        try:
            found[row.target] = row.error()
        except InputError as error:
            raise InputError(f"{where}: {error}") from None
    return found


def _csv_rows(text: str, path: str) -> Iterator[tuple[str, TargetErrorRow]]:
    for where, cells in csv_rows(text, path, _checked_header, f"target, {SIGMAS[0]}, …"):
        yield where, _row(cells, where)


def _checked_header(header: list[str], where: str) -> list[str]:
    for at, name in enumerate(header):
        if name not in COLUMNS:
            raise InputError(
                f"{where}: column {shown(name)!r} is unknown; use target, {', '.join(SIGMAS)}, "
                f"{DECAY}, or for a covariance {TRIANGLE[0][0]} to {TRIANGLE[-1][0]}"
            )
        if name in header[:at]:
            raise InputError(f"{where}: two columns {name}; keep one")
    missing = [name for name, _, _ in TRIANGLE if name not in header]
    if 0 < len(missing) < len(TRIANGLE):
        raise InputError(f"{where}: a covariance needs the column {missing[0]}, too")
    if "target" not in header:
        raise InputError(f"{where}: no column names the bodies; call it target")
    return header


def _row(cells: dict[str, str], where: str) -> TargetErrorRow:
    numbers: dict[str, float] = {}
    for name, cell in cells.items():
        if name != "target" and cell:
            numbers[name] = csv_number(cell, f"{where}: {name}")
    content: dict[str, Any] = {"target": cells["target"]}
    stated = [name for name, _, _ in TRIANGLE if name in numbers]
    if stated:
        matrix = np.zeros((6, 6))
        for name, row, column in TRIANGLE:
            if name not in numbers:
                raise InputError(f"{where}: {name} is empty; a covariance needs all of its columns")
            matrix[row, column] = matrix[column, row] = numbers.pop(name)
        content["covariance_rtn"] = matrix.tolist()
    try:
        return TargetErrorRow.model_validate(content | numbers)
    except ValidationError as error:
        raise InputError(f"{where}: {sentence(error)}") from None


def read_target_errors(instance: Instance, path: str | os.PathLike[str]) -> dict[str, TargetError]:
    """Errors of the bodies of an instance by name.

    Parameters
    ----------
    instance : Instance
    path : path
        A table (:mod:`.table`), or a message in key-value notation, which begins with its version.

    Raises
    ------
    InputError
        It cannot be read, or states no errors.
    """
    text = read_text(path)
    if text.lstrip("\ufeff \t\r\n").startswith("CCSDS_OEM_VERS"):
        return of_message(instance, text, str(path))
    return read_table(path, instance.names)
