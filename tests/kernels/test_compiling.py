"""Compiled kernels: where they are kept, when they are used again, and that limits wait."""

from __future__ import annotations

import errno
import gc
import importlib
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from compiled_kernels import LISTEN

import adr_opt
from adr_opt.common.clock import now_s
from adr_opt.kernels.core import archive
from adr_opt.kernels.core import cache as kernel_cache
from adr_opt.kernels.core import compile as compiled
from adr_opt.kernels.core.compile import compiling_s, is_compiling, kernel
from adr_opt.run.methods import BOUNDS, PLANNERS, names
from adr_opt.ui.cli.entry import main

ROOT = Path(__file__).parents[2]
NOMINAL = ROOT / "instances" / "nominal" / "nominal-000.json"

LOW = """
from adr_opt.kernels.core.compile import kernel
FACTOR = {factor}
OTHER = {other}
@kernel
def scaled(x):
    {comment}
    return FACTOR * x
"""
HIGH = """
from adr_opt.kernels.core.compile import kernel
import {low} as low
@kernel
def shifted(x):
    return low.scaled(x) + {shift}
"""
RUN = """
import sys
sys.path.insert(0, {folder!r})
import {high} as high
from adr_opt.kernels.core.compile import compiling_s
print(high.shifted(2.0), compiling_s() > 0.0)
"""


def write_pair(
    folder: Path, *, factor: float = 3.0, other: int = 0, comment: str = "pass", shift: float = 1.0
) -> None:
    """Two modules: a kernel, and one that calls it."""
    low = LOW.format(factor=factor, other=other, comment=comment)
    (folder / "pair_low.py").write_text(low)
    (folder / "pair_high.py").write_text(HIGH.format(low="pair_low", shift=shift))


def run_pair(folder: Path, cache_dir: Path) -> str:
    """What a process says that calls them: the value, and whether it had to compile."""
    return python(RUN.format(folder=str(folder), high="pair_high"), cache_dir)


def python(code: str, cache_dir: Path | None = None) -> str:
    """Standard output of a process that keeps its kernels in a folder, the user's by default."""
    variables = {} if cache_dir is None else {"ADR_OPT_CACHE_DIR": str(cache_dir)}
    ran = subprocess.run(
        [sys.executable, "-B", "-c", code],
        capture_output=True,
        check=False,
        text=True,
        cwd=ROOT,
        env=os.environ | variables,
    )
    assert ran.returncode == 0, ran.stderr
    return ran.stdout.strip()


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder for kernels."""
    kept = tmp_path / "kept"
    monkeypatch.setenv(kernel_cache.VARIABLE, str(kept))
    monkeypatch.setattr(kernel_cache, "_troubles", [])
    monkeypatch.setattr(kernel_cache, "_is_pruned", False)
    return kept


def doubling() -> Any:
    """A kernel that nothing has been compiled of yet."""

    @kernel
    def double(x):
        return 2.0 * x

    return double


def test_kernel_is_compiled_once_and_again_when_what_it_calls_has_changed(tmp_path: Path) -> None:
    """A second process compiles nothing; a change in another file it calls is never overlooked."""
    kept = tmp_path / "kept"
    write_pair(tmp_path)
    assert run_pair(tmp_path, kept) == "7.0 True"
    assert run_pair(tmp_path, kept) == "7.0 False"
    write_pair(tmp_path, factor=5.0)
    assert run_pair(tmp_path, kept) == "11.0 True"
    write_pair(tmp_path, factor=3.0)
    assert run_pair(tmp_path, kept) == "7.0 False"
    assert not [path for path in tmp_path.rglob("*.nb*") if path.is_file()]
    assert {path.suffix for path in kept.iterdir()} == {".kernel"}


@pytest.mark.parametrize(
    ("change", "matters"),
    [
        ({"comment": "pass  # a comment"}, False),
        ({"other": 1}, False),
        ({"factor": 4.0}, True),
        ({"comment": "x = x + 0.0"}, True),
        ({"shift": 2.0}, True),
    ],
)
def test_only_changes_that_a_kernel_can_reach_compile_it_anew(
    change: dict[str, Any], matters: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Code and constants that a kernel uses count; comments and what it does not use do not."""
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)

    def digest() -> str:
        for name in ("pair_low", "pair_high"):
            sys.modules.pop(name, None)
        importlib.invalidate_caches()
        high: ModuleType = importlib.import_module("pair_high")
        return kernel_cache.sources(high.shifted)

    write_pair(tmp_path)
    before = digest()
    write_pair(tmp_path, **change)
    assert (digest() != before) == matters


def test_kernels_of_the_rules_follow_the_orbits() -> None:
    """What fills a timetable, or asks for rows, is compiled anew when the orbits change.

    What only reads a timetable is not.
    """
    from adr_opt.kernels.orbits import ephemeris
    from adr_opt.kernels.rules import rules
    from adr_opt.kernels.tables import timetable, timetable_making

    def digests() -> list[str]:
        kernels = timetable_making.fill, rules.replay, timetable.transfer_exists
        return [kernel_cache.sources(each) for each in kernels]

    before = digests()
    given = ephemeris.COPLANAR_RAD
    ephemeris.COPLANAR_RAD = 2.0 * given
    try:
        after = digests()
    finally:
        ephemeris.COPLANAR_RAD = given
    assert after[0] != before[0]
    assert after[1] != before[1]
    assert after[2] == before[2]


@pytest.mark.parametrize("damage", [b"", b"garbage", None])
def test_damaged_file_is_compiled_anew_and_replaced(damage: bytes | None, folder: Path) -> None:
    """Whatever stands in a file of the folder, the kernel works and the file is mended."""
    assert doubling()(2.0) == 4.0
    (path,) = folder.iterdir()
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2] if damage is None else damage)
    began = compiling_s()
    assert doubling()(2.0) == 4.0
    assert compiling_s() > began
    began = compiling_s()
    assert doubling()(2.0) == 4.0
    assert compiling_s() == began


@pytest.fixture
def archive_of(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[], None]]:
    """Move what the folder has to the archive of this installation, for this processor."""

    def move() -> None:
        found = {path.name: path.read_bytes()[32:] for path in folder.iterdir()}
        archive.write(found, folder.parent / "compiled.zip")
        shutil.rmtree(folder)
        archive.is_usable.cache_clear()
        archive._opened.cache_clear()

    monkeypatch.setattr(archive, "FILE", folder.parent / "compiled.zip")
    monkeypatch.setattr(archive, "processor", lambda own: own)
    yield move
    archive.is_usable.cache_clear()
    archive._opened.cache_clear()


needs_level = pytest.mark.skipif(
    not archive.serves_this_processor(), reason="no archive is for this processor"
)


@needs_level
def test_kernel_of_the_archive_is_not_compiled(
    folder: Path, archive_of: Callable[[], None]
) -> None:
    """What the archive has is neither compiled nor written to the folder."""
    assert doubling()(2.0) == 4.0
    archive_of()
    began = compiling_s()
    assert doubling()(2.0) == 4.0
    assert compiling_s() == began
    assert not folder.exists()


@needs_level
@pytest.mark.parametrize("damage", ["garbage", "other kernels", "gone", "old processor"])
def test_kernel_is_compiled_where_the_archive_is_of_no_use(
    damage: str, folder: Path, archive_of: Callable[[], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A damaged or missing archive, or one for other processors, costs compiling, nothing else."""
    assert doubling()(2.0) == 4.0
    archive_of()
    if damage == "garbage":
        archive.FILE.write_bytes(b"garbage")
    elif damage == "gone":
        archive.FILE.unlink()
    elif damage == "other kernels":
        archive.write({"other.kernel": b"x"}, archive.FILE)
    else:
        monkeypatch.setattr(archive, "FEATURES", ("avx2", "such-as-no-processor-has"))
    began = compiling_s()
    assert doubling()(2.0) == 4.0
    assert compiling_s() > began
    assert len(list(folder.iterdir())) == 1


def test_limits_and_garbage_collection_stand_still_while_compiling(folder: Path) -> None:
    """Compiling counts for no limit, and garbage is collected again afterwards."""
    clock, made_s = time.perf_counter, compiled._made_now.seconds
    before, made, outer, clock_began, inner = compiling_s(), made_s(), clock(), now_s(), clock()
    assert doubling()(2.0) == 4.0
    inner, counted, outer = clock() - inner, now_s() - clock_began, clock() - outer
    made = made_s() - made
    assert made > compiling_s() - before > 0.0
    assert inner - 1e-6 <= counted + made <= outer + 1e-6
    assert gc.isenabled()
    assert not is_compiling()


def test_kernels_work_where_they_cannot_be_kept(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A folder that cannot be made or written costs compiling, and nothing else."""
    folder.write_text("a file is in the way")
    assert doubling()(2.0) == 4.0
    assert "kept" in str(kernel_cache.trouble())


def test_full_disk_is_named_by_its_folder(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    """A full disk under the folder is said in one sentence that names it, and a plan comes out."""

    def full(path: Path, content: bytes) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    tiny = tmp_path / "tiny.json"
    assert main(["generate", "tiny", "--seed", "0", "--out", str(tiny)]) == 0
    monkeypatch.setattr(kernel_cache.Path, "write_bytes", full)
    assert doubling()(2.0) == 4.0
    assert main(["solve", str(tiny), "--method", "greedy"]) == 0
    said = capsys.readouterr().err
    assert f"compiled kernels cannot be kept: {folder}: No space left on device" in said


def test_who_cannot_write_to_the_home_uses_a_folder_that_only_he_can_write_to(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After the usual folder comes a temporary one; never one that others may write to."""
    monkeypatch.delenv(kernel_cache.VARIABLE, raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    monkeypatch.setattr(kernel_cache.tempfile, "tempdir", str(tmp_path))
    usual, temporary = kernel_cache.folders()
    assert usual == tmp_path / "home" / "adr-opt"
    assert temporary.parent == tmp_path
    (tmp_path / "home").write_text("in the way")
    assert doubling()(2.0) == 4.0
    assert len(list(temporary.iterdir())) == 1
    temporary.chmod(0o777)
    assert kernel_cache.folders() == [usual]


@pytest.mark.slow
def test_two_processes_that_compile_at_once(tmp_path: Path) -> None:
    """Two cold processes both answer rightly, and leave what a third one can use."""
    write_pair(tmp_path)
    kept = tmp_path / "kept"
    with ThreadPoolExecutor(2) as pool:
        said = list(pool.map(lambda _: run_pair(tmp_path, kept), range(2)))
    assert {line.split()[0] for line in said} == {"7.0"}
    assert run_pair(tmp_path, kept) == "7.0 False"


def test_folder_does_not_grow_for_ever(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where files take too much room, those that were not used for longest go."""
    folder.mkdir()
    for age in range(10):
        path = folder / f"old-{age}.kernel"
        path.write_bytes(b"x" * 100_000)
        os.utime(path, (1e9 - age, 1e9 - age))
    monkeypatch.setattr(kernel_cache, "MOST_BYTES", 800_000)
    assert doubling()(2.0) == 4.0
    left = {path.name for path in folder.iterdir()}
    assert {name for name in left if name.startswith("old")} == {
        f"old-{age}.kernel" for age in (0, 1, 2)
    }
    assert len(left) == 4


def test_kernels_take_each_other_s_numbers_without_being_compiled_for_each(folder: Path) -> None:
    """Integers of any width, written out or not, are one type to a kernel called by a kernel."""
    inner = doubling()

    @kernel
    def outer(numbers):
        return inner(0) + inner(1) + inner(numbers[0]) + inner(numbers.size)

    assert outer(np.array([3], dtype=np.int32)) == 10.0
    assert len(list(folder.glob("*double*"))) == 1


@pytest.mark.parametrize("python_first", [True, False])
def test_kernel_answers_python_and_another_kernel(folder: Path, python_first: bool) -> None:
    """Whichever calls a kernel first, both get the answer; Python's own serves a kernel too."""
    inner = doubling()

    @kernel
    def outer(number):
        return inner(number) + 1

    calls = [lambda: inner(3) == 6, lambda: outer(3) == 7]
    assert all(call() for call in (calls if python_first else calls[::-1]))
    assert len(list(folder.glob("*double*"))) == (1 if python_first else 2)


PRACTISED = f"""{LISTEN}
import json, sys
import adr_opt
from adr_opt.run import front
group, method, path, limit = sys.argv[1:]
problem = front.warm_up(group, method)
listen()
front.run(group, adr_opt.load(path), method, front.RunOptions(float(limit)))
print(json.dumps([problem and str(problem), compiled]))
"""

QUICK = ("beam",)
METHODS = [
    pytest.param(group, method, marks=() if method in QUICK else pytest.mark.slow)
    for group in (PLANNERS, BOUNDS)
    for method in names(group)
]


@pytest.mark.parametrize(("group", "method"), METHODS)
def test_warm_up_compiles_all_that_a_method_calls(group: str, method: str) -> None:
    """A method that is warm compiles nothing on a nominal field."""
    ran = subprocess.run(
        [sys.executable, "-c", PRACTISED, group, method, str(NOMINAL), "3"],
        capture_output=True,
        check=True,
        text=True,
        cwd=ROOT,
    )
    assert json.loads(ran.stdout.splitlines()[-1]) == [None, []]


@pytest.mark.slow
def test_cold_plan_is_the_warm_plan(tmp_path: Path) -> None:
    """With no kernel compiled, a short limit gives the plan that it always gives, and says why."""
    plans, said = [], []
    for _ in range(2):
        ran = subprocess.run(
            [
                sys.executable,
                "-m",
                "adr_opt",
                "solve",
                str(NOMINAL),
                "--method",
                "beam",
                "--time-limit",
                "5",
                "--out",
                str(tmp_path / "plan.json"),
            ],
            capture_output=True,
            check=True,
            text=True,
            cwd=ROOT,
            env=os.environ | {kernel_cache.VARIABLE: str(tmp_path / "kept")},
        )
        plan = adr_opt.load_plan(tmp_path / "plan.json")
        plans.append([(leg.destination, leg.departure_s) for leg in plan.legs])
        said.append("compiling, once" in ran.stderr)
    assert plans[0] == plans[1]
    assert said == [True, False]


def test_warm_up_says_what_it_has_done(capsys: pytest.CaptureFixture[str]) -> None:
    """`warm-up` compiles for the methods named, and says where it keeps what it compiled."""
    assert main(["warm-up", "greedy", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert [row["method"] for row in said["methods"]] == ["(all)", "greedy"]
    assert [row["problem"] for row in said["methods"]] == [None, None]
    assert Path(said["folder"]).is_dir()


@pytest.mark.slow
def test_warm_up_of_all_methods(capsys: pytest.CaptureFixture[str]) -> None:
    """Without a name `warm-up` compiles for every planner and bound, and none has a problem."""
    assert main(["warm-up", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["methods"]
    everything = dict.fromkeys((*names(PLANNERS), *names(BOUNDS), "environment"))
    assert [row["method"] for row in rows] == ["(all)", *everything]
    assert [row["problem"] for row in rows] == [None] * len(rows)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [(["gredy"], "method 'gredy' is unknown; use one of: auto"), (["--jobs", "0"], "must be ≥ 1")],
)
def test_warm_up_refuses_what_there_is_not(
    arguments: list[str], named: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """An unknown method or a wrong number of processes is refused in one sentence."""
    assert main(["warm-up", *arguments]) == 2
    assert named in capsys.readouterr().err
