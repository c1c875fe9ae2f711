"""Imitation: a first policy from plans of beams, before any play."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import torch

from ...kernels.episodes import episodes as kernels
from ...kernels.episodes.choices import LEGAL
from ...kernels.episodes.episodes import HOME
from ...kernels.episodes.set_scores import UNSEEN
from ...mission.mission import Mission
from ...plan.plan import Plan
from ...run.front import solve
from ...sources.generator import generate
from ..environment.fields import FIRST_SEED
from ..episodes import Board, FieldPool, new_episodes, playing_time_s, start
from ..held_out import chaser_by_chaser
from .configs import Config

FAMILIES = {"varied": (*("reduced-time", "nominal", "reduced-fuel") * 3, "reduced-time")}
"""Families of the fields in turn, of kinds of missions that are not of one family."""

WIDTH = 300
"""Width of the beams."""

EPOCHS = 20
"""Passes over all states."""

ILLEGAL = -1e8
"""Score of moves that are not legal."""


class TaughtState(NamedTuple):
    """A state of a plan, and what comes of it.

    Attributes
    ----------
    moves : (actions, fields) float32
    mission : (len(MISSION_FIELDS),) float32
    action : int
        The plan's next move.
    to_go : float
        What the plan of this chaser collects from there on [mean prizes].
    """

    moves: npt.NDArray[np.float32]
    mission: npt.NDArray[np.float32]
    action: int
    to_go: float


def states_of(mission: Mission, *plans: Plan) -> list[TaughtState]:
    """States of plans, of each as far as its moves are those of the environment.

    That has one connection for each move, and a plan may need another one. Several plans are those
    of chasers like that of the mission, which find what others have left.
    """
    pool, targets, instance = FieldPool.of(mission), len(mission.names) - 1, mission.instance
    episodes, rewards = new_episodes(1, targets + 1), np.zeros(1, dtype=np.float32)
    budget = instance.chaser.tank.delta_v_m_s - mission.reserve_m_s
    bodies = {name: body for body, name in enumerate(mission.names)}
    board, found, gone = Board("choices", 1, targets), list[TaughtState](), list[int]()
    for plan in plans:
        start(pool, episodes, 0, 0, budget, playing_time_s(instance))
        episodes.visited[0, gone] = True
        for leg in plan.legs:
            board.observe(pool.arrays, episodes, 0, 1)
            action = int(kernels.action_of(bodies[leg.destination], targets))
            if not board.mask[0, action]:
                break
            seen, left = board.choices, plan.objective - float(episodes.collected[0])
            found.append(TaughtState(seen.moves[0].copy(), seen.mission[0].copy(), action, left))
            kernels.act(pool.arrays, episodes, 0, 1, np.array([action]), rewards)
        gone += [bodies[leg.destination] for leg in plan.legs if bodies[leg.destination] != HOME]
    return found


def imitate(
    model: Any, config: Config, seed: int = 0, enough: Callable[[], bool] = lambda: False
) -> int:
    """Let a model choose as beams do on ``config.imitated`` fields; returns the number of states.

    Nothing is imitated if ``enough`` is true on the way. The model has a :class:`.SetPolicy`.
    """
    states = list[TaughtState]()
    for at in range(config.imitated):
        if enough():
            return 0
        turn, kind = divmod(at, len(config.kinds))
        name, fields = list(config.kinds.items())[kind]
        families = FAMILIES.get(name, (fields.family,))
        field = generate(families[turn % len(families)], FIRST_SEED + 100_000 * seed + at)
        first: Mission | None = None
        plans = list[Plan]()
        for mission in chaser_by_chaser(field, plans):
            first = first or mission
            plan = solve(mission, "beam", width=WIDTH, time_limit=math.inf).plan
            plans += [] if plan is None else [plan]
        if first is not None and plans:
            states += states_of(first, *plans)
    if not states:
        return 0
    network, device = model.policy.network, model.device
    moves, seen, actions, to_go = (
        torch.as_tensor(np.array(column), device=device) for column in zip(*states, strict=True)
    )
    worth = (config.reward_scale * to_go).float()
    optimiser = torch.optim.Adam(network.parameters(), config.rate, eps=1e-5)
    for _ in range(EPOCHS):
        for rows in torch.split(torch.randperm(len(states), device=device), config.batch):
            scores, value = network(moves[rows], seen[rows])
            told = scores.masked_fill(moves[rows][..., LEGAL] == 0.0, ILLEGAL)
            # Nothing is learned of a move that the network does not see.
            known = scores.gather(1, actions[rows].unsqueeze(1)).squeeze(1) > UNSEEN
            taken = told[known], actions[rows][known]
            loss = torch.nn.functional.cross_entropy(*taken, reduction="sum")
            loss = loss / known.sum().clamp(min=1) + 0.5 * (value - worth[rows]).square().mean()
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
    return len(states)
