"""The live line: how far a method is, on a terminal."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager


def wanted(as_json: bool, quiet: bool) -> bool:
    """Whether somebody looks: standard error is a terminal, and nobody asked for silence."""
    return not as_json and not quiet and sys.stderr is not None and sys.stderr.isatty()


@contextmanager
def live_line(shown: bool) -> Iterator[Callable[[float, float, float], None]]:
    """A line on standard error, gone at the end; yields what updates it.

    The function takes incumbent, bound and the share of the timetable that is built; without
    ``shown`` it does nothing.
    """
    if not shown:
        yield lambda incumbent, bound, built: None
        return
    from rich.console import Console
    from rich.live import Live
    from rich.text import Text

    begun = time.monotonic()
    with Live(console=Console(stderr=True), auto_refresh=False, transient=True) as live:
        yield lambda incumbent, bound, built: live.update(
            Text(describe(time.monotonic() - begun, incumbent, bound, built)), refresh=True
        )


def describe(elapsed_s: float, incumbent: float, bound: float, built: float = 1.0) -> str:
    """The text of the line."""
    from ..plan import relative_gap

    if built < 1.0:
        return f"{elapsed_s:.1f} s  timetable {100.0 * built:.0f} %"

    parts = [f"{elapsed_s:.1f} s"]
    parts.append(f"incumbent {incumbent:g}" if math.isfinite(incumbent) else "no plan yet")
    if math.isfinite(bound):
        parts.append(f"bound {bound:.6g}")
        if math.isfinite(incumbent):
            parts.append(f"gap {relative_gap(incumbent, bound):.1%}")
    return "  ".join(parts)
