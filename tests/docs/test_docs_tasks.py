"""The pages about tasks: their commands produce what they show."""

from __future__ import annotations

import re
import runpy
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import Cli, Outcome
from pages import ROOT, python_blocks, read

TASKS = sorted(path.stem for path in ROOT.glob("docs/tasks/*.md"))
NEEDED = ("boinor", "gymnasium", "plotly", "pyarrow", "sgp4")

SHORTER = {
    "cloud": {
        "--max-targets 20": "--max-targets 12",
        "cloud.tle --out": "cloud.tle --max-targets 8 --out",
        "fragment-cloud --seed 0": "fragment-cloud --seed 0 --targets 30",
        "--at 2.5": "--at 1.5",
        "--time-limit 60": "--time-limit 2",
    },
    "rocket-bodies": {
        "--duration-days 365": "--duration-days 120",
        "--time-limit 60": "--time-limit 4",
    },
    "campaign": {
        "1461": "60",
        "365": "15",
        "548": "30",
        "--kits 6": "--kits 2",
        "--time-limit 60": "--time-limit 8",
    },
    "chemical-or-electric": {"--time-limit 60": "--time-limit 4", "0.05,0.1,0.4": "0.1,0.4"},
    "own-cost": {},
    "own-policy": {
        "generate nominal": "generate tiny",
        "--time-limit 10": "--time-limit 1",
        "runs/mine/best.npz": str(ROOT / "adr_opt/learning/weights/policy.npz"),
        "MissionVecEnv(256": "MissionVecEnv(4",
        "batch_size=1024": "batch_size=64",
        "learn(1_000_000)": "learn(256)",
    },
}
"""What is put in the place of what in commands and code of a page, so that they take seconds."""

LONG = ("campaign", "chemical-or-electric", "cloud", "own-policy")
"""Take longest even so."""


@pytest.fixture(autouse=True)
def everything_is_there(tmp_path: Path) -> None:
    """The extras that the pages ask for, and the repository's examples in the folder."""
    for package in NEEDED:
        pytest.importorskip(package)
    (tmp_path / "examples").symlink_to(ROOT / "examples")


def steps(page: str) -> Iterator[tuple[str, str]]:
    """What a page has one type, and what it shows, in order: (kind, text)."""
    pattern = r"^```(\w+)\n(.*?)^```$|^    (python -m adr_opt [^\n]*)$"
    page = re.sub(r"\\\n\s*", "", page)  # a backslash at its end goes on with a line
    for found in re.finditer(pattern, page, re.DOTALL | re.MULTILINE):
        language, block, line = found.groups()
        yield ("command", line) if line else (language, block)


def allowed(outcome: Outcome, line: str) -> bool:
    """Done, or a flight, or a page that shows one, that says that a tank breaks."""
    told = outcome.out if " fly " in line else outcome.err if " report " in line else ""
    return outcome.status == 0 or (outcome.status == 1 and "is over by" in told)


def masked(text: str) -> str:
    """A line without its numbers and its blanks."""
    return re.sub(r"[\d.]+(e[+-]?\d+)?", "#", re.sub(r"\s+", " ", text.strip()))


def hold(shown: str, printed: str) -> None:
    """Each line that is shown was printed, but for its numbers; what is proven there, with them."""
    lines = printed.splitlines()
    proven = "(of the model)" in printed or "no plan that keeps back" in printed
    for line in shown.splitlines():
        alike = [each for each in lines if masked(each).startswith(masked(line))]
        assert alike, line
        visits = re.search(r"visits \d+ of \d+", line)
        if visits and proven and not re.search(r"gap (?!0\.0%)", line):
            assert any(visits[0] in each for each in alike), line


def test_every_task_is_tried() -> None:
    """There is a shorter form of each page, and each page has something to type and to see."""
    assert sorted(SHORTER) == TASKS
    for name in TASKS:
        page = read(f"docs/tasks/{name}.md")
        kinds = [kind for kind, _ in steps(page)]
        assert {"command", "text"} <= set(kinds)
        assert page.startswith("# ")
        for part in ("**You have**", "**You want**", "\n## Points to note", "\n## Next questions"):
            assert part in page


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG)) for name in TASKS]
)
def test_the_commands_of_a_task_run(cli: Cli, name: str) -> None:
    """One after the other, on a smaller mission, they do what they say and write their files."""
    page = read(f"docs/tasks/{name}.md")
    code = "\n".join(python_blocks(page))
    for long, short in SHORTER[name].items():
        code = code.replace(long, short)
    exec(code, {})
    for kind, line in steps(page):
        if kind != "command" or " train " in line:
            continue
        for long, short in SHORTER[name].items():
            line = line.replace(long, short)
        words = shlex.split(line)[3:]
        outcome = cli(*words)
        assert allowed(outcome, line), (line, outcome)
        if "--out" in words:
            assert Path(words[words.index("--out") + 1]).stat().st_size > 0


def test_what_the_hand_made_cost_prints(capsys: pytest.CaptureFixture[str]) -> None:
    """The Python of the page prints what the page says, to the letter."""
    page = read("docs/tasks/own-cost.md")
    pairs = re.findall(r"```python\n(.*?)```\n\nprints\n\n```text\n(.*?)```", page, re.DOTALL)
    ((code, printed),) = pairs
    exec(code, {})
    assert capsys.readouterr().out == printed


@pytest.mark.slow
def test_who_follows_the_tasks_to_the_letter_sees_what_they_show(
    cli: Cli, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Every command as it stands prints what is shown; the pictures come of the files it writes."""
    for package in ("matplotlib", "torch"):
        pytest.importorskip(package)
    for name in TASKS:
        printed, names = "", {}
        for kind, text in steps(read(f"docs/tasks/{name}.md")):
            if kind == "command":
                outcome = cli(*shlex.split(text)[3:])
                assert allowed(outcome, text), (text, outcome)
                printed += outcome.out + outcome.err
            elif kind == "python":
                capsys.readouterr()
                exec(text, names)
                printed += capsys.readouterr().out
            elif kind == "text":
                hold(text, printed)
                printed = ""
    drawn = runpy.run_path(str(ROOT / "docs/draw_tasks.py"))["draw"](tmp_path, tmp_path / "drawn")
    committed = sorted(ROOT.glob("docs/pictures/task-*.svg"))
    assert sorted(path.name for path in drawn) == [path.name for path in committed]


def test_the_zone_of_the_page_is_the_one_of_the_file() -> None:
    """The JSON that docs/tasks/cloud.md shows is examples/catalogue/zone.json."""
    (shown,) = re.findall(r"```json\n(.*?)```", read("docs/tasks/cloud.md"), re.DOTALL)
    assert shown == read("examples/catalogue/zone.json")
