"""Drawn campaigns that are tours through time."""

from __future__ import annotations

import numpy as np

from adr_opt.common.constants import DAY_S
from adr_opt.problem.instance import Instance, instance_of

STEP_S = 2.5 * DAY_S
STAY, MOST, APART = 2, 6, 4
"""Stay, longest leg from arrival to arrival, and time between missions, in steps."""


def launched(seed: int, targets: int = 3, steps: int = 20, **changes: object) -> Instance:
    """Targets with planes some degrees apart, and chasers that are launched one after another."""
    random = np.random.default_rng([46, seed])
    orbits = [
        {
            "semi_major_axis_m": float(random.uniform(7.05e6, 7.25e6)),
            "eccentricity": float(random.choice([0.0, 0.01])),
            "inclination_deg": float(98.0 + random.uniform(-0.5, 0.5)),
            "raan_deg": float(random.uniform(0.0, 6.0)),
            "argument_of_perigee_deg": float(random.uniform(0.0, 360.0)),
            "true_anomaly_deg": float(random.uniform(0.0, 360.0)),
        }
        for _ in range(targets)
    ]
    tank = {"dry_mass_kg": 500.0, "propellant_kg": 400.0, "isp_s": 310.0}
    chaser = {
        "start": "anywhere",
        "tank": tank,
        "kit_mass_kg": 20.0,
        "expense": {"fixed": float(random.uniform(1.0, 20.0)), "per_kg_squared": 2e-4},
    }
    content = {
        "format": "adr-opt-instance/2",
        "name": "launched",
        "epoch": "2030-01-01T00:00:00Z",
        "dynamics": "j2",
        "stations": [],
        "targets": [
            {"name": f"t{k}", "orbit": orbit, "required": True, "removal": "kit"}
            for k, orbit in enumerate(orbits)
        ],
        "chasers": [{"name": f"c{k}", **chaser} for k in range(3)],
        "mission": {
            "duration_s": steps * STEP_S,
            "service_s": STAY * STEP_S,
            "mission_separation_s": APART * STEP_S,
        },
        "transfer": {
            "drift_step_s": STEP_S,
            "max_drift_s": (MOST - STAY) * STEP_S,
            "max_leg_s": MOST * STEP_S,
        },
        "objective": {"cost": "expense"},
    }
    for field, value in changes.items():
        part, _, inner = field.partition("__")
        if inner:
            content[part] = {**content[part], inner: value}  # type: ignore[dict-item]
            if value is None:
                del content[part][inner]  # type: ignore[attr-defined]
        else:
            content[part] = value
    return instance_of(content)
