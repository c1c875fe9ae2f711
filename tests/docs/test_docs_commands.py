"""Every command of the pages is one that there is, and those of the quick starts run."""

from __future__ import annotations

import ast
import re
import shlex
import tomllib
from functools import cache
from pathlib import Path

import click
import pytest
from conftest import Cli
from pages import PAGES, ROOT, commands, in_a_small_world, meant, read

from adr_opt.run import methods as planner
from adr_opt.ui.cli.entry import VERBS
from adr_opt.ui.cli.entry import command as verbs

ALL_COMMANDS = sorted({line for page in PAGES for line in commands(page.read_text("utf-8"))})
OURS = [line for line in ALL_COMMANDS if line.startswith("python -m adr_opt ")]
SCRIPTS = [line for line in ALL_COMMANDS if re.match(r"python [a-z_/-]+\.py", line)]
MAKE = [line for line in ALL_COMMANDS if re.fullmatch(r"make [a-z]+( [A-Z_]+=\S+)*", line)]


def test_commands_and_methods_named_in_the_pages_exist() -> None:
    """Every verb and every method that a page tells the reader to type is there."""
    example = tomllib.loads(read("examples/random-walks/pyproject.toml"))["project"]
    methods = {
        *planner.names(),
        *planner.names(planner.BOUNDS),
        *example["entry-points"][planner.PLANNERS],
    }
    verbs, used = set(), set()
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        verbs |= set(re.findall(r"python -m adr_opt ([a-z][a-z-]*)", text))
        used |= set(re.findall(r"(?:--method|--bound) ([a-z-]+)", text))
    assert {"generate", "solve", "check"} <= verbs
    assert verbs - set(VERBS) == set()
    # In place of a bound: none beside the planner (bench/best_known.py).
    assert used - methods - {"none"} == set()


@pytest.mark.parametrize("line", OURS)
def test_every_command_in_the_pages_parses(line: str) -> None:
    """Each command line of a page is one that the program takes: verb, arguments and options."""
    _, _, _, verb, *words = meant(line)
    if verb in ("--help", "--version"):
        return
    context = click.Context(verbs)
    command = verbs.get_command(context, verb)
    assert command is not None, verb
    if words and "--help" not in words:
        # A verb that stands for itself, as in "`python -m adr_opt train`", has no arguments.
        assert command.make_context(verb, words, parent=context).params


@cache
def syntax(file: Path) -> ast.Module:
    """The syntax tree of a file."""
    return ast.parse(file.read_text(encoding="utf-8"))


def tables(script: Path) -> dict[str, set[str]]:
    """The tables that a script of the bench prints, by name, with their options; none of others."""
    named = {
        each.id
        for call in ast.walk(syntax(script))
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Name)
        if call.func.id == "experiment"
        for each in call.args[1:]
        if isinstance(each, ast.Name)
    }
    files = [
        script.parent.joinpath(*node.module.split(".")).with_suffix(".py")
        for node in syntax(script).body
        if isinstance(node, ast.ImportFrom) and node.module is not None
    ]
    return {
        node.name.replace("_", "-"): {
            f"--{each.arg.replace('_', '-')}" for each in (*node.args.args, *node.args.kwonlyargs)
        }
        for file in (*files, script)
        if file.is_file()
        for node in syntax(file).body
        if isinstance(node, ast.FunctionDef) and node.name in named
    }


@pytest.mark.parametrize("line", SCRIPTS)
def test_every_script_in_the_pages_exists(line: str) -> None:
    """Each script that a page starts is there, and knows the table and options of the page."""
    _, path, *words = shlex.split(line)
    script = ROOT / path
    assert script.is_file()
    known = tables(script) if path.startswith("bench/") else {}
    options = {word for word in words if word.startswith("--")}
    if known:
        stated = known[words[0]] if len(known) > 1 else next(iter(known.values()))
        assert options <= stated
        return
    near = [script, *script.parent.glob("*/*.py")]
    source = "\n".join(file.read_text(encoding="utf-8") for file in near)
    assert all(f'"{option}"' in source for option in options)


@pytest.mark.parametrize("line", MAKE)
def test_every_target_of_make_in_the_pages_exists(line: str) -> None:
    """Each target that a page makes is in the Makefile, and so is each variable that it sets."""
    _, target, *settings = line.split()
    makefile = read("Makefile")
    assert re.search(rf"^{target}:.*## ", makefile, re.MULTILINE)
    for setting in settings:
        assert re.search(rf"^{setting.partition('=')[0]} \S*= ", makefile, re.MULTILINE)


def test_the_pages_have_commands() -> None:
    """The patterns above find what they look for."""
    assert {shlex.split(line)[3] for line in OURS} >= set(VERBS)
    assert len(SCRIPTS) > 10
    assert {line.split()[1] for line in MAKE} >= {"solve", "test", "docs"}


@pytest.mark.parametrize(
    "page", ["README.md", pytest.param("docs/index.md", marks=pytest.mark.slow)]
)
def test_the_commands_of_the_quick_start_run(cli: Cli, tmp_path: Path, page: str) -> None:
    """One after the other, the commands of a quick start do what they say, on small missions."""
    for package in ("boinor", "h5netcdf", "plotly", "sgp4"):
        pytest.importorskip(package)
    for folder in ("examples", "instances"):
        (tmp_path / folder).symlink_to(ROOT / folder)
    blocks = re.findall(r"(?m)^    python -m adr_opt (?!train).*$", read(page))
    assert len(blocks) >= 9
    for line in blocks:
        outcome = cli(*in_a_small_world(line.strip()))
        assert outcome.status == 0, (line, outcome.err)
    for name in ("my.json", "plan.json", "mission.oem", "mission.html"):
        assert (tmp_path / name).stat().st_size > 0


NEED_MORE = re.compile(r" (serve|train|benchmark) | --policy | instances/| --element-sets | --help")
"""Commands that run for ever or for long, or need what no command before them writes."""

OF_ONE_MISSION = (
    "certificates",
    "exports",
    "files",
    "flights-with-errors",
    "importing",
    "matrices",
    "plans-that-hold",
    "policy",
    "refining",
    "report",
    "scenarios",
    "true-orbits",
    "waiting",
    "worth",
)


@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=[pytest.mark.slow] * (page != "report")) for page in OF_ONE_MISSION],
)
def test_the_commands_of_a_page_run(cli: Cli, tmp_path: Path, page: str) -> None:
    """With an instance and a plan as the quick start leaves them, each command of a page does."""
    for package in ("boinor", "h5netcdf", "plotly", "pyarrow", "sgp4"):
        pytest.importorskip(package)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    for words in (
        ["generate", "tiny", "--seed", "1", "--out", "my.json"],
        ["solve", "my.json", "--time-limit", "1", "--out", "plan.json"],
        ["refine", "my.json", "plan.json", "--out", "refined.json"],
    ):
        assert cli(*words).status == 0
    text = re.sub(r"\\\n\s*", "", read(f"docs/{page}.md"))  # lines that go on
    for table in re.findall(r"(?s)```csv\n(.*?)```", text):
        Path("errors.csv").write_text(table, encoding="utf-8")
    ran = 0
    for line in re.findall(r"(?m)^    python -m adr_opt .*$", text):
        if not NEED_MORE.search(line):
            outcome = cli(*in_a_small_world(line.strip()))
            broken = " fly " in line and outcome.status == 1 and "is over by" in outcome.out
            assert outcome.status == 0 or broken, (line, outcome)
            ran += 1
    assert ran > 0
