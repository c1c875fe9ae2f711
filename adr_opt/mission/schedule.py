"""Scheduling an order of bodies at least cost, exactly (docs/model.md section 4)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from copy import copy
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..common.constants import SLACK_M_S
from ..kernels.rules import schedule as kernels
from ..kernels.rules.falls import lost_at
from ..kernels.rules.rules import Rules
from ..legs.connection_finder import ConnectionFinder
from ..legs.connections import Connections
from ..problem.chasers import Chaser, TankByMass
from .prizes import PrizeLosses

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

PAIRS_KEPT = 2_000
"""Usual number of pairs whose connections are cached: about 50 kB each in a mission of a week."""


class Front(NamedTuple):
    """Undominated labels at the last body of an order.

    Attributes
    ----------
    ready, left, cost : (labels,) float64
        Since when the chaser is free there [s], ascending; ΔV left [m/s]; ΔV of all legs and tows
        [m/s], or, where expenses count, what it has to carry at the start if it ends here [kg].
    parent, taken : (labels,) int64
        Label at the body before, and the connection taken from there.
    spent : (labels,) float64
        ΔV of all legs where expenses count masses, else empty [m/s].
    """

    ready: FloatArray
    left: FloatArray
    cost: FloatArray
    parent: IntArray
    taken: IntArray
    spent: FloatArray = np.empty(0)


@dataclass(frozen=True)
class Schedule:
    """Least-cost schedule of an order of bodies, as far as the rules allow.

    Attributes
    ----------
    made : int
        Number of moves that can be made; less than the length of the order if it cannot be flown.
    objective : float
        Sum of the prizes of the moves made, by the ends of their services.
    delta_v : float
        Total ΔV of the moves made, tows included [m/s].
    cost : float
        What the mission minimises among plans of the same prizes: that ΔV and the price of the
        time since the start [m/s], or the end of the last leg's service [s], or the expense of
        the chaser.
    departures, arrivals, ends : (made,) float64
        Of each leg, and the end of the service that follows it [s].
    delta_vs, lefts : (made,) float64
        ΔV that each leg draws from the tank, without tows, the first one with the ΔV spent before
        the start; and the ΔV left after its service, plus the slack by which a tank may be
        overdrawn [m/s].
    revolutions, families : (made,) int8
        Phasing revolutions of each leg, and the number of its family.
    masses : (made,) float64
        Largest mass at the departure of each leg, +inf for any [kg].
    """

    made: int
    objective: float
    delta_v: float
    cost: float
    departures: FloatArray
    arrivals: FloatArray
    ends: FloatArray
    delta_vs: FloatArray
    lefts: FloatArray
    revolutions: npt.NDArray[np.int8]
    families: npt.NDArray[np.int8]
    masses: FloatArray

    @property
    def connections(self) -> Connections:
        """The connection flown by each leg, in order."""
        return Connections(
            self.departures,
            self.arrivals,
            self.delta_vs,
            self.revolutions,
            self.families,
            self.masses,
        )


def left_at_start(rules: Rules, kits: int) -> float:
    """ΔV in the tank at the start with a number of kits aboard [m/s]."""
    return rules.budget if rules.loads is None else float(rules.loads.first[kits])


class Scheduler:
    """Schedules orders of one mission; common beginnings of orders are computed once.

    Parameters
    ----------
    connecting : ConnectionFinder
        Of the instance.
    rules : callable
        Gives the rules of the mission, once they are needed.
    cost : {"delta-v", "duration", "expense"}
        What the best schedule of an order has least of, among those that lose least of prizes.
    chaser : Chaser
        The chaser.
    time_m_s_per_s : float
        Price of the time from when the chaser may fly to the end of an order [m/s per s].
    kept : int
        Number of pairs whose connections are cached.
    """

    def __init__(
        self,
        connecting: ConnectionFinder,
        rules: Callable[[], Rules],
        cost: str,
        chaser: Chaser,
        time_m_s_per_s: float = 0.0,
        kept: int = PAIRS_KEPT,
    ) -> None:
        self._rules = rules
        self._chaser = chaser
        self._time_m_s_per_s = time_m_s_per_s
        self._by_time = cost == "duration"
        self._by_expense = cost == "expense"

        def of_pair(i: int, j: int) -> Connections:
            return connecting.of_pair(i, j, connecting.planning_resolution_m_s)

        def leaving_from(i: int, j: int, since_s: float) -> Connections:
            return connecting.of_pair(i, j, connecting.planning_resolution_m_s, since_s)

        def least(i: int, j: int) -> float:
            function = connecting.function_of(i, j)
            if function is not None:
                return function.cost + connecting.spent_m_s(i)
            return float(self.connections(i, j).delta_v.min(initial=math.inf))

        self._of_class: Callable[[int, int], Connections] | None = None
        weighs = any(
            station.max_propellant_kg is not None for station in connecting.instance.stations
        )
        if connecting.lighter_classes_kg and not weighs:
            self._of_class = lru_cache(kept)(connecting.by_class)
        self._has_lighter, self._counts_cost = False, True
        self._spent_m_s = connecting.spent_m_s
        self._by_function = connecting.by_function
        self._leaving_from = None if connecting.is_listed else leaving_from
        self._passes = False
        self.connections: Callable[[int, int], Connections] = lru_cache(kept)(of_pair)
        self._least = lru_cache(None)(least)
        # The order of the last call, the kits at its start, and its fronts. One object, so that
        # threads may share it.
        self._last: tuple[tuple[int, ...], int, tuple[Front, ...]] = ((), 0, ())

    def under(self, rules: Rules, chaser: Chaser | None = None) -> Scheduler:
        """A scheduler with other rules or of another chaser; connections are shared."""
        made = copy(self)
        made._rules = lambda: rules
        made._chaser = chaser or self._chaser
        made.__dict__.pop("_losses", None)
        made._last = ((), 0, ())
        return made

    def over(self, connections: Callable[[int, int], Connections]) -> Scheduler:
        """A scheduler over other connections, from a function of origin and destination."""
        made = copy(self)
        made.connections, made._of_class, made._leaving_from = connections, None, None
        made._last = ((), 0, ())
        return made

    @property
    def by_class(self) -> Scheduler:
        """A scheduler with the connections of lighter chasers as well; itself if there are none.

        Searches do without them: these lists take several times as long.
        """
        if self._of_class is None:
            return self
        made = copy(self)
        made._has_lighter = True
        made._last = ((), 0, ())
        return made

    @property
    def unpriced(self) -> Scheduler:
        """A scheduler that ignores costs, to find whether and when an order can be flown.

        Its fronts are of time and ΔV alone, and far shorter.
        """
        made = copy(self)
        made._counts_cost, made._last = False, ((), 0, ())
        return made

    @property
    def passing(self) -> Scheduler:
        """A scheduler for pairs asked for once: no connections before a chaser is ready."""
        made = copy(self)
        made._passes, made._last = True, ((), 0, ())
        return made

    def from_ready(self, i: int, j: int, ready: FloatArray) -> Connections:
        """The connections of a pair that chasers ready at some times may need, by departure.

        All that are listed; of a function of time those that leave as soon as one is ready.
        """
        found = self._by_function(i, j, ready)
        if found is None and self._passes and self._leaving_from is not None:
            return self._leaving_from(i, j, float(ready.min()))
        return self.connections(i, j) if found is None else found

    def _flyable(self, i: int, j: int, ready: FloatArray) -> Connections:
        """The connections of a pair for ready times, including those for lighter chasers only."""
        if self._of_class is None or not self._has_lighter or self._keeps_to_heaviest:
            return self.from_ready(i, j, ready)
        return self._of_class(i, j)

    @property
    def _reserve_m_s(self) -> float:
        """ΔV kept in reserve in each tank, without kits aboard [m/s]."""
        rules = self._rules()
        full = rules.budget if rules.loads is None else float(rules.loads.full[0])
        return self._chaser.usable.delta_v_m_s + SLACK_M_S - full

    @property
    def _keeps_to_heaviest(self) -> bool:
        """Whether only connections of the heaviest chaser are flown, as venting would not be exact.

        Where kits are left or objects towed, a reserve changes, and of two labels the one that has
        vented may be the one that needs less at the start.
        """
        if self._rules().loads is None:
            return False
        return self._weighs or self._reserve_m_s > SLACK_M_S

    def _caps(self, found: Connections, i: int, aboard: int) -> FloatArray | None:
        """Most ΔV that may be left before each of some connections, as labels count it [m/s]."""
        tank = self._chaser.usable
        if found.mass_kg is None or not isinstance(tank, TankByMass):
            return None
        empty_kg = tank.dry_mass_kg + aboard * self._chaser.kit_mass_kg
        kept = SLACK_M_S + self._spent_m_s(i) - self._reserve_m_s
        return tank.exhaust_m_s * np.log(found.mass_kg / empty_kg) + kept

    def kits_for(self, order: tuple[int, ...]) -> int:
        """Number of kits that the services of an order need, all taken along."""
        loads = self._rules().loads
        return 0 if loads is None else int(loads.takes[list(order)].sum())

    def ways(self, order: tuple[int, ...]) -> Iterator[tuple[int, Front]]:
        """Labels after an order, by number of kits that may remain."""
        loads = self._rules().loads
        taken = self.kits_for(order)
        for kits in range(taken, taken + 1 if loads is None else loads.full.size):
            fronts = self.fronts(order, kits)
            if len(fronts) > len(order):
                yield kits - taken, fronts[-1]

    def fronts(self, order: tuple[int, ...], kits: int | None = None) -> tuple[Front, ...]:
        """Labels at the start and after each move, as far as the order can be flown.

        Parameters
        ----------
        order : tuple of int
            Bodies; its moves keep to the rules of the order.
        kits : int, optional
            Number of kits taken along; by default the number needed.
        """
        rules = self._rules()
        if kits is None:
            kits = self.kits_for(order)
            if rules.loads is not None:
                kits = min(kits, rules.loads.full.size - 1)
        before, with_kits, known = self._last
        common = 0
        while common < min(len(order), len(known) - 1) and order[common] == before[common]:
            common += 1
        fronts = list(known[: common + 1]) if kits == with_kits else []
        if not fronts:
            common = 0
            fronts.append(self.beginning(kits))
        aboard = kits - self.kits_for(order[:common])
        for at in range(common, len(order)):
            i = order[at - 1] if at else rules.start
            j = order[at]
            refuelled = any(rules.is_station[body] for body in order[:at])
            front = self.extended(fronts[-1], i, j, aboard, refuelled=refuelled)
            if not front.ready.size:
                break
            aboard -= self.kits_for((j,))
            fronts.append(front)
        self._last = order, kits, tuple(fronts)
        return self._last[2]

    def beginning(self, kits: int) -> Front:
        """The label at the start, with a number of kits aboard."""
        rules, nothing, needed = self._rules(), np.zeros(1, dtype=np.int64), np.zeros(1)
        left = left_at_start(rules, kits)
        if self._weighs:
            needed[0] = kits * self._chaser.kit_mass_kg
        ready = np.array([rules.ready])
        return Front(ready, np.array([left]), needed, nothing, nothing, np.zeros(1))

    def extended(self, here: Front, i: int, j: int, aboard: int, *, refuelled: bool) -> Front:
        """The labels after a move.

        Parameters
        ----------
        here : Front
            Those at body i.
        i, j : int
        aboard : int
            Kits on the way.
        refuelled : bool
            Whether it has refuelled before.
        """
        rules, found = self._rules(), self._flyable(i, j, here.ready)
        loads = rules.loads
        flown = 0.0 if loads is None else float(loads.flown[j])
        weight, price = self._paid(here, found.delta_v, aboard, refuelled, j)
        visit = kernels.Visit(
            j,
            aboard,
            rules.service[j],
            rules.windows,
            rules.is_station[j],
            rules.budget,
            self._losses.falls if self._counts_cost else None,
            self._caps(found, i, aboard),
        )
        front = Front(
            *kernels.follow(
                here.ready,
                here.left,
                here.cost,
                weight,
                (found.departure, found.arrival, found.delta_v, price),
                visit,
                loads,
            )
        )
        if self._weighs:
            spent = here.spent[front.parent] + found.delta_v[front.taken] + flown
            front = front._replace(spent=spent)
        return front

    @property
    def _weighs(self) -> bool:
        """Whether the cost is the mass that the chaser carries."""
        return self._by_expense and self._chaser.priced.counts_mass

    def _paid(
        self, here: Front, delta_v: FloatArray, aboard: int, refuelled: bool, body: int
    ) -> tuple[FloatArray, FloatArray]:
        """Cost added to labels by connections: the weights, and their prices.

        Weights are empty where all are one. Where expenses count, legs after the first refuelling
        cost nothing, as do all of a chaser whose expense does not go by mass. A tow that follows
        is flown with the mass of the object as well.
        """
        if not self._counts_cost:
            return np.empty(0), np.zeros(delta_v.size)
        loads = self._rules().loads
        flown = 0.0 if loads is None else float(loads.flown[body])
        if not self._by_expense:
            return np.empty(0), delta_v + flown
        tank = self._chaser.usable
        if refuelled or not self._weighs or not isinstance(tank, TankByMass):
            return np.empty(0), np.zeros(delta_v.size)
        empty_kg = tank.dry_mass_kg + aboard * self._chaser.kit_mass_kg
        exhaust = tank.exhaust_m_s
        lifts, price = np.exp(delta_v / exhaust), np.expm1(delta_v / exhaust)
        if loads is not None and flown > 0.0:
            kept, lost = loads.scale[body, aboard], loads.loss[body, aboard]
            both = 1.0 + lost / (1.0 - kept)  # the mass of both, in that without propellant
            price = price + lifts * both * math.expm1(flown / exhaust)
        return empty_kg * np.exp(here.spent / exhaust), price

    def least_cost(self, order: tuple[int, ...]) -> float:
        """Lower bound on the cost of an order: each leg at its least ΔV, and tows [m/s]; or 0."""
        if self._by_time or self._by_expense:
            return 0.0
        rules = self._rules()
        way = (rules.start, *order)
        flown = math.fsum(self._flown(order))
        return math.fsum(self._least(i, j) for i, j in pairwise(way)) + flown - self._before(order)

    def _flown(self, order: tuple[int, ...]) -> list[float]:
        """ΔV flown within each service of an order [m/s]."""
        loads = self._rules().loads
        found: list[float] = [] if loads is None else loads.flown[list(order)].tolist()
        return found

    def _before(self, order: tuple[int, ...]) -> float:
        """ΔV charged to the first leg for expenditure before the start [m/s]."""
        return self._spent_m_s(self._rules().start) if order else 0.0

    def paid(self, last: Front) -> FloatArray:
        """Cost of labels if the order ends with them, including the price of time.

        That is paid at the end alone, so that on the way a label that is ready no later, has no
        less left and has cost no more makes another one superfluous whatever time costs.
        """
        return last.cost + self._time_m_s_per_s * (last.ready - self._rules().ready)

    @cached_property
    def _losses(self) -> PrizeLosses:
        """Losses of prizes as costs of labels."""
        rules = self._rules()
        return PrizeLosses.of(rules.falls, self._most_cost(rules))

    def _most_cost(self, rules: Rules) -> float:
        """Upper limit on the cost of a label."""
        tank, kits = self._chaser.usable, 0
        if rules.loads is not None:
            kits = rules.loads.full.size - 1
        if self._by_expense and isinstance(tank, TankByMass):
            return tank.dry_mass_kg + tank.propellant_kg + kits * self._chaser.kit_mass_kg
        flown = 0.0 if rules.loads is None else float(rules.loads.flown.max(initial=0.0))
        # Without stations all legs are paid for by one tank.
        legs = 2 * (rules.service.size - rules.first_target) + 2 if rules.stations else 1
        time_m_s = self._time_m_s_per_s * max(rules.duration - rules.ready, 0.0)
        return legs * (rules.budget + flown + self._spent_m_s(rules.start)) + time_m_s

    def lost_and_cost(self, front: Front) -> tuple[FloatArray, FloatArray]:
        """Losses of prizes, and costs of labels."""
        return self._losses.apart(front.cost)

    def endings(self, order: tuple[int, ...]) -> tuple[FloatArray, FloatArray]:
        """Possible ends of an order with their least ΔV, which falls with later ends.

        Returns
        -------
        ends : (endings,) float64
            Ascending [s]; none where the order cannot be flown.
        delta_vs : (endings,) float64
            Descending, tows included [m/s].
        """
        fronts = self.fronts(order)
        if not order or len(fronts) <= len(order):
            return np.empty(0), np.empty(0)
        last = fronts[-1]
        by_end = np.lexsort((last.cost, last.ready))
        ends, costs = last.ready[by_end], self.lost_and_cost(last)[1][by_end]
        falls = costs < np.append(math.inf, np.minimum.accumulate(costs)[:-1])
        return ends[falls], costs[falls] - self._before(order)

    def of(self, order: tuple[int, ...]) -> Schedule:
        """Least-cost schedule: the earliest end of least ΔV, or the other way round."""
        fronts = self.fronts(order)
        rules = self._rules()
        made = len(fronts) - 1
        last = fronts[-1]
        paid = self.paid(last)
        lost, spent = self.lost_and_cost(last)
        keys = (spent, last.ready, lost) if self._by_time else (last.ready, paid)
        label = int(np.lexsort(keys)[0])
        before = self._before(order[:made])
        total = float(spent[label]) - before
        cost = float((paid - (last.cost - spent))[label]) - before
        if self._by_time:
            cost = float(last.ready[label]) if made else 0.0
        elif self._by_expense:
            cost = self._chaser.priced.of(float(spent[label])) if made else 0.0
        departures, arrivals, ends, delta_vs, lefts, masses = np.empty((6, made))
        revolutions, families = np.empty((2, made), dtype=np.int8)
        for at in range(made - 1, -1, -1):
            front = fronts[at + 1]
            i = order[at - 1] if at else rules.start
            found, taken = self._flyable(i, order[at], fronts[at].ready), front.taken[label]
            departures[at], arrivals[at] = found.departure[taken], found.arrival[taken]
            delta_vs[at], revolutions[at] = found.delta_v[taken], found.revolutions[taken]
            families[at] = found.family[taken]
            masses[at] = math.inf if found.mass_kg is None else found.mass_kg[taken]
            ends[at], lefts[at] = front.ready[label], front.left[label]
            label = front.parent[label]
        objective = math.fsum(rules.prize[j] for j in order[:made])
        if rules.falls is not None:
            objective -= math.fsum(
                float(lost_at(rules.falls, j, end))
                for j, end in zip(order[:made], ends, strict=True)
            )
            if not self._by_expense:
                # Labels know it only as finely as losses leave room for.
                exact = math.fsum((*delta_vs, *self._flown(order[:made]))) - before
                cost, total = cost if self._by_time else cost + exact - total, exact
        return Schedule(
            made,
            objective,
            math.fsum(delta_vs) - before if self._by_expense else total,
            cost,
            departures,
            arrivals,
            ends,
            delta_vs,
            lefts,
            revolutions,
            families,
            masses,
        )
