"""Additions to mkdocs: pages from the whole repository, its links, and formulas as MathML.

The pages are written to be read on a forge, where a link leads from `docs/` to any file of the
repository. The site keeps such a link where it has its target as a page or as a file to download,
and keeps only its text otherwise. mkdocs.yml names this file under ``hooks``.
"""

from __future__ import annotations

import html
import re
import runpy
from pathlib import Path, PurePosixPath
from posixpath import dirname, normpath, relpath
from typing import Any

from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[1]

PAGES = ("CHANGELOG.md", "CONTRIBUTING.md", "examples/README.md", "instances/README.md")
"""Pages outside docs/, besides those of the families of instances."""

DOWNLOADS = (
    *("examples/*.py", "examples/*.ipynb", "CITATION.cff", "LICENSE"),
    *("adr_opt/judge/verify/closed.py", "adr_opt/judge/verify/completion.py"),
)
"""Files outside docs/ that pages may link to."""

PROSE = 18
"""Characters from which the cell of a table counts as prose."""

CODE = re.compile(r"(^```.*?^```$|`[^`\n]+`)", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\[\]]*\])*)\]\(([^)\s]+)\)")
CELL = re.compile(r"<td(?=[ >])([^>]*)>(.*?)</td>", re.DOTALL)
MATHS = re.compile(
    r'<(?P<tag>div|span) class="arithmatex">(?P<open>\\[\[(])(?P<text>.*?)\\[\])]</(?P=tag)>',
    re.DOTALL,
)


def slug(heading: str, separator: str = "-") -> str:
    """The anchor of a heading, as the forges make it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", separator)


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Name anchors as the forges do, so that one link serves both."""
    config.mdx_configs.setdefault("toc", {})["slugify"] = slug
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages and downloads from outside docs/ under their paths in the repository."""
    families = sorted(path.relative_to(ROOT) for path in ROOT.glob("instances/*/README.md"))
    downloads = sorted(path.relative_to(ROOT) for glob in DOWNLOADS for path in ROOT.glob(glob))
    for path in (*PAGES, *families, *downloads):
        source = str(PurePosixPath(path))
        files.append(File.generated(config, source, abs_src_path=str(ROOT / source)))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Turn links between files of the repository into links between files of the site."""
    here = page.file.src_uri
    if here == "options.md":
        markdown += runpy.run_path(str(ROOT / "docs/list_options.py"))["tables"]()
    outside = page.file.generated_by is not None
    home = dirname(here if outside else f"docs/{here}")

    def moved(match: re.Match[str]) -> str:
        picture, text, link = match[1], match[2], match[3]
        if re.match(r"[a-z]+:|#", link):
            return match[0]
        path, mark, anchor = link.partition("#")
        target = normpath(f"{home}/{path}" if home else path)
        target = "index.md" if target == "README.md" else target.removeprefix("docs/")
        if files.get_file_from_path(target) is None:
            if (ROOT / home / path).exists():
                return text
            return match[0]  # leads nowhere: the strict build says so
        return f"{picture}[{text}]({relpath(target, dirname(here) or '.')}{mark}{anchor})"

    # Code is not looked into: its brackets are no links. A link may hold code, as its text.
    kept: list[str] = []

    def keep(match: re.Match[str]) -> str:
        kept.append(match[0])
        return f"\x00{len(kept) - 1}\x00"

    text = LINK.sub(moved, CODE.sub(keep, markdown))
    return re.sub("\x00(\\d+)\x00", lambda match: kept[int(match[1])], text)


def on_page_content(content: str, **_: Any) -> str:
    """Formulas as MathML, which browsers draw without fonts or scripts; cells of prose marked."""
    return CELL.sub(_marked, MATHS.sub(_mathml, content))


def _marked(match: re.Match[str]) -> str:
    """A cell with a class if it holds prose, so that a phone does not show a word a line."""
    prose = len(re.sub(r"<[^>]*>", "", match[2])) > PROSE
    return f'<td{match[1]} class="prose">{match[2]}</td>' if prose else match[0]


def _mathml(match: re.Match[str]) -> str:
    shown = match["open"] == r"\["
    text = html.unescape(match["text"]).strip()
    # The converter spells operators in italics.
    text = re.sub(r"\\operatorname\{(\w+)\}", r"\\mathrm{\1}", text)
    text = text.replace(r"\mathbb Z", "ℤ")
    # The converter glues the number of an equation to it.
    text = re.sub(r"\\tag\{([\d.]+)\}", r"\\qquad \\text{(\1)}", text)
    drawn = convert(text, display="block" if shown else "inline")
    return f'<div class="formula">{drawn}</div>' if shown else drawn
