"""Workers on this machine: processes of joblib's loky."""

from __future__ import annotations

import contextlib
import queue
import signal
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from adr_opt.common.errors import InputError, MissingExtra

from .backend import Broken, Collected, Died, Done, Event, Messages, Told
from .channel import Address, Channel, connect
from .methods import Method
from .trials import BoundCall, Task
from .work import preflight, work

IDLE_S = 60.0
ONE_THREAD = {
    name: "1"
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
}
"""Each worker has one core; without this every library would start a thread for each core."""

_send: Callable[[Any], None] | None = None


class Processes:
    """Worker processes; dead ones are replaced.

    Parameters
    ----------
    workers : int

    Raises
    ------
    MissingExtra
        joblib is not installed.
    """

    def __init__(self, workers: int) -> None:
        try:
            from joblib.externals import loky
        except ImportError:
            raise MissingExtra("running the benchmark", "joblib", "bench") from None
        self._loky = loky
        self._latest: Any = None
        self.workers = workers
        self.inbox: queue.Queue[Event] = queue.Queue()
        self._channel = Channel(lambda message: self.inbox.put(Told(message)))

    def _executor(self) -> Any:
        # Gives the same executor again and again, and a new one once that is broken.
        self._latest = self._loky.get_reusable_executor(
            max_workers=self.workers,
            timeout=IDLE_S,
            initializer=_begin,
            initargs=(self._channel.address,),
            env=ONE_THREAD,
        )
        return self._latest

    def preflight(self, methods: tuple[Method | BoundCall, ...]) -> str | None:
        """Start the workers and load the methods; what input is wrong, if any."""
        try:
            self._executor().submit(preflight, ()).result()
        except self._loky.BrokenProcessPool as error:
            raise InputError(
                f"no worker process could be started ({error}); try fewer with --jobs"
            ) from None
        for methods_now in [(method,) for method in methods] + [methods] * (self.workers - 1):
            # What kills a process here will kill it there, and have a row for it.
            with contextlib.suppress(self._loky.BrokenProcessPool):
                wrong = self._executor().submit(preflight, methods_now).result()
                if wrong is not None:
                    return str(wrong)
        return None

    def submit(self, task: Task) -> None:
        """Hand out a task."""
        try:
            future = self._executor().submit(_work, task)
        except self._loky.BrokenProcessPool:
            self.inbox.put(Died(task))
            return
        future.add_done_callback(lambda future: self._ended(task, future))

    def _ended(self, task: Task, future: Future[Messages]) -> None:
        error = None if future.cancelled() else future.exception()
        if future.cancelled() or isinstance(error, self._loky.BrokenProcessPool):
            self.inbox.put(Died(task))
        elif error is not None:
            said = f"a worker process cannot work: {type(error).__name__}: {error}"
            self.inbox.put(Broken(said))
        else:
            self.inbox.put(Done(task, future.result()))

    def close(self) -> None:
        """Kill the workers."""
        if self._latest is not None:
            self._latest.shutdown(wait=True, kill_workers=True)
        self._channel.close()


def _begin(address: Address) -> None:
    """Make a process a worker."""
    global _send
    # Ctrl-C goes to every process of the terminal; the coordinator alone decides what it means.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _send = connect(address)


def _work(task: Task) -> Messages:
    assert _send is not None
    collected = Collected(_send)
    work(task, collected)
    return collected.messages
