"""The 113 legs of the winning solution of GTOC9, as flown and as a closed form has them.

The folder holds `debris_data.txt` (number, epoch as MJD2000, semi-major axis, eccentricity,
inclination, RAAN, argument of perigee, mean anomaly; metres and radians) and `jpl_solution.json`
(start of each mission; debris in order, stays and transfer times in days, ΔV of each leg).
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from adr_opt.kernels import drift, orbits
from adr_opt.kernels.constants import DAY_S, EARTH_RADIUS_M, OBLATENESS_M2

LIMITS_M = EARTH_RADIUS_M + 200e3, EARTH_RADIUS_M + 2000e3
"""Of the drift orbit, as radii; the contest asked for perigees above 6600 km."""


class Leg(NamedTuple):
    """A leg of the solution, times since MJD2000 0 [s].

    Attributes
    ----------
    pair : DriftPair
        Of the two debris, prepared.
    departure, arrival : float
        [s].
    flown : float
        ΔV of the optimised leg, fully flown [m/s].
    """

    pair: drift.DriftPair
    departure: float
    arrival: float
    flown: float

    @property
    def days(self) -> float:
        """How long it takes."""
        return (self.arrival - self.departure) / DAY_S

    @property
    def closed_form(self) -> float:
        """What the closed form says, which planning is done with [m/s]."""
        return float(drift.delta_v(self.pair, self.departure, self.arrival))

    @property
    def least_sum(self) -> float:
        """The least sum of the two ΔV, instead of that of their squares [m/s]."""
        pair, span = self.pair, self.arrival - self.departure
        node = drift.node_left(pair, self.arrival)
        shape = drift.shape_left(pair, self.arrival)
        left = np.array([node, pair.climb, pair.tilt])
        matrix = np.eye(3)
        matrix[0, 1:] = -pair.by_radius * span, -pair.by_inclination * span

        def total(b: np.ndarray) -> float:
            ends = b, left - matrix @ b
            return float(sum(np.sqrt(end @ end + shape * shape + 1e-9) for end in ends))

        climb = drift.climb_of(pair, span, node)
        along, tilt = drift.split_at(pair, span, node, climb)
        # The sum has more than one valley: everything at an end, or half of it.
        starts = (
            np.array([along, climb, tilt]),
            np.full(3, 1e-3),
            0.9 * np.linalg.solve(matrix, left),
        )
        return float(min(minimize(total, start, method="BFGS").fun for start in starts))


def _row(record: np.ndarray) -> np.ndarray:
    """A debris as a row of ORBIT_COLUMNS, angles at MJD2000 0."""
    _, epoch, axis, eccentricity, inclination, raan, perigee, anomaly = record
    node, turning, advancing = orbits.secular_rates(axis, eccentricity, inclination, OBLATENESS_M2)
    gone = epoch * DAY_S
    return np.array(
        [
            axis, inclination, raan - node * gone,
            perigee + anomaly - (turning + advancing) * gone,
            node, turning + advancing, eccentricity, perigee - turning * gone, turning,
        ]
    )  # fmt: skip


def read_legs(folder: Path) -> list[Leg]:
    """The legs in order of flight, mission by mission."""
    rows = [_row(record) for record in np.loadtxt(folder / "debris_data.txt")]
    solution = json.loads((folder / "jpl_solution.json").read_text(encoding="utf-8"))
    legs = []
    for start, mission in zip(solution["start_mjd2000"], solution["missions"], strict=True):
        now, debris = start, mission["debris"]
        for leg, days in enumerate(mission["transfer_d"]):
            departure = now + mission["stay_d"][leg]
            now = departure + days
            pair = drift.prepare(rows[debris[leg]], rows[debris[leg + 1]], *LIMITS_M, OBLATENESS_M2)
            flown = float(mission["dv_m_s"][leg])
            legs.append(Leg(pair, departure * DAY_S, now * DAY_S, flown))
    return legs
