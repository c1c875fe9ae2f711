"""The mission in which everybody may wait and choose: its network, its best walks, its labels."""

from .labels import WaitingRoutes
from .network import WaitingNetwork, build
from .walks import WaitingBound

__all__ = ["WaitingBound", "WaitingNetwork", "WaitingRoutes", "build"]
