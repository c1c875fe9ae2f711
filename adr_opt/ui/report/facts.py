"""Headline figures of a plan, as stated in the plan."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ...common.errors import InputError
from ...common.wording import counted
from ...fly.flight.mean_flight import fly_mean
from ...judge.admit import Admitted
from ...plan.plan import Plan
from ...plan.refined_plan import RefinedPlan
from ...plan.routes import Flown, routes_of
from ...problem.instance import Instance
from .text import escape


@dataclass(frozen=True)
class Facts:
    """Headline figures.

    Attributes
    ----------
    visits, targets : int
        Targets that are visited, and all of them.
    prize, total_prize : float
        Collected, and of all targets.
    upper_bound, gap : float or None
        As the plan states them.
    cost, cost_bound, cost_gap : float or None
        As the plan states them.
    delta_v_m_s : float
        Of all legs [m/s].
    budgets_m_s : float
        The full budget of each chaser that flies, once at the start and once for every refuelling
        that a leg follows [m/s].
    chasers, flying : int
        All of them, and those that have a leg.
    refuellings, stations : int
    used_s, duration_s : float
        End of the last service, and of the mission [s].
    """

    visits: int
    targets: int
    prize: float
    total_prize: float
    upper_bound: float | None
    gap: float | None
    cost: float
    cost_bound: float | None
    cost_gap: float | None
    delta_v_m_s: float
    budgets_m_s: float
    chasers: int
    flying: int
    refuellings: int
    stations: int
    used_s: float
    duration_s: float

    @property
    def counts_visits(self) -> bool:
        """Whether every prize is 1, so that the objective counts visits."""
        return self.total_prize == self.targets and self.prize == self.visits


def facts(instance: Instance, plan: Plan) -> Facts:
    """Read the headline figures off a plan."""
    refuellings = sum(name in instance.station_names for name in plan.destinations)
    routes = routes_of(instance, plan)
    flying = [flown for flown in routes if flown.legs]
    names = {target.name for target in instance.targets}
    return Facts(
        visits=len(names & set(plan.destinations)),
        targets=len(instance.targets),
        prize=plan.objective,
        total_prize=float(sum(target.greatest_prize for target in instance.targets)),
        upper_bound=plan.upper_bound,
        gap=plan.gap,
        cost=plan.cost,
        cost_bound=plan.cost_bound,
        cost_gap=plan.cost_gap,
        delta_v_m_s=plan.delta_v_m_s,
        budgets_m_s=sum(_budgets_m_s(instance, flown) for flown in flying or routes),
        chasers=len(routes),
        flying=len(flying),
        refuellings=refuellings,
        stations=len(instance.stations),
        used_s=max(flown.end_s for flown in routes),
        duration_s=instance.mission.duration_s,
    )


def _budgets_m_s(instance: Instance, flown: Flown) -> float:
    """Tanks available to a chaser until its last leg [m/s]."""
    followed = sum(leg.destination in instance.station_names for _, leg in flown.legs[:-1])
    return math.fsum(flown.tank_worths(instance)[: 1 + followed])


def flown_paragraph(admitted: Admitted[Plan], refined: RefinedPlan | None) -> str:
    """Knowledge of the plan beyond the model, from a flight in mean motion.

    Parameters
    ----------
    admitted : Admitted
        The plan, with its instance.
    refined : RefinedPlan or None
        The plan as refined, if the page has it.
    """
    said, holds = _said(admitted, refined)
    kind = "" if holds else " bad"
    return f'<p class="verdict{kind}" id="standing">{escape(said)}.</p>'


def _said(admitted: Admitted[Plan], refined: RefinedPlan | None) -> tuple[str, bool]:
    if refined is not None:
        legs = counted(len(refined.legs), "leg")
        return f"Refined in the field {refined.gravity}: {legs}, as told below", True
    known = admitted.plan.own_flight
    if known is not None and known.how == "refined":
        return f"The plan states, but this page has not judged, that {known}", known.holds
    try:
        flight = fly_mean(admitted.instance, admitted)
    except InputError as error:
        return f"Neither flown nor refined: {error}", True
    assert flight is not None  # it is never interrupted
    told = str(flight)
    return f"{told[:1].upper()}{told[1:]}; not refined", flight.holds
