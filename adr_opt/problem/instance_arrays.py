"""Kernel inputs of an instance: its orbits and its transfer rule."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ..common.constants import EARTH_RADIUS_M, HOUR_S, SLACK_M, SLACK_S
from ..kernels.legs.co_elliptic import TransferRule
from ..kernels.orbits.ephemeris import ORBIT_COLUMNS
from .approach import approach_of
from .orbit import Orbit
from .settings import KeepOutZone, TransferSettings


def orbit_rows(
    orbits: Sequence[Orbit | None], oblateness_m2: float, decays_m_per_day: Sequence[float]
) -> npt.NDArray[np.float64]:
    """Orbits as kernels take them.

    Parameters
    ----------
    orbits : sequence of Orbit or None
    oblateness_m2 : float
        J2 R² of the dynamics [m²].
    decays_m_per_day : sequence of float
        By what the semi-major axes shrink.

    Returns
    -------
    (bodies, columns) float64
        Columns are :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`; NaN for those without an
        orbit.
    """
    nothing = (math.nan,) * len(ORBIT_COLUMNS)
    return np.array(
        [
            nothing if orbit is None else orbit.row(oblateness_m2, decay)
            for orbit, decay in zip(orbits, decays_m_per_day, strict=True)
        ]
    )


class KeptRows:
    """Cached orbit rows of an instance; comparisons of instances ignore them."""

    def __init__(self) -> None:
        self._of: tuple[Sequence[Orbit | None], float, Sequence[float]] | None = None
        self._rows = np.empty((0, len(ORBIT_COLUMNS)))

    def of(
        self,
        orbits: Sequence[Orbit | None],
        oblateness_m2: float,
        decays_m_per_day: Sequence[float],
    ) -> npt.NDArray[np.float64]:
        """A copy of :func:`orbit_rows`, computed again if the orbits have changed."""
        inputs = orbits, oblateness_m2, decays_m_per_day
        if self._of != inputs:  # equal orbits are mostly the same objects, which is quick
            self._of, self._rows = inputs, orbit_rows(*inputs)
        return self._rows.copy()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, KeptRows)

    def __hash__(self) -> int:
        return hash(KeptRows)

    def __reduce__(self) -> tuple[type[KeptRows], tuple[()]]:
        return KeptRows, ()  # another process works them out itself


def zone_rows(zones: Sequence[KeepOutZone]) -> npt.NDArray[np.float64]:
    """Keep-out zones as kernels take them.

    Returns
    -------
    (zones, 4) float64
        Min radius [m], max radius [m], start [s], end [s].

    Notes
    -----
    Zones are closed, so the slack of the model is theirs: what touches one is in it.
    """
    return np.array(
        [
            (
                EARTH_RADIUS_M + zone.min_altitude_m - SLACK_M,
                EARTH_RADIUS_M + zone.max_altitude_m + SLACK_M,
                zone.start_s - SLACK_S,
                zone.end_s + SLACK_S,
            )
            for zone in zones
        ],
        dtype=float,
    ).reshape(-1, 4)


def rule_of(
    settings: TransferSettings,
    zones: Sequence[KeepOutZone],
    oblateness_m2: float,
    time_value_m_s_per_h: float,
) -> TransferRule:
    """Transfer settings and zones as kernels take them (radii, m/s per s)."""
    approach = approach_of(settings)
    return TransferRule(
        settings.first_leg_fraction,
        settings.standoff_m,
        approach.revolutions,
        settings.max_phasing_revolutions,
        EARTH_RADIUS_M + settings.min_altitude_m,
        EARTH_RADIUS_M + settings.max_altitude_m,
        time_value_m_s_per_h / HOUR_S,
        zone_rows(zones),
        oblateness_m2,
        approach.length_m,
        approach.burns,
        settings.burns == "free",
    )
