"""``doctor``: report the installation on this machine and its problems."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import TYPE_CHECKING

import click

from ...common.wording import counted
from . import param
from .output import emit, emit_json

if TYPE_CHECKING:
    from ...run.installation import Installation

INTERNAL = {"bench", "dev", "docs", "peers", "readers", "test"}
"""Extras for the development of adr-opt itself."""


@click.command("doctor", short_help="Examine the installation and report problems.")
@param.as_json
def command(as_json: bool) -> int:
    """Examine the installation and report its problems.

    Versions, cores, free memory, where compiled kernels are kept, extras, and whether every planner
    and bound can be loaded. Each problem is one sentence that says what to do. Exit status 1: there
    are problems.
    """
    from ...run.installation import examine

    found = examine()
    if as_json:
        emit_json(asdict(found))
    else:
        emit("\n".join(_lines(found)))
    return 1 if found.problems else 0


def _lines(found: Installation) -> list[str]:
    """The facts, then the problems."""
    versions = [f"{name} {number or '(missing)'}" for name, number in found.versions.items()]
    memory = "" if math.isinf(found.memory_bytes) else f", {found.memory_bytes / 2.0**30:.1f} GiB"
    extras = {name: gone for name, gone in found.extras.items() if name not in INTERNAL}
    rows = {
        "adr-opt": f"{found.versions['adr-opt']} in {found.place}",
        "Python": f"{found.python}, {found.system}",
        "packages": ", ".join(versions[1:]),
        "machine": f"{counted(found.cores, 'core')}{memory}{' of memory free' if memory else ''}",
        "kernels": _kernels(found),
        "archive": found.archive,
        "extras": ", ".join(name for name, gone in extras.items() if not gone) or "none",
    }
    missing = [f"{name} ({', '.join(gone)})" for name, gone in extras.items() if gone]
    if missing:
        rows["not there"] = f"{', '.join(missing)}; pip install 'adr-opt[NAME]' adds one"
    rows["planners"] = ", ".join(found.planners) or "none"
    rows["bounds"] = ", ".join(found.bounds) or "none"
    lines = [f"{name + ':':<11}{text}" for name, text in rows.items()]
    return [*lines, *(f"problem: {each}" for each in found.problems or ())] + (
        [] if found.problems else ["all is well"]
    )


def _kernels(found: Installation) -> str:
    if found.cache is None:
        return "not examined"
    if not found.cache.folder:
        return "cached nowhere"
    kernels = counted(found.cache.kernels, "kernel")
    return f"{kernels}, {found.cache.size_bytes / 1e6:.1f} MB, in {found.cache.folder}"
