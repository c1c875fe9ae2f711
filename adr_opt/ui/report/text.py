"""Numbers and names as the page shows them."""

from __future__ import annotations

import html
import json
from typing import Any

from ...common.constants import DAY_S

NOTHING = "—"

LONG_S = 2.0 * DAY_S
"""Length beyond which spans are given in days."""


def escape(text: object) -> str:
    """Text as HTML, in content and in quoted attributes."""
    return html.escape(str(text), quote=True)


def in_chart(name: str) -> str:
    """A name for plotly.js, which interprets tags and entities in all text."""
    return html.escape(name, quote=False)


def in_script(content: Any) -> str:
    """Data as JSON in which no HTML parser sees the end of its script."""
    text = json.dumps(content, allow_nan=False, ensure_ascii=True, separators=(",", ":"))
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text


def number(value: float, digits: int = 1) -> str:
    """A number with thin spaces between thousands, and without trailing zeros."""
    text = f"{value:,.{digits}f}".replace(",", "\u202f").replace("-", "−")
    return text.rstrip("0").rstrip(".") if "." in text else text


def fixed(value: float, digits: int) -> str:
    """A number with all its decimals, for columns."""
    rounded = round(value, digits) + 0.0  # no negative zero
    return f"{rounded:.{digits}f}".replace("-", "−")


def length(metres: float) -> str:
    """A small distance in millimetres or metres, rounded to its significance."""
    return "a millimetre" if metres < 1e-3 else f"{metres:.2g}\u202fm"


def in_days(duration_s: float) -> str:
    """A duration in days, with the word."""
    text = number(duration_s / DAY_S, 2)
    return f"{text} day{'' if text == '1' else 's'}"


def clock(time_s: float) -> str:
    """A time since the epoch as day, hours and minutes; the first day is day 0."""
    minutes = round(time_s / 60.0)
    return f"{minutes // 1440}\u202fd {minutes // 60 % 24:02d}:{minutes % 60:02d}"


def lasting(duration_s: float) -> str:
    """A duration with its unit: hours and minutes, or days if long."""
    if abs(duration_s) < LONG_S:
        return f"{span(duration_s)}\u202fh"
    return f"{fixed(duration_s / DAY_S, 1)}\u202fd"


def span(duration_s: float) -> str:
    """A duration as hours and minutes."""
    minutes = round(abs(duration_s) / 60.0)
    return f"{'−' if duration_s < 0.0 else ''}{minutes // 60}:{minutes % 60:02d}"
