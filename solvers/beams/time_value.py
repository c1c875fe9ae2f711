"""Value of an hour for beams."""

from __future__ import annotations

TIME_VALUE_M_S_PER_H = 110.0
"""Value of an hour where beams and windows choose one connection per move; less where planes drift,
as time is cheaper there."""
