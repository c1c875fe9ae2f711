"""A family of legs in a package of its own: co-elliptic sequences of more revolutions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from adr_opt.common.errors import InputError
from adr_opt.kernels.legs import burns as burn_kernels
from adr_opt.kernels.legs import connections as regular
from adr_opt.kernels.legs.co_elliptic import TransferRule
from adr_opt.kernels.legs.found import ConnectionArrays
from adr_opt.legs.families import registry
from adr_opt.legs.families.family import (
    FlownLeg,
    Manoeuvres,
    PairEnds,
    RecomputedLeg,
    RegisteredFamily,
    StatedLeg,
    Way,
)
from adr_opt.legs.families.merging import merged
from adr_opt.plan.leg_kinds import LegKind
from adr_opt.plan.phases import Phase
from adr_opt.problem.instance import Instance

LONGER = Phase("longer-phasing", "longer phasing", "#7a8b3c")


class LongerPhasing(RegisteredFamily):
    """Sequences with more phasing revolutions than short legs may have, in two-body motion.

    Parameters
    ----------
    most : int
        Phasing revolutions that they have at most.
    """

    kind = LegKind("longer", "longer leg", "longer", counts_laps=True)
    phases = (LONGER,)

    def __init__(self, most: int) -> None:
        self._most = most

    def applies(self, instance: Instance) -> bool:
        """Two-body motion."""
        return instance.given is None and instance.dynamics == "two-body"

    def _rule(self, ends: PairEnds) -> TransferRule:
        # Free burns have no price for so many revolutions.
        return ends.rule._replace(max_phasing_revolutions=self._most, free=False)

    def _own(self, ends: PairEnds, resolution_m_s: float) -> ConnectionArrays:
        """Those of all revolutions that short legs may not have."""
        found = regular.of_pair(
            ends.leaving,
            ends.arriving,
            ends.eccentricity_m_s,
            self._rule(ends),
            ends.latest_s,
            resolution_m_s,
        )
        more = found.revolutions > ends.rule.max_phasing_revolutions
        own = ConnectionArrays(*(column[more] for column in found))
        return own._replace(family=np.full(own.departure.size, self.number, dtype=np.int8))

    def connections(
        self, ends: PairEnds, found: ConnectionArrays | None, resolution_m_s: float
    ) -> ConnectionArrays:
        """Those of short legs, and more."""
        return merged(found, self._own(ends, resolution_m_s), ends.latest_s, resolution_m_s)

    def flown(self, ends: PairEnds, stated: StatedLeg) -> FlownLeg:
        """Flown as a short leg, under the name of its own phase."""
        pair = ends.leaving, ends.arriving, ends.eccentricity_m_s, self._rule(ends)
        times, vectors, phases = burn_kernels.burns_between(*pair, *stated)
        share = burn_kernels.eccentric_share(*pair, *stated)
        names = [burn_kernels.PHASES[phase] for phase in phases]
        names = [LONGER.name if name == "phasing" else name for name in names]
        return FlownLeg(float(times[0]), float(share), Manoeuvres(times, vectors, tuple(names)))

    def recomputed(self, ends: PairEnds, stated: StatedLeg) -> RecomputedLeg:
        """The nearest of its own."""
        own = self._own(ends, 0.0)
        if not own.departure.size:
            raise InputError("there are no longer legs between its bodies")
        off = np.abs(own.departure - stated.departure) + np.abs(own.arrival - stated.arrival)
        row = int(np.argmin(off))
        departure, arrival = float(own.departure[row]), float(own.arrival[row])
        flown = self.flown(ends, StatedLeg(departure, arrival, int(own.revolutions[row])))
        return RecomputedLeg(
            departure, arrival, float(own.delta_v[row]), flown.eccentricity_m_s, flown.manoeuvres
        )

    def ways(self, ends: PairEnds, after_s: float) -> Iterator[Way]:
        """Those of the next event."""
        own = self._own(ends, 0.0)
        next_event = own.departure[own.departure >= after_s].min(initial=np.inf)
        for row in np.flatnonzero(own.departure == next_event):
            yield Way(float(next_event), float(own.arrival[row]), float(own.delta_v[row]))


def register() -> None:
    """Make the family known; entry points of the package name this."""
    registry.register(LongerPhasing(most=30))
