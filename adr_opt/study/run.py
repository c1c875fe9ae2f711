"""Runs of a study: missing rows are computed, and written to its file as they finish."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from types import TracebackType
from typing import Any, Generic, Self

from ..common.errors import InputError
from ..common.processors import usable_cores
from ..common.stop import Stop
from .file import Stored, StudyFile
from .study import K, Place, Study, V
from .workers import Answer, Here, Workers

POLL_S = 0.1
"""Longest time after which a stop is noticed [s]."""

SHARE = 4
"""Least number of calls for each process, so that all end at about the same time."""

FEWEST_OF_CLUSTER = 16
"""Least number of workers assumed of a cluster, for the size of calls."""

Told = Callable[[int, int], None]


class Run(Generic[K, V]):
    """A run of a study, as a context manager: at its end processes end and the file is released.

    Parameters
    ----------
    study : Study
    path : path, optional
        File of the rows, which may be there from an earlier run.
    jobs : int
        Processes, each with one row at a time; 0 for one per core. With one all happens in this
        process, unless the study has its rows made apart.
    cluster : str, optional
        Address of a Dask scheduler whose workers make the rows instead, as
        :func:`.cluster.client_of` takes it.
    stop : Stop, optional
        Ends the run early; rows that are being made then are left out.

    Raises
    ------
    InputError
        The number of jobs, or the file, does not fit.
    """

    def __init__(
        self,
        study: Study[K, V],
        path: str | os.PathLike[str] | None = None,
        *,
        jobs: int = 1,
        cluster: str | None = None,
        stop: Stop | None = None,
    ) -> None:
        check_jobs(jobs, cluster)
        self._study, self._jobs, self._cluster = study, jobs, cluster
        self._place = Place(stop=stop)
        self._file = None if path is None else StudyFile(path, study)
        self._found: dict[str, Stored] = {} if self._file is None else self._file.found
        self._workers: Workers | None = None

    def __enter__(self) -> Self:
        """Begin."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the run, finished or not."""
        if self._workers is not None:
            self._workers.close()
        if self._file is not None:
            self._file.close()

    @property
    def has_rows(self) -> bool:
        """Whether the file had rows before this run."""
        return bool(self._found)

    @property
    def workers(self) -> int:
        """Number of rows computed at once."""
        return self._started().count

    def known(self, key: K) -> V | None:
        """The row of a key from the file; None if it has none.

        Raises
        ------
        InputError
            It is no row of this study.
        """
        stored = self._found.get(self._study.name(key))
        return None if stored is None else row_of(self._study, key, stored)

    def forget(self, key: K) -> None:
        """Compute the row of a key again, even if the file has it."""
        self._found.pop(self._study.name(key), None)

    def rows(self, groups: Iterable[tuple[K, ...]]) -> Iterator[tuple[K, V]]:
        """Keys with their rows: those of the file immediately, others as they finish.

        Parameters
        ----------
        groups : iterable of tuple of keys
            Those of a group are made one after the other in one process, which may keep what they
            share. The next group is asked for only when there is somebody to make it: it may
            depend on all rows until then.
        """
        waiting = iter(groups)
        left = True
        while True:
            while left and not self._place.is_over and self._is_free():
                group = next(waiting, None)
                left = group is not None
                missing = []
                for key in group or ():
                    stored = self._found.get(self._study.name(key))
                    if stored is None:
                        missing.append(key)
                    else:
                        yield key, row_of(self._study, key, stored)
                if missing:
                    self._started().submit(tuple(missing))
            if self._workers is None or not self._workers.busy or self._place.is_over:
                return
            finished = [(key, self._row(key, made), made.seconds) for key, made in self._wait()]
            if self._file is not None and finished:
                study = self._study
                self._file.append(
                    (study.key(key), study.to_json(row), took) for key, row, took in finished
                )
            for key, row, _ in finished:
                yield key, row

    def _is_free(self) -> bool:
        return self._workers is None or self._workers.busy < self._workers.count

    def _wait(self) -> list[tuple[Any, Answer]]:
        assert self._workers is not None
        return self._workers.wait(POLL_S)

    def _row(self, key: K, made: Answer) -> V:
        if made.error is None:
            value: V = made.value
            return value
        if self._study.failed is None:
            raise made.error
        return self._study.failed(key, made.error)

    def _started(self) -> Workers:
        """The workers, started for the first missing row."""
        if self._workers is None:
            row, jobs = self._study.row, self._jobs or usable_cores()
            if self._cluster is not None:
                from .cluster import ClusterWorkers

                self._workers = ClusterWorkers(row, self._cluster)
            elif jobs > 1 or self._study.apart:
                from .processes import Processes

                self._workers = Processes(row, jobs)
            else:
                self._workers = Here(row, self._place)
        return self._workers


def run(
    study: Study[K, V],
    keys: Iterable[K],
    path: str | os.PathLike[str] | None = None,
    *,
    jobs: int = 1,
    cluster: str | None = None,
    stop: Stop | None = None,
    told: Told = lambda done, of: None,
    most: int = 1,
) -> dict[K, V]:
    """Rows of hashable keys, in the order of the keys; keys cut off by a stop are omitted.

    Parameters
    ----------
    study, path, jobs, cluster, stop
        As :class:`Run` takes them.
    keys : iterable
    told : callable
        Called with the numbers of finished rows and of all, for each row that is made.
    most : int
        Most rows that a process makes for a call, where rows are many and quick.

    Raises
    ------
    InputError
        The number of jobs, or the file, does not fit.
    """
    wanted, found = tuple(dict.fromkeys(keys)), dict[K, V]()
    with Run(study, path, jobs=jobs, cluster=cluster, stop=stop) as running:
        for key in wanted:
            row = running.known(key)
            if row is not None:
                found[key] = row
        left = [key for key in wanted if key not in found]
        count = FEWEST_OF_CLUSTER if cluster is not None else jobs or usable_cores()
        size = max(1, min(most, len(left) // (SHARE * count)))
        groups = (tuple(left[at : at + size]) for at in range(0, len(left), size))
        for key, row in running.rows(groups):
            found[key] = row
            told(len(found), len(wanted))
    return {key: found[key] for key in wanted if key in found}


def check_jobs(jobs: int, cluster: str | None) -> None:
    """Refuse numbers of processes that make no sense.

    Raises
    ------
    InputError
        Too few, or processes beside a cluster.
    """
    if jobs < 0:
        raise InputError(f"jobs = {jobs}: must be 0, for all cores, or more")
    if jobs != 1 and cluster is not None:
        raise InputError("jobs and a cluster exclude each other; leave one of them out")


def row_of(study: Study[K, V], key: K, stored: Stored) -> V:
    """The row of a key, restored from its stored form.

    Raises
    ------
    InputError
        It is no row of the study.
    """
    try:
        return study.from_json(key, stored.value)
    except InputError as error:
        raise InputError(f"{stored.where}: {error}; name another file") from None
    except (ValueError, TypeError, LookupError, AttributeError, OverflowError, RecursionError):
        raise InputError(
            f"{stored.where}: not a row of {study.protocol}; name another file"
        ) from None
