"""Missions on which the choice of the next leg is trained."""

from __future__ import annotations

import numpy as np

from adr_opt.learning.environment.fields import FIRST_SEED, LAST_SEED, VARIED
from adr_opt.mission.mission import Mission
from adr_opt.problem.instance import Instance
from adr_opt.sources.generator import generate

FAMILIES = ("nominal", "reduced-fuel", "reduced-time", "varied", "many")
"""Families, drawn in equal parts but for `many`, fields of up to 160 targets, which are fewer."""

CHANCES = (0.27, 0.22, 0.22, 0.22, 0.07)

PRIZES, WINDOWS, REQUIRED = 0.35, 0.2, 0.15
"""Shares of missions with unequal prizes, with windows and with required targets."""


def drawn_mission(rng: np.random.Generator, *, domain_randomised: bool) -> Mission:
    """A mission of a family, with other rules now and then.

    Parameters
    ----------
    rng : Generator
    domain_randomised : bool
        Whether budgets and durations differ from those of the three benchmark families.
    """
    name = str(rng.choice(FAMILIES, p=CHANCES))
    seed = int(rng.integers(FIRST_SEED, LAST_SEED))
    if name == "many":
        instance = generate("nominal", seed, targets=int(rng.integers(70, 161)))
    elif name == "varied" and domain_randomised:
        instance = VARIED.draw_field(rng)
        limits = VARIED.draw_limits(rng)
        instance = instance.with_limits(limits.duration_s, limits.delta_v_m_s)
    else:
        instance = generate("nominal" if name == "varied" else name, seed)
    return Mission(_with_wishes(instance, rng))


def _with_wishes(instance: Instance, rng: np.random.Generator) -> Instance:
    """The instance with prizes, windows or required targets of its own, now and then."""
    targets, duration_s = list(instance.targets), instance.mission.duration_s
    if rng.random() < PRIZES:
        drawn = np.round(rng.gamma(2.0, 0.5, len(targets)) + 0.1, 2)
        targets = [
            each.replace(prize=float(prize)) for each, prize in zip(targets, drawn, strict=True)
        ]
    if rng.random() < WINDOWS:
        for at in rng.choice(len(targets), len(targets) // 3, replace=False):
            opens = float(rng.uniform(0.0, 0.6)) * duration_s
            closes = opens + float(rng.uniform(0.15, 0.5)) * duration_s
            targets[at] = targets[at].replace(window_s=(opens, closes))
    if rng.random() < REQUIRED:
        for at in rng.choice(len(targets), 3, replace=False):
            targets[at] = targets[at].replace(required=True)
    return instance.replace(targets=tuple(targets))
