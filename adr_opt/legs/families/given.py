"""Given connections: times and costs from elsewhere, without a trajectory."""

from __future__ import annotations

from ...kernels.legs.found import ConnectionArrays
from ...kernels.legs.given import sifted
from ...plan.leg_kinds import GIVEN
from ...problem.instance import Instance
from .family import FlownLeg, LegFamily, PairEnds, StatedLeg


class GivenLegs(LegFamily):
    """Rows of an instance's table of given connections."""

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
