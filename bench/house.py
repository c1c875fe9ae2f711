"""Structure of the code: circles, storeys, loose modules, names, arguments, and its budgets.

    python bench/house.py
    python bench/house.py --list
    python bench/house.py --rooms

Imports inside functions and those for types only are counted. A room is a folder of ``adr_opt`` or
``solvers``, or a module that lies loose in one of them; the order of rooms is that of the import
contract ``Rooms stand on each other in one order`` in ``pyproject.toml``. ``--list`` names what is
counted; ``--rooms`` draws the rooms from the top storey down, with their modules and code lines.
Code lines are lines with code on them: no blank lines, comments and docstrings.
"""

from __future__ import annotations

import argparse
import ast
import io
import re
import tokenize
import tomllib
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import grimp
import networkx

ROOT = Path(__file__).parents[1]
PACKAGES = ("adr_opt", "solvers")
ROOMS_CONTRACT = "Rooms stand on each other in one order"

MOST_ARGUMENTS = 8
"""Functions with more are counted."""

TOW = re.compile(r"(?:^|_)tow(?:s|ed|ing|er)?(?:_|$)|Tow")

VISITS = re.compile(r"visits.between.refuel")
"""The rule of visits between refuellings, by its field or its word."""

Imports = Mapping[str, set[str]]


def modules() -> dict[str, ast.Module]:
    """The syntax trees of all modules of the product, by dotted name."""
    found = {}
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
            found[name] = ast.parse(path.read_text(encoding="utf-8"))
    return found


def imports() -> dict[str, set[str]]:
    """The modules that each module imports."""
    graph = grimp.build_graph(*PACKAGES)
    return {
        module: set(graph.find_modules_directly_imported_by(module)) for module in graph.modules
    }


def room_of(module: str) -> str:
    """The room that a module lies in: a folder, or the module itself if it is loose."""
    return ".".join(module.split(".")[:2])


def by_room(edges: Imports) -> dict[str, set[str]]:
    """The rooms that each room opens onto, without the packages themselves."""
    found: dict[str, set[str]] = defaultdict(set)
    for module, imported in edges.items():
        room = room_of(module)
        if room not in PACKAGES:
            found[room] |= {room_of(other) for other in imported} - {room, *PACKAGES}
    return found


def circles(edges: Imports) -> list[list[str]]:
    """Sets of nodes each of which leads to all others."""
    graph = networkx.DiGraph([(one, other) for one in edges for other in edges[one]])
    found = [sorted(part) for part in networkx.strongly_connected_components(graph)]
    return sorted(part for part in found if len(part) > 1)


def storeys(edges: Imports) -> int:
    """Length of the longest chain of imports, a circle counted as one."""
    graph = networkx.DiGraph([(one, other) for one in edges for other in edges[one]])
    return 1 + networkx.dag_longest_path_length(networkx.condensation(graph))


def storey_of_rooms() -> dict[str, int]:
    """The storeys of rooms as the import contract has them; empty if there is none."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    for contract in settings["tool"]["importlinter"]["contracts"]:
        if contract["name"] == ROOMS_CONTRACT:
            layers = reversed(contract["layers"])
            return {
                room.strip(): storey
                for storey, layer in enumerate(layers, 1)
                for room in re.split(r"[|:]", layer)
            }
    return {}


def upwards(edges: Imports) -> list[str] | None:
    """Imports of a room by one that is not above it; None if no order of rooms is stated."""
    order = storey_of_rooms()
    if not order:
        return None
    found = []
    for module in sorted(edges):
        for other in sorted(edges[module]):
            here, there = room_of(module), room_of(other)
            if here != there and here in order and there in order and order[here] <= order[there]:
                found.append(f"{module} -> {other}")
    return found


def loose(names: Iterable[str]) -> list[str]:
    """Modules that lie in ``adr_opt`` itself."""
    folders = {name.rsplit(".", 1)[0] for name in names}
    return [
        name
        for name in names
        if name.count(".") == 1 and name.startswith("adr_opt.") and name not in folders
    ]


def identifiers(tree: ast.AST) -> Iterator[str]:
    """The names in a tree: of variables, attributes, arguments, functions, classes and keywords."""
    for node in ast.walk(tree):
        for field in ("id", "attr", "arg", "name"):
            value = getattr(node, field, None)
            if isinstance(value, str):
                yield value


def knows_visits(tree: ast.AST) -> bool:
    """Whether a module knows of the rule of visits between refuellings, or of its limit."""
    for node in ast.walk(tree):
        name = node.arg if isinstance(node, ast.keyword) else getattr(node, "attr", None)
        words = [name, getattr(node, "id", None), getattr(node, "value", None)]
        if name == "between" or any(
            isinstance(each, str) and VISITS.search(each) for each in words
        ):
            return True
    return False


def is_window_rule(node: ast.AST) -> bool:
    """Whether an expression is the later of a time and the opening of a window."""
    if not isinstance(node, ast.Call) or len(node.args) != 2:
        return False
    function = node.func.attr if isinstance(node.func, ast.Attribute) else node.func
    function = function.id if isinstance(function, ast.Name) else function
    return function in ("max", "maximum") and any(
        "opens" in name for argument in node.args for name in identifiers(argument)
    )


def functions(tree: ast.AST) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    """All functions and methods."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node


def arguments(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Number of arguments, ``self`` and ``cls`` not counted."""
    stated = function.args
    names = [each.arg for each in (*stated.posonlyargs, *stated.args, *stated.kwonlyargs)]
    return len([name for name in names if name not in ("self", "cls")])


def shared_names(trees: Mapping[str, ast.Module]) -> list[str]:
    """Names that more than one public class has."""
    times = Counter(
        node.name
        for tree in trees.values()
        for node in tree.body
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
    )
    return sorted(name for name in times if times[name] > 1)


def only_importers(edges: Imports) -> list[str]:
    """Modules that a single module imports, one of the same room."""
    importers: dict[str, list[str]] = defaultdict(list)
    for module in edges:
        for other in edges[module]:
            importers[other].append(module)
    folders = {name.rsplit(".", 1)[0] for name in edges}
    return sorted(
        f"{module} <- {by[0]}"
        for module, by in importers.items()
        if len(by) == 1 and room_of(module) == room_of(by[0]) and module not in folders
    )


def files(*folders: str, ending: str = "py") -> Iterator[str]:
    """The texts of all files of some folders."""
    for folder in folders:
        for path in sorted((ROOT / folder).rglob(f"*.{ending}")):
            yield path.read_text(encoding="utf-8")


def docstrings(tree: ast.AST) -> Iterator[tuple[ast.AST, ast.Expr]]:
    """What has a docstring (a module, class, function, or the name above a text), and that."""
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        for before, statement in (
            zip((node, *body), body, strict=False) if isinstance(body, list) else ()
        ):
            if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant):
                if isinstance(statement.value.value, str):
                    yield before, statement


def code_lines(text: str) -> int:
    """Lines with code on them."""
    layout = {
        tokenize.COMMENT,
        tokenize.NL,
        tokenize.NEWLINE,
        tokenize.INDENT,
        tokenize.DEDENT,
        tokenize.ENDMARKER,
    }
    found: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in layout:
            found |= set(range(token.start[0], token.end[0] + 1))
    for _, docstring in docstrings(ast.parse(text)):
        found -= set(range(docstring.lineno, (docstring.end_lineno or 0) + 1))
    return len(found)


def lines_of_docstrings(trees: Mapping[str, ast.Module]) -> float:
    """Mean number of docstring lines of a public class or function, one without counted as 0."""
    public = 0
    total = 0
    for tree in trees.values():
        kinds = ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
        public += sum(
            isinstance(node, kinds) and not node.name.startswith("_") for node in ast.walk(tree)
        )
        total += sum(
            (docstring.end_lineno or 0) - docstring.lineno + 1
            for owner, docstring in docstrings(tree)
            if isinstance(owner, kinds)
            and not owner.name.startswith("_")
            and docstring is owner.body[0]
        )
    return total / public


def picture(trees: Iterable[str]) -> Iterator[str]:
    """The rooms from the top storey down, each with its modules and its code lines."""
    order = storey_of_rooms()
    rooms = Counter(map(room_of, trees))
    for storey in sorted(set(order.values()), reverse=True):
        here = []
        for room in sorted(name for name in order if order[name] == storey):
            folder = room.replace(".", "/")
            if (ROOT / folder).is_dir():
                weight = sum(map(code_lines, files(folder)))
                here.append(f"{folder} {rooms[room]} / {weight:,}")
        yield f"{storey:2}  " + "    ".join(here)


def budgets(trees: Mapping[str, ast.Module]) -> Iterator[tuple[str, str]]:
    """What the code weighs: names and figures."""
    yield "code lines of adr_opt and solvers", str(sum(map(code_lines, files(*PACKAGES))))
    for folders in (PACKAGES, ("bench",), ("tests",)):
        total = sum(len(text.splitlines()) for text in files(*folders))
        yield f"lines of {' and '.join(folders)}", str(total)
    kinds = ("py", "js", "css", "html")
    total = sum(len(text.splitlines()) for end in kinds for text in files("adr_opt/ui", ending=end))
    yield "lines of adr_opt/ui with scripts and styles", str(total)
    yield "words in docs/", str(sum(len(text.split()) for text in files("docs", ending="md")))
    yield "docstring lines of a public name", f"{lines_of_docstrings(trees):.2f}"


def show(what: str, found: list[str] | None, is_listed: bool) -> None:
    """Print how many there are, and which."""
    print(f"{what:58} {'-' if found is None else len(found):>7}")
    if is_listed:
        for each in found or ():
            print(f"    {each}")


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--list", action="store_true", help="name what is counted")
    parser.add_argument("--rooms", action="store_true", help="draw the rooms: modules / code lines")
    wanted = parser.parse_args()
    is_listed, trees = wanted.list, modules()
    if wanted.rooms:
        print(*picture(trees), sep="\n")
        return
    edges = imports()
    rooms = by_room(edges)
    show("modules", sorted(trees), False)
    show("rooms", sorted(rooms), is_listed)
    show("loose modules in adr_opt", loose(sorted(trees)), is_listed)
    show("circles of modules", [" ".join(each) for each in circles(edges)], is_listed)
    show("circles of rooms", [" ".join(each) for each in circles(rooms)], is_listed)
    show("imports upwards", upwards(edges), is_listed)
    print(f"{'storeys of modules':58} {storeys(edges):7}")
    print(f"{'storeys of rooms':58} {storeys(rooms):7}")
    windows = [name for name, tree in trees.items() if any(map(is_window_rule, ast.walk(tree)))]
    show("modules with the rule of windows", windows, is_listed)
    tows = [name for name, tree in trees.items() if any(map(TOW.search, identifiers(tree)))]
    show("modules with identifiers of tows", tows, is_listed)
    every = [(name, each) for name, tree in trees.items() for each in functions(tree)]
    long = [
        f"{name}.{each.name} {arguments(each)}"
        for name, each in every
        if arguments(each) > MOST_ARGUMENTS
    ]
    show("functions with more than 8 arguments", long, is_listed)
    print(f"{'  as a share of all':58} {len(long) / len(every):7.2%}")
    show("names of public classes that stand more than once", shared_names(trees), is_listed)
    show("modules with one importer, in the same room", only_importers(edges), is_listed)
    for what, figure in budgets(trees):
        print(f"{what:58} {figure:>7}")


if __name__ == "__main__":
    main()
