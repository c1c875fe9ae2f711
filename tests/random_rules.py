"""Random tiny missions in which every rule is on or off."""

from __future__ import annotations

import numpy as np

import adr_opt
from adr_opt.bodies import Station
from adr_opt.chasers import AtStation, InOrbit
from adr_opt.instance import Instance
from adr_opt.settings import MissionSettings, Objective

DAY_S = 86400.0


def random_mission(seed: int) -> Instance:
    """A few targets, with windows, zones, prizes, stations, starts and ends drawn by the seed."""
    rng = np.random.default_rng(seed)

    def chance(share: float) -> bool:
        return bool(rng.random() < share)

    instance = adr_opt.generate(
        "tiny", int(rng.integers(10)), zones=int(rng.choice([0, 0, 3])), targets=5
    )
    duration = DAY_S * float(rng.uniform(0.3, 0.9))
    targets = [
        target.replace(prize=float(rng.choice([0.0, 0.3, 1.0, 1.0, 2.5])))
        for target in instance.targets[: rng.integers(3, 6)]
    ]
    if chance(0.3):
        targets[1] = targets[1].replace(orbit=targets[0].orbit)
    if chance(0.3):
        orbit = targets[2].orbit.replace(inclination_deg=targets[0].orbit.inclination_deg)
        targets[2] = targets[2].replace(orbit=orbit.replace(raan_deg=targets[0].orbit.raan_deg))
    if chance(0.4):
        for number in range(len(targets)):
            if chance(0.4):
                opens = float(rng.uniform(0.0, 0.6)) * duration * chance(0.6)
                closes = float(rng.uniform(opens, duration)) if chance(0.6) else None
                targets[number] = targets[number].replace(window_s=(opens, closes))
    if chance(0.25):
        number = int(rng.integers(len(targets)))
        targets[number] = targets[number].replace(required=True)
    stations = list(instance.stations)
    if chance(0.25):
        there = targets[0].orbit.replace(true_anomaly_deg=77.0)
        stations.append(Station(name="second station", orbit=there))
    chaser = instance.chaser
    changes: dict[str, object] = {}
    if chance(0.2):
        start = stations[0].orbit.replace(true_anomaly_deg=123.0)
        changes["start"] = InOrbit(orbit=start)
        if chance(0.3):
            stations = []
    if stations and chance(0.25):
        changes["end"] = AtStation(station=stations[-1].name)
    if chance(0.2):
        changes["max_targets"] = int(rng.integers(1, 4))
    if chance(0.25):
        begin = float(rng.uniform(0.0, 0.3)) * duration
        changes["available_s"] = (begin, float(rng.uniform(0.7, 1.1)) * duration)
    changes["tank"] = chaser.tank.replace(
        delta_v_m_s=float(rng.choice([150.0, 300.0, 500.0, 900.0]))
    )
    service = (
        {"service_s": float(rng.uniform(0.0, 9000.0))}
        if chance(0.3)
        else {"service_revolutions": float(rng.choice([0.0, 0.5, 1.0]))}
    )
    return instance.replace(
        stations=tuple(stations),
        targets=tuple(targets),
        chasers=(chaser.replace(**changes),),
        mission=MissionSettings(duration_s=duration, **service),
        objective=Objective(cost=str(rng.choice(["delta-v", "delta-v", "duration"]))),
    )
