"""The least ΔV of campaigns that collect as much: column generation over routes that pay for it.

With a price λ on worth in m/s, and multipliers π of "each target at most once", every campaign that
is worth P or more costs at least

    λ P − Σ π − Σ over chasers of the most that Σ (λ worth_j − π_j) − ΔV comes to on a route.

The master mixes known routes at least cost; its duals are λ and π. Labels that pay for their ΔV
(:mod:`solvers.relaxation.cost`) find routes that it lacks, or prove how good any could be. What is
left between the bound and the best plan is closed as for prizes: all routes that a cheaper plan
could be made of are listed, and a set packing decides (:mod:`.finish`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import NamedTuple

import highspy
import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp

from adr_opt.campaign import Campaign
from adr_opt.stop import Stop

from ..relaxation.cost import COARSER, RELATIVE, PricedBound
from ..relaxation.proof import FIRST_LABELS, GROWTH, ProofOptions
from ..relaxation.routes import Routes as Search
from ..relaxation.walks import TimeIsOver
from .bound import CampaignBound
from .finish import MOST_ROUTES
from .incumbent import CampaignCertificate
from .pool import Column, Pool, dealt, packing
from .pricing import LabelPricing

CENTRED = 0.5
"""Weight of the best prices against the master's duals."""

GREATEST_TANKS = 4.0
"""Most that a target may be worth to a walk: multipliers are raised where the master asks for more.
"""

QUICK_LABELS = 200_000
"""Labels of a search that proves nothing."""

ATTRACTIVE = 1e-7
"""A route of use makes the master cheaper by so much, as a share of what it costs now."""

SLACK_WORTH = 1e-9
"""A little less is asked for, so that no rounding of a sum of prizes counts."""

LEAST_OFF_M_S = 1e-4
"""Routes are asked for from so much below; for rounding."""


class Prices(NamedTuple):
    """A solution of the master.

    Attributes
    ----------
    cost : float
        No mixture of the columns that is worth enough costs less [m/s].
    worth : float
        λ [m/s].
    targets : (bodies,) float64
        π [m/s].
    kinds : (kinds,) float64
        What one more chaser of a kind would save [m/s].
    """

    cost: float
    worth: float
    targets: np.ndarray
    kinds: np.ndarray


class CostMaster:
    """Minimise the cost of a mixture of routes that is worth enough.

    Parameters
    ----------
    campaign : Campaign
    least_worth : float
    """

    def __init__(self, campaign: Campaign, least_worth: float) -> None:
        self._bodies = len(campaign.names)
        # Worths in tens of thousands would leave the tolerances of the solver behind.
        self._scale = 1.0 / max(least_worth, 1e-300)
        self._highs = highspy.Highs()
        self._highs.setOptionValue("output_flag", False)
        self._highs.setOptionValue("threads", 1)
        none, nobody = np.empty(0), np.empty(0, dtype=np.int32)
        for _ in range(self._bodies):
            self._highs.addRow(-highspy.kHighsInf, 1.0, 0, nobody, none)
        for kind in campaign.kinds:
            self._highs.addRow(-highspy.kHighsInf, float(len(kind.chasers)), 0, nobody, none)
        self._highs.addRow(least_worth * self._scale, highspy.kHighsInf, 0, nobody, none)
        self._last = self._bodies + len(campaign.kinds)

    def add(self, columns: list[Column]) -> None:
        """More routes to mix."""
        for column in columns:
            rows = [*sorted(column.targets), self._bodies + column.kind, self._last]
            values = np.ones(len(rows))
            values[-1] = column.worth * self._scale
            self._highs.addCol(
                column.cost, 0.0, highspy.kHighsInf, len(rows), np.array(rows, dtype=np.int32),
                values,
            )  # fmt: skip

    def solve(self) -> Prices:
        """The cheapest mixture."""
        self._highs.run()
        duals = np.array(self._highs.getSolution().row_dual)
        return Prices(
            float(self._highs.getInfo().objective_function_value),
            max(float(duals[self._last]), 0.0) * self._scale,
            np.maximum(-duals[: self._bodies], 0.0),
            np.maximum(-duals[self._bodies : self._last], 0.0),
        )


class CampaignCost:
    """Rounds of column generation for the least ΔV of one campaign.

    Parameters
    ----------
    campaign : Campaign
    certificate : CampaignCertificate
        With the plan whose worth is asked for; told of cheaper ones.
    pool : Pool
        Of routes; added to.
    stop : Stop
        Its time alone counts here.
    options : ProofOptions

    Attributes
    ----------
    bound : float
        No plan worth as much costs less [m/s].
    done : bool
        Nothing is left to do.
    """

    def __init__(
        self,
        campaign: Campaign,
        certificate: CampaignCertificate,
        pool: Pool,
        stop: Stop,
        options: ProofOptions,
    ) -> None:
        self._campaign, self._certificate, self._pool = campaign, certificate, pool
        self._options, self._stop = options, stop
        self._worths = np.array(campaign.worths)
        asked = certificate.incumbent
        self._asked = asked - SLACK_WORTH * max(1.0, abs(asked))
        self._bounds = CampaignBound(
            campaign, COARSER * options.delta_v_slot_m_s, jobs=options.cores,
            over=lambda: stop.remaining_s() <= 0.0,
            kind=partial(PricedBound, greatest_tanks=GREATEST_TANKS),
        )  # fmt: skip
        self._pricing = tuple(LabelPricing(*place) for place in self._bounds.of_kind)
        self._counts = np.array([len(kind.chasers) for kind in campaign.kinds])
        self._master = CostMaster(campaign, self._asked)
        self._mixed: dict[tuple[int, frozenset[int]], float] = {}
        self._labels = min(FIRST_LABELS, options.most_labels)
        self._centre: tuple[float, np.ndarray] | None = None
        self._centred = CENTRED
        # Prices, the most that routes come to at them, and the bound of both, be it below 0.
        self._proven: tuple[float, np.ndarray, np.ndarray, float] | None = None
        self._finishing = 0
        self.bound, self.done = 0.0, False
        for kind, group in enumerate(campaign.kinds):
            for chaser in group.chasers:
                route = certificate.sequence[chaser] if certificate.sequence else ()
                if route:
                    pool.add(kind, route)

    @property
    def proven(self) -> bool:
        """Whether the cost known is the least."""
        return self._certificate.cost <= self.bound * (1.0 + RELATIVE) + RELATIVE

    def advance(self, enough: Callable[[], bool]) -> None:
        """One iteration: solve the master, and look for routes that it lacks."""
        with suppress(TimeIsOver):
            self._iterate(enough)
        self.done = self.done or self.proven

    def _iterate(self, enough: Callable[[], bool]) -> None:
        self._mix()
        duals = self._master.solve()
        worth, targets = self._near(duals)
        new, most, finished = False, np.zeros(len(self._pricing)), True
        self._bounds.charge(worth)
        paid = duals.kinds + ATTRACTIVE * max(duals.cost, 1.0)
        keep = [partial(self._keep, duals, kind) for kind in range(len(self._pricing))]
        found = 0
        for kind, pricing in enumerate(self._pricing):
            found += len(
                pricing.quickly(targets, float(paid[kind]), QUICK_LABELS, enough, keep[kind])
            )
        if found:
            return
        for kind, pricing in enumerate(self._pricing):
            answered, routes = pricing.search(
                targets, float(paid[kind]), self._labels, enough, keep[kind]
            )
            new, finished = new or bool(routes), finished and answered
            most[kind] = max(0.0, pricing.most_worth)
        if finished:
            bound = worth * self._asked - math.fsum([*targets, *(self._counts * most)])
            if self._proven is None or bound > self._proven[3]:
                self.bound = max(bound, self.bound)
                self._centre, self._proven = (worth, targets), (worth, targets, most, bound)
        if new:
            self._centred = CENTRED
            self._offer()
        elif not finished:
            self.done = self._labels == self._options.most_labels
            self._labels = min(GROWTH * self._labels, self._options.most_labels)
        elif self._centred > 0.0:
            self._centred = 0.0 if self._centred < 0.1 else 0.5 * self._centred
        else:
            self._offer()
            self._finish(enough)
            self.done = True

    def _near(self, duals: Prices) -> tuple[float, np.ndarray]:
        """Prices between the best ones and the master's duals, at which walks can be counted."""
        worth, targets = duals.worth, duals.targets
        if self._centre is not None:
            share = self._centred
            worth = share * self._centre[0] + (1.0 - share) * worth
            targets = share * self._centre[1] + (1.0 - share) * targets
        most = self._bounds.largest_gain
        return worth, np.maximum(targets, worth * self._worths - most)

    def _mix(self) -> None:
        """Let the master know of routes that came into the pool, or became cheaper."""
        new = [
            column for column in self._pool.columns()
            if column.cost < self._mixed.get((column.kind, column.targets), math.inf)
        ]  # fmt: skip
        self._mixed |= {(column.kind, column.targets): column.cost for column in new}
        self._master.add(new)

    def _keep(self, duals: Prices, kind: int, route: tuple[int, ...]) -> bool:
        """Put a route into the pool; whether it makes the mixture cheaper."""
        column = self._pool.add(kind, route)
        if column is None:
            return False
        if column.cost >= self._mixed.get((kind, column.targets), math.inf):
            return False
        gain = duals.worth * column.worth - math.fsum(duals.targets[j] for j in column.targets)
        least = ATTRACTIVE * max(duals.cost, 1.0)
        return bool(gain - column.cost - duals.kinds[kind] > least)

    def _offer(self) -> float:
        """Offer the cheapest plan of the routes known.

        Returns
        -------
        least : float
            No plan of these routes costs less [m/s].
        """
        columns = self._pool.columns()
        if not columns:
            return 0.0
        costs = np.array([column.cost for column in columns])
        worths = np.array([column.worth for column in columns])
        scale = 1.0 / max(self._asked, 1e-300)
        found = milp(
            costs,
            integrality=np.ones(len(columns)),
            bounds=Bounds(0.0, 1.0),
            constraints=[
                packing(self._campaign, [(column.kind, column.targets) for column in columns]),
                LinearConstraint(scale * worths[None, :], scale * self._asked, np.inf),
            ],
            options={"time_limit": max(self._stop.remaining_s(), 0.1), "mip_rel_gap": 1e-9},
        )
        if found.x is None:
            return 0.0
        taken = [columns[at] for at in np.flatnonzero(found.x > 0.5).tolist()]
        self._certificate.offer(
            dealt(self._campaign, [(column.kind, column.route) for column in taken])
        )
        return math.fsum(column.cost for column in taken) if found.status == 0 else 0.0

    def _finish(self, enough: Callable[[], bool]) -> None:
        """List all routes that a cheaper plan could be made of, and ask for one."""
        if self.proven or self._proven is None:
            return
        worth, targets, most, bound = self._proven
        gap = self._certificate.cost - bound
        self._bounds.charge(worth)
        routes: list[tuple[int, tuple[int, ...]]] = []
        for kind, (walks, start) in enumerate(self._bounds.of_kind):
            search = Search(walks, start=start, all_sets=True)
            search.use(targets)
            least = float(most[kind]) - gap - LEAST_OFF_M_S
            finished, _, _, _ = search.search(
                search.total + least, self._options.most_labels, enough
            )
            self._finishing += search.labels_made
            found = search.plans(MOST_ROUTES + 1)
            routes += [(kind, route) for route in found]
            if not finished or len(routes) > MOST_ROUTES:
                return
        for kind, route in routes:
            self._pool.add(kind, route)
        # All that could make a cheaper plan is there to choose from.
        before = self._certificate.cost
        self.bound = max(self.bound, min(before, self._offer() * (1.0 - 0.1 * RELATIVE)))

    @property
    def counters(self) -> dict[str, float]:
        """What was done so far."""
        return {
            "cost_searches": sum(pricing.searches for pricing in self._pricing),
            "cost_labels": self._finishing + sum(pricing.labels_made for pricing in self._pricing),
        }

    def close(self) -> None:
        """End the threads."""
        self._bounds.close()


def prove_campaign_cost(
    campaign: Campaign,
    certificate: CampaignCertificate,
    pool: Pool,
    stop: Stop,
    options: ProofOptions,
) -> tuple[float, dict[str, float]]:
    """Prove how much ΔV the plans cost at least that are worth as much as the incumbent.

    Returns
    -------
    bound : float
        [m/s]
    counters : dict
    """

    def over() -> bool:
        return stop.remaining_s() <= 0.0

    proof = CampaignCost(campaign, certificate, pool, stop, options)
    try:
        while not proof.done and not over():
            proof.advance(over)
    finally:
        proof.close()
    return proof.bound, proof.counters
