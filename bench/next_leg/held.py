"""Missions held back from training, and what a policy collects there: how good a policy is."""

from __future__ import annotations

import numpy as np

from adr_opt.learning.environment.fields import VARIED
from adr_opt.learning.next_leg.scorer import LegScorer
from adr_opt.problem.instance import Instance
from adr_opt.problem.uncertainty import Uncertainty
from adr_opt.sources.generator import generate

from .drawn import MIXED
from .flights import InTraining, Kept, collected, kept

FIRST_SEED = 500
"""Of held fields; published tables have others."""

FAMILIES = ("nominal", "reduced-fuel", "reduced-time", "randomised", "campaign", "planned")
"""`randomised`: budgets, durations and numbers of targets as the environment draws them;
`campaign`: nominal fields with two chasers, each with a tank; `planned`: nominal fields with the
plan of a beam, in uncertain worlds only."""

PLAN_WIDTH = 64

WORLDS = {"known": Uncertainty(), "uncertain": MIXED}


def field(family: str, seed: int) -> Instance:
    """A mission of a family."""
    if family == "campaign":
        return generate("nominal", seed, chasers=2)
    if family == "randomised":
        rng = np.random.default_rng(seed)
        limits = VARIED.draw_limits(rng)
        drawn = generate("nominal", seed, targets=int(rng.integers(20, 61)))
        return drawn.with_limits(limits.duration_s, limits.delta_v_m_s)
    return generate("nominal" if family == "planned" else family, seed)


Held = dict[tuple[str, str], list[Kept]]


def held_missions(count: int, first_seed: int = FIRST_SEED) -> Held:
    """Missions of each family, in known and in uncertain worlds."""
    return {
        (family, world): [
            kept(field(family, seed), uncertainty, width=PLAN_WIDTH * (family == "planned"))
            for seed in range(first_seed, first_seed + count)
        ]
        for family in FAMILIES
        for world, uncertainty in WORLDS.items()
        if (family, world) != ("planned", "known")
    }


def means(missions: Held, scorer: LegScorer) -> dict[tuple[str, str], float]:
    """Mean prize in each family and kind of world, one world a field."""
    return {
        key: float(
            np.mean(
                [
                    collected(mission, InTraining(mission, scorer), seed)[1]
                    for seed, mission in enumerate(those)
                ]
            )
        )
        for key, those in missions.items()
    }
