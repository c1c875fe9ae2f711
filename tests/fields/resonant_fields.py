"""Small missions whose legs end when the next ones begin, but for rounding."""

from __future__ import annotations

import math

import numpy as np

from adr_opt.common.constants import EARTH_RADIUS_M, MU_M3_S2
from adr_opt.problem.bodies import Station, Target
from adr_opt.problem.chasers import AtStation, Chaser, Tank
from adr_opt.problem.instance import Instance
from adr_opt.problem.orbit import Orbit
from adr_opt.problem.settings import KeepOutZone, MissionSettings, TransferSettings
from adr_opt.sources.generator import EPOCH

RARE = (63, 842, 883, 1005)
"""Seeds where a chaser is ready at 0 just after the first event, and where costs tie."""


PERIOD_S = 2.0 * math.pi * math.sqrt((EARTH_RADIUS_M + 700e3) ** 3 / MU_M3_S2)


def resonant(seed: int) -> Instance:
    """Bodies whose legs end when the next ones begin, but for rounding.

    By turns planes share their RAAN, their inclination, or everything and altitudes differ;
    latitudes are quarters of a turn, services half periods, and the stand-off is next to nothing.
    """
    rng = np.random.default_rng(seed)

    def orbit() -> Orbit:
        steps = [float(rng.integers(-2, 3)) if seed % 3 == kind else 0.0 for kind in range(3)]
        return Orbit(
            semi_major_axis_m=EARTH_RADIUS_M + 700e3 + 5e3 * (steps[2] + abs(steps[2])),
            eccentricity=0.0,
            inclination_deg=90.0 + steps[0],
            raan_deg=steps[1],
            argument_of_perigee_deg=0.0,
            true_anomaly_deg=float(rng.choice([0.0, 0.0, 90.0, 180.0, 1e-9])),
        )

    zone = KeepOutZone(
        min_altitude_m=700e3,
        max_altitude_m=720e3,
        start_s=float(rng.choice([0.0, 2.0 * PERIOD_S])),
        end_s=float(rng.choice([2.0, 3.5, 4.0])) * PERIOD_S,
    )
    station = Station(name="station", orbit=orbit())
    targets = tuple(
        Target(name=f"t{number}", prize=float(rng.choice([1.0, 1.0, 2.0, 0.7])), orbit=orbit())
        for number in range(int(rng.integers(2, 5)))
    )
    duration_s = PERIOD_S * float(rng.choice([6.5, 9.0, 10.5, 13.0, 14.0]))
    tank = Tank(delta_v_m_s=float(rng.uniform(100.0, 900.0)))
    service, refuelling = (float(rng.choice([0.0, 0.5, 1.0])) for _ in range(2))
    standoff_m = float(rng.choice([0.0, 0.0, 1e-6, 1e-4, 9e-4]))
    time_value_m_s_per_h = float(rng.choice([0.0, 75.0]))
    instance = Instance(
        name=f"resonant-{seed}",
        epoch=EPOCH,
        stations=(station,),
        targets=targets,
        chasers=(Chaser(name="chaser", start=AtStation(station="station"), tank=tank),),
        mission=MissionSettings(
            duration_s=duration_s, service_revolutions=service, refuel_revolutions=refuelling
        ),
        transfer=TransferSettings(
            standoff_m=standoff_m,
            max_altitude_m=float(rng.choice([700e3, 2000e3])),
            max_phasing_revolutions=3,
        ),
        keep_out_zones=(zone,) if seed % 4 == 0 else (),
    )
    return instance.with_time_value(time_value_m_s_per_h)
