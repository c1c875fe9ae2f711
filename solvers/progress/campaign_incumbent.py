"""The best plan of a campaign so far, and its certificate: most prize, then least cost."""

from __future__ import annotations

import math
from collections.abc import Iterable

from adr_opt.common.progress import Progress
from adr_opt.mission.campaign import Campaign, Routes
from adr_opt.mission.schedule import Schedule

from .gap import CertificateOf


class CampaignIncumbent:
    """The best plan that was offered.

    Parameters
    ----------
    campaign : Campaign

    Attributes
    ----------
    sequence : tuple of tuple of int or None
        Bodies in order for each chaser; None before the first plan.
    objective : float
        What they are worth, −inf before the first plan.
    cost : float
        At the best schedules, +inf before the first plan.
    """

    def __init__(self, campaign: Campaign) -> None:
        self._campaign = campaign
        self.sequence: Routes | None = None
        self.objective = -math.inf
        self.cost = math.inf

    def offer(self, routes: Iterable[Iterable[int]]) -> bool:
        """Routes that may be the best plan; whether they are. No target may be on two of them."""
        campaign = self._campaign
        moves = tuple(tuple(int(j) for j in route) for route in routes)
        first = campaign.instance.first_target
        targets = [j for route in moves for j in route if j >= first]
        worth = campaign.collected(targets)
        if len(set(targets)) < len(targets):
            return False
        if worth < self.objective or moves == self.sequence:
            return False
        closed = campaign.closed(moves)
        costs, uses = [], []
        for mission, route in zip(campaign.missions, closed, strict=True):
            schedule: Schedule = mission.time(route)
            if schedule.made < len(route) or not mission.may_stop(route):
                return False
            costs.append(schedule.cost)
            uses.append(campaign.use(mission, route, schedule.delta_vs))
        if not campaign.limits.allow(uses):
            return False
        cost = campaign.instance.objective.together(costs)
        if worth == self.objective and cost >= self.cost:
            return False
        self.sequence, self.objective, self.cost = closed, worth, cost
        return True


class CampaignCertificate(CertificateOf[Routes]):
    """Incumbent and bound of a campaign, and who is told of them."""

    def __init__(self, campaign: Campaign, progress: Progress) -> None:
        super().__init__(campaign, progress, CampaignIncumbent(campaign))
