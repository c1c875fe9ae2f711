"""Write a trained network as an ONNX file that plans without PyTorch."""

from __future__ import annotations

import io
import json
import warnings
from pathlib import Path
from typing import Any

import onnx
import torch
from torch import nn

from adr_opt.common.files import write_bytes
from adr_opt.kernels.episodes.observation import MISSION_FIELDS
from adr_opt.learning.episodes.board import MISSION, MOVES, move_fields, published_size

from ..policies.policy import FORMAT, field_names
from ..policies.screening import OPSET


class _Flat(nn.Module):
    """Stable-Baselines3's multilayer perceptron as one network of the flat observation."""

    def __init__(self, policy: Any) -> None:
        super().__init__()
        self.trunk = policy.mlp_extractor
        self.action, self.value = policy.action_net, policy.value_net

    def forward(self, observation: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Scores and values."""
        for_scores, for_value = self.trunk(observation)
        return self.action(for_scores), self.value(for_value).squeeze(-1)


def write_onnx(
    policy: Any,
    path: Path,
    *,
    name: str,
    observation: str,
    targets: int | None,
    facts: dict[str, Any],
) -> None:
    """Write a policy, completely or not at all.

    Parameters
    ----------
    policy : SetPolicy or ActorCriticPolicy
    path : Path
    name : str
        Configuration.
    observation : str
    targets : int or None
        Number of targets of a network of fixed size.
    facts : dict
        Training steps, seed and versions.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    if observation == "published":
        network: nn.Module = _Flat(policy)
        inputs: tuple[torch.Tensor, ...] = (torch.zeros(2, published_size(targets or 0)),)
        names = ["observation"]
        axes = {"observation": {0: "batch"}}
    else:
        network = policy.network
        fields = len(move_fields(observation))
        inputs = (torch.zeros(2, 3, fields), torch.zeros(2, len(MISSION_FIELDS)))
        names = [MOVES, MISSION]
        axes = {MOVES: {0: "batch", 1: "actions"}, MISSION: {0: "batch"}}
    axes |= {"scores": {0: "batch", 1: "actions"}, "value": {0: "batch"}}
    training = network.training
    network.eval()
    # In memory: the exporter and onnx say in their own ways that a disk is full.
    file = io.BytesIO()
    with warnings.catch_warnings():
        # The exporter by TorchScript is called old, but it needs no further package and takes
        # axes of any length.
        warnings.simplefilter("ignore")
        torch.onnx.export(
            network,
            inputs,
            file,  # type: ignore[arg-type]  # it takes files, and does not say so
            input_names=names,
            output_names=["scores", "value"],
            dynamic_axes=axes,
            opset_version=OPSET,
            dynamo=False,
        )
    network.train(training)
    model = onnx.ModelProto.FromString(file.getvalue())
    for key, value in {
        "format": FORMAT,
        "name": name,
        "observation": observation,
        "fields": field_names(observation),
        "targets": str(targets or 0),
        "facts": json.dumps(facts),
    }.items():
        entry = model.metadata_props.add()
        entry.key, entry.value = key, value
    # The exporter writes where each node stands in the source, which does not belong in the file.
    for node in model.graph.node:
        node.doc_string = ""
        del node.metadata_props[:]
    write_bytes(path, model.SerializeToString())
