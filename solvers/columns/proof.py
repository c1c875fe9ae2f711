"""Column generation: the upper bound of a campaign, lowered round by round.

Master and pricing in turn (Desrosiers and Lübbecke 2005). The master mixes known routes; its duals
are multipliers, for which beams, and where they find nothing labels, look for routes worth more
than they cost. The labels are those of one chaser's proofs (:mod:`solvers.labels.extension`), so
routes are exact in time and ΔV, and relaxed only in that walks may repeat what they have forgotten
(ng-routes: Baldacci, Mingozzi and Roberti 2011). With any multipliers

    prizes collected ≤ Σ π + Σ over chasers of the most that a route is worth, less multipliers:

that is the bound, whether or not the master is solved. Multipliers between the best ones so far and
the master's duals make it come down sooner (Wentges 1997). Before all that, a descent with the
walks of :mod:`.bound` tells where to begin; and where the master is solved and a gap is left, cuts
that its mixture violates (:mod:`.subset_rows`) join both sides of the bound.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import NamedTuple

import numpy as np

from adr_opt.common.stop import Stop, TimeIsOver
from adr_opt.mission.evidence import Evidence
from adr_opt.mission.problem import Problem

from ..networks.evidence import evidence_of
from ..progress.gap import GapTracker
from ..proof.proof import COARSER, FIRST_LABELS, GROWTH, ProofOptions
from ..routes.route_pool import Column, Key, RoutePool, dealt
from ..walks.multipliers import Descent
from ..walks.walks import WalkBound
from .bound import CampaignBound
from .master import Duals, Master
from .pricing import LabelPricing, by_beam
from .route_enumeration import EnumerationAnswer, Finish
from .subset_rows import WHOLE, SubsetRows

DESCENT = 30
"""Number of evaluations of walks before the first columns."""

BEAMS = 8
"""Number of beams of each chaser type before labels are set."""

CENTRED = 0.6
"""Weight of the best multipliers against the master's duals (stabilisation)."""

ATTRACTIVE = 1e-4
"""Least reduced worth of a useful route, as a share of the largest prize."""

ENDS = 0.99
"""Share of a step above the incumbent at which a bound ends the proof."""

LOWERED = 0.25
"""Share of the distance between bound and master that one lowering of the bound leaves."""

NEAR, SOLVED = 0.01, 0.001
"""Distances of the bound from the master at which cuts are added and at which it counts as solved,
as shares of the largest prize."""

MOST_GIVEN_UP = 4
"""Number of failed searches with the maximum number of labels that ends the proof."""

MOST_CUTS = 400
"""Number of cuts beyond which none is added."""

MANY_STEPS = 4.0
"""Number of steps between bound and master beyond which the bound is lowered in parts: ending the
proof at once needs all routes of slightly negative reduced worth."""

ITERATIONS, LABELS = 6, 1_000_000
"""Iterations of column generation per round, and number of labels after which none begins in it."""


class Multipliers(NamedTuple):
    """Multipliers of a bound.

    Attributes
    ----------
    targets : (bodies,) float64
    cuts : (cuts,) float64
    """

    targets: np.ndarray
    cuts: np.ndarray


class PricedRoutes(NamedTuple):
    """Multipliers, the largest reduced worth of routes of each kind, and the resulting bound."""

    multipliers: Multipliers
    most_worth: np.ndarray
    bound: float


class ColumnProof:
    """Rounds of column generation for one campaign.

    Parameters
    ----------
    problem : Problem
    certificate : GapTracker
        Told of every bound, and asked for the incumbent.
    pool : RoutePool
        Of routes; added to.
    seed : int
    stop : Stop
        Its time alone counts here.
    options : ProofOptions

    Attributes
    ----------
    done : bool
        Nothing is left to do: proven, or the master is solved and proves no more.
    """

    def __init__(
        self,
        problem: Problem,
        certificate: GapTracker,
        pool: RoutePool,
        seed: int,
        stop: Stop,
        options: ProofOptions,
    ) -> None:
        self._problem, self._certificate, self._pool = problem, certificate, pool
        self._options, self._stop = options, stop
        self._rng = np.random.default_rng(seed)
        self._over = lambda: stop.remaining_s() <= 0.0
        self._coarse = CampaignBound(
            problem,
            COARSER * options.delta_v_slot_m_s,
            jobs=options.cores,
            over=self._over,
            kind=WalkBound,
        )
        self._descent = Descent(self._coarse)
        self._pricing: tuple[LabelPricing, ...] = ()
        self._fine: CampaignBound[WalkBound] | None = None
        self._master = Master(problem)
        self._mixed: set[tuple[Key, float]] = set()  # and worths, which may be improved
        self._guard = problem.bound_guard / len(problem.missions)
        self._counts = [len(kind.chasers) for kind in problem.kinds]
        self._cuts = SubsetRows()
        self._centre = Multipliers(np.zeros(len(problem.names)), np.empty(0))
        self._centred = CENTRED
        self._least = math.inf  # the bound at the centre
        self._labels = min(FIRST_LABELS, options.most_labels)
        self._largest = float(problem.planning_prizes.max(initial=0.0)) or 1.0
        self._columns = 0
        self._priced: PricedRoutes | None = None
        self._finishing_labels = self._given_up = 0
        self.done = certificate.proven

    def begin(self) -> None:
        """The descent: a first bound with its multipliers."""
        with suppress(TimeIsOver):
            for _ in range(DESCENT):
                if self._descent.done or self._certificate.proven or self._over():
                    break
                self._descent.step()
                self._certificate.lower(self._descent.value, self._coarse.evidence)
        self._centre = Multipliers(self._descent.multipliers, np.empty(0))
        self._least = self._descent.value
        self.done = self._certificate.proven or self._descent.value == -math.inf

    def advance(self, enough: Callable[[], bool]) -> None:
        """One round, with more effort than the previous one.

        Parameters
        ----------
        enough : callable
            Asked now and then whether to leave it.
        """
        if not self._pricing:
            self._fine = CampaignBound(
                self._problem,
                self._options.delta_v_slot_m_s,
                jobs=self._options.cores,
                over=self._over,
                kind=WalkBound,
                known=self._coarse,
            )
            self._pricing = tuple(LabelPricing(*place) for place in self._fine.of_kind)
        most = self._labels_made + LABELS
        with suppress(TimeIsOver):
            for _ in range(ITERATIONS):
                if self.done or enough() or self._labels_made > most:
                    break
                self._iterate(enough)

    def _iterate(self, enough: Callable[[], bool]) -> None:
        """Solve the master, and price missing routes."""
        self._mix()
        duals = self._master.solve()
        if self._attained(duals, NEAR) and self._cut(duals):
            return
        multipliers = self._near(duals)
        for pricing in self._pricing:
            pricing.cut(self._cuts, multipliers.cuts)
        if self._by_beams(duals, multipliers) or self._by_few_labels(duals, multipliers, enough):
            return
        new, bound = self._by_labels(duals, multipliers, enough)
        lowered = bound < self._least
        if lowered:
            self._least, self._centre = bound, multipliers
            self._certificate.lower(bound, self._evidence(multipliers))
        if math.isfinite(bound) and (self._priced is None or bound < self._priced.bound):
            most_worth = np.array([pricing.most_worth for pricing in self._pricing])
            self._priced = PricedRoutes(multipliers, most_worth, bound)
        self.done = self._certificate.proven
        if new or self.done:
            self._centred = CENTRED
        elif not math.isfinite(bound):
            # There may be more routes to mix by the next time, and fewer labels at the duals.
            self._given_up += self._labels == self._options.most_labels
            self.done = self._given_up == MOST_GIVEN_UP
            self._labels = min(GROWTH * self._labels, self._options.most_labels)
            self._approach()
        elif self._centred > 0.0:
            self._approach()
        elif (not lowered or self._attained(duals, SOLVED)) and not self._cut(duals):
            # Nothing is missing at the duals themselves: the master is solved.
            self._finish(enough)

    def _target(self, duals: Duals) -> float:
        """The bound to prove next: one that ends the proof, or nearer to the master's value."""
        certificate, value = self._certificate, duals.value
        step = certificate.next_goal - certificate.incumbent
        ends, lower = certificate.incumbent + ENDS * step, value + LOWERED * (self._least - value)
        if value < ends and self._least - value <= MANY_STEPS * step:
            return ends
        # Without a plan yet there is no end to compare with.
        return ends if lower < ends else lower

    def _attained(self, duals: Duals, near: float) -> bool:
        """Whether the bound is near the master's value, so that few routes are missing."""
        return self._least - duals.value <= near * self._largest

    def _near(self, duals: Duals) -> Multipliers:
        """Multipliers between the best so far and the master's duals."""
        share, cuts = self._centred, np.zeros(duals.cuts.size)
        cuts[: self._centre.cuts.size] = self._centre.cuts
        return Multipliers(
            share * self._centre.targets + (1.0 - share) * duals.targets,
            share * cuts + (1.0 - share) * duals.cuts,
        )

    def _approach(self) -> None:
        """Price nearer to the duals from now on."""
        self._centred = 0.0 if self._centred < 0.1 else 0.5 * self._centred

    def _cut(self, duals: Duals) -> bool:
        """Add cuts that the mixture of routes violates; returns whether there are any.

        If it mixes nothing, it is a plan.
        """
        columns, shares = self._master.columns, duals.shares
        mixed = [columns[at] for at in np.flatnonzero(shares > WHOLE)]
        if np.all(np.abs(shares - np.rint(shares)) < WHOLE):
            self._certificate.offer(
                *dealt(self._problem, [(column.kind, column.route) for column in mixed])
            )
        if self._certificate.proven or len(self._cuts.rows) >= MOST_CUTS:
            return False
        new = self._cuts.separate(columns, shares, len(self._problem.names))
        if not new:
            return False
        self._master.cut(new)
        self._centred = CENTRED
        return True

    def _evidence(self, multipliers: Multipliers) -> Evidence:
        """Evidence of a bound just proven by labels."""
        return evidence_of(
            multipliers.targets,
            [kind.chasers for kind in self._problem.kinds],
            [pricing.most_worth + self._guard for pricing in self._pricing],
            [pricing.remembered for pricing in self._pricing],
            self._options.delta_v_slot_m_s,
            self._cuts.priced(multipliers.cuts),
        )

    def _finish(self, enough: Callable[[], bool]) -> None:
        """Search for plans better than the incumbent, until there is none."""
        certificate = self._certificate
        assert self._priced is not None
        assert self._fine is not None
        multipliers, most_worth, _ = self._priced
        finish = Finish(self._problem, self._fine.of_kind)
        cuts = np.zeros(len(self._cuts.rows))
        cuts[: multipliers.cuts.size] = multipliers.cuts
        finish.cut(self._cuts.priced(cuts))
        while not certificate.proven and not enough():
            goal = certificate.next_goal
            answer, routes = finish.ask(
                goal,
                multipliers.targets,
                most_worth,
                self._options.most_labels,
                enough,
                self._stop.remaining_s,
            )
            if answer is EnumerationAnswer.NONE:
                certificate.lower(certificate.below(goal))
            if routes is None or not certificate.offer(*routes):
                break
        self._finishing_labels += finish.labels_made
        self.done = True

    def _mix(self) -> None:
        """Add new routes of the pool to the master."""
        new = [
            column
            for column in self._pool.columns()
            if (column.key, column.worth) not in self._mixed
        ]
        self._mixed.update((column.key, column.worth) for column in new)
        self._master.add(new)

    def _attracts(self, duals: Duals, column: Column) -> bool:
        """Whether a column has positive reduced worth in the master."""
        paid = column.paid(duals.targets) + self._cuts.paid(column.targets, duals.cuts)
        paid += duals.kinds[column.kind]
        return bool(column.worth - paid > ATTRACTIVE * self._largest)

    def _keep(self, duals: Duals, kind: int, route: tuple[int, ...]) -> bool:
        """Add a route to the pool; returns whether it has positive reduced worth."""
        column = self._pool.add(kind, route)
        if column is None or (column.key, column.worth) in self._mixed:
            return False
        return self._attracts(duals, column)

    def _by_beams(self, duals: Duals, multipliers: Multipliers) -> bool:
        """Whether beams find routes with positive reduced worth."""
        found = 0
        for number, kind in enumerate(self._problem.kinds):
            for _ in range(BEAMS):
                if self._over():
                    break
                route = by_beam(kind.mission, multipliers.targets, self._rng, self._stop)
                found += self._keep(duals, number, route)
        self._columns += found
        return found > 0

    def _by_few_labels(
        self, duals: Duals, multipliers: Multipliers, enough: Callable[[], bool]
    ) -> bool:
        """Whether heuristic label searches find routes with positive reduced worth."""
        found = 0
        for number, pricing in enumerate(self._pricing):
            least = float(duals.kinds[number]) + ATTRACTIVE * self._largest
            keep = partial(self._keep, duals, number)
            found += len(pricing.quickly(multipliers.targets, least, FIRST_LABELS, enough, keep))
        self._columns += found
        return found > 0

    def _by_labels(
        self, duals: Duals, multipliers: Multipliers, enough: Callable[[], bool]
    ) -> tuple[bool, float]:
        """Whether exact label searches find such routes, and their bound; +inf if they give up."""
        bound, new = self._problem.limits.total(multipliers.targets), False
        bound += math.fsum(multipliers.cuts)
        known = bound + math.fsum(self._counts * duals.kinds)
        # All routes of use are not needed, but none above what lowers the bound enough.
        above = max((self._target(duals) - known) / sum(self._counts), ATTRACTIVE * self._largest)
        for number, pricing in enumerate(self._pricing):
            paid = float(duals.kinds[number])
            finished, routes = pricing.search(
                multipliers.targets,
                paid + above,
                self._labels,
                enough,
                partial(self._keep, duals, number),
            )
            self._columns += len(routes)
            new = new or bool(routes)
            bound += self._counts[number] * pricing.most_worth if finished else math.inf
        return new, bound

    @property
    def multipliers(self) -> np.ndarray:
        """Multipliers of the best bound so far, shape (bodies,)."""
        return self._centre.targets

    @property
    def counters(self) -> dict[str, float]:
        """Work counters."""
        return {
            "evaluations": self._descent.evaluations,
            "columns": self._columns,
            "cuts": len(self._cuts.rows),
            "searches": sum(pricing.searches for pricing in self._pricing),
            "labels": self._labels_made,
        }

    @property
    def _labels_made(self) -> int:
        return self._finishing_labels + sum(pricing.labels_made for pricing in self._pricing)

    def close(self) -> None:
        """End the threads."""
        self._coarse.close()
        if self._fine is not None:
            self._fine.close()
