"""Electric chasers in the fields of the family `removal`: each object is towed down by a spiral.

Three chasers are launched at the start, each onto a target of its choice. With thrust of 0.4 N each
goes from object to object, takes it down to a disposal orbit of 500 km, leaves it there and climbs
to the next one. There is no refuelling.
"""

from __future__ import annotations

from ...common.constants import DAY_S
from ...problem.chasers import Chaser, TankByMass
from ...problem.settings import TransferSettings

CHASERS = 3

SERVICE_S = 10.0 * DAY_S
"""Time to approach and capture an object [s]."""

DISPOSAL_ALTITUDE_M = 500e3

THRUST_N = 0.4
TANK = TankByMass(dry_mass_kg=600.0, propellant_kg=300.0, isp_s=1800.0)

TRANSFER = TransferSettings(
    departure_spacing_s=8.0 * DAY_S,
    drift_step_s=20.0 * DAY_S,
    max_drift_s=360.0 * DAY_S,
    delta_v_resolution_m_s=20.0,
)
"""Coarse, as legs take weeks, and the longest is a year: what it saves otherwise is little."""


def chaser(number: int) -> Chaser:
    """The chaser with a number from 0."""
    return Chaser(name=f"chaser-{number + 1}", start="anywhere", tank=TANK, thrust_n=THRUST_N)
