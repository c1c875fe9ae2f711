"""The interface of stopping criteria."""

from __future__ import annotations

from typing import Protocol


class Stop(Protocol):
    """A criterion asked once per iteration; the planner defines its iterations."""

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop.

        Parameters
        ----------
        incumbent : float
            Objective of the best plan so far; −inf if there is none.
        bound : float
            Best proven upper bound so far; +inf if there is none.
        """
        ...

    def remaining_s(self) -> float:
        """Remaining time [s], +inf without a limit: for phases that cannot ask."""
        ...
