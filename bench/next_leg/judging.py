"""What moves are worth: by beams from there, and by the rest of the best plan that is known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

import adr_opt
from adr_opt.analysis.rehearse.flying_chasers import FlyingChaser
from adr_opt.analysis.rehearse.learned import visible_legs_of
from adr_opt.analysis.rehearse.mission_facts import MissionFacts
from adr_opt.analysis.rehearse.tries import mean_worths, with_worths
from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.core.memory import borrowed
from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.mission.mission import Mission
from adr_opt.problem.uncertainty import Uncertainty
from solvers.beams.beams import beam_search, usual_settings

from .asked import beam_from, state_of

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

NARROW, NOISES = 6, (0.0, 0.4, 0.4, 0.4)
"""Width of the beams that judge every move, and the random parts of their comparisons."""

STRONG = 24
"""Width of the beam that judges the moves that seem best once more."""

SEEMS_BEST = 1.0
"""By how much such a move may seem worse than the best [mean prizes]."""

PLAN_WIDTH = 150
"""Width of the beam that makes a plan where none is proven."""

PROVABLE, PROOF_S = 30, 12.0
"""Number of targets up to which a proof is tried, and its limit [s]."""


@kernel
def _stepped(rules, state, done, body):
    """Whether a move is legal, and the state after it."""
    rules = borrowed(rules)
    legal, _, after = rule_kernels.step(rules, state, body)
    return legal and rule_kernels.may_go(rules, state, done, body), after


@kernel
def _collected(rules, sequence, state, done):
    """Prizes along a sequence of bodies, of which moves that are not legal are left out."""
    rules = borrowed(rules)
    total, done = 0.0, done.copy()
    for j in sequence:
        if rule_kernels.may_go(rules, state, done, j):
            legal, _, after = rule_kernels.step(rules, state, j)
            if legal:
                state = after
                done[j] = not rules.is_station[j]
                total += rules.prize[j]
    return total


class Judge:
    """Worths of moves in one mission: prizes as they are on average, services of mean length.

    The best plan known of the mission is that of a proof, where one ends in time, or of a beam, and
    what is left of it counts as well as what beams find: a decision on it is labelled by a plan
    that nothing beats.

    Parameters
    ----------
    facts : MissionFacts
    uncertainty : Uncertainty
    seed : int
    routes : sequence of sequence of int
        Bodies of the plan with which chasers begin, whose rest counts as well.

    Attributes
    ----------
    is_proven : bool
        Whether the best plan known is optimal as planned.
    """

    def __init__(
        self,
        facts: MissionFacts,
        uncertainty: Uncertainty,
        seed: int,
        routes: Sequence[Sequence[int]] = (),
    ) -> None:
        instance = with_worths(facts.instance, mean_worths(facts.instance, uncertainty))
        later_s = float(visible_legs_of(facts, uncertainty).later_s[facts.first_target :].mean())
        if later_s != 0.0:
            first = facts.first_target
            planned_s = facts.chasers[0].limits.service[first] - facts.tow_s.get(first, 0.0)
            service_s = max(float(planned_s) + later_s, 0.0)
            settings = instance.mission.replace(service_revolutions=None, service_s=service_s)
            instance = instance.replace(mission=settings)
        self._missions = [Mission(instance, chaser=c) for c in range(len(facts.chasers))]
        self._stations = facts.stations
        self.is_proven = False
        self._best = [np.empty(0, dtype=np.int64) for _ in self._missions]
        self._shown = [np.array(route, dtype=np.int64) for route in routes] or self._best
        if len(facts.chasers) > 1:
            return
        mission = self._missions[0]
        if facts.chasers[0].loads is None and len(instance.targets) <= PROVABLE:
            found = adr_opt.solve(instance, "exact", time_limit=PROOF_S)
            if found.plan is not None and found.upper_bound is not None:
                legs = [facts.number[leg.destination] for leg in found.plan.legs]
                self._best[0] = np.array(legs, dtype=np.int64)
                self.is_proven = found.upper_bound <= found.objective + 1e-9
        if not self.is_proven:
            self._best[0] = beam_search(mission, usual_settings(mission, PLAN_WIDTH), seed=seed)[0]

    @property
    def best(self) -> IntArray:
        """Bodies of the best plan known, in order; none for several chasers."""
        return self._best[0]

    def worths(self, craft: FlyingChaser, closed: set[int], bodies: IntArray) -> FloatArray:
        """Prizes of some moves and of what follows; NaN of those that are not legal.

        Parameters
        ----------
        craft : FlyingChaser
        closed : set of int
            Targets that are not to be serviced.
        bodies : (moves,) int64
        """
        mission, state = self._missions[craft.chaser], state_of(craft, craft.left)
        rules, done = mission.rules, np.zeros(mission.rules.service.size, dtype=np.bool_)
        done[list(closed)] = True
        scale = _mean_prize(rules)
        means, most = np.full(bodies.size, np.nan), np.full(bodies.size, np.nan)
        for at, j in enumerate(bodies.tolist()):
            legal, after = _stepped(rules, state, done, j)
            if not legal:
                continue
            own, there = self._after(rules, done, j)
            found = [
                beam_from(mission, after, there, NARROW, noise=noise, seed=seed)[1]
                for seed, noise in enumerate(NOISES)
            ]
            rest = max(
                _collected(rules, self._rest(plan[craft.chaser], j, there), after, there)
                for plan in (self._best, self._shown)
            )
            means[at] = own + float(np.mean(np.maximum(found, rest)))
            most[at] = own + max(*found, rest)
        for at in np.flatnonzero(most >= np.nanmax(most, initial=-np.inf) - SEEMS_BEST * scale):
            j = int(bodies[at])
            own, there = self._after(rules, done, j)
            after = _stepped(rules, state, done, j)[1]
            most[at] = max(most[at], own + beam_from(mission, after, there, STRONG)[1])
        return 0.5 * (means + most) / scale

    def _after(
        self, rules: rule_kernels.Rules, done: npt.NDArray[np.bool_], j: int
    ) -> tuple[float, npt.NDArray[np.bool_]]:
        """The prize of a move, and what is done after it."""
        there = done.copy()
        there[j] = j >= self._stations
        return float(rules.prize[j]) if j >= self._stations else 0.0, there

    def _rest(self, plan: IntArray, j: int, done: npt.NDArray[np.bool_]) -> IntArray:
        """What is left of a plan after a move: what follows the last target that is done."""
        made = np.flatnonzero(done[plan] | ((plan == j) & (j >= self._stations)))
        rest = plan[made[-1] + 1 :] if made.size else plan
        return rest[1:] if rest.size and rest[0] == j else rest


def _mean_prize(rules: rule_kernels.Rules) -> float:
    """Mean prize of targets that are worth something; 1 if none is."""
    worth = rules.prize[rules.prize > 0.0]
    return float(worth.mean()) if worth.size else 1.0
