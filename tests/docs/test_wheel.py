"""Wheel and source archive, installed outside the checkout: what users get works there."""

from __future__ import annotations

import filecmp
import json
import os
import shutil
import site
import subprocess
import sys
import tarfile
import zipfile
from dataclasses import dataclass
from pathlib import Path

import pytest
from compiled_kernels import LISTEN
from pages import ROOT

from adr_opt.kernels.core import archive
from adr_opt.kernels.core.cache import VARIABLE
from adr_opt.run.front import spec_of
from adr_opt.run.methods import BOUNDS, PLANNERS, names

PACKAGES = ("adr_opt", "solvers")

METHOD = "beam"
"""Method whose kernels are in the archive of the wheel; all are in that of the slow test."""

pytestmark = pytest.mark.slow

needs_level = pytest.mark.skipif(
    not archive.serves_this_processor(), reason="no archive is for this processor"
)
BUILD = "from setuptools import build_meta; build_meta.build_{}({!r})"


@dataclass(frozen=True)
class Archives:
    """What is built, and the folders that it was built in."""

    source: Path
    unpacked: Path
    sdist: Path
    wheel: Path
    wheel_of_sdist: Path


def build(folder: Path, kind: str) -> Path:
    """Build a wheel or a source archive of a folder, as installers do."""
    out = folder / f"out-{kind}"
    run([sys.executable, "-c", BUILD.format(kind, str(out))], folder)
    (made,) = out.iterdir()
    return made


def run(command: list[str], folder: Path, **variables: str) -> str:
    """Run a program that sees nothing of the checkout; returns what it prints."""
    environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")}
    environment |= variables
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, env=environment)
    assert done.returncode == 0, (command, done.stdout[-2000:], done.stderr[-2000:])
    return done.stdout


def make_archive(file: Path, *methods: str) -> None:
    """Make an archive of kernels, by the script of the project."""
    some = ["--methods", *methods] if methods else []
    subprocess.run(
        [sys.executable, str(ROOT / "bench/wheel.py"), "--archive", str(file), *some],
        check=True,
        capture_output=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )


@pytest.fixture(scope="module")
def archives(tmp_path_factory: pytest.TempPathFactory) -> Archives:
    """Both, and the wheel that the source archive makes."""
    pytest.importorskip("setuptools", minversion="77")
    source = tmp_path_factory.mktemp("source")
    for package in PACKAGES:
        shutil.copytree(
            ROOT / package, source / package, ignore=shutil.ignore_patterns("__pycache__")
        )
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source / name)
    if archive.serves_this_processor():
        make_archive(source / "adr_opt" / archive.FILE.relative_to(ROOT / "adr_opt"), METHOD)
    sdist, wheel = build(source, "sdist"), build(source, "wheel")
    with tarfile.open(sdist) as file:
        file.extractall(tmp_path_factory.mktemp("unpacked"), filter="data")
    (unpacked,) = (tmp_path_factory.getbasetemp() / "unpacked0").iterdir()
    return Archives(source, unpacked, sdist, wheel, build(unpacked, "wheel"))


def environment(folder: Path, wheel: Path, *options: str) -> Path:
    """A virtual environment with a wheel in it; returns its folder of programs."""
    run([sys.executable, "-m", "venv", "--without-pip", str(folder)], folder.parent)
    programs = folder / ("Scripts" if os.name == "nt" else "bin")
    python = next(programs.glob("python*"))
    pip = [
        sys.executable,
        "-m",
        "pip",
        "--python",
        str(python),
        "install",
        "--quiet",
        "--no-compile",
    ]
    run([*pip, *options, str(wheel)], folder.parent)
    return programs


@pytest.fixture(scope="module")
def programs(archives: Archives, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Programs of an environment with the wheel, and what it needs from that of the tests.

    Installed for editing, as adr-opt is there, a package is a .pth file, and one within a folder
    that a .pth file names is not read.
    """
    folder = tmp_path_factory.mktemp("environment") / "venv"
    found = environment(folder, archives.wheel_of_sdist, "--no-deps", "--no-index")
    (packages,) = folder.glob("[Ll]ib/**/site-packages")
    (packages / "needed.pth").write_text("\n".join(site.getsitepackages()) + "\n")
    return found


def test_both_hold_all_files_of_the_packages(archives: Archives) -> None:
    """The wheel has every file of the packages, code or data, and nothing else."""
    files = {
        path.relative_to(archives.source).as_posix()
        for package in PACKAGES
        for path in (archives.source / package).rglob("*")
        if path.is_file()
    }
    endings = {name.rpartition(".")[2] for name in files}
    assert {"py", "typed", "html", "css", "js", "npz"} <= endings
    with zipfile.ZipFile(archives.wheel) as file:
        packed = {name for name in file.namelist() if ".dist-info/" not in name}
    assert packed == files
    for name in (*files, "LICENSE", "README.md", "pyproject.toml"):
        assert filecmp.cmp(archives.source / name, archives.unpacked / name, shallow=False), name


def test_the_source_archive_makes_the_same_wheel(archives: Archives) -> None:
    """Name for name and byte for byte."""
    assert archives.wheel.name == archives.wheel_of_sdist.name
    one, other = zipfile.ZipFile(archives.wheel), zipfile.ZipFile(archives.wheel_of_sdist)
    assert sorted(one.namelist()) == sorted(other.namelist())
    for name in one.namelist():
        assert one.read(name) == other.read(name), name


def test_the_wheel_is_what_is_imported(programs: Path, tmp_path: Path) -> None:
    """Both packages, their metadata, policies and views of notebooks come from the environment."""
    program = """
import json, adr_opt, solvers
from importlib.metadata import version
from importlib.resources import files
from adr_opt.learning import load_policy
load_policy()
print(json.dumps({
    "places": [adr_opt.__file__, solvers.__file__],
    "versions": [adr_opt.__version__, version("adr-opt")],
    "typed": (files("adr_opt") / "py.typed").is_file(),
    "shown": repr(adr_opt.generate("tiny", 0)),
}))
"""
    said = json.loads(run([str(programs / "python"), "-c", program], tmp_path))
    for place in said["places"]:
        assert Path(place).is_relative_to(programs.parent), place
    assert len(set(said["versions"])) == 1
    assert said["typed"]
    assert said["shown"].startswith("<Instance 'tiny-000': 7 targets")


def mission(program: list[str], folder: Path) -> None:
    """Draw, plan, check and show a mission by the commands of an installation."""

    def call(*words: str) -> str:
        return run([*program, *words], folder)

    assert call("--version").startswith("adr-opt ")
    call("generate", "tiny", "--out", "tiny.json")
    call("solve", "tiny.json", "--method", "greedy-guarded", "--out", "plan.json")
    assert "no violations" in call("check", "tiny.json", "plan.json")
    found = json.loads(call("doctor", "--json"))  # loads every method
    assert found["problems"] == []
    assert {"auto", "exact", "ppo"} <= set(found["planners"])


def test_its_commands_work(programs: Path, tmp_path: Path) -> None:
    """Its program draws, plans, checks, reports and finds all well, as a module too."""
    pytest.importorskip("plotly")
    mission([str(programs / "adr-opt")], tmp_path)
    run(
        [str(programs / "adr-opt"), "report", "tiny.json", "plan.json", "--out", "a.html"], tmp_path
    )
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert "</html>" in page
    assert len(page) > 100_000
    by_module = [str(programs / "python"), "-m", "adr_opt", "schema", "plan"]
    assert json.loads(run(by_module, tmp_path))["properties"]


PLANS = f"""{LISTEN}
import json, sys
import adr_opt
from adr_opt.kernels.core import archive, cache
from adr_opt.run.front import RunOptions, run
assert archive.is_usable()
listen()
method, *groups = sys.argv[1].split()
for family, how in json.loads(sys.argv[2]):
    field = adr_opt.generate(family, 0, **how)
    for group in groups:
        try:
            result = run(group, field, method, RunOptions(5.0))
        except adr_opt.InputError as refusal:  # policies want a station
            assert "plan this mission with another method" in str(refusal)
            continue
        assert result.plan is None or adr_opt.check(field, result.plan) == ()
print(json.dumps([compiled, [str(file) for file in cache.folders()[0].glob("*")]]))
"""


pytestmark = pytest.mark.slow


@needs_level
def test_the_wheel_brings_kernels(programs: Path, tmp_path: Path) -> None:
    """With an empty folder for kernels a plan is made, and nothing is compiled or written."""
    fields = json.dumps([["tiny", {}], ["nominal", {"targets": 12}]])
    call = [str(programs / "python"), "-c", PLANS, f"{METHOD} {PLANNERS}", fields]
    said = run(call, tmp_path, **{VARIABLE: str(tmp_path / "kept")})
    assert json.loads(said.splitlines()[-1]) == [[], []]


@needs_level
def test_the_whole_archive_leaves_no_method_anything_to_compile(tmp_path: Path) -> None:
    """With it no planner and no bound compiles for eight kinds of missions."""
    file = tmp_path / "compiled.zip"
    make_archive(file)
    where = (
        "from pathlib import Path\nfrom adr_opt.kernels.core import archive\n"
        f"archive.FILE = Path({str(file)!r})\n"
    )
    one = [["nominal", {}], ["reduced-time", {"zones": 3}], ["rocket-bodies", {"targets": 6}]]
    several = [
        ["campaign", {"targets": 10}],
        ["removal", {"targets": 4}],
        ["electric", {"targets": 8, "chasers": 1}],
        ["electric", {"targets": 8, "chasers": 2}],
    ]
    for method in dict.fromkeys((*names(PLANNERS), *names(BOUNDS))):
        groups = [group for group in (PLANNERS, BOUNDS) if method in names(group)]
        able = spec_of(method, groups[0])
        carries = several if "tows" in able.follows else []
        fields = [*one, *(several[:1] if able.several else []), *carries]
        ran = subprocess.run(
            [sys.executable, "-c", where + PLANS, " ".join([method, *groups]), json.dumps(fields)],
            capture_output=True,
            text=True,
            env=os.environ | {VARIABLE: str(tmp_path / "kept"), "PYTHONPATH": str(ROOT)},
        )
        assert ran.returncode == 0, (method, ran.stderr[-2000:])
        assert json.loads(ran.stdout.splitlines()[-1]) == [[], []], method


def test_the_wheel_installs_what_it_needs(archives: Archives, tmp_path: Path) -> None:
    """With what pip finds a mission is planned in an empty environment, by `auto` too."""
    constraints = ("--constraint", str(ROOT / "constraints.txt"))
    programs = environment(tmp_path / "venv", archives.wheel, *constraints)
    mission([str(programs / "adr-opt")], tmp_path)
    run([str(programs / "adr-opt"), "solve", "tiny.json", "--time-limit", "2"], tmp_path)
