"""Output of verbs: results on standard output, everything else on standard error."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import click

from ...common.wording import harmless, in_one_line

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderableType
    from rich.segment import Segment

    from ...problem.instance import Instance


WIDEST = 10_000
"""Maximum width for rich: tables are fitted before printing, and never cut."""


def emit(text: str) -> None:
    """Print text on standard output."""
    _emit(harmless(text))


def _emit(text: str) -> None:
    click.echo(text, nl=not text.endswith("\n"))


def emit_json(content: Any) -> None:
    """Print one JSON object on standard output; numbers that are not finite become null."""
    emit(json.dumps(plain_data(content), indent=1, ensure_ascii=False, allow_nan=False))


def plain_data(value: Any) -> Any:
    """Data as JSON has them, with None for each number that is not finite."""
    if isinstance(value, Mapping):
        return {str(key): plain_data(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain_data(item) for item in value]
    if hasattr(value, "item"):  # a NumPy number, as counters may be
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def terminal_width() -> int | None:
    """Width of the terminal; None without one, when tables may have any width."""
    from rich.console import Console

    console = Console(file=sys.stdout)
    return console.width if console.is_terminal else None


def emit_rich(*renderables: RenderableType) -> None:
    """Print tables on standard output, coloured on a terminal only."""
    from rich.console import Console

    # Rendered first and printed by :func:`emit`: rich itself leaves the process on a closed pipe.
    # Without a height rich takes 80 columns for a terminal that calls itself dumb.
    console = Console(file=sys.stdout, highlight=False, width=WIDEST, height=25)
    with console.capture() as capture:
        for renderable in renderables:
            console.print(Harmless(renderable))
    _emit(capture.get())


class Harmless:
    """A table whose cells lose control characters once it is laid out."""

    def __init__(self, renderable: RenderableType) -> None:
        self._renderable = renderable

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[Segment]:
        """The printed form of the table."""
        for segment in console.render(self._renderable, options):
            yield segment._replace(text=harmless(segment.text))


def say_written(*paths: str | None, quiet: bool) -> None:
    """Say which files were written; None for those not requested."""
    for path in paths:
        say(f"wrote {path}", unless=quiet or path is None)


def say(message: str, *, unless: bool = False) -> None:
    """Print a message on standard error unless ``unless``; ignore a closed stream."""
    if unless:
        return
    with suppress(OSError):
        click.echo(f"adr-opt: {in_one_line(message)}", err=True)


def say_doubts(
    instance: Instance, *, quiet: bool = False, reword: Callable[[str], str] = str
) -> None:
    """Note on standard error the values that look like mistakes, in the caller's terms."""
    from ...problem.plausible import doubts

    for doubt in doubts(instance):
        say(f"note: {reword(str(doubt))}", unless=quiet)
