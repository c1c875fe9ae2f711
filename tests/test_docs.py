"""What the documentation states as a fact and the code decides."""

from __future__ import annotations

import importlib
import json
import re
import shlex
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
import pytest
from conftest import Cli

import adr_opt
from adr_opt import (
    bodies,
    certificate,
    chasers,
    checking,
    instance,
    keep_out,
    orbit,
    plan,
    planner,
    settings,
)
from adr_opt.cli.verbs import VERBS
from adr_opt.cli.verbs import command as verbs
from adr_opt.generator import FAMILIES, generate
from adr_opt.kernels import constants
from adr_opt.kernels.burns import PHASES
from adr_opt.library import Library, load_library
from adr_opt.refining import plan as refined

ROOT = Path(__file__).parents[1]
PAGES = sorted(
    [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), *ROOT.glob("*/README.md"),
     *ROOT.glob("instances/*/README.md")]
)  # fmt: skip
PLACEHOLDERS = {
    "FAMILY": "nominal",
    "METHOD": "beam",
    "NAME=VALUE": "width=10",
    "N": "1",
    "VERB": "methods",
}
"""Words that stand for something in the commands of the pages, and one thing each stands for."""


def read(path: str) -> str:
    return (ROOT / path).read_text(encoding="utf-8")


def tables(text: str) -> Iterator[tuple[str, list[list[str]]]]:
    """The tables of a page, each with the line of text before it; rows are lists of cells."""
    before, rows = "", []
    for line in [*text.splitlines(), ""]:
        if line.startswith("|"):
            rows.append([cell.strip() for cell in line.strip("|").split(" |")])
        elif rows:
            yield before, rows
            rows = []
        if line and not line.startswith("|"):
            before = line


def described(caption: str) -> dict[str, str]:
    """The fields of the table of docs/files.md under a caption, each with its stated default."""
    found = [rows for before, rows in tables(read("docs/files.md")) if caption in before]
    assert len(found) == 1, caption
    head, _, *rows = found[0]
    fields = {}
    for row in rows:
        names = re.findall(r"`([a-z_0-9]+)`", row[0])
        default = row[head.index("default")] if "default" in head else ""
        values = default.split(", ") if default.count(", ") == len(names) - 1 else [default]
        for number, name in enumerate(names):
            fields[name] = values[number % len(values)]
    return fields


@pytest.mark.parametrize(
    ("caption", "model"),
    [
        ("Fields with a default may be left out", instance.Instance),
        ("**Orbit**", orbit.Orbit),
        ("**`targets[]`**", bodies.Target),
        ("**`chasers[]`**", chasers.Chaser),
        ("**`mission`**", settings.MissionSettings),
        ("**`transfer`**", settings.TransferSettings),
        ("**`objective`**", settings.Objective),
        ("**`keep_out_zones[]`**", settings.KeepOutZone),
        ("Defined in `adr_opt/plan.py`", plan.Plan),
        ("**`legs[]`**", plan.Leg),
        ("**`burns[]`**", plan.Burn),
        ("Defined in `adr_opt/refining/plan.py`", refined.RefinedPlan),
        ("**A refined leg**", refined.RefinedLeg),
        ("is packed by gzip", certificate.Certificate),
        ("**`walks[]`**", certificate.ProvenWalks),
        ("says how to get the files", Library),
    ],
)
def test_the_tables_of_the_formats_are_the_schemas(caption: str, model: Any) -> None:
    """docs/files.md lists the fields of every part in the order of its schema, with defaults."""
    schema = model.model_json_schema()
    stated = described(caption)
    assert list(stated) == list(schema["properties"])
    for name, default in stated.items():
        known = schema["properties"][name].get("default")
        if isinstance(known, bool):
            assert default == json.dumps(known), name
        elif isinstance(known, int | float):
            assert float(default or known) == known, name
            assert default or caption == "**`legs[]`**", name
        elif name in schema.get("required", ()):
            assert default == "", name


def test_small_parts_of_the_formats_are_described() -> None:
    """The parts without a table of their own are written out, field by field."""
    text = read("docs/files.md")
    for model in (
        chasers.Tank,
        chasers.Expense,
        settings.GivenFile,
        plan.InstanceReference,
        plan.Route,
        plan.Unvisited,
        refined.PlanReference,
        refined.BodyState,
        refined.Missing,
        refined.RefinedBurn,
        refined.RefinedState,
    ):
        assert f"{{{', '.join(model.model_json_schema()['properties'])}}}" in text


def test_the_schemas_that_are_printed_are_those_of_the_tables(cli: Cli) -> None:
    """`schema` prints the schemas that the tables are held against."""
    for which, model in (
        ("instance", instance.Instance),
        ("plan", plan.Plan),
        ("refined", refined.RefinedPlan),
        ("certificate", certificate.Certificate),
    ):
        printed = json.loads(cli("schema", which).out)
        assert printed["properties"].keys() == model.model_json_schema()["properties"].keys()
        assert printed["$defs"].keys() == model.model_json_schema()["$defs"].keys()


def test_the_metadata_of_a_policy_are_described() -> None:
    """docs/files.md lists exactly the metadata that a policy of the package has."""
    onnxruntime = pytest.importorskip("onnxruntime")
    files = sorted(ROOT.glob("solvers/learned/weights/*.onnx"))
    assert files
    for file in files:
        session = onnxruntime.InferenceSession(str(file), providers=["CPUExecutionProvider"])
        known = session.get_modelmeta().custom_metadata_map
        assert set(known) == set(described("observation`. Its ONNX metadata"))


def test_phases_and_reasons_are_described() -> None:
    """The pages on the model and the files name every phase of a burn and every reason."""
    for page in ("docs/model.md", "docs/files.md"):
        for word in (*PHASES, *plan.Reason.__args__):
            assert f"`{word}`" in read(page)


def test_tolerances_are_those_of_the_code() -> None:
    """docs/files.md states the tolerances of the check and of its keep-out zones."""
    assert (keep_out.MARGIN_M, keep_out.MARGIN_S) == (1.0, 1e-2)
    assert checking.TIME_TOLERANCE_S == 1e-3
    assert checking.DELTA_V_TOLERANCE_M_S == 1e-4
    assert checking.OBJECTIVE_TOLERANCE == 1e-6
    section = read("docs/files.md").partition("## What `check` tolerates")[2]
    assert "1 ms" in section
    assert "0.1 mm/s" in section
    assert "10⁻⁶" in section
    assert "1 m and 10 ms inside" in section


def test_the_slack_is_that_of_the_code() -> None:
    """docs/model.md states the slack in time, ΔV and radius."""
    assert constants.SLACK_S == constants.SLACK_M_S == 2.0**-20
    assert constants.SLACK_M == 2.0**-10
    section = read("docs/model.md").partition("## The slack")[2].partition("\n## ")[0]
    for value in ("| time | 2⁻²⁰ s", "| ΔV | 2⁻²⁰ m/s", "| radius | 2⁻¹⁰ m"):
        assert value in section


def test_families_are_those_of_the_generator() -> None:
    """instances/README.md lists every family with its targets, duration and budget."""
    rows = re.findall(
        r"^\| `([a-z-]+)` \| (\S+?)(?:,[^|]*)? \| ([\d.]+) days \| ([\d.]+) km/s \|",
        read("instances/README.md"),
        re.MULTILINE,
    )
    stated = {
        name: (tuple(int(n) for n in targets.split("–")), float(days), float(budget))
        for name, targets, days, budget in rows
    }
    true = {
        family.name: (
            family.targets if family.targets[0] < family.targets[1] else family.targets[:1],
            family.duration_s / 86400.0,
            round(family.delta_v_m_s / 1000.0, 3),
        )
        for family in FAMILIES.values()
    }
    assert stated == true


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
    assert used - methods == set()


def test_which_planner_lists_exactly_what_this_project_installs() -> None:
    """docs/which-planner.md has a row for every planner and bound of this package, and no other.

    Other packages may install methods of their own beside them.
    """
    declared = tomllib.loads(read("pyproject.toml"))["project"]["entry-points"]
    methods = {*declared[planner.PLANNERS], *declared[planner.BOUNDS]}
    rows = set(re.findall(r"^\| `([a-z-]+)` \|", read("docs/which-planner.md"), re.MULTILINE))
    assert rows == methods


def commands(text: str) -> Iterator[str]:
    """Every command of a page: lines of code blocks, and code in the text."""
    text = re.sub(r"\\\n\s*", "", text)  # a backslash at its end goes on with a line
    fenced = re.findall(r"^```\w*\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    rest = re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE)
    for block in (*fenced, *re.findall(r"(?m)^    \S.*$", rest)):
        for line in block.splitlines():
            yield line.partition("  #")[0].strip()
    for code in re.findall(r"`([^`]+)`", rest):
        yield " ".join(code.split())


def meant(line: str) -> list[str]:
    """The words of a command, with something in place of each placeholder."""
    return [PLACEHOLDERS.get(word, word) for word in shlex.split(line)]


ALL_COMMANDS = sorted({line for page in PAGES for line in commands(page.read_text("utf-8"))})
OURS = [line for line in ALL_COMMANDS if line.startswith("python -m adr_opt ")]
SCRIPTS = [line for line in ALL_COMMANDS if re.match(r"python [a-z_/-]+\.py", line)]
MAKE = [line for line in ALL_COMMANDS if re.fullmatch(r"make [a-z]+( [A-Z_]+=\S+)*", line)]


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


@pytest.mark.parametrize("line", SCRIPTS)
def test_every_script_in_the_pages_exists(line: str) -> None:
    """Each script that a page starts is there, and knows the options that the page gives it."""
    _, path, *words = shlex.split(line)
    script = ROOT / path
    assert script.is_file()
    near = [script, *script.parent.glob("*/*.py")]
    source = "\n".join(file.read_text(encoding="utf-8") for file in near)
    for word in words:
        if word.startswith("--"):
            assert f'"{word}"' in source, word


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


def in_a_small_world(line: str) -> list[str]:
    """A command of the quick start that takes less time and fewer targets."""
    words = meant(line)[3:]
    if words[0] == "generate":
        words[1] = "tiny"
    if words[0] == "import":
        words += ["--max-targets", "6", "--quiet"]
    if "--time-limit" in words:
        words[words.index("--time-limit") + 1] = "1"
    if words == ["warm-up"]:
        words.append("greedy")
    return words


@pytest.mark.parametrize("page", ["README.md", "docs/index.md"])
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


def test_the_first_example_of_each_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The Python of the quick start and of the page on Python runs as it stands."""
    monkeypatch.chdir(tmp_path)
    for page in ("docs/index.md", "docs/api.md"):
        for code in re.findall(r"```python\n(.*?)```", read(page), re.DOTALL):
            exec(code, {})
    assert plan.load_plan("plan.json").legs


def test_the_page_on_campaigns_runs(cli: Cli, capsys: pytest.CaptureFixture[str]) -> None:
    """Its commands, on fewer targets, plan a campaign that passes; its Python does as it stands.

    The chasers that it shows as a file are an instance's, and it lists the methods that plan them.
    """
    for package in ("boinor", "plotly"):
        pytest.importorskip(package)
    page = read("docs/campaigns.md")
    blocks = re.findall(r"(?m)^    python -m adr_opt .*$", page)
    verbs = [shlex.split(line)[3] for line in blocks]
    assert verbs[:4] == ["generate", "solve", "check", "generate"]
    assert verbs[4:7] == ["generate"] * 3
    assert set(verbs[7:]) == {"fly", "refine", "report", "export"}
    for line in blocks:
        words = in_a_small_world(line.strip())
        if words[0] == "generate":
            words[1] = shlex.split(line)[4]
            words += ["--targets", "12"]
        outcome = cli(*words)
        assert outcome.status == 0, (line, outcome.err)
    drawn = instance.load("my.json")
    assert (len(drawn.chasers), len(drawn.stations)) == (2, 2)
    shown = re.search(r"```json\n(.*?)```", page, re.DOTALL)
    assert shown is not None
    content = json.loads(drawn.to_json()) | json.loads(f"{{{shown[1]}}}")
    assert [each.name for each in instance.Instance.from_json(json.dumps(content)).chasers] == [
        "first", "late",
    ]  # fmt: skip
    (code,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    capsys.readouterr()
    exec(code, {})
    first, second, last = capsys.readouterr().out.splitlines()
    assert first.startswith("chaser-1 ['debris-")
    assert second.startswith("late ['debris-")
    assert last.endswith(" optimal ()")
    listed = {cell.strip("`") for row in next(tables(page))[1][2:] for cell in row[:1]}
    able = {
        name for name in planner.names() if planner.campaign_form(planner.get(name)) is not None
    }
    assert listed == able


def test_what_the_page_on_waiting_prints(capsys: pytest.CaptureFixture[str]) -> None:
    """Each block of Python on the page prints what the page says that it prints."""
    page = read("docs/waiting.md")
    pairs = re.findall(r"```python\n(.*?)```\n\nprints\n\n```text\n(.*?)```", page, re.DOTALL)
    assert len(pairs) == page.count("```python") == 3
    names: dict[str, Any] = {}
    for code, printed in pairs:
        exec(code, names)
        assert capsys.readouterr().out == printed


def test_what_the_page_on_given_costs_prints(
    cli: Cli, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each block of Python on the page prints what the page says; its commands run on the toy."""
    for package in ("boinor", "pyarrow", "plotly"):
        pytest.importorskip(package)
    page = read("docs/given-costs.md")
    pairs = re.findall(r"```python\n(.*?)```\n\nprints\n\n```text\n(.*?)```", page, re.DOTALL)
    assert len(pairs) == page.count("```python") == 2
    for code, printed in pairs:
        names: dict[str, Any] = {}
        exec(code, names)
        assert capsys.readouterr().out == printed
        if "road" in names:
            names["table"].instance.save("round.json")
    lines = re.findall(r"(?m)^    python -m adr_opt .*$", page)
    assert len(lines) == 3
    for line in lines:
        outcome = cli(*meant(line.strip())[3:])
        assert outcome.status == 0, (line, outcome.err)


def test_the_environment_of_the_readme_runs() -> None:
    """The environment in five lines runs as it stands."""
    pytest.importorskip("gymnasium")
    code = re.search(r"```python\n(import gymnasium.*?)```", read("README.md"), re.DOTALL)
    assert code is not None
    names: dict = {}
    exec(code[1], names)
    assert names["reward"] in (0.0, 1.0)


def test_the_page_on_python_names_all_there_is() -> None:
    """docs/api.md has every public name of the package, and no module or name that is not there."""
    (_, public), (_, modules) = tables(read("docs/api.md"))
    named = {name for row in public[2:] for name in re.findall(r"`([A-Za-z_]+)", row[0])}
    assert named == {name for name in adr_opt.__all__ if not name.startswith("__")}
    for row in modules[2:]:
        name = row[0].strip("`")
        try:
            module = importlib.import_module(name)
        except adr_opt.MissingExtra:
            continue
        for word in re.findall(r"`([A-Za-z_]+)`", row[1]):
            assert hasattr(module, word), f"{name}.{word}"


def test_extras_are_those_of_the_package() -> None:
    """The README has a row for each extra that is not for the tests of this project."""
    project = tomllib.loads(read("pyproject.toml"))["project"]
    section = read("README.md").partition("## Extras")[2].partition("\n## ")[0]
    rows = {name for row in section.splitlines() for name in re.findall(r"`\[(\w+)\]`", row)}
    assert rows == set(project["optional-dependencies"]) - {"test", "dev"}


def test_the_readme_counts_the_library() -> None:
    """The README says how many instances the library has and in which families."""
    entries = load_library(ROOT / "instances/library.json").instances
    families = list(dict.fromkeys(entry.family for entry in entries))
    text = " ".join(read("README.md").split())
    assert f"{len(entries)} instances in eleven families ({', '.join(families)})" in text
    assert len(families) == 11


def test_formats_are_in_the_changelog_and_on_their_page() -> None:
    """Every file format with a number is named where readers look for it."""
    from solvers.learned.policy import FORMAT as POLICY

    formats = (instance.FORMAT, plan.FORMAT, certificate.FORMAT, "adr-opt-library/1", POLICY)
    for page in ("CHANGELOG.md", "docs/files.md"):
        for name in formats:
            assert f"`{name}`" in read(page)


def test_versions_agree() -> None:
    """What is cited, what is installed and what is said to be made are one version."""
    version = tomllib.loads(read("pyproject.toml"))["project"]["version"]
    assert adr_opt.__version__ == version
    assert f"\nversion: {version}\n" in read("CITATION.cff")
    assert f"version = {{{version}}}" in read("docs/citing.md")
    assert version in read("CHANGELOG.md")


def test_links_between_pages_lead_somewhere() -> None:
    """Every relative link of a page names a file or folder, and every anchor a heading."""
    for page in PAGES:
        for link in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8")):
            if link.startswith(("http:", "https:", "mailto:")):
                continue
            path, _, anchor = link.partition("#")
            target = page.parent / path if path else page
            assert target.exists(), f"{page.name}: {link}"
            if anchor:
                headings = re.findall(
                    r"^#+ (.*)$", target.read_text(encoding="utf-8"), re.MULTILINE
                )
                slugs = [re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in headings]
                assert anchor in slugs, f"{page.name}: {link}"


def test_the_example_of_the_readme_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first Python example of the README runs as it stands."""
    (tmp_path / "instances").symlink_to(ROOT / "instances")
    monkeypatch.chdir(tmp_path)
    code = re.search(r"```python\n(.*?)```", read("README.md"), re.DOTALL)
    assert code is not None
    names: dict = {}
    exec(code[1], names)
    assert names["result"].objective > 0.0
    assert names["matrices"].delta_v.shape == (3, 51, 51)
    assert (tmp_path / "plan.json").is_file()


def test_the_committed_instances_are_what_their_names_say() -> None:
    """Each FAMILY-SEED file under instances/ is, byte for byte, what the generator gives."""
    files = sorted(ROOT.glob("instances/*/*-[0-9][0-9][0-9].json"))
    files = [file for file in files if file.parent.name != "best-known"]  # plans
    assert len(files) >= 20
    for file in files:
        family, _, seed = file.stem.rpartition("-")
        assert file.parent.name == family
        assert file.read_bytes() == generate(family, int(seed)).to_json().encode(), file.name
