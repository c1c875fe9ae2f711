"""Public names: what is promised of them, and what a prompt offers of data."""

from __future__ import annotations

import re
import warnings
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from pages import read, tables
from pydantic import BaseModel

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.common.records import Record
from adr_opt.common.stability import PROVISIONAL, STABLE, stability
from adr_opt.plan.refined_plan import reference

DEPRECATED = {
    "construct",
    "copy",
    "dict",
    "from_orm",
    "json",
    "parse_file",
    "parse_obj",
    "parse_raw",
    "schema",
    "schema_json",
    "update_forward_refs",
    "validate",
}


def records(kind: type[Record] = Record) -> list[type[Record]]:
    """All classes of data that are imported."""
    return [kind, *(each for child in kind.__subclasses__() for each in records(child))]


def test_every_public_name_is_stable_and_every_other_module_provisional() -> None:
    """Each name of ``adr_opt`` is stable, and the page says the same as the code."""
    assert sorted(STABLE) == sorted(adr_opt.__all__)
    (rows,) = [rows for _, rows in tables(read("docs/api.md")) if rows[0][0] == "promise"]
    assert sorted(re.findall(r"`(\w+)`", rows[2][1])) == sorted(STABLE)
    (rest,) = [rows for _, rows in tables(read("docs/api.md")) if rows[0][0] == "module"]
    modules = [name for row in rest[2:] for name in re.findall(r"^`([\w.]+)`$", row[0])]
    assert sorted(set(modules)) == sorted(PROVISIONAL)
    assert all(import_module(name) for name in PROVISIONAL)
    assert stability("solve") == stability("adr-opt-plan/2") == "stable"
    assert stability("adr_opt.analysis") == stability("adr-opt-project/1") == "provisional"
    assert stability("front") is None


def test_data_list_their_own_names() -> None:
    """At a prompt no record and no class of records offers anything of pydantic's."""
    instance = adr_opt.generate("tiny", 0)
    machinery = set(dir(BaseModel)) - set(dir(object))
    assert machinery >= DEPRECATED
    public = {adr_opt.Instance, adr_opt.Plan, adr_opt.RefinedPlan, adr_opt.Certificate}
    classes = records()
    assert public < set(classes)
    for listed in (dir(instance), dir(instance.targets[0]), *map(dir, classes)):
        assert not machinery & set(listed)
    offered = {"load", "save", "replace", "to_json", "targets", "names", "__class__", "__eq__"}
    assert offered <= set(dir(instance))
    assert {"load", "save", "replace"} <= set(dir(adr_opt.Instance))


def test_looking_at_all_that_is_listed_warns_of_nothing() -> None:
    """Whatever a prompt offers of an instance can be looked at without a deprecation."""
    instance = adr_opt.generate("tiny", 0)
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)
        for name in dir(instance):
            if not name.startswith("__"):
                getattr(instance, name)


def test_what_is_saved_is_loaded_by_its_class(tmp_path: Path) -> None:
    """What is saved comes back equal, by its class and by the function of the package."""
    instance = adr_opt.generate("tiny", 0)
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    named: dict[str, Any] = {"name": instance.name, "sha256": instance.sha256}
    certificate = adr_opt.Certificate(
        instance=plan.instance, method="nothing", upper_bound=7.0, multipliers={}
    )
    refined = adr_opt.RefinedPlan(
        instance=named,
        plan=reference(plan),
        gravity="j2",
        freedom="free",
        status="complete",
        runtime_s=0.0,
    )
    for made, function in (
        (instance, adr_opt.load),
        (plan, adr_opt.load_plan),
        (refined, adr_opt.load_refined),
        (certificate, adr_opt.load_certificate),
    ):
        path = tmp_path / "file.json"
        made.save(path)
        assert type(made).load(path) == function(path) == made
        path.write_text("{}")
        with pytest.raises(InputError, match=r"file\.json"):
            type(made).load(path)
