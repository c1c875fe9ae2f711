"""What makes a choice of arcs a plan."""

from __future__ import annotations

import numpy as np
from ortools.sat.python import cp_model

from adr_opt.kernels.constants import STATION

from ..exact_models.network import Network
from .variables import Variables


class Constraints:
    """The constraints of the model, one method each.

    Parameters
    ----------
    block : CpModel
        Gets the constraints.
    network : Network
    variables : Variables
    cost : (nodes,) int64
        ΔV of the leg to each node, in steps.
    steps : int
        Whole steps of ΔV in the budget.
    """

    def __init__(
        self,
        block: cp_model.CpModel,
        network: Network,
        variables: Variables,
        cost: np.ndarray,
        steps: int,
    ) -> None:
        self._block = block
        self._network = network
        self._variables = variables
        self._cost = cost.tolist()
        self._steps = steps
        self._one_path()
        self._each_target_once()
        self._delta_v_adds_up()
        self._delta_v_fits()

    def _one_path(self) -> None:
        """Begin at the start; leave each node that is entered once, or end there."""
        network, variables = self._network, self._variables
        entering: list[list[cp_model.IntVar]] = [[] for _ in range(network.nodes)]
        for move, node in zip(variables.move, network.successor.tolist(), strict=True):
            entering[node].append(move)
        self._block.add(variables.skip[0] == 0)
        for node in range(network.nodes):
            leaving = variables.move[network.head[node] : network.head[node + 1]]
            around = variables.skip[node]
            if node > 0:
                self._block.add_exactly_one([*entering[node], around])
            self._block.add_exactly_one([*leaving, variables.last[node], around])
        self._block.add_exactly_one(variables.last)

    def _each_target_once(self) -> None:
        """Move to each target at most once: exactly once if it is serviced."""
        network, variables = self._network, self._variables
        moves: dict[int, list[cp_model.IntVar]] = {target: [] for target in variables.visit}
        for move, body in zip(
            variables.move, network.body[network.successor].tolist(), strict=True
        ):
            if body != STATION:
                moves[body].append(move)
        for target, visit in variables.visit.items():
            self._block.add_exactly_one([*moves[target], visit.negated()])

    def _delta_v_adds_up(self) -> None:
        """Reach a target with the ΔV used before it and on the way to it."""
        used = self._variables.used
        for node, origin, body in self._legs():
            if body != STATION:
                before = 0 if origin == STATION else used[origin]
                made = self._variables.skip[node].negated()
                self._block.add(used[body] >= before + self._cost[node]).only_enforce_if(made)

    def _delta_v_fits(self) -> None:
        """Reach the station within the budget; targets are by the range of ``used``."""
        for node, origin, body in self._legs():
            if body == STATION:
                made = self._variables.skip[node].negated()
                before = self._variables.used[origin]
                self._block.add(before + self._cost[node] <= self._steps).only_enforce_if(made)

    def forbid(self, arcs: list[int]) -> None:
        """Keep a path from using all of some arcs."""
        self._block.add_bool_or([self._variables.move[arc].negated() for arc in arcs])

    def _legs(self):
        """Nodes but the start, with the bodies that their legs leave and reach."""
        network = self._network
        return zip(
            range(1, network.nodes),
            network.origin[1:].tolist(),
            network.body[1:].tolist(),
            strict=True,
        )
