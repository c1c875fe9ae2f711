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
    ROOT / "adr_opt/kernels" / name
    for name in ("timetable.py", "timetable_making.py", "timetables.py")
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
    """Everybody asks the functions of `kernels.timetable`; its arrays are its own."""
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


def imported(source: str) -> Iterator[str]:
    """Packages that a module imports; those of its own package by one dot and their name."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            names = [node.module] if node.module else [alias.name for alias in node.names]
            yield from ("." * node.level + name.split(".")[0] for name in names)


def test_kernels_import_numbers_and_each_other_only() -> None:
    """NumPy, Numba, the llvmlite that it stands on, the standard library, and other kernels."""
    folder = ROOT / "adr_opt/kernels"
    own = {f".{path.stem}" for path in folder.glob("*.py")}
    known = own | {"numpy", "numba", "llvmlite"} | sys.stdlib_module_names
    for path in folder.glob("*.py"):
        assert set(imported(path.read_text())) <= known, path.name
    strangers = "import adr_opt.legs.service_limits\nfrom ..schedule import x\nfrom . import limits"
    assert set(imported(strangers)) == {"adr_opt", "..schedule", ".limits"}
    assert not known & {"adr_opt", "..schedule", ".limits"}
