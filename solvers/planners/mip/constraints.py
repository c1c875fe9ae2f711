"""Constraints that make a choice of legs a plan."""

from __future__ import annotations

import pyomo.environ as pyo

from adr_opt.kernels.rules.rules import Rules

from ...models.solver_network import GUARD_M_S, SolverNetwork
from .variables import MipVariables

ROUNDING = 1e-6
"""Relative enlargement of tanks, so that no tolerance of HiGHS loses a plan that just fits; an
infeasible path is forbidden when found."""


class MipConstraints:
    """The constraints of the model, one method each.

    Parameters
    ----------
    block : pyomo.environ.ConcreteModel
        Gets the constraints.
    network : SolverNetwork
    variables : MipVariables
    rules : adr_opt.kernels.rules.rules.Rules
    """

    def __init__(
        self,
        block: pyo.ConcreteModel,
        network: SolverNetwork,
        variables: MipVariables,
        rules: Rules,
    ) -> None:
        self._block = block
        self._network = network
        self._variables = variables
        self._rules = rules
        self._one_path()
        self._each_target_once()
        self._not_too_many_targets()
        self._delta_v_adds_up()
        self._delta_v_fits()
        self._block.forbidden = pyo.ConstraintList()

    def _one_path(self) -> None:
        """Begin at the start; at each node entered, leave by a leg, wait, or end."""
        network, move, wait = self._network, self._variables.move, self._variables.wait
        entering = [[move[leg] for leg in legs] for legs in _landing_at(network)]
        for node, onward in enumerate(network.onward.tolist()):
            if onward >= 0:
                entering[onward].append(wait[node])
        self._block.one_path = pyo.ConstraintList()
        for node in range(network.nodes):
            leaving = [move[leg] for leg in range(network.first[node], network.first[node + 1])]
            if node in wait:
                leaving.append(wait[node])
            entered = sum(entering[node]) if node > 0 else 1
            if self._rules.may_end[network.body[node]]:
                if leaving:
                    self._block.one_path.add(sum(leaving) <= entered)
            elif leaving or entering[node] or node == 0:
                self._block.one_path.add(sum(leaving) - entered == 0)

    def _each_target_once(self) -> None:
        """Enter each target at most once."""
        move = self._variables.move
        self._block.once = pyo.ConstraintList()
        for legs in self._into_targets().values():
            self._block.once.add(sum(move[leg] for leg in legs) <= 1)

    def _not_too_many_targets(self) -> None:
        """Enter at most the chaser's maximum number of targets."""
        move, into = self._variables.move, self._into_targets()
        self._block.number = pyo.ConstraintList()
        if self._rules.limits.targets < len(into):
            moves = sum(move[leg] for legs in into.values() for leg in legs)
            self._block.number.add(moves <= self._rules.limits.targets)

    def _delta_v_adds_up(self) -> None:
        """Leave a target with the ΔV used before it and on the way to it.

        Where the mission ends nothing is carried on; what was used by then is at most 1.
        """
        move, used = self._variables.move, self._variables.used
        into, out_of = self._into_targets(), self._by_body(0)
        before: dict[int, list[pyo.Expression]] = {}
        after: dict[int, list[pyo.Expression]] = {}
        for i, j in self._variables.pairs:
            after.setdefault(i, []).append(used[i, j])
            before.setdefault(j, []).append(used[i, j])
        self._block.adds_up = pyo.ConstraintList()
        for target, entering in into.items():
            leaving = out_of.get(target)
            if leaving is None:
                continue
            way = sum(self._part(leg) * move[leg] for leg in entering)
            ends = sum(move[leg] for leg in entering) - sum(move[leg] for leg in leaving)
            self._block.adds_up.add(sum(after[target]) >= sum(before.get(target, [])) + way - ends)

    def _delta_v_fits(self) -> None:
        """Keep the ΔV used before a move and on it within the budget."""
        slack = GUARD_M_S / self._rules.budget + ROUNDING
        self._block.fits = pyo.ConstraintList()
        for pair in self._variables.pairs:
            legs = self._variables.legs_of[pair].tolist()
            self._block.fits.add(
                self._variables.used[pair]
                <= sum((1.0 + slack - self._part(leg)) * self._variables.move[leg] for leg in legs)
            )

    def forbid(self, groups: list[list[int]]) -> None:
        """Forbid paths with a leg from each of some groups."""
        move = self._variables.move
        self._block.forbidden.add(
            sum(move[leg] for legs in groups for leg in legs) <= len(groups) - 1
        )

    def _part(self, leg: int) -> float:
        """ΔV of a leg as a share of the budget."""
        return float(self._network.delta_v[leg]) / self._rules.budget

    def _into_targets(self) -> dict[int, list[int]]:
        """Legs by target entered."""
        into = self._by_body(1)
        return {body: legs for body, legs in into.items() if body >= self._rules.first_target}

    def _by_body(self, end: int) -> dict[int, list[int]]:
        """Legs by body left (0) or entered (1)."""
        legs: dict[int, list[int]] = {}
        for pair, group in self._variables.legs_of.items():
            legs.setdefault(pair[end], []).extend(group.tolist())
        return legs


def _landing_at(network: SolverNetwork) -> list[list[int]]:
    """Legs by landing node."""
    legs: list[list[int]] = [[] for _ in range(network.nodes)]
    for leg, node in enumerate(network.landing.tolist()):
        legs[node].append(leg)
    return legs
