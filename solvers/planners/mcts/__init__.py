"""Monte Carlo tree search: as published, and tuned."""

from .planner import mcts

__all__ = ["mcts"]
