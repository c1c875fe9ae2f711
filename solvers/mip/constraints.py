"""What makes a choice of arcs a plan."""

from __future__ import annotations

import pyomo.environ as pyo

from adr_opt.kernels.constants import STATION

from ..exact_models.network import GUARD_M_S, Network
from .variables import Variables


class Constraints:
    """The constraints of the model, one method each.

    Parameters
    ----------
    block : pyomo.environ.ConcreteModel
        Gets the constraints.
    network : Network
    variables : Variables
    budget : float
        [m/s].
    """

    def __init__(
        self, block: pyo.ConcreteModel, network: Network, variables: Variables, budget: float
    ) -> None:
        self._block = block
        self._network = network
        self._variables = variables
        self._budget = budget
        self._one_path()
        self._each_target_once()
        self._delta_v_adds_up()
        self._delta_v_fits()
        self._block.forbidden = pyo.ConstraintList()

    def _one_path(self) -> None:
        """Leave the start at most once, and a node at most as often as it is entered."""
        network, move = self._network, self._variables.move
        entering: list[list[int]] = [[] for _ in range(network.nodes)]
        for arc, node in enumerate(network.successor.tolist()):
            entering[node].append(arc)
        self._block.one_path = pyo.ConstraintList()
        for node in range(network.nodes):
            leaving = range(network.head[node], network.head[node + 1])
            if not leaving:
                continue
            entered = sum(move[arc] for arc in entering[node]) if node > 0 else 1
            self._block.one_path.add(sum(move[arc] for arc in leaving) <= entered)

    def _each_target_once(self) -> None:
        """Move to each target at most once."""
        move = self._variables.move
        self._block.once = pyo.ConstraintList()
        for target, arcs in self._by_body(1).items():
            if target != STATION:
                self._block.once.add(sum(move[arc] for arc in arcs) <= 1)

    def _delta_v_adds_up(self) -> None:
        """Leave a target with the ΔV used before it and on the way to it.

        Where the mission ends nothing is carried on; what was used by then is at most 1.
        """
        move, used = self._variables.move, self._variables.used
        into, out_of = self._by_body(1), self._by_body(0)
        before: dict[int, list[pyo.Expression]] = {}
        after: dict[int, list[pyo.Expression]] = {}
        for i, j in self._variables.pairs:
            after.setdefault(i, []).append(used[i, j])
            before.setdefault(j, []).append(used[i, j])
        self._block.adds_up = pyo.ConstraintList()
        for target, leaving in out_of.items():
            if target == STATION:
                continue
            entering = into[target]
            way = sum(self._part(arc) * move[arc] for arc in entering)
            ends = sum(move[arc] for arc in entering) - sum(move[arc] for arc in leaving)
            self._block.adds_up.add(sum(after[target]) >= sum(before.get(target, [])) + way - ends)

    def _delta_v_fits(self) -> None:
        """Keep what is used before a move and on it within the budget."""
        slack = GUARD_M_S / self._budget
        self._block.fits = pyo.ConstraintList()
        for pair in self._variables.pairs:
            arcs = self._variables.arcs_of[pair].tolist()
            self._block.fits.add(
                self._variables.used[pair]
                <= sum((1.0 + slack - self._part(arc)) * self._variables.move[arc] for arc in arcs)
            )

    def forbid(self, arcs: list[int]) -> None:
        """Keep a path from using all of some arcs."""
        self._block.forbidden.add(sum(self._variables.move[arc] for arc in arcs) <= len(arcs) - 1)

    def _part(self, arc: int) -> float:
        """ΔV of an arc, as part of the budget."""
        return float(self._network.delta_v[self._network.successor[arc]]) / self._budget

    def _by_body(self, end: int) -> dict[int, list[int]]:
        """Arcs by the body that they leave (0) or enter (1)."""
        arcs: dict[int, list[int]] = {}
        for pair, group in self._variables.arcs_of.items():
            arcs.setdefault(pair[end], []).extend(group.tolist())
        return arcs
