"""A study of designs: all points of some axes, run on one core or several, and resumable.

Designs say something of each other: plans that others can fly as well, bounds that hold for less.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

from ...common.stop import MaxRuntime, Stop
from ...mission.certified import certify_routes
from ...mission.problem import problem_of
from ...problem.instance import Instance
from ...run.front import DEFAULT_METHOD, DEFAULT_TIME_LIMIT_S
from ...run.method_call import refuse_unable, spec_of
from ...sources.worth import SetWorths
from ...study import Run, Study, check_jobs
from ..priced import price
from ..trade.axes import Axis
from .designs import Design, designs_of
from .prices import CampaignPrices
from .rating import rating_of
from .results import DesignPoint, DesignStudy
from .run import run_design
from .work import DesignWork, to_json

TRIES = 3
"""Maximum number of other designs' plans tried for one design, the best first."""

INCLUDING = ("launches", "kits", "budget")
"""Kinds of which a larger value allows all plans of a smaller one."""

SURELY = 1e-9
"""Relative difference above which worths count as different."""


def with_neighbours(work: DesignWork, points: Sequence[DesignPoint]) -> list[DesignPoint]:
    """Points with bounds and plans of other designs, where those are better and hold for them.

    A bound holds for each design with fewer launches, fewer kits or a smaller budget that is the
    same otherwise. The plans of designs that differ in one value are timed anew on the instance of
    a design; where they can be flown within its budget the best of them counts.
    """
    tight = [
        replace(
            point,
            bound=max(point.worth, min(other.bound for other in points if includes(other, point))),
        )
        for point in points
    ]
    return [_with_best_plan(work, point, tight) for point in tight]


def includes(larger: DesignPoint, smaller: DesignPoint) -> bool:
    """Whether every plan of one design is a plan of another, judged by the varied limits."""
    values, others = dict(larger.design.values), dict(smaller.design.values)
    return all(
        value == others[kind] or (kind in INCLUDING and value > others[kind])
        for kind, value in values.items()
    )


def _with_best_plan(
    work: DesignWork, point: DesignPoint, points: Sequence[DesignPoint]
) -> DesignPoint:
    rules = point.instance.transfer.max_leg_s, point.instance.mission.mission_separation_s
    if any(rule is not None for rule in rules) or not math.isfinite(point.worth):
        return point  # orders without their times say little there
    better = [
        other
        for other in points
        if other.plan is not None
        and _is_near(other.design, point.design)
        and point.worth * (1.0 + SURELY) < other.worth <= point.bound * (1.0 + SURELY)
    ]
    better.sort(key=lambda other: (-other.worth, other.euros))
    for other in better[:TRIES]:
        assert other.plan is not None
        flown = {name: order for name, order in other.plan.orders.items() if order}
        made = _flown(work, point, flown)
        if made is not None and made.worth > point.worth:
            return made
    return point


def _is_near(one: Design, other: Design) -> bool:
    pairs = zip(one.values, other.values, strict=True)
    return sum(first != second for first, second in pairs) == 1


def _flown(
    work: DesignWork, point: DesignPoint, orders: Mapping[str, tuple[str, ...]]
) -> DesignPoint | None:
    """A point with the orders of another design; None if it cannot fly or afford them."""
    instance = point.instance
    if not orders.keys() <= {chaser.name for chaser in instance.chasers}:
        return None
    if not price(instance, orders, mend=False).holds:
        return None
    problem = problem_of(instance)
    problem.do_without()
    routes = [orders.get(chaser.name, ()) for chaser in instance.chasers]
    made = certify_routes(problem, work.method, routes, seed=work.seed, runtime_s=0.0)
    if made.plan is None or work.prices.of_plan(instance, made.plan) > point.design.budget:
        return None
    return work.point(point.design, instance, made.plan, point.bound, point.runtime_s, point.cpu_s)


FROM_THE_INSTANCE = CampaignPrices()
"""No prices but the expense of chasers."""

Told = Callable[[DesignPoint, int, int], None]
"""Called with a finished point, the number of finished points, and the total."""


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
