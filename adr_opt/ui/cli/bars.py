"""Progress on a terminal: transient bars, and the live line of a method."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ...common.clock import now_s
from ..watched import teller

Show = Callable[[int, int], None]


@contextmanager
def counting_bar(shown: bool, what: str) -> Iterator[Show]:
    """Yield a callback for the number of finished parts and the total.

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
    """Yield a callback for the finished share."""
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


def wanted(as_json: bool, quiet: bool) -> bool:
    """Whether to show progress: standard error is a terminal, and neither option forbids it."""
    return not as_json and not quiet and sys.stderr is not None and sys.stderr.isatty()


@contextmanager
def live_line(shown: bool) -> Iterator[Callable[[float, float, float, bool], None]]:
    """Show a line on standard error until the end; yields its update function.

    The function takes incumbent, bound, the share of the timetable that is built, and whether
    a kernel is being compiled, for which the clock stands still. Without ``shown`` it does nothing.
    """
    if not shown:
        tell, since = teller(), now_s()

        def passed_on(incumbent: float, bound: float, built: float, compiling: bool) -> None:
            if tell is not None:
                tell(None, describe(now_s() - since, incumbent, bound, built))

        yield passed_on
        return
    from rich.console import Console
    from rich.live import Live
    from rich.text import Text

    begun = now_s()
    with Live(console=Console(stderr=True), auto_refresh=False, transient=True) as live:

        def show(incumbent: float, bound: float, built: float, compiling: bool) -> None:
            text = describe(now_s() - begun, incumbent, bound, built)
            if compiling:
                text += "  compiling, once"
            live.update(Text(text), refresh=True)

        yield show


def describe(elapsed_s: float, incumbent: float, bound: float, built: float = 1.0) -> str:
    """The text of the line."""
    from ...plan.plan import relative_gap

    if built < 1.0:
        return f"{elapsed_s:.1f} s  timetable {100.0 * built:.0f} %"

    parts = [f"{elapsed_s:.1f} s"]
    parts.append(f"incumbent {incumbent:g}" if math.isfinite(incumbent) else "no plan yet")
    if math.isfinite(bound):
        parts.append(f"bound {bound:.6g}")
        if math.isfinite(incumbent):
            parts.append(f"gap {relative_gap(incumbent, bound):.1%}")
    return "  ".join(parts)
