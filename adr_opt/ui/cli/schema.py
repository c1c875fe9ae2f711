"""``schema``: print the JSON Schema of a file format."""

from __future__ import annotations

import click

from . import take
from .output import emit_json

FORMATS = ["instance", "plan", "refined", "certificate", "uncertainty"]


@click.command("schema")
@click.argument(
    "which",
    type=click.Choice(["instance", "plan", "refined", "certificate", "uncertainty", "project"]),
)
@take.as_json
def command(which: str, as_json: bool) -> int:
    """Print the JSON Schema of a file: instance, plan, refined plan, certificate and others."""
    if which == "instance":
        from ...problem.instance import json_schema
    elif which == "plan":
        from ...plan.plan import json_schema
    elif which == "certificate":
        from ...plan.certificate import json_schema
    elif which == "uncertainty":
        from ...problem.uncertainty import json_schema
    elif which == "project":
        from ..serve.project.record import json_schema
    else:
        from ...plan.refined_plan import json_schema
    emit_json(json_schema())
    return 0
