"""Tables of legs: numbers are never cut, names are shortened first."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple, Protocol, TypeVar

from rich.cells import cell_len
from rich.table import Table
from rich.text import Text

from ...common.wording import shortened
from .output import emit_rich, terminal_width

ARROW = " → "
ROUTE, PLACE = f"origin{ARROW}destination", "destination"
SHORT_NAME = 10
"""Minimum width of a name, however narrow the terminal."""


class Row(NamedTuple):
    """One leg."""

    number: int
    origin: str
    destination: str
    texts: Sequence[str]
    bold: bool = False


class _Flown(Protocol):
    """A leg with its number."""

    @property
    def leg(self) -> int: ...
    @property
    def origin(self) -> str: ...
    @property
    def destination(self) -> str: ...


Told = TypeVar("Told", bound=_Flown)


def leg_table(
    headings: Sequence[str], rows: Iterable[Row], width: int | None, title: str | None = None
) -> Table:
    """A table of legs: number, bodies, and columns of numbers.

    Where there is too little room, the frame goes, then parts of the names, then the origins: the
    row before says where the chaser is. A table that is still too wide stays so.

    Parameters
    ----------
    headings : sequence of str
        Of the columns of numbers.
    rows : iterable of Row
    width : int or None
        Columns of the terminal; None for no limit.
    title : str, optional
    """
    rows = list(rows)
    # As wide as the longest line of each column of numbers, heading included.
    cells = [["leg", *(str(row.number) for row in rows)]]
    cells += [[heading, *(row.texts[at] for row in rows)] for at, heading in enumerate(headings)]
    taken = sum(
        max(cell_len(line) for cell in column for line in cell.split("\n")) for column in cells
    )
    count = len(cells) + 1
    routes = [ROUTE, *(row.origin + ARROW + row.destination for row in rows)]
    framed = True
    if width is not None:
        longest = max(map(cell_len, routes))
        framed = width - taken - (3 * count + 1) >= min(longest, 2 * SHORT_NAME + len(ARROW))
        room = width - taken - (3 * count + 1 if framed else count - 1)
        if longest > room:
            routes = _fitted(rows, room)
    table = Table(title=title, title_justify="left")
    if not framed:
        table.box, table.pad_edge, table.collapse_padding = None, False, True
    table.add_column("leg", justify="right", no_wrap=True)
    table.add_column(routes[0], no_wrap=True)
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    for row, route in zip(rows, routes[1:], strict=True):
        style = "bold" if row.bold else None
        table.add_row(str(row.number), Text(route), *row.texts, style=style)
    return table


def emit_legs(
    legs: Iterable[Told],
    columns: Iterable[tuple[str, Callable[[Told], str]]],
    whose: Mapping[int, str],
    title: str | None = None,
    bold: Callable[[Told], bool] = lambda leg: False,
) -> None:
    """Print legs as one table, or as one per chaser if there are several.

    Parameters
    ----------
    legs : iterable
    columns : iterable of (str, callable)
        Headings, and what stands below them.
    whose : mapping of int to str
        The chaser of each leg, by its number; empty where there is one.
    title : str, optional
    bold : callable
        Whether a leg stands out.
    """
    columns = list(columns)
    tables: dict[str | None, list[Row]] = {} if whose else {None: []}
    for leg in legs:
        texts = [told(leg) for _, told in columns]
        row = Row(leg.leg, leg.origin, leg.destination, texts, bold(leg))
        tables.setdefault(whose.get(leg.leg), []).append(row)
    headings, width = [heading for heading, _ in columns], terminal_width()
    for chaser, rows in tables.items():
        said = ", ".join(part for part in (chaser, title) if part is not None)
        emit_rich(leg_table(headings, rows, width, said or None))


def number_table(
    title: str,
    headings: Iterable[str],
    rows: Iterable[Iterable[str | Text]],
    *,
    first: str | None = None,
    last: str | None = None,
) -> Table:
    """A table of numbers under headings, with optional columns of words on either side."""
    table = Table(title=title, title_justify="left")
    if first is not None:
        table.add_column(first, no_wrap=True)
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    if last is not None:
        table.add_column(last, no_wrap=True)
    for row in rows:
        table.add_row(*row)
    return table


class _Part(Protocol):
    """Consecutive legs of one chaser."""

    @property
    def chaser(self) -> str | None: ...
    @property
    def first_leg(self) -> int: ...
    @property
    def last_leg(self) -> int: ...


def whose(parts: Iterable[_Part]) -> dict[int, str]:
    """Name of the chaser of each leg by number, for parts of a plan; empty if there is only one."""
    return {
        number: part.chaser
        for part in parts
        if part.chaser is not None
        for number in range(part.first_leg, part.last_leg + 1)
    }


def _fitted(rows: Sequence[Row], room: int) -> list[str]:
    """Routes fitted into a width, under their heading."""
    each = (room - len(ARROW)) // 2
    if each >= SHORT_NAME:
        short = shortened((name for row in rows for name in row[1:3]), each)
        return [ROUTE, *(short[row.origin] + ARROW + short[row.destination] for row in rows)]
    last = max(room - len(ARROW.lstrip()), SHORT_NAME)
    short = shortened((row.destination for row in rows), last)
    return [PLACE, *(ARROW.lstrip() + short[row.destination] for row in rows)]
