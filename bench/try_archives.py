"""Install the wheel and the source archive outside the checkout, and use both as users do.

    python bench/wheel.py --out dist
    python bench/try_archives.py dist

Looks at the content of both; installs each in an empty environment, with the versions of
``constraints.txt`` and no extras; plans, checks and examines there, with nothing compiled yet; then
adds the extras ``serve`` and ``viz``, writes a report, starts the page, and lets mypy read the
types. Prints a line for each step with its time, and ends with 1 if one has failed.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tarfile
import tempfile
import time
import urllib.request
import zipfile
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

from machine import heading

ROOT = Path(__file__).resolve().parents[1]
NOMINAL = ROOT / "instances/nominal/nominal-000.json"
PIP = ("-m", "pip", "--quiet", "--disable-pip-version-check")

WHEEL = re.compile(r"(adr_opt|solvers|adr_opt-[0-9.]+\.dist-info)/.*")
SOURCE = re.compile(
    r"adr_opt-[0-9.]+(|/((adr_opt|solvers|adr_opt\.egg-info)(/.*)?"
    r"|LICENSE|README\.md|pyproject\.toml|setup\.cfg|PKG-INFO))"
)
FOREIGN = re.compile(r"(^|/)(tests?|__pycache__|\.[a-z_]+)(/|$)|\.(pyc|nbi|nbc|log)$")

TYPED = """
import adr_opt

found: adr_opt.Result = adr_opt.solve(adr_opt.generate("tiny", seed=0), method="greedy")
plan: adr_opt.Plan | None = found.plan
wrong: int = adr_opt.__version__
"""


class Failed(Exception):
    """A step that did not do what it should."""


def main() -> int:
    """Try both."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path, help="where wheel and source archive are")
    folder = parser.parse_args().folder.resolve()
    print(heading())
    (wheel,), (source,) = folder.glob("*.whl"), folder.glob("*.tar.gz")
    print("| step | result | time |\n|---|---|---|")
    good = [
        step("content of the wheel", lambda: content_of_wheel(wheel)),
        step("content of the source archive", lambda: content_of_source(source)),
        step("twine check", lambda: twine(wheel, source)),
    ]
    for archive in (wheel, source):
        with tempfile.TemporaryDirectory() as place:
            good += tried(archive, Path(place))
    return 0 if all(good) else 1


def step(name: str, do: Callable[[], str]) -> bool:
    """Do one, and print what came of it."""
    began = time.perf_counter()
    try:
        said = do()
    except Failed as failure:
        said = f"FAILED: {failure}"
    print(f"| {name} | {said} | {time.perf_counter() - began:.1f} s |", flush=True)
    return not said.startswith("FAILED")


def content_of_wheel(file: Path) -> str:
    """Only the packages and their metadata, with types, licence and kernels."""
    with zipfile.ZipFile(file) as opened:
        names = opened.namelist()
    for wanted in (r"adr_opt/py\.typed", r".*dist-info/(licenses/)?LICENSE", r".*/compiled\.zip"):
        if not any(re.fullmatch(wanted, name) for name in names):
            raise Failed(f"nothing like {wanted}")
    return _of_ours(file, names, WHEEL)


def content_of_source(file: Path) -> str:
    """Only the packages, their metadata and the licence."""
    with tarfile.open(file) as opened:
        names = opened.getnames()
    if not any(name.endswith("/LICENSE") for name in names):
        raise Failed("no licence")
    return _of_ours(file, names, SOURCE)


def _of_ours(file: Path, names: list[str], ours: re.Pattern[str]) -> str:
    others = [name for name in names if not ours.fullmatch(name) or FOREIGN.search(name)]
    if others:
        raise Failed(f"foreign files: {', '.join(others[:5])}")
    return f"{len(names)} names, {file.stat().st_size / 1e6:.1f} MB"


def twine(*files: Path) -> str:
    """Metadata that an index takes."""
    if find_spec("twine") is None:
        return "skipped: twine is not installed"
    return last(call([sys.executable, "-m", "twine", "check", "--strict", *map(str, files)], ROOT))


def tried(archive: Path, place: Path) -> list[bool]:
    """Install an archive in a folder and use it."""
    python, kind = place / "venv/bin/python", archive.name.partition("-")[2]
    program = str(place / "venv/bin/adr-opt")

    def install() -> str:
        call([sys.executable, "-m", "venv", str(place / "venv")], place)
        call([str(python), *PIP, "install", *_constrained(), str(archive)], place)
        return last(call([program, "--version"], place))

    def plan() -> str:
        words = ["solve", str(NOMINAL), "--time-limit", "10", "--out", "plan.json"]
        said = call([str(python), "-m", "adr_opt", *words], place)
        return next(line for line in said.splitlines() if line.startswith("visits"))

    def extras() -> str:
        call([str(python), *PIP, "install", *_constrained(), f"{archive}[serve,viz]"], place)
        return last(call([str(python), "-m", "pip", "check"], place))

    def report() -> str:
        call([program, "report", str(NOMINAL), "plan.json", "--out", "mission.html"], place)
        return f"{(place / 'mission.html').stat().st_size / 1e6:.1f} MB"

    return [
        step(f"{kind}: install", install),
        step("pip check", lambda: last(call([str(python), "-m", "pip", "check"], place))),
        step("first solve", plan),
        step("check", lambda: last(call([program, "check", str(NOMINAL), "plan.json"], place))),
        step("doctor", lambda: examined(program, place)),
        step("extras serve, viz", extras),
        step("report", report),
        step("serve", lambda: served(program, place)),
        step("types", lambda: typed(python, place)),
    ]


def _constrained() -> list[str]:
    return ["--constraint", str(ROOT / "constraints.txt")]


def examined(program: str, place: Path) -> str:
    """All methods of the entry points are loaded, and nothing is wrong."""
    found = json.loads(call([program, "doctor", "--json"], place))
    if found["problems"]:
        raise Failed(found["problems"][0])
    return f"{len(found['planners'])} planners, {len(found['bounds'])} bounds"


def served(program: str, place: Path) -> str:
    """The page starts, answers at the address that it prints, and ends when asked."""
    with subprocess.Popen(
        [program, "serve", str(NOMINAL), "--no-open"],
        cwd=place,
        env=_alone(place),
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    ) as page:
        try:
            said = ""
            while page.stdout is not None and (line := page.stdout.readline()):
                said += line
                found = re.search(r"http://127\.0\.0\.1:\d+/\S*", line)
                if found is not None:
                    with urllib.request.urlopen(found[0], timeout=60.0) as answer:
                        return f"status {answer.status}, {len(answer.read()) / 1e6:.1f} MB"
            raise Failed(said[-300:].replace("\n", " "))
        finally:
            page.terminate()
            try:
                page.communicate(timeout=60.0)
            except subprocess.TimeoutExpired:
                page.kill()


def typed(python: Path, place: Path) -> str:
    """A checker of types sees those of the installation: of three lines one is wrong."""
    (place / "program.py").write_text(TYPED, encoding="utf-8")
    if find_spec("mypy") is None:
        return "skipped: mypy is not installed"
    mypy = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(place / "types")]
    ran = subprocess.run(
        [*mypy, "--python-executable", str(python), "program.py"],
        cwd=place,
        env=_alone(place),
        capture_output=True,
        text=True,
    )
    wrong = [line for line in ran.stdout.splitlines() if ": error:" in line]
    if len(wrong) != 1 or "program.py:6" not in wrong[0]:
        raise Failed(ran.stdout[-300:].replace("\n", " ") + ran.stderr[-300:])
    return "as stated"


def call(command: list[str], place: Path) -> str:
    """Run a program that sees nothing of the checkout; what it prints."""
    ran = subprocess.run(command, cwd=place, env=_alone(place), capture_output=True, text=True)
    if ran.returncode != 0:
        raise Failed(f"{' '.join(command[:4])} …: {(ran.stdout + ran.stderr)[-400:]}")
    return ran.stdout


def _alone(place: Path) -> dict[str, str]:
    """The environment of this process, without what points to a checkout or its kernels."""
    kept = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")}
    return kept | {"ADR_OPT_CACHE_DIR": str(place / "kernels")}


def last(said: str) -> str:
    """The last line."""
    return said.strip().splitlines()[-1] if said.strip() else ""


if __name__ == "__main__":
    sys.exit(main())
