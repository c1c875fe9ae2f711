"""A card: what an object is, some facts of it, and tables for those who have room."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cache
from html import escape
from importlib.metadata import entry_points
from typing import NamedTuple

from .constants import DAY_S

VIEWS = "adr_opt.views"
"""Entry-point group of functions that make the card of an object, or say None."""

MOST_ROWS = 60
"""So many rows of a table are shown in a notebook; a line says how many more there are."""

MOST_NAMES = 6
"""So many names of an order stand in a line."""

NUMBER, TEXT = "text-align: right", "text-align: left"


class CardTable(NamedTuple):
    """Rows of texts under heads.

    Attributes
    ----------
    heads : tuple of str
    rows : sequence of tuple of str
    texts : int
        So many columns, from the first on, hold words; the others hold numbers.
    """

    heads: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    texts: int = 1

    def html(self) -> str:
        """The table, cut where it is long."""
        styles = [TEXT if at < self.texts else NUMBER for at in range(len(self.heads))]
        shown = [self.heads, *self.rows[:MOST_ROWS]]
        lines = []
        for number, row in enumerate(shown):
            tag = "td" if number else "th"
            cells = zip(row, styles, strict=True)
            lines.append(
                "".join(f'<{tag} style="{style}">{escape(text)}</{tag}>' for text, style in cells)
            )
        more = len(self.rows) - MOST_ROWS
        said = f"<p>and {more} more</p>" if more > 0 else ""
        body = "".join(f"<tr>{line}</tr>" for line in lines[1:])
        return f"<table><thead><tr>{lines[0]}</tr></thead><tbody>{body}</tbody></table>{said}"


class Card(NamedTuple):
    """What an object shows of itself.

    Attributes
    ----------
    kind : str
        What it is.
    said : str
        Which one: ``'nominal-000'``, or ``of 'auto'``.
    facts : tuple of str
        For the line and the page.
    details : tuple of (str, str)
        For the page alone: what, and its value.
    tables : tuple of CardTable
        For the page alone.
    """

    kind: str
    said: str
    facts: tuple[str, ...]
    details: tuple[tuple[str, str], ...] = ()
    tables: tuple[CardTable, ...] = ()

    @property
    def head(self) -> str:
        """What it is, and which one."""
        return f"{self.kind} {self.said}".rstrip()

    def line(self) -> str:
        """One line."""
        told = f": {', '.join(self.facts)}" if self.facts else ""
        return f"<{self.head}{told}>"

    def html(self) -> str:
        """A piece of a page, without colours or sizes of its own."""
        parts = [f"<p><strong>{escape(self.head)}</strong><br>{escape(', '.join(self.facts))}</p>"]
        if self.details:
            rows = "".join(
                f'<tr><th style="{TEXT}">{escape(what)}</th>'
                f'<td style="{TEXT}">{escape(value)}</td></tr>'
                for what, value in self.details
            )
            parts.append(f"<table><tbody>{rows}</tbody></table>")
        return f"<div>{''.join(parts)}{''.join(table.html() for table in self.tables)}</div>"


View = Callable[[object], Card | None]


class Shown:
    """Something that shows itself by a card, which a view makes (:data:`VIEWS`)."""

    __slots__ = ()

    def __repr__(self) -> str:
        return card_of(self).line()

    __str__ = __repr__

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        return card_of(self).html()


def card_of(shown: object) -> Card:
    """The card of an object; of one that no view knows, the name of its class."""
    for view in _views():
        card = view(shown)
        if card is not None:
            return card
    return Card(type(shown).__name__, "", ())


@cache
def _views() -> tuple[View, ...]:
    return tuple(entry.load() for entry in entry_points(group=VIEWS))


def order_words(names: Iterable[str]) -> str:
    """An order of bodies in a line: the first ones, and the last one."""
    listed = list(names)
    if len(listed) > MOST_NAMES + 1:
        listed = [*listed[: MOST_NAMES - 1], "…", listed[-1]]
    return " → ".join(listed)


def days(seconds: float) -> str:
    """A time in days, for columns."""
    return f"{seconds / DAY_S:.3f}"


def days_words(seconds: float) -> str:
    """A time in days, short and with the unit."""
    text = days(seconds).rstrip("0").rstrip(".")
    return f"{text} day" if text == "1" else f"{text} days"
