"""Experiments are run seldom: what they take from the packages is there, and is what they mean."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SCRIPTS = sorted((ROOT / "bench").rglob("*.py"))


@cache
def names_in(module: str) -> set[str] | None:
    """Names that a module of the packages binds, with its submodules; None if there is none."""
    place = ROOT.joinpath(*module.split("."))
    file = place.with_suffix(".py")
    is_room = not file.exists()  # a folder of that name may be left of an earlier version
    file = place / "__init__.py" if is_room else file
    if not file.exists():
        return None
    found = {each.stem for each in file.parent.iterdir()} if is_room else set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.Import | ast.ImportFrom):
            found |= {(each.asname or each.name).split(".")[0] for each in node.names}
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found.add(node.id)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            found |= set(node.value.split()) if "__getattr__" in found else {node.value}
    return found


def faults(script: Path) -> list[str]:
    """Names that are not there, and imports that a definition of the same script hides."""
    tree = ast.parse(script.read_text(encoding="utf-8"))
    modules: dict[str, str] = {}
    imported, found = set[str](), list[str]()
    for node in ast.walk(tree):
        if not isinstance(node, ast.ImportFrom) or not node.module or node.level:
            continue
        imported |= {each.asname or each.name for each in node.names}
        if node.module.split(".")[0] not in ("adr_opt", "solvers"):
            continue
        known = names_in(node.module)
        for each in node.names:
            if known is None or each.name not in known:
                found.append(f"{node.module} has no {each.name}")
            if names_in(f"{node.module}.{each.name}") is not None:
                modules[each.asname or each.name] = f"{node.module}.{each.name}"
    made = {each.name for each in tree.body if isinstance(each, ast.FunctionDef)}
    found += [f"{name} hides an import" for name in sorted(made & imported)]
    own = {each.arg for each in ast.walk(tree) if isinstance(each, ast.arg)}
    own |= {
        each.id
        for each in ast.walk(tree)
        if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)
    }
    functions = made - imported - own
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            if node.value.id in functions:
                found.append(f"{node.value.id} is a function, without {node.attr}")
            module = modules.get(node.value.id)
            if module is not None and node.attr not in (names_in(module) or ()):
                found.append(f"{module} has no {node.attr}")
    return found


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda each: str(each.relative_to(ROOT)))
def test_what_an_experiment_takes_from_the_packages_is_there(script: Path) -> None:
    """Nothing that it imports is missing or hidden, at whatever table it is needed."""
    assert faults(script) == []


def test_faults_are_found(tmp_path: Path) -> None:
    """A name that is gone, one that is hidden and an attribute that is not there are each told."""
    script = tmp_path / "script.py"
    script.write_text(
        "from adr_opt.kernels.legs import low_thrust\n"
        "from adr_opt.kernels.legs.low_thrust import gone\n"
        "def low_thrust(): pass\n"
        "low_thrust.absent()\n"
        "def own(): pass\n"
        "own.absent()\n"
    )
    assert faults(script) == [
        "adr_opt.kernels.legs.low_thrust has no gone",
        "low_thrust hides an import",
        "adr_opt.kernels.legs.low_thrust has no absent",
        "own is a function, without absent",
    ]
