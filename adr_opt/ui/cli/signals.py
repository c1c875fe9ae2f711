"""SIGINT and SIGTERM: the first requests an end, the second aborts."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


class Aborted(KeyboardInterrupt):
    """The user asked a second time: exit at once.

    Parameters
    ----------
    number : int
    """

    def __init__(self, number: int) -> None:
        super().__init__()
        self.number = number


@contextmanager
def signals_to(interrupt: Callable[[], None]) -> Iterator[None]:
    """Let the first SIGINT or SIGTERM call a function; a second raises :class:`Aborted`."""
    heard = False

    def hear(number: int, frame: FrameType | None) -> None:
        nonlocal heard
        if heard:
            raise Aborted(number)
        heard = True
        interrupt()

    before = {}
    # Only the main thread may set handlers, and only it hears signals.
    if threading.current_thread() is threading.main_thread():
        for number in (signal.SIGINT, signal.SIGTERM):
            # Ignored signals, as in the background of a script, stay ignored.
            if signal.getsignal(number) not in (signal.SIG_IGN, None):
                before[number] = signal.signal(number, hear)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
