"""Missions flown by a scorer alone, as they are planned: how good it is."""

from __future__ import annotations

import numpy as np

from adr_opt.learning.environment.fields import FIRST_SEED
from adr_opt.learning.next_leg.scorer import LegScorer
from adr_opt.mission.mission import Mission
from adr_opt.sources.generator import generate

from . import walks

HELD = {"nominal": 1.0, "reduced-fuel": 1.0, "reduced-time": 1.0}


def held_missions(count: int) -> dict[str, list[Mission]]:
    """Missions of three families that are never drawn for training."""
    first = FIRST_SEED - 1000
    return {
        name: [Mission(generate(name, first + number)) for number in range(count)] for name in HELD
    }


def flown_by(mission: Mission, scorer: LegScorer) -> int:
    """Number of targets serviced without any plan."""
    at = walks.unplanned(mission)
    while True:
        choices, legs, numbers = at.seen()
        if choices.bodies.size == 0:
            return int(at.visited.sum())
        scores = scorer.scores(legs, numbers, choices.legal)
        for choice in np.argsort(-scores):
            if at.is_guarded(int(choices.bodies[choice])):
                break
        else:
            choice = np.argmax(scores)
        at.move(int(choices.bodies[choice]))


def means(missions: dict[str, list[Mission]], scorer: LegScorer) -> dict[str, float]:
    """Mean number of targets serviced in each family."""
    return {
        name: float(np.mean([flown_by(mission, scorer) for mission in those]))
        for name, those in missions.items()
    }
