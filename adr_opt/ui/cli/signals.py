"""SIGINT and SIGTERM: the first requests an end, the second aborts, and none is lost."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType, TracebackType

INTERRUPTED = 128 + signal.SIGINT
"""Exit status after Ctrl-C, the one that shells use."""

AGAIN_S = 0.1
"""Interval at which a swallowed interrupt is raised again [s]."""


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
def signals_to(
    interrupt: Callable[[], None], numbers: tuple[int, ...] = (signal.SIGINT, signal.SIGTERM)
) -> Iterator[None]:
    """Let the first of some signals call a function, and a second one raise :class:`Aborted`.

    Parameters
    ----------
    interrupt : callable
        May raise KeyboardInterrupt.
    numbers : tuple of int
    """
    heard = False

    def hear(number: int, frame: FrameType | None) -> None:
        nonlocal heard
        if _raised.is_repeating:
            _raised.repeat()
            return
        try:
            if heard:
                raise Aborted(number)
            heard = True
            interrupt()
        except KeyboardInterrupt as error:
            _raised.insist_on(error)
            raise

    before = {}
    # Only the main thread may set handlers, and only it hears signals.
    if threading.current_thread() is threading.main_thread():
        for number in numbers:
            # Ignored signals, as in the background of a script, stay ignored.
            if signal.getsignal(number) not in (signal.SIG_IGN, None):
                before[number] = signal.signal(number, hear)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def interruptible() -> Iterator[Callable[[], bool]]:
    """Raise KeyboardInterrupt at the first SIGINT, and repeat it until it is handled.

    Python prints and drops what is raised in a ``__del__`` or in a callback from C, as where a
    kernel is loaded; libraries clear it, or print it and raise something else.

    Yields
    ------
    callable
        To be called where the exception arrives, or should have; returns whether one was raised.
    """

    def interrupt() -> None:
        raise KeyboardInterrupt

    report, show = sys.unraisablehook, sys.excepthook

    def drop(dropped: sys.UnraisableHookArgs) -> None:
        if not issubclass(dropped.exc_type, KeyboardInterrupt):
            report(dropped)

    def hide(kind: type[BaseException], error: BaseException, place: TracebackType | None) -> None:
        if not issubclass(kind, KeyboardInterrupt):
            show(kind, error, place)

    sys.unraisablehook, sys.excepthook = drop, hide
    try:
        with signals_to(interrupt, (signal.SIGINT,)):
            _raised.begin()
            try:
                yield _raised.settle
            finally:
                _raised.settle()
    finally:
        sys.unraisablehook, sys.excepthook = report, show


class _Raised:
    """The pending KeyboardInterrupt, if any."""

    def __init__(self) -> None:
        self._error: KeyboardInterrupt | None = None
        self._settled = threading.Event()
        self._settled.set()
        self._thread: threading.Thread | None = None
        self.is_repeating = False

    def begin(self) -> None:
        """From now on, repeat raised interrupts until they are settled."""
        self._settled.clear()

    def insist_on(self, error: KeyboardInterrupt) -> None:
        """Repeat an error, in place of any former one."""
        self._error = error
        if self._thread is None and not self._settled.is_set():
            main = threading.get_ident()
            self._thread = threading.Thread(target=self._repeat, args=(main,), daemon=True)
            self._thread.start()

    def _repeat(self, main: int) -> None:
        while not self._settled.wait(AGAIN_S):
            self.is_repeating = True
            # A true signal, which also wakes what waits; Windows has none for a thread.
            if hasattr(signal, "pthread_kill"):
                signal.pthread_kill(main, signal.SIGINT)
            else:
                signal.raise_signal(signal.SIGINT)

    def repeat(self) -> None:
        """Raise the error again, unless it is being handled or has been."""
        self.is_repeating = False
        error = self._error
        if error is not None and not _is_handling(error):
            raise error

    def settle(self) -> bool:
        """Stop repeating; returns whether an interrupt was pending."""
        was, self._error = self._error is not None, None
        self._settled.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None
            self.is_repeating = False
        return was


_raised = _Raised()


def _is_handling(error: BaseException) -> bool:
    """Whether the main thread is in an except, finally or with clause because of an error."""
    handled, seen = sys.exc_info()[1], set()
    while handled is not None and id(handled) not in seen:
        if handled is error:
            return True
        seen.add(id(handled))
        handled = handled.__context__
    return False
