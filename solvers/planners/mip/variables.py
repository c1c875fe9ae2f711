"""Variables of the mixed-integer program, and its objective."""

from __future__ import annotations

import numpy as np
import pyomo.environ as pyo

from adr_opt.kernels.rules.rules import Rules

from ...models.solver_network import SolverNetwork


class MipVariables:
    """The variables of the model.

    Parameters
    ----------
    block : pyomo.environ.ConcreteModel
        Gets the variables.
    network : SolverNetwork
    rules : adr_opt.kernels.rules.rules.Rules

    Attributes
    ----------
    move : Var, indexed by leg
        Whether the plan takes the leg.
    wait : Var, indexed by node
        Whether the chaser is at the node and waits for the next one of its body. It is so by
        itself wherever moves are whole.
    used : Var, indexed by pair of bodies
        ΔV used since refuelling when the chaser leaves the first body for the second, as part of
        the budget; 0 if it does not.
    pairs : list of (int, int)
        Pairs whose first body is a target: elsewhere the tank is full.
    legs_of : dict
        Legs of each pair, an int64 array.
    """

    def __init__(self, block: pyo.ConcreteModel, network: SolverNetwork, rules: Rules) -> None:
        self.legs_of = _by_pair(network.origin, network.destination)
        self.pairs = [pair for pair in self.legs_of if pair[0] >= rules.first_target]
        block.move = pyo.Var(range(network.legs), domain=pyo.Binary)
        waiting = np.flatnonzero(network.onward >= 0).tolist()
        block.wait = pyo.Var(waiting, domain=pyo.NonNegativeReals)
        block.used = pyo.Var(self.pairs, domain=pyo.NonNegativeReals)
        self.move, self.wait, self.used = block.move, block.wait, block.used

    def begin_from(self, network: SolverNetwork, legs: list[int], rules: Rules) -> None:
        """Set the variables to the values of a plan.

        Parameters
        ----------
        network : SolverNetwork
        legs : list of int
            Its legs, from the start on.
        rules : adr_opt.kernels.rules.rules.Rules
        """
        for variable in (*self.move.values(), *self.wait.values(), *self.used.values()):
            variable.set_value(0, skip_validation=True)
        used, node = 0.0, 0
        for leg, tail in zip(legs, network.tail[legs].tolist(), strict=True):
            while node != tail:
                self.wait[node].set_value(1, skip_validation=True)
                node = int(network.onward[node])
            self.move[leg].set_value(1, skip_validation=True)
            node = int(network.landing[leg])
            pair = int(network.body[tail]), int(network.body[node])
            if pair in self.used:
                self.used[pair].set_value(used / rules.budget, skip_validation=True)
            used = 0.0 if rules.is_station[pair[1]] else used + float(network.delta_v[leg])


def collect_prizes(
    block: pyo.ConcreteModel, network: SolverNetwork, variables: MipVariables, prize: np.ndarray
) -> None:
    """Give the model its objective: the sum of the prizes of the bodies entered, in units.

    Parameters
    ----------
    block : pyomo.environ.ConcreteModel
    network : SolverNetwork
    variables : MipVariables
    prize : (bodies,) float64
        In units; non-zero for targets only.
    """
    worth = prize[network.destination].tolist()
    block.prizes = pyo.Objective(
        expr=sum(prize * variables.move[leg] for leg, prize in enumerate(worth) if prize),
        sense=pyo.maximize,
    )


def _by_pair(origins: np.ndarray, destinations: np.ndarray) -> dict[tuple[int, int], np.ndarray]:
    order = np.lexsort((destinations, origins))
    keys = np.stack((origins[order], destinations[order]), axis=1)
    pairs, firsts = np.unique(keys, axis=0, return_index=True)
    groups = np.split(order, firsts[1:])
    return {(int(i), int(j)): group for (i, j), group in zip(pairs, groups, strict=True)}
