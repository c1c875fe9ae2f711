"""The best that moves by one timetable's choices can do: the yardstick of heuristics on a layer.

A layer leaves connections out, so its best plan may be worse than the best of the mission. Being
early is no gain for sure there, so that nothing can be left out: all sequences of moves are made.
"""

from __future__ import annotations

import numpy as np

from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.rules import resources as resource_kernels
from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.kernels.rules.rules import State
from adr_opt.mission.mission import Mission


@kernel
def _best(rules, most):
    """Depth first over all legal moves: the most that targets are worth."""
    bodies = rules.service.size
    visited = np.zeros(bodies, np.bool_)
    tried = np.zeros(most + 1, np.int64)
    body = np.zeros(most + 1, np.int64)
    held, worth = resource_kernels.columns(most + 1), np.zeros(most + 1)
    start = rule_kernels.beginning(rules)
    body[0] = start.body
    resource_kernels.put(held, 0, start.resources)
    depth, best = 0, -np.inf
    while depth >= 0:
        if tried[depth] == 0 and rules.may_end[body[depth]]:
            best = max(best, worth[depth])
        j = tried[depth]
        tried[depth] += 1
        if j == bodies or depth == most:
            visited[body[depth]] = False
            depth -= 1
            continue
        state = State(body[depth], resource_kernels.at(held, depth))
        if not rule_kernels.may_go(rules, state, visited, j):
            continue
        legal, _, after = rule_kernels.step(rules, state, j)
        if legal:
            worth[depth + 1] = worth[depth] + rules.prize[j]
            visited[j] = not rules.is_station[j]
            depth += 1
            tried[depth] = 0
            body[depth] = after.body
            resource_kernels.put(held, depth, after.resources)
    return best


def best_on_layer(mission: Mission, time_value_m_s_per_h: float | None = None) -> float:
    """The most prizes on the layer of a time value, the mission's own by default."""
    if time_value_m_s_per_h is not None:
        mission = mission.with_time_value(time_value_m_s_per_h)
    targets = len(mission.instance.targets)
    return float(mission.shown(_best(mission.rules, 2 * targets + 1)))


def replayed(mission: Mission, sequence: list[int]) -> tuple[int, float]:
    """Number of moves of a sequence possible on the layer of a mission, and their end."""
    rules = mission.rules
    visited = np.zeros(len(mission.names), dtype=np.bool_)
    ends, lefts = np.empty((2, len(sequence)))
    made, _, state = rule_kernels.replay(
        rules,
        np.array(sequence, dtype=np.int64),
        rule_kernels.beginning(rules),
        visited,
        ends,
        lefts,
    )
    return made, float(state.resources.time)
