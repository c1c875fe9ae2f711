"""Bars on a terminal, gone at the end: how many parts are done, or that something is being done."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

Show = Callable[[int, int], None]


@contextmanager
def counting_bar(shown: bool, what: str) -> Iterator[Show]:
    """Yields what hears of the parts done and of how many there are.

    Parameters
    ----------
    shown : bool
        Draw a bar; otherwise say nothing.
    what : str
        What is done to which parts.
    """
    if not shown:
        yield lambda done, total: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(),
    )  # fmt: skip
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=None)

        def show(done: int, total: int) -> None:
            bar.update(task, completed=done, total=total)

        yield show


@contextmanager
def percent_bar(shown: bool, what: str) -> Iterator[Callable[[float], None]]:
    """The same of a share: yields what hears of it."""
    with counting_bar(shown, f"{what}, %") as show:
        yield lambda share: show(round(100.0 * share), 100)


@contextmanager
def busy_bar(shown: bool, what: str) -> Iterator[None]:
    """A bar that moves while something takes its time, for as long as nobody can say how long.

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
