"""Training of policies (extra ``[rl]``): the configurations called by ``train``.

For training with Stable-Baselines3 itself there are :class:`SetPolicy` and
:func:`write_policy`. PyTorch is imported only when one of all these is used.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from adr_opt.common.errors import MissingExtra

if TYPE_CHECKING:
    from .policies import SetPolicy

__all__ = ["SetPolicy", "published", "set_", "set_transfer", "write_policy"]

PACKAGES = ("torch", "gymnasium", "sb3_contrib", "tensorboard", "safetensors", "onnx")


def _need(who: str) -> None:
    """Raise :class:`MissingExtra` if a package for training is not installed."""
    from importlib.util import find_spec

    for package in PACKAGES:
        if find_spec(package) is None:
            raise MissingExtra(who, package, "rl")


def _training_of(name: str) -> Callable[..., None]:
    """The training function of a configuration in :mod:`.configs`."""

    def train(folder: Path, **options: Any) -> None:
        _need("train")
        from . import configs
        from .trainer import train as run

        run(configs.config(name), folder, **options)

    train.__doc__ = (
        f"Train the configuration {name!r}; see :class:`adr_opt.learning.trainer.Trainer`."
    )
    return train


set_ = _training_of("set")
set_transfer = _training_of("set-transfer")
published = _training_of("published")


def write_policy(
    model: Any,
    path: str | os.PathLike[str],
    *,
    name: str = "own",
    dynamics: str = "two-body",
    facts: dict[str, Any] | None = None,
) -> None:
    """Write a trained model as a file for ``--policy`` and ``solve(method="ppo", policy=…)``.

    What is written was read again as planners read it.

    Parameters
    ----------
    model : PPO or MaskablePPO
        Of Stable-Baselines3 or sb3-contrib, trained on an environment of
        :mod:`adr_opt.learning.environment` with ``SetPolicy``, or with ``"MlpPolicy"`` on the
        observation ``published``. Reading one from its own file, as ``MaskablePPO.load`` does, runs
        code that is in it.
    path : path
        The ONNX file to write, whole or not at all.
    name : str
        What plans and errors call it.
    dynamics : {"two-body", "j2"}
        Of the fields that it was trained on: plans of others say so.
    facts : dict, optional
        What else the file is to state, as JSON; steps, seed and versions it states anyway.

    Raises
    ------
    InputError
        The model sees something else, its network cannot be written as one of ours, or the file
        cannot be written.
    MissingExtra
        A package of training is not installed.
    """
    _need("write_policy")
    from . import from_sb3

    from_sb3.write_policy(model, Path(path), name, dynamics, facts)


def __getattr__(name: str) -> Any:
    if name == "SetPolicy":
        _need("SetPolicy")
        from .policies import SetPolicy

        return SetPolicy
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
