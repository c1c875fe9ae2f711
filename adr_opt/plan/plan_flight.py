"""A plan file's record of its own flight: the cost of its legs, and the rest of each tank.

It speaks of the legs that were flown. Their digest stands beside it, so that a plan whose legs were
changed afterwards does not go for a flown one.
"""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from ..common.records import Count, DeltaV, Name, Omitting, Record
from .leg_kinds import OneOf, flown_kind_names, leg_kind

TOW = "tow"


def _families() -> tuple[str, ...]:
    return (*flown_kind_names(), TOW)


class FamilyFlight(Record):
    """Planned and flown cost of the legs of a family; null if unknown."""

    family: Annotated[str, OneOf(_families)]
    legs: Count
    planned_delta_v_m_s: DeltaV
    flown_delta_v_m_s: DeltaV | None

    def __str__(self) -> str:
        noun = TOW if self.family == TOW else leg_kind(self.family).noun
        flown = "unknown" if self.flown_delta_v_m_s is None else f"{self.flown_delta_v_m_s:.1f}"
        return (
            f"{self.legs} {noun}{'' if self.legs == 1 else 's'} planned with "
            f"{self.planned_delta_v_m_s:.1f} and flown with {flown} m/s"
        )


class TankLeft(Omitting):
    """ΔV left in one tank, negative if it did not suffice; null if unknown."""

    chaser: Name | None = None
    tank: Annotated[int, Field(ge=1)]
    left_m_s: DeltaV | None

    OMITTED: ClassVar = ("chaser",)


class PlanFlight(Record):
    """How a plan was flown when it was made, with the outcome.

    ``how`` is ``mean``: its burns in the mean motion of the instance, aimed at targets on their
    true orbits, or ``refined``: burns of their own in integrated motion. ``legs_sha256`` is that of
    the routes of the plan.
    """

    how: Literal["mean", "refined"]
    gravity: Literal["two-body", "j2", "j3", "j4"]
    legs_sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    holds: bool
    families: Annotated[tuple[FamilyFlight, ...], Field(strict=False)]
    tanks: Annotated[tuple[TankLeft, ...], Field(strict=False)]

    def to_dict(self) -> dict[str, Any]:
        """The record as plain data."""
        return self.model_dump(mode="json")

    def __str__(self) -> str:
        where = {"two-body": "two-body motion", "j2": "mean motion under J2"}.get(self.gravity)
        how = f"flown in {where}" if self.how == "mean" else f"refined in the field {self.gravity}"
        families = ", ".join(map(str, self.families)) or "no legs"
        return f"{how}: {families}; {left_in(self.tanks)}"


def left_in(tanks: tuple[TankLeft, ...]) -> str:
    """ΔV left in each tank, by chaser, in words."""
    if not tanks:
        return "no tank is used"
    chasers = dict.fromkeys(tank.chaser for tank in tanks)
    parts = []
    for chaser in chasers:
        left = [tank.left_m_s for tank in tanks if tank.chaser == chaser]
        told = ", ".join("unknown" if each is None else f"{each:.1f}" for each in left)
        parts.append(told if chaser is None else f"{chaser} {told}")
    return f"left in {'the tank' if len(tanks) == 1 else 'each tank'}: {'; '.join(parts)} m/s"
