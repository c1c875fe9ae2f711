"""The learned planner and its training (extras ``[ppo]`` to plan, ``[rl]`` to train)."""

from .planner import ppo

__all__ = ["ppo"]
