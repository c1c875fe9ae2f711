"""Planning for one chaser: rounds of beams, ruin and recreate, annealing, and a proof."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import partial

import numpy as np

from adr_opt.common.progress import Progress
from adr_opt.common.stop import Clock, Stop
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.mission.result import Result

from ..beams.beams import usual_settings, with_time_value
from ..beams.greedy_order import guarded_sequence
from ..beams.timely_beams import Beams, first_width, pilots
from ..beams.varied_beams import recreate, varied
from ..orders.string_removal import Strings, strings_of
from ..progress.gap import GapTracker
from ..progress.incumbent import Incumbent
from ..progress.proof_size import proof_notes
from ..proof.concurrent_proof import LEAST_PROOF_S, LEAST_SET_UPS, ConcurrentProof
from ..proof.large_proof import LargeProof
from ..proof.proof import Proof, ProofOptions, proof_of
from ..routes.engine_rounds import EngineRounds
from ..walks.latest_times import Latest
from .label_setting import least_cost
from .options import AutoOptions
from .rounds import Task, run

Prover = ConcurrentProof[Proof | LargeProof]

USUAL_WIDTH = 2000
"""Width of the first beam, that of the ``beam`` planner."""

VARIED_WIDTH = 1000
"""Width of the first varied beam."""

UNHURRIED = 0.25
"""Share of the remaining time for the first beam alongside a proof."""

MOST_GUIDED = 16
"""Maximum number of guided beams per round."""

WIDEST = 30_000

ASKING = 0.1
"""Share of the usual widths if rows are computed on demand."""

USUAL_TARGETS = 50
"""Number of targets for which these widths are meant; larger fields get narrower beams."""

ANNEALINGS = 8
"""Number of annealings in the first round where planes drift."""

FIRST_ANNEALINGS = 2
"""Number of annealings before any wide beam."""

PROVING_ROUNDS = 4
"""After the second round, if planes drift and a proof has no bound yet, it continues in one round
of this many; in the others, a second order is annealed instead."""

FRUITLESS = 6
"""Number of fruitless annealings from one plan before another plan is chosen."""


class RouteSearches:
    """The searching half: beams, and ruin and recreate.

    Parameters
    ----------
    mission : Mission
    seed : int
    stop : Stop
        Its time alone counts here.
    certificate : GapTracker
    engine : EngineRounds
        Searches in place of all but guided beams, where arrivals are all that matters.
    """

    def __init__(
        self, mission: Mission, seed: int, stop: Stop, certificate: GapTracker, engine: EngineRounds
    ) -> None:
        self._engine = engine
        self._mission = mission
        self._stop = stop
        self._certificate = certificate
        self._rng = np.random.default_rng(seed)
        self._beams, self._beams_apart = Beams(mission, stop), Beams(mission, stop)
        self._widest = 0
        self._strings: Strings | None = None
        self._too_large = False
        self._fruitless = 0
        self._beside: Strings | None = None
        self._found = Incumbent(mission)
        self.counters = {"beams": 0, "recreations": 0}
        if self.drifts:
            self.counters["annealings"] = 0
        targets = max(1, len(mission.instance.targets))
        self._asks = mission.timetable.is_on_demand
        # Large fields get narrower beams, so that a round takes about as long on all of them. Where
        # rows are worked out on demand all beams look at as many destinations, but dearer ones.
        self._scale = ASKING if self._asks else min(1.0, (USUAL_TARGETS / targets) ** 2)
        self._usual = first_width(mission, USUAL_WIDTH)
        # An annealing of few targets is as good after a few: the proof is not to wait for others.
        share = min(1.0, (targets / USUAL_TARGETS) ** 2)
        self._width, self._recreations = VARIED_WIDTH, 20
        self._annealings = max(2, round(share * ANNEALINGS))

    @property
    def drifts(self) -> bool:
        """Whether planes drift enough for annealing orders, which takes memory."""
        return self._mission.instance.transfer.may_drift

    def needed_s(self, width: int) -> float:
        """Expected time of a beam [s]."""
        return self._beams.needed_s(width)

    def usual_width(self, width: int) -> int:
        """A width up to this one whose beam leaves most of the time for others."""
        needed_s, allowed_s = self.needed_s(width), UNHURRIED * self._stop.remaining_s()
        if needed_s <= max(allowed_s, 0.0):
            return width
        return max(1, int(width * max(allowed_s, 0.0) / needed_s))

    def scaled(self, width: int) -> int:
        """A width adapted to the size of the field."""
        least = max(10, int(self._scale * width))
        return self.usual_width(least) if self._asks else least

    def begin(self, prover: Prover | None, cores: int) -> None:
        """Before the first round: the fastest beams, and a first bound."""
        certificate, stop = self._certificate, self._stop

        def is_over() -> bool:
            return certificate.proven or stop(certificate.incumbent, certificate.bound)

        if self._asks and prover is not None and not is_over():
            prover.advance()  # only beginning takes no time, and beams may take all of it
            prover.deliver()
        if self._engine.serves:
            if self._certificate.routes is None:
                self._engine.at_first()
            return
        for width in pilots(self._mission):
            if not is_over():
                self.usual(self.usual_width(width))
        # It finds more in less time than wider beams do, but its table takes longer than a pilot.
        if not self._asks:
            self.anneal(FIRST_ANNEALINGS)
        # Beside a proof a beam is slower, so where time is short it comes before; on one core the
        # proof would come before it, and take what there is.
        short = cores == 1 or self.needed_s(self._usual) > UNHURRIED * stop.remaining_s()
        if short and not certificate.proven:
            self.usual(self._usual)

    def _is_unbounded(self, rounds: int) -> bool:
        """Whether nothing is proven so far, nor likely to be in the next rounds."""
        bound = self._certificate.bound
        return self.drifts and bound >= self._mission.total_worth and rounds > 2

    def beside(self, prover: Prover | None, rounds: int) -> Task | None:
        """The proof or, if it has made little progress, a second order to anneal."""
        task: Task | None = None
        anneals = partial(self.part, self._annealings)
        if prover is not None and not prover.done:
            task = prover.advance
            is_turn = rounds % PROVING_ROUNDS != 1
            if self._is_unbounded(rounds) and is_turn and self.may_part():
                task = anneals
        elif self.may_part():
            task = anneals
        if self._asks:
            task = _one_after_another(task, self.apart(self.scaled(self._width)))
        return task

    def advance(self, prover: Prover | None, rounds: int) -> None:
        """One round of all searches."""
        knows = prover is not None and rounds > 1 and not self._is_unbounded(rounds)
        proof = prover.proof if prover is not None and knows else None
        if proof is not None and proof.latest is not None:
            self.guided(proof.latest, min(2**rounds, MOST_GUIDED))
        if self._engine.serves:
            self._engine.until(most=1)
            return
        if proof is None or proof.latest is None:
            self.usual(max(self._usual, self.scaled(self._width)))
        self.varied(self.scaled(self._width))
        self.anneal(self._annealings, restarts=rounds > 1)
        self.improve(self._recreations, self.scaled(self._width // 20))

    def usual(self, width: int) -> None:
        """Search one beam with the usual settings, unless done before at this width."""
        if width > self._widest:
            self._widest = width
            self.beam(width)

    def guided(self, latest: Latest, beams: int) -> None:
        """Search some beams guided by the latest times from a proof."""
        for _ in range(beams):
            if self._certificate.proven:
                break
            self.varied(USUAL_WIDTH, latest)

    def beam(self, width: int) -> None:
        """Search one beam with the usual settings."""
        if self._stop.remaining_s() <= 0.0:
            return
        self._certificate.offer(self._beams.search(usual_settings(self._mission, width)))
        self.counters["beams"] += 1

    def varied(self, width: int, latest: Latest | None = None) -> None:
        """Search one beam with settings varied around the usual ones."""
        # The draws do not depend on the clock, so that time limits do not shift them.
        mission, settings, seed = varied(self._mission, width, self._rng)
        if self._stop.remaining_s() <= 0.0:
            return
        if latest is not None:
            latest = latest._replace(goal=self._certificate.goal)
        found = self._beams.search(settings, guide=latest, seed=seed, mission=mission)
        self._certificate.offer(found)
        self.counters["beams"] += 1

    def anneal(self, annealings: int, *, restarts: bool = False) -> None:
        """Anneal an order repeatedly where planes drift, until several in a row have failed.

        With ``restarts`` another order is then annealed instead.
        """
        if not (self.drifts and self._mission.total_worth > 0.0):
            return
        if self._strings is None and not self._too_large and self._stop.remaining_s() > 0.0:
            seed = int(self._rng.integers(2**31))
            begun = self._certificate.sequence or ()
            self._strings = strings_of(self._mission, seed, self._stop, begun)
            self._too_large = self._strings is None
        if self._strings is None or self._certificate.proven or self._stop.remaining_s() <= 0.0:
            return
        before = self._certificate.incumbent
        for annealed in self._strings.annealings(annealings):
            self._certificate.offer(annealed)
            self._fruitless = 0 if self._certificate.incumbent > before else self._fruitless + 1
            self.counters["annealings"] += 1
            if self._certificate.proven or self._stop.remaining_s() <= 0.0:
                break
            if self._fruitless >= FRUITLESS and not restarts:
                break
            if self._fruitless >= FRUITLESS:
                mission, settings, seed = varied(self._mission, VARIED_WIDTH, self._rng)
                found = self._beams.search(settings, seed=seed, mission=mission)
                self._certificate.offer(found)
                self.counters["beams"] += 1
                self._strings.begin(found)
                self._fruitless = 0
            before = self._certificate.incumbent

    def may_part(self) -> bool:
        """Prepare a second annealing; returns whether there is an order for it."""
        if self._strings is None:
            return False
        if self._beside is None:
            self._beside = self._strings.beside(int(self._rng.integers(2**31)))
        if self._certificate.incumbent > self._found.objective:
            self._beside.begin(self._certificate.sequence or ())
            self._found.offer(self._certificate.sequence or ())
        return True

    def part(self, annealings: int) -> None:
        """Anneal a second order in a concurrent thread; :meth:`meet` collects the result."""
        if self._beside is None or self._stop.remaining_s() <= 0.0:
            return
        for annealed in self._beside.annealings(annealings):
            self._found.offer(annealed)
            if self._stop.remaining_s() <= 0.0:
                break

    def apart(self, width: int) -> Task:
        """A random varied beam to search in a thread; :meth:`meet` collects the result."""
        mission, settings, seed = varied(self._mission, width, self._rng)
        self.counters["beams"] += 1

        def search() -> None:
            if self._stop.remaining_s() > 0.0:
                self._found.offer(self._beams_apart.search(settings, seed=seed, mission=mission))

        return search

    def meet(self, prover: Prover | None) -> None:
        """Collect results of threads, and increase the effort of the next round."""
        if self._found.sequence is not None:
            self._certificate.offer(self._found.sequence)
        self._width = min(2 * self._width, WIDEST)
        self._recreations *= 2
        self._annealings *= 2

    def improve(self, recreations: int, width: int) -> None:
        """Ruin and recreate the incumbent."""
        rng = np.random.default_rng(int(self._rng.integers(2**31)))
        for _ in range(recreations):
            if self._stop.remaining_s() <= 0.0:
                break
            found = recreate(
                self._mission, self._certificate.sequence or (), width, rng, self._stop
            )
            self._certificate.offer(found)
            self.counters["recreations"] += 1


def _prover(mission: Mission, certificate: GapTracker, stop: Stop, options: ProofOptions) -> Prover:
    """The proving half."""
    own = GapTracker(mission, certificate.tell)
    return ConcurrentProof(
        certificate,
        own,
        stop,
        lambda: proof_of(mission, own, stop, options, LEAST_PROOF_S, LEAST_SET_UPS),
    )


def _one_after_another(first: Task | None, then: Task) -> Task:
    """A task that runs two tasks in sequence."""

    def both() -> None:
        if first is not None:
            first()
        then()

    return both


def plan(
    method: str,
    problem: Problem,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[Iterable[int]] | None,
    options: AutoOptions,
) -> Result:
    """The best plan of one chaser within the time, with a proof if one is found.

    Begins with the guarded greedy plan, a few annealings of its order where planes drift or costs
    are given, and the searches of ``beam``. Then rounds: one of proof
    (:class:`solvers.proof.proof.Proof`: it bounds the objective, and its searches for plans
    worth more than the incumbent are exhaustive, so they find what beams miss) side by side with
    wider beams, with ruin-and-recreate and, where planes drift or costs are given, with annealing
    of orders. Where orders are annealed and a search has proven nothing, a second order is annealed
    in most rounds in place of the proof.

    Parameters
    ----------
    method : str
        Whose result it is.
    problem : Problem
        With a mission that is :attr:`~.Problem.alone`.
    seed, stop, progress, start, options
        As planners take them.
    """
    given = problem.alone
    assert given is not None
    mission = with_time_value(given, options.time_value_m_s_per_h)
    certificate = GapTracker(mission, progress)
    engine = EngineRounds(problem, certificate, seed, Clock(stop), options.cores)
    search = RouteSearches(mission, seed, stop, certificate, engine)
    if not engine.serves:
        certificate.offer(guarded_sequence(given))
    if start is not None:
        certificate.offer(*start)
    prover = _prover(mission, certificate, stop, options) if options.goals.proves else None
    search.begin(prover, options.cores)
    rounds = run(certificate, search, prover, stop=stop, cores=options.cores)
    counters: dict[str, float] = {**(engine.counters if engine.serves else {}), **search.counters}
    counters["rounds"] = rounds
    if prover is not None:
        counters |= prover.counters
    cost_bound = None
    if options.goals.cost:
        cost_bound, counted = least_cost(
            method, given, certificate, stop, seed=seed, options=options, by_rounds=True
        )
        counters |= counted
    stated = certificate.stated
    return certificate.result(
        method,
        seed=seed,
        counters=counters,
        upper_bound=stated,
        cost_bound=cost_bound,
        notes=proof_notes(mission) if math.isfinite(stated) else (),
    )
