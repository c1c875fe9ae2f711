"""What walks remember before any search."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hand_made import hand_made

from adr_opt.mission.evidence import WORD
from adr_opt.mission.mission import Mission
from solvers.labels import near_targets
from solvers.networks.network import build


def test_each_body_remembers_the_targets_that_cost_least(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of all targets in reach the nearest ones, there or back, and neither itself nor a station."""
    monkeypatch.setattr(near_targets, "REMEMBERED", 2)
    mission = Mission(hand_made())
    bodies, first = len(mission.names), mission.rules.first_target
    least = np.full((bodies, bodies), math.inf)
    for i in range(bodies):
        for j in range(bodies):
            if i != j:
                least[i, j] = mission.schedules.connections(i, j).delta_v.min(initial=math.inf)
    least = np.minimum(least, least.T)
    least[least > mission.rules.budget] = math.inf
    memory = np.zeros((bodies, 1), dtype=np.int64)
    near_targets.remember_near(memory, build(mission, jobs=1), first, 0.0)
    for i in range(bodies):
        nearest = sorted(range(first, bodies), key=lambda j: least[i, j])[:2]
        nearest = [j for j in nearest if least[i, j] < math.inf]
        remembered = [j for j in range(WORD) if memory[i, 0] >> j & 1]
        assert set(remembered) == set(nearest), i
