"""What rooms keep to themselves: how a timetable is kept, and what kernels stand on."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from adr_opt.kernels.tables.stacked_timetables import PackedColumn
from adr_opt.kernels.tables.timetable import Table

ROOT = Path(__file__).parents[2]
OWNERS = [
    ROOT / "adr_opt/kernels/tables" / name
    for name in ("timetable.py", "timetable_making.py", "stacked_timetables.py")
]
"""Who knows how a timetable is kept."""

HOLDERS = ("table", "tables", "column", "columns", "home")
"""What tables and columns are called, whoever holds them."""

OWN = {*Table._fields, *PackedColumn._fields}


def touched(source: str) -> Iterator[str]:
    """Every look at an array of a table, and at a spacing of anything."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Attribute) and node.attr in OWN:
            holder = node.value
            name = getattr(holder, "attr", None) or getattr(holder, "id", None)
            if name in HOLDERS or node.attr == "spacing":
                yield f"line {node.lineno}: {ast.unparse(node)}"


def sources() -> list[Path]:
    """All modules but those that may."""
    paths = [path for room in ("adr_opt", "solvers", "bench", "docs", "examples")
             for path in sorted((ROOT / room).rglob("*.py"))]  # fmt: skip
    return [path for path in paths if path not in OWNERS]


def test_nobody_else_knows_how_a_timetable_is_kept() -> None:
    """Everybody asks the functions of `kernels.tables.timetable`; its arrays are its own."""
    found = [
        f"{path.relative_to(ROOT)}, {where}"
        for path in sources()
        for where in touched(path.read_text())
    ]
    assert found == []


@pytest.mark.parametrize(
    "line",
    [
        "first = rules.table.first[i, j]",
        "wait = pool.tables.spacing[slot, i]",
        "count = mission.timetable.table.entries.shape[1]",
        "total = outlook.home.total[j]",
        "gap = t.spacing[i]",
    ],
)
def test_a_look_inside_is_seen(line: str) -> None:
    """The search above finds what it looks for."""
    assert len(list(touched(line))) == 1


def test_the_modules_themselves_are_full_of_it() -> None:
    """In the modules that know, all of the arrays are used under these names."""
    used = {where.rsplit(".", 1)[1] for owner in OWNERS for where in touched(owner.read_text())}
    assert used == OWN


def imported(source: str, package: str) -> Iterator[str]:
    """Modules that one in a package imports, by their whole names."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            parts = package.split(".")
            above = parts[: len(parts) + 1 - node.level] if node.level else []
            yield ".".join([*above, *([node.module] if node.module else [])])


def may_be_imported(module: str) -> bool:
    """NumPy, Numba, the llvmlite that it stands on, the standard library, constants, kernels."""
    known = {"numpy", "numba", "llvmlite"} | sys.stdlib_module_names
    own = module == "adr_opt.common.constants" or module.startswith("adr_opt.kernels.")
    return own or module.split(".")[0] in known


def test_kernels_import_numbers_and_each_other_only() -> None:
    """Kernels stand on numbers, on the compiler and on each other."""
    folder = ROOT / "adr_opt/kernels"
    for path in folder.rglob("*.py"):
        package = ".".join(path.parent.relative_to(ROOT).parts)
        for module in imported(path.read_text(), package):
            assert may_be_imported(module), (path.name, module)
    strangers = "import adr_opt.legs.service_limits\nfrom ...plan import x\nfrom ..rules import y"
    assert [may_be_imported(each) for each in imported(strangers, "adr_opt.kernels.legs")] == [
        False, False, True,
    ]  # fmt: skip
