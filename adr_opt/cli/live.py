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
def live_line(shown: bool) -> Iterator[Callable[[float, float], None]]:
    """A line on standard error, gone at the end; yields what updates it.

    The function takes incumbent and bound; without ``shown`` it does nothing.
    """
    if not shown:
        yield lambda incumbent, bound: None
        return
    from rich.console import Console
    from rich.live import Live
    from rich.text import Text

    begun = time.monotonic()
    with Live(console=Console(stderr=True), auto_refresh=False, transient=True) as live:
        yield lambda incumbent, bound: live.update(
            Text(describe(time.monotonic() - begun, incumbent, bound)), refresh=True
        )


def describe(elapsed_s: float, incumbent: float, bound: float) -> str:
    """The text of the line."""
    from ..plan import relative_gap

    parts = [f"{elapsed_s:.1f} s"]
    parts.append(f"incumbent {incumbent:g}" if math.isfinite(incumbent) else "no plan yet")
    if math.isfinite(bound):
        parts.append(f"bound {bound:.6g}")
        if math.isfinite(incumbent):
            parts.append(f"gap {relative_gap(incumbent, bound):.1%}")
    return "  ".join(parts)
