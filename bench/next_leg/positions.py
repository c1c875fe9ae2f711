"""A mission while it is walked through, as the policy sees it and as beams go on from it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.core.memory import borrowed
from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.kernels.rules.loads import full_tank
from adr_opt.kernels.rules.resources import Resources
from adr_opt.kernels.tables import timetable
from adr_opt.kernels.tables.rows_of_body import from_rules
from adr_opt.learning.next_leg.choices import Choices, Standing
from adr_opt.learning.next_leg.features import features
from adr_opt.learning.next_leg.near_orbits import NearOrbits
from adr_opt.learning.next_leg.onward import onward, unknown
from adr_opt.mission.mission import Mission
from solvers.beams.beams import beam_kernel, usual_settings
from solvers.beams.levels import Weights
from solvers.walks.completion_times import no_latest

BoolArray = npt.NDArray[np.bool_]
FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
State = rule_kernels.State


@kernel
def steps_to(rules, state, visited, bodies, legal, figures):
    """Moves to some bodies: whether they are legal; ΔV, arrival, end and ΔV left after each."""
    rules = borrowed(rules)
    for place in range(bodies.size):
        j = bodies[place]
        fits, _, after = rule_kernels.step(rules, state, j)
        legal[place] = fits and rule_kernels.may_go(rules, state, visited, j)
        delta_v, arrival = timetable.lookup(rules.table, state.body, j, state.resources.time)
        figures[place, 0], figures[place, 1] = delta_v, arrival
        figures[place, 2], figures[place, 3] = after.resources.time, after.resources.left


@kernel
def stepped(rules, state, body):
    """The state after a move that is legal."""
    return rule_kernels.step(borrowed(rules), state, body)[2]


@kernel
def guarded(rules, state, body):
    """Whether a chaser can still refuel after a legal move, or no longer needs to."""
    rules = borrowed(rules)
    if rules.is_station[body]:
        return True
    return rule_kernels.has_way_back(rules, rule_kernels.step(rules, state, body)[2])


@kernel
def collected_by(rules, sequence, state, visited):
    """Prizes along a sequence of bodies, of which moves that are not legal are left out."""
    rules = borrowed(rules)
    total = 0.0
    for j in sequence:
        if rule_kernels.may_go(rules, state, visited, j):
            legal, _, after = rule_kernels.step(rules, state, j)
            if legal:
                state = after
                visited[j] = not rules.is_station[j]
                total += rules.prize[j]
    return total


@dataclass
class Position:
    """Where a walk through a mission is.

    Attributes
    ----------
    mission : Mission
    around : NearOrbits
    state : State
    visited : (bodies,) bool
        Targets that are done, or left to another chaser.
    plan : (legs,) int64
        Bodies of the plan in order; none without one.
    plan_ends, plan_lefts : (legs,) float64
        Time and ΔV left before each planned leg [s], [m/s].
    elsewhere : (bodies,) bool
        Targets that another chaser plans to service.
    worths : (bodies,) float64
        Of targets, over the mean of those that are worth something.
    other : int
        Body at which another chaser is; −1 without one.
    next_planned : int
    looks_ahead : bool
        Whether legs after the next one are seen.
    """

    mission: Mission
    around: NearOrbits
    state: State
    visited: BoolArray
    plan: IntArray
    plan_ends: FloatArray
    plan_lefts: FloatArray
    elsewhere: BoolArray
    worths: FloatArray
    other: int = -1
    next_planned: int = 0
    looks_ahead: bool = True
    _halt: BoolArray = field(default_factory=lambda: np.zeros(1, dtype=np.bool_))

    def advance(self) -> None:
        """Go past planned legs that are done, or not to be flown any more."""
        rules, state = self.mission.rules, self.state
        while self.next_planned < self.plan.size:
            j = self.plan[self.next_planned]
            spent = rules.is_station[j] and (state.resources.since == 0 or j == state.body)
            if not (spent or self.visited[j]):
                return
            self.next_planned += 1

    def seen(self) -> tuple[Choices, FloatArray, FloatArray]:
        """The legal legs, and what the policy sees of them and of the mission."""
        self.advance()
        rules, state = self.mission.rules, self.state
        here = state.resources
        bodies = np.flatnonzero(~self.visited)
        bodies = bodies[(bodies < rules.stations) | (bodies >= rules.first_target)]
        bodies = bodies[bodies != state.body]
        legal = np.zeros(bodies.size, dtype=np.bool_)
        figures = np.empty((bodies.size, 4))
        steps_to(rules, state, self.visited, bodies, legal, figures)
        bodies, figures = bodies[legal], figures[legal]
        ranks = np.full(rules.service.size, -1)
        left = self.plan[self.next_planned :]
        for rank, j in reversed(list(enumerate(left))):
            ranks[j] = rank
        places = self.around.at(here.time)
        apart = np.full(bodies.size, np.inf)
        if self.other >= 0:
            apart = places.distances(self.other, bodies)
        has_plan = left.size > 0
        at = self.next_planned
        standing = Standing(
            int(state.body), here.time, rules.duration, here.left,
            float(full_tank(rules.loads, rules.budget, int(here.kits))), int(here.since),
            rules.stations, 2 if self.other >= 0 else 1,
            here.left - float(self.plan_lefts[at]) if has_plan else None,
            float(self.plan_ends[at]) - here.time if has_plan else None,
        )  # fmt: skip
        choices = Choices(
            bodies, figures[:, 0], figures[:, 1], figures[:, 2], figures[:, 3],
            rules.closes[bodies], np.maximum(rules.opens[bodies] - figures[:, 1], 0.0),
            np.ones(bodies.size, dtype=np.bool_), ranks[bodies], self.elsewhere[bodies], apart,
        )  # fmt: skip
        worths = np.where(self.visited, 0.0, self.worths)
        ahead = unknown(bodies.size)
        if self.looks_ahead:
            ahead = onward(choices, places, worths, rules.duration, rules.stations, self.connecting)
        required = self.mission.is_required
        return choices, *features(standing, choices, ahead, places, worths, required)

    def connecting(
        self, origins: IntArray, ready: FloatArray, destinations: IntArray
    ) -> tuple[FloatArray, FloatArray]:
        """Connections of some pairs at some times."""
        delta_v, arrival = np.empty(origins.size), np.empty(origins.size)
        from_rules(self.mission.rules, origins, ready, destinations, delta_v, arrival)
        return delta_v, arrival

    def move(self, body: int) -> None:
        """Make a legal move."""
        rules = self.mission.rules
        self.state = stepped(rules, self.state, body)
        self.visited[body] = not rules.is_station[body]

    def is_guarded(self, body: int) -> bool:
        """Whether a legal move leaves a way to refuel, or none is needed any more."""
        return bool(guarded(self.mission.rules, self.state, body))

    def worth_after(self, body: int, width: int, noises: tuple[float, ...]) -> float:
        """Prizes of a move and of what beams and the plan go on with, the mean over beams."""
        rules = self.mission.rules
        after, visited = stepped(rules, self.state, body), self.visited.copy()
        own = 0.0
        if not rules.is_station[body]:
            visited[body] = True
            own = 0.0 if self.elsewhere[body] else float(rules.prize[body])
        done = visited | self.elsewhere
        planned = 0.0
        if self.next_planned < self.plan.size:
            planned = collected_by(rules, self.plan[self.next_planned :], after, done.copy())
        before = float(rules.prize[done].sum())
        has: Resources = after.resources
        first = (
            int(after.body), int(has.since), np.array([has.kits]), np.array([has.time]),
            np.array([has.left]), np.zeros(1), np.zeros(1),
        )  # fmt: skip
        found = []
        for seed, noise in enumerate(noises):
            weights = _weights(self.mission, width, noise, seed)
            prize = beam_kernel(rules, done, first, no_latest(), False, weights, self._halt)[1]
            found.append(max(prize - before, planned))
        return own + float(np.mean(found))


def _weights(mission: Mission, width: int, noise: float, seed: int) -> Weights:
    usual = usual_settings(mission, width)
    return Weights(
        width, usual.time_weight / 3600.0, usual.delta_v_weight / 1000.0, usual.crowding, noise,
        usual.guarded, seed,
    )  # fmt: skip
