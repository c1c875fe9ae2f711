"""Renew docs/options.md from the options that the methods declare: python docs/list_options.py."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

from adr_opt.common.options import listed
from adr_opt.run.methods import BOUNDS, PLANNERS, get, options_of

DOCS = Path(__file__).parent

HEAD = """\
# Options of the methods

Options are set by `solve --option NAME=VALUE` and `bound --option NAME=VALUE`, or by keyword
arguments of `adr_opt.solve` and `adr_opt.bound`. `python -m adr_opt methods NAME` prints those of
one method. `docs/list_options.py` makes this page from the declarations.
"""


def page() -> str:
    """The page, with a table for each method of this project."""
    project = tomllib.loads((DOCS.parent / "pyproject.toml").read_text(encoding="utf-8"))
    declared = project["project"]["entry-points"]
    parts = [HEAD]
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
    (DOCS / "options.md").write_text(page(), encoding="utf-8")
