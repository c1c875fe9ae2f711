"""Training of a policy: resumable, with evaluations on held-out fields."""

from __future__ import annotations

import json
import math
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from safetensors.torch import save
from sb3_contrib import MaskablePPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import configure
from stable_baselines3.common.utils import obs_as_tensor

from adr_opt.common.errors import InputError
from adr_opt.common.files import write_bytes
from adr_opt.kernels.episodes import episodes as kernels
from adr_opt.learning.environment.fields import Limits
from adr_opt.learning.environment.vector import MissionVecEnv
from adr_opt.learning.episodes import Board, FieldPool, new_episodes, start
from adr_opt.learning.trainer import Report
from adr_opt.mission.mission import Mission
from adr_opt.sources.generator import family, generate

from .checkpoints import read_checkpoint, write_checkpoint
from .configs import Config
from .export import write_onnx
from .policies import SetPolicy
from .runs import TrainingRun, locked


def model_of(config: Config, env: MissionVecEnv, seed: int, device: str) -> MaskablePPO:
    """A new MaskablePPO model of a configuration."""
    first, last = config.learning_rate, config.final_learning_rate
    kwargs: dict[str, Any] = dict(config.network)
    policy: Any = SetPolicy
    if config.policy == "mlp":
        policy = "MlpPolicy"
        kwargs["activation_fn"] = torch.nn.Tanh
    return MaskablePPO(
        policy,
        env,
        learning_rate=lambda left: last + (first - last) * left,
        n_steps=config.rollout,
        batch_size=config.batch,
        n_epochs=config.epochs,
        gamma=config.gamma,
        gae_lambda=config.gae_lambda,
        clip_range=config.clip,
        ent_coef=config.entropy,
        vf_coef=config.value_weight,
        max_grad_norm=config.gradient_norm,
        policy_kwargs=kwargs,
        seed=seed,
        device=device,
    )


class Keeper(BaseCallback):
    """Evaluates, checkpoints, keeps the best and the last weights, and ends on request.

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
    """

    def __init__(
        self,
        run: TrainingRun,
        config: Config,
        every: int,
        checkpoint_s: float,
        enough: Callable[[], bool],
        report: Report,
    ) -> None:
        super().__init__()
        self.run, self.config, self.every, self.checkpoint_s = run, config, every, checkpoint_s
        self.enough, self.report = enough, report
        self.held = HeldFields(config.observation)
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
        means = self.held.evaluate(self.model.policy, self.model.device)
        for name, value in means.items():
            self.logger.record(f"held/{name}", value)
        self.run.add_to_curve(self.num_timesteps, self.seconds, means)
        if sum(means.values()) > self.best:
            self.best = sum(means.values())
            self._keep("best")
        self.report(self.num_timesteps, means)

    def _keep(self, name: str) -> None:
        config = self.config
        facts = {
            "steps": self.num_timesteps,
            "seed": self.run.facts["seed"],
            "versions": self.run.facts["versions"],
            "dynamics": config.fields.draw_field(np.random.default_rng(0)).dynamics,
        }
        tensors = {
            name: tensor.detach().cpu().contiguous()
            for name, tensor in self.model.policy.state_dict().items()
        }
        write_bytes(
            self.run.folder / f"{name}.safetensors",
            save(tensors, metadata={"facts": json.dumps(facts)}),
        )
        targets = None if config.policy == "set" else config.fields.most_targets
        write_onnx(
            self.model.policy,
            self.run.folder / f"{name}.onnx",
            name=config.name,
            observation=config.observation,
            targets=targets,
            facts=facts,
        )

    def _save(self) -> None:
        write_checkpoint(self.model, self.run.checkpoint, self.seconds, self.best)
        self._saved = time.perf_counter()


@contextmanager
def _full_disks_said(folder: Path) -> Iterator[None]:
    """Report a failure of TensorBoard to write, in one sentence.

    Its thread keeps the error for this one, which gets it with the next record, and would print a
    traceback besides.
    """
    before = threading.excepthook

    def hear(thrown: threading.ExceptHookArgs) -> None:
        if not isinstance(thrown.exc_value, OSError):
            before(thrown)

    threading.excepthook = hear
    try:
        yield
    except OSError as error:
        raise InputError(
            f"{folder}: cannot be written ({error.strerror or error}); make room, and give the "
            "same call again"
        ) from error
    finally:
        threading.excepthook = before


def train(  # noqa: PLR0913
    config: Config,
    folder: Path,
    *,
    steps: int | None,
    seed: int,
    jobs: int,
    device: str,
    evaluate_every: int,
    checkpoint_s: float,
    enough: Callable[[], bool],
    report: Report,
) -> None:
    """Train a configuration; see :class:`adr_opt.learning.trainer.Trainer` for the parameters."""
    if device != "cpu" and not torch.cuda.is_available():
        raise InputError(f"device {device!r}: PyTorch finds no such device here; use cpu")
    config = replace(config, steps=config.steps if steps is None else steps)
    with ExitStack() as stack:
        stack.enter_context(_full_disks_said(folder))
        stack.enter_context(locked(folder))
        run = TrainingRun(folder, config, seed)
        torch.set_num_threads(jobs)
        done = int(run.state.get("steps", 0))
        if done >= config.steps and run.last.exists():
            report(done, run.last_evaluation())
            return
        env = MissionVecEnv(
            config.missions,
            config.fields,
            observation=config.observation,
            slots=config.slots,
            refresh_every=config.refresh_every,
            threads=jobs,
            reward_scale=config.reward_scale,
            # A resumed training goes on with other fields than it began with.
            seed=(seed + done) % 2**32,
        )
        stack.callback(env.close)
        model = model_of(config, env, seed, device)
        if done:
            read_checkpoint(model, run.checkpoint)
            # A new model seeds the environment as at the beginning.
            env.seed((seed + done) % 2**32)
        model.set_logger(configure(str(folder / "tensorboard"), ["tensorboard"]))
        keeper = Keeper(run, config, evaluate_every, checkpoint_s, enough, report)
        if done >= config.steps:
            # It was stopped after its last step, and before it was ended.
            keeper.init_callback(model)
            keeper.num_timesteps = done
            keeper.on_training_end()
            return
        model.learn(config.steps - done, callback=keeper, reset_num_timesteps=done == 0)


HELD_SEED, HELD_FIELDS = 900_000, 24
"""First seed and number of the held-out fields: not in the library, and never trained on."""

FAMILIES = ("nominal", "reduced-time", "reduced-fuel")


class HeldFields:
    """Held-out fields with timetables, one pool for the three benchmark families.

    Parameters
    ----------
    observation : str
        What the policy sees.
    """

    def __init__(self, observation: str) -> None:
        self._observation = observation
        missions = [
            Mission(generate("nominal", HELD_SEED + number), threads=1)
            for number in range(HELD_FIELDS)
        ]
        events = max(mission.timetable.most_events for mission in missions)
        self._bodies = len(missions[0].names)
        self.pool = FieldPool(HELD_FIELDS, self._bodies, events)
        for slot, mission in enumerate(missions):
            self.pool.install(slot, mission)

    def evaluate(self, policy: Any, device: torch.device | str = "cpu") -> dict[str, float]:
        """Mean visits in each family, with the best move at every step.

        Parameters
        ----------
        policy : MaskableActorCriticPolicy
        """
        games = []
        for name in FAMILIES:
            limits = Limits(family(name).delta_v_m_s, family(name).duration_s)
            games += [(slot, limits) for slot in range(HELD_FIELDS)]

        def choose(board: Board) -> npt.NDArray[np.int64]:
            with torch.no_grad():
                # Not ``predict``: it insists on the number of targets of the training.
                distribution = policy.get_distribution(
                    obs_as_tensor(board.arrays, torch.device(device)), board.mask
                )
                actions = distribution.get_actions(deterministic=True)
            chosen: npt.NDArray[np.int64] = actions.cpu().numpy()
            return chosen

        serviced = np.zeros(len(games))
        episodes = new_episodes(len(games), self._bodies)
        for index, (slot, limits) in enumerate(games):
            start(self.pool, episodes, index, slot, limits.delta_v_m_s, limits.duration_s)
        running = np.arange(len(games))
        while True:
            board = Board(self._observation, running.size, self._bodies - 1)
            board.observe(self.pool.arrays, episodes, 0, running.size)
            alive = board.legal > 0
            if not alive.all():
                serviced[running[~alive]] = episodes.serviced[~alive]
                running = running[alive]
                episodes = kernels.Episodes(*(part[alive].copy() for part in episodes))
                if not running.size:
                    break
                continue
            rewards = np.zeros(running.size, dtype=np.float32)
            kernels.act(self.pool.arrays, episodes, 0, running.size, choose(board), rewards)
        means = serviced.reshape(len(FAMILIES), HELD_FIELDS).mean(axis=1)
        return dict(zip(FAMILIES, means.tolist(), strict=True))
