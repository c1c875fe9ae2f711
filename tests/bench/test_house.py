"""How the code is built: rooms in one order, no circles, and names that stand once."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

pytest.importorskip("grimp")
import house

MOST_MODULES_OF_A_RULE = 10

MOST_STOREYS, MOST_ROOM_STOREYS = 36, 12  # the server stands on the judges


@pytest.fixture(scope="module")
def modules() -> dict[str, ast.Module]:
    """Modules of the product, parsed."""
    found: dict[str, ast.Module] = house.modules()
    return found


def test_imports_lead_downwards() -> None:
    """Imports, those inside functions and for types as well, form no circle and never go up."""
    edges = house.imports()
    assert house.circles(edges) == []
    assert house.upwards(edges) == []
    assert set(house.by_room(edges)) - {"adr_opt.__main__"} == set(house.storey_of_rooms())
    assert house.storeys(edges) <= MOST_STOREYS
    assert house.storeys(house.by_room(edges)) <= MOST_ROOM_STOREYS


def test_a_rule_stands_in_few_modules_and_all_are_named(modules: dict[str, ast.Module]) -> None:
    """The walk of a rule in CONTRIBUTING names each module that knows of it, ten at most."""
    known = {
        name.replace(".", "/") + ".py" for name, tree in modules.items() if house.knows_visits(tree)
    } - {"adr_opt/problem/format_2.py"}  # the fields of a format that gets no more
    text = (Path(__file__).parents[2] / "CONTRIBUTING.md").read_text(encoding="utf-8")
    table = text.partition("## Adding a rule")[2].partition("| what |")[2].partition("\n\n")[0]
    assert known == set(re.findall(r"`((?:adr_opt|solvers)/[^`]+)`", table))
    assert len(known) <= MOST_MODULES_OF_A_RULE


def test_names_of_public_classes_stand_once(modules: dict[str, ast.Module]) -> None:
    """No two public classes of the product have one name."""
    assert house.shared_names(modules) == []


def test_what_is_forbidden_is_found() -> None:
    """A circle of two, and an import upwards, are counted."""
    loop = {"adr_opt.plan.a": {"adr_opt.plan.b"}, "adr_opt.plan.b": {"adr_opt.plan.a"}}
    assert house.circles(loop) == [["adr_opt.plan.a", "adr_opt.plan.b"]]
    assert house.upwards({"adr_opt.plan.a": {"adr_opt.ui.b"}, "adr_opt.ui.b": set()}) == [
        "adr_opt.plan.a -> adr_opt.ui.b"
    ]


def test_the_formatter_decides() -> None:
    """No line is kept from the formatter, and lines of code are told from all others."""
    folders = ("adr_opt", "solvers", "bench", "examples", "tests")
    assert not [text for text in house.files(*folders) if "fmt:" + " " in text]
    source = '"""Title."""\n\nA = 1  # one\n"""Named."""\n# why\nB = (\n    2,\n\n)\n'
    assert house.code_lines(source) == 4
