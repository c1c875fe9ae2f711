"""Training of policies (extra ``[rl]``): the configurations as ``train`` calls them.

PyTorch is imported only when one is called.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from adr_opt.errors import MissingExtra

PACKAGES = ("torch", "gymnasium", "sb3_contrib", "tensorboard", "safetensors", "onnx")


def _training_of(name: str) -> Callable[..., None]:
    """The training of a configuration of :mod:`solvers.training.configs`."""

    def train(folder: Path, **options: Any) -> None:
        from importlib.util import find_spec

        for package in PACKAGES:
            if find_spec(package) is None:
                raise MissingExtra("train", package, "rl")
        from . import configs
        from .trainer import train as run

        run(configs.config(name), folder, **options)

    train.__doc__ = f"Train the configuration {name!r}; see :class:`adr_opt.trainer.Trainer`."
    return train


set_ = _training_of("set")
set_transfer = _training_of("set-transfer")
published = _training_of("published")
