"""A study of designs: all points of some axes, run on one core or several, or gone on with."""

from __future__ import annotations

import multiprocessing
import os
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait

from ...common.cluster import Calls, LocalPool, Workers
from ...common.errors import InputError
from ...common.processors import usable_cores
from ...common.stop import MaxRuntime, Stop
from ...mission.problem import problem_of
from ...problem.instance import Instance
from ...run.front import DEFAULT_METHOD, DEFAULT_TIME_LIMIT_S
from ...run.method_call import refuse_unable, spec_of
from ...sources.worth import SetWorths
from ..trade.axes import Axis
from .designs import Design, designs_of
from .file import DesignsFile
from .handing import handed_on
from .point import DesignPoint
from .prices import CampaignPrices
from .rating import rating_of
from .results import DesignStudy
from .run import run_design
from .work import DesignWork

FROM_THE_INSTANCE = CampaignPrices()
"""No prices but the expense of chasers."""

Told = Callable[[DesignPoint, int, int], None]
"""Called with a finished point, the number of finished ones, and that of all."""


def design_study(  # noqa: PLR0913
    instance: Instance,
    axes: Sequence[Axis],
    *,
    worths: SetWorths | None = None,
    prices: CampaignPrices = FROM_THE_INSTANCE,
    method: str = DEFAULT_METHOD,
    time_limit: float = DEFAULT_TIME_LIMIT_S,
    seed: int = 0,
    jobs: int = 1,
    cluster: str | None = None,
    path: str | os.PathLike[str] | None = None,
    stop: Stop | None = None,
    told: Told = lambda point, done, of: None,
) -> DesignStudy:
    """Plan, bound and evaluate the designs of a campaign.

    Parameters
    ----------
    instance : Instance
        What is not varied stays as it is there.
    axes : sequence of Axis
    worths : SetWorths, optional
        Of objects under the names of targets. Each design is planned with the floors of its
        targets, bounded with their worths alone, and its chosen set evaluated (docs/worth.md,
        equations 8 to 10). Without them prizes of the instance count, which add up.
    prices : CampaignPrices
        By default the expense of the instance's chasers counts.
    method : str
        Name of a planner; bounds come from those that prove, as "auto" and "exact".
    time_limit : float
        Wall time of the plan, and again of the bound, of each design [s].
    seed : int
    jobs : int
        Processes, each with one design at a time; 0 for one per core. With one all happens in
        this process.
    cluster : str, optional
        Address of a Dask scheduler whose workers run the designs instead, as
        :func:`adr_opt.common.cluster.client_of` takes it.
    path : path, optional
        File of the results, see :mod:`.file`: designs in it are not run again.
    stop : Stop, optional
        Ends all of it early; what is not finished is left out.
    told : callable

    Raises
    ------
    InputError
        The axes, prices, worths, the method, or the file do not fit.
    """
    began = time.perf_counter()
    MaxRuntime(time_limit)
    if jobs < 0:
        raise InputError(f"jobs = {jobs}: must be 0, for all cores, or more")
    if jobs != 1 and cluster is not None:
        raise InputError("jobs and a cluster exclude each other; leave one of them out")
    designs = designs_of(axes)
    rated, rating = rating_of(instance, worths)
    work = DesignWork(rated, rating, prices, method, time_limit, seed)
    for number, design in enumerate(designs):
        made = work.instance_of(design)  # what is not valid is refused before any work
        if number == 0:
            refuse_unable(problem_of(made), spec_of(method))
    file = None if path is None else DesignsFile(path, work)
    points = {} if file is None else file.points(designs)
    left = [design for design in designs if design not in points]
    for point in _run(work, left, jobs or usable_cores(), cluster, stop):
        points[point.design] = point
        if file is not None:
            file.append(point)
        told(point, len(points), len(designs))
    finished = handed_on(work, [points[each] for each in designs if each in points])
    return DesignStudy(
        instance,
        tuple(axes),
        tuple(finished),
        len(designs),
        rating,
        prices,
        None if worths is None else worths.total,
        time.perf_counter() - began,
    )


def _run(
    work: DesignWork, designs: Sequence[Design], jobs: int, cluster: str | None, stop: Stop | None
) -> Iterator[DesignPoint]:
    """Points of designs as they are finished."""
    if not designs:
        return
    if cluster is None and jobs == 1:
        for design in designs:
            if _is_over(stop):
                return
            point = run_design(work, design, alone=True, stop=stop)
            if not _is_over(stop):  # or it had less time than the others
                yield point
        return
    calls: Calls
    if cluster is not None:
        calls = Workers(cluster)
    else:
        # A fork of a process with threads may wait for a lock that is never released.
        processes = ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn"))
        calls = LocalPool(processes, jobs)
    try:
        yield from _beside(calls, work, designs, stop)
    finally:
        calls.close()


def _beside(
    calls: Calls, work: DesignWork, designs: Sequence[Design], stop: Stop | None
) -> Iterator[DesignPoint]:
    waiting, running = list(designs), set[Future[DesignPoint]]()
    while True:
        while waiting and len(running) < calls.count and not _is_over(stop):
            running.add(calls.submit(run_design, work, waiting.pop(0)))
        if not running:
            return
        done, running = wait(running, return_when=FIRST_COMPLETED)
        for each in done:
            yield calls.result(each)


def _is_over(stop: Stop | None) -> bool:
    return stop is not None and stop.remaining_s() <= 0.0
