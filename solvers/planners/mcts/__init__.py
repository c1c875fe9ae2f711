"""Monte Carlo tree search: as published, and tuned."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from adr_opt.common.clock import now_s
from adr_opt.common.constants import HOUR_S
from adr_opt.common.progress import Progress, tell_plan
from adr_opt.common.stop import Stop
from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.learning.decoding import Field
from adr_opt.learning.policy import load_policy
from adr_opt.mission.certified import certify
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result

from ...beams.varied_beams import recreate
from ...progress.incumbent import Incumbent
from . import policy as policies
from . import tree as trees
from .settings import MctsOptions, settings_of

__all__ = ["mcts"]


LARGEST_TREE = 10_000_000
"""Maximum number of moves listed in a reused tree before it is rebuilt, which bounds its memory."""

POLISH_WIDTH = 30
"""Width of the polishing beams: a few milliseconds each on nominal missions."""


@dataclass
class _Player:
    """One search: settings in kernel form, memory and counters."""

    mission: Mission
    settings: MctsOptions
    rng: np.random.Generator
    stop: Stop
    progress: Progress
    prior: Field | None = None

    def __post_init__(self) -> None:
        settings = self.settings
        bodies = len(self.mission.names)
        guarded = settings.moves == "guarded"
        width = min(settings.width, bodies)
        self.policy = policies.RolloutSettings(
            min(settings.depth, 2 * bodies),
            settings.rollout == "guarded",
            settings.time_value_m_s_per_h / HOUR_S,
            settings.temperature_m_s,
        )
        self.search = trees.TreeSearch(
            settings.simulations,
            settings.c,
            guarded,
            width,
            settings.scale == "range",
            settings.best_share,
            settings.play == "value",
            settings.tree == "kept",
        )
        listed = width + 1 if guarded else bodies
        nodes = settings.simulations
        if self.search.keep:
            nodes = max(nodes, min(nodes * 2 * bodies, LARGEST_TREE // listed))
        self.tree = trees.allocate(nodes + 1, listed)
        self.scratch = policies.scratch(bodies)
        self.record = trees.new_record(bodies)
        self.best_played = -math.inf
        self.answer: npt.NDArray[np.int64] = np.zeros(0, dtype=np.int64)
        self.missions = self.steps = 0

    @property
    def incumbent(self) -> float:
        """Prize of the plan that would be returned now; −inf before the first step."""
        if self.settings.answer == "best":
            return float(self.record.best[1])
        return self.best_played

    def _new_mission(self) -> int:
        """Reset the tree to the start, together with its value scale."""
        rules = self.mission.rules
        trees.write_node(self.tree, 0, rule_kernels.beginning(rules), 0.0)
        self.record.returns[:] = math.inf, -math.inf
        return 1

    def play(self) -> bool:
        """Play one mission to its end.

        Returns
        -------
        enough : bool
            ``stop`` ended it.
        """
        rules, tree, sequence = self.mission.rules, self.tree, self.scratch.sequence
        visited = np.zeros(len(self.mission.names), dtype=np.bool_)
        root, played, collected = 0, 0, 0.0
        used = self._new_mission()
        while True:
            if self.stop(self.incumbent, math.inf):
                return True
            before = self.incumbent
            if self.prior is not None and tree.untried[root] == trees.NOT_LISTED:
                has = tree.resources
                liked = self.prior.moves(
                    int(tree.body[root]),
                    float(has.time[root]),
                    float(has.left[root]),
                    int(has.since[root]),
                    visited,
                )[: tree.moves.shape[1]]
                # Moves are tried from the end of the list.
                tree.moves[root, : liked.size] = liked[::-1]
                tree.untried[root] = liked.size
            game = trees.Game(root, used, played, collected, visited)
            body, root, used = trees.step(
                rules, self.policy, self.search, self.rng, tree, game, self.scratch, self.record
            )
            self.steps += 1
            if body != trees.NONE:
                # Simulations write into the sequence beyond what is played, never before it.
                sequence[played] = body
                played += 1
                collected += float(rule_kernels.worth_at(rules, body, tree.resources.time[root]))
                visited[body] = not rules.is_station[body]
            if self.settings.answer == "played" and collected > self.best_played:
                self.best_played, self.answer = collected, sequence[:played].copy()
            if self.incumbent > before:
                tell_plan(self.progress, self.incumbent, self.plan())
            if body == trees.NONE:
                self.missions += 1
                return False

    def plan(self) -> npt.NDArray[np.int64]:
        """The sequence to be returned."""
        if self.settings.answer == "best":
            return self.record.sequence[: int(self.record.best[0])]
        return self.answer


def mcts(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    options: MctsOptions = MctsOptions(),
) -> Result:
    """Monte Carlo tree search (UCT): as published, or tuned.

    ``published`` plays one mission: 200 simulations a step, uniform rollouts 15 moves deep,
    c = 1.5, the most visited child is played and a new tree begun; the trajectory played is the
    plan. It ends by itself within tens of milliseconds. ``tuned`` looks along full missions with
    guarded rollouts on a narrow tree, plays mission after mission until ``stop`` says enough (or
    every prize is collected), and returns the best sequence that any simulation saw. ``stop`` is
    asked once before every step; a mission stopped halfway counts as far as it was played.
    """
    settings = settings_of(options)
    start = now_s()
    prior = None
    if options.policy and mission.instance.targets:
        prior = Field(mission, load_policy(options.policy))
    if prior is not None:
        settings = replace(settings, tree="new")
    player = _Player(mission, settings, np.random.default_rng(seed), stop, progress, prior)
    while player.missions < settings.missions and player.incumbent < mission.total_worth:
        if player.play():
            break
    plan, polished = _polish(mission, mission.closed(player.plan()), options.polish, seed, stop)
    return certify(
        mission,
        "mcts",
        plan,
        seed=seed,
        runtime_s=now_s() - start,
        counters={
            "missions": player.missions,
            "steps": player.steps,
            "simulations": player.steps * settings.simulations,
            "polished": polished,
        },
        notes=() if prior is None else prior.policy.notes(mission),
    )


def _polish(
    mission: Mission, plan: tuple[int, ...], steps: int, seed: int, stop: Stop
) -> tuple[tuple[int, ...], int]:
    """Ruin and recreate a plan; returns the best one and the number of improvements."""
    rng = np.random.default_rng(seed)
    polished = 0
    best = Incumbent(mission)
    best.offer(plan)
    for _ in range(steps):
        if stop.remaining_s() <= 0.0:
            break
        polished += best.offer(recreate(mission, best.sequence or (), POLISH_WIDTH, rng))
    return best.sequence or (), polished
