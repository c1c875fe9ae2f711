"""Connections and limits of an instance, as used by rehearsals."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import HOUR_S, SLACK_M_S, SLACK_S
from ...kernels.legs.connections import best_from
from ...kernels.rules.loads import Loads
from ...kernels.tables.timetable_making import ServiceLimits
from ...legs.connection_finder import ConnectionFinder
from ...legs.service_limits import limits_of, removal_times
from ...plan.cargo import loads_of, most_left_m_s
from ...plan.leg_kinds import leg_kinds
from ...plan.plan import Leg
from ...problem.instance import Instance
from ...problem.rules import CAMPAIGNS, FIRST, MODELLED, RELEASES, SUPPLIES, Follower, most_targets
from ...problem.support import refuse
from ...problem.uncertainty import LognormalFactor, Uncertainty

FloatArray = npt.NDArray[np.float64]

MATCH_S = 1e-3
"""Tolerance of arrivals when a plan's leg is matched with connections [s]."""


class Hop(NamedTuple):
    """A connection that a chaser may fly next, at its planned cost.

    Attributes
    ----------
    destination : int
    departure, arrival : float
        [s].
    delta_v : float
        As planned [m/s].
    family, revolutions : int
    """

    destination: int
    departure: float
    arrival: float
    delta_v: float
    family: int
    revolutions: int


class Rows(NamedTuple):
    """The connections of a pair, and the best of each and all later ones.

    Attributes
    ----------
    departure, arrival, delta_v : (connections,) float64
        [s], [s], [m/s].
    family, revolutions : (connections,) int8
    best : (connections,) int64
        By the value of time of the instance.
    """

    departure: FloatArray
    arrival: FloatArray
    delta_v: FloatArray
    family: npt.NDArray[np.int8]
    revolutions: npt.NDArray[np.int8]
    best: npt.NDArray[np.int64]


class ChaserLimits(NamedTuple):
    """Limits of a chaser.

    Attributes
    ----------
    name : str
    start : int
        Body at which it begins.
    limits : ServiceLimits
    loads : Loads or None
    budget : float
        ΔV of a full tank without cargo, with the slack [m/s].
    spent : float
        ΔV that its tank lacks at the start, other than by mass [m/s].
    most_targets : int or None
    is_launched : bool
    """

    name: str
    start: int
    limits: ServiceLimits
    loads: Loads | None
    budget: float
    spent: float
    most_targets: int | None
    is_launched: bool


FOLLOWS = Follower(
    "rehearse",
    (FIRST | CAMPAIGNS | MODELLED | RELEASES | {"capture windows", "end of life"})
    - SUPPLIES
    - {"low thrust", "prizes that fall", "launches into orbits"},
)
"""Rules that rehearsals follow."""

PROMISED = Follower("plans with a confidence", FOLLOWS.follows - {"capture windows"})
"""Rules followed by robust plans and plans for the expected prize; with several windows, the chance
that a stay ends in time is unknown."""


class MissionFacts:
    """Everything about an instance that rehearsals share.

    Parameters
    ----------
    instance : Instance
    cores : int
        That planners and proofs may use; 0 for all.

    Attributes
    ----------
    expectation : tuple or None
        What policies expect that plan, for what (:func:`.expectation.expectation_of`).
    visible_legs : tuple or None
        What the learned policy sees, for what (:func:`.learned.visible_legs_of`).

    Raises
    ------
    InputError
        It has a rule that rehearsals do not follow.
    """

    def __init__(self, instance: Instance, *, cores: int = 0) -> None:
        refuse(instance, FOLLOWS)
        instance = instance.without_reserves()
        self.cores = cores
        self.instance, self.names = instance, instance.names
        self.number = {name: body for body, name in enumerate(self.names)}
        self.first_target, self.stations = instance.first_target, len(instance.stations)
        self.finder = ConnectionFinder(instance)
        self.tow_s = removal_times(instance, range(len(instance.chasers)))
        self._visited = self.finder
        if self.tow_s:
            targets = tuple(target.replace(removal="visit") for target in instance.targets)
            mission = instance.mission.replace(disposal=None)
            self._visited = ConnectionFinder(instance.replace(targets=targets, mission=mission))
        self.prizes = {
            body: target.prize
            for body, target in enumerate(instance.targets, start=self.first_target)
        }
        self.required = frozenset(
            body
            for body, target in enumerate(instance.targets, start=self.first_target)
            if target.required
        )
        self.chasers = tuple(map(self._limits, range(len(instance.chasers))))
        self.expectation: tuple[Any, Any, Any] | None = None
        self.visible_legs: tuple[Any, Any] | None = None
        self._rows: dict[tuple[int, int, bool], Rows] = {}

    def _limits(self, chaser: int) -> ChaserLimits:
        what = self.instance.chasers[chaser]
        loads = loads_of(self.instance, what, 0.0)
        budget = what.tank.delta_v_m_s + SLACK_M_S if loads is None else most_left_m_s(loads)
        start = self.instance.starts[chaser]
        return ChaserLimits(
            what.name,
            start,
            limits_of(self.instance, chaser),
            loads,
            budget,
            self.finder.spent_m_s(start),
            most_targets(self.instance, what),
            what.is_launched,
        )

    @cached_property
    def without_required(self) -> Instance:
        """The instance in which no target is required."""
        targets = tuple(target.replace(required=False) for target in self.instance.targets)
        return self.instance.replace(targets=targets)

    def factor_of(self, hop: Hop, uncertainty: Uncertainty) -> LognormalFactor | None:
        """Distribution of the factor on the ΔV of a connection; None where it is 1."""
        name = None if hop.destination < self.stations else self.names[hop.destination]
        return uncertainty.factor_of(leg_kinds()[hop.family].name, name)

    def takes_kit(self, body: int) -> bool:
        """Whether a body is a target that takes a kit."""
        at = body - self.first_target
        return at >= 0 and self.instance.targets[at].service.takes_kit

    def finder_of(self, *, towed: bool) -> ConnectionFinder:
        """Finder of connections from where bodies are, or from disposal orbits if towed."""
        return self.finder if towed else self._visited

    def rows(self, i: int, j: int, *, towed: bool) -> Rows:
        """Connections of a pair at their own cost; from a disposal orbit if towed."""
        key = i, j, towed and i in self.tow_s
        if key not in self._rows:
            finder = self.finder_of(towed=key[2]) if i in self.tow_s else self.finder
            found = finder.of_pair(i, j, finder.planning_resolution_m_s)
            value = self.instance.time_value_m_s_per_h / HOUR_S
            best = best_from(found.departure, found.arrival, found.delta_v, 1.0, value)
            cost = found.delta_v - finder.spent_m_s(i)
            self._rows[key] = Rows(
                found.departure, found.arrival, cost, found.family, found.revolutions, best
            )
        return self._rows[key]

    def best(self, i: int, j: int, ready_s: float, *, towed: bool) -> Hop | None:
        """The connection that a ready chaser takes: the best by the value of time."""
        rows = self.rows(i, j, towed=towed)
        first = int(np.searchsorted(rows.departure, ready_s - SLACK_S))
        return None if first == rows.best.size else hop_of(j, rows, int(rows.best[first]))

    def of_leg(self, leg: Leg, i: int, *, towed: bool) -> Hop:
        """The connection that a plan's leg flies; the leg itself if none matches.

        That of a leg between times of a grid leaves earlier than the leg states.
        """
        j = self.number[leg.destination]
        family = [kind.name for kind in leg_kinds()].index(leg.kind)
        if leg.traits.on_time_grid:
            rows = self.rows(i, j, towed=towed)
            near = (rows.family == family) & (np.abs(rows.arrival - leg.arrival_s) < MATCH_S)
            for row in np.flatnonzero(near & (rows.departure <= leg.departure_s + SLACK_S))[::-1]:
                if abs(rows.delta_v[row] - leg.delta_v_m_s) < SLACK_M_S:
                    return hop_of(j, rows, int(row))
        return Hop(
            j, leg.departure_s, leg.arrival_s, leg.delta_v_m_s, family, leg.phasing_revolutions
        )


def hop_of(j: int, rows: Rows, row: int) -> Hop:
    """A connection of a pair that leads to body j."""
    return Hop(
        j,
        float(rows.departure[row]),
        float(rows.arrival[row]),
        float(rows.delta_v[row]),
        int(rows.family[row]),
        int(rows.revolutions[row]),
    )
