"""GTOC9 as an instance: 123 required targets, kits, and launches one after another.

The rules are those of the contest (Izzo and Märtens, Acta Futura 11, 2018, 11–24), in the words of
docs/files.md; times count from the first day on which a mission may begin.
"""

from __future__ import annotations

import math
from datetime import UTC, datetime, timedelta

from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M
from adr_opt.kernels.orbits import ephemeris
from adr_opt.problem.instance import Instance, instance_of
from adr_opt.sources.catalogue.propagation import true_anomaly

from ..reading import FloatArray
from .campaign import FIRST_D, LAST_D, PREFIX
from .expense import DRY_KG, KIT_KG, LAUNCH_MEUR, MOST_PROPELLANT_KG, PER_KG2_MEUR
from .scoring import APART_D, STAY_D, WITHIN_D

ISP_S = 340.0
LOWEST_PERIGEE_M, HIGHEST_M = 6600e3, EARTH_RADIUS_M + 2000e3
"""Limits of drift orbits, as radii: the contest's, and one that no winning leg comes near."""

CHASERS = 12
"""Launches that there may be."""


def contest(rows: FloatArray, step_d: float) -> Instance:
    """The contest as an instance.

    Parameters
    ----------
    rows : (debris, columns) float64
        Of :func:`.debris.read_debris`, angles at MJD2000 0.
    step_d : float
        Step of the grid of connections [d].
    """
    epoch = datetime(2000, 1, 1, tzinfo=UTC) + timedelta(days=FIRST_D)
    tank = {"dry_mass_kg": DRY_KG, "propellant_kg": MOST_PROPELLANT_KG, "isp_s": ISP_S}
    chaser = {
        "start": "anywhere",
        "tank": tank,
        "kits": None,
        "kit_mass_kg": KIT_KG,
        "expense": {"fixed": LAUNCH_MEUR, "per_kg": 0.0, "per_kg_squared": PER_KG2_MEUR},
    }
    content = {
        "format": "adr-opt-instance/2",
        "name": "gtoc9",
        "epoch": epoch.strftime("%Y-%m-%dT%H:%M:%SZ"),
        "dynamics": "j2",
        "stations": [],
        "targets": [
            {
                "name": f"{PREFIX}{number}",
                "orbit": _orbit(row),
                "prize": 1.0,
                "required": True,
                "removal": "kit",
            }
            for number, row in enumerate(rows)
        ],
        "chasers": [{"name": f"mission-{number + 1}", **chaser} for number in range(CHASERS)],
        "mission": {
            "duration_s": (LAST_D - FIRST_D) * DAY_S,
            "service_s": STAY_D * DAY_S,
            "mission_separation_s": APART_D * DAY_S,
        },
        "transfer": {
            "min_altitude_m": LOWEST_PERIGEE_M - EARTH_RADIUS_M,
            "max_altitude_m": HIGHEST_M - EARTH_RADIUS_M,
            "drift_step_s": step_d * DAY_S,
            "max_drift_s": (WITHIN_D - STAY_D) * DAY_S,
            "max_leg_s": WITHIN_D * DAY_S,
        },
        "objective": {"cost": "expense"},
    }
    return instance_of(content)


def _orbit(row: FloatArray) -> dict[str, float]:
    """An orbit at the first day."""
    now = FIRST_D * DAY_S
    shape, perigee = ephemeris.eccentricity_at(row, now), ephemeris.perigee_at(row, now)
    mean = math.remainder(ephemeris.latitude_at(row, now) - perigee, math.tau)
    return {
        "semi_major_axis_m": float(ephemeris.radius_at(row, now)),
        "eccentricity": float(shape),
        "inclination_deg": math.degrees(ephemeris.inclination_at(row, now)),
        "raan_deg": math.degrees(ephemeris.node_at(row, now)) % 360.0,
        "argument_of_perigee_deg": math.degrees(perigee) % 360.0,
        "true_anomaly_deg": math.degrees(true_anomaly(mean, float(shape))) % 360.0,
    }
