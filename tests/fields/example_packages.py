"""Packages of others, put where an installer would put them."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any


def put(project: dict[str, Any], folder: Path) -> None:
    """Write the metadata and the entry points of a project, as its pyproject.toml states them."""
    metadata = folder / f"{project['name'].replace('-', '_')}-{project['version']}.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n"
    )
    lines = []
    for group, entries in project["entry-points"].items():
        lines += [f"[{group}]", *(f"{name} = {home}" for name, home in entries.items())]
    (metadata / "entry_points.txt").write_text("\n".join(lines) + "\n")


def project_of(example: Path) -> dict[str, Any]:
    """The table ``project`` of the pyproject.toml of an example."""
    project: dict[str, Any] = tomllib.loads((example / "pyproject.toml").read_text())["project"]
    return project
