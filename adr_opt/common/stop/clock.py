"""Stop when another criterion runs out of time."""

from __future__ import annotations

from .criterion import Stop


class Clock:
    """The time limit of another criterion, which is not asked: for phases without iterations."""

    def __init__(self, stop: Stop) -> None:
        self._stop = stop

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        return self.remaining_s() <= 0.0

    def remaining_s(self) -> float:
        """Remaining time [s]."""
        return self._stop.remaining_s()
