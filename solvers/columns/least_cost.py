"""Least cost of campaigns at equal prize: column generation over routes with costs.

With a price λ on worth, in m/s or as expenses are stated, and multipliers π of "each target at most
once", every campaign that is worth P or more costs at least

    λ P − Σ π − Σ over chasers of the most that Σ (λ worth_j − π_j) − cost comes to on a route.

The master mixes known routes at least cost; its duals are λ and π. Labels that pay for their ΔV
(:mod:`solvers.proof.cost`), under one tariff or under several that are never more than the
expense (:mod:`solvers.walks.tariffs`), find routes that it lacks, or prove how good any could
be. Cuts that the mixture violates (:mod:`.subset_rows`) join both sides, as for prizes. What is
left between the bound and the best plan is closed as there, too: all sets of targets that a cheaper
plan could be made of are listed, and set packing decides (:mod:`.cheapest_sets`).
Limits of stations are not looked at: bounds are of campaigns whose stations never run empty.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.optimize import LinearConstraint

from adr_opt.common.stop import Stop, TimeIsOver
from adr_opt.mission.evidence import CostEvidence
from adr_opt.mission.problem import Problem

from ..labels.label_search import LabelSearch as Search
from ..networks.evidence import evidence_of
from ..progress.cost_rounds import CostRounds, is_least, least_worth_of, settled
from ..progress.gap import GapTracker
from ..proof.cost import COARSER, STATED_LESS, PricedBound
from ..proof.proof import FIRST_LABELS, GROWTH, ProofOptions
from ..routes.route_pool import RoutePool, dealt
from ..routes.set_packing import cheapest_of, packing
from ..walks.tariffs import Tariff, most_expense, tariffs_of
from .bound import CampaignBound
from .cheapest_sets import CheapestSets
from .master import Duals, Master
from .pricing import LabelPricing
from .route_enumeration import MOST_ROUTES
from .subset_rows import SubsetRows

CENTRED = 0.5
"""Weight of the best prices against the master's duals (stabilisation)."""

GREATEST_TANKS = 4.0
"""Upper limit on a target's worth to a walk: if the master asks for more, multipliers grow."""

QUICK_LABELS = 200_000
"""Maximum number of labels of a heuristic search."""

LEAST_OFF = 1e-7
"""Margin below a plan's cost from which routes are sought, as a share of it, for rounding."""

ATTRACTIVE = 1e-7
"""Least relative decrease of the master's cost for a useful route."""

ATTAINED = 0.1
"""Greatest distance of the bound from the master, as a share of the gap, at which cuts are
added."""

MOST_CUTS = 200
"""Number of cuts beyond which none is added."""


class Prices(NamedTuple):
    """Prices of a bound.

    Attributes
    ----------
    worth : float
        λ.
    targets : (bodies,) float64
        π.
    cuts : (cuts,) float64
    """

    worth: float
    targets: np.ndarray
    cuts: np.ndarray


class ProvenPrices(NamedTuple):
    """A bound with its evidence.

    Attributes
    ----------
    prices : Prices
    most : (kinds,) float64
        No route of each kind comes to more at these prices, less what it costs.
    remembered : dict of int to (bodies, words) int64
        Of what walks of each kind, under its last tariff, need to remember for that.
    bound : float
        Be it below 0.
    """

    prices: Prices
    most: np.ndarray
    remembered: dict[int, np.ndarray]
    bound: float


class _Place(NamedTuple):
    """Walks of a chaser type that pay by a tariff.

    Attributes
    ----------
    kind : int
    tariff : Tariff
    walks : PricedBound
    start : int
        Number of the kind there.
    pricing : LabelPricing
    """

    kind: int
    tariff: Tariff
    walks: PricedBound
    start: int
    pricing: LabelPricing


class ColumnCost(CostRounds):
    """Rounds of column generation for the least cost of one campaign.

    Parameters
    ----------
    problem : Problem
    certificate : GapTracker
        With the plan whose worth is asked for; told of cheaper ones.
    pool : RoutePool
        Of routes; added to.
    stop : Stop
        Its time alone counts here.
    options : ProofOptions
    """

    def __init__(
        self,
        problem: Problem,
        certificate: GapTracker,
        pool: RoutePool,
        stop: Stop,
        options: ProofOptions,
    ) -> None:
        self._problem, self._certificate, self._pool = problem, certificate, pool
        self._options, self._stop = options, stop
        self._worths = np.array(problem.planning_prizes)
        self._stations = frozenset(range(problem.instance.first_target))
        self._over = lambda: stop.remaining_s() <= 0.0
        self._least_worth = least_worth_of(problem, certificate.incumbent)
        self._bounds = CampaignBound(
            problem,
            COARSER * options.delta_v_slot_m_s,
            jobs=options.cores,
            over=self._over,
            kind=partial(PricedBound, greatest_tanks=GREATEST_TANKS, greatest=_greatest(problem)),
        )
        self._places = tuple(self._all_places())
        self._counts = np.array([len(kind.chasers) for kind in problem.kinds])
        self._master = Master(problem, self._least_worth)
        self._cuts = SubsetRows()
        self._mixed: dict[tuple[int, frozenset[int]], float] = {}
        self._labels = min(FIRST_LABELS, options.most_labels)
        self._centred = CENTRED
        self._proven: ProvenPrices | None = None
        self._finishing = 0
        self.bound, self.done = 0.0, False
        for kind, group in enumerate(problem.kinds):
            for chaser in group.chasers:
                route = certificate.routes[chaser] if certificate.routes else ()
                if route:
                    pool.add(kind, route)

    @property
    def proven(self) -> bool:
        """Whether the known cost is proven to be least."""
        return is_least(self._certificate.cost, self.bound)

    def advance(self) -> None:
        """One iteration: solve the master, and price missing routes."""
        with suppress(TimeIsOver):
            self._iterate()
        self.done = self.done or self.proven

    def _iterate(self) -> None:
        self._mix()
        duals = self._master.solve()
        prices = self._near(duals)
        for place in self._places:
            place.pricing.cut(self._cuts, prices.cuts)
        paid = duals.kinds + ATTRACTIVE * max(duals.value, 1.0)
        if self._by_few_labels(duals, prices, paid):
            return
        new, finished = self._by_labels(duals, prices, paid)
        if new:
            self._centred = CENTRED
            self._offer()
        elif not finished:
            self.done = self._labels == self._options.most_labels
            self._labels = min(GROWTH * self._labels, self._options.most_labels)
        elif self._centred > 0.0:
            self._centred = 0.0 if self._centred < 0.1 else 0.5 * self._centred
        elif not self._cut(duals):
            self._offer()
            self._finish()
            self.done = True

    def _by_few_labels(self, duals: Duals, prices: Prices, paid: np.ndarray) -> bool:
        """Whether heuristic label searches find routes that make the combination cheaper."""
        found = 0
        for place in self._places:
            found += len(
                place.pricing.quickly(
                    self._charged(place, prices),
                    float(paid[place.kind]),
                    QUICK_LABELS,
                    self._over,
                    partial(self._keep, duals, place.kind),
                )
            )
        return found > 0

    def _by_labels(self, duals: Duals, prices: Prices, paid: np.ndarray) -> tuple[bool, bool]:
        """Whether exact searches find such routes, and all have finished: then a bound."""
        new, finished, most = False, True, np.zeros(len(self._counts))
        for place in self._places:
            answered, routes = place.pricing.search(
                self._charged(place, prices),
                float(paid[place.kind]),
                self._labels,
                self._over,
                partial(self._keep, duals, place.kind),
            )
            new, finished = new or bool(routes), finished and answered
            most[place.kind] = max(most[place.kind], place.pricing.most_worth)
        if finished:
            bound = prices.worth * self._least_worth
            bound -= math.fsum([*prices.targets, *prices.cuts, *(self._counts * most)])
            if self._proven is None or bound > self._proven.bound:
                remembered = {place.kind: place.pricing.remembered for place in self._places}
                self._proven = ProvenPrices(prices, most, remembered, bound)
                self.bound = max(bound, self.bound)
        return new, finished

    def _cut(self, duals: Duals) -> bool:
        """Add cuts that the mixture of routes violates; returns whether there are any."""
        if self.proven or self._proven is None or len(self._cuts.rows) >= MOST_CUTS:
            return False
        # Where walks are worth far more than routes, cuts of routes raise no bound.
        gap = self._certificate.cost - self._proven.bound
        if duals.value - self._proven.bound > ATTAINED * gap:
            return False
        new = self._cuts.separate(self._master.columns, duals.shares, len(self._problem.names))
        self._master.cut(new)
        self._centred = CENTRED if new else 0.0
        return bool(new)

    def _all_places(self) -> Iterator[_Place]:
        """All walks to be priced; those swept together come one after another."""
        problem = self._problem
        for kinds in problem.networks:
            # What they may fly and what that takes is the same for all of them.
            for tariff in tariffs_of(problem.kinds[kinds[0]].mission):
                for kind in kinds:
                    walks, start = self._bounds.of_kind[kind]
                    yield _Place(kind, tariff, walks, start, LabelPricing(walks, start))

    @property
    def evidence(self) -> CostEvidence | None:
        """Evidence of a bound on ΔV, unless the final phase has raised it.

        To verify the final phase would be to repeat it.
        """
        problem, proven = self._problem, self._proven
        if proven is None or problem.instance.objective.cost != "delta-v":
            return None
        if problem.instance.mission.mission_separation_s is not None:
            return None  # not yet verifiable
        if proven.bound <= 0.0 or not is_least(self.bound, proven.bound):
            return None
        cuts = np.zeros(len(self._cuts.rows))
        cuts[: proven.prices.cuts.size] = proven.prices.cuts
        stated_less = STATED_LESS * self._certificate.cost
        found = evidence_of(
            proven.prices.targets,
            [kind.chasers for kind in problem.kinds],
            (proven.most + 0.5 * stated_less / len(problem.missions)).tolist(),
            [proven.remembered[kind] for kind in range(len(problem.kinds))],
            self._options.delta_v_slot_m_s,
            self._cuts.priced(cuts),
        )
        return CostEvidence(
            proven.bound - stated_less,
            self._certificate.incumbent,
            proven.prices.worth,
            walks=found.walks,
            multipliers=found.multipliers,
            cuts=found.cuts,
        )

    def _charged(self, place: _Place, prices: Prices) -> np.ndarray:
        """Charge walks; returns the inputs of their pricing: multipliers, fees at stations."""
        place.walks.charge(prices.worth, place.tariff)
        if not place.tariff.fee:
            return prices.targets
        paid = np.array(prices.targets)
        paid[place.walks.network.is_station] = place.walks.greatest_prize
        return paid

    def _near(self, duals: Duals) -> Prices:
        """Prices between the best ones and the master's duals, within the range of walks."""
        worth, targets, cuts = duals.worth, duals.targets, duals.cuts
        if self._proven is not None:
            share, centre = self._centred, self._proven.prices
            worth = share * centre.worth + (1.0 - share) * worth
            targets = share * centre.targets + (1.0 - share) * targets
            cuts = (1.0 - share) * cuts
            cuts[: centre.cuts.size] += share * centre.cuts
        most = self._bounds.largest_gain
        return Prices(worth, np.maximum(targets, worth * self._worths - most), cuts)

    def _mix(self) -> None:
        """Add new or cheaper routes of the pool to the master."""
        new = [
            column
            for column in self._pool.columns()
            if column.cost < self._mixed.get((column.kind, column.targets), math.inf)
        ]
        self._mixed |= {(column.kind, column.targets): column.cost for column in new}
        self._master.add(new)

    def _keep(self, duals: Duals, kind: int, route: tuple[int, ...]) -> bool:
        """Add a route to the pool; returns whether it makes the combination cheaper."""
        column = self._pool.add(kind, route)
        if column is None:
            return False
        if column.cost >= self._mixed.get((kind, column.targets), math.inf):
            return False
        gain = duals.worth * column.worth - math.fsum(duals.targets[j] for j in column.targets)
        gain -= self._cuts.paid(column.targets, duals.cuts)
        least = ATTRACTIVE * max(duals.value, 1.0)
        return bool(gain - column.cost - duals.kinds[kind] > least)

    def _offer(self) -> None:
        """Offer the cheapest plan of the known routes."""
        columns = self._pool.columns()
        if not columns:
            return
        costs = np.array([column.cost for column in columns])
        worths = np.array([column.worth for column in columns])
        scale = 1.0 / max(self._least_worth, 1e-300)
        found = cheapest_of(
            costs,
            [
                packing(
                    self._problem,
                    [(column.kind, column.targets) for column in columns],
                    [column.use for column in columns],
                ),
                LinearConstraint(scale * worths[None, :], scale * self._least_worth, np.inf),
            ],
            self._stop.remaining_s(),
            gap=1e-9,
        )
        if found.taken is None:
            return
        taken = [columns[at] for at in found.taken]
        self._certificate.offer(
            *dealt(self._problem, [(column.kind, column.route) for column in taken])
        )

    def _finish(self) -> None:
        """List all routes of possible cheaper plans, and search for such a plan."""
        if self.proven or self._proven is None:
            return
        prices, most, _, bound = self._proven
        finish = CheapestSets(
            self._problem, self._certificate, self._pool, self._least_worth, self._stop
        )
        gap = self._certificate.cost - bound
        cuts = np.zeros(len(self._cuts.rows))
        cuts[: prices.cuts.size] = prices.cuts
        for place in self._places:
            search = Search(place.walks, start=place.start, all_sets=True)
            search.cut(self._cuts.priced(cuts), forgetful=False)
            paid = self._charged(place, prices)
            search.use(paid)
            off = LEAST_OFF * max(self._certificate.cost, 1.0)
            finished, _, _, _ = search.search(
                search.total + float(most[place.kind]) - gap - off,
                self._options.most_labels,
                self._over,
            )
            self._finishing += search.labels_made
            found = search.valued_plans(MOST_ROUTES + 1)
            if not finished or finish.size + len(found) > MOST_ROUTES:
                return
            gains = prices.worth * self._worths - paid
            for route, value in found:
                targets = frozenset(route) - self._stations
                worth = math.fsum(gains[list(targets)]) - self._cuts.paid(targets, cuts)
                finish.note(place.kind, route, worth, value)
        # All that could make a cheaper plan is there to choose from.
        before = self._certificate.cost
        self.bound = max(self.bound, min(before, finish.settle()))
        self._offer()

    @property
    def counters(self) -> dict[str, float]:
        """Work counters."""
        return {
            "cost_searches": sum(place.pricing.searches for place in self._places),
            "cost_labels": self._finishing
            + sum(place.pricing.labels_made for place in self._places),
        }

    def close(self) -> None:
        """End the threads."""
        self._bounds.close()


def prove_cost_by_columns(
    problem: Problem,
    certificate: GapTracker,
    pool: RoutePool,
    stop: Stop,
    enough: Callable[[], bool],
    options: ProofOptions,
) -> tuple[float, dict[str, float]]:
    """Prove a lower bound on the cost of plans with at least the incumbent's worth.

    Parameters
    ----------
    problem, certificate, pool, stop, options
        As :class:`ColumnCost` takes them.
    enough : callable
        Asked once a round.

    Returns
    -------
    bound : float
    counters : dict
    """
    try:
        proof = ColumnCost(problem, certificate, pool, stop, options)
    except TimeIsOver:
        return 0.0, {}
    found = settled(proof, enough)
    certificate.cost_evidence = proof.evidence
    return found


def _greatest(problem: Problem) -> float | None:
    """Largest worth of a target to walks that pay expenses; None if they pay ΔV."""
    if problem.instance.objective.cost != "expense":
        return None
    most = max(most_expense(kind.mission) for kind in problem.kinds)
    return GREATEST_TANKS * (most or 1.0)
