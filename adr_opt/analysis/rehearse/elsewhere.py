"""Calls on groups of seeds in other processes, or by the workers of a Dask cluster."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from typing import TypeVar

from ...common.cluster import Calls, LocalPool, Workers
from ...common.errors import InputError
from ...common.processors import usable_cores
from ...common.stop import Stop

W = TypeVar("W")
R = TypeVar("R")

MOST_SAMPLES = 1_000_000

SHARE = 4
"""Least number of groups for each process, so that all end at about the same time."""


def check_worlds(samples: int, seed: int, jobs: int, cluster: str | None) -> None:
    """Refuse numbers of worlds and of processes that make no sense.

    Raises
    ------
    InputError
        One of them is out of range, or jobs are given for a cluster.
    """
    if not 1 <= samples <= MOST_SAMPLES:
        raise InputError(f"samples = {samples}: give 1 to {MOST_SAMPLES}")
    if seed < 0:
        raise InputError(f"seed = {seed}: must not be negative")
    if jobs < 0:
        raise InputError(f"jobs = {jobs}: must be 0, for all cores, or more")
    if jobs != 1 and cluster is not None:
        raise InputError("jobs and a cluster exclude each other; leave one of them out")


def is_over(stop: Stop | None) -> bool:
    """Whether to begin nothing more."""
    return stop is not None and stop.remaining_s() <= 0.0


def elsewhere(
    call: Callable[[W, tuple[int, ...]], list[R]],
    work: W,
    seeds: Sequence[int],
    most: int,
    where: tuple[int, str | None],
    stop: Stop | None,
) -> Iterator[list[R]]:
    """Results of a call on groups of seeds, as they come.

    Parameters
    ----------
    call : callable
        Takes the work and some seeds.
    work : object
        What the call needs.
    seeds : sequence of int
    most : int
        Largest size of a group.
    where : (int, str or None)
        Number of processes, 0 for one per core; address of a scheduler in place of them.
    stop : Stop, optional
    """
    if not seeds:
        return
    jobs, cluster = where
    calls: Calls
    if cluster is not None:
        calls = Workers(cluster)
    else:
        jobs = jobs or usable_cores()
        # A fork of a process with threads may wait for a lock that is never released.
        processes = ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn"))
        calls = LocalPool(processes, jobs)
    size = max(1, min(most, len(seeds) // (SHARE * calls.count)))
    groups = [tuple(seeds[at : at + size]) for at in range(0, len(seeds), size)][::-1]
    running: set[Future[list[R]]] = set()
    try:
        while True:
            while groups and len(running) < calls.count and not is_over(stop):
                running.add(calls.submit(call, work, groups.pop()))
            if not running:
                return
            done, running = wait(running, return_when=FIRST_COMPLETED)
            for each in done:
                yield calls.result(each)
    finally:
        calls.close()
