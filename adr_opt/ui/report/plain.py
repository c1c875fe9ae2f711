"""Pages without scripts: the style of the report for tables and small charts."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from typing import Any

from ...common.errors import InputError
from ...common.files import check_writable, write_text
from ...common.version import __version__
from . import tables
from .assets import asset
from .text import escape


def check_page(path: str | os.PathLike[str] | None) -> None:
    """Raise :class:`InputError` in advance if a requested page could not be written."""
    if path is None:
        return
    check_writable(path)
    if not os.fspath(path).lower().endswith((".html", ".htm")):
        raise InputError(f"{path}: the page is HTML; give a file that ends in .html")


def section(title: str, note: str, content: str) -> str:
    """A section of a page; title and note are text, the content is HTML."""
    said = f"<p>{escape(note)}</p>" if note else ""
    return f"<section><h2>{escape(title)}</h2>{said}{content}</section>"


def row(cells: Iterable[tuple[str, str]], kind: str = "") -> str:
    """A table row: cells as (class, text), with class "n" for numbers."""
    return tables.row(((c, escape(text)) for c, text in cells), kind and f"class={kind}")


def table_of(
    caption: str,
    columns: Iterable[tables.Column | bool],
    items: Iterable[tuple[Any, ...]],
    kind: Callable[..., str] = lambda *item: "",
) -> str:
    """As :func:`.tables.table_of`, of texts; ``kind`` is the class of a row."""

    def _escaped(tell: Callable[..., object]) -> Callable[..., str]:
        return lambda *item: escape(tell(*item))

    texts = (
        column if isinstance(column, bool) else (*column[:2], _escaped(column[2]))
        for column in columns
    )

    def _about(*item: Any) -> str:
        return kind(*item) and f"class={kind(*item)}"

    return tables.table_of(caption, texts, items, _about)


def page(over: str, title: str, under: str, sections: Iterable[str]) -> str:
    """HTML of a page without scripts or requests."""
    style = asset("page.css")
    policy = (
        "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; "
        "form-action 'none'"
    )
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n'
        f'<meta name="generator" content="adr-opt {__version__}">\n'
        f'<title>{escape(title)}</title>\n<link rel="icon" href="data:,">\n'
        f"<style>{style}</style>\n</head>\n<body>\n<main>\n<header>\n"
        f'<p class="over">{escape(over)}</p>\n<h1>{escape(title)}</h1>\n'
        f'<p class="under">{escape(under)}</p>\n</header>\n{"".join(sections)}\n'
        f"<footer>Made by adr-opt {__version__}; this page loads nothing from the "
        "network.</footer>\n</main>\n</body>\n</html>\n"
    )


def write_page(path: str | os.PathLike[str], text: str) -> None:
    """Write a page, completely or not at all."""
    check_page(path)
    write_text(path, text)
