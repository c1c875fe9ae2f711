"""Stopping criteria: small objects that tell a planner, from its incumbent and bound, to stop."""

from .any_of import AnyOf
from .clock import Clock
from .criterion import Stop
from .interrupted import Interrupted
from .max_iterations import MaxIterations
from .max_runtime import MaxRuntime
from .no_improvement import NoImprovement
from .proven import Proven
from .time_is_over import TimeIsOver

__all__ = [
    "AnyOf",
    "Clock",
    "Interrupted",
    "MaxIterations",
    "MaxRuntime",
    "NoImprovement",
    "Proven",
    "Stop",
    "TimeIsOver",
]
