"""Compiled kernels are executed, so they are read only from where nobody else can write."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import Cli

from adr_opt.kernels.core import cache

pytestmark = pytest.mark.skipif(os.name != "posix", reason="owners and modes are those of POSIX")

OTHER = 54321
"""Number of another user."""


def named(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(cache.VARIABLE, str(folder))


def usual(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Dirs:
        user_cache_dir = str(folder)

    monkeypatch.delenv(cache.VARIABLE, raising=False)
    monkeypatch.setattr(cache, "AppDirs", lambda *names, **more: Dirs)


def fallback(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    usual(Path("nowhere"), monkeypatch)
    folder.rename(folder.parent / f"adr-opt-{os.getuid()}")
    monkeypatch.setattr(cache.tempfile, "gettempdir", lambda: str(folder.parent))


def kept(folder: Path) -> Path:
    """A whole file in a folder."""
    path = folder / "one.kernel"
    path.write_bytes(hashlib.sha256(b"code").digest() + b"code")
    return path


@pytest.mark.parametrize("place", [named, usual, fallback])
@pytest.mark.parametrize("mode", [0o700, 0o755, 0o775, 0o777, 0o1777])
def test_a_folder_that_others_can_write_to_is_refused(
    place: Callable[[Path, pytest.MonkeyPatch], None],
    mode: int,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Wherever it comes from, it is used where its owner alone can write, and else says why."""
    (folder := tmp_path / "kernels").mkdir()
    folder.chmod(mode)
    place(folder, monkeypatch)
    at = tmp_path / f"adr-opt-{os.getuid()}" if place is fallback else folder
    assert (at in cache.folders()) is (not mode & 0o022)
    assert any("others can write to it" in said for said in cache.refused()) is bool(mode & 0o022)


def test_the_folder_of_another_user_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its owner could write to it, whatever its mode."""
    (folder := tmp_path / "kernels").mkdir(mode=0o700)
    named(folder, monkeypatch)
    assert cache.folders() == [folder]
    status = list(folder.stat())
    status[4] = OTHER
    assert not cache.is_ours(os.stat_result(status))


def test_a_file_that_others_can_write_is_not_read(tmp_path: Path) -> None:
    """Nor is one that was put there while the folder was open."""
    path = kept(tmp_path)
    path.chmod(0o644)
    assert cache.read(path) == b"code"
    path.chmod(0o664)
    assert cache.read(path) is None


def test_nobody_else_can_write_to_what_is_new(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Folder and file are used again, also where the mask of the process lets others write."""
    named(tmp_path / "new" / "kernels", monkeypatch)
    before = os.umask(0)
    try:
        written = cache._write("one.kernel", b"code")
    finally:
        os.umask(before)
    assert written is not None
    assert not written.parent.stat().st_mode & 0o022
    assert cache.read(written) == b"code"


def test_a_refused_folder_is_said(
    cli: Cli, tiny_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`solve` and `doctor` name it, with what to do."""
    (folder := tmp_path / "kernels").mkdir()
    folder.chmod(0o777)
    named(folder, monkeypatch)
    solved = cli("solve", tiny_file, "--method", "greedy", "--time-limit", "5")
    assert solved.status == 0
    assert f"compiled kernels cannot be kept: {folder} (others can write to it" in solved.err
    examined = cli("doctor")
    assert examined.status == 1
    assert f"cannot be kept in {folder} (others can write to it" in examined.out
    assert not list(folder.iterdir())
