"""A campaign as it goes: planned, flown with failures, and replanned after each."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...kernels.orbits.keyed_draws import keyed_draws
from ...plan.plan import Leg, Plan
from ...problem.instance import Instance
from ...run.front import solve
from ..replan.chaser_states import states_at
from ..replan.replanning import replan
from .events import CAMPAIGNS, CAPTURES
from .offer import Offer
from .records import Attempt, FlownCampaign
from .settings import ScenarioSettings

LEAST_S = 1e-3


def fails(seed: int, year: int, chance: float) -> bool:
    """Whether the campaign of a year is lost at its launch."""
    return chance > 0.0 and float(keyed_draws(seed, year, CAMPAIGNS, np.zeros(1, int))[0]) < chance


Keep = Callable[[Instance, Plan], None]
"""Called with the instance of a campaign and its first plan."""


def campaign(
    offered: Offer,
    settings: ScenarioSettings,
    seed: int,
    year: int,
    keep: Keep = lambda instance, plan: None,
) -> FlownCampaign | None:
    """Plan and fly a campaign; None if nothing is offered to it.

    A capture that fails is found at the end of its service; the chaser goes on from there, and all
    that has not begun is planned anew, without that object.

    Parameters
    ----------
    offered : Offer
    settings : ScenarioSettings
    seed, year : int
    keep : callable
    """
    instance = offered.instance
    if instance is None:
        return None
    if fails(seed, year, settings.campaign_failure):
        return FlownCampaign(True, len(instance.targets), 0, 0, 0.0, ())
    numbers = np.array(list(offered.numbers.values()))
    drawn = keyed_draws(seed, year, CAPTURES, numbers)
    failing = {
        name
        for name, chance in zip(offered.numbers, drawn, strict=True)
        if chance < settings.capture_failure
    }
    prizes = {target.name: target.prize * offered.unit for target in instance.targets}

    def attempt(leg: Leg) -> Attempt:
        name, failed = leg.destination, leg.destination in failing
        time_s = leg.end_s if failed else leg.done_s
        return Attempt(time_s, offered.numbers[name], name, prizes[name], not failed)

    plan = solve(instance, settings.method, time_limit=settings.time_limit_s, seed=seed).plan
    if plan is None:
        return FlownCampaign(False, len(instance.targets), 0, 0, 0.0, ())
    keep(instance, plan)
    planned, delta_v_m_s = len(_services(plan, offered)), sum(leg.spent_m_s for leg in plan.legs)
    attempts: list[Attempt] = []
    replanned = 0
    left: Instance = instance
    while plan is not None:
        services = _services(plan, offered)
        # A leg has begun only after its departure, also where a service takes no time.
        wrong = [
            max(leg.end_s, leg.leaves_s + LEAST_S) for leg in services if leg.destination in failing
        ]
        if not wrong:
            attempts += map(attempt, services)
            break
        at_s = min(min(wrong), left.mission.duration_s)
        begun = [leg for state in states_at(left, plan, at_s) for leg in state.legs]
        missed = [leg.destination for leg in begun if leg.destination in failing]
        made = replan(
            left,
            plan,
            at_s,
            missed=missed,
            method=settings.method,
            time_limit=settings.time_limit_s,
            seed=seed,
        )
        for state in made.states:
            done = state.legs[:-1] if state.is_put else state.legs
            attempts += [attempt(leg) for leg in done if leg.destination in offered.numbers]
        left, plan, replanned = made.instance, made.plan, replanned + 1
    attempts = sorted(attempts)
    return FlownCampaign(
        False, len(instance.targets), planned, replanned, delta_v_m_s, tuple(attempts)
    )


def _services(plan: Plan, offered: Offer) -> list[Leg]:
    return [leg for leg in plan.legs if leg.destination in offered.numbers]
