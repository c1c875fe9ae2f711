"""What the package says of itself elsewhere agrees with pyproject.toml."""

from __future__ import annotations

import re
import tomllib
from typing import Any

import pytest
from pages import read

from adr_opt.common.packages import Requirement, requirements

CONDA_NAMES = {"matplotlib": "matplotlib-base", "ortools": "ortools-python", "torch": "pytorch"}
"""Packages that conda-forge has under other names."""

DEVELOPMENT = {"bench", "dev", "docs", "peers", "readers", "test"}


@pytest.fixture(scope="module")
def project() -> dict[str, Any]:
    return tomllib.loads(read("pyproject.toml"))


@pytest.fixture(scope="module")
def recipe() -> dict[str, Any]:
    yaml = pytest.importorskip("yaml")
    found: dict[str, Any] = yaml.safe_load(read("docs/conda/recipe.yaml"))
    return found


def conda(stated: list[str]) -> list[str]:
    """Requirements as the recipe writes them."""
    found: tuple[Requirement, ...] = requirements(lambda name: stated)
    return sorted(f"{CONDA_NAMES.get(each.package, each.package)} {each.bounds}" for each in found)


def test_the_recipe_needs_what_the_package_needs(
    project: dict[str, Any], recipe: dict[str, Any]
) -> None:
    """Names and bounds of all that is needed to build, to run, and by the extras for users."""
    needs, stated = recipe["requirements"], project["project"]
    python, *run = needs["run"]
    least = stated["requires-python"].removeprefix(">=")
    assert recipe["context"]["python_min"] == least
    assert python == "python >=${{ python_min }}"
    assert sorted(run) == conda(stated["dependencies"])
    extras = stated["optional-dependencies"]
    users = {
        text for extra, listed in extras.items() if extra not in DEVELOPMENT for text in listed
    }
    assert sorted(needs["run_constraints"]) == conda(sorted(users))
    assert sorted(needs["host"]) == sorted(
        ["pip", "python ${{ python_min }}.*", *conda(project["build-system"]["requires"])]
    )


def test_the_recipe_makes_this_version(project: dict[str, Any], recipe: dict[str, Any]) -> None:
    """Version, entry point and licence are those of the package; the version is released."""
    stated = project["project"]
    cited = re.search(r"^version: (.*)$", read("CITATION.cff"), re.MULTILINE)
    assert recipe["context"]["version"] == cited[1]
    assert recipe["package"]["name"] == stated["name"]
    ((name, called),) = stated["scripts"].items()
    assert recipe["build"]["python"]["entry_points"] == [f"{name} = {called}"]
    assert recipe["about"]["license"] == stated["license"]
    assert [recipe["about"]["license_file"]] == stated["license-files"]


def test_every_requirement_has_its_exact_version(project: dict[str, Any]) -> None:
    """constraints.txt has all that pyproject.toml asks for, in a version that it allows."""
    stated = project["project"]
    lines = read("constraints.txt").splitlines()
    exact = dict(line.lower().replace("_", "-").split("==") for line in lines if "==" in line)
    wanted = [*stated["dependencies"]]
    for listed in stated["optional-dependencies"].values():
        wanted += [text for text in listed if not text.startswith("adr-opt[")]
    for each in requirements(lambda name: wanted):
        assert each.allows(exact[each.package.lower()]), each
