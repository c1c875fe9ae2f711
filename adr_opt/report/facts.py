"""The headline figures of a plan, as the plan states them."""

from __future__ import annotations

from dataclasses import dataclass

from ..instance import Instance
from ..plan import Plan


@dataclass(frozen=True)
class Facts:
    """What a plan comes to.

    Attributes
    ----------
    visits, targets : int
        Targets that are visited, and all of them.
    prize, total_prize : float
        Collected, and of all targets.
    upper_bound, gap : float or None
        As the plan states them.
    delta_v_m_s : float
        Of all legs [m/s].
    budgets_m_s : float
        The full budget, once at the start and once for every refuelling that a leg follows [m/s].
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
    delta_v_m_s: float
    budgets_m_s: float
    refuellings: int
    stations: int
    used_s: float
    duration_s: float

    @property
    def counts_visits(self) -> bool:
        """Whether every prize is 1, so that the objective is the number of visits."""
        return self.total_prize == self.targets and self.prize == self.visits


def facts(instance: Instance, plan: Plan) -> Facts:
    """Read the headline figures off a plan."""
    refuellings = sum(name in instance.station_names for name in plan.destinations)
    followed = sum(name in instance.station_names for name in plan.destinations[:-1])
    names = {target.name for target in instance.targets}
    return Facts(
        visits=len(names & set(plan.destinations)),
        targets=len(instance.targets),
        prize=plan.objective,
        total_prize=float(sum(target.prize for target in instance.targets)),
        upper_bound=plan.upper_bound,
        gap=plan.gap,
        delta_v_m_s=plan.delta_v_m_s,
        budgets_m_s=instance.chaser.tank.delta_v_m_s * (1 + followed),
        refuellings=refuellings,
        stations=len(instance.stations),
        used_s=plan.legs[-1].end_s if plan.legs else 0.0,
        duration_s=instance.mission.duration_s,
    )
