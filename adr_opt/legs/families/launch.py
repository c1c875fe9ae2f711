"""Launches: a chaser without a start orbit is placed at its first target, instantly and free."""

from __future__ import annotations

import numpy as np

from ...kernels.legs.found import ConnectionArrays
from ...plan.leg_kinds import LAUNCH
from ...problem.instance import Instance
from .family import FlownLeg, LegFamily, PairEnds, StatedLeg
from .merging import of_family


class Launches(LegFamily):
    """Launches of chasers without a start orbit."""

    kind = LAUNCH

    def applies(self, instance: Instance) -> bool:
        return bool(instance.launches)

    def claims(self, ends: PairEnds) -> bool:
        launches = ends.instance.launches
        return ends.origin in launches or ends.destination in launches

    def connections(
        self, ends: PairEnds, found: ConnectionArrays | None, resolution_m_s: float
    ) -> ConnectionArrays:
        if found is not None:
            return found  # of a pair that legs lead between
        # As soon as the chaser is there: to be early is no loss.
        launches = ends.instance.launches
        leads_on = ends.origin in launches and ends.destination >= ends.instance.first_target
        when = np.full(int(leads_on), launches.get(ends.origin, 0.0))
        nothing = np.zeros_like(when)
        return of_family(self.number, when, when, nothing, nothing.astype(np.int8))

    def flown(self, ends: PairEnds, stated: StatedLeg) -> FlownLeg:
        return FlownLeg(stated.departure)
