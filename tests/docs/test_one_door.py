"""What the code does in one place only, because doing it elsewhere went wrong."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

PRODUCT = ("adr_opt", "solvers")

APART = {"adr_opt/ui/cli/warm_up.py", "bench/tables.py", "bench/wheel.py"}
"""Modules that start processes for something else than rows."""

DOORS = {
    # keys that stand twice are refused there; records of OMM are decoded one by one, with a check
    # that knows their spellings
    "json.load": (PRODUCT, set()),
    "json.loads": (PRODUCT, {"adr_opt/common/json_text.py"}),
    "JSONDecoder": (PRODUCT, {"adr_opt/sources/catalogue/omm_formats.py"}),
    "validate_json": (PRODUCT, {"adr_opt/common/json_text.py"}),
    "model_validate_json": (PRODUCT, {"adr_opt/common/json_text.py"}),
    "parse_raw": (PRODUCT, set()),
    "from_json.pydantic_core": (PRODUCT, set()),
    # not on every system
    "sched_getaffinity": ((*PRODUCT, "bench"), {"adr_opt/common/processors.py"}),
    "cpu_count": ((*PRODUCT, "bench"), {"adr_opt/common/processors.py"}),
    # rows are made by studies: a process that dies, a Ctrl-C and a stop are seen to there alone.
    # 'warm-up' tells what a process compiles, and so has one for each method.
    # So have figures of bench/tables.py that a used process would spoil, and kernels of a wheel.
    "ProcessPoolExecutor": ((*PRODUCT, "bench"), APART),
    "get_context": ((*PRODUCT, "bench"), {"adr_opt/study/processes.py", *APART}),
    "Process": (PRODUCT, {"adr_opt/study/processes.py"}),
    "Pool": (PRODUCT, set()),
    "Client": ((*PRODUCT, "bench"), {"adr_opt/study/cluster.py"}),
    "get_reusable_executor": ((*PRODUCT, "bench"), set()),
    # what a plan lists by phase is fired as impulses, those of one instant as one
    "leg.burns": (("adr_opt/export", "adr_opt/ui", "adr_opt/analysis", "solvers", "bench"), set()),
    # without the settings that all runs need
    "CpSolver": ((*PRODUCT, "bench"), {"solvers/models/cp_sat.py"}),
}
"""Names that only some modules may call, by the folders that are searched."""


def called(source: str) -> Iterator[tuple[int, str]]:
    """Calls and imports by name, with the name before the dot and without, and their lines."""
    if not any(all(part in source for part in name.split(".")) for name in DOORS):
        return  # without parsing
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Attribute):
            yield node.lineno, node.attr
            yield node.lineno, f"{getattr(node.value, 'id', '')}.{node.attr}"
        elif isinstance(node, ast.ImportFrom):
            for alias in node.names:
                yield node.lineno, alias.name
                yield node.lineno, f"{node.module}.{alias.name}"
                yield node.lineno, f"{alias.name}.{node.module}"


@cache
def calls_of(folder: str) -> dict[str, dict[str, list[int]]]:
    """Lines of each called name, by module of a folder; read once for all names."""
    found: dict[str, dict[str, list[int]]] = {}
    for path in sorted((ROOT / folder).rglob("*.py")):
        lines = found.setdefault(str(path.relative_to(ROOT)), {})
        for line, name in called(path.read_text(encoding="utf-8")):
            if name in DOORS:
                lines.setdefault(name, []).append(line)
    return found


@pytest.mark.parametrize("name", DOORS)
def test_it_is_called_in_its_own_place_alone(name: str) -> None:
    """No other module calls it; annotations are no calls, and its own place still has it."""
    folders, allowed = DOORS[name]
    found = {
        module: line
        for folder in folders
        for module, names in calls_of(folder).items()
        for line in names.get(name, ())
        if not _annotates(ROOT / module, line, name)
    }
    assert found.keys() == allowed, found


def _annotates(path: Path, line: int, name: str) -> bool:
    """Whether a line has the name without a call, as the type of a value."""
    text = path.read_text(encoding="utf-8").splitlines()[line - 1]
    return name == "CpSolver" and "CpSolver(" not in text
