"""Campaigns as tours through time: from a problem to a tour, and from a tour to a plan.

Tours are found on a coarse grid with costs to first order, and the best of them then get the best
times on the grid of the instance's connections, at their exact costs. A plan is made of these.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from adr_opt.common.clock import now_s
from adr_opt.common.constants import DAY_S, SLACK_M_S
from adr_opt.common.errors import InputError
from adr_opt.common.progress import Progress
from adr_opt.common.stop import Stop, TimeIsOver
from adr_opt.legs.connections import Connections
from adr_opt.legs.families.family import StatedLeg
from adr_opt.mission.certified import certify_routes
from adr_opt.mission.problem import Problem, Routes
from adr_opt.mission.result import Result
from adr_opt.mission.schedule import Schedule
from adr_opt.plan.leg_kinds import DRIFT, LAUNCH, leg_kinds
from adr_opt.problem.chasers import TankByMass

from .costs import Tour, TourExpense
from .enumerated import MOST_TARGETS, Enumeration, grid_of
from .grid_costs import TourLayout, costs_of, layout_of
from .population import Annealing, Population
from .retiming import FineGrid, FloatArray, Growth, Integers, MissionTimes, Retiming

FOR_TIMES, MOST_FOR_TIMES_S = 0.08, 60.0
"""Share of the time for the times of the best tours, and its limit [s]."""

TURNS = 2
"""Number of times that each mission is retimed between its neighbours."""

FOR_BEGINNINGS = 0.25
"""Share of the time for the first tours."""

LEAST_ITERATIONS, MOST_ITERATIONS = 500, 25_000
"""Limits on the iterations of an initial tour; the first applies without a time limit."""

MOST_TOURS = 48
"""Maximum number of tours in a population, which grows with the time."""

GUESSED_S = 4e-6
"""Time of an iteration of annealing, for each target [s]."""

SHORTEST_S = 0.3 * DAY_S
"""Shortest planned drift: within fewer than about five revolutions, burns may not fit."""

SUMMED = 1e9
"""Exhaust speed so large that masses add up as ΔV does [m/s]."""


@dataclass(frozen=True)
class FlownTour:
    """Missions of a tour with their times.

    Attributes
    ----------
    orders : tuple of tuple of int
        Bodies of each mission.
    times : tuple of MissionTimes
    cost : float
        Of the campaign as the instance counts it; infinite where a tank is too small.
    """

    orders: tuple[tuple[int, ...], ...]
    times: tuple[MissionTimes, ...]
    cost: float


@dataclass(frozen=True)
class PlannedTour:
    """A campaign as routes with schedules.

    Attributes
    ----------
    routes : tuple of tuple of int or None
        Bodies in order for each chaser; None where no campaign was found.
    schedules : sequence of Schedule
        Of each route.
    counters : mapping
    """

    routes: Routes | None
    schedules: Sequence[Schedule]
    counters: Mapping[str, float]


class Campaign:
    """Data of a problem for tours.

    Parameters
    ----------
    problem : Problem
        :func:`adr_opt.problem.tours.tour_obstacle` knows of none.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.instance, self._mission = problem.instance, problem.missions[0]
        self.layout: TourLayout = layout_of(problem)
        self.expense = self._expense()
        step, stay = self.instance.transfer.drift_step_s, self.layout.steps.stay
        limit = self.instance.transfer.max_leg_s
        longest = math.floor(self.instance.transfer.max_drift_s / step + 1e-9)
        stay_steps = math.ceil(stay / step - 1e-9)
        within = stay_steps + longest + math.ceil(self.layout.steps.step / step)
        if limit is not None:
            within = math.floor(limit / step + 1e-9)
        self.fine = FineGrid(step, stay_steps, within, math.ceil(SHORTEST_S / step), longest)
        since, until = self.instance.available_s[0]
        last_s = min(self.instance.mission.duration_s, math.inf if until is None else until) - stay
        self._bounds = math.ceil(since / step - 1e-9), math.floor(last_s / step + 1e-9)
        apart_s = self.instance.mission.mission_separation_s
        self._apart = None if apart_s is None else math.ceil((stay + apart_s) / step - 1e-9)
        spent = self.expense
        growth = Growth(0.0, 0.0, 0.0)
        if self.weighs:
            growth = Growth(spent.exhaust_m_s, spent.kit_kg, spent.dry_kg + spent.kit_kg)
        self._growth = growth
        self.retiming = Retiming(problem.connecting.ends, self.fine, growth)

    @property
    def weighs(self) -> bool:
        """Whether the cost depends on mass."""
        by_expense = self.instance.objective.cost == "expense"
        return by_expense and isinstance(self._mission.chaser.usable, TankByMass)

    def _expense(self) -> TourExpense:
        """Expense of a mission; where the cost is ΔV, one kilogram stands for 1 m/s."""
        chaser, most = self._mission.chaser, len(self.instance.chasers)
        tank, kept = chaser.usable, 1.0 - self.problem.margin
        if self.weighs:
            assert isinstance(tank, TankByMass)
            stated = chaser.priced
            takes_kits = self.instance.targets[0].service.takes_kit
            kit_kg = chaser.kit_mass_kg if takes_kits else 0.0
            return TourExpense(
                stated.fixed,
                stated.per_kg,
                stated.per_kg_squared,
                tank.dry_mass_kg,
                kit_kg,
                tank.exhaust_m_s,
                kept * tank.propellant_kg,
                most,
            )
        fixed, per_m_s = 0.0, 1.0
        if self.instance.objective.cost == "expense":
            fixed, per_m_s = chaser.priced.fixed, 1e-6
        full = (
            kept * tank.full_m_s(0.0) if isinstance(tank, TankByMass) else kept * tank.delta_v_m_s
        )
        return TourExpense(fixed, per_m_s, 0.0, SUMMED, 0.0, SUMMED, full, most)

    def timed(self, tour: Tour) -> FlownTour | None:
        """A tour at its best times on the grid of connections; None if no times are possible."""
        firsts = [*np.flatnonzero(tour.begins).tolist(), tour.order.size]
        first = self.instance.first_target
        orders = [tuple((tour.order[a:b] + first).tolist()) for a, b in pairwise(firsts)]
        steps, to_fine = self.layout.steps, self.layout.steps.step / self.fine.step
        near = np.round(steps.first / self.fine.step + tour.at * to_fine).astype(np.int64)
        arrivals = [near[a:b] for a, b in pairwise(firsts)]
        times: list[MissionTimes | None] = [None] * len(orders)
        for turn in range(TURNS + 1):
            for place, order in enumerate(orders):
                within, before = self._between(place, arrivals), times[place]
                if turn < TURNS or before is None:
                    found = self.retiming.first_order(order, arrivals[place], *within)
                else:
                    found = self.retiming.exact(order, before, *within)
                if found is None:
                    return None
                times[place], arrivals[place] = found, found.arrivals
        settled = tuple(each for each in times if each is not None)
        return FlownTour(tuple(orders), settled, self._cost(orders, settled))

    def _between(self, place: int, arrivals: Sequence[Integers]) -> tuple[int, int]:
        """Steps between which a mission may arrive anywhere, as its neighbours are."""
        low, high = self._bounds
        if self._apart is not None:
            if place > 0:
                low = max(low, int(arrivals[place - 1][-1]) + self._apart)
            if place + 1 < len(arrivals):
                high = min(high, int(arrivals[place + 1][0]) - self._apart)
        return low, high

    def enumerated(self, over: Callable[[], bool]) -> tuple[FlownTour | None, bool]:
        """The cheapest campaign of few targets, and whether all times of the grid were tried.

        Nothing, and not, of more targets or where the time is over.
        """
        count = len(self.instance.targets)
        if count > MOST_TARGETS:
            return None, False
        fine = self.fine
        if self.instance.transfer.max_leg_s is None:  # one may wait as long as one likes
            fine = fine._replace(within=self._bounds[1])
        coarse = grid_of(count, fine, self._bounds)
        first, ends = self.instance.first_target, self.problem.connecting.ends
        try:
            ways = Enumeration(ends, first, count, fine, coarse, self._growth, over)
            missions = ways.cheapest(self._priced, len(self.instance.chasers), self._apart)
        except TimeIsOver:
            return None, False
        if missions is None:
            return None, coarse.every == 1
        orders, times = [order for order, _ in missions], [each for _, each in missions]
        for place in range(len(orders)) if coarse.every > 1 else ():
            within = self._between(place, [each.arrivals for each in times])
            times[place] = self.retiming.exact(orders[place], times[place], *within) or times[place]
        flown = FlownTour(tuple(orders), tuple(times), self._cost(orders, times))
        return flown, coarse.every == 1

    def _priced(self, total: FloatArray, targets: int) -> FloatArray:
        """Cost of missions by their mass at launch; infinite if a tank is too small."""
        spent = self.expense
        carried = total - (spent.dry_kg if self.weighs else 0.0)
        fits = carried - targets * spent.kit_kg <= spent.most_propellant_kg + SLACK_M_S
        with np.errstate(invalid="ignore"):
            cost = spent.fixed + (spent.per_kg + spent.per_kg_squared * carried) * carried
        return np.where(fits, cost, np.inf)

    def _cost(self, orders: Sequence[tuple[int, ...]], times: Sequence[MissionTimes]) -> float:
        """Cost of missions; infinite if a tank is too small."""
        return math.fsum(
            float(self._priced(np.array(each.total), len(order)))
            for order, each in zip(orders, times, strict=True)
        )

    def schedules(self, flown: FlownTour) -> tuple[tuple[tuple[int, ...], ...], list[Schedule]]:
        """Routes of all chasers and their schedules; missions go to chasers in order of time."""
        begun = np.argsort([each.arrivals[0] for each in flown.times], kind="stable")
        routes: list[tuple[int, ...]] = []
        found: list[Schedule] = []
        for number, mission in enumerate(self.problem.missions):
            if number >= len(begun):
                routes.append(())
                found.append(mission.schedules.of(()))
                continue
            order, times = flown.orders[begun[number]], flown.times[begun[number]]
            chosen = self._connections(mission.rules.start, order, times)
            routes.append(order)
            found.append(mission.schedules.over(_looked_up(chosen)).of(order))
        return tuple(routes), found

    def can_be_flown(self, routes: Routes, schedules: Sequence[Schedule]) -> bool:
        """Whether tanks suffice for all legs, kits aboard, and burns are found for them."""
        for route, schedule, mission in zip(routes, schedules, self.problem.missions, strict=True):
            if schedule.made < len(route):
                return False
            for k, pair in enumerate(pairwise((mission.rules.start, *route))):
                times = float(schedule.departures[k]), float(schedule.arrivals[k])
                stated = StatedLeg(*times, int(schedule.revolutions[k]))
                try:
                    mission.connecting.flown(*pair, int(schedule.families[k]), stated)
                except InputError:
                    return False
        return True

    def planned(
        self, tours: Iterable[FlownTour], counters: Mapping[str, float]
    ) -> PlannedTour | None:
        """The first of some tours that can be flown, as a plan."""
        for flown in tours:
            routes, schedules = self.schedules(flown)
            if self.can_be_flown(routes, schedules):
                return PlannedTour(routes, schedules, counters)
        return None

    def _connections(
        self, start: int, order: tuple[int, ...], times: MissionTimes
    ) -> dict[tuple[int, int], Connections]:
        """The connection of each leg of a mission, its launch first."""
        kinds, step = leg_kinds(), self.fine.step
        launch = times.arrivals[0] * step
        of_leg = {(start, order[0]): _one(launch, launch, 0.0, 0, kinds.index(LAUNCH))}
        for k, pair in enumerate(pairwise(order)):
            leaves, arrives = times.departures[k] * step, times.arrivals[k + 1] * step
            delta_v = self.retiming.delta_v(*pair, leaves, arrives)
            of_leg[pair] = _one(leaves, arrives, delta_v, -1, kinds.index(DRIFT))
        return of_leg


def _looked_up(chosen: dict[tuple[int, int], Connections]) -> Callable[[int, int], Connections]:
    """Connections by origin and destination."""
    return lambda i, j: chosen[i, j]


def _one(leaves: float, arrives: float, delta_v: float, laps: int, family: int) -> Connections:
    """A single connection."""

    def column(value: float, kind: type[np.generic]) -> npt.NDArray[np.generic]:
        return np.array([value], kind)

    return Connections(
        np.array([leaves]),
        np.array([arrives]),
        np.array([delta_v]),
        np.array([laps], np.int8),
        np.array([family], np.int8),
    )


def plan_tours(
    problem: Problem, *, seed: int, stop: Stop, progress: Progress, cores: int
) -> PlannedTour:
    """The best campaign that the time allows.

    Parameters
    ----------
    problem : Problem
        :func:`adr_opt.problem.tours.tour_obstacle` knows of none.
    seed : int
    stop : Stop
        Asked once a generation.
    progress : Progress
    cores : int
        Threads.
    """
    campaign = Campaign(problem)
    tried, settled = campaign.enumerated(lambda: stop.remaining_s() <= 0.0)
    if settled:
        counters = {"generations": 0.0}
        if tried is not None and (planned := campaign.planned([tried], counters)) is not None:
            return planned
    cost = costs_of(problem, campaign.layout, cores, stop)
    left_s = stop.remaining_s()
    settings = Annealing(missions=min(10, len(problem.missions)), iterations=LEAST_ITERATIONS)
    if math.isfinite(left_s):
        each_s = GUESSED_S * len(problem.instance.targets) / cores
        most = int(FOR_BEGINNINGS * max(left_s, 0.0) / each_s)
        tours = min(max(most // MOST_ITERATIONS, settings.population), MOST_TOURS)
        iterations = min(max(most // tours, LEAST_ITERATIONS), MOST_ITERATIONS)
        settings = replace(settings, population=tours, iterations=iterations)
    for_times_s = min(FOR_TIMES * left_s, MOST_FOR_TIMES_S) if math.isfinite(left_s) else 0.0

    def share() -> float:
        return 1.0 if stop.remaining_s() <= for_times_s else 0.0

    grid, spent = campaign.layout.grid, campaign.expense
    found = Population(cost, grid, spent, settings, share, seed=seed, cores=cores)
    everything, told = problem.total_worth, False
    while True:
        found.advance()
        if found.tours and not told:
            progress(everything, everything)
            told = True
        if share() >= 1.0 or stop(everything if told else -math.inf, everything):
            break
    counters = {"generations": float(found.generations)}
    flown = _timed(campaign, found.tours, stop, cores)
    if tried is not None:
        flown = sorted([tried, *flown], key=lambda each: each.cost)
    return campaign.planned(flown, counters) or PlannedTour(None, (), counters)


def certified_tour(
    method: str,
    problem: Problem,
    planned: PlannedTour,
    *,
    seed: int,
    began_s: float,
    cost_bound: float | None = None,
    counters: Mapping[str, float] | None = None,
) -> Result:
    """The result of a campaign.

    Parameters
    ----------
    method : str
        Whose result it is.
    problem : Problem
    planned : PlannedTour
    seed : int
    began_s : float
        When the method began, by :func:`adr_opt.common.clock.now_s` [s].
    cost_bound : float, optional
        Proven: no campaign costs less.
    counters : mapping, optional
        Of what was done besides planning.
    """
    lacking = planned.routes is None
    notes = ("no tour through time was found that services all targets",) if lacking else ()
    return certify_routes(
        problem,
        method,
        planned.routes,
        seed=seed,
        runtime_s=now_s() - began_s,
        schedules=planned.schedules or None,
        cost_bound=cost_bound,
        upper_bound=math.inf if lacking else problem.total_worth,
        notes=notes,
        counters={**planned.counters, **(counters or {})},
    )


def _timed(campaign: Campaign, tours: Sequence[Tour], stop: Stop, cores: int) -> list[FlownTour]:
    """Tours at their best times, the cheapest first; the first that has any if time is short."""
    found: list[FlownTour] = []

    def timed(tour: Tour) -> None:
        if found and stop.remaining_s() <= 0.0:
            return
        flown = campaign.timed(tour)
        if flown is not None and math.isfinite(flown.cost):
            found.append(flown)

    with ThreadPoolExecutor(cores) as threads:
        list(threads.map(timed, tours))
    return sorted(found, key=lambda flown: (flown.cost, flown.orders))
