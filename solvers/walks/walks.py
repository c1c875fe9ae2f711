"""Longest walks, computed backwards in time for given multipliers (docs/model.md section 8).

The relaxation. A *walk* may service a target again and again, but never two legs after leaving it
(i → j → i is forbidden, also when j is a station); each service of target j is worth its prize
less a multiplier π_j ≥ 0. The best walk from every (body, time, ΔV left) comes out of one sweep
backwards in time. Every plan is a walk: its moves are the walk's moves, and each step below only
widens what is allowed. So for every plan, and for every completion of a partial plan,

    prizes collected = Σ over its targets (prize_j − π_j) + Σ over its targets π_j
                     ≤ value of the best walk + Σ over the targets not yet visited π_j .

What is exact and what is relaxed:

- Walks move on the network of :mod:`solvers.networks.buckets`: arrivals within a bucket of time
    count as at its beginning, and one arc leads from each bucket of a body to the next, to wait.
  That is one comparison a leg and a slot. Services that would end too late are left out exactly.
  With buckets of no length time is exact.
- ΔV is counted in slots. The slots of a leg are rounded down and so is the budget: if the legs fit
  into the budget, then Σ ⌊ΔV/u⌋ ≤ ⌊Σ ΔV/u⌋ ≤ ⌊budget/u⌋. A relaxation, the better the finer.
- A prize that falls has fallen by no more than at the earliest end of a service in a bucket.
- Values are whole numbers of units, so sums are exact and there is no rounding error to guard
  against: the multipliers are those for which prize_j − π_j is a whole number of units.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from adr_opt.common.stop import TimeIsOver
from adr_opt.kernels.core.events import earliest_taken
from adr_opt.kernels.rules.falls import Falls
from adr_opt.mission.mission import Mission

from ..networks import simd
from ..networks.arrays import Network
from ..networks.buckets import Buckets, assign
from ..networks.buckets import build as fill
from ..networks.layers import SLACK, layers_of
from ..networks.network import build
from .sweeps import Values, WalkState, WalkTerms, begin, sweep_until, trace

LARGEST = 2**29
"""Upper limit of sums of values, code included."""


BUCKET_SHARE = 1.0 / 60.0
"""Usual length of a time bucket, as a share of the shortest leg."""

MOST_SLOTS = 8_000
"""Maximum number of ΔV slots, so that evaluations do not take too long: a tank of hundreds of
km/s is as good as any, and needs none."""

ROOM_BYTES = 0.6e9
"""Memory for the values of all states [bytes]."""


def affordable(buckets: int, budget: float, slot: float, arrays: int = 2) -> float:
    """The requested slot, widened until slots are few enough and all values fit in memory [m/s].

    Parameters
    ----------
    arrays : int
        Number of integers for each bucket and slot.
    """
    while slot < budget and (
        budget > MOST_SLOTS * slot
        or 4.0 * arrays * buckets * (budget / slot + simd.LANES) > ROOM_BYTES
    ):
        slot *= 2.0
    return slot


def spendable(network: Network, duration: float) -> float:
    """Upper bound on the ΔV of a walk: each leg at the largest cost of any [m/s]."""
    legs = duration / network.shortest + 1.0 if network.shortest > 0.0 else math.inf
    # One more, and a launch that takes no time.
    return float((legs + 2.0) * network.delta_v.max(initial=0.0))


def _stages(buckets: Buckets) -> list[float]:
    """Starts of stages, the last one first, as few as possible [s].

    Each is as long as what opens in it may be apart and still not land in it. Between stages there
    may be nothing, so that they are few also where the shortest leg is far shorter than others.
    What takes no time, launches, stands before the beginning and has a stage of its own, from −inf.
    """
    opens = np.unique(buckets.opens[(buckets.opens >= 0.0) & np.isfinite(buckets.opens)])
    length = earliest_taken(buckets.shortest) * (1.0 - 1e-9)
    begins, end = [], opens.size
    while end > 0:
        end = min(int(np.searchsorted(opens, opens[end - 1] - length)), end - 1)
        begins.append(float(opens[end]))
    return [*begins, -math.inf]


def bonuses(mission: Mission) -> np.ndarray:
    """Worths of required targets beyond their prizes, shape (bodies,)."""
    return np.where(mission.is_required, np.minimum(mission.bonus, mission.rules.prize), 0.0)


class Paid(NamedTuple):
    """Costs of walks, as far as their choice of legs depends on them.

    Attributes
    ----------
    parts : int
        Steps of ΔV in a slot that legs are told apart by, for walks that pay for it.
    time : bool
        Whether the network has ends of services, for walks that pay for time.
    """

    parts: int = 1
    time: bool = False


NOTHING_PAID = Paid()


class WalkBound:
    """Repeated evaluation of a mission's best walks for given multipliers.

    Parameters
    ----------
    mission : Mission
    delta_v_slot_m_s : float
        Slot of the ΔV axis, widened where values would not fit into memory [m/s].
    bucket_share : float
        Length of a bucket of time as a share of the shortest leg; 0 for exact times.
    jobs : int
        Threads.
    over : callable
        Asked now and then whether the time is over.
    network : Network, optional
        That of the missions, where it is known.
    paid : Paid
    others : sequence of Mission
        That move on the same network, see :func:`solvers.networks.network.build`.

    Attributes
    ----------
    network : Network
    buckets : Buckets
        What walks move on.
    values : Values
    slot : float
        Slot in use [m/s].
    loads : Loads or None
        As of the rules of the mission.
    layers : Layers or None
        As walks have them.
    most_legs : int
        No walk has more.
    unit : float
        Prize that one unit of value is worth.
    price : (kits + 1 or 1,) float64
        What a m/s takes off the value of a walk, by number of kits aboard, or for any.
    tank : (kits + 1,) float64
        What a walk starts with, by number of kits [m/s]; less than 0 where it cannot.
    constant : (kits + 1,) float64
        What it pays for starting.
    worths : (bodies,) float64
        What targets are worth in the mission.
    flown : (bodies,) float64
        ΔV that each service takes itself, where walks pay for it [m/s].
    toll : (kits + 1 or 1, legs kept) int32
        What a leg takes off a walk's value [units]; empty for nothing.
    stop : (buckets,) int32
        What a walk has to pay for time that is over in a bucket, packed as :class:`Values` are; no
        less than the truth, and counted from when the first mission begins. Empty for nothing.
    fall : (buckets,) int32 or None
        What services that end in a bucket have lost of their prize, packed; no more than the truth.
        None where no prize falls.
    falls : Falls or None
        As of the rules of the mission.
    time_price : float
        What a second takes off a walk's value.
    since : (missions,) float64
        When each of the missions begins [s].
    is_paid : (bodies,) bool
        Which multipliers walks pay at each visit: by default those of targets; a limit on visits
        of stations adds theirs.
    walk : (legs,) int64
        Best walk of the last evaluation: bodies in order.
    """

    def __init__(
        self,
        mission: Mission,
        delta_v_slot_m_s: float,
        bucket_share: float = BUCKET_SHARE,
        jobs: int = 1,
        over: Callable[[], bool] = lambda: False,
        network: Network | None = None,
        paid: Paid = NOTHING_PAID,
        others: Sequence[Mission] = (),
    ) -> None:
        rules = mission.rules
        self._over = over
        self.prize = np.array(rules.prize)
        self.is_target = np.arange(self.prize.size) >= rules.first_target
        self.is_paid = self.is_target
        self._bonuses = bonuses(mission)
        self._starts = [each.rules.start for each in (mission, *others)]
        self.since = np.array([each.rules.ready for each in (mission, *others)])
        self.limits = rules.limits
        bodies = self.prize.size
        self.network = network or build(
            mission, others=others, jobs=jobs, with_ends=paid.time, over=over
        )
        assignment = assign(self.network, bucket_share)
        self.loads = rules.loads
        layers = 1 if self.loads is None else self.loads.full.size
        arrays = 2 if self.loads is None else 4 * layers
        self.slot = affordable(int(assignment.start[-1]), rules.budget, delta_v_slot_m_s, arrays)
        if self.loads is None and rules.budget > spendable(self.network, rules.duration):
            self.slot = max(self.slot, rules.budget)  # nothing is short of ΔV, so none is counted
        self.top = math.floor(rules.budget / self.slot + SLACK)
        self.width = (self.top // simd.LANES + 1) * simd.LANES
        self._jobs = jobs
        self.buckets = fill(
            self.network, assignment, rules.budget, self.slot, parts=paid.parts, jobs=jobs
        )
        self.layers = layers_of(self.loads, self.slot, self.top, self.width)
        size = layers, (int(self.buckets.start[-1]) + 1) * self.width
        best, second = np.empty(size, dtype=np.int32), np.empty(size, dtype=np.int32)
        landed = best, second
        if self.layers is not None:
            landed = np.empty_like(best), np.empty_like(second)
        self.values = Values(best, second, *landed)
        # Buckets of one stage do not land in it, so their bodies are independent; and a walk has
        # no two legs in one stage.
        self._stages = _stages(self.buckets)
        self.bits = int(bodies).bit_length()
        self.most_legs = len(self._stages) + 1
        self.budget = rules.budget
        self.greatest_prize = float(self.prize.max(initial=0.0)) or 1.0
        # A service may be worth less than nothing by its multiplier, and by what it has lost.
        parts = self.most_legs if rules.falls is None else 2 * self.most_legs
        room = LARGEST / (1 << self.bits) / parts / self.greatest_prize
        # A power of two, so that units are exact numbers.
        self.unit = 2.0 ** -math.floor(math.log2(room))
        self.toll, self.stop = np.empty((1, 0), dtype=np.int32), np.empty(0, dtype=np.int32)
        self.falls = rules.falls
        self.fall = prize_losses(self.network, self.buckets, rules.falls, self.unit, self.bits)
        self.time_price = 0.0
        self.price, self.worths, self.flown = np.zeros(1), self.prize, np.zeros(bodies)
        self.tank = np.array([rules.budget]) if self.loads is None else np.array(self.loads.first)
        self.constant = np.zeros(self.tank.size)
        self._begun = np.empty(bodies, dtype=np.int64)
        self._common: tuple[object, ...] = ()
        self._kept: np.ndarray | None = None
        self._walk = np.empty(self.most_legs + 1, dtype=np.int64)
        self.walk = self._walk[:0]
        self._pool = ThreadPoolExecutor(jobs) if jobs > 1 else None

    @property
    def dimensions(self) -> int:
        """Number of multipliers: one for each body."""
        return int(self.prize.size)

    @property
    def total(self) -> float:
        """The sum of all prizes: the bound if multipliers are equal to prizes."""
        return float(self.prize[self.is_target].sum())

    @property
    def radius(self) -> float:
        """Search radius around the best multipliers."""
        return self.greatest_prize

    def first_point(self) -> np.ndarray:
        """Initial multipliers: bonuses, which would otherwise let walks cycle."""
        return self._bonuses.copy()

    def allowed(self, point: np.ndarray) -> np.ndarray:
        """Nearest multipliers at which the bound can be evaluated."""
        point = np.clip(point, 0.0, self.prize + self.greatest_prize)
        point[~self.is_target] = 0.0
        return point

    def at(self, point: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """Bound near a point, with its exact multipliers and its subgradient."""
        value, rounded = self.evaluate(point)
        slope = 1.0 - np.bincount(self.walk, minlength=self.prize.size)
        slope[~self.is_target] = 0.0
        return value, rounded, slope

    def _sweep(self, sweep_until: Callable[..., None], *common: object) -> None:
        """Sweep backwards in time, stage by stage, with bodies shared among threads."""
        for time in self._stages:
            if self._over():
                raise TimeIsOver
            if self._pool is None:
                sweep_until(*common, 0, 1, time)
                continue
            parts = [
                self._pool.submit(sweep_until, *common, first, self._jobs, time)
                for first in range(self._jobs)
            ]
            for part in parts:
                part.result()

    def close(self) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()

    def evaluate(self, multipliers: np.ndarray, *, keep: bool = False) -> tuple[float, np.ndarray]:
        """The bound for given multipliers.

        Parameters
        ----------
        multipliers : (bodies,) float64
            π of each target, at least 0 and at most its prize plus the largest prize; and of each
            refuelling at a station, where they are :attr:`is_paid`. Others count for nothing.
        keep : bool
            Take the multipliers as they are, and round what services are worth up to units, which
            relaxes; otherwise round the multipliers so that there is nothing to round.

        Returns
        -------
        bound : float
            No plan has a larger objective; −inf if there is none at all.
        multipliers : (bodies,) float64
            Those for which the bound holds.

        Raises
        ------
        TimeIsOver
            It was broken off.
        """
        whole = np.floor(self.prize / self.unit)
        least = np.rint(-self.greatest_prize / self.unit)
        if keep:
            rounded = np.array(multipliers)
            gain = np.maximum(np.ceil((self.prize - rounded) / self.unit), least)
        else:
            gain = np.rint((self.prize - multipliers) / self.unit)
            gain = np.clip(gain, least, whole)
            rounded = self.prize - gain * self.unit
        gain[~self.is_paid], rounded[~self.is_paid] = 0.0, 0.0
        code = (gain.astype(np.int64) << self.bits) + np.arange(gain.size)
        code = code.astype(np.int32)
        self._kept = None
        self._sweep_all(code)
        self._kept = rounded if keep else None
        value, self.walk = self.best_from(0)
        return value + math.fsum(rounded), rounded

    def _sweep_all(self, code: np.ndarray) -> None:
        """Values of all states; ``code`` holds the packed worth of each service."""
        terms = WalkTerms(code, self.toll, self.stop, self.fall, self.bits, self.width, self.top)
        self._common = self.buckets, self.values, self.layers, terms
        begin(*self._common, self._begun)
        self._sweep(sweep_until, *self._common, self._begun)

    def holds(self, multipliers: np.ndarray) -> bool:
        """Whether the last evaluation used exactly these multipliers."""
        return self._kept is not None and np.array_equal(self._kept, multipliers)

    def ahead(self, number: int) -> float:
        """Unpaid time before a mission begins, by number of the mission."""
        return self.time_price * float(self.since[number] - self.since[0])

    def best_from(self, number: int) -> tuple[float, np.ndarray]:
        """Value and bodies of the best walk of a mission, by number, in the last evaluation.

        −inf if there is no walk: the mission cannot end where it must.
        """
        tops = np.array([self.top]) if self.layers is None else self.layers.tops
        tops = np.clip(np.floor(self.tank / self.slot + SLACK).astype(np.int64), 0, tops)
        root, start = int(self.buckets.roots[number]), self._starts[number]
        found = self.values.best[np.arange(tops.size), (root + 1) * self.width + tops] >> self.bits
        possible = (found >= -LARGEST >> self.bits) & (self.tank >= 0.0)
        if not possible.any():
            return -math.inf, self._walk[:0]
        paid = np.floor((self.constant - self.ahead(number)) / self.unit)
        worth = np.where(possible, found - paid, -np.inf)
        kits = int(np.argmax(worth))
        state = WalkState(root, start, kits, int(tops[kits]))
        length = trace(*self._common, state, self._walk)
        return float(worth[kits]) * self.unit, self._walk[:length].copy()


def prize_losses(
    network: Network, buckets: Buckets, falls: Falls | None, unit: float, bits: int
) -> np.ndarray | None:
    """Lower bounds on the losses of prizes of services that end in each bucket.

    A leg that lands in an earlier bucket than another one ends no later, so what is left out for
    its sake has lost no less.

    Parameters
    ----------
    network : Network
        With ends of services, where prizes fall.
    buckets : Buckets
        Of the network.
    falls : Falls or None
    unit : float
        Prize that one unit of value is worth.
    bits : int
        Of the next body in a packed value.

    Returns
    -------
    (buckets,) int32 or None
        Packed as values are; None where no prize falls.
    """
    if falls is None:
        return None
    earliest = np.full(buckets.opens.size, np.inf)
    landing = buckets.of_row[network.landing]
    np.minimum.at(earliest, landing, network.end)
    made = np.zeros(earliest.size, dtype=np.int64)
    for body in np.flatnonzero(np.diff(falls.first)):
        steps = slice(falls.first[body], falls.first[body + 1])
        own = slice(buckets.start[body], buckets.start[body + 1])
        lost = np.append(0.0, falls.lost[steps])[np.searchsorted(falls.until[steps], earliest[own])]
        # Nothing lands where there is no earliest end.
        lost[np.isinf(earliest[own])] = 0.0
        made[own] = np.floor(lost / unit).astype(np.int64) << bits
    return made.astype(np.int32)
