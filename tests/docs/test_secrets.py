"""What rooms keep to themselves: timetables, the columns of a body, and what kernels stand on."""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from adr_opt.kernels.orbits import columns
from adr_opt.kernels.tables.timetable import Table

ROOT = Path(__file__).parents[2]
OWNERS = [
    ROOT / "adr_opt/kernels/tables" / name
    for name in ("timetable.py", "timetable_making.py", "stacked_timetables.py")
]
"""Modules that know how a timetable is stored."""

HOLDERS = ("table", "tables", "column", "columns", "home")
"""Usual names of tables and columns."""

OWN = set(Table._fields)


def touched(source: str) -> Iterator[str]:
    """Every look at an array of a table, and at a spacing of anything."""
    if not any(f"{name}." in source for name in HOLDERS) and ".spacing" not in source:
        return  # without parsing
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Attribute) and node.attr in OWN:
            holder = node.value
            name = getattr(holder, "attr", None) or getattr(holder, "id", None)
            if name in HOLDERS or node.attr == "spacing":
                yield f"line {node.lineno}: {ast.unparse(node)}"


def sources() -> list[Path]:
    """All modules but those that may."""
    paths = [
        path
        for room in ("adr_opt", "solvers", "bench", "docs", "examples")
        for path in sorted((ROOT / room).rglob("*.py"))
    ]
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


def module_of(node: ast.ImportFrom, package: str) -> str:
    """The whole name of the module that a statement in a package imports from."""
    parts = package.split(".")
    above = parts[: len(parts) + 1 - node.level] if node.level else []
    return ".".join([*above, *([node.module] if node.module else [])])


EPHEMERIS = ROOT / "adr_opt/kernels/orbits"
"""The room that knows how a row holds the orbit of a body."""

ELEMENTS = {name for name in vars(columns) if name.isupper()} - {"ORBIT_COLUMNS"}
"""The names of the columns."""

NAMED = re.compile(rf"\b(?:{'|'.join(ELEMENTS)})\b|orbits\(|orbits\b.*\bcolumns\b", re.DOTALL)


def columns_named(source: str, package: str) -> Iterator[str]:
    """Every use of a column of a body by its name, or by its number in the rows of an instance."""
    rooms = {"ephemeris", "columns"}
    if not NAMED.search(source):
        return  # without parsing
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            module = module_of(node, package)
            if module.startswith("adr_opt.kernels.orbits"):
                names = {alias.name for alias in node.names}
                rooms |= {alias.asname or alias.name for alias in node.names}
                if module.endswith(".columns") or names & {*ELEMENTS, "columns"}:
                    yield f"line {node.lineno}: {ast.unparse(node)}"
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and node.attr in ELEMENTS:
            holder = getattr(node.value, "attr", None) or getattr(node.value, "id", None)
            if holder in rooms:
                yield f"line {node.lineno}: {ast.unparse(node)}"
        elif isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Tuple):
            made = node.value.func if isinstance(node.value, ast.Call) else None
            if isinstance(made, ast.Attribute) and made.attr == "orbits":
                yield f"line {node.lineno}: {ast.unparse(node)}"


def test_only_the_ephemeris_knows_the_columns_of_a_body() -> None:
    """Elements and rates come from accessors with a time; outside their room no column is named."""
    found = [
        f"{path.relative_to(ROOT)}, {where}"
        for room in ("adr_opt", "solvers")
        for path in sorted((ROOT / room).rglob("*.py"))
        if path.parent != EPHEMERIS
        for where in columns_named(path.read_text(), ".".join(path.parent.relative_to(ROOT).parts))
    ]
    assert found == []


@pytest.mark.parametrize(
    "line",
    [
        "from ..orbits.columns import RADIUS",
        "from ..orbits import columns",
        "from ..orbits.ephemeris import node_at, RAAN_RATE",
        "import adr_opt\nadr_opt.kernels.orbits.columns.RAAN",
        "rate = orbit[ephemeris.RAAN_RATE]",
        "from ..orbits import ephemeris as bodies\nrate = rows[:, bodies.LATITUDE_RATE]",
        "lowest = instance.orbits()[:, 0].min()",
    ],
)
def test_a_named_column_is_seen(line: str) -> None:
    """The search above finds columns under every name that a module may give them."""
    assert len(list(columns_named(line, "adr_opt.kernels.legs"))) == 1


def imported(source: str, package: str) -> Iterator[str]:
    """Modules that one in a package imports, by their whole names."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield module_of(node, package)


def may_be_imported(module: str) -> bool:
    """NumPy, Numba, llvmlite, the standard library, constants, the clock, errors, kernels."""
    known = {"numpy", "numba", "llvmlite"} | sys.stdlib_module_names
    common = {f"adr_opt.common.{name}" for name in ("constants", "clock", "errors")}
    own = module in common or module.startswith("adr_opt.kernels.")
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
        False,
        False,
        True,
    ]
