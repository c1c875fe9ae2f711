"""What a method reports while it runs."""

from __future__ import annotations

from typing import Protocol


class Progress(Protocol):
    """Hears of every new incumbent or bound: −inf and +inf stand for none yet."""

    def __call__(self, incumbent: float, bound: float) -> None:
        """Hear of it; called from the thread that found it."""
        ...


def silent(incumbent: float, bound: float) -> None:
    """A progress that hears and says nothing."""
