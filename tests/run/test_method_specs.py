"""Specifications of methods: read without importing them, and true."""

import inspect
import subprocess
import sys
from dataclasses import fields

import pytest

from adr_opt.run.methods import BOUNDS, PLANNERS, get, names, options_of, spec

METHODS = [(group, name) for group in (PLANNERS, BOUNDS) for name in names(group)]


def test_reading_specifications_imports_no_planner() -> None:
    """What all methods can do is known before numba, OR-Tools, torch or a planner is imported."""
    code = (
        "import sys; from adr_opt.run import methods as m;"
        "[m.spec(n, g) for g in (m.PLANNERS, m.BOUNDS) for n in m.names(g)];"
        "heavy = {'numba', 'ortools', 'torch', 'solvers.planners', 'solvers.bounds'};"
        "sys.exit(','.join(sorted(heavy & set(sys.modules))) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(("group", "name"), METHODS)
def test_specifications_say_what_methods_take(group: str, name: str) -> None:
    """Start plans, cores, chasers and options that need a table are as the method has them."""
    known, method = spec(name, group), get(name, group)
    parameters = inspect.signature(method).parameters
    options = {each.name for each in fields(options_of(method))}
    assert known.name == name
    assert known.starts == ("start" in parameters)
    assert known.uses_cores == ("jobs" in options)
    assert known.several == (next(iter(parameters)) == "problem")
    assert set(known.table_options) <= options
    assert set(known.practice.options) <= options
