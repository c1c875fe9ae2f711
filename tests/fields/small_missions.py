"""Small missions at random, whose optimum a brute force can find, and their networks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import random_rules

import adr_opt
from adr_opt.mission.mission import Mission
from solvers.models.solver_network import of_rows
from solvers.networks.network import build

INSTANCES = Path(__file__).parents[2] / "instances" / "tiny"
TINY = sorted(INSTANCES.glob("tiny-[0-9][0-9][0-9].json"))
DAY_S = 86400.0


def random_mission(seed, *, zones=True):
    """2–6 targets, a random tank and mission; zones, unequal and non-integer prizes by turns."""
    rng = np.random.default_rng(seed)
    targets = int(rng.integers(2, 7))
    instance = adr_opt.generate("tiny", seed, targets=targets, zones=3 * (zones and seed % 3 == 0))
    limits = {
        "duration_s": DAY_S * float(rng.uniform(0.5, 2.0 if targets < 5 else 1.5)),
        "delta_v_m_s": float(rng.uniform(300.0, 1500.0)),
    }
    prizes = [
        np.ones(targets),
        rng.integers(0, 6, targets) * 2.0,
        np.round(rng.uniform(0.0, 3.0, targets), 3),
    ][seed % 4 % 3]
    return Mission(
        instance.replace(
            targets=tuple(
                target.replace(prize=float(prize))
                for target, prize in zip(instance.targets, prizes, strict=True)
            )
        ).with_limits(**limits),
        threads=1,
    )


def ruled_mission(seed):
    """A random mission with every rule on or off."""
    return Mission(random_rules.random_mission(seed), threads=1)


def network_of(mission):
    """The network of a mission, as the models get it."""
    return of_rows(build(mission, jobs=1), mission.rules)
