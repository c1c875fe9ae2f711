"""The pages of the documentation, taken apart: tables, commands, code and what it prints."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = sorted(
    [
        *ROOT.glob("*.md"),
        *ROOT.glob("docs/**/*.md"),
        *ROOT.glob("*/README.md"),
        *ROOT.glob("instances/*/README.md"),
    ]
)
PLACEHOLDERS = {
    "FAMILY": "nominal",
    "METHOD": "beam",
    "NAME=VALUE": "width=10",
    "N": "1",
    "VERB": "methods",
}
"""Words that stand for something in the commands of the pages, and one thing each stands for."""


def read(path: str) -> str:
    return (ROOT / path).read_text(encoding="utf-8")


def tables(text: str) -> Iterator[tuple[str, list[list[str]]]]:
    """The tables of a page, each with the line of text before it; rows are lists of cells."""
    before, rows = "", []
    for line in [*text.splitlines(), ""]:
        if line.startswith("|"):
            rows.append([cell.strip() for cell in line.strip("|").split(" |")])
        elif rows:
            yield before, rows
            rows = []
        if line and not line.startswith("|"):
            before = line


def commands(text: str) -> Iterator[str]:
    """Every command of a page: lines of code blocks, and code in the text."""
    text = re.sub(r"\\\n\s*", "", text)  # a backslash at its end goes on with a line
    fenced = re.findall(r"^```\w*\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    rest = re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE)
    for block in (*fenced, *re.findall(r"(?m)^    \S.*$", rest)):
        for line in block.splitlines():
            yield line.partition("  #")[0].strip()
    for code in re.findall(r"`([^`]+)`", rest):
        yield " ".join(code.split())


def meant(line: str) -> list[str]:
    """The words of a command, with something in place of each placeholder."""
    return [PLACEHOLDERS.get(word, word) for word in shlex.split(line)]


def in_a_small_world(line: str) -> list[str]:
    """A command of the quick start that takes less time and fewer targets."""
    words = meant(line)[3:]
    if words[0] == "generate":
        words[1] = "tiny"
    if words[0] == "import":
        words += ["--max-targets", "6", "--quiet"]
    if "--time-limit" in words:
        words[words.index("--time-limit") + 1] = "1"
    if "--samples" in words:
        words[words.index("--samples") + 1] = "20"
    if words == ["warm-up"]:
        words.append("greedy")
    return words


def python_blocks(text: str) -> list[str]:
    """The blocks of Python of a page."""
    return re.findall(r"```python\n(.*?)```", text, re.DOTALL)
