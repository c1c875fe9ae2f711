"""The folder of benchmarks that others made, as a package to import, and where their data lie."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

BENCH = Path(__file__).parents[1] / "bench"
DATA = Path(os.environ.get("ADR_OPT_EXTERNAL_DATA", "../shared/data"))

sys.path.insert(0, str(BENCH))
try:
    import outside as outside
finally:
    sys.path.remove(str(BENCH))


def external(folder: str) -> list[pytest.MarkDecorator]:
    """The marks of tests that read a folder of data."""
    path = DATA / folder
    missing = f"no folder {path} (ADR_OPT_EXTERNAL_DATA)"
    return [pytest.mark.external, pytest.mark.skipif(not path.is_dir(), reason=missing)]


def broken(tmp_path: Path, source: Path, old: str, new: str, count: int = 1) -> Path:
    """A copy of a file of which a text is something else."""
    text = source.read_text(encoding="utf-8")
    assert old in text
    copy = tmp_path / source.name
    copy.write_text(text.replace(old, new, count), encoding="utf-8")
    return copy
