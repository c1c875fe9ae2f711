"""Machine and versions of a row's measurement."""

from __future__ import annotations

import platform
import socket
from functools import cache
from typing import Any

from machine import processor

from adr_opt.common.processors import usable_cores
from adr_opt.mission.result import versions


@cache
def _here() -> tuple[tuple[str, Any], ...]:
    listed = "; ".join(f"{name} {number}" for name, number in versions().items())
    return (
        ("host", socket.gethostname()),
        ("processor", processor()),
        ("cores", usable_cores()),
        ("python", platform.python_version()),
        ("versions", listed),
    )


def environment() -> dict[str, Any]:
    """Host, processor, number of cores, Python and packages of this process."""
    return dict(_here())
