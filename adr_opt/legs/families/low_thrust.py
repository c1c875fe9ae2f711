"""Legs of low thrust: thrust, drift and thrust again (docs/model.md section 11)."""

from __future__ import annotations

import numpy as np

from ...kernels.legs import low_thrust_grid, low_thrust_windows
from ...kernels.legs.found import ConnectionArrays
from ...kernels.legs.low_thrust_arcs import Thrust
from ...kernels.orbits.ephemeris import EPOCH_S
from ...plan.leg_kinds import LOW_THRUST
from ...problem.drives import Drive, since_j2000_s
from ...problem.instance import Instance
from .family import FlownLeg, LegFamily, PairEnds, StatedLeg
from .merging import merged, of_family

LIGHTER = 1.01
"""Factor on the acceleration of the lightest chaser in lower bounds: where a leg thrusts nearly all
the time, its ΔV is the least to within the effect of some promille of the mass."""


class LowThrustLegs(LegFamily):
    """Legs of chasers with low thrust, between times of a grid."""

    kind = LOW_THRUST

    def applies(self, instance: Instance) -> bool:
        return any(chaser.thrust_n is not None for chaser in instance.chasers)

    def serves(self, drive: Drive | None) -> bool:
        return drive is not None

    def connections(
        self, ends: PairEnds, found: ConnectionArrays | None, resolution_m_s: float
    ) -> ConnectionArrays:
        assert ends.drive is not None
        assert ends.times is not None
        drive, step = ends.drive, ends.times.step
        since = since_j2000_s(ends.instance.epoch)
        pair = low_thrust_windows.prepare(ends.leaving, ends.arriving, ends.rule, since, EPOCH_S)
        pushed = LIGHTER * drive.largest_acceleration if ends.relaxed else drive.least_acceleration
        thrust = Thrust(pushed, drive.exhaust_m_s)
        legs = low_thrust_grid.of_pair(
            pair, thrust, ends.times, ends.latest_s, resolution_m_s, ends.relaxed
        )
        made = of_family(
            self.number, legs.departure * step, legs.arrival * step, legs.delta_v,
            np.full(legs.departure.size, -1, dtype=np.int8),
        )  # fmt: skip
        return merged(found, made, ends.latest_s, resolution_m_s)

    def flown(self, ends: PairEnds, stated: StatedLeg) -> FlownLeg:
        return FlownLeg(stated.departure)
