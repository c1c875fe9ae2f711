"""The example of `docs/adding-a-planner.md`, installed as a third party's package would be."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import pytest
from example_packages import project_of, put

import adr_opt
from adr_opt.common.stop import MaxIterations
from adr_opt.run import methods

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "random-walks"


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Put the module and the entry points of its pyproject.toml where an installer would."""
    put(project_of(EXAMPLE), tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.syspath_prepend(str(EXAMPLE))


@pytest.mark.usefixtures("installed")
def test_an_installed_planner_shows_up_with_its_options() -> None:
    """A planner is found, and its options are listed, because its package is installed."""
    assert "random-walks" in methods.names()
    kind = methods.options_of(methods.get("random-walks"))
    assert [each.name for each in fields(kind)] == ["walks"]


@pytest.mark.usefixtures("installed")
def test_its_plans_are_legal_and_repeatable() -> None:
    """The example plans legal missions, and the same seed and work give the same plan."""
    instance = adr_opt.generate("tiny", seed=3)
    first, second = (
        adr_opt.solve(instance, method="random-walks", seed=5, walks=20) for _ in range(2)
    )
    assert first.plan is not None
    assert adr_opt.check(instance, first.plan) == ()
    assert first.objective > 0.0
    assert first.sequence == second.sequence


@pytest.mark.usefixtures("installed")
def test_it_asks_the_stopping_criterion_and_reports_incumbents() -> None:
    """The example stops when told to, and every incumbent it reports beats the one before."""
    heard: list[float] = []
    result = adr_opt.solve(
        adr_opt.generate("nominal", seed=0, targets=12),
        method="random-walks",
        stop=MaxIterations(7),
        progress=lambda incumbent, bound: heard.append(incumbent),
    )
    assert result.counters["walks"] == 7
    assert heard == sorted(set(heard))
    assert heard[-1] == result.objective


def test_without_its_package_it_is_unknown() -> None:
    """A planner that is not installed is refused with the list of those that are."""
    with pytest.raises(
        adr_opt.InputError, match=r"'of-no-package' is unknown; use one of: .*greedy"
    ):
        adr_opt.solve(adr_opt.generate("tiny", seed=0), method="of-no-package")


def test_the_page_shows_the_code_that_runs() -> None:
    """The page on adding a planner prints the example's files word for word."""
    page = (ROOT / "docs" / "adding-a-planner.md").read_text(encoding="utf-8")
    assert (EXAMPLE / "random_walks.py").read_text(encoding="utf-8") in page
    assert (EXAMPLE / "pyproject.toml").read_text(encoding="utf-8") in page
