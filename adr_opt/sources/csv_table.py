"""Tables in CSV: rows under a header, each with its place for errors."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Iterator, Sequence

from ..common.errors import InputError
from ..common.files import read_text
from .catalogue.records import shown


def csv_rows(
    text: str, path: object, header_of: Callable[[list[str], str], list[str]], columns: str
) -> Iterator[tuple[str, dict[str, str]]]:
    """The rows of a table, with file and line before each; blank lines are left out.

    Parameters
    ----------
    text : str
    path : str or path
        Of the file, for errors.
    header_of : callable
        From the cells of the first line and its place to the names of the columns; refuses others.
    columns : str
        What an empty file is told to have.

    Raises
    ------
    InputError
        It is empty or no CSV, or a row is longer or shorter than the header.
    """
    lines = text.removeprefix("\ufeff").splitlines()
    rows = csv.reader(lines, strict=True, skipinitialspace=True)
    header: list[str] = []
    try:
        for row in rows:
            cells, where = [cell.strip() for cell in row], f"{path}: line {rows.line_num}"
            if not any(cells):
                continue
            if not header:
                header = header_of(cells, where)
            elif len(cells) != len(header):
                raise InputError(f"{where}: {len(cells)} values under {len(header)} columns")
            else:
                yield where, dict(zip(header, cells, strict=True))
    except csv.Error as error:
        raise InputError(f"{path}: line {rows.line_num}: not a line of CSV ({error})") from None
    if not header:
        raise InputError(f"{path}: empty; give a line with the columns {columns}")


def csv_number(text: str, where: str) -> float:
    """The number in a cell; raises :class:`InputError` for other texts."""
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{where} = {shown(text)!r}: must be a number") from None


def named_numbers(path: str, columns: Sequence[str]) -> Iterator[tuple[str, str, list[float]]]:
    """The rows of a file of names and numbers, each as place, name and numbers.

    Raises
    ------
    InputError
        It cannot be read, has other columns, a value is no number, or a name is missing or twice.
    """

    def header_of(cells: list[str], where: str) -> list[str]:
        if cells != list(columns):
            raise InputError(f"{where}: the first line must be {','.join(columns)}")
        return cells

    known = set[str]()
    for where, row in csv_rows(read_text(path), path, header_of, ",".join(columns)):
        name, *_ = row.values()
        if not name or name in known:
            raise InputError(f"{where}: {'a name is missing' if not name else f'{name!r} again'}")
        known.add(name)
        numbers = [csv_number(row[each], f"{where}: {each}") for each in columns[1:]]
        yield where, name, numbers


def csv_text(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table as text."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return text.getvalue()
