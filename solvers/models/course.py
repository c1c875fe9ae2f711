"""Driver of a proof by an integer-programming solver, the same for every solver."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from adr_opt.common.clock import now_s
from adr_opt.common.options import MOST_JOBS, Options, option
from adr_opt.common.processors import usable_cores
from adr_opt.common.progress import Progress
from adr_opt.common.stop import Stop, TimeIsOver
from adr_opt.kernels.rules.rules import Rules
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result

from ..beams.greedy_order import greedy_sequence
from ..networks.arrays import Network as Rows
from ..progress.gap import GapTracker
from ..progress.proof_size import bound_notes, set_up_s
from ..walks.multipliers import Descent
from ..walks.walks import WalkBound
from .reduction import best_through, can_reach, finest_slot
from .solver_network import SolverNetwork, bodies_along, keep, of_rows, path_of

WHOLE_LEGS = 1_000
"""Maximum number of legs up to which the whole network is solved, by the solver's bound alone."""

SIFTED_FIRST = 100_000
SIFTING_S_PER_LEG = 3e-6
"""Networks of this size are reduced before multipliers are sought, as they may turn out small; of
larger ones this takes too long if not needed, and cannot be interrupted [s]."""

SHARE = 0.3
"""Share of the remaining time for multipliers."""

SLOT_M_S = 20.0
"""ΔV slots of the multipliers' bound, widened if its values do not fit in memory."""

FINER = 0.8
"""Reduced costs are recomputed if slots can be finer by this factor."""


class SolverAnswer(NamedTuple):
    """Answer of a solver for a network.

    Attributes
    ----------
    legs : tuple of int or None
        Of the best path it knows, in any order.
    upper_bound : float
        Proven: no path of the network is worth more. +inf if nothing was proven.
    nodes : int
        Nodes or branches of its search.
    """

    legs: tuple[int, ...] | None
    upper_bound: float
    nodes: int


class Hear(NamedTuple):
    """Callback for a solver's progress.

    Attributes
    ----------
    bound : callable
        Told a bound on the paths of the network; says whether to stop.
    remaining_s : callable
        Seconds that may still be used.
    """

    bound: Callable[[float], bool]
    remaining_s: Callable[[], float]


class SolverModel(Protocol):
    """A network modelled for a solver."""

    def solve(self, *, seed: int, hear: Hear) -> SolverAnswer:
        """Solve the model as far as time allows."""
        ...

    def forbid(self, groups: list[list[int]]) -> None:
        """Forbid paths with a leg from each of these groups, from the next solve on."""
        ...


MakeModel = Callable[[SolverNetwork, Rules, float, list[int]], SolverModel]
"""Arguments: network, rules, unit of the objective, legs of an initial plan."""


@dataclass(frozen=True)
class ModelOptions(Options):
    """Options of the methods that pass the network to a solver."""

    jobs: int = option(
        0,
        "Threads for the multipliers, 0 for all cores. No effect on the result.",
        least=0,
        most=MOST_JOBS,
    )
    most_arcs: int = option(60_000, "Largest network passed to the solver, in arcs.", least=1)
    evaluations: int = option(
        150, "Maximum number of evaluations of the Lagrangian bound.", least=1
    )


def prove(
    method: str,
    make_model: MakeModel,
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[int] | None,
    options: ModelOptions,
) -> Result:
    """Prove a bound on the best plan.

    A small network is solved whole. From a larger one, arcs are dropped that no plan worth a goal
    can use; the goal is a little below the bound and above the incumbent. If the solver finds such
    a plan, it is the best one there is; if it proves that there is none, every plan is worth less
    than the goal, the bound comes down, and the next goal is set. What the solver finds is an order
    of bodies, which is then timed anew.

    Parameters
    ----------
    method : str
        Name of the method.
    make_model : callable
        Writes a network for the solver.
    mission, seed, stop, progress, start, options
        As for any planner. Without a start, the guarded greedy planner gives one.
    """
    certificate = GapTracker(mission, progress)
    course = _Course(mission, make_model, certificate, stop, seed)
    if start is None:
        start = greedy_sequence(mission)
    certificate.offer(start)
    if not course.enough():
        with suppress(TimeIsOver):
            course.run(options.jobs or usable_cores(), options.most_arcs, options.evaluations)
        if not (certificate.proven or course.notes or course.remaining_s() <= 0.0):
            course.notes.append(
                f"the solver cannot tell the bound of {certificate.bound:g} from the plan within "
                "its tolerances: other proving methods may"
            )
    notes = [*course.notes, *bound_notes(mission)]
    return certificate.result(method, seed=seed, counters=course.counters, notes=notes)


class _Course:
    """One proof."""

    def __init__(
        self,
        mission: Mission,
        make_model: MakeModel,
        certificate: GapTracker,
        stop: Stop,
        seed: int,
    ) -> None:
        self._mission = mission
        self._make_model = make_model
        self._certificate = certificate
        self._stop = stop
        self._seed = seed
        self._ended = False
        self.notes: list[str] = []
        self.counters: dict[str, float] = {
            "network_nodes": 0,
            "network_arcs": 0,
            "solved_arcs": 0,
            "solves": 0,
            "solver_nodes": 0,
            "forbidden": 0,
            "evaluations": 0,
        }

    def enough(self) -> bool:
        """Whether to stop; ``stop`` is queried once per iteration."""
        known = self._certificate
        self._ended = self._ended or known.proven or self._stop(known.incumbent, known.bound)
        return self._ended

    def remaining_s(self) -> float:
        """Remaining time [s]."""
        return 0.0 if self._ended else self._stop.remaining_s()

    def run(self, jobs: int, most_arcs: int, evaluations: int) -> None:
        """Work until the incumbent meets the bound, or as far as size and time allow.

        Raises
        ------
        TimeIsOver
            An evaluation of the multipliers' bound was broken off.
        """
        mission, certificate = self._mission, self._certificate
        if self.remaining_s() < set_up_s(mission):
            return
        bound = WalkBound(mission, SLOT_M_S, jobs=jobs, over=lambda: self.remaining_s() <= 0.0)
        try:
            rows = bound.network
            if rows.landing.size <= SIFTED_FIRST:
                network = self._network(rows)
                if network.legs <= min(WHOLE_LEGS, most_arcs):
                    self._solve(network, -math.inf)
                    return
            multipliers = self._multipliers(bound, evaluations)
        finally:
            bound.close()
        del bound
        if rows.landing.size > SIFTED_FIRST:
            if self.remaining_s() < SIFTING_S_PER_LEG * rows.landing.size:
                self.notes.append(
                    f"the network of {rows.landing.size} connections was not passed to the solver: "
                    "too little time was left"
                )
                return
            network = self._network(rows)
        while not self.enough():
            goal = certificate.threshold
            part = self._reduced(network, multipliers, goal)
            if self.remaining_s() <= 0.0:
                return
            if part.legs > most_arcs:
                self.notes.append(
                    f"{part.legs} arcs may belong to a plan worth {goal:g}, which is more than "
                    f"most_arcs = {most_arcs}: they were not passed to the solver"
                )
                return
            before = certificate.bound
            self._solve(part, goal)
            if certificate.bound >= before:
                return

    def _network(self, rows: Rows) -> SolverNetwork:
        """The network of a mission, counted."""
        network = of_rows(rows, self._mission.rules)
        self.counters |= {"network_nodes": network.nodes, "network_arcs": network.legs}
        return network

    def _multipliers(self, bound: WalkBound, evaluations: int) -> np.ndarray:
        """Multipliers with a small best walk; lowers the bound."""
        certificate = self._certificate
        end = now_s() + SHARE * self.remaining_s()
        descent = Descent(bound)
        while descent.evaluations < evaluations and not descent.done:
            descent.step()
            self.counters["evaluations"] = descent.evaluations
            certificate.lower(descent.value)
            if self.enough() or now_s() > end:
                break
        return descent.multipliers

    def _reduced(
        self, network: SolverNetwork, multipliers: np.ndarray, goal: float
    ) -> SolverNetwork:
        """The network of legs that a plan above the goal may use, by increasingly fine slots."""
        rules = self._mission.rules
        slot = math.inf
        while network.legs and finest_slot(network, rules.budget) < FINER * slot:
            if self.remaining_s() <= 0.0:
                break
            slot = finest_slot(network, rules.budget)
            through = best_through(network, rules, multipliers, slot)
            network = keep(network, can_reach(through, goal), rules)
        return network

    def _solve(self, network: SolverNetwork, goal: float) -> None:
        """Pass a network that contains every plan above a goal to the solver."""
        certificate, rules = self._certificate, self._mission.rules
        stays = bool(rules.may_end[rules.start])
        answer = SolverAnswer((), 0.0 if stays else -math.inf, 0)
        if network.legs:
            self.counters["solves"] += 1
            self.counters["solved_arcs"] = network.legs
            known = path_of(network, certificate.sequence or (), rules)
            unit = self._mission.prize_step or float(rules.prize.max())
            model = self._make_model(network, rules, unit, known)

            def hear(bound: float) -> bool:
                certificate.lower(max(bound, goal))
                return self.remaining_s() <= 0.0

            while True:
                answer = model.solve(seed=self._seed, hear=Hear(hear, self.remaining_s))
                self.counters["solver_nodes"] += answer.nodes
                too_dear = _too_dear(network, rules, answer.legs or ())
                if not too_dear or self.remaining_s() <= 0.0:
                    break
                # Within the solver's tolerances it fits the tank. There are few such paths.
                model.forbid(too_dear)
                self.counters["forbidden"] += 1
        if answer.legs is not None:
            certificate.offer(bodies_along(network, answer.legs))
        # Plans that are not in the network are worth less than the goal.
        certificate.lower(max(answer.upper_bound, goal))


def _too_dear(network: SolverNetwork, rules: Rules, path: tuple[int, ...]) -> list[list[int]]:
    """Legs that overdraw a tank if one is taken from each group; none for a feasible path.

    Each group goes from one body to the next of the path's first tank that does not reach, and
    costs no less than the leg taken.
    """
    left, tank = rules.budget, list[int]()
    for leg in sorted(path):
        tank.append(leg)
        if network.delta_v[leg] > left:
            origin, destination = network.origin, network.destination
            return [
                np.flatnonzero(
                    (origin == origin[taken])
                    & (destination == destination[taken])
                    & (network.delta_v >= network.delta_v[taken])
                ).tolist()
                for taken in tank
            ]
        left -= network.delta_v[leg]
        if rules.is_station[network.body[network.landing[leg]]]:
            left, tank = rules.budget, []
    return []
