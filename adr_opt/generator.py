"""Random instances: the families of the benchmark.

Every number is drawn from raw PCG-64 output (whose stream NumPy guarantees) by IEEE arithmetic and
rounded to the digits of the file, so one seed gives one file, byte for byte, on any machine.

The spread of the planes and of the phases is a *calibration*: the published study does not state
it. It was chosen so that the published algorithms give the published numbers (MODEL section 6).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np

from .errors import InputError
from .instance import Instance, KeepOutZone, MissionLimits, Orbit, Station, Target
from .kernels.constants import EARTH_RADIUS_M

DAY_S = 86400.0
HOUR_S = 3600.0
EPOCH = datetime(2026, 1, 1, tzinfo=UTC)
LARGEST_SEED = 2**63 - 1

ALTITUDE_KM = (700.0, 800.0)
INCLINATION_DEG = (95.0, 97.0)
RAAN_DEG = (-1.0, 1.0)
STATION_ALTITUDE_KM = 700.0
STATION_INCLINATION_DEG = 96.0

ZONE_ALTITUDE_KM = (680.0, 830.0)
ZONE_THICKNESS_KM = (10.0, 25.0)
ZONE_LENGTH_H = (6.0, 24.0)


@dataclass(frozen=True)
class Family:
    """A family of instances: everything but the seed.

    Attributes
    ----------
    name, summary : str
    targets : (int, int)
        Least and largest number of targets; the seed draws it.
    duration_s, delta_v_m_s : float
    """

    name: str
    summary: str
    targets: tuple[int, int]
    duration_s: float
    delta_v_m_s: float


FAMILIES = {
    family.name: family
    for family in (
        Family("tiny", "6-8 targets, 1.5 days, 1 km/s", (6, 8), 1.5 * DAY_S, 1000.0),
        Family("nominal", "50 targets, 7 days, 3 km/s", (50, 50), 7.0 * DAY_S, 3000.0),
        Family("reduced-time", "50 targets, 3 days, 3 km/s", (50, 50), 3.0 * DAY_S, 3000.0),
        Family("reduced-fuel", "50 targets, 7 days, 1 km/s", (50, 50), 7.0 * DAY_S, 1000.0),
    )
}
"""The families by name. Families with equal numbers of targets share the field of one seed."""


def family(name: str) -> Family:
    """The family of a name.

    Raises
    ------
    InputError
        There is none; the sentence lists them.
    """
    if name not in FAMILIES:
        raise InputError(f"family {name!r} is unknown; use one of {', '.join(FAMILIES)}")
    return FAMILIES[name]


def _stream(seed: int, purpose: int) -> Callable[[float, float], float]:
    """A source of uniform numbers; different purposes of one seed are independent."""
    bits = np.random.PCG64(np.random.SeedSequence([purpose, seed]))

    def uniform(low: float, high: float) -> float:
        return low + (high - low) * ((int(bits.random_raw()) >> 11) * 2.0**-53)

    return uniform


def _circle(altitude_km: float, inclination_deg: float, raan_deg: float, u_deg: float) -> Orbit:
    return Orbit(
        semi_major_axis_m=round(EARTH_RADIUS_M + 1e3 * altitude_km, 3),
        eccentricity=0.0,
        inclination_deg=round(inclination_deg, 6),
        raan_deg=round(raan_deg, 6),
        argument_of_perigee_deg=0.0,
        true_anomaly_deg=round(u_deg, 6),
    )


def generate(name: str, seed: int, *, targets: int | None = None, zones: int = 0) -> Instance:
    """Draw an instance.

    Parameters
    ----------
    name : str
        A family of :data:`FAMILIES`.
    seed : int
        Not negative.
    targets : int, optional
        Number of targets, instead of the family's.
    zones : int
        Number of keep-out zones to draw; they do not change the field.

    Raises
    ------
    InputError
        Unknown family, or a number out of range.
    """
    kind = family(name)
    for what, value, most in (("seed", seed, LARGEST_SEED), ("zones", zones, 10**6)):
        if not 0 <= value <= most:
            raise InputError(f"{what} = {value}: must be between 0 and {most}")
    if targets is not None and not 0 <= targets <= 10**6:
        raise InputError(f"targets = {targets}: must be between 0 and 1000000")
    uniform = _stream(seed, 0)
    low, high = kind.targets
    count = low
    if high > low:
        count = min(high, int(uniform(low, high + 1)))
    if targets is not None:
        count = targets
    width = max(3, len(str(count)))
    field = tuple(
        Target(
            name=f"debris-{number:0{width}d}",
            prize=1.0,
            orbit=_circle(
                uniform(*ALTITUDE_KM),
                uniform(*INCLINATION_DEG),
                uniform(*RAAN_DEG),
                uniform(0.0, 360.0),
            ),
        )
        for number in range(1, count + 1)
    )
    suffix = f"-n{count}" if targets is not None else ""
    suffix += f"-z{zones}" if zones else ""
    return Instance(
        name=f"{kind.name}-{seed:03d}{suffix}",
        epoch=EPOCH,
        station=Station(
            name="station", orbit=_circle(STATION_ALTITUDE_KM, STATION_INCLINATION_DEG, 0.0, 0.0)
        ),
        targets=field,
        mission=MissionLimits(duration_s=kind.duration_s, delta_v_m_s=kind.delta_v_m_s),
        keep_out_zones=draw_zones(seed, zones, kind.duration_s),
    )


def draw_zones(seed: int, count: int, duration_s: float) -> tuple[KeepOutZone, ...]:
    """Keep-out zones within 680–830 km, 10–25 km thick, 6–24 h long (MODEL section 5)."""
    uniform = _stream(seed, 1)
    zones = []
    for _ in range(count):
        thickness = uniform(*ZONE_THICKNESS_KM)
        bottom = uniform(ZONE_ALTITUDE_KM[0], ZONE_ALTITUDE_KM[1] - thickness)
        length = HOUR_S * uniform(*ZONE_LENGTH_H)
        start = uniform(0.0, max(0.0, duration_s - length))
        zones.append(
            KeepOutZone(
                min_altitude_m=round(1e3 * bottom, 3),
                max_altitude_m=round(1e3 * (bottom + thickness), 3),
                start_s=round(start, 3),
                end_s=round(start + length, 3),
            )
        )
    return tuple(zones)
