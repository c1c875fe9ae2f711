"""Fields with time and ΔV for several services: routes long enough to meet in cuts."""

from __future__ import annotations

import numpy as np
from random_rules import DAY_S, carrying, random_mission, towing

from adr_opt.problem.chasers import Chaser, Tank
from adr_opt.problem.instance import Instance


def roomy(seed: int) -> Instance:
    """Mission of days with a large tank, every rule of random missions on and off."""
    return with_room(random_mission(seed), seed)


def roomy_and_laden(seed: int) -> Instance:
    """The same with kits, and every third time with tows."""
    made = carrying(random_mission(seed), seed)
    return with_room(made if seed % 3 else towing(made, seed), seed)


def roomy_launched(seed: int) -> Instance:
    """The same for a chaser that is launched onto its first target."""
    made = roomy(seed)
    return made.replace(chasers=(made.chaser.replace(start="anywhere"),))


def tight(seed: int) -> Instance:
    """The same with hardly enough time for all targets."""
    return with_room(random_mission(seed), seed, days=(0.5, 1.1))


def with_room(instance: Instance, seed: int, days: tuple[float, float] = (1.5, 3.0)) -> Instance:
    """The same with windows of a few targets only, and chasers that may do more."""
    rng = np.random.default_rng([25, seed])
    duration = DAY_S * float(rng.uniform(*days))

    def freed(chaser: Chaser) -> Chaser:
        most = int(rng.integers(2, 5)) if rng.random() < 0.3 else None
        changed = chaser.replace(available_s=(0.0, None), max_targets=most)
        if isinstance(chaser.tank, Tank):
            return changed.replace(tank=Tank(delta_v_m_s=float(rng.uniform(600.0, 2500.0))))
        return changed

    targets = tuple(
        target if rng.random() < 0.2 else target.replace(window_s=(0.0, None))
        for target in instance.targets
    )
    return instance.replace(
        targets=targets,
        chasers=tuple(freed(chaser) for chaser in instance.chasers),
        mission=instance.mission.replace(
            duration_s=duration, service_s=None, service_revolutions=float(rng.choice([0.5, 2.0]))
        ),
        keep_out_zones=(),
    )
