"""The epoch of an instance: a calendar time with a time zone, in UTC in files."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Annotated, Any

from pydantic import AfterValidator, AwareDatetime, BeforeValidator, Field, PlainSerializer


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
