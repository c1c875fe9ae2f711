"""Walks through drawn missions, with the worth of moves by beams: what is imitated."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.learning.next_leg.features import LEG_FEATURES
from adr_opt.learning.next_leg.near_orbits import NearOrbits
from adr_opt.learning.next_leg.scorer import LegScorer
from adr_opt.mission.mission import Mission
from solvers.beams.beams import beam_search, usual_settings

from .positions import Position

FloatArray = npt.NDArray[np.float64]

SLOTS = 64
"""Legs kept of a decision."""

PLAN_WIDTH = 150
"""Width of the beam that makes the plan that a walk begins with."""

LABEL_WIDTH = 6
NOISES = (0.0, *(0.4,) * 7)
"""Width of the beams that judge moves, and the random parts of their comparisons."""

TRIED = 7
"""Moves judged by cost, and again as many by the present scores."""

PLANNED, UNCERTAIN, SHARED, AHEAD = 0.5, 0.6, 0.2, 0.85
"""Shares of walks that begin with a plan, in uncertain worlds, beside another chaser, and
with legs after the next one in sight."""

LABELLED = 0.45
"""Share of decisions that are judged."""

ASTRAY = 0.12
"""Share of moves that are drawn."""


class Decision(NamedTuple):
    """A judged decision, padded to :data:`SLOTS` legs.

    Attributes
    ----------
    legs : (SLOTS, LEG_FEATURES) float32
    mission : (MISSION_FEATURES,) float32
    count : int
        Legs.
    worth : (SLOTS,) float32
        Of each leg with what follows, over the mean prize; NaN where it was not judged.
    """

    legs: npt.NDArray[np.float32]
    mission: npt.NDArray[np.float32]
    count: int
    worth: npt.NDArray[np.float32]


def walk(mission: Mission, rng: np.random.Generator, scorer: LegScorer | None) -> list[Decision]:
    """Judged decisions of one walk through a mission."""
    at = begun(mission, rng)
    uncertain = rng.random() < UNCERTAIN
    factors, delays = float(rng.choice([0.03, 0.1, 0.2])), float(rng.choice([0.0, 0.3, 0.6]))
    found = []
    while True:
        choices, legs, numbers = at.seen()
        if choices.bodies.size == 0:
            return found
        scores = None if scorer is None else scorer.scores(legs, numbers, choices.legal)
        cost = legs[:, 5]
        judged = scorer is None or rng.random() < LABELLED
        if choices.bodies.size > 1 and judged:
            decision = _judged(at, choices.bodies, legs, numbers, scores)
            found.append(decision)
            best = np.nan_to_num(decision.worth[: decision.count], nan=-np.inf)
            choice = int(rng.choice(np.flatnonzero(best >= best.max() - 1e-9)))
            choice = int(decision_order(cost, choices.bodies.size)[choice])
            if scores is not None and rng.random() < 0.6:
                choice = int(np.argmax(scores))
        else:
            choice = int(np.argmin(cost)) if scores is None else int(np.argmax(scores))
            planned = np.flatnonzero(choices.ranks == 0)
            if scores is None and planned.size:
                choice = int(planned[0])
        if rng.random() < ASTRAY:
            near = np.argsort(cost)[:6]
            choice = int(rng.choice(near))
        j = int(choices.bodies[choice])
        before = at.state.resources
        at.move(j)
        if uncertain:
            at.state = _disturbed(at, before, float(choices.delta_v[choice]), rng, factors, delays)


def unplanned(mission: Mission) -> Position:
    """A walk of the only chaser at its beginning, without a plan."""
    rules = mission.rules
    bodies = rules.service.size
    none = np.empty(0, dtype=np.int64)
    kits = 0 if rules.loads is None else rules.loads.full.size - 1
    state = rule_kernels.beginning_with(rules, kits)
    prizes = np.zeros(bodies)
    prizes[rules.first_target :] = [target.prize for target in mission.instance.targets]
    mean = prizes[prizes > 0.0].mean() if (prizes > 0.0).any() else 1.0
    return Position(
        mission, NearOrbits(mission.instance), state, np.zeros(bodies, dtype=np.bool_), none,
        np.empty(0), np.empty(0), np.zeros(bodies, dtype=np.bool_), prizes / mean,
    )  # fmt: skip


def begun(mission: Mission, rng: np.random.Generator) -> Position:
    """A walk at its beginning, with a plan or beside another chaser or neither."""
    at, rules = unplanned(mission), mission.rules
    if rng.random() < SHARED:
        # Another chaser has serviced some targets, plans to service others, and is among them.
        targets = np.arange(rules.first_target, rules.service.size)
        theirs = rng.permutation(targets)[: rng.integers(3, max(4, targets.size // 2))]
        if rng.random() < 0.5:
            near = at.around.at(0.0).near
            theirs = near[int(rng.choice(targets))][: theirs.size]
        cut = int(rng.integers(0, theirs.size))
        at.visited[theirs[:cut]] = True
        at.elsewhere[theirs[cut:]] = True
        at.other = int(theirs[cut])
    at.looks_ahead = bool(rng.random() < AHEAD)
    if rng.random() < PLANNED:
        _plan(at, rng)
    else:
        at.elsewhere[:] = False
    return at


def _plan(at: Position, rng: np.random.Generator) -> None:
    """Give a walk the plan of a beam."""
    mission, rules = at.mission, at.mission.rules
    plan = beam_search(mission, usual_settings(mission, PLAN_WIDTH), seed=int(rng.integers(99)))[0]
    plan = plan[~(at.visited | at.elsewhere)[plan]]
    ends, lefts = np.empty(plan.size), np.empty(plan.size)
    made = rule_kernels.replay(rules, plan, at.state, np.zeros_like(at.visited), ends, lefts)[0]
    at.plan = plan[:made]
    at.plan_ends = np.concatenate([[at.state.resources.time], ends[:made]])
    at.plan_lefts = np.concatenate([[at.state.resources.left], lefts[:made]])


def decision_order(cost: FloatArray, count: int) -> npt.NDArray[np.int64]:
    """The legs that are kept of a decision: the cheapest."""
    order: npt.NDArray[np.int64] = np.argsort(cost, kind="stable")[: min(count, SLOTS)]
    return order


def _judged(
    at: Position, bodies: npt.NDArray[np.int64], legs: FloatArray, numbers: FloatArray,
    scores: npt.NDArray[np.float32] | None,
) -> Decision:  # fmt: skip
    order = decision_order(legs[:, 5], bodies.size)
    legs, bodies = legs[order], bodies[order]
    tried = set(range(min(TRIED if scores is not None else 2 * TRIED, bodies.size)))
    if scores is not None:
        tried |= set(np.argsort(-scores[order])[:TRIED].tolist())
    tried |= set(np.flatnonzero((legs[:, 0] > 0.0) | (legs[:, 21] > 0.0)).tolist())
    worth = np.full(SLOTS, np.nan, dtype=np.float32)
    mean = at.mission.rules.prize[at.mission.rules.prize > 0.0].min()
    prizes = at.worths[at.worths > 0.0]
    scale = mean / prizes.min() if prizes.size else 1.0
    for place in sorted(tried):
        worth[place] = at.worth_after(int(bodies[place]), LABEL_WIDTH, NOISES) / scale
    padded = np.zeros((SLOTS, LEG_FEATURES), dtype=np.float32)
    padded[: bodies.size] = legs
    return Decision(padded, numbers.astype(np.float32), bodies.size, worth)


def _disturbed(
    at: Position, before: object, delta_v: float, rng: np.random.Generator, factors: float,
    delays: float,
) -> rule_kernels.State:  # fmt: skip
    """The state after a move whose leg cost more or less, and whose service took longer."""
    state, rules = at.state, at.mission.rules
    has = state.resources
    left = has.left
    if not rules.is_station[state.body]:
        left = max(left - (np.exp(factors * rng.standard_normal()) - 1.0) * delta_v, 0.0)
    time = has.time
    if delays:
        time += float(rules.service[state.body]) * (np.exp(delays * rng.standard_normal()) - 1.0)
        if rng.random() < 0.1:
            time += float(rng.exponential(14400.0))
    return rule_kernels.State(state.body, has._replace(left=float(left), time=float(time)))
