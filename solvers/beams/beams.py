"""Beam search over partial plans: the kernel shared by constructive planners.

Level by level: a state of level n has serviced n targets, and its successors are all targets that
can be reached from it directly or after a refuelling on the way (refuelling is part of the move,
so that a level never mixes states before and after it). The `width` best states of a level
survive; of states with the same targets visited and the same body only those that are not later
*and* poorer in ΔV than another are kept: a chaser that is earlier and richer may wait and do all
that the other one can. The states move on the timetable of the mission's choice, so a beam is
exhaustive about where to go, never about when.

States are ordered by a weighted sum, smaller first:

    time_weight · end − delta_v_weight · ΔV left − prizes collected

or, where latest times are known (:mod:`solvers.walks.latest_times`), by the mean of that and of
the worth of the time by which they are later than they may be if the goal is to be reached.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from adr_opt.common.constants import HOUR_S
from adr_opt.common.stop import Stop
from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.tables.timetable import asks
from adr_opt.mission.mission import Mission

from ..progress.halting import halted_by
from ..walks.latest_times import Latest, no_latest
from . import levels
from .exchange_rates import worth_of
from .levels import BeamContext, LevelScratch, Weights

FloatArray = npt.NDArray[np.float64]

USUAL = -1.0
"""Value of an option that stands for the usual one."""

CANDIDATES = 8
"""Number of candidates examined per kept state: some are dominated, stranded, or at a full body."""

LEAST_CANDIDATES = 1024
"""Least number of candidates, for narrow beams: at the end of a tank the best are all stranded."""

HURRIED = 20
"""Number of states kept on the remaining levels once time is over: about ten milliseconds."""

HURRIED_ASKING = 2
"""Number of states kept then if rows are computed on demand."""


@dataclass(frozen=True)
class BeamSettings:
    """Ordering and selection of states in a beam search.

    Attributes
    ----------
    width : int
        States kept on each level.
    time_weight : float
        Worth of an hour [prizes per h].
    delta_v_weight : float
        Worth of a km/s of ΔV left [prizes per km/s].
    crowding : float
        Most states at one body, as a multiple of an equal share; +inf for no limit.
    noise : float
        Width of the random number, uniform and the same for one state in one search, that is
        added to its score [prizes]: makes searches of different seeds differ.
    guarded : bool
        Keep states that can neither refuel nor do without only where there is room after all other
        candidates. Narrow beams strand themselves without this guard.
    """

    width: int
    time_weight: float
    delta_v_weight: float
    crowding: float = 1.7
    noise: float = 0.0
    guarded: bool = True


def with_time_value(mission: Mission, time_value_m_s_per_h: float = USUAL) -> Mission:
    """The mission with the usual choice of connections for beams, or with a given one."""
    if time_value_m_s_per_h < 0.0:
        time_value_m_s_per_h = TIME_VALUE_M_S_PER_H * mission.instance.hurry
    return mission.with_time_value(time_value_m_s_per_h)


def usual_settings(mission: Mission, width: int) -> BeamSettings:
    """Settings from the mission's worth of an hour and of a km/s."""
    worth = worth_of(mission)
    return BeamSettings(width, worth.hour, worth.kilometre_per_s)


@kernel
def beam_kernel(rules, done, first, guide, guided, weights, halt):
    """Beam search from states at the same body with the same serviced targets.

    Parameters
    ----------
    rules : Rules
    done : (bodies,) bool
        Targets that are done.
    first : tuple
        Body, targets since the last refuelling, kits aboard, (states,) int64, and (states,) float64
        each: time ready [s], ΔV left [m/s], ΔV spent [m/s], and what prizes have fallen by. At most
        ``width`` are taken.
    guide : Latest
        Not looked at unless ``guided``.
    guided : bool
    weights : Weights
    halt : (1,) bool
        Once another thread sets it, only the best states of each level are gone on with, so that
        the search ends soon, with a plan to the end of the mission.

    Returns
    -------
    sequence : (moves,) int64
        What the best plan found goes on with: most prize, then least ΔV.
    prize, delta_v : float
        Of the whole plan.
    priced : int
        Number of candidates priced.
    """
    bodies, width = rules.service.size, weights.width
    words = (bodies + 63) // 64
    level, after = levels.new_level(width, words), levels.new_level(width, words)
    keys = np.empty(bodies, np.uint64)
    serviced = 0
    for j in range(bodies):
        keys[j] = levels.key_of(j, weights.seed)
        serviced += done[j]
    remaining = min(bodies - rules.first_target, rules.limits.targets) - serviced
    search = BeamContext(rules, guide, guided, weights, keys)
    size = levels.begin(search, done, first, serviced, level)

    parent_of = np.empty((remaining, width), np.int32)
    move_of = np.empty((remaining, width), np.int32)
    via_of = np.empty((remaining, width), np.int32)
    best_prize, best_spent, best_level, best_at = level.prize[0], level.spent[0], -1, -1

    wanted = max(CANDIDATES * width, LEAST_CANDIDATES)
    cand = levels.new_candidates(max(4 * wanted, 4096))
    buckets = 1
    while buckets < 4 * width:
        buckets *= 2
    which = np.empty(width, np.int64)
    scratch = LevelScratch(
        np.empty(buckets, np.int32),
        np.empty(width, np.int32),
        np.empty(bodies, np.int64),
        np.empty(cand.score.size, np.int64),
        which,
    )
    most, few = width, HURRIED_ASKING if asks(rules.table) else HURRIED
    depth, priced = 0, 0
    while depth < remaining and size > 0:
        if halt[0]:
            size = min(size, few)
            most = min(width, few)
        share = most
        if weights.crowding < remaining:
            share = max(1, math.ceil(weights.crowding * most / remaining))
        count, looked_at = levels.succeed(search, level, size, wanted, cand)
        priced += looked_at
        room = levels.LevelRoom(most, share)
        size = levels.keep(search, level, cand, count, room, scratch, after)
        for s in range(size):
            parent_of[depth, s] = cand.parent[which[s]]
            move_of[depth, s], via_of[depth, s] = cand.move[which[s]], cand.via[which[s]]
            if after.prize[s] > best_prize or (
                after.prize[s] == best_prize and after.spent[s] < best_spent
            ):
                best_prize, best_spent = after.prize[s], after.spent[s]
                best_level, best_at = depth, s
        level, after = after, level
        depth += 1

    backwards = np.empty(2 * remaining, np.int64)
    length = 0
    while best_level >= 0:
        backwards[length] = move_of[best_level, best_at]
        length += 1
        if via_of[best_level, best_at] != levels.STRAIGHT:
            backwards[length] = via_of[best_level, best_at]
            length += 1
        best_at = parent_of[best_level, best_at]
        best_level -= 1
    return backwards[:length][::-1].copy(), best_prize, best_spent, priced


def beam_search(
    mission: Mission,
    settings: BeamSettings,
    *,
    guide: Latest | None = None,
    prefix: tuple[int, ...] = (),
    seed: int = 0,
    stop: Stop | None = None,
) -> tuple[npt.NDArray[np.int64], float, float, int]:
    """One beam search; see :func:`beam_kernel` for arguments and results.

    The sequence returned includes the prefix, which is a legal one; the search goes on from all
    ways to fly it that are worth having. When ``stop`` has no time left, it is hurried to its end.
    """
    rules = mission.rules
    done = np.zeros(rules.service.size, dtype=np.bool_)
    since = 0
    for j in prefix:
        done[j] = not rules.is_station[j]
        since = since + 1 if done[j] else 0
    body = prefix[-1] if prefix else rules.start
    weights = Weights(
        settings.width,
        settings.time_weight / HOUR_S,
        settings.delta_v_weight / 1000.0,
        settings.crowding,
        settings.noise,
        settings.guarded,
        seed,
    )
    first = _ways_to_fly(mission, prefix)
    with halted_by(stop) as halt:
        found, prize, delta_v, priced = beam_kernel(
            rules,
            done,
            (body, since, *first),
            no_latest() if guide is None else guide,
            guide is not None,
            weights,
            halt,
        )
    return np.concatenate([np.array(prefix, dtype=np.int64), found]), prize, delta_v, priced


def _ways_to_fly(
    mission: Mission, prefix: tuple[int, ...]
) -> tuple[npt.NDArray[np.int64], FloatArray, FloatArray, FloatArray, FloatArray]:
    """Undominated ways to fly a prefix, with all possible numbers of remaining kits.

    Returns
    -------
    kits : (ways,) int64
    ready, left, spent, lost : (ways,) float64
        [s], [m/s], [m/s], and what prizes have fallen by.
    """
    ways = list(mission.schedules.ways(prefix))
    fronts = [front for _, front in ways]
    paid = [mission.schedules.lost_and_cost(front) for front in fronts]
    return (
        np.concatenate([np.full(front.ready.size, kits, dtype=np.int64) for kits, front in ways]),
        np.concatenate([front.ready for front in fronts]),
        np.concatenate([front.left for front in fronts]),
        np.concatenate([cost for _, cost in paid]),
        np.concatenate([lost for lost, _ in paid]),
    )


TIME_VALUE_M_S_PER_H = 110.0
"""Value of an hour where beams and windows choose one connection per move; less where planes drift,
as time is cheaper there."""
