"""A model trained elsewhere with Stable-Baselines3, as a file for ``--policy``."""

from __future__ import annotations

import os
from typing import Any

from ...common.errors import InputError
from ..policy import load_policy
from .trainer import policy_of


def write_policy(
    model: Any,
    path: str | os.PathLike[str],
    *,
    name: str = "own",
    dynamics: str = "two-body",
    facts: dict[str, Any] | None = None,
) -> None:
    """Write a trained model as a file for ``--policy`` and ``solve(method="ppo", policy=…)``.

    Parameters
    ----------
    model : MaskablePPO
        Of sb3-contrib, trained with ``SetPolicy`` on the observation ``choices`` of
        :mod:`adr_opt.learning.environment`. Reading one from its own file, as
        ``MaskablePPO.load`` does, runs code that is in it.
    path : path
        The file to write, whole or not at all.
    name : str
        Name of the policy in plans.
    dynamics : {"two-body", "j2"}
        Dynamics of the fields that it was trained on; plans of fields with others have a note.
    facts : dict, optional
        Further entries of its card, as JSON; it always states steps and seed.

    Raises
    ------
    InputError
        The model has another network or another observation, or the file cannot be written.
    """
    if model.get_vec_normalize_env() is not None:
        raise InputError(
            "the model sees what VecNormalize makes of observations, and planners do not; train it "
            "without"
        )
    card = {"name": name, "dynamics": dynamics, "steps": model.num_timesteps, "seed": model.seed}
    policy_of(model, card | (facts or {})).save(path)
    load_policy(path)
