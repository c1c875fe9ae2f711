"""The epoch of an instance, a calendar time, and the inertial frame of its elements, if stated."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Annotated, Any, ClassVar, Literal, Self, get_args

from pydantic import (
    AfterValidator,
    AwareDatetime,
    BeforeValidator,
    Field,
    PlainSerializer,
    model_validator,
)

from ..common.records import Omitting


def _is_calendar_time(value: Any) -> Any:
    """Refuse values that pydantic would read as seconds since 1970."""
    if isinstance(value, datetime) or (isinstance(value, str) and value[4:5] == "-"):
        return value
    raise ValueError("must be a time like 2026-01-01T00:00:00Z")


def _has_utc(epoch: datetime) -> datetime:
    """Refuse times outside the calendar in UTC."""
    try:
        epoch.astimezone(UTC)
    except OverflowError:
        raise ValueError("must lie in the years 1 to 9999 in UTC") from None
    return epoch


def _in_utc(epoch: datetime) -> str:
    return epoch.astimezone(UTC).isoformat().replace("+00:00", "Z")


Epoch = Annotated[
    AwareDatetime,
    Field(strict=False),
    BeforeValidator(_is_calendar_time),
    AfterValidator(_has_utc),
    PlainSerializer(_in_utc, return_type=str),
]


FrameName = Literal["EME2000", "GCRF", "ICRF", "TEME"]

FRAMES: tuple[FrameName, ...] = get_args(FrameName)
"""Inertial frames about the Earth by name, as in CCSDS messages."""

OF_DATE = ("TEME",)
"""Frames whose axes follow the equator and equinox of date, and so need a date."""


class Frame(Omitting):
    """A frame with fixed axes.

    Those of TEME (true equator, mean equinox) are of ``axes_epoch``: of another date they are
    others, 34 m in low orbit after a week. Axes of the other frames are of no date, and their files
    say none.
    """

    name: FrameName
    axes_epoch: Epoch | None = None

    OMITTED: ClassVar = ("axes_epoch",)

    @model_validator(mode="after")
    def _says_when(self) -> Self:
        if self.name in OF_DATE and self.axes_epoch is None:
            raise ValueError(
                f'axes_epoch is missing: the axes of "{self.name}" move, so give the time they '
                "refer to"
            )
        if self.name not in OF_DATE and self.axes_epoch is not None:
            raise ValueError(f'axes_epoch: the axes of "{self.name}" are fixed; leave it out')
        return self

    def __str__(self) -> str:
        if self.axes_epoch is None:
            return self.name
        return f"{self.name} of {self.axes_epoch.astimezone(UTC):%Y-%m-%dT%H:%M:%SZ}"
