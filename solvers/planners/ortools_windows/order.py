"""An order of bodies with its undominated schedules, from which windows are cut."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.core.memory import borrowed
from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.mission.mission import Mission
from adr_opt.mission.schedule import FloatArray, Front, Schedule

from ...beams.greedy_order import greedy_sequence
from .window_network import SlackWorth, state_at

Bodies = npt.NDArray[np.int64]


class Pace(NamedTuple):
    """One schedule of an order.

    Attributes
    ----------
    value : float
        What it is worth by the measure that it was chosen by.
    bodies : (moves + 1,) int64
        Where the chaser is before each move, and in the end.
    times, lefts, costs : (moves + 1,) float64
        Since when [s], ΔV left [m/s] and ΔV of all moves before [m/s].
    """

    value: float
    bodies: Bodies
    times: FloatArray
    lefts: FloatArray
    costs: FloatArray


class ClosedOrder:
    """A flyable order of bodies, with a legal end.

    Its best schedule counts in the end. That of least ΔV may take all the time there is; windows
    begin from the one that is best by their own measure of time and ΔV.

    Parameters
    ----------
    mission : Mission
    moves : (moves,) int64
        Legal.

    Attributes
    ----------
    moves : (moves,) int64
    timing : Schedule
        The best one by the mission's measure.
    """

    def __init__(self, mission: Mission, moves: Bodies) -> None:
        self._mission = mission
        self.moves = moves
        self.timing: Schedule = mission.time(moves.tolist())
        self._fronts: tuple[Front, ...] = mission.schedules.fronts(tuple(moves.tolist()))

    @property
    def targets(self) -> int:
        """Number of targets."""
        return int(np.count_nonzero(self.moves >= self._mission.rules.first_target))

    def pace(self, worth: SlackWorth) -> Pace:
        """The schedule of greatest worth, over all connections."""
        last = self._fronts[-1]
        lost, cost = self._mission.schedules.lost_and_cost(last)
        values = -worth.per_m_s * cost - worth.per_s * last.ready - lost
        label = int(values.argmax())
        most = float(self._mission.rules.prize[self.moves].sum())
        value = most + float(values[label])
        states = np.empty((3, self.moves.size + 1))
        for at in range(self.moves.size, -1, -1):
            front = self._fronts[at]
            cost = self._mission.schedules.lost_and_cost(front)[1][label]
            states[:, at] = front.ready[label], front.left[label], cost
            label = int(front.parent[label])
        bodies = np.concatenate(([self._mission.rules.start], self.moves)).astype(np.int64)
        return Pace(value, bodies, *states)


def flown(mission: Mission, moves: Bodies) -> ClosedOrder | None:
    """The order of some moves, with a legal end; None if no schedule flies it completely."""
    closed = np.array(mission.closed(moves.tolist()), dtype=np.int64)
    rules = mission.rules
    if not rules.may_end[closed[-1] if closed.size else rules.start]:
        return None
    order = ClosedOrder(mission, closed)
    return order if order.timing.made == closed.size else None


def filled(layer: Mission, order: ClosedOrder, worth: SlackWorth, time_value: float) -> ClosedOrder:
    """An order filled up by the connections that the layer chooses.

    Parameters
    ----------
    layer : Mission
    order : ClosedOrder
    worth : SlackWorth
        By which schedules are chosen.
    time_value : float
        Of greedy appending [m/s per s].
    """
    rules = layer.rules
    made = order.moves.size
    longer = greedy_sequence(layer, order.moves, beta=time_value)
    # The choice may be unable to fly what a schedule over all connections can.
    if longer.size > made and np.array_equal(longer[:made], order.moves):
        found = flown(layer, longer)
        if found is not None and found.timing.objective > order.timing.objective:
            order = found
    while True:
        pace = order.pace(worth)
        target, place = best_insertion(
            rules, order.moves, pace.bodies, pace.times, pace.lefts, order.targets
        )
        if target < 0:
            return order
        found = flown(layer, np.insert(order.moves, place, target))
        if found is None:
            return order
        order = found


@kernel
def best_insertion(rules, sequence, bodies, times, lefts, count):
    """The best target to insert such that all later moves stay legal.

    Of the largest prize that fits, the place with the earliest end of the plan.

    Parameters
    ----------
    sequence : (moves,) int64
    bodies, times, lefts : (moves + 1,)
        Where the chaser is before each move, the end included; since when [s]; ΔV left [m/s].
    count : int
        Targets of the sequence.

    Returns
    -------
    target, place : int
        Target −1 for none.
    """
    rules = borrowed(rules)
    given = np.zeros(rules.service.size, dtype=np.bool_)
    for j in sequence:
        given[j] = True
    best, best_place, best_prize, best_end = -1, -1, 0.0, math.inf
    if count >= rules.limits.targets:
        return best, best_place
    for place in range(sequence.size + 1):
        for new in range(rules.first_target, given.size):
            prize = rules.prize[new]
            if given[new] or prize <= 0.0 or prize < best_prize:
                continue
            state = state_at(rules, bodies[place], times[place], lefts[place])
            legal, _, state = rule_kernels.step(rules, state, new)
            at = place
            while legal and at < sequence.size:
                legal, _, state = rule_kernels.step(rules, state, sequence[at])
                at += 1
            if legal and (prize > best_prize or state.resources.time < best_end):
                best, best_place, best_prize, best_end = new, place, prize, state.resources.time
    return best, best_place
