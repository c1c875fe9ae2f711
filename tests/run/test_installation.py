"""``doctor``: the facts about an installation, and each problem in a sentence with its cure."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError
from pathlib import Path
from typing import Any

import pytest
from conftest import Cli

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.common.packages import Requirement, requirements
from adr_opt.kernels.core import archive, cache
from adr_opt.run import installation, method_call

PROJECT = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())["project"]
STATED = [
    *PROJECT["dependencies"],
    *(
        f'{text}; extra == "{extra}"'
        for extra, listed in PROJECT["optional-dependencies"].items()
        for text in listed
    ),
]
"""What the metadata of an installation state."""

Patch = Callable[[pytest.MonkeyPatch, Path], None]


@pytest.fixture(autouse=True)
def _well(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """An installation of which all is well, whatever this machine is like."""
    real = installation.installed
    monkeypatch.setattr(
        installation,
        "installed",
        lambda name: PROJECT["version"] if name == "adr-opt" else real(name),
    )
    monkeypatch.setattr(installation, "requirements", lambda: requirements(lambda name: STATED))
    monkeypatch.setattr(installation, "available_bytes", lambda: 4.0 * 2.0**30)
    monkeypatch.setenv("ADR_OPT_CACHE_DIR", str(tmp_path / "kernels"))
    monkeypatch.delenv("NUMBA_DISABLE_JIT", raising=False)


def test_all_is_well(cli: Cli, tmp_path: Path) -> None:
    """Facts stand on standard output, as lines and as JSON, and the exit status is 0."""
    (folder := tmp_path / "kernels").mkdir()
    (folder / "one.kernel").write_bytes(bytes(2_000_000))
    (folder / "other").touch()
    outcome = cli("doctor")
    assert (outcome.status, outcome.err) == (0, "")
    assert outcome.out.endswith("all is well\n")
    for said in (
        adr_opt.__version__,
        "numba ",
        "llvmlite ",
        f"1 kernel, 2.0 MB, in {folder}",
        "4.0 GiB of memory free",
        "auto, beam",
        "lagrangian",
    ):
        assert said in outcome.out
    printed = json.loads(cli("doctor", "--json").out)
    assert printed["problems"] == []
    assert printed["versions"].keys() >= {"adr-opt", "highspy", "llvmlite", "numba", "ortools"}
    assert printed["cache"]["kernels"] == 1
    assert printed["extras"].keys() == PROJECT["optional-dependencies"].keys()
    assert sorted(path.name for path in folder.iterdir()) == ["one.kernel", "other"]


def test_the_archive_of_kernels_is_told(
    cli: Cli, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Whether there is one, whether it serves this processor, and how many kernels it has."""

    def told() -> str:
        archive.is_usable.cache_clear()
        archive._opened.cache_clear()
        said: str = json.loads(cli("doctor", "--json").out)["archive"]
        return said

    monkeypatch.setattr(archive, "FILE", tmp_path / "compiled.zip")
    assert told().startswith("none in this installation")
    archive.write({"one": b"", "two": b""}, archive.FILE)
    for serves, said in (
        (True, "2 kernels for processors of level"),
        (False, "made for processors of"),
    ):
        monkeypatch.setattr(archive, "serves_this_processor", lambda serves=serves: serves)
        assert told().startswith(said)
    archive.is_usable.cache_clear()
    archive._opened.cache_clear()


def test_missing_extras_are_no_problem(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    """They are listed with the packages that they lack, and how to add them."""
    known = installation.installed
    monkeypatch.setattr(
        installation, "installed", lambda name: None if name == "pyarrow" else known(name)
    )
    outcome = cli("doctor")
    assert outcome.status == 0
    assert "io (pyarrow); pip install 'adr-opt[NAME]' adds one" in outcome.out
    extras = json.loads(cli("doctor", "--json").out)["extras"]
    assert extras["io"] == ["pyarrow"]
    assert "pyarrow" in extras["test"]  # which stands for others


def test_what_python_brings_is_no_problem(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    """An old package of an extra counts where that extra is complete, and no earlier."""
    _version("setuptools", "65.5.0")(monkeypatch, Path())
    with monkeypatch.context() as without:
        _version("hypothesis", None)(without, Path())
        outcome = cli("doctor", "--json")
    assert outcome.status == 0, outcome.out
    assert "hypothesis" in json.loads(outcome.out)["extras"]["test"]
    monkeypatch.setattr(installation, "_extras", lambda needed: {each.extra: () for each in needed})
    refusal = cli("doctor")
    assert refusal.status == 1
    assert "setuptools 65.5.0 does not work with [test]" in refusal.out + refusal.err


def _version(package: str, found: str | None) -> Patch:
    def patch(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
        known = installation.installed
        monkeypatch.setattr(
            installation, "installed", lambda name: found if name == package else known(name)
        )

    return patch


def _broken(package: str) -> Patch:
    def patch(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
        real = installation.import_module

        def imported(name: str) -> Any:
            if name == package:
                raise ImportError("needs another\nlibrary")
            return real(name)

        monkeypatch.setattr(installation, "import_module", imported)

    return patch


def _unloadable(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    real = method_call.method_of

    def found(name: str, group: str) -> Any:
        if name == "mip":
            raise InputError("method 'mip' is broken; mend it")
        return real(name, group)

    monkeypatch.setattr(method_call, "method_of", found)


def _uninstalled(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    def state(name: str) -> list[str] | None:
        raise PackageNotFoundError(name)

    monkeypatch.setattr(installation, "requirements", lambda: requirements(state))


def _file_in_the_way(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    (folder / "kernels").write_text("")


def _second_folder(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    (folder / "taken").write_text("")
    monkeypatch.setattr(cache, "folders", lambda: [folder / "taken" / "kernels", folder / "other"])


PROBLEMS: list[tuple[Patch, str]] = [
    (
        _version("highspy", "1.15.1"),
        "highspy 1.15.1 does not work with adr-opt; replace it with pip install "
        "'highspy>=1.10,!=1.15.0,!=1.15.1'",
    ),
    (_version("sgp4", "2.9"), "sgp4 2.9 does not work with [astro]; replace it with pip install"),
    (_version("scipy", None), "scipy is missing; install it with pip install 'scipy>=1.10'"),
    (_version("adr-opt", "0.1.0"), "has the metadata of version 0.1.0, so that methods may be"),
    (_version("adr-opt", None), "adr-opt is not installed in this Python ("),
    (_uninstalled, "adr-opt is not installed in this Python ("),
    (
        _broken("numba"),
        "numba cannot be imported (needs another library); install it again with pip install "
        "--force-reinstall 'numba>=0.60'",
    ),
    (_unloadable, "method 'mip' is broken; mend it"),
    (
        lambda monkeypatch, folder: monkeypatch.setattr(installation, "names", lambda group: ()),
        "no planner is installed; install adr-opt again with pip",
    ),
    (
        lambda monkeypatch, folder: monkeypatch.setattr(
            installation, "foreign_package", lambda: "another package hides ours; rename it"
        ),
        "another package hides ours; rename it",
    ),
    (_file_in_the_way, "so every run compiles for a minute; name a folder that is writable"),
    (_second_folder, "which the next restart may empty; make it writable, or name another folder"),
    (
        lambda monkeypatch, folder: monkeypatch.setattr(cache, "folders", lambda: []),
        "there is no folder to keep compiled kernels in, so every run compiles for a minute",
    ),
    (
        lambda monkeypatch, folder: monkeypatch.setattr(
            installation, "available_bytes", lambda: 100.0 * 2.0**20
        ),
        "only 100 MiB of memory are free; end other programs",
    ),
    (
        lambda monkeypatch, folder: monkeypatch.setenv("NUMBA_DISABLE_JIT", "1"),
        "NUMBA_DISABLE_JIT is set, so that nothing is compiled; unset it",
    ),
]


@pytest.mark.parametrize(("patch", "said"), PROBLEMS)
def test_each_problem_is_a_sentence_with_its_cure(
    cli: Cli, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, patch: Patch, said: str
) -> None:
    """Every drawn problem is found, alone, in one line, and the exit status is 1."""
    patch(monkeypatch, tmp_path)
    outcome = cli("doctor")
    assert (outcome.status, outcome.err) == (1, "")
    (line,) = [line for line in outcome.out.splitlines() if line.startswith("problem: ")]
    assert said in line
    assert "all is well" not in outcome.out
    (told,) = json.loads(cli("doctor", "--json").out)["problems"]
    assert f"problem: {told}" == line


def test_requirements_are_read_as_they_are_stated() -> None:
    """Every requirement of pyproject.toml comes back with its package, its bounds and its extra."""
    found = requirements(lambda name: STATED)
    assert len(found) == len(STATED)
    for each, text in zip(found, STATED, strict=True):
        parts = f"[{','.join(each.parts)}]" if each.parts else ""
        marker = f'; extra == "{each.extra}"' if each.extra else ""
        assert f"{each.package}{parts}{each.bounds}{marker}" == text


@pytest.mark.parametrize(
    ("bounds", "found", "allowed"),
    [
        ("", "0.1", True),
        (">=1.10", "1.9.9", False),
        (">=1.10", "1.10", True),
        (">=1.10", "1.10.0", True),
        (">=2.2.0", "2.2", True),
        (">=1.10", "2.0", True),
        ("!=1.15.0,>=1.10", "1.15", False),
        ("!=1.15.0,>=1.10", "1.15.2", True),
        (">=2.4", "2.13.0+cpu", True),
    ],
)
def test_versions_are_compared_as_numbers(bounds: str, found: str, allowed: bool) -> None:
    """Lower bounds and exclusions hold, and 1.10 comes after 1.9."""
    assert Requirement("any", bounds).allows(found) is allowed
