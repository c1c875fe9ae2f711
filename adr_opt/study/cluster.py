"""Calls and rows computed by the workers of a Dask cluster."""

from __future__ import annotations

import pickle
import re
import secrets
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, wait
from typing import Any, ParamSpec, TypeVar

from ..common.errors import InputError, MissingExtra
from .study import Place
from .workers import Answer, Row, WorkerDied, made_of, sendable

P = ParamSpec("P")
T = TypeVar("T")

PATIENCE_S = 10.0
"""Longest wait for a scheduler to answer, and for its first worker to appear [s]."""


def client_of(address: str) -> Any:
    """The ``distributed.Client`` of a scheduler that has workers.

    Parameters
    ----------
    address : str
        ``dask://host:port``, or ``tcp://`` or ``tls://``.

    Raises
    ------
    InputError
        Not an address, no scheduler answers there, or it has no workers.
    MissingExtra
        distributed is not installed.
    """
    found = re.fullmatch(r"(?:dask|tcp|tls)://([^/\s]+:\d+)/?", address)
    if found is None:
        raise InputError(f"--cluster: {address!r} is not an address; write dask://HOST:PORT")
    try:
        import distributed
    except ImportError:
        raise MissingExtra("--cluster", "distributed", "cluster") from None
    scheme = "tls" if address.startswith("tls") else "tcp"
    place = f"{scheme}://{found[1]}"
    try:
        client: Any = distributed.Client(  # type: ignore[no-untyped-call]
            place, timeout=PATIENCE_S, set_as_default=False
        )
    except (OSError, TimeoutError, ValueError):
        raise InputError(
            f"--cluster: no Dask scheduler answers at {address}; "
            "start one with 'dask scheduler', or check host and port"
        ) from None
    try:
        client.wait_for_workers(1, timeout=PATIENCE_S)
    except TimeoutError:
        client.close()
        raise InputError(
            f"--cluster: the scheduler at {address} has no workers; "
            f"start some with 'dask worker {place} --nthreads 1'"
        ) from None
    return client


class Cluster(Executor):
    """Calls run by the workers of a Dask cluster, which need adr-opt (extra ``cluster``).

    Parameters
    ----------
    address : str
        As :func:`client_of` takes it.

    Raises
    ------
    InputError, MissingExtra
        As :func:`client_of` does.
    """

    def __init__(self, address: str) -> None:
        self._address = address
        self._client = client_of(address)
        self._executor = self._client.get_executor(pure=False)

    @property
    def count(self) -> int:
        """Number of calls that the cluster can run at once, now."""
        return max(1, sum(map(int, self._client.nthreads().values())))

    def submit(self, call: Callable[P, T], /, *arguments: P.args, **named: P.kwargs) -> Future[T]:
        """Submit a call.

        Its future raises :class:`.workers.WorkerDied` where workers died over it, and InputError
        where they lack a package or the scheduler is gone.
        """
        told: Future[T] = Future()

        def pass_on(done: Future[T]) -> None:
            if not told.set_running_or_notify_cancel():
                return
            try:
                told.set_result(done.result())
            except BaseException as error:
                told.set_exception(self._said(error))

        self._executor.submit(call, *arguments, **named).add_done_callback(pass_on)
        return told

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Cancel submitted calls, and leave the cluster as it was."""
        self._executor.shutdown(wait=False)
        self._client.close(timeout=5)

    def _said(self, error: BaseException) -> BaseException:
        import distributed

        if isinstance(error, ImportError):
            why = f"a worker lacks a module ({error}); install adr-opt there"
        elif isinstance(error, distributed.KilledWorker):
            return WorkerDied(f"--cluster {self._address}: workers died over a call")
        elif isinstance(error, (CancelledError, distributed.CancelledError, OSError)):
            why = f"the scheduler is gone ({type(error).__name__})"
        else:
            return error
        return InputError(f"--cluster {self._address}: {why}")


class ClusterWorkers:
    """Rows made by the workers of a Dask cluster.

    Parameters
    ----------
    row : callable
        Each worker keeps one copy. What it is made of has to be installed there, or to be
        registered with cloudpickle as sent by value.
    address : str
        As :func:`client_of` takes it.
    """

    def __init__(self, row: Row, address: str) -> None:
        self._cluster = Cluster(address)
        from cloudpickle import dumps  # comes with distributed

        self._dumps = dumps
        self._row, self._token = dumps(row), secrets.token_hex(8)
        self._out: dict[Future[list[Answer]], tuple[Any, ...]] = {}

    @property
    def count(self) -> int:
        """Number of groups that can run at once."""
        return self._cluster.count

    @property
    def busy(self) -> int:
        """Number of groups under way."""
        return len(self._out)

    def submit(self, keys: tuple[Any, ...]) -> None:
        """Submit a group of keys; all its rows come at its end."""
        self._out[self._cluster.submit(_made_there, self._token, self._row, self._dumps(keys))] = (
            keys
        )

    def wait(self, longest_s: float) -> list[tuple[Any, Answer]]:
        """Answers since the last call, after waiting for the first one."""
        found: list[tuple[Any, Answer]] = []
        for each in wait(self._out, longest_s, FIRST_COMPLETED).done:
            keys = self._out.pop(each)
            try:
                found.extend(zip(keys, each.result(), strict=True))
            except WorkerDied as error:
                if len(keys) == 1:
                    found.append((keys[0], Answer(None, error, 0.0)))
                else:  # one of them is at fault
                    for key in keys:
                        self.submit((key,))
        return found

    def close(self) -> None:
        """End all work, finished or not."""
        self._cluster.shutdown()


_mine: tuple[str, Row] | None = None
"""The latest row that this worker made, with its token."""


def _made_there(token: str, row: bytes, keys: bytes) -> list[Answer]:
    global _mine
    if _mine is None or _mine[0] != token:
        _mine = token, pickle.loads(row)
    return [sendable(made_of(_mine[1], key, Place(alone=False))) for key in pickle.loads(keys)]
