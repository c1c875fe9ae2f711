"""The tour runs from top to bottom and says what it said when it was committed."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import pytest

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")
for package in ("ipykernel", "matplotlib", "plotly"):
    pytest.importorskip(package)

ROOT = Path(__file__).parents[2]
TOUR, FIVE = ROOT / "examples" / "tour.ipynb", ROOT / "examples" / "five-targets.ipynb"


def said(notebook: Any) -> list[str]:
    """The text that the cells print."""
    return [
        output["text"]
        for cell in notebook.cells
        if cell.cell_type == "code"
        for output in cell.outputs
        if output.output_type == "stream"
    ]


def pictures(notebook: Any) -> int:
    """How many pictures the cells show."""
    return sum(
        "image/png" in output.get("data", {})
        for cell in notebook.cells
        if cell.cell_type == "code"
        for output in cell.outputs
    )


@pytest.mark.slow
def test_the_tour_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every cell runs without an error or a warning, and prints and draws what is committed."""
    # the kernel asks for a place of its own
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    monkeypatch.setenv("JUPYTER_RUNTIME_DIR", str(tmp_path / "runtime"))
    monkeypatch.setenv("PYDEVD_DISABLE_FILE_VALIDATION", "1")
    committed = nbformat.read(TOUR, as_version=4)
    notebook = nbformat.read(TOUR, as_version=4)
    nbformat.validate(notebook)
    client = nbclient.NotebookClient(
        notebook, timeout=600, resources={"metadata": {"path": str(tmp_path)}}
    )
    client.execute()
    size = re.compile(r"[\d.]+ MB")  # of the page, which the version of plotly decides
    assert [size.sub("", text) for text in said(notebook)] == [
        size.sub("", text) for text in said(committed)
    ]
    assert pictures(notebook) == pictures(committed) == 6
    assert os.path.getsize(tmp_path / "mission.html") < 6e6


def test_the_five_targets_are_those_of_the_page() -> None:
    """The notebook has the Python of *Checking a proof*, which a test runs, and what it prints."""
    page = (ROOT / "docs" / "checking-a-proof.md").read_text(encoding="utf-8")
    notebook = nbformat.read(FIVE, as_version=4)
    nbformat.validate(notebook)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    code = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert [cell.source + "\n" for cell in cells] == code
    assert said(notebook) == re.findall(r"```text\n(.*?)```", page, re.DOTALL)


@pytest.mark.parametrize("notebook", [TOUR, FIVE], ids=lambda path: path.stem)
def test_notebooks_are_small_and_name_no_machine(notebook: Path) -> None:
    """A committed notebook stays under a megabyte and holds no path of where it was run."""
    text = notebook.read_text(encoding="utf-8")
    assert len(text) < 1_000_000
    assert "stderr" not in text
    assert not re.search(r"/(home|tmp|usr|work|root)/", text)
