"""Transient progress bars on a terminal: parts done, or just activity."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ..watched import teller

Show = Callable[[int, int], None]


@contextmanager
def counting_bar(shown: bool, what: str) -> Iterator[Show]:
    """Yield a callback for the numbers of finished parts and of all parts.

    Parameters
    ----------
    shown : bool
        Draw a bar; otherwise say nothing.
    what : str
        What is done to which parts.
    """
    if not shown:
        tell = teller()
        if tell is None:
            yield lambda done, total: None
        else:
            yield lambda done, total: tell(done / max(total, 1), what)
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=None)

        def show(done: int, total: int) -> None:
            bar.update(task, completed=done, total=total)

        yield show


@contextmanager
def percent_bar(shown: bool, what: str) -> Iterator[Callable[[float], None]]:
    """Yield a callback for the share that is done."""
    with counting_bar(shown, f"{what}, %") as show:
        yield lambda share: show(round(100.0 * share), 100)


@contextmanager
def busy_bar(shown: bool, what: str) -> Iterator[None]:
    """A moving bar for work of unknown length.

    Parameters
    ----------
    shown, what
        As of :func:`counting_bar`.
    """
    if not shown:
        yield
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn()
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        bar.add_task(what, total=None)
        yield
