"""Positions of the debris, by the contest's own ephemeris."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from adr_opt.common.constants import DAY_S, MU_M3_S2, OBLATENESS_M2
from adr_opt.kernels.orbits import ephemeris

from ..reading import FloatArray, filled_lines, numbers_of, published


@dataclass(frozen=True)
class Debris:
    """A debris as the contest has it: epoch [d], a [m], e, i, Ω, ω, M [rad] at it.

    a, e and i stay, node and perigee turn at their secular rates, the mean anomaly grows by
    √(μ/a³), and position and velocity follow from these as from osculating elements.
    """

    epoch_d: float
    axis: float
    eccentricity: float
    inclination: float
    raan: float
    perigee: float
    anomaly: float

    @property
    def revolution_s(self) -> float:
        """Period of the mean anomaly [s]."""
        return math.tau * math.sqrt(self.axis**3 / MU_M3_S2)

    def state(self, time_s: float) -> FloatArray:
        """Inertial position and velocity at a time since MJD2000 0, shape (6,) [m, m/s]."""
        gone = time_s - self.epoch_d * DAY_S
        node, turning, _ = ephemeris.secular_rates(
            self.axis, self.eccentricity, self.inclination, OBLATENESS_M2
        )
        mean = self.anomaly + math.sqrt(MU_M3_S2 / self.axis**3) * gone
        e, centric = self.eccentricity, mean
        for _ in range(50):
            change = (centric - e * math.sin(centric) - mean) / (1.0 - e * math.cos(centric))
            centric -= change
            if abs(change) < 1e-14:
                break
        ascending, ahead, _ = ephemeris.frame(self.inclination, self.raan + node * gone)
        perigee = self.perigee + turning * gone
        along = math.cos(perigee) * ascending + math.sin(perigee) * ahead
        across = -math.sin(perigee) * ascending + math.cos(perigee) * ahead
        flat = math.sqrt(1.0 - e * e)
        place = self.axis * ((math.cos(centric) - e) * along + flat * math.sin(centric) * across)
        speed = math.sqrt(MU_M3_S2 / self.axis) / (1.0 - e * math.cos(centric))
        velocity = speed * (-math.sin(centric) * along + flat * math.cos(centric) * across)
        return np.r_[place, velocity]


@published
def read_ephemeris(path: Path) -> tuple[Debris, ...]:
    """The debris of the contest's file."""
    return tuple(Debris(*numbers_of(line, 8)[1:]) for line in filled_lines(path))
