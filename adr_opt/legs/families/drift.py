"""Drift legs: a stay on an orbit with a different node rate (docs/model.md section 3)."""

from __future__ import annotations

from ...kernels.legs import drifting_connections
from ...kernels.legs.found import ConnectionArrays
from ...plan.leg_kinds import DRIFT
from ...problem.drives import Drive
from ...problem.instance import Instance
from . import drift_burns
from .family import FlownLeg, LegFamily, Manoeuvres, PairEnds, StatedLeg


class DriftLegs(LegFamily):
    """Drifts between times of a grid."""

    kind = DRIFT

    def applies(self, instance: Instance) -> bool:
        return instance.given is None and instance.transfer.max_drift_s > 0.0

    def serves(self, drive: Drive | None) -> bool:
        return drive is None

    def connections(
        self, ends: PairEnds, found: ConnectionArrays | None, resolution_m_s: float
    ) -> ConnectionArrays:
        assert found is not None
        if ends.times is None or ends.times.longest < ends.times.step:
            return found
        made: ConnectionArrays = drifting_connections.with_drifts(
            ends.leaving, ends.arriving, ends.rule, ends.times, ends.latest_s, resolution_m_s, found
        )
        return made

    def flown(self, ends: PairEnds, stated: StatedLeg) -> FlownLeg:
        pair = ends.leaving, ends.arriving, ends.rule, stated.departure, stated.arrival
        flight = drift_burns.flown(*pair)
        names = drift_burns.phases(ends.rule)
        manoeuvres = Manoeuvres(flight.times, flight.vectors, names)
        return FlownLeg(stated.departure, drift_burns.shape_m_s(*pair), manoeuvres)
