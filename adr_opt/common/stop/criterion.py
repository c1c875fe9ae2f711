"""What a stopping criterion is."""

from __future__ import annotations

from typing import Protocol


class Stop(Protocol):
    """Asked once per iteration of a planner; the planner says what an iteration is."""

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether it is enough.

        Parameters
        ----------
        incumbent : float
            Objective of the best plan so far; −inf if there is none.
        bound : float
            Best proven upper bound so far; +inf if there is none.
        """
        ...

    def remaining_s(self) -> float:
        """Seconds that may still be used, +inf without a limit: for parts that cannot ask."""
        ...
