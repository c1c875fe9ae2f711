"""Null means that nothing is stated, and what is worked out of a copy is its own."""

from __future__ import annotations

import ast
import pickle
import typing
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from pydantic import BaseModel
from toy_roads import order_of_all

import adr_opt
import solvers
from adr_opt.mission.problem import Problem
from adr_opt.problem.instance_file import InstanceFile

NULL_IS_ZERO = {"decay_m_per_day", "end_of_life_m_s"}
"""Fields that mean the same by null and by 0."""

CHECKED_BEFORE = {"mass_kg", "disposal"}
"""Fields that stand in every instance with tows, and are of no account without."""

SHOWN = {"thrust_n"}
"""Fields of which null and 0 are shown alike: 0 is no value."""


def records(kind: object, seen: set[type[BaseModel]]) -> set[type[BaseModel]]:
    """The records that a type consists of."""
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        if kind not in seen:
            seen.add(kind)
            for field in kind.model_fields.values():
                records(field.annotation, seen)
    for part in typing.get_args(kind):
        records(part, seen)
    return seen


def numbers_or_null() -> set[str]:
    """Names of all fields of instances that are a number or null."""
    return {
        name
        for record in records(InstanceFile, set())
        for name, field in record.model_fields.items()
        if type(None) in typing.get_args(field.annotation)
        and any(number in str(field.annotation) for number in ("int", "float"))
    }


def read_as_numbers() -> Iterator[tuple[Path, int, str]]:
    """Places where code takes another value for a field that is false, as 0 is."""
    for package in (adr_opt, solvers):
        for path in Path(package.__file__).parent.rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text("utf-8"))):
                if not isinstance(node, ast.BoolOp) or not isinstance(node.op, ast.Or):
                    continue
                for part, other in zip(node.values, node.values[1:], strict=False):
                    is_value = isinstance(other, ast.Constant | ast.Name | ast.Attribute)
                    if isinstance(part, ast.Attribute) and is_value:
                        yield path, node.lineno, part.attr


def test_null_is_not_read_as_a_number() -> None:
    """No code has `field or value` for a field in which 0 and null differ."""
    fields = numbers_or_null()
    assert {"launch_separation_s", "max_targets", "kits", "service_revolutions"} <= fields
    fields -= NULL_IS_ZERO | CHECKED_BEFORE | SHOWN
    found = [f"{path}:{line}: {name}" for path, line, name in read_as_numbers() if name in fields]
    assert found == []


@pytest.mark.parametrize(("most", "asks"), [(None, True), (3, True), (2, False), (0, False)])
def test_a_limit_of_no_targets_is_a_limit(most, asks) -> None:
    """A plan is an order of all targets unless the chaser may not service all, or none."""
    assert Problem(order_of_all(most)).asks_for_least_end is asks


def test_rows_of_orbits_are_those_of_the_copy() -> None:
    """A changed or unchecked copy has rows of its own orbits, and nobody changes those kept."""
    drawn = adr_opt.generate("tiny", 3, targets=5)
    rows = drawn.orbits()
    rows[:] = 0.0
    fresh = adr_opt.generate("tiny", 3, targets=5)
    assert np.array_equal(drawn.orbits(), fresh.orbits(), equal_nan=True)
    turned = drawn.targets[::-1]
    replaced, copied = drawn.replace(targets=turned), drawn.model_copy(update={"targets": turned})
    first = drawn.first_target
    for other in (replaced, copied):
        assert np.array_equal(other.orbits()[first:], fresh.orbits()[first:][::-1])
    assert np.array_equal(drawn.orbits(), fresh.orbits(), equal_nan=True)
    drifting = drawn.model_copy(update={"dynamics": "j2"})
    assert not np.array_equal(drifting.orbits(), fresh.orbits(), equal_nan=True)
    again = pickle.loads(pickle.dumps(drawn))
    assert again == drawn
    assert np.array_equal(again.orbits(), fresh.orbits(), equal_nan=True)
