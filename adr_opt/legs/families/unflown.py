"""Legs without a trajectory: launches, and connections that are given."""

from __future__ import annotations

import numpy as np

from ...kernels.legs.found import ConnectionArrays
from ...kernels.legs.given import sifted
from ...plan.leg_kinds import GIVEN, LAUNCH
from ...problem.instance import Instance
from .family import FlownLeg, LegFamily, PairEnds, StatedLeg
from .merging import of_family


class Launches(LegFamily):
    """A chaser without a start orbit is placed at its first target, instantly and free."""

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


class GivenLegs(LegFamily):
    """Rows of an instance's table of given connections: times and costs from elsewhere."""

    kind = GIVEN

    def applies(self, instance: Instance) -> bool:
        return instance.given is not None

    def claims(self, ends: PairEnds) -> bool:
        return True

    def connections(
        self, ends: PairEnds, found: ConnectionArrays | None, resolution_m_s: float
    ) -> ConnectionArrays:
        given, names = ends.instance.given, ends.instance.names
        assert given is not None
        pair = names[ends.origin], names[ends.destination]
        made: ConnectionArrays = sifted(*given.of_pair(*pair), ends.latest_s, resolution_m_s)
        return made

    def flown(self, ends: PairEnds, stated: StatedLeg) -> FlownLeg:
        return FlownLeg(stated.departure)
