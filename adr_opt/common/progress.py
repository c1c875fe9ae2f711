"""Progress reports of a running method."""

from __future__ import annotations

from typing import Protocol


class Progress(Protocol):
    """Callback for each new incumbent or bound; −inf and +inf mean none yet."""

    def __call__(self, incumbent: float, bound: float) -> None:
        """Receive a report, in the thread that found it."""
        ...


def silent(incumbent: float, bound: float) -> None:
    """A progress callback that does nothing."""
