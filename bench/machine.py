"""Machine and command of a measurement, printed above every table."""

from __future__ import annotations

import platform
import sys
from datetime import UTC, datetime

from adr_opt.common.processors import usable_cores
from adr_opt.mission.result import versions


def processor() -> str:
    """Name of the processor, as far as the system tells."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            for line in lines:
                if line.startswith("model name"):
                    return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def heading() -> str:
    """Command, date, machine and versions in two lines of Markdown."""
    used = ", ".join(f"{name} {number}" for name, number in versions().items())
    return (
        f"`python {' '.join(sys.argv)}`, {datetime.now(UTC):%Y-%m-%d}  \n"
        f"{processor()}, {usable_cores()} cores, Python {platform.python_version()}, {used}\n"
    )
