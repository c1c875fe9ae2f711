"""Small missions at random, whose optimum a brute force can find, and their networks."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import adr_opt
from adr_opt.mission.mission import Mission
from adr_opt.problem.bodies import Station
from adr_opt.problem.chasers import AtStation, Chaser, InOrbit
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


def featured_mission(seed):
    """A random mission with several stations or none, a start of its own, windows, ends by turns.

    Some of its targets are required, some share an orbit, some are worth nothing.
    """
    rng = np.random.default_rng([7, seed])
    instance = random_mission(seed).instance
    targets = instance.targets
    if seed % 5 == 0:
        targets = (targets[0], targets[1].replace(orbit=targets[0].orbit), *targets[2:])
    duration = instance.mission.duration_s
    stations = instance.stations[: int(rng.integers(0, 2))]
    if len(targets) > 2 and rng.random() < 0.4:
        stations += (Station(name="second", orbit=targets[-1].orbit),)
        targets = targets[:-1]
    start = InOrbit(orbit=instance.stations[0].orbit)
    if stations and rng.random() < 0.6:
        start = AtStation(station=stations[int(rng.integers(len(stations)))].name)
    end = "anywhere"
    if stations and rng.random() < 0.5:
        end = AtStation(station=stations[int(rng.integers(len(stations)))].name)
    if rng.random() < 0.5:
        opens = rng.uniform(0.0, 0.6, len(targets)) * duration
        closes = opens + rng.uniform(0.05, 0.9, len(targets)) * duration
        targets = tuple(
            target.replace(window_s=(float(opens[at]), float(closes[at]) if at % 3 else None))
            for at, target in enumerate(targets)
        )
    if rng.random() < 0.3:
        targets = (*targets[:-1], targets[-1].replace(required=True))
    begin = float(rng.choice([0.0, 0.2])) * duration * float(rng.random())
    chaser = Chaser(
        name="chaser",
        start=start,
        end=end,
        available_s=(begin, None if seed % 2 else 0.9 * duration),
        max_targets=[None, None, 1, 2][int(rng.integers(4))],
        tank=instance.chaser.tank,
    )
    return Mission(
        instance.replace(stations=stations, targets=targets, chasers=(chaser,)), threads=1
    )


def network_of(mission):
    """The network of a mission, as the models get it."""
    return of_rows(build(mission, jobs=1), mission.rules)
