"""Legs dominated for a chaser that has waited, against every pair of legs."""

import numpy as np

import adr_opt
from adr_opt.mission.mission import Mission
from solvers.networks.arrays import Network
from solvers.networks.dominated_legs import LOOK_BACK
from solvers.networks.network import build


def networks() -> list[Network]:
    """Of a field without and one with drift, both small."""
    field = adr_opt.generate("tiny", 0)
    transfer = {"drift_step_s": 43200.0, "max_drift_s": 604800.0, "departure_spacing_s": 20000.0}
    drifting = field.replace(dynamics="j2", transfer=field.transfer.model_copy(update=transfer))
    return [build(Mission(instance), jobs=1) for instance in (field, drifting)]


def test_a_leg_is_stale_exactly_since_an_earlier_one_is_as_good() -> None:
    """Of the rows just before, the last one with a leg no later and no dearer is named."""
    for network in networks():
        stale = 0
        for body in range(network.start.size - 1):
            earlier: dict[int, list[int]] = {}
            for row in range(network.start[body], network.start[body + 1] - 1):
                others = earlier.setdefault(int(network.destination[row]), [])
                since = []
                for leg in range(network.first[row], network.first[row + 1]):
                    as_good = [
                        other
                        for other in others[-LOOK_BACK:]
                        if np.any(
                            (
                                network.landing[network.first[other] : network.first[other + 1]]
                                <= network.landing[leg]
                            )
                            & (
                                network.delta_v[network.first[other] : network.first[other + 1]]
                                <= network.delta_v[leg]
                            )
                        )
                    ]
                    since.append(max(as_good, default=-1))
                    assert network.since[leg] == since[-1]
                assert network.fresh[row] == min(since)
                stale += sum(other >= 0 for other in since)
                others.append(row)
        assert stale > 0
