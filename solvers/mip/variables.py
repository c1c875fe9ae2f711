"""What the mixed-integer model decides."""

from __future__ import annotations

import numpy as np
import pyomo.environ as pyo

from adr_opt.kernels.constants import STATION

from ..exact_models.network import Network


class Variables:
    """The variables of the model.

    Parameters
    ----------
    block : pyomo.environ.ConcreteModel
        Gets the variables.
    network : Network

    Attributes
    ----------
    move : Var, indexed by arc
        Whether the plan uses the arc.
    used : Var, indexed by pair of bodies
        ΔV used since refuelling when the chaser leaves the first body for the second, as part of
        the budget; 0 if it does not.
    pairs : list of (int, int)
        Pairs of targets with the station as second one too: those that leave the station leave it
        with nothing used.
    arcs_of : dict
        Arcs of each pair, an int64 array.
    """

    def __init__(self, block: pyo.ConcreteModel, network: Network) -> None:
        origins = network.body[network.tail]
        destinations = network.body[network.successor]
        self.arcs_of = _by_pair(origins, destinations)
        self.pairs = [pair for pair in self.arcs_of if pair[0] != STATION]
        block.move = pyo.Var(range(network.arcs), domain=pyo.Binary)
        block.used = pyo.Var(self.pairs, domain=pyo.NonNegativeReals)
        self.move, self.used = block.move, block.used

    def begin_from(self, network: Network, arcs: list[int], budget: float) -> None:
        """Give the variables the values of a plan.

        Parameters
        ----------
        network : Network
        arcs : list of int
            Its arcs, from the start on.
        budget : float
            [m/s].
        """
        for variable in (*self.move.values(), *self.used.values()):
            variable.set_value(0, skip_validation=True)
        used = 0.0
        for arc, tail in zip(arcs, network.tail[arcs].tolist(), strict=True):
            node = network.successor[arc]
            self.move[arc].set_value(1, skip_validation=True)
            if network.body[tail] != STATION:
                pair = int(network.body[tail]), int(network.body[node])
                self.used[pair].set_value(used / budget, skip_validation=True)
            used = 0.0 if network.body[node] == STATION else used + float(network.delta_v[node])


def _by_pair(origins: np.ndarray, destinations: np.ndarray) -> dict[tuple[int, int], np.ndarray]:
    order = np.lexsort((destinations, origins))
    keys = np.stack((origins[order], destinations[order]), axis=1)
    pairs, firsts = np.unique(keys, axis=0, return_index=True)
    groups = np.split(order, firsts[1:])
    return {(int(i), int(j)): group for (i, j), group in zip(pairs, groups, strict=True)}
