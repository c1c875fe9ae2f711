"""A proof concurrent with a search, on its own certificate, synchronised between rounds."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

from adr_opt.common.stop import Stop

from ..progress.gap import GapTracker

LEAST_PROOF_S, LEAST_SET_UPS = 1.0, 2.0
"""Least remaining time, absolute and as a multiple of the set-up time, at which a proof begins."""


class Rounds(Protocol):
    """A proof that proceeds round by round."""

    done: bool

    def begin(self) -> None:
        """Quick initial work."""

    def advance(self, enough: Callable[[], bool]) -> None:
        """One round."""

    @property
    def counters(self) -> dict[str, float]:
        """Work counters."""

    def close(self) -> None:
        """End the threads."""


AnyProof = TypeVar("AnyProof", bound=Rounds)


class ConcurrentProof(Generic[AnyProof]):
    """The proving half of a planner.

    Parameters
    ----------
    shared, own : GapTracker
        That of the planner, and that of the proof.
    stop : Stop
        Its time alone counts here.
    made : callable
        Gives the proof; None where there is no time for it.

    Attributes
    ----------
    proof : Rounds or None
        None before the first round.
    """

    def __init__(
        self, shared: GapTracker, own: GapTracker, stop: Stop, made: Callable[[], AnyProof | None]
    ) -> None:
        self._shared, self._own, self._stop, self._made = shared, own, stop, made
        self.proof: AnyProof | None = None

    @property
    def done(self) -> bool:
        """Whether the proof cannot progress further."""
        return self.proof is not None and self.proof.done

    def advance(self) -> None:
        """One round; the first one only begins the proof."""
        if self.proof is None:
            self.proof = self._made()
            if self.proof is not None:
                self.proof.begin()
            return
        self.proof.advance(lambda: self._stop.remaining_s() <= 0.0)

    def fetch(self) -> None:
        """Receive the incumbent, before a round."""
        if self._shared.routes is not None:
            self._own.offer(*self._shared.routes)

    def deliver(self) -> None:
        """Deliver the results of the round."""
        if self._own.routes is not None:
            self._shared.offer(*self._own.routes)
        self._shared.lower(self._own.bound, self._own.evidence)

    @property
    def counters(self) -> dict[str, float]:
        """Work counters."""
        return {} if self.proof is None else self.proof.counters

    def close(self) -> None:
        """End the threads."""
        if self.proof is not None:
            self.proof.close()
