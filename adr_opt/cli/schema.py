"""``schema``: print the JSON Schema of a file format."""

from __future__ import annotations

import click

from .output import emit_json
from .parameters import json_option


@click.command("schema")
@click.argument("which", type=click.Choice(["instance", "plan"]))
@json_option
def command(which: str, as_json: bool) -> int:
    """Print the JSON Schema of the instance file or of the plan file."""
    if which == "instance":
        from ..instance import json_schema
    else:
        from ..plan import json_schema
    emit_json(json_schema())
    return 0
