"""Files of JSON lines: what was cut off is made again, and what is not theirs stays untouched."""

from __future__ import annotations

import json
import resource
from pathlib import Path

import pytest

from adr_opt.common.errors import InputError
from adr_opt.common.lines_file import LinesFile, line_of

HEAD = {"format": "test/1", "of": "naïve"}


def lines_at(path: Path, of: str = "naïve") -> LinesFile:
    """A file of lines of some work."""
    return LinesFile(path, HEAD | {"of": of}, "a file of tests")


def found(path: Path, of: str = "naïve") -> list[int]:
    """The numbers that its lines hold."""
    lines = lines_at(path, of).read(lambda key: f"other {key}")
    return [json.loads(line)["n"] for _, line in lines]


def test_a_file_goes_on_wherever_it_was_cut_off(tmp_path: Path) -> None:
    """After any number of bytes whole lines are read, and the next line makes the file whole."""
    path = tmp_path / "a.jsonl"
    assert found(path) == []
    for number in range(3):
        lines_at(path).append({"n": number})
    content = path.read_bytes()
    assert content.count(b"\n") == 4
    for kept in range(len(content) + 1):
        path.write_bytes(content[:kept])
        before = found(path)
        assert path.read_bytes() == content[:kept]
        assert before == list(range(max(content[:kept].count(b"\n") - 1, 0)))
        for number in range(len(before), 3):
            lines_at(path).append({"n": number})
        assert path.read_bytes() == content


@pytest.mark.parametrize(
    "content", [b"notes", b"notes\n", b"\n", b"\xff\n", b'{"format": "x"}\n', b"[" * 99_999 + b"\n"]
)
def test_other_files_are_refused_and_stay(tmp_path: Path, content: bytes) -> None:
    """A file without the head, even one without the end of a line, is not written to."""
    path = tmp_path / "a.jsonl"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"a\.jsonl: not a file of tests"):
        found(path)
    assert path.read_bytes() == content


def test_a_cut_off_head_of_other_work_is_refused(tmp_path: Path) -> None:
    """The beginning of another head is no file of these lines, and a whole one names its key."""
    path = tmp_path / "a.jsonl"
    path.write_bytes(line_of(HEAD)[:-2])
    with pytest.raises(InputError, match="not a file of tests"):
        found(path, of="else")
    path.write_bytes(line_of(HEAD))
    with pytest.raises(InputError, match="other of"):
        found(path, of="else")


@pytest.mark.parametrize("kept", [0, 40, 60])
def test_a_line_that_cannot_be_written_leaves_nothing(tmp_path: Path, kept: int) -> None:
    """On a full disk nothing of a line is left, and lines before it are."""
    path = tmp_path / "a.jsonl"
    whole = line_of(HEAD) + line_of({"n": 0})
    path.write_bytes((whole + b'{"n":1,"text":"cut off')[:kept])
    before, limits = found(path), resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, limits[1]))
    try:
        with pytest.raises(InputError, match="cannot be written"):
            lines_at(path).append({"n": 1, "text": "x" * 8192})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    left = path.read_bytes()
    assert whole.startswith(left)
    assert found(path) == before


def test_a_number_that_is_not_finite_is_not_written(tmp_path: Path) -> None:
    """JSON has no infinity: such a line is an error of the program, before anything is written."""
    path = tmp_path / "a.jsonl"
    with pytest.raises(ValueError, match="JSON"):
        lines_at(path).append({"n": float("inf")})
    assert not path.exists()
