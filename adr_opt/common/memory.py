"""Memory that this process may still allocate."""

from __future__ import annotations

import math
import os
from pathlib import Path


def available_bytes() -> float:
    """Memory available for new arrays [bytes].

    On the machine, in its control groups, and in the limit of this process;
    +inf where the system does not say.
    """
    return min(_of_the_machine(), _of_the_group(), _of_the_process())


def _of_the_process() -> float:
    """Address space left to this process, as ``ulimit -v`` limits it; +inf without a limit."""
    try:
        import resource

        most, _ = resource.getrlimit(resource.RLIMIT_AS)
        pages = int(Path("/proc/self/statm").read_text().split()[0])
    except (ImportError, OSError):  # not Linux
        return math.inf
    unlimited = most == resource.RLIM_INFINITY
    return math.inf if unlimited else max(0.0, float(most - pages * resource.getpagesize()))


def _of_the_machine() -> float:
    """Memory available without swapping; all of the machine's memory if that is unknown."""
    try:
        for line in Path("/proc/meminfo").read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return 1024.0 * float(line.split()[1])
    except OSError:
        pass  # not Linux
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, ValueError, OSError):
        return math.inf


def _of_the_group(
    groups: Path = Path("/sys/fs/cgroup"), membership: Path = Path("/proc/self/cgroup")
) -> float:
    """Memory left by this process's control groups, as in a container; +inf without a limit."""
    try:
        lines = membership.read_text().splitlines()
    except OSError:
        return math.inf
    least = math.inf
    for line in lines:
        _, controllers, path = line.split(":", 2)
        if controllers == "":
            root, names = groups, ("memory.max", "memory.current")
        elif "memory" in controllers.split(","):
            root = groups / "memory"
            names = ("memory.limit_in_bytes", "memory.usage_in_bytes")
        else:
            continue
        # In a container the own group may be mounted at the root, and its path is not there.
        for folder in (Path(path), *Path(path).parents):
            least = min(least, _left_in(root / folder.relative_to("/"), *names))
    return least


def _left_in(folder: Path, limit: str, usage: str) -> float:
    """Memory left in one control group: its limit minus its usage, file cache excluded."""
    try:
        most = float((folder / limit).read_text())
        used = float((folder / usage).read_text())
        facts = dict(line.split() for line in (folder / "memory.stat").read_text().splitlines())
        return max(0.0, most - used + float(facts.get("inactive_file", 0.0)))
    except (OSError, ValueError):
        return math.inf  # no such group, or "max"
