"""Cards that describe an object: its name, a few facts, and tables where there is room."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from html import escape
from importlib.metadata import entry_points
from typing import Any, NamedTuple

from .constants import DAY_S

VIEWS = "adr_opt.views"
"""Entry-point group of functions that make the card of an object, or return None."""

MOST_ROWS = 60
"""Maximum number of table rows shown in a notebook; a further line counts the rest."""

MOST_NAMES = 6
"""Maximum number of names when an order is written on one line."""

NUMBER, TEXT = "text-align: right", "text-align: left"


class CardTable(NamedTuple):
    """Rows of text under column heads.

    Attributes
    ----------
    heads : tuple of str
    rows : sequence of tuple of str
    texts : int
        Number of leading columns that hold words; the others hold numbers.
    """

    heads: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    texts: int = 1

    @classmethod
    def of(
        cls,
        items: Iterable[tuple[Any, ...]],
        columns: Mapping[str, Callable[..., str]],
        texts: int = 1,
    ) -> CardTable:
        """A table from rows of values, with a function for each column that writes its cell."""
        rows = [tuple(tell(*item) for tell in columns.values()) for item in items]
        return cls(tuple(columns), rows, texts)

    def html(self) -> str:
        """The table as HTML, shortened if it is long."""
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
    """What an object displays about itself.

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
        """The kind of object and its name."""
        return f"{self.kind} {self.said}".rstrip()

    def line(self) -> str:
        """The card on one line."""
        told = f": {', '.join(self.facts)}" if self.facts else ""
        return f"<{self.head}{told}>"

    def html(self) -> str:
        """The card as an HTML fragment, without colours or sizes of its own."""
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
    """Base of objects that display a card, made by a view (:data:`VIEWS`)."""

    __slots__ = ()

    def __repr__(self) -> str:
        return card_of(self).line()

    __str__ = __repr__

    def _repr_html_(self) -> str:
        """HTML shown by a notebook."""
        return card_of(self).html()


def card_of(shown: object) -> Card:
    """The card of an object, or just its class name if no view knows it."""
    for view in _views():
        card = view(shown)
        if card is not None:
            return card
    return Card(type(shown).__name__, "", ())


@cache
def _views() -> tuple[View, ...]:
    return tuple(entry.load() for entry in entry_points(group=VIEWS))


def order_words(names: Iterable[str]) -> str:
    """An order of bodies on one line: the first few and the last."""
    listed = list(names)
    if len(listed) > MOST_NAMES + 1:
        listed = [*listed[: MOST_NAMES - 1], "…", listed[-1]]
    return " → ".join(listed)


def days(seconds: float) -> str:
    """A time in days, for table columns."""
    return f"{seconds / DAY_S:.3f}"


def days_words(seconds: float) -> str:
    """A time in days, brief and with its unit."""
    text = days(seconds).rstrip("0").rstrip(".")
    return f"{text} day" if text == "1" else f"{text} days"
