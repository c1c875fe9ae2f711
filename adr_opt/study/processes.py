"""Rows made in other processes of this machine.

A process that dies takes nothing with it but the row that it was making: that one is tried again
once, in a new process, and then given up.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any

from .study import Place
from .workers import Answer, Row, WorkerDied, made_of, sendable

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
"""Environment that gives each process one thread; libraries would start one for each core."""

ENDING_S = 5.0
"""Longest wait for a process to end when asked to [s]."""

_starting = threading.Lock()


@dataclass
class _Worker:
    """A process with its remaining keys, and whether another process died on the first of them."""

    process: BaseProcess
    line: Connection
    keys: tuple[Any, ...] = ()
    died: bool = False


class Processes:
    """Rows computed in several processes, each with one group of keys at a time.

    Parameters
    ----------
    row : callable
        Picklable; each process has one copy.
    count : int
        Number of processes; they are started when they are needed.
    """

    def __init__(self, row: Row, count: int) -> None:
        self._row, self.count = pickle.dumps(row), count
        self._idle: list[_Worker] = []
        self._busy: list[_Worker] = []

    @property
    def busy(self) -> int:
        """Number of groups under way."""
        return len(self._busy)

    def submit(self, keys: tuple[Any, ...], *, died: bool = False) -> None:
        """Submit a group of keys to an idle process or a new one."""
        worker = self._idle.pop() if self._idle else self._started()
        worker.keys, worker.died = keys, died
        self._busy.append(worker)
        with suppress(OSError):  # it has died since; wait() finds that out
            worker.line.send(keys)

    def wait(self, longest_s: float) -> list[tuple[Any, Answer]]:
        """Answers since the last call, after waiting for the first one."""
        found: list[tuple[Any, Answer]] = []
        lines = {worker.line: worker for worker in self._busy}
        for line in wait(list(lines), longest_s):
            worker = lines[line]  # type: ignore[index]
            try:
                made = worker.line.recv()
            except (EOFError, OSError):
                found.extend(self._after_death(worker))
                continue
            found.append((worker.keys[0], made))
            worker.keys, worker.died = worker.keys[1:], False
            if not worker.keys:
                self._busy.remove(worker)
                self._idle.append(worker)
        return found

    def _after_death(self, worker: _Worker) -> list[tuple[Any, Answer]]:
        """Continue with the keys of a process that died; returns the answers given up."""
        self._busy.remove(worker)
        worker.line.close()
        worker.process.join()
        first, *others = worker.keys
        if not worker.died:
            self.submit(worker.keys, died=True)
            return []
        if others:
            self.submit(tuple(others))
        error = WorkerDied(f"its process died twice (exit code {worker.process.exitcode})")
        return [(first, Answer(None, error, 0.0))]

    def close(self) -> None:
        """End the processes, finished or not."""
        workers = [*self._busy, *self._idle]
        for worker in workers:
            worker.line.close()
            worker.process.terminate()
        for worker in workers:
            worker.process.join(ENDING_S)
            if worker.process.is_alive():
                worker.process.kill()
                worker.process.join()
        self._busy, self._idle = [], []

    def _started(self) -> _Worker:
        # A fork of a process with threads may wait for a lock that is never released.
        context = multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe()
        process = context.Process(target=_serve, args=(theirs, self._row), daemon=True)
        with _one_thread():
            process.start()
        theirs.close()  # or its end would not be noticed
        return _Worker(process, ours)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Set the environment of processes with one core each."""
    with _starting:
        before = {name: os.environ.get(name) for name in ONE_THREAD}
        os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
        try:
            yield
        finally:
            for name, value in before.items():
                if value is None:
                    del os.environ[name]
                else:
                    os.environ[name] = value


def _serve(line: Connection, row: bytes) -> None:
    """Compute rows for the parent process until it ends."""
    # Ctrl-C goes to every process of the terminal; the one that began the study decides.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
    call: Row | None = None
    with suppress(EOFError, OSError):
        while True:
            for key in line.recv():
                if call is None:
                    call = pickle.loads(row)
                line.send(sendable(made_of(call, key, Place(alone=False))))
