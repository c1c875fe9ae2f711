"""What an hour is worth to a beam."""

from __future__ import annotations

TIME_VALUE_M_S_PER_H = 110.0
"""What an hour is worth where beams, and windows, choose one connection for each move; where planes
drift it is less by as much as time is cheaper there."""
