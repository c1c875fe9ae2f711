"""What all plots share: units and labels."""

from __future__ import annotations

from datetime import UTC
from typing import Any

from ...problem.instance import Instance

KM_M = 1000.0


def since(instance: Instance) -> str:
    """The label of a time axis in days."""
    return f"days since {instance.epoch.astimezone(UTC):%Y-%m-%d %H:%M} UTC"


def plain(name: str) -> str:
    """A name for matplotlib: `$` would begin mathematics."""
    return name.replace("$", r"\$")


def label(ax: Any, x: str, y: str) -> None:
    """Label the axes of ``ax`` unless somebody has."""
    if not ax.get_xlabel():
        ax.set_xlabel(x)
    if not ax.get_ylabel():
        ax.set_ylabel(y)
