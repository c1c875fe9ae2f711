"""The options that methods declare, for docs/options.md on the site; printed as a script."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

from adr_opt.common.options import listed
from adr_opt.run.methods import BOUNDS, PLANNERS, get, options_of

DOCS = Path(__file__).parent


def tables() -> str:
    """A table for each method of this project."""
    project = tomllib.loads((DOCS.parent / "pyproject.toml").read_text(encoding="utf-8"))
    declared = project["project"]["entry-points"]
    parts = []
    for group, more in ((PLANNERS, "Planners"), (BOUNDS, "Bounds only")):
        parts.append(f"\n## {more}\n")
        for name in sorted(declared[group]):
            if group == BOUNDS and name in declared[PLANNERS]:
                continue
            rows = listed(options_of(get(name, group)))
            parts.append(f"\n### `{name}`\n\n{table(rows) if rows else 'No options.'}\n")
    return "".join(parts)


def table(rows: list[dict[str, str]]) -> str:
    """The options of a method, one in a row."""
    lines = ["| option | default | values | meaning |", "|---|---|---|---|"]
    for row in rows:
        default = json.dumps(row["default"]).strip('"')
        shown = f"`{default}` {row['unit']}".strip() if default else "empty"
        lines.append(f"| `{row['name']}` | {shown} | {row['allowed']} | {row['meaning']} |")
    return "\n".join(lines)


if __name__ == "__main__":
    print(tables())
