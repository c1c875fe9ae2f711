"""Proof of least ΔV at the best prize: the relaxation with walks that pay for ΔV.

Of the plans worth at least P, which costs least? With a price λ on worth, in m/s, every such plan
costs at least

    λ P − max over walks [ Σ over services λ worth_j − ΔV ] ,

since it is a walk and is worth P or more. The walks are those of :mod:`solvers.walks.walks`, times
exact; a leg pays the least ΔV that any leg between the same bodies in as many slots costs. Labels
pay exactly. Where time has a price (:attr:`.instance_file.InstanceFile.time_m_s_per_s`), walks pay
for it when they stop, from then back to when the chaser may fly: labels exactly, walks as if they
had stopped at the departure before. No label has paid for time on its way, so that dominance is
what it was. They are dropped when they would cost too much at either of two prices, a moderate one
and one at which a service is worth any ΔV, and when their worth can no longer reach P, by the
values of a sweep in which nothing is paid. That one is what keeps them few, and so the finest: a
mission at its best prize has hardly any time to spare.

There are no multipliers here. They raise the bound of walks by little compared with what is left to
the cost of a plan, and without them labels that collect as many targets can be compared.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress

import numpy as np
import numpy.typing as npt

from adr_opt.common.stop import TimeIsOver
from adr_opt.mission.evidence import CostEvidence
from adr_opt.mission.mission import Mission

from ..labels.extension import CompletionValues
from ..labels.label_search import LabelSearch
from ..networks.arrays import Network
from ..networks.evidence import as_bits
from ..progress.cost_rounds import RELATIVE, CostRounds, is_least, least_worth_of
from ..walks.sweeps import NEVER
from ..walks.tariffs import Tariff
from ..walks.walks import LARGEST, Paid, WalkBound

GREATEST_TANKS = 2.0
"""Upper limit on the worth of a service to a walk [tanks]."""

COARSER, PARTS = 4.0, 10
"""Slots of paying walks, in slots of non-paying ones, and ΔV steps per slot of theirs."""

REACH_SHARE = 1.0 / 150.0
"""Length of a time bucket as a share of the shortest leg, where nothing is paid."""

EVALUATIONS = 8
"""Number of prices tried for the first bound."""

FIRST_LABELS, GROWTH = 4_000_000, 2
"""Maximum number of labels in the first searches, and its growth factor."""

NEAR = 0.15
"""Gap, as a share of the known cost, below which the whole gap is searched at once."""

STATED_LESS = 2e-7
"""Share by which the evidence states less than the bound, to cover rounding."""

LEAST_SHARE = 1.0 / 8.0
"""Least share of the gap searched before more labels are allowed."""


class PricedBound(WalkBound):
    """Walks that pay for ΔV, that of tows included, and for time until they stop.

    Parameters
    ----------
    mission, delta_v_slot_m_s, jobs, over, network, others
        As of :class:`WalkBound`.
    greatest_tanks : float
        Most that a service may be worth to a walk [tanks, and what the mission's time costs].
    greatest : float, optional
        The same in the unit of the tariffs that it will be charged with.
    """

    def __init__(
        self,
        mission: Mission,
        delta_v_slot_m_s: float,
        jobs: int,
        over: Callable[[], bool],
        network: Network | None = None,
        others: Sequence[Mission] = (),
        greatest_tanks: float = GREATEST_TANKS,
        greatest: float | None = None,
    ) -> None:
        time_price = mission.instance.time_m_s_per_s
        super().__init__(
            mission,
            delta_v_slot_m_s,
            jobs=jobs,
            over=over,
            network=network,
            paid=Paid(PARTS, time_price > 0.0),
            others=others,
        )
        # Losses are left out, a relaxation: services are worth their greatest prize.
        self.falls = self.fall = None
        self.time_price = time_price
        self.worths = np.array(mission.rules.prize)
        if self.loads is not None:
            self.flown = np.array(self.loads.flown)
        most = self.budget + time_price * max(mission.rules.duration - mission.rules.ready, 0.0)
        self.greatest_prize = greatest or greatest_tanks * max(most, 1.0)
        self.greatest_price = self.greatest_prize / (float(self.worths.max(initial=0.0)) or 1.0)
        room = LARGEST / (1 << self.bits) / self.most_legs / self.greatest_prize
        self.unit = 2.0 ** -math.floor(math.log2(room))
        if time_price > 0.0:
            self.stop = self._stops()
        self._tariff: Tariff | None = None
        self._worth = math.nan
        if greatest is None:
            self._pay(np.ones(1))

    def _stops(self) -> np.ndarray:
        """Price of time of walks that stop in a bucket, packed: a lower bound.

        A walk ready in a bucket was not ready for the last departure of the bucket before.
        """
        buckets = self.buckets
        before = np.append(-np.inf, buckets.closes[:-1])
        before[buckets.start[:-1]] = -np.inf
        passed = np.maximum(before - self.since[0], 0.0)
        most = LARGEST // (1 << self.bits) // 4
        paid = np.minimum(np.floor(self.time_price * passed / self.unit), most).astype(np.int64)
        body = np.repeat(np.arange(buckets.may_end.size), np.diff(buckets.start))
        packed = (-paid << self.bits) + body
        return np.where(buckets.may_end[body], packed, NEVER).astype(np.int32)

    def _pay(self, price: np.ndarray) -> None:
        """Set the price of ΔV for a number of kits aboard, or for any."""
        most = LARGEST // (1 << self.bits) // 2
        paid = np.floor(price[:, None] * self.buckets.least / self.unit)
        self.price, self.toll = price, np.minimum(paid, most).astype(np.int32)

    def charge(self, worth: float, tariff: Tariff | None = None) -> None:
        """Set the worth of a unit for walks [m/s, or the unit of the tariff]."""
        new = tariff is not None and tariff is not self._tariff
        if not new and worth == self._worth:
            return
        self._kept, self._worth = None, worth
        if tariff is not None and new:
            alike = bool((tariff.price == tariff.price[0]).all())
            self._pay(tariff.price[:1] if alike else tariff.price)
            self._tariff, self.tank, self.constant = tariff, tariff.tank, tariff.constant
        # What a service flies itself pays the price with no kits aboard at least.
        self.prize = worth * self.worths - float(self.price.min()) * self.flown

    def cost_at(self, price: float, worth: float) -> tuple[float, float]:
        """The bound at a price of worth [m/s], and the worth of the best walk there."""
        self.charge(price)
        value, _ = self.evaluate(np.zeros(self.prize.size), keep=True)
        return price * worth - value, float(self.worths[self.walk].sum())


class CostProof(CostRounds):
    """Rounds of search for the least ΔV of plans with sufficient worth.

    Parameters
    ----------
    mission : Mission
    least_worth : float
        P: what a plan has to be worth.
    offer : callable
        Takes a sequence of bodies that may be a plan of less cost.
    cost : callable
        Least cost known [m/s].
    over : callable
        Whether the time is over.
    jobs : int
        Threads.
    delta_v_slot_m_s : float
        Of walks that do not pay.
    most_labels : int
        Most labels of a search.
    """

    def __init__(
        self,
        mission: Mission,
        least_worth: float,
        offer: Callable[[npt.NDArray[np.int64]], object],
        cost: Callable[[], float],
        over: Callable[[], bool],
        *,
        jobs: int,
        delta_v_slot_m_s: float,
        most_labels: int,
    ) -> None:
        self._offer, self._cost, self._over, self._jobs = offer, cost, over, jobs
        self._reach = WalkBound(
            mission,
            delta_v_slot_m_s,
            bucket_share=REACH_SHARE,
            jobs=jobs,
            over=over,
            paid=Paid(time=mission.instance.time_m_s_per_s > 0.0),
        )
        self._walks = PricedBound(
            mission, COARSER * delta_v_slot_m_s, jobs, over, self._reach.network
        )
        self._asked_worth, self._worth = least_worth, least_worth_of(mission, least_worth)
        # Walks pay for what the tank lacked before the start, and plans do not.
        self._spent = mission.connecting.spent_m_s(mission.rules.start)
        self._proving, self._finding = LabelSearch(self._walks), LabelSearch(self._walks)
        # All that was visited is remembered, so that each walk found is a plan; labels are told
        # apart by what proofs remember only, so that some are lost, but there are not too many.
        self._finding.neighbourhood[:] = -1
        self._price = 0.0
        self._pool = ThreadPoolExecutor(1) if jobs > 1 else None
        self._labels, self._most_labels = min(FIRST_LABELS, most_labels), most_labels
        self._share, self._finding_share = 0.25, 1.0
        self._fruitless = 0  # rounds since one found a cheaper plan
        self._tried = False  # whether the whole gap was ever too much
        self._ready = False
        self.bound = 0.0
        self.evidence: CostEvidence | None = None
        self.done = self.proven

    def _raise(self, bound: float, price: float, neighbourhood: npt.NDArray[np.int64]) -> None:
        """Take over a better bound with its evidence."""
        if bound <= self.bound:
            return
        self.bound = bound
        self.evidence = CostEvidence(
            (1.0 - STATED_LESS) * bound,
            self._asked_worth,
            price,
            as_bits(neighbourhood, self._walks.prize.size),
        )

    @property
    def proven(self) -> bool:
        """Whether the known cost is proven to be least."""
        return is_least(self._cost(), self.bound)

    def advance(self) -> None:
        """One round: searches for cheaper plans, one exact and one heuristic."""
        with suppress(TimeIsOver):
            if not self._ready:
                self._prepare()
            if not self.proven and not self._over():
                self._search()
        self.done = self.done or self.proven

    def _prepare(self) -> None:
        """Sweeps: a first bound, and the completion values that prune labels."""
        reach, walks = self._reach, self._walks
        reach.evaluate(np.zeros(reach.prize.size), keep=True)
        low, high = 0.0, walks.greatest_price
        price, best = 0.05 * high, 0.0
        nothing = np.zeros_like(self._proving.neighbourhood)
        for _ in range(EVALUATIONS):
            bound, worth = walks.cost_at(price, self._worth)
            if bound - self._spent > self.bound:
                best = price
                self._raise(bound - self._spent, price, nothing)
            if worth < self._worth:
                low = price
            else:
                high = price
            price = 0.5 * (low + high) if high < walks.greatest_price else 2.0 * price
            price = min(price, walks.greatest_price)
        prices = np.array([best or price, 0.75 * walks.greatest_price])
        tables = []
        for price in prices:
            walks.cost_at(price, self._worth)
            tables.append((walks.values.best[0].copy(), walks.values.second[0].copy()))
        values = CompletionValues(
            walks.buckets.of_row,
            np.stack([one for one, _ in tables]),
            np.stack([one for _, one in tables]),
            tables[0][0].size,
            walks.bits,
            walks.width,
            walks.top,
            walks.slot,
        )
        for routes in (self._proving, self._finding):
            routes.pay(values, prices, reach, self._worth)
        self._price = float(prices[0])
        self._ready = True

    def _below(self, share: float) -> float:
        """Goal of a search: at a share of the gap, below the known plan's cost."""
        cost = self._cost()
        less = 0.5 * RELATIVE * cost
        return min(self.bound + share * (cost - self.bound), cost - less)

    def _free(self) -> float:
        """Worth of a walk that is sufficient and costs nothing [m/s]."""
        return self._price * self._worth - self._spent

    def _search(self) -> None:
        """Search for plans within a share of the gap above the bound."""
        if not self._tried and self._cost() - self.bound <= NEAR * self._cost():
            self._share = 1.0
        known, most = self._free(), self._below(self._share)
        finding: Future[None] | None = None
        remembered = self._proving.neighbourhood.copy()
        self._finding.compared = remembered.copy()
        self._fruitless += 1
        finds = self._fruitless & (self._fruitless - 1) == 0  # it takes as long as the proof
        if finds:
            if self._pool is None:
                self._find()
            else:
                finding = self._pool.submit(self._find)
        try:
            finished, value, plan, grown = self._proving.search(
                known - most, self._labels, self._over
            )
        finally:
            if finding is not None:
                finding.result()
        if not finished:
            self._tried |= self._share == 1.0
            if self._share > LEAST_SHARE:
                self._share *= 0.5
            elif self._labels < self._most_labels:
                self._labels = min(GROWTH * self._labels, self._most_labels)
            else:
                self.done = True
            return
        before = self._cost()
        if plan is not None:
            self._offer(plan)
        # Every plan left out costs more than what was asked for.
        self._raise(min(most, known - value, self._cost()), self._price, remembered)
        if value == -math.inf:
            self._share = min(1.0, 2.0 * self._share)
        elif grown == 0 and self._cost() >= before:
            self.done, self._fruitless = finds, 0

    def _find(self) -> None:
        """Search heuristically for cheaper plans."""
        known, most = self._free(), self._below(self._finding_share)
        finished, _, plan, _ = self._finding.search(known - most, self._labels, self._over)
        if plan is not None:
            self._offer(plan)
            self._fruitless = 0
        if not finished:
            self._finding_share = max(0.5 * self._finding_share, LEAST_SHARE)
        elif plan is None:
            self._finding_share = min(1.0, 1.5 * self._finding_share)

    def close(self) -> None:
        """End the threads."""
        self._walks.close()
        self._reach.close()
        if self._pool is not None:
            self._pool.shutdown()

    @property
    def counters(self) -> dict[str, float]:
        """Work counters."""
        return {
            "cost_searches": self._proving.searches + self._finding.searches,
            "cost_labels": self._proving.labels_made + self._finding.labels_made,
        }
