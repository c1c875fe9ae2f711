"""``methods``: list the planners and bounds that are installed."""

from __future__ import annotations

import inspect
import math
from typing import Any

import click

from ..errors import InputError
from .output import emit, emit_json
from .parameters import json_option


@click.command("methods", short_help="List planners and bounds with their options.")
@json_option
def command(as_json: bool) -> int:
    """List the installed planners and bounds with their options and defaults."""
    from ..planner import BOUNDS, PLANNERS, names

    found = {
        "planners": [_describe(name, PLANNERS) for name in names(PLANNERS)],
        "bounds": [_describe(name, BOUNDS) for name in names(BOUNDS)],
    }
    if as_json:
        emit_json(found)
        return 0
    lines = []
    for heading, methods in found.items():
        lines.append(f"{heading}:" if methods else f"{heading}: none installed")
        for method in methods:
            mark = " (default)" if method["default"] else ""
            lines.append(f"  {method['name']}{mark}")
            lines.append(f"      {method['summary']}")
            if method["takes_start"]:
                lines.append("      takes --start")
            for option in method["options"]:
                lines.append(f"      --option {option['name']}={_as_text(option['default'])}")
    emit("\n".join(lines))
    return 0


def _describe(name: str, group: str) -> dict[str, Any]:
    from .. import front
    from ..planner import PLANNERS, options

    entry: dict[str, Any] = {
        "name": name,
        "summary": "",
        "default": group == PLANNERS and name == front.DEFAULT_METHOD,
        "takes_start": False,
        "options": [],
    }
    try:
        method = front.method_of(name, group)
    except InputError as error:  # declared and broken: it is listed, and says why
        return entry | {"summary": str(error)}
    paragraph = (inspect.getdoc(method) or "").partition("\n\n")[0]
    return entry | {
        "summary": " ".join(paragraph.split()),
        "takes_start": front.takes_start(method),
        "options": [
            {
                "name": option,
                "type": type(parameter.default).__name__,
                "default": _shown(parameter.default),
            }
            for option, parameter in options(method).items()
        ],
    }


def _shown(default: Any) -> Any:
    """A default as JSON can say it: infinities as the text that ``--option`` takes."""
    if isinstance(default, float) and not math.isfinite(default):
        return str(default)
    return default if isinstance(default, (bool, int, float, str, type(None))) else str(default)


def _as_text(default: Any) -> str:
    return str(default).lower() if isinstance(default, bool) else str(default)
