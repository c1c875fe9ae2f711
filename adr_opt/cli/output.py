"""What verbs print: results on standard output, everything else on standard error."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from rich.console import RenderableType

WIDEST = 10_000
"""Columns that rich may use: tables are made to fit before they are printed, and never cut."""


def emit(text: str) -> None:
    """Print text on standard output."""
    click.echo(text, nl=not text.endswith("\n"))


def emit_json(content: Any) -> None:
    """Print one JSON object on standard output; numbers that are not finite become null."""
    emit(json.dumps(_plain(content), indent=1, ensure_ascii=False, allow_nan=False))


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if hasattr(value, "item"):  # a NumPy number, as counters may be
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def terminal_width() -> int | None:
    """Columns of the terminal; None where nobody looks at one, and tables may be of any width."""
    from rich.console import Console

    console = Console(file=sys.stdout)
    return console.width if console.is_terminal else None


def emit_rich(*renderables: RenderableType) -> None:
    """Print tables on standard output, with colour on a terminal only."""
    from rich.console import Console

    # Rendered first and printed by :func:`emit`: rich itself leaves the process on a closed pipe.
    # Without a height rich takes 80 columns for a terminal that calls itself dumb.
    console = Console(file=sys.stdout, highlight=False, width=WIDEST, height=25)
    with console.capture() as capture:
        for renderable in renderables:
            console.print(renderable)
    emit(capture.get())


def say(message: str) -> None:
    """Print a message on standard error; if nobody can hear it, so be it."""
    with suppress(OSError):
        click.echo(f"adr-opt: {message}", err=True)
