"""Checkpoints of a training run: weights, optimiser and random states, as plain numbers.

One safetensors file, replaced as a whole. Reading it runs no code, whatever its source.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from stable_baselines3.common.base_class import BaseAlgorithm
from torch import Tensor

from ...common.errors import InputError
from ...common.files import write_bytes
from ...common.json_text import loaded

OPTIMIZER = "optimizer."
"""Prefix of Adam's entries; the number of the parameter and the name of the moment follow."""

NUMPY, TORCH = "random.numpy", "random.torch"
"""Global generators: NumPy's, which shuffles batches, and PyTorch's, which samples moves.

That of a GPU begins anew with the seed."""


def write_checkpoint(model: BaseAlgorithm, path: Path, seconds: float, best: float) -> None:
    """Write a checkpoint, completely or not at all.

    Parameters
    ----------
    model : MaskablePPO
    path : Path
    seconds, best : float
        Time spent so far [s]; the best evaluation.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    steps, updates = model.num_timesteps, model._n_updates
    state = {"steps": steps, "updates": updates, "seconds": seconds, "best": best}
    kept = {name: tensor.detach().cpu().contiguous() for name, tensor in _tensors(model).items()}
    write_bytes(path, save(kept, metadata={"state": json.dumps(state)}))


def read_state(path: Path) -> dict[str, Any]:
    """Scalars stored beside the tensors: steps, updates, seconds and best.

    Raises
    ------
    InputError
        Not a checkpoint.
    """
    try:
        with safe_open(str(path), framework="pt") as file:
            state: dict[str, Any] = loaded((file.metadata() or {})["state"])
        counts = [state["steps"], state["updates"]]
        if any(type(count) is not int or count < 0 for count in counts):
            raise ValueError
        if not float(state["seconds"]) >= 0.0 or math.isnan(float(state["best"])):
            raise ValueError
    except (OSError, SafetensorError, ValueError, KeyError, TypeError, RecursionError):
        raise _damaged(path) from None
    return state


def read_checkpoint(model: BaseAlgorithm, path: Path) -> None:
    """Restore a new model from a checkpoint; its environment restarts.

    Raises
    ------
    InputError
        Not a checkpoint of such a model.
    """
    state = read_state(path)
    policy, optimizer = model.policy, model.policy.optimizer
    wanted = {name: of for name, of in _tensors(model).items() if not name.startswith(OPTIMIZER)}
    remembered: dict[int, dict[str, Tensor]] = {}
    try:
        with safe_open(str(path), framework="pt") as file:
            names = set(file.keys())
            for number, parameter in enumerate(policy.parameters()):
                # The optimiser remembers nothing of what had no gradient yet.
                if f"{OPTIMIZER}{number}.step" in names:
                    remembered[number] = {"step": torch.zeros(())}
                    remembered[number] |= {"exp_avg": parameter, "exp_avg_sq": parameter}
            wanted |= _named(remembered)
            shapes = {name: file.get_slice(name).get_shape() for name in names}
            if shapes != {name: list(tensor.shape) for name, tensor in wanted.items()}:
                raise ValueError
            found = {name: file.get_tensor(name) for name in names}
        if any(found[name].dtype != tensor.dtype for name, tensor in wanted.items()):
            raise ValueError
        *keys, place = found[NUMPY].tolist()
        # NumPy believes that the place is one of the keys.
        if not 0 <= min(*keys, place) <= max(keys) < 2**32 or place > len(keys):
            raise ValueError
        torch.set_rng_state(found[TORCH])
    except (OSError, SafetensorError, RuntimeError, ValueError):
        raise _damaged(path) from None
    shuffling = {"key": np.array(keys, np.uint32), "pos": place}
    np.random.set_state({"bit_generator": "MT19937", "state": shuffling})  # noqa: NPY002
    policy.load_state_dict({name: found[f"policy.{name}"] for name in policy.state_dict()})
    for number, moments in remembered.items():
        for name in moments:
            moments[name] = found[f"{OPTIMIZER}{number}.{name}"]
    groups = optimizer.state_dict()["param_groups"]
    optimizer.load_state_dict({"state": remembered, "param_groups": groups})
    model.num_timesteps, model._n_updates = state["steps"], state["updates"]


def _tensors(model: BaseAlgorithm) -> dict[str, Tensor]:
    """All stored tensors, by name in the file."""
    tensors = {f"policy.{name}": tensor for name, tensor in model.policy.state_dict().items()}
    tensors |= _named(model.policy.optimizer.state_dict()["state"])
    shuffling = np.random.get_state(legacy=False)["state"]  # noqa: NPY002
    tensors[NUMPY] = torch.tensor([*shuffling["key"].tolist(), shuffling["pos"]])
    tensors[TORCH] = torch.get_rng_state()
    return tensors


def _named(moments: dict[int, dict[str, Tensor]]) -> dict[str, Tensor]:
    """State of the optimiser, by name in the file."""
    return {
        f"{OPTIMIZER}{number}.{name}": tensor
        for number, of_one in moments.items()
        for name, tensor in of_one.items()
    }


def _damaged(path: Path) -> InputError:
    return InputError(f"{path}: not the checkpoint of such a training; remove it to begin anew")
