"""What the documentation states as a fact and the code decides."""

from __future__ import annotations

import csv
import importlib
import re
import tomllib

from pages import ROOT, read, tables

import adr_opt
from adr_opt.common import constants
from adr_opt.judge.check import violation, zone_crossings
from adr_opt.run import methods as planner
from adr_opt.sources.generator import FAMILIES
from adr_opt.sources.library import load_library


def test_tolerances_are_those_of_the_code() -> None:
    """docs/files.md states the tolerances of the check and of its keep-out zones."""
    assert (zone_crossings.MARGIN_M, zone_crossings.MARGIN_S) == (1.0, 1e-2)
    assert violation.TIME_TOLERANCE_S == 1e-3
    assert violation.DELTA_V_TOLERANCE_M_S == 1e-4
    assert violation.OBJECTIVE_TOLERANCE == 1e-6
    section = read("docs/files.md").partition("## Tolerances of `check`")[2]
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


def test_which_planner_lists_exactly_what_this_project_installs() -> None:
    """docs/which-planner.md has a row for every planner and bound of this package, and no other.

    Other packages may install methods of their own beside them.
    """
    declared = tomllib.loads(read("pyproject.toml"))["project"]["entry-points"]
    methods = {*declared[planner.PLANNERS], *declared[planner.BOUNDS]}
    rows = set(re.findall(r"^\| `([a-z-]+)` \|", read("docs/which-planner.md"), re.MULTILINE))
    assert rows == methods


def test_the_page_on_python_names_all_there_is() -> None:
    """docs/api.md has every public name of the package, and no module or name that is not there."""
    (_, public), _, (_, modules) = tables(read("docs/api.md"))
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
    assert f"{len(entries)} instances in twelve families ({', '.join(families)})" in text
    assert len(families) == 12


def test_the_proven_gaps_are_those_of_the_table() -> None:
    """instances/README.md counts the instances of 50 targets, and those whose gap is zero."""
    fifty = {family.name for family in FAMILIES.values() if family.targets == (50, 50)}
    with (ROOT / "instances/best-known.csv").open(encoding="utf-8") as file:
        gaps = [
            row["gap"]
            for row in csv.DictReader(file)
            if row["instance"].rpartition("-")[0] in fifty
        ]
    closed = sum(bool(gap) and float(gap) == 0.0 for gap in gaps)
    stated = f"Of the {len(gaps)} instances with 50 targets, the gap is zero on {closed}."
    assert stated in " ".join(read("instances/README.md").split())
    assert closed > 0.9 * len(gaps), "the README says: almost all"


def test_visits_beside_those_of_the_study_are_those_measured() -> None:
    """Pages that compare with the study name it, with the figures of its page and of the curve."""
    page = read("docs/published-study.md")
    visits = [
        re.search(rf"^\| {planner}.*?\| [\d–]+ \| ([\d.]+) ±", page, re.MULTILINE)[1]
        for planner in ("greedy", "MCTS")
    ]
    with (ROOT / "bench/curves/published.csv").open(encoding="utf-8") as file:
        visits.append(list(csv.DictReader(file))[-1]["nominal"])
    assert f"| {float(visits[-1]):.2f}, without zones |" in page
    for name in ("README.md", "instances/README.md"):
        section = re.search(r"\*\*calibration\*\*.*", read(name), re.DOTALL)[0][:1200]
        for mean in visits:
            assert f"{float(mean):.1f}" in section, name
    for name in ("README.md", "docs/published-study.md", "docs/citing.md", "CITATION.cff"):
        assert "Waxenegger-Wilfing" in read(name)
        assert "2602.17685" in read(name)


def test_versions_agree() -> None:
    """What is cited is the last release; what is installed is it, or on the way to the next one."""
    version = tomllib.loads(read("pyproject.toml"))["project"]["version"]
    assert adr_opt.__version__ == version
    released = re.findall(r"^## (\S+) \(\d{4}-\d\d-\d\d\)", read("CHANGELOG.md"), re.MULTILINE)[0]
    unreleased = re.findall(r"^## (\S+) \(unreleased\)", read("CHANGELOG.md"), re.MULTILINE)
    assert version == (f"{unreleased[0]}.dev0" if unreleased else released)
    assert f"\nversion: {released}\n" in read("CITATION.cff")
    assert f"version = {{{released}}}" in read("docs/citing.md")


def test_every_page_says_for_whom_it_is() -> None:
    """The first words below the heading of a page are its readers, or what the reader has."""
    for path in sorted((ROOT / "docs").rglob("*.md")):
        below = path.read_text(encoding="utf-8").split("\n", 3)[2]
        assert below.startswith(("*For ", "**You have** ")), path.name
