"""Conversion of a trained Stable-Baselines3 model to a file for ``--policy``."""

from __future__ import annotations

import tempfile
from importlib.metadata import version
from pathlib import Path
from typing import Any

from gymnasium import spaces
from stable_baselines3.common.torch_layers import FlattenExtractor

from adr_opt.common.errors import InputError
from adr_opt.common.files import check_writable, write_bytes
from adr_opt.learning.episodes import OBSERVATIONS
from adr_opt.learning.episodes.board import MISSION, MOVES, move_fields, published_size

from ..policies.policy import load_policy
from .export import write_onnx

PACKAGES = ("torch", "stable_baselines3", "sb3_contrib")


def write_policy(
    model: Any, path: Path, name: str, dynamics: str, facts: dict[str, Any] | None
) -> None:
    """See :func:`.write_policy`."""
    check_writable(path)
    observation, targets = _seen(model.observation_space)
    policy = model.policy
    if observation == "published":
        if not isinstance(getattr(policy, "features_extractor", None), FlattenExtractor):
            raise InputError(
                "the model takes its observation in parts; train it with policy='MlpPolicy'"
            )
    elif not hasattr(policy, "network"):
        raise InputError(
            f"the observation {observation!r} has a row for each move, and the network has to take "
            "any number of them; train it with policy=solvers.training.SetPolicy"
        )
    if model.get_vec_normalize_env() is not None:
        raise InputError(
            "the model sees what VecNormalize makes of observations, and planners do not; train it "
            "without"
        )
    stated = {
        "steps": int(model.num_timesteps),
        "seed": model.seed,
        "versions": {package: version(package) for package in PACKAGES},
        "dynamics": dynamics,
        **(facts or {}),
    }
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "policy.onnx"
        before = policy.device
        write_onnx(
            policy.to("cpu"),
            made,
            name=name,
            observation=observation,
            targets=targets,
            facts=stated,
        )
        policy.to(before)
        try:
            load_policy(made)
        except InputError as error:
            said = str(error).removeprefix(f"{made}: ")
            raise InputError(f"the model cannot be a policy: {said}") from None
        write_bytes(path, made.read_bytes())


def _seen(space: Any) -> tuple[str, int | None]:
    """Observation and number of targets of a space.

    Raises
    ------
    InputError
        It is of none.
    """
    if isinstance(space, spaces.Dict) and set(space.spaces) == {MOVES, MISSION}:
        wide = (space[MOVES].shape or (0,))[-1]
        for name in OBSERVATIONS:
            if name != "published" and len(move_fields(name)) == wide:
                return name, None
    if isinstance(space, spaces.Box) and len(space.shape) == 1:
        targets = (space.shape[0] - published_size(0)) // (published_size(1) - published_size(0))
        if targets > 0 and published_size(targets) == space.shape[0]:
            return "published", targets
    raise InputError(
        "the model was trained on other observations than those of "
        f"adr_opt.learning.environment; train it on one of them: {', '.join(OBSERVATIONS)}"
    )
