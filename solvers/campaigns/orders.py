"""Routes of one chaser over the targets that the others leave."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
import numpy.typing as npt

from adr_opt.campaign import Campaign, Problem, Routes
from adr_opt.mission import Mission

FloatArray = npt.NDArray[np.float64]

RouteOf = Callable[[Mission], Iterable[int]]


def left(campaign: Problem, done: Iterable[int]) -> FloatArray:
    """What targets are worth that are not done, and −inf for the others, shape (bodies,)."""
    worths = np.array(campaign.worths)
    for j in done:
        worths[j] = -np.inf
    worths[: campaign.instance.first_target] = 0.0
    return worths


def targets_of(campaign: Problem, routes: Iterable[Iterable[int]]) -> set[int]:
    """The targets on routes."""
    first = campaign.instance.first_target
    return {j for route in routes for j in route if j >= first}


def one_after_another(campaign: Campaign, route_of: RouteOf) -> Routes:
    """Routes made chaser after chaser, each over what those before have left.

    Parameters
    ----------
    campaign : Campaign
    route_of : callable
        From the mission of a chaser that offers what is left to its route.
    """
    routes: list[tuple[int, ...]] = []
    for mission in campaign.missions:
        offered = mission.offering(left(campaign, targets_of(campaign, routes)))
        routes.append(tuple(int(j) for j in route_of(offered)))
    return tuple(routes)
