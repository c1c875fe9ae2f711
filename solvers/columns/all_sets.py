"""Enumeration of all sets of targets that chasers can service, feasible for a few targets.

Searches prefer routes that are worth something, and pass by stations that have little. Where
chasers have to fly to an end for nothing that is worth anything, or may refuel so often only, they
may find no plan, or not the best, and proofs may leave a gap. Then the best one is put together
from the cheapest routes of all sets, and where there can be none there is none.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations

import numpy as np
from scipy.optimize import LinearConstraint

from adr_opt.common.stop import Stop
from adr_opt.mission.problem import Problem

from ..progress.gap import GapTracker
from ..routes.digits import has_large
from ..routes.route_pool import Column, RoutePool, dealt
from ..routes.set_packing import cheapest_of, packing
from .cheapest_routes import cheapest_routes
from .route_enumeration import PACKING_OFF, SCALE, worth_a_goal

MOST_TARGETS = 6
"""Maximum number of targets: sets double with each, and orders of them grow faster."""


def lacks_plan(problem: Problem, certificate: GapTracker) -> bool:
    """Whether no known plan services all required targets and ends where it must."""
    return certificate.routes is None or problem.shown(certificate.incumbent) < 0.0


def settle(problem: Problem, certificate: GapTracker, pool: RoutePool, stop: Stop) -> bool:
    """Combine the cheapest routes of all sets of targets into an optimal plan, if sets are few.

    Parameters
    ----------
    problem : Problem
    certificate : GapTracker
        Told of the plan, and of what no plan is worth more than.
    pool : RoutePool
        Of routes; all that are found are added to it.
    stop : Stop
        Its time alone counts here.

    Returns
    -------
    bool
        Whether it is proven that no plan services all required targets and ends where it must.
    """
    if len(problem.instance.targets) > MOST_TARGETS or not _list_all(problem, pool, stop):
        return False
    columns, required = pool.columns(), sorted(problem.required)
    # Which of the routes that refuel as often takes least propellant is not asked.
    proves = problem.is_whole and not _weighs(problem)
    if not columns:
        none = proves and (bool(required) or _must_fly(problem))
        return _none(problem, certificate) if none else False
    worths = np.array([column.worth for column in columns])
    scale = SCALE / (float(worths.max()) or 1.0)
    covered = np.array([[j in column.targets for column in columns] for j in required], dtype=float)
    constraints = [
        packing(
            problem,
            [(column.kind, column.targets) for column in columns],
            [column.use for column in columns],
            all_flown=True,
        )
    ]
    if required:
        constraints.append(LinearConstraint(covered, 1.0, np.inf))
    found = cheapest_of(-scale * worths, constraints, stop.remaining_s(), gap=0.0)
    if found.taken is not None:
        taken = [columns[at] for at in found.taken]
        certificate.offer(*dealt(problem, [(each.kind, each.route) for each in taken]))
        if proves and found.solved:
            most = (PACKING_OFF - found.least) / scale
            certificate.lower(most if worths.any() else 0.0)
            if has_large(problem):
                _compare_exactly(problem, certificate, columns, constraints, stop)
    none = found.taken is None and found.solved and proves and lacks_plan(problem, certificate)
    return _none(problem, certificate) if none else False


def _compare_exactly(
    problem: Problem,
    certificate: GapTracker,
    columns: Sequence[Column],
    constraints: Sequence[LinearConstraint],
    stop: Stop,
) -> None:
    """Search for better plans until none exists, where prizes are too large for exact sums."""
    worths = [column.worth for column in columns]
    while not certificate.proven and stop.remaining_s() > 0.0:
        goal = certificate.next_goal
        found = worth_a_goal(problem, worths, goal, constraints, stop.remaining_s())
        if found.taken is None:
            if found.solved:
                certificate.lower(certificate.below(goal))
            return
        taken = [columns[at] for at in found.taken]
        if not certificate.offer(*dealt(problem, [(each.kind, each.route) for each in taken])):
            return


def _none(problem: Problem, certificate: GapTracker) -> bool:
    """Report that there is no plan: a missing required target costs its bonus."""
    certificate.lower(problem.all_worth - problem.bonus if problem.required else -math.inf)
    return True


def _must_fly(problem: Problem) -> bool:
    """Whether some chaser does not start where it must end."""
    return not all(mission.may_stop(()) for mission in problem.missions)


def _weighs(problem: Problem) -> bool:
    """Whether a station has limited propellant."""
    return any(station.max_propellant_kg is not None for station in problem.instance.stations)


def _list_all(problem: Problem, pool: RoutePool, stop: Stop) -> bool:
    """Add the cheapest route of each type and set to a pool; False if time runs out."""
    first = problem.instance.first_target
    targets = range(first, first + len(problem.instance.targets))
    counted = frozenset(problem.limits.stations)
    by_weight = _weighs(problem)
    for number, kind in enumerate(problem.kinds):
        for size in range(1, len(targets) + 1):
            for chosen in combinations(targets, size):
                over = stop.remaining_s() <= 0.0
                routes = (
                    None
                    if over
                    else cheapest_routes(
                        kind.mission,
                        frozenset(chosen),
                        lambda: stop.remaining_s() <= 0.0,
                        counted,
                        every=by_weight,
                    )
                )
                if routes is None:
                    return False
                for route in routes:
                    pool.add(number, route.route)
    return True
