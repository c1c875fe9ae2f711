"""Notes on values that look like slips of units, alike for ``solve``, ``check`` and ``import``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from .output import say

if TYPE_CHECKING:
    from ...problem.instance import Instance


def say_doubts(
    instance: Instance, *, quiet: bool = False, reword: Callable[[str], str] = str
) -> None:
    """Say on standard error which values look like slips, reworded for who gave them."""
    from ...problem.plausible import doubts

    for doubt in doubts(instance):
        say(f"note: {reword(str(doubt))}", unless=quiet)
