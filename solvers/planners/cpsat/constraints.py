"""Constraints that make a choice of legs a plan."""

from __future__ import annotations

from ortools.sat.python import cp_model

from adr_opt.kernels.rules.rules import Rules

from ...models.network import SolverNetwork
from .variables import CpSatVariables


class CpSatConstraints:
    """The constraints of the model, one method each.

    Parameters
    ----------
    block : CpModel
        Gets the constraints.
    network : SolverNetwork
    variables : CpSatVariables
    rules : adr_opt.kernels.rules.rules.Rules
    cost : list of int
        ΔV of each leg, in steps.
    steps : int
        Whole steps of ΔV in the budget.
    """

    def __init__(
        self,
        block: cp_model.CpModel,
        network: SolverNetwork,
        variables: CpSatVariables,
        rules: Rules,
        cost: list[int],
        steps: int,
    ) -> None:
        self._block = block
        self._network = network
        self._variables = variables
        self._rules = rules
        self._cost = cost
        self._steps = steps
        self._legs_of = _by_pair(network)
        self._one_path()
        self._each_target_once()
        self._not_too_many_targets()
        self._delta_v_adds_up()
        self._delta_v_fits()

    def _one_path(self) -> None:
        """Begin at the start; at each node entered, leave by a leg, wait, or end."""
        network, variables = self._network, self._variables
        entering: list[list[cp_model.IntVar]] = [[] for _ in range(network.nodes)]
        for move, node in zip(variables.move, network.landing.tolist(), strict=True):
            entering[node].append(move)
        for node, wait in variables.wait.items():
            entering[int(network.onward[node])].append(wait)
        self._block.add(variables.skip[0] == 0)
        for node in range(network.nodes):
            leaving = variables.move[network.first[node] : network.first[node + 1]]
            leaving += [kind[node] for kind in (variables.wait, variables.last) if node in kind]
            around = variables.skip[node]
            if node > 0:
                self._block.add_exactly_one([*entering[node], around])
            self._block.add_exactly_one([*leaving, around])
        self._block.add_exactly_one(variables.last.values())

    def _each_target_once(self) -> None:
        """Enter each target from at most one body: from exactly one if it is serviced."""
        variables = self._variables
        for pair, legs in self._legs_of.items():
            moves = [variables.move[leg] for leg in legs]
            self._block.add_exactly_one([*moves, variables.go[pair].negated()])
        for target, visit in variables.visit.items():
            ways = [go for (_, j), go in variables.go.items() if j == target]
            self._block.add_exactly_one([*ways, visit.negated()])

    def _not_too_many_targets(self) -> None:
        """Service at most the chaser's maximum number of targets."""
        visits = list(self._variables.visit.values())
        if self._rules.limits.targets < len(visits):
            self._block.add(sum(visits) <= self._rules.limits.targets)

    def _delta_v_adds_up(self) -> None:
        """At each target, accumulate the ΔV used before it and on the way to it."""
        used = self._variables.used
        for (i, j), go in self._variables.go.items():
            if j in used:
                needed = used.get(i, 0) + self._way(i, j)
                self._block.add(used[j] >= needed).only_enforce_if(go)

    def _delta_v_fits(self) -> None:
        """Reach a station within the budget; for targets, the range of ``used`` ensures that."""
        used = self._variables.used
        for (i, j), go in self._variables.go.items():
            if j not in used:
                self._block.add(used[i] + self._way(i, j) <= self._steps).only_enforce_if(go)

    def forbid(self, groups: list[list[int]]) -> None:
        """Forbid paths with a leg from each of some groups."""
        moves = [self._variables.move[leg] for legs in groups for leg in legs]
        self._block.add(sum(moves) <= len(groups) - 1)

    def _way(self, i: int, j: int) -> cp_model.LinearExpr:
        """ΔV of the leg taken from one body to another, in steps."""
        legs = self._legs_of[i, j]
        return cp_model.LinearExpr.weighted_sum(
            [self._variables.move[leg] for leg in legs], [self._cost[leg] for leg in legs]
        )


def _by_pair(network: SolverNetwork) -> dict[tuple[int, int], list[int]]:
    """Legs by the bodies that they leave and reach."""
    legs: dict[tuple[int, int], list[int]] = {}
    pairs = zip(network.origin.tolist(), network.destination.tolist(), strict=True)
    for leg, pair in enumerate(pairs):
        legs.setdefault(pair, []).append(leg)
    return legs
