"""A study of designs: all points of some axes, run on one core or several, or gone on with."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from functools import partial

from ...common.stop import MaxRuntime, Stop
from ...mission.problem import problem_of
from ...problem.instance import Instance
from ...run.front import DEFAULT_METHOD, DEFAULT_TIME_LIMIT_S
from ...run.method_call import refuse_unable, spec_of
from ...sources.worth import SetWorths
from ...study import Run, Study, check_jobs
from ..trade.axes import Axis
from .designs import Design, designs_of
from .neighbours import with_neighbours
from .point import DesignPoint
from .prices import CampaignPrices
from .rating import rating_of
from .results import DesignStudy
from .run import run_design
from .work import DesignWork, to_json

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
        :func:`adr_opt.study.cluster.client_of` takes it.
    path : path, optional
        File of the results, see :mod:`adr_opt.study.file`: designs in it are not run again.
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
    check_jobs(jobs, cluster)
    designs = designs_of(axes)
    rated, rating = rating_of(instance, worths)
    work = DesignWork(rated, rating, prices, method, time_limit, seed)
    for number, design in enumerate(designs):
        made = work.instance_of(design)  # what is not valid is refused before any work
        if number == 0:
            refuse_unable(problem_of(made), spec_of(method))
    study: Study[Design, DesignPoint] = Study(
        "designs",
        1,
        partial(run_design, work),
        work.of,
        key=lambda design: dict(design.values),
        to_json=to_json,
        from_json=work.from_json,
    )
    points = dict[Design, DesignPoint]()
    with Run(study, path, jobs=jobs, cluster=cluster, stop=stop) as running:
        for design in designs:
            known = running.known(design)
            if known is not None:
                points[design] = known
        for design, point in running.rows((each,) for each in designs if each not in points):
            points[design] = point
            told(point, len(points), len(designs))
    finished = with_neighbours(work, [points[each] for each in designs if each in points])
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
