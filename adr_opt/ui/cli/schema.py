"""``schema``: print the JSON Schema of a file format."""

from __future__ import annotations

from importlib import import_module

import click

from . import take
from .output import emit_json

SCHEMAS = {
    "instance": "problem.instance",
    "plan": "plan.plan",
    "refined": "plan.refined_plan",
    "certificate": "plan.certificate",
    "uncertainty": "problem.uncertainty",
    "target-errors": "sources.uncertainty.table",
    "elements": "sources.ephemerides.elements_file",
    "functions": "problem.function_files",
    "worth": "sources.worth.worth_file",
    "library": "sources.library",
    "project": "ui.serve.project.record",
    "project-result": "ui.serve.project.result_record",
}
"""Modules of the formats, each with a function ``json_schema``."""


@click.command("schema")
@click.argument("which", type=click.Choice(list(SCHEMAS)))
@take.as_json
def command(which: str, as_json: bool) -> int:
    """Print the JSON Schema of a file: instance, plan, refined plan, certificate and others."""
    emit_json(import_module(f"...{SCHEMAS[which]}", __package__).json_schema())
    return 0
