"""Runs of a method that can be watched and interrupted."""

from __future__ import annotations

import math
import signal
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Generic, TypeVar

from .bars import live_line, wanted
from .output import emit_json, say
from .signals import Aborted, signals_to

if TYPE_CHECKING:
    from ...common.stop import Stop
    from ...legs.timetable_size import Size
    from ...mission.problem import Problem
    from ...mission.result import Result
    from ...problem.instance import Instance
    from ...run.run_options import RunOptions

Found = TypeVar("Found")

POLL_S = 0.1


class Watch:
    """A progress callback that records the best incumbent and bound."""

    def __init__(self) -> None:
        self.incumbent = -math.inf
        self.bound = math.inf
        self.built = 1.0
        self.size: Size | None = None

    def sizing(self, size: Size) -> None:
        """Receive the size of a large timetable before it is built."""
        self.size = size

    def building(self, share: float) -> None:
        """Receive the share of the timetable that is built."""
        self.built = share

    def __call__(self, incumbent: float, bound: float) -> None:
        """Receive an incumbent and a bound; the timetable is as complete as it will be."""
        self.built = 1.0
        self.incumbent = max(self.incumbent, incumbent)
        self.bound = min(self.bound, bound)


class _Begun(threading.Thread, Generic[Found]):
    """Work in a daemon thread, which does not keep the process from ending."""

    def __init__(self, task: Callable[[], Found]) -> None:
        super().__init__(name="work", daemon=True)
        self._task, self.done = task, threading.Event()
        self._found: list[Found] = []
        self._error: BaseException | None = None

    def run(self) -> None:
        try:
            self._found.append(self._task())
        except BaseException as error:
            self._error = error
        finally:
            self.done.set()

    def result(self) -> Found:
        """The result of the work; raises the error that ended it."""
        if self._error is not None:
            raise self._error
        return self._found[0]


def work(task: Callable[[Stop, Watch], Found], *, live: bool, quiet: bool) -> Found:
    """Run a method in a thread, so that signals and the live line need not wait for kernels.

    The first Ctrl-C (or SIGTERM) asks the method to return what it has; the second aborts.

    Parameters
    ----------
    task : callable
        Called with a stop and a progress that hears of the timetable, too.
    live : bool
        Show a live line on standard error.
    quiet : bool
        Say nothing.

    Raises
    ------
    Aborted
        On the second signal. The thread is still running then.
    """
    from ...common.stop import Interrupted
    from ...kernels.core.cache import trouble
    from ...kernels.core.compile import is_compiling

    stop, watch = Interrupted(), Watch()
    begun = _Begun(lambda: task(stop, watch))
    told = warned = sized = False
    with signals_to(stop.interrupt), live_line(live) as show:
        begun.start()
        while not begun.done.wait(POLL_S):
            compiling = is_compiling()
            show(watch.incumbent, watch.bound, watch.built, compiling)
            if compiling and not warned and not live and not quiet:
                say("compiling, once; it does not count for the time limit")
                warned = True
            if watch.size is not None and not sized and not quiet:
                say(f"building {watch.size}")
                sized = True
            if stop.is_set and not told and not quiet:
                say("interrupted: waiting for the best result so far; interrupt again to abort")
                told = True
    if trouble() is not None and not quiet:
        say(f"compiled kernels cannot be kept: {trouble()}")
    found = begun.result()
    if stop.is_set and not quiet:
        say("interrupted: this is the best result so far")
    return found


def attend(task: Callable[[], Found], what: str, *, live: bool) -> Found:
    """Run work that writes nothing in a thread, so that Ctrl-C need not wait for kernels.

    Parameters
    ----------
    task : callable
    what : str
        What is said of it.
    live : bool
        Show a bar on standard error.

    Raises
    ------
    Aborted
        On the first Ctrl-C. The thread is still running then.
    """
    from .bars import busy_bar

    begun = _Begun(task)
    with busy_bar(live, what):
        begun.start()
        try:
            begun.done.wait()
        except KeyboardInterrupt:
            raise Aborted(signal.SIGINT) from None
    return begun.result()


def run_method(
    group: str,
    problem: Instance | Problem,
    method: str,
    given: RunOptions,
    *,
    as_json: bool,
    quiet: bool,
) -> Result:
    """Run a planner or a bound, and print its notes."""
    from ...run import front

    result = work(
        lambda stop, progress: front.run(
            group,
            problem,
            method,
            given,
            stop=stop,
            progress=progress,
            building=progress.building,
            sizing=progress.sizing,
        ),
        live=wanted(as_json, quiet),
        quiet=quiet,
    )
    say_notes(result, quiet)
    return result


def say_notes(result: Result, quiet: bool) -> None:
    """Print the notes of a result, one per line."""
    for note in result.notes:
        say(f"note: {note}", unless=quiet)


def emit_result(instance: Instance, margin: float, result: Result) -> None:
    """Print a result as one JSON object, with its instance and settings."""
    reference = {"name": instance.name, "sha256": instance.sha256}
    emit_json({"instance": reference, "margin": margin, **result.to_dict()})
