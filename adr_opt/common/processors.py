"""Processor cores that this process may use."""

from __future__ import annotations

import os


def usable_cores() -> int:
    """Number of cores that this process may use, at least 1.

    Those that it is bound to, where the system tells them (neither macOS nor Windows does), or all
    of the machine.
    """
    try:
        return len(os.sched_getaffinity(0))
    except (AttributeError, OSError):
        return os.cpu_count() or 1
