"""What the constraint programming model decides."""

from __future__ import annotations

import numpy as np
from ortools.sat.python import cp_model

from adr_opt.kernels.constants import STATION

from ..exact_models.network import Network


class Variables:
    """The variables of the model.

    Parameters
    ----------
    block : CpModel
        Gets the variables.
    network : Network
    steps : int
        Whole steps of ΔV in the budget.

    Attributes
    ----------
    move : list of literals, by arc
        Whether the plan uses the arc.
    skip : list of literals, by node
        Whether the plan does not pass through the node.
    last : list of literals, by node
        Whether the plan ends there.
    visit : dict of literals, by target
        Whether the plan services the target.
    used : dict of integers, by target
        ΔV used since refuelling when the target is serviced, in steps; anything if it is not.
    """

    def __init__(self, block: cp_model.CpModel, network: Network, steps: int) -> None:
        self.move = [block.new_bool_var("") for _ in range(network.arcs)]
        self.skip = [block.new_bool_var("") for _ in range(network.nodes)]
        self.last = [block.new_bool_var("") for _ in range(network.nodes)]
        targets = sorted({int(j) for j in network.body if j != STATION})
        self.visit = {target: block.new_bool_var("") for target in targets}
        self.used = {target: block.new_int_var(0, steps, "") for target in targets}

    def begin_from(
        self, block: cp_model.CpModel, network: Network, arcs: list[int], cost: np.ndarray
    ) -> None:
        """Give the variables the values of a plan, as hints.

        Parameters
        ----------
        block : CpModel
        network : Network
        arcs : list of int
            Its arcs, from the start on.
        cost : (nodes,) int64
            ΔV of the leg to each node, in steps.
        """
        path = [0, *(int(network.successor[arc]) for arc in arcs)]
        chosen, passed, used = set(arcs), set(path), 0
        for arc, move in enumerate(self.move):
            block.add_hint(move, arc in chosen)
        for node in range(network.nodes):
            block.add_hint(self.skip[node], node not in passed)
            block.add_hint(self.last[node], node == path[-1])
        serviced = {int(network.body[node]) for node in path}
        for target, visit in self.visit.items():
            block.add_hint(visit, target in serviced)
        for node in path[1:]:
            body = int(network.body[node])
            used = 0 if body == STATION else used + int(cost[node])
            if body != STATION:
                block.add_hint(self.used[body], used)
