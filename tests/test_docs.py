"""What the documentation states as a fact and the code decides."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from adr_opt import checking, instance, plan, planner
from adr_opt.cli.verbs import VERBS
from adr_opt.generator import FAMILIES, generate
from adr_opt.kernels.burns import PHASES

ROOT = Path(__file__).parents[1]
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), *ROOT.glob("*/README.md")])


def read(path: str) -> str:
    return (ROOT / path).read_text(encoding="utf-8")


@pytest.mark.parametrize("schema", [instance.json_schema(), plan.json_schema()])
def test_every_field_of_the_files_is_described(schema: dict) -> None:
    """docs/files.md names every field of both formats."""
    described = set(re.findall(r"`([a-z_0-9]+)`|\{([^}]*)\}", read("docs/files.md")))
    words = {
        word for pair in described for text in pair for word in re.findall(r"[a-z_0-9]+", text)
    }
    parts = [schema, *schema["$defs"].values()]
    fields = {field for part in parts for field in part.get("properties", {})}
    assert len(fields) > 10
    assert fields - words == set()


def test_phases_and_reasons_are_described() -> None:
    """The pages on the model and the files name every phase of a burn and every reason."""
    for page in ("docs/model.md", "docs/files.md"):
        for word in (*PHASES, *plan.Reason.__args__):
            assert f"`{word}`" in read(page)


def test_tolerances_are_those_of_the_code() -> None:
    """docs/files.md states the tolerances of the check: 1 ms, 0.1 mm/s and 1e-6."""
    assert checking.TIME_TOLERANCE_S == 1e-3
    assert checking.DELTA_V_TOLERANCE_M_S == 1e-4
    assert checking.OBJECTIVE_TOLERANCE == 1e-6
    section = read("docs/files.md").partition("## What `check` tolerates")[2]
    assert "1 ms" in section
    assert "0.1 mm/s" in section
    assert "10⁻⁶" in section


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
            family.delta_v_m_s / 1000.0,
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
        verbs |= set(re.findall(r"python -m adr_opt ([a-z]+)", text))
        used |= set(re.findall(r"(?:--method|--bound) ([a-z-]+)", text))
    assert {"generate", "solve", "check"} <= verbs
    assert verbs - set(VERBS) == set()
    assert used - methods == set()


def test_which_planner_lists_exactly_what_is_installed() -> None:
    """docs/which-planner.md has a row for every planner and bound, and for nothing else."""
    rows = set(re.findall(r"^\| `([a-z-]+)` \|", read("docs/which-planner.md"), re.MULTILINE))
    assert rows == {*planner.names(), *planner.names(planner.BOUNDS)}


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
