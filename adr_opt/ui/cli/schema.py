"""``schema``: print the JSON Schema of a file format."""

from __future__ import annotations

from importlib import import_module

import click

from . import param
from .output import emit_json

SCHEMAS = {
    "instance": "problem.instance:Instance",
    "plan": "plan.plan:Plan",
    "refined": "plan.refined_plan:RefinedPlan",
    "certificate": "plan.certificate:Certificate",
    "uncertainty": "problem.uncertainty:Uncertainty",
    "target-errors": "sources.uncertainty.table:TargetErrorsFile",
    "elements": "sources.ephemerides.elements_file",
    "functions": "problem.given_functions:FunctionsFile",
    "worth": "sources.worth.worth_file:WorthFile",
    "library": "sources.library:Library",
    "project": "ui.serve.project.record:ProjectRecord",
    "project-result": "ui.serve.project.record:ResultRecord",
}
"""Modules of the formats, and their records; one without a record has a function of its own."""


@click.command("schema", short_help="Print the JSON Schema of a file format.")
@click.argument("which", metavar="FORMAT", type=click.Choice(list(SCHEMAS)))
@param.as_json
def command(which: str, as_json: bool) -> int:
    """Print the JSON Schema of a file of FORMAT.

    FORMAT is instance, plan, refined, certificate, uncertainty, target-errors, elements,
    functions, worth, library, project or project-result.
    """
    module, _, record = SCHEMAS[which].partition(":")
    owner = import_module(f"...{module}", __package__)
    emit_json((getattr(owner, record) if record else owner).json_schema())
    return 0
