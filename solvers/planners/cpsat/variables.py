"""Variables of the constraint-programming model."""

from __future__ import annotations

import numpy as np
from ortools.sat.python import cp_model

from adr_opt.kernels.rules.rules import Rules

from ...models.network import SolverNetwork


class CpSatVariables:
    """The variables of the model.

    Parameters
    ----------
    block : CpModel
        Gets the variables.
    network : SolverNetwork
    rules : adr_opt.kernels.rules.rules.Rules
    steps : int
        Whole steps of ΔV in the budget.

    Attributes
    ----------
    move : list of literals, by leg
        Whether the plan takes the leg.
    wait : dict of literals, by node
        Whether the chaser is at the node and waits for the next one of its body.
    skip : list of literals, by node
        Whether the plan does not pass through the node.
    last : dict of literals, by node
        Whether the plan ends there; nodes where it may.
    go : dict of literals, by pair of bodies
        Whether the plan goes from the first to the second.
    visit : dict of literals, by target
        Whether the plan services the target.
    used : dict of integers, by target
        ΔV used since refuelling when the target is serviced, in steps; anything if it is not.
    """

    def __init__(
        self, block: cp_model.CpModel, network: SolverNetwork, rules: Rules, steps: int
    ) -> None:
        self.move = [block.new_bool_var("") for _ in range(network.legs)]
        self.wait = {
            node: block.new_bool_var("") for node in np.flatnonzero(network.onward >= 0).tolist()
        }
        self.skip = [block.new_bool_var("") for _ in range(network.nodes)]
        self.last = {
            node: block.new_bool_var("")
            for node in np.flatnonzero(rules.may_end[network.body]).tolist()
        }
        pairs = zip(network.origin.tolist(), network.destination.tolist(), strict=True)
        self.go = {pair: block.new_bool_var("") for pair in sorted(set(pairs))}
        targets = sorted({int(j) for j in network.body if j >= rules.first_target})
        self.visit = {target: block.new_bool_var("") for target in targets}
        self.used = {target: block.new_int_var(0, steps, "") for target in targets}

    def begin_from(
        self, block: cp_model.CpModel, network: SolverNetwork, legs: list[int], cost: list[int]
    ) -> None:
        """Set the values of a plan as hints.

        Parameters
        ----------
        block : CpModel
        network : SolverNetwork
        legs : list of int
            Its legs, from the start on.
        cost : list of int
            ΔV of each leg, in steps.
        """
        chosen, gone, waited, used = set(legs), set(), set(), dict[int, int]()
        node = 0
        passed = {node}
        for leg, tail in zip(legs, network.tail[legs].tolist(), strict=True):
            while node != tail:
                waited.add(node)
                node = int(network.onward[node])
                passed.add(node)
            node = int(network.landing[leg])
            passed.add(node)
            i, j = int(network.body[tail]), int(network.body[node])
            gone.add((i, j))
            if j in self.used:
                used[j] = used.get(i, 0) + cost[leg]
        for at, move in enumerate(self.move):
            block.add_hint(move, at in chosen)
        for at, wait in self.wait.items():
            block.add_hint(wait, at in waited)
        for at, skip in enumerate(self.skip):
            block.add_hint(skip, at not in passed)
        for at, last in self.last.items():
            block.add_hint(last, at == node)
        for pair, go in self.go.items():
            block.add_hint(go, pair in gone)
        for target, visit in self.visit.items():
            block.add_hint(visit, target in used)
        for target, by_then in used.items():
            block.add_hint(self.used[target], by_then)
