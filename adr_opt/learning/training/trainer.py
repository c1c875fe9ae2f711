"""Training by MaskablePPO: resumable, with evaluations on held-out fields."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from sb3_contrib import MaskablePPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.utils import obs_as_tensor

from ...common.errors import InputError
from ..environment.vector import MissionVecEnv
from ..episodes import Board
from ..held_out import HeldFields
from ..policy import Policy
from .checkpoints import read_checkpoint, write_checkpoint
from .configs import Config
from .imitation import imitate
from .policy_network import SetPolicy
from .runs import TrainingRun, locked

Report = Callable[[int, Mapping[str, float]], None]
"""Callback with the number of steps done, and the last evaluation if there is a new one."""


def model_of(config: Config, env: MissionVecEnv, seed: int, device: str) -> MaskablePPO:
    """A new MaskablePPO model of a configuration."""
    kwargs: dict[str, Any] = dict(config.network)
    policy: Any = SetPolicy
    if "net_arch" in kwargs:
        policy = "MlpPolicy" if config.observation == "published" else "MultiInputPolicy"
        kwargs["activation_fn"] = torch.nn.Tanh
    return MaskablePPO(
        policy,
        env,
        learning_rate=config.rate,
        n_steps=config.rollout,
        batch_size=config.batch,
        n_epochs=config.epochs,
        gamma=config.gamma,
        gae_lambda=config.gae_lambda,
        ent_coef=config.entropy,
        policy_kwargs=kwargs | {"optimizer_kwargs": {"eps": 1e-5}},
        seed=seed,
        device=device,
    )


def policy_of(model: Any, card: Mapping[str, Any]) -> Policy:
    """The policy of a trained model, as planners use it.

    Raises
    ------
    InputError
        A model with another network than :class:`.network.SetPolicy`.
    """
    if not isinstance(model.policy, SetPolicy):
        raise InputError("the model has another network; train it with SetPolicy")
    return Policy(model.policy.network.arrays(), dict(card))


class Keeper(BaseCallback):
    """Sets rates, evaluates, checkpoints, keeps best and last weights, and ends on request.

    Parameters
    ----------
    run : TrainingRun
    config : Config
    every : int
        Steps between evaluations.
    checkpoint_s : float
        Time between checkpoints [s].
    enough : callable
    report : callable
    held_out : HeldFields
    """

    def __init__(
        self,
        run: TrainingRun,
        config: Config,
        every: int,
        checkpoint_s: float,
        enough: Callable[[], bool],
        report: Report,
        held_out: HeldFields,
    ) -> None:
        super().__init__()
        self.run, self.config, self.every, self.checkpoint_s = run, config, every, checkpoint_s
        self.enough, self.report, self.held_out = enough, report, held_out
        state = run.state
        self.best = state.get("best", -math.inf)
        self.spent_s = state.get("seconds", 0.0)
        self._next = (state["steps"] // every + 1) * every if state else 0
        self._began = self._saved = time.perf_counter()

    @property
    def seconds(self) -> float:
        """Time spent training, over all runs [s]."""
        return float(self.spent_s + time.perf_counter() - self._began)

    def _on_step(self) -> bool:
        return not self.enough()

    def _on_rollout_start(self) -> None:
        # Between updates: a checkpoint holds a policy, and no half of a rollout.
        strength = self.config.strength(self.num_timesteps)
        self.model.lr_schedule = lambda _: self.config.rate * strength
        model: Any = self.model
        model.ent_coef = self.config.entropy * strength
        model.batch_size = self.config.batch * (
            1 if strength > 0.5 else 2 if strength > 0.25 else 4
        )
        self.report(self.num_timesteps, {})
        if self.num_timesteps >= self._next:
            self._evaluate()
            self._next = (self.num_timesteps // self.every + 1) * self.every
        if time.perf_counter() - self._saved >= self.checkpoint_s:
            self._save()

    def _on_training_end(self) -> None:
        if not self.enough():
            self._evaluate()
            self._keep("last")
        self._save()

    def _evaluate(self) -> None:
        means = self.measured(self.model)
        self.run.add_to_curve(self.num_timesteps, self.seconds, means)
        if sum(means.values()) > self.best:
            self.best = sum(means.values())
            self._keep("best")
        self.report(self.num_timesteps, means)

    def measured(self, model: Any) -> dict[str, float]:
        """Mean visits on the held-out fields, with the best moves of a model as it is."""

        def choose(board: Board) -> npt.NDArray[np.int64]:
            with torch.no_grad():
                # Not ``predict``: it insists on the number of targets of the training.
                seen = obs_as_tensor(board.arrays, model.device)
                moves = model.policy.get_distribution(seen, board.mask)
                chosen = moves.get_actions(deterministic=True)
            found: npt.NDArray[np.int64] = chosen.cpu().numpy()
            return found

        return self.held_out.means(choose, self.config.observation)

    def _keep(self, name: str) -> None:
        if isinstance(self.model.policy, SetPolicy):
            card = self.run.card(self.num_timesteps)
            policy_of(self.model, card).save(self.run.folder / f"{name}.npz")

    def _save(self) -> None:
        write_checkpoint(self.model, self.run.checkpoint, self.seconds, self.best)
        self._saved = time.perf_counter()


def train(  # noqa: PLR0913
    config: Config,
    folder: Path,
    *,
    seed: int = 0,
    jobs: int = 1,
    device: str = "auto",
    evaluate_every: int = 200_000,
    checkpoint_s: float = 60.0,
    enough: Callable[[], bool] = lambda: False,
    report: Report = lambda steps, means: None,
    held_out: HeldFields | None = None,
) -> None:
    """Train into a folder, from its last checkpoint if it has one.

    Parameters
    ----------
    config : Config
    folder : Path
        Made if it does not exist.
    seed, jobs : int
        ``jobs``: threads.
    device : str
        Device of PyTorch: "cpu", "cuda", or "auto" for a GPU where there is one.
    evaluate_every : int
        Steps between evaluations on held-out fields.
    checkpoint_s : float
        Time between checkpoints [s].
    enough : callable
        Asked after every step; if it returns True, the training ends with a checkpoint.
    report : callable
    held_out : HeldFields, optional
        Fields of the evaluations on the way; those of the block ``val`` if None.

    Raises
    ------
    InputError
        The folder holds another training, or there is no such device.
    """
    if device == "auto":
        device = "cuda" if torch.cuda.is_available() else "cpu"
    if device != "cpu" and not torch.cuda.is_available():
        raise InputError(f"device {device!r}: PyTorch finds no such device here; use cpu")
    with ExitStack() as stack:
        stack.enter_context(locked(folder))
        run = TrainingRun(folder, config, seed)
        torch.set_num_threads(jobs)
        done = int(run.state.get("steps", 0))
        if done >= config.steps:
            report(done, run.last_evaluation())
            return
        env = MissionVecEnv(
            config.missions,
            tuple(config.kinds.values()),
            observation=config.observation,
            slots=config.slots,
            refresh_every=config.refresh_every,
            threads=jobs,
            reward_scale=config.reward_scale,
            uncertainty=config.models or None,
            # A resumed training goes on with other fields than it began with.
            seed=(seed + done) % 2**32,
        )
        stack.callback(env.close)
        model = model_of(config, env, seed, device)
        model.set_logger(Logger(None, []))
        if done:
            read_checkpoint(model, run.checkpoint)
            # A new model seeds the environment as at the beginning.
            env.seed((seed + done) % 2**32)
        keeper = Keeper(
            run, config, evaluate_every, checkpoint_s, enough, report, held_out or HeldFields()
        )
        if config.imitated and not done:
            run.begin_with(keeper.measured(model))
            imitate(model, config, seed, enough)
        model.learn(config.steps - done, callback=keeper, reset_num_timesteps=done == 0)
