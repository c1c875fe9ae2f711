"""Options of flights with all forces, which need no library to be refused."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from conftest import Cli, refused
from plans import solved

import adr_opt


@pytest.fixture
def files(tmp_path: Path) -> list[str]:
    """An instance and its refined plan."""
    instance = adr_opt.generate("tiny", 0).replace(dynamics="j2")
    instance.save(tmp_path / "my.json")
    plan = solved(instance)
    plan.save(tmp_path / "plan.json")
    adr_opt.refine(instance, plan).save(tmp_path / "refined.json")
    return [str(tmp_path / name) for name in ("my.json", "refined.json", "plan.json")]


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ("--cd 3", "--cd needs --forces full"),
        ("--activity low", "--activity needs --forces full"),
        ("--forces j2 --target-area-mass 0.1", "--target-area-mass needs --forces full"),
        ("--forces all", "'all' is not one of"),
        ("--forces full --activity huge", "'huge' is not one of"),
        ("--forces full --area-mass -1", "area-mass = -1: must lie between 0 and 100"),
        ("--forces full --cr nan", "cr = nan: must lie between 0 and 2"),
        ("--forces full --samples 10", "--samples flies with errors"),
    ],
)
def test_bad_options_are_refused(files: list[str], cli: Cli, options: str, named: str) -> None:
    """A wrong value, or an option without what it belongs to, is one sentence and no file."""
    out = Path(files[0]).with_name("out.json")
    refused(cli("fly", *files[:2], *options.split(), "--out", str(out)), named)
    assert not out.exists()


def test_a_plan_that_is_not_refined_is_refused(files: list[str], cli: Cli) -> None:
    """All forces need osculating states, which a refined plan has."""
    refused(cli("fly", files[0], files[2], "--forces", "full"), "needs a refined plan")


@pytest.mark.parametrize("package", ["brahe", "astropy_iers_data"])
def test_a_missing_library_names_its_extra(
    files: list[str], cli: Cli, monkeypatch: pytest.MonkeyPatch, package: str
) -> None:
    """Without the library, or the tables of the Earth's rotation, the sentence names the extra."""
    monkeypatch.setitem(sys.modules, package, None)
    refused(cli("fly", *files[:2], "--forces", "full"), "adr-opt[forces]")
