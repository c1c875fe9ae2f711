"""The course of a proof by a solver for networks, the same for every solver."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Iterable
from typing import Protocol

import numpy as np

from adr_opt.errors import InputError
from adr_opt.kernels.constants import STATION
from adr_opt.mission import Mission
from adr_opt.planner import Progress, silent
from adr_opt.result import Result, certify
from adr_opt.stop import Stop

from ..greedy import greedy_guarded
from ..multipliers import Descent
from ..proof import bound_notes
from ..walks import WalkBound
from .answer import Answer, Hear
from .network import Network, keep, path_of, unroll
from .reduction import affordable_slot, best_through, can_reach
from .standing import Standing

WHOLE_ARCS = 2_000
"""Up to so many arcs the network is solved whole: no bound but the solver's has a part in it."""

SHARE = 0.3
"""Part of the time left that multipliers may take."""

SLOT_M_S = 20.0
ROOM_BYTES = 1.5e9
"""ΔV slots of the multipliers' bound, and memory it may take; slots are widened to fit."""


class Model(Protocol):
    """A network written for a solver."""

    def solve(self, *, seed: int, hear: Hear) -> Answer:
        """Solve it, or as much as the time allows."""
        ...

    def forbid(self, arcs: list[int]) -> None:
        """Let no path use all of these arcs, from the next solve on."""
        ...


MakeModel = Callable[[Network, np.ndarray, float, float, list[int]], Model]
"""Network, prizes, unit of the objective, budget [m/s], arcs of a plan to begin from."""


def prove(
    method: str,
    make_model: MakeModel,
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[int] | None,
    jobs: int,
    most_arcs: int,
    evaluations: int,
) -> Result:
    """Prove how much the best plan is worth.

    A small network is solved whole. From a larger one, arcs are dropped that no plan worth a goal
    can use; the goal is a little below the bound and above the incumbent. If the solver finds such
    a plan, it is the best one there is; if it proves that there is none, every plan is worth less
    than the goal, the bound comes down, and the next goal is set.

    Parameters
    ----------
    method : str
        Name of the method.
    make_model : callable
        Writes a network for the solver.
    mission, seed, stop, progress, start
        As for any planner. Without a start, the guarded greedy planner gives one.
    jobs : int
        Threads for the multipliers, 0 for all cores.
    most_arcs : int
        Larger networks are not handed to the solver.
    evaluations : int
        Most evaluations of the multipliers' bound.

    Raises
    ------
    InputError
        An option is out of range.
    """
    for name, value, least in (
        ("jobs", jobs, 0),
        ("most_arcs", most_arcs, 1),
        ("evaluations", evaluations, 1),
    ):
        if value < least:
            raise InputError(f"option {name} = {value} of method {method!r}: must be ≥ {least}")
    began = time.perf_counter()
    course = _Course(mission, make_model, Standing(mission, stop, progress), seed)
    standing = course.standing
    if start is None:
        found = greedy_guarded(mission, seed=seed, stop=stop, progress=silent)
        start = found.sequence or ()
    course.start = tuple(int(j) for j in start)
    standing.offer(course.start)
    if not standing.enough():
        course.run(jobs, most_arcs, evaluations)
        if not (standing.proven or course.notes or standing.remaining_s() <= 0.0):
            course.notes.append(
                f"the solver cannot tell the bound of {standing.bound:g} from the plan within its "
                "tolerances: other proving methods may"
            )
    return certify(
        mission,
        method,
        standing.sequence,
        seed=seed,
        runtime_s=time.perf_counter() - began,
        upper_bound=standing.bound,
        counters=course.counters,
        notes=[*course.notes, *bound_notes(mission)],
    )


class _Course:
    """One proof."""

    def __init__(
        self, mission: Mission, make_model: MakeModel, standing: Standing, seed: int
    ) -> None:
        self._mission = mission
        self._make_model = make_model
        self._seed = seed
        self._prize = np.array(mission.rules.prize)
        self.standing = standing
        self.start: tuple[int, ...] = ()
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

    def run(self, jobs: int, most_arcs: int, evaluations: int) -> None:
        """Work until the incumbent meets the bound, or as far as size and time allow."""
        standing, budget = self.standing, self._mission.rules.budget
        network = unroll(self._mission.rules)
        self.counters |= {"network_nodes": network.nodes, "network_arcs": network.arcs}
        if network.arcs <= min(WHOLE_ARCS, most_arcs):
            self._solve(network, -math.inf)
            return
        multipliers = self._multipliers(jobs, evaluations)
        if standing.enough():
            return
        slot = affordable_slot(network, budget)
        through = best_through(network, self._prize, multipliers, budget, slot)
        standing.lower(float(through.max(initial=0.0)))
        while not standing.enough():
            goal = standing.goal
            part = keep(network, can_reach(through, goal))
            finer = affordable_slot(part, budget)
            if part.arcs and finer < slot:
                again = best_through(part, self._prize, multipliers, budget, finer)
                part = keep(part, can_reach(again, goal))
            if part.arcs > most_arcs:
                self.notes.append(
                    f"{part.arcs} arcs may belong to a plan worth {goal:g}, which is more than "
                    f"most_arcs = {most_arcs}: they were not handed to the solver"
                )
                return
            before = standing.bound
            self._solve(part, goal)
            if standing.bound >= before:
                return

    def _multipliers(self, jobs: int, evaluations: int) -> np.ndarray:
        """Multipliers for which the best walk is worth little; lowers the bound."""
        standing = self.standing
        slot, budget = SLOT_M_S, self._mission.rules.budget
        events = self._mission.timetable.entries + len(self._mission.names)
        while slot < budget and 8.0 * events * (budget / slot + 16.0) > ROOM_BYTES:
            slot *= 2.0
        end = time.monotonic() + SHARE * standing.remaining_s()
        bound = WalkBound(self._mission, slot, jobs or os.cpu_count() or 1)
        try:
            descent = Descent(bound)
            while descent.evaluations < evaluations and not descent.done:
                descent.step()
                standing.lower(descent.value)
                if standing.enough() or time.monotonic() > end:
                    break
        finally:
            bound.close()
        self.counters["evaluations"] = descent.evaluations
        return descent.multipliers

    def _solve(self, network: Network, goal: float) -> None:
        """Hand a network to the solver that holds every plan worth a goal."""
        standing = self.standing
        rest = standing.under(goal)
        answer = Answer((), 0.0, 0)
        if network.arcs:
            self.counters["solves"] += 1
            self.counters["solved_arcs"] = network.arcs
            known = path_of(network, standing.sequence or ())
            unit = standing.step or float(self._prize.max())
            model = self._make_model(network, self._prize, unit, self._mission.rules.budget, known)

            def hear(bound: float) -> bool:
                standing.lower(max(bound, rest))
                return standing.remaining_s() <= 0.0

            while True:
                answer = model.solve(seed=self._seed, hear=Hear(hear, standing.remaining_s))
                self.counters["solver_nodes"] += answer.nodes
                too_dear = self._too_dear(network, answer.sequence or ())
                if not too_dear or standing.remaining_s() <= 0.0:
                    break
                # Within the solver's tolerances it fits the tank. There are few such paths.
                model.forbid(too_dear)
                self.counters["forbidden"] += 1
        if answer.sequence is not None:
            standing.offer(answer.sequence)
        standing.lower(max(answer.upper_bound, rest))

    def _too_dear(self, network: Network, sequence: tuple[int, ...]) -> list[int]:
        """The arcs of a path's first tank that does not reach; none if the path is a plan."""
        made = self._mission.time(sequence).made
        if made == len(sequence):
            return []
        full = max((place + 1 for place in range(made) if sequence[place] == STATION), default=0)
        return path_of(network, sequence)[full : made + 1]
