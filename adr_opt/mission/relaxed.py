"""An order under larger limits: what a chaser would need to fly an order that it cannot fly."""

from __future__ import annotations

import math

from ..common.constants import SLACK_M_S
from ..common.records import LARGEST_DELTA_V_M_S, LARGEST_DURATION_S, LARGEST_MASS_KG
from ..kernels.rules.rules import Rules
from ..legs.connection_finder import ConnectionFinder
from ..legs.service_limits import limits_of
from ..plan.cargo import loads_of, most_left_m_s
from ..problem.chasers import Chaser, Tank, TankByMass
from ..problem.instance import Instance
from .mission import Mission
from .schedule import Front, Scheduler

LARGEST, LONGEST = 4.0, 2.0
"""Largest multiples of the tank and of the mission that are examined."""

PRECISION_M_S = 0.1
"""Precision of the least tank."""

PAIRS_KEPT = 500
"""Number of pairs whose connections are cached for each chaser: the legs of an order."""

Moves = tuple[int, ...]


def with_tank(chaser: Chaser, scale: float) -> Chaser:
    """A chaser with a scaled tank: ΔV or propellant.

    The ΔV that is lacking at the start stays lacking, as first legs pay for it: more in a full tank
    is more at the start, too.
    """
    tank = chaser.usable
    if isinstance(tank, TankByMass):
        propellant_kg = min(scale * tank.propellant_kg, LARGEST_MASS_KG)
        larger = tank.replace(propellant_kg=propellant_kg, initial_propellant_kg=None)
        if chaser.spent_m_s > 0.0:
            left_m_s = larger.delta_v_m_s - chaser.spent_m_s
            left_kg = tank.dry_mass_kg * math.expm1(left_m_s / tank.exhaust_m_s)
            larger = larger.replace(initial_propellant_kg=max(left_kg, 0.0))
        return chaser.replace(tank=larger, end_of_life_m_s=None)
    full = min(scale * tank.delta_v_m_s, LARGEST_DELTA_V_M_S)
    initial = full - chaser.spent_m_s if chaser.spent_m_s else None
    tank = Tank(delta_v_m_s=full, initial_delta_v_m_s=initial)
    return chaser.replace(tank=tank, end_of_life_m_s=None)


class Relaxed:
    """An order under larger limits, with the connections that those allow.

    Parameters
    ----------
    mission : Mission
    chaser : Chaser
        With a tank that may be larger.
    duration_s : float or None
        Of the mission and of the availability of the chaser; None for what they are.
    windows : bool
        Whether targets keep their windows.
    passing : bool
        Whether each order is asked for once, see :attr:`.Scheduler.passing`.
    """

    def __init__(
        self,
        mission: Mission,
        chaser: Chaser,
        duration_s: float | None,
        *,
        windows: bool = True,
        passing: bool = False,
    ) -> None:
        self._mission = mission
        instance, number = mission.instance, mission.instance.chasers.index(mission.chaser)
        if duration_s is not None:
            duration_s = min(duration_s, LARGEST_DURATION_S)
            chaser = chaser.replace(available_s=(chaser.available_s[0], None))
            instance = instance.replace(mission=instance.mission.replace(duration_s=duration_s))
        if not windows:
            instance = instance.without_closings()
        chasers = (*instance.chasers[:number], chaser, *instance.chasers[number + 1 :])
        self._instance: Instance = instance.replace(chasers=chasers)
        self._rules = mission.rules
        if duration_s is not None or not windows:
            limits = limits_of(self._instance, number)
            self._rules = self._rules._replace(windows=limits.windows, duration=limits.duration)
        made = mission.over_all
        if duration_s is not None or mission.connecting.depends_on_tank:
            connecting = ConnectionFinder(self._instance, mission.connecting.corrections, number)
            cost, price = self._instance.objective.cost, mission.instance.time_m_s_per_s
            made = Scheduler(
                connecting, lambda: self._rules, cost, mission.chaser, price, PAIRS_KEPT
            )
        self._schedules = made.unpriced.passing if passing else made.unpriced
        self._by_limits: dict[tuple[float, bool], Scheduler] = {}

    def _under(self, scale: float, counts: bool) -> Rules:
        """The rules with a scaled tank, and without limits on kits and targets."""
        mission = self._mission
        chaser = with_tank(mission.chaser, scale)
        if not counts:
            chaser = chaser.replace(kits=None, max_targets=None)
        loads = loads_of(mission.instance, chaser, mission.margin)
        budget = (1.0 - mission.margin) * chaser.usable.delta_v_m_s + SLACK_M_S
        if loads is not None:
            budget = most_left_m_s(loads)
        return self._rules._replace(budget=budget, loads=loads)

    def front(self, moves: Moves, scale: float, *, counts: bool = True) -> Front | None:
        """Labels at the end of an order of allowed moves; None if it needs still more.

        ``counts`` tells whether the chaser has as many kits as it has, and services as many targets
        as it may.
        """
        key = scale, counts
        if key not in self._by_limits:
            self._by_limits[key] = self._schedules.under(self._under(scale, counts))
        fronts = self._by_limits[key].fronts(moves)
        return fronts[-1] if len(fronts) > len(moves) else None

    def least_end(self, moves: Moves, scale: float) -> float | None:
        """Earliest end of an order [s]."""
        front = self.front(moves, scale)
        return None if front is None else float(front.ready.min())

    def added_m_s(self, scale: float) -> float:
        """Additional ΔV of a scaled tank [m/s]."""
        chaser = self._mission.chaser
        return with_tank(chaser, scale).usable.delta_v_m_s - chaser.usable.delta_v_m_s

    def least_scale(self, moves: Moves) -> float | None:
        """Least scale of the tank."""
        if self.front(moves, LARGEST) is None:
            return None
        low, high = 1.0, LARGEST
        full = self._mission.chaser.usable.delta_v_m_s
        steps = math.ceil(math.log2(max(LARGEST * full / PRECISION_M_S, 2.0)))
        for _ in range(steps):
            middle = 0.5 * (low + high)
            if self.front(moves, middle) is None:
                low = middle
            else:
                high = middle
        return high
