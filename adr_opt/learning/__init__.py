"""The mission as an environment, and the policy learned on it: training, use, evaluation.

``load_policy`` and ``evaluate`` need NumPy and Numba alone, ``SetPolicy`` and ``write_policy`` the
extra ``[rl]``. Nothing is imported before it is used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from ..common.errors import MissingExtra

if TYPE_CHECKING:
    from .evaluation import Evaluation, evaluate
    from .policy import Policy, load_policy
    from .training.own import write_policy
    from .training.policy_network import SetPolicy

__all__ = ["Evaluation", "Policy", "SetPolicy", "evaluate", "load_policy", "write_policy"]

_HOMES = {
    "Evaluation": ".evaluation",
    "evaluate": ".evaluation",
    "Policy": ".policy",
    "load_policy": ".policy",
    "SetPolicy": ".training.policy_network",
    "write_policy": ".training.own",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        return getattr(import_module(_HOMES[name], __name__), name)
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] == "adr_opt":
            raise
        raise MissingExtra(name, error.name.partition(".")[0], "rl") from None
