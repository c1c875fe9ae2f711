"""Impulses as a chaser makes them: simultaneous burns are one vector.

A plan lists its burns by phase, as its price counts them: the transfer ends by stopping at the
stand-off, and the approach begins by leaving it, at the same time (docs/model.md section 2.2).
Whatever flies, lists or exports burns takes them from here.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Protocol, Self, TypeVar

SAME_INSTANT_S = 1e-6
"""Largest interval between burns that count as simultaneous [s]."""


class Burning(Protocol):
    """A burn with a time [s] and a vector [m/s]."""

    @property
    def time_s(self) -> float:
        """Time of the burn [s]."""
        ...

    @property
    def delta_v_m_s(self) -> tuple[float, float, float]:
        """Vector of the burn [m/s]."""
        ...

    def replace(self, **changes: Any) -> Self:
        """A copy with some fields changed."""
        ...


B = TypeVar("B", bound=Burning)


def impulses_of(burns: Iterable[B]) -> tuple[B, ...]:
    """Burns in time order, simultaneous ones as one vector with the phase that it begins."""
    found: list[B] = []
    for burn in burns:
        if found and burn.time_s - found[-1].time_s <= SAME_INSTANT_S:
            parts = zip(found.pop().delta_v_m_s, burn.delta_v_m_s, strict=True)
            burn = burn.replace(delta_v_m_s=tuple(sum(part) for part in parts))
        found.append(burn)
    return tuple(found)
