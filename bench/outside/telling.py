"""Output of a benchmark: lines printed and kept as they come, and a progress bar."""

from __future__ import annotations

import queue
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TextIO

Doing = Callable[[str, int, int], None]
"""Takes the current step, the number of finished parts and the number of all parts."""

Lines = Callable[[Doing], Iterable[str]]
"""Source of lines, which raises what is wrong with the call before the first of them."""


def silent(what: str, done: int, total: int) -> None:
    """Ignore progress."""


def tell(lines: Lines, heading: str, out: Path | None = None) -> None:
    """Print lines when they come, and write them to a file; the heading before the first.

    They come from a thread of their own, so that Ctrl-C does not wait for it. An interrupt is
    queued like a line: raised anywhere, it would meet the bar half drawn.

    Parameters
    ----------
    lines : callable
    heading : str
    out : Path, optional
        Every line is there as soon as it is printed.
    """
    said: queue.SimpleQueue[Any] = queue.SimpleQueue()

    def run(doing: Doing) -> None:
        try:
            for line in lines(doing):
                said.put(line)
            said.put(None)
        except BaseException as error:
            said.put(error)

    kept: TextIO | None = None
    former: Any = None
    if threading.current_thread() is threading.main_thread():
        former = signal.signal(signal.SIGINT, lambda number, frame: said.put(KeyboardInterrupt()))
    try:
        with _bar() as (doing, hidden):
            threading.Thread(target=run, args=(doing,), name="benchmark", daemon=True).start()
            while (line := said.get()) is not None:
                if isinstance(line, BaseException):
                    raise line
                if kept is None and out is not None:
                    kept = out.open("w", encoding="utf-8")
                with hidden():
                    # What is printed is kept: the file comes first.
                    for stream in (*([kept] if kept else []), sys.stdout):
                        text = (heading, line) if heading else (line,)
                        print(*text, sep="\n", file=stream, flush=True)
                heading = ""
    finally:
        if former is not None:
            signal.signal(signal.SIGINT, former)
        if kept is not None:
            kept.close()


@contextmanager
def _bar() -> Iterator[tuple[Doing, Callable[[], Any]]]:
    """A bar on standard error if that is a terminal, and what hides it for a while."""

    @contextmanager
    def shown() -> Iterator[None]:
        yield

    if not sys.stderr.isatty():
        yield silent, shown
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
    )
    bar = Progress(*columns, console=Console(stderr=True), transient=True, redirect_stdout=False)
    task = bar.add_task("reading", total=None)

    def doing(what: str, done: int, total: int) -> None:
        bar.update(task, description=what, completed=done, total=total)

    @contextmanager
    def hidden() -> Iterator[None]:
        bar.stop()
        yield
        bar.start()

    with bar:
        yield doing, hidden
