"""Proof by rounds: bound and incumbent are brought together.

The room shared by the Lagrangian bound, by the exact method and by ``auto``. One round has two
parts. Multipliers of "each target at most once" are moved so that the best walk of the
time-expanded network is worth little (:mod:`solvers.walks.walks`). Then plans worth a little
less than the bound are asked for (:mod:`solvers.labels.label_search`): if there are none, the bound
comes down; if the answer is a plan, it is a better incumbent. Every value on the way is a valid
bound and the least is kept; the trivial one is the sum of all prizes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from contextlib import closing, suppress
from dataclasses import dataclass

import numpy as np

from adr_opt.common.options import MOST_JOBS, Options, option
from adr_opt.common.processors import usable_cores
from adr_opt.common.progress import Progress
from adr_opt.common.stop import Stop, TimeIsOver
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result

from ..labels.label_search import LabelSearch
from ..labels.waiting import bytes_each
from ..networks.evidence import evidence_of
from ..progress.cost_rounds import settled
from ..progress.gap import GapTracker
from ..progress.proof_size import fits_memory, proof_notes, set_up_s
from ..walks.floors import floor_evidence
from ..walks.latest_times import Latest, latest_of
from ..walks.multipliers import Descent
from ..walks.walks import WalkBound
from .cost import CostProof
from .large_proof import LargeProof

COARSER = 2.5
"""Width of ΔV slots while multipliers are sought, as a multiple of that for labels."""

SMALL = 1e-3
"""Share of the largest prize below which multipliers are dropped rather than halved."""

FIRST_EVALUATIONS, FIRST_LABELS = 3, 1_000_000
"""Effort of the first round: evaluations of the bound, and labels of a search."""

GROWTH = 4
"""Growth of the maximum number of labels per round."""

MOST_LABELS = f"Maximum number of labels in one search, about {bytes_each()} bytes each."
"""Meaning of the option of this name."""


@dataclass(frozen=True)
class ProofOptions(Options):
    """Options of the methods that prove by rounds."""

    jobs: int = option(
        0, "Number of cores, 0 for all. No effect on the result.", least=0, most=MOST_JOBS
    )
    delta_v_slot_m_s: float = option(
        20.0, "Slot of ΔV: finer slots give a tighter bound and take longer.", unit="m/s", above=0.0
    )
    most_labels: int = option(8_000_000, MOST_LABELS, least=1)

    @property
    def cores(self) -> int:
        """Number of cores."""
        return self.jobs or usable_cores()


class Proof:
    """Rounds of bounding and search for one mission.

    Parameters
    ----------
    mission : Mission
    certificate : GapTracker
        Told of every bound and plan; asked for the incumbent.
    stop : Stop
        Its time alone counts here: a round is broken off when none is left.
    options : ProofOptions

    Attributes
    ----------
    done : bool
        Nothing is left to do: proven, or out of labels.
    latest : Latest or None
        What guides a search for better plans, once the first sweep is done.
    """

    def __init__(
        self, mission: Mission, certificate: GapTracker, stop: Stop, options: ProofOptions
    ) -> None:
        self._certificate = certificate
        self._options = options
        self._over = lambda: stop.remaining_s() <= 0.0
        self._bound = WalkBound(
            mission, COARSER * options.delta_v_slot_m_s, jobs=options.cores, over=self._over
        )
        self._fine: WalkBound | None = None
        self._routes: LabelSearch | None = None
        self._descent = Descent(self._bound)
        self._evaluations = FIRST_EVALUATIONS
        self._labels = min(FIRST_LABELS, options.most_labels)
        self._plain: bool | None = None  # whether searches have no multipliers
        self.latest: Latest | None = None
        self._first = math.inf  # the bound without multipliers
        self._mission = mission
        self.done = certificate.proven

    def begin(self) -> None:
        """The first sweep: a first bound, and guidance for a search."""
        with suppress(TimeIsOver):
            self._step()

    def _step(self) -> None:
        """One evaluation of the bound."""
        descent = self._descent
        value = descent.step()
        if descent.evaluations == 1:
            self._first = value
        self._lower_by_walks(descent.value, descent.multipliers, self._bound)
        if self.latest is None and math.isfinite(value):
            self.latest = latest_of(self._bound, self._mission, descent.multipliers, value)

    def _lower_by_walks(self, value: float, multipliers: np.ndarray, bound: WalkBound) -> None:
        """Lower the bound to one proven by walks without memory."""
        most = value - math.fsum(multipliers) + self._mission.bound_guard
        evidence = evidence_of(multipliers, [(0,)], [most], None, bound.slot)
        self._certificate.lower(value, evidence)

    def advance(self, enough: Callable[[], bool]) -> None:
        """One round, with more effort than the one before.

        Parameters
        ----------
        enough : callable
            Asked at every evaluation and every few labels; the round is left when it says so.
        """
        with suppress(TimeIsOver):
            self._round(enough)

    def _round(self, enough: Callable[[], bool]) -> None:
        certificate, descent = self._certificate, self._descent
        for _ in range(self._evaluations):
            if descent.done or certificate.proven or enough():
                break
            self._step()
        if certificate.proven:
            self.done = True
            return
        if enough():
            return
        before = certificate.bound
        nothing_left = self._search(enough)
        self.done = (
            nothing_left
            or certificate.proven
            or (self._labels == self._options.most_labels and descent.done and not enough())
        )
        self._evaluations *= 2
        # Where multipliers are what is lacking, more labels are no help.
        if self._plain or descent.done or certificate.bound < before:
            self._labels = min(GROWTH * self._labels, self._options.most_labels)

    def _search(self, enough: Callable[[], bool]) -> bool:
        """Search for plans above decreasing thresholds until one is found or labels run out.

        The first time with the multipliers of the best bound and with none, since neither is always
        better: without, many labels are worth the same, and more of them dominate one another. Then
        with those that went further.

        Returns
        -------
        done : bool
            There is nothing left to ask for.
        """
        if self._routes is None:
            self._fine = WalkBound(
                self._mission,
                self._options.delta_v_slot_m_s,
                jobs=self._options.cores,
                over=self._over,
                network=self._bound.network,
            )
            self._routes = LabelSearch(self._fine)
        none = np.zeros(self._mission.rules.prize.size)
        if self._plain is not None:
            return self._ask(none if self._plain else self._descent.multipliers, enough)[0]
        done, *without = self._ask(none, enough)
        if done or self._certificate.proven or enough():
            return done
        step = self._mission.prize_step
        self._plain = bool(step) and (
            self._mission.rounded_down(self._first)
            <= self._mission.rounded_down(self._descent.value)
        )
        if not self._plain:
            done, *given = self._ask(self._descent.multipliers, enough)
            self._plain = without < given
        return done

    def _ask(
        self, multipliers: np.ndarray, enough: Callable[[], bool]
    ) -> tuple[bool, float, float]:
        """Search with some multipliers; returns: done, least unreachable threshold, labels."""
        certificate, routes, fine = self._certificate, self._routes, self._fine
        assert routes is not None
        assert fine is not None
        value = routes.use(multipliers)
        self._lower_by_walks(value, routes.multipliers, fine)
        least, took = math.inf, math.inf
        while not certificate.proven:
            threshold, before = certificate.threshold, routes.labels_made
            remembered, used = routes.neighbourhood.copy(), routes.multipliers
            finished, value, plan, grown = routes.search(threshold, self._labels, enough)
            if not finished:
                return False, least, took
            if value < threshold:
                least, took = threshold, routes.labels_made - before
            if plan is not None:
                certificate.offer(plan)
            # Every plan left out of the search is worth less than the threshold.
            most = threshold - routes.total + self._mission.threshold_guard
            if value >= threshold:
                most = value - routes.total + self._mission.bound_guard
            evidence = evidence_of(used, [(0,)], [most], [remembered], fine.slot)
            certificate.lower(max(value, threshold), evidence)
            if certificate.proven or enough():
                return certificate.proven, least, took
            if value >= threshold and grown == 0:
                if not multipliers.any():
                    return True, least, took
                # Plans reach the threshold only by multipliers of targets that they leave out.
                small = SMALL * routes.greatest_prize
                multipliers = np.where(multipliers > small, 0.5 * multipliers, 0.0)
                routes.use(multipliers)
        return True, least, took

    @property
    def counters(self) -> dict[str, float]:
        """Work counters."""
        return {
            "delta_v_slot_m_s": (self._fine or self._bound).slot,
            "evaluations": self._descent.evaluations,
            "searches": self._routes.searches if self._routes else 0,
            "labels": self._routes.labels_made if self._routes else 0,
        }

    def close(self) -> None:
        """End the threads."""
        self._bound.close()
        if self._fine is not None:
            self._fine.close()


def proof_of(
    mission: Mission,
    certificate: GapTracker,
    stop: Stop,
    options: ProofOptions,
    least_s: float = 0.0,
    set_ups: float = 1.0,
) -> Proof | LargeProof | None:
    """The proof that fits in memory; None if there is no time to set it up.

    Parameters
    ----------
    mission, certificate, stop, options
        As :class:`Proof` takes them.
    least_s, set_ups : float
        Least remaining time: absolute [s], and as a multiple of the set-up time.
    """
    if not fits_memory(mission):
        return LargeProof(mission, certificate, stop, options.cores)
    if stop.remaining_s() < max(least_s, set_ups * set_up_s(mission)):
        return None
    try:
        return Proof(mission, certificate, stop, options)
    except TimeIsOver:
        return None


def prove(
    mission: Mission,
    certificate: GapTracker,
    stop: Stop,
    enough: Callable[[], bool],
    options: ProofOptions,
    *,
    search: Callable[[Latest], None] = lambda latest: None,
) -> dict[str, float]:
    """Run rounds of proof until finished or stopped; returns the counters.

    Parameters
    ----------
    mission, certificate, stop, options
        As :class:`Proof` takes them.
    enough : callable
        Asked once per iteration.
    search : callable
        Looks for a better plan before each round.
    """
    if certificate.proven or enough():
        return {"evaluations": 0, "searches": 0, "labels": 0}
    proof = proof_of(mission, certificate, stop, options)
    if proof is None:
        certificate.lower(*floor_evidence(mission))
        return {"evaluations": 0, "searches": 0, "labels": 0}
    with closing(proof):
        proof.begin()
        while not proof.done and not enough():
            if proof.latest is not None and not certificate.proven:
                search(proof.latest)
            proof.advance(enough)
    return proof.counters


def prove_cost(
    mission: Mission,
    certificate: GapTracker,
    stop: Stop,
    enough: Callable[[], bool],
    options: ProofOptions,
) -> tuple[float, dict[str, float]]:
    """Prove a lower bound on the ΔV of plans with at least the incumbent's worth.

    Parameters
    ----------
    mission, certificate, stop, options
        As :class:`Proof` takes them.
    enough : callable
        Asked once a round.

    Returns
    -------
    bound : float
        [m/s]
    counters : dict
    """

    def over() -> bool:
        return stop.remaining_s() <= 0.0

    if stop.remaining_s() < set_up_s(mission) or not fits_memory(mission):
        return 0.0, {}
    try:
        proof = CostProof(
            mission,
            certificate.incumbent,
            certificate.offer,
            lambda: certificate.cost,
            over,
            jobs=options.cores,
            delta_v_slot_m_s=options.delta_v_slot_m_s,
            most_labels=options.most_labels,
        )
    except TimeIsOver:
        return 0.0, {}
    bound, counters = settled(proof, enough)
    if mission.falls is None:  # what is lost has been looked ahead for, and `verify` does not
        certificate.cost_evidence = proof.evidence
    return bound, counters


def bounded(
    method: str,
    mission: Mission,
    stop: Stop,
    progress: Progress,
    *,
    seed: int,
    start: Iterable[int] | None,
    options: ProofOptions,
) -> Result:
    """Result of a bound that consists of rounds of proof, optionally from a start plan."""
    certificate = GapTracker(mission, progress)
    if start is not None:
        certificate.offer(start)

    def enough() -> bool:
        return stop(certificate.incumbent, certificate.bound)

    counters = prove(mission, certificate, stop, enough, options)
    return certificate.result(method, seed=seed, counters=counters, notes=proof_notes(mission))
