"""The pages on files list what the schemas have."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest
from conftest import Cli
from pages import read, tables

from adr_opt.kernels.legs.burns import PHASES
from adr_opt.learning.policy import FORMAT as POLICY
from adr_opt.learning.policy import load_policy
from adr_opt.plan import certificate, plan, refined_thrust
from adr_opt.plan import refined_plan as refined
from adr_opt.problem import bodies, chasers, instance, orbit, settings, uncertainty
from adr_opt.sources.library import Library
from adr_opt.ui.serve.project import record


def described(caption: str) -> dict[str, str]:
    """The fields of the table of docs/files.md under a caption, each with its stated default."""
    found = [rows for before, rows in tables(read("docs/files.md")) if caption in before]
    assert len(found) == 1, caption
    head, _, *rows = found[0]
    fields = {}
    for row in rows:
        names = re.findall(r"`([a-z_0-9]+)`", row[0])
        default = row[head.index("default")] if "default" in head else ""
        values = default.split(", ") if default.count(", ") == len(names) - 1 else [default]
        for number, name in enumerate(names):
            fields[name] = values[number % len(values)]
    return fields


@pytest.mark.parametrize(
    ("caption", "model"),
    [
        ("Fields with a default may be left out", instance.Instance),
        ("**Orbit**", orbit.Orbit),
        ("**`targets[]`**", bodies.Target),
        ("**`chasers[]`**", chasers.Chaser),
        ("**`mission`**", settings.MissionSettings),
        ("**`transfer`**", settings.TransferSettings),
        ("**`objective`**", settings.Objective),
        ("**`keep_out_zones[]`**", settings.KeepOutZone),
        ("Defined in `adr_opt/plan/plan.py`", plan.Plan),
        ("**`legs[]`**", plan.Leg),
        ("**`burns[]`**", plan.Burn),
        ("**`manoeuvres[]`**", plan.LowThrustArc),
        ("Defined in `adr_opt/plan/refined_plan.py`", refined.RefinedPlan),
        ("**A refined leg**", refined.RefinedLeg),
        ("**`thrust`**", refined_thrust.RefinedThrust),
        ("**`arcs[]`**", refined_thrust.SteeredArc),
        ("is packed by gzip", certificate.Certificate),
        ("**`walks[]`**", certificate.ProvenWalks),
        ("Defined in `adr_opt/problem/uncertainty.py`", uncertainty.Uncertainty),
        ("Defined in `adr_opt/ui/serve/project/record.py`", record.ProjectRecord),
        ("says how to get the files", Library),
    ],
)
def test_the_tables_of_the_formats_are_the_schemas(caption: str, model: Any) -> None:
    """docs/files.md lists the fields of every part in the order of its schema, with defaults."""
    schema = model.model_json_schema()
    stated = described(caption)
    assert list(stated) == list(schema["properties"])
    for name, default in stated.items():
        known = schema["properties"][name].get("default")
        if isinstance(known, bool):
            assert default == json.dumps(known), name
        elif isinstance(known, int | float):
            assert float(default or known) == known, name
            # Tables of what programs write have no column of defaults.
            assert default or caption in ("**`legs[]`**", "Defined in `adr_opt/plan/plan.py`"), name
        elif name in schema.get("required", ()):
            assert default == "", name


def test_small_parts_of_the_formats_are_described() -> None:
    """The parts without a table of their own are written out, field by field."""
    text = read("docs/files.md")
    for model in (
        chasers.Tank,
        chasers.Expense,
        settings.GivenFile,
        plan.InstanceReference,
        plan.Route,
        plan.Unvisited,
        refined.PlanReference,
        refined.BodyState,
        refined.Missing,
        refined.RefinedBurn,
        refined.RefinedState,
        uncertainty.LognormalFactor,
        uncertainty.Delay,
        record.StepRecord,
        record.DroppedFile,
    ):
        assert f"{{{', '.join(model.model_json_schema()['properties'])}}}" in text


def test_the_schemas_that_are_printed_are_those_of_the_tables(cli: Cli) -> None:
    """`schema` prints the schemas that the tables are held against."""
    for which, model in (
        ("instance", instance.Instance),
        ("plan", plan.Plan),
        ("refined", refined.RefinedPlan),
        ("certificate", certificate.Certificate),
        ("uncertainty", uncertainty.Uncertainty),
        ("project", record.ProjectRecord),
    ):
        printed = json.loads(cli("schema", which).out)
        assert printed["properties"].keys() == model.model_json_schema()["properties"].keys()
        assert printed["$defs"].keys() == model.model_json_schema()["$defs"].keys()


def test_the_card_of_a_policy_is_described() -> None:
    """docs/files.md lists exactly what the card of the policy of the package has."""
    known = {"format", "fields", *load_policy().card}
    assert known == set(described("`card` is JSON as bytes"))


def test_phases_and_reasons_are_described() -> None:
    """The pages on the model and the files name every phase of a burn and every reason."""
    for page in ("docs/model.md", "docs/files.md"):
        for word in (*PHASES, *plan.Reason.__args__):
            assert f"`{word}`" in read(page)


def test_formats_are_in_the_changelog_and_on_their_page() -> None:
    """Every file format with a number is named where readers look for it."""
    formats = (instance.FORMAT, plan.FORMAT, certificate.FORMAT, "adr-opt-library/1", POLICY)
    for page in ("CHANGELOG.md", "docs/files.md"):
        for name in formats:
            assert f"`{name}`" in read(page)
