"""The Python of the pages runs as it stands and prints what they say."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path
from typing import Any

import pytest
from conftest import Cli
from pages import ROOT, in_a_small_world, read
from rated_fields import pairs_text, rated, worths_of_sets

from adr_opt.plan import plan
from adr_opt.problem import instance


def test_the_first_example_of_each_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The Python of the quick start and of the page on Python runs as it stands."""
    monkeypatch.chdir(tmp_path)
    for page in ("docs/index.md", "docs/api.md"):
        for code in re.findall(r"```python\n(.*?)```", read(page), re.DOTALL):
            exec(code, {})
    assert plan.load_plan("plan.json").legs


@pytest.mark.slow
def test_the_page_on_campaigns_runs(
    cli: Cli, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its commands, on fewer targets, plan a campaign that passes; its Python does as it stands.

    The chasers that it shows as a file are an instance's.
    """
    for package in ("boinor", "plotly"):
        pytest.importorskip(package)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    page = re.sub(r"\\\n\s*", "", read("docs/campaigns.md"))
    blocks = re.findall(r"(?m)^    python -m adr_opt .*$", page)
    verbs = [shlex.split(line)[3] for line in blocks]
    assert verbs[:4] == ["generate", "solve", "check", "generate"]
    assert set(verbs[4:8]) == {"generate", "import"}
    assert set(verbs[8:]) == {"fly", "refine", "report", "export"}
    for line in blocks:
        words = in_a_small_world(line.strip())
        if words[0] == "generate":
            words[1] = shlex.split(line)[4]
            words += ["--targets", "12"]
        outcome = cli(*words)
        assert outcome.status == 0, (line, outcome.err)
    drawn = instance.load("my.json")
    assert (len(drawn.chasers), len(drawn.stations)) == (2, 2)
    shown = re.search(r"```json\n(.*?)```", page, re.DOTALL)
    assert shown is not None
    content = json.loads(drawn.to_json()) | json.loads(f"{{{shown[1]}}}")
    assert [each.name for each in instance.Instance.from_json(json.dumps(content)).chasers] == [
        "first",
        "late",
    ]
    (code,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    capsys.readouterr()
    exec(code, {})
    first, second, last = capsys.readouterr().out.splitlines()
    assert first.startswith("chaser-1 ['debris-")
    assert second.startswith("late ['debris-")
    assert last.endswith(" optimal ()")


@pytest.mark.parametrize("page", ["waiting", "checking-a-proof"])
def test_what_a_page_says_that_its_python_prints(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each block of Python on the page prints what the page says that it prints, if anything."""
    (tmp_path / "instances").symlink_to(ROOT / "instances")
    monkeypatch.chdir(tmp_path)
    block = r"```python\n(.*?)```\n(?:\nprints\n\n```text\n(.*?)```)?"
    pairs = re.findall(block, read(f"docs/{page}.md"), re.DOTALL)
    assert len(pairs) == 3
    names: dict[str, Any] = {}
    for code, printed in pairs:
        exec(code, names)
        assert capsys.readouterr().out == printed


def test_the_page_on_designs_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its Python runs on a smaller campaign: the set of the best design is worth what it says."""
    field = rated(targets=2)
    field.save(tmp_path / "base.json")
    (tmp_path / "pairs.json").write_text(pairs_text(worths_of_sets(field)), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    (code,) = re.findall(r"```python\n(.*?)```", read("docs/designs.md"), re.DOTALL)
    kits = "kits=4,8"
    assert kits in code
    exec(code.replace(kits, "kits=1,2"), {})
    first, again = capsys.readouterr().out.splitlines()
    floor, worth, bound, euros = map(float, first.split())
    assert 0.0 < floor <= worth <= bound
    assert euros > 20e6
    assert float(again) == worth


@pytest.mark.slow
def test_what_the_page_on_given_costs_prints(capsys: pytest.CaptureFixture[str]) -> None:
    """The Lambert arcs of the page are planned as it says."""
    pytest.importorskip("boinor")
    page = read("docs/given-costs.md")
    ((code, printed),) = re.findall(
        r"```python\n(.*?)```\n\nprints\n\n```text\n(.*?)```", page, re.DOTALL
    )
    exec(code, {})
    assert capsys.readouterr().out == printed


def test_the_environment_of_the_readme_runs() -> None:
    """The environment in five lines runs, with fewer fields to draw from."""
    pytest.importorskip("gymnasium")
    code = re.search(r"```python\n(import gymnasium.*?)```", read("README.md"), re.DOTALL)
    assert code is not None
    names: dict = {}
    whole = 'make("adr_opt/Mission-v0")'
    assert whole in code[1]
    exec(code[1].replace(whole, whole.replace(")", ", pool=4)")), names)
    assert names["reward"] in (0.0, 1.0)


def test_the_example_of_the_readme_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first Python example of the README runs as it stands."""
    (tmp_path / "instances").symlink_to(ROOT / "instances")
    monkeypatch.chdir(tmp_path)
    code = re.search(r"```python\n(.*?)```", read("README.md"), re.DOTALL)
    assert code is not None
    names: dict = {}
    exec(code[1], names)
    assert names["result"].objective > 0.0
    assert names["matrices"].delta_v.shape == (3, 51, 51)
    assert (tmp_path / "plan.json").is_file()
