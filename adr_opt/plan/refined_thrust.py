"""Low thrust of a refined leg: where its arcs steer, and when they thrust."""

from __future__ import annotations

import math
from typing import Annotated, Self

from pydantic import Field, model_validator

from ..common.records import DeltaV, NonNegative, Positive, Record, Time

Window = Annotated[tuple[Time, Time], Field(strict=False)]
Part = Annotated[float, Field(ge=-1e9, le=1e9)]
Steering = tuple[Part, Part, Part, Part, Part]


class SteeredArc(Record):
    """An arc of low thrust: windows of thrust, and one law of steering for all of them.

    ``steering`` is A to E of docs/model.md section 11.6: at the argument of latitude u thrust has
    the direction (A sin u − B cos u, C + 2 (A cos u + B sin u), D cos u + E sin u), outward, ahead
    and along the momentum.
    """

    delta_v_m_s: DeltaV
    steering: Annotated[Steering, Field(strict=False)]
    windows_s: Annotated[tuple[Window, ...], Field(strict=False)]

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        times = [time for window in self.windows_s for time in window]
        if times != sorted(times):
            raise ValueError("field windows_s: not in time order; sort them")
        if times and not any(self.steering):
            raise ValueError("field steering: all five numbers are 0; one must not be")
        return self

    @property
    def on_s(self) -> float:
        """Time in which thrust is on [s]."""
        return math.fsum(end - start for start, end in self.windows_s)


class RefinedThrust(Record):
    """Thrust of a leg: the force while it is on, and the arcs.

    ``force_n`` is the mean over the duty cycle, ``exhaust_m_s`` g₀ Isp. ``mass_kg`` is the chaser
    at the beginning; ``propellant_kg`` what arcs and burns of the leg take.
    """

    force_n: Positive
    exhaust_m_s: Positive
    mass_kg: Positive
    propellant_kg: NonNegative
    arcs: Annotated[tuple[SteeredArc, ...], Field(strict=False, min_length=1)]

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        times = [time for arc in self.arcs for window in arc.windows_s for time in window]
        if times != sorted(times):
            raise ValueError("field arcs: not in time order; sort them")
        if self.propellant_kg >= self.mass_kg:
            raise ValueError("field propellant_kg: must be less than mass_kg")
        return self

    @property
    def delta_v_m_s(self) -> float:
        """ΔV of all arcs [m/s]."""
        return math.fsum(arc.delta_v_m_s for arc in self.arcs)

    @property
    def windows_s(self) -> tuple[tuple[float, float], ...]:
        """Beginning and end of each window of thrust."""
        return tuple(window for arc in self.arcs for window in arc.windows_s)
