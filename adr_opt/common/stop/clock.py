"""Stop when another criterion has no time left."""

from __future__ import annotations

from .criterion import Stop


class Clock:
    """The time of another criterion, which is not asked: for a part that is no iteration."""

    def __init__(self, stop: Stop) -> None:
        self._stop = stop

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether it is enough."""
        return self.remaining_s() <= 0.0

    def remaining_s(self) -> float:
        """Seconds that may still be used."""
        return self._stop.remaining_s()
