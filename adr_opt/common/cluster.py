"""Calls run elsewhere: in an executor on this machine or by the workers of a Dask cluster."""

from __future__ import annotations

import re
from collections.abc import Callable
from concurrent.futures import Executor, Future
from typing import Any, ParamSpec, Protocol, TypeVar

from .errors import InputError, MissingExtra

PATIENCE_S = 10.0
"""Longest wait for a scheduler to answer, and for its first worker to appear [s]."""

P = ParamSpec("P")
T = TypeVar("T")


class Calls(Protocol):
    """Something that runs calls, several at once."""

    @property
    def count(self) -> int:
        """Number of calls run at once."""
        ...

    def submit(self, call: Callable[P, T], /, *arguments: P.args, **named: P.kwargs) -> Future[T]:
        """Submit a call."""
        ...

    def result(self, future: Future[T]) -> T:
        """The result of a call."""
        ...

    def close(self) -> None:
        """Cancel submitted calls that have not begun."""
        ...


class LocalPool:
    """Calls run by an executor on this machine.

    Parameters
    ----------
    executor : concurrent.futures.Executor
    count : int
        Number of calls at once.
    """

    def __init__(self, executor: Executor, count: int) -> None:
        self._executor, self.count = executor, count

    def submit(self, call: Callable[P, T], /, *arguments: P.args, **named: P.kwargs) -> Future[T]:
        """Submit a call."""
        return self._executor.submit(call, *arguments, **named)

    def result(self, future: Future[T]) -> T:
        """The result of a call."""
        return future.result()

    def close(self) -> None:
        """Cancel submitted calls that have not begun, and wait for the others."""
        self._executor.shutdown(cancel_futures=True)


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
        raise InputError(f"--cluster: {address!r} is no address; write dask://HOST:PORT")
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


def count_of(client: Any) -> int:
    """Number of calls that a client's workers can run at once, now."""
    return max(1, sum(map(int, client.nthreads().values())))


class Workers:
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
        return count_of(self._client)

    def submit(self, call: Callable[P, T], /, *arguments: P.args, **named: P.kwargs) -> Future[T]:
        """Submit a call."""
        future: Future[T] = self._executor.submit(call, *arguments, **named)
        return future

    def result(self, future: Future[T]) -> T:
        """The result of a call.

        Raises
        ------
        InputError
            Workers lack adr-opt, died over it, or the scheduler is gone.
        """
        import distributed

        try:
            return future.result()
        except ImportError as error:
            why = f"a worker lacks a module ({error}); install adr-opt there"
        except (distributed.KilledWorker, distributed.CancelledError, OSError) as error:
            why = f"workers died, or the scheduler is gone ({type(error).__name__})"
        raise InputError(f"--cluster {self._address}: {why}")

    def close(self) -> None:
        """Cancel submitted calls, and leave the cluster as it was."""
        self._executor.shutdown(wait=False)
        self._client.close(timeout=5)
