"""Six kinds of missions, small enough to be planned at once."""

from __future__ import annotations

KINDS: dict[str, tuple[str, dict[str, int]]] = {
    "one chaser": ("tiny", {}),
    "nominal": ("nominal", {}),
    "campaign": ("campaign", {"targets": 12}),
    "electric": ("electric", {"targets": 6}),
    "drift": ("rocket-bodies", {"targets": 8}),
    "removal": ("removal", {"targets": 10}),
}
"""Kinds of missions: family and sizes."""

SEED = 8_640_001
