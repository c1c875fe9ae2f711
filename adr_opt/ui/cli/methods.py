"""``methods``: list the installed planners and bounds."""

from __future__ import annotations

import inspect
from textwrap import wrap
from typing import Any

import click

from ...common.errors import InputError
from . import complete, param
from .output import emit, emit_json


@click.command("methods", short_help="List planners and bounds with their options.")
@click.argument("name", required=False, shell_complete=complete.methods)
@param.as_json
def command(name: str | None, as_json: bool) -> int:
    """List the installed planners and bounds with their options and defaults.

    With NAME, explain that method alone: the meaning and allowed values of each option.
    """
    from ...run.methods import BOUNDS, PLANNERS, names

    known = dict.fromkeys((*names(PLANNERS), *names(BOUNDS)))
    if name is not None and name not in known:
        raise InputError(f"method {name!r} is unknown; use one of: {', '.join(known)}")
    found = {
        heading: [_describe(each, group) for each in names(group) if name in (None, each)]
        for heading, group in (("planners", PLANNERS), ("bounds", BOUNDS))
    }
    if as_json:
        emit_json(found)
        return 0
    lines = []
    for heading, methods in found.items():
        if methods or name is None:
            lines.append(f"{heading}:" if methods else f"{heading}: none installed")
        for method in methods:
            mark = " (default)" if method["default"] else ""
            lines.append(f"  {method['name']}{mark}")
            lines.append(f"      {method['summary']}")
            if method["takes_start"]:
                lines.append("      takes --start")
            for option in method["options"]:
                lines.append(f"      --option {option['name']}={_as_text(option['default'])}")
                if name is not None:
                    lines += _explained(option)
    emit("\n".join(lines))
    return 0


def _explained(option: dict[str, Any]) -> list[str]:
    """Allowed values and meaning of an option, as lines."""
    unit = f"[{option['unit']}]" if option["unit"] else ""
    allowed = f"{option['allowed']} {unit}"
    return [
        line
        for text in (option["meaning"], allowed)
        for line in wrap(text, 100, initial_indent=10 * " ", subsequent_indent=10 * " ")
    ]


def _describe(name: str, group: str) -> dict[str, Any]:
    from ...common.options import listed
    from ...run import front
    from ...run.methods import PLANNERS, options_of

    entry: dict[str, Any] = {
        "name": name,
        "summary": "",
        "default": name == (front.DEFAULT_METHOD if group == PLANNERS else front.DEFAULT_BOUND),
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
        "takes_start": front.spec_of(name, group).starts,
        "options": listed(options_of(method)),
    }


def _as_text(default: Any) -> str:
    return str(default).lower() if isinstance(default, bool) else str(default)
