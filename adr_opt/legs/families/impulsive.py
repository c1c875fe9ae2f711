"""Legs by impulses: short ones (docs/model.md section 2), and drifts (section 3)."""

from __future__ import annotations

from ...kernels.legs import burns as burn_kernels
from ...kernels.legs import connections as regular
from ...kernels.legs import drifting_connections
from ...kernels.legs.found import ConnectionArrays
from ...plan.leg_kinds import DRIFT, SHORT
from ...problem.drives import Drive
from ...problem.instance import Instance
from . import drift_burns
from .family import FlownLeg, LegFamily, Manoeuvres, PairEnds, StatedLeg
from .merging import merged


class ShortLegs(LegFamily):
    """Co-elliptic sequences, in either dynamics."""

    kind = SHORT

    def applies(self, instance: Instance) -> bool:
        return instance.given is None

    def serves(self, drive: Drive | None) -> bool:
        return drive is None

    def connections(
        self, ends: PairEnds, found: ConnectionArrays | None, resolution_m_s: float
    ) -> ConnectionArrays:
        assert found is None  # it is the first one
        pair = ends.leaving, ends.arriving, ends.eccentricity_m_s, ends.rule
        made: ConnectionArrays
        if ends.times is None:
            made = regular.of_pair(*pair, ends.latest_s, resolution_m_s, ends.since_s)
        elif ends.pieces is not None:
            # Sifted once, when they are together: a saving counts against all pieces.
            every = drifting_connections.short_ones_of_pieces(
                ends.pieces.pieces, *pair[1:], ends.times, ends.latest_s, 0.0
            )
            made = merged(None, every, ends.latest_s, resolution_m_s)
        else:
            made = drifting_connections.short_ones(*pair, ends.times, ends.latest_s, resolution_m_s)
        return made

    def flown(self, ends: PairEnds, stated: StatedLeg) -> FlownLeg:
        left = ends.left_at(stated.departure)
        pair = left, ends.arriving, ends.eccentricity_m_s, ends.rule
        times, vectors, phases = burn_kernels.burns_between(*pair, *stated)
        share = burn_kernels.eccentric_share(*pair, times[0], stated.arrival, stated.revolutions)
        names = tuple(burn_kernels.PHASES[phase] for phase in phases)
        return FlownLeg(float(times[0]), float(share), Manoeuvres(times, vectors, names))


class DriftLegs(LegFamily):
    """Drifts between times of a grid: stays on an orbit with a different node rate."""

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
        rows = ends.leaving[None] if ends.pieces is None else ends.pieces.on_grid
        made: ConnectionArrays = drifting_connections.with_drifts(
            rows, ends.arriving, ends.rule, ends.times, ends.latest_s, resolution_m_s, found
        )
        return made

    def flown(self, ends: PairEnds, stated: StatedLeg) -> FlownLeg:
        left = ends.left_at(stated.departure)
        pair = left, ends.arriving, ends.rule, stated.departure, stated.arrival
        flight = drift_burns.flown(*pair)
        names = drift_burns.phases(ends.rule)
        manoeuvres = Manoeuvres(flight.times, flight.vectors, names)
        return FlownLeg(stated.departure, drift_burns.shape_m_s(*pair), manoeuvres)
