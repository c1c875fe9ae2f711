"""Paired speed of two commits: short works in turns, each commit in its own warm process.

    python bench/paired_commits.py v0.1.0
    python bench/paired_commits.py OLD NEW --repeats 20 --works exact auto

``NEW`` is the working tree by default. Commits are checked out into temporary worktrees. Each
side has its kernels in a folder of its own, compiled by a process before, and does each work once
(`paired_works.py`) before the clock starts. Then both do each work in turns, and who is first
changes from repeat to repeat. A ratio is that of a pair, one right after the other, so that what
else the machine does concerns both: the table has medians and quartiles of the ratios, by the clock
and of processors. Above 1 the new commit is slower. What did not come out the same is listed, since
times of different work say little.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import tomllib
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from machine import heading

ROOT = Path(__file__).parents[1]
WORKS = Path(__file__).with_name("paired_works.py")
WORKING_TREE = "the working tree"

Row = dict[str, Any]
"""Time and outcome of one work, as answered by the process."""

Rows = dict[str, list[Row]]
"""The same of all repeats, by work."""


class Side:
    """A commit in a process of its own, which does what it is asked for.

    Parameters
    ----------
    tree : Path
        Where the commit is checked out.
    scratch : Path
        An own folder, for kernels and for the entry points of the commit.
    script : Path
        Of the works.
    *options : str
        Its options.

    Raises
    ------
    RuntimeError
        The process ended, or runs other code.
    """

    def __init__(self, tree: Path, scratch: Path, script: Path, *options: str) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-P", str(script), *options],
            env=_surroundings(tree, scratch),
            cwd=scratch,
            text=True,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        greeting = self._answer()
        self.works: list[str] = greeting["works"]
        if not Path(greeting["code"]).resolve().is_relative_to(tree.resolve()):
            raise RuntimeError(f"{greeting['code']} was imported, which is not in {tree}")

    def do(self, work: str) -> Row:
        """Do a work once."""
        assert self._process.stdin is not None
        self._process.stdin.write(work + "\n")
        self._process.stdin.flush()
        return self._answer()

    def _answer(self) -> Row:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError(f"the process of a side ended with status {self._process.wait()}")
        answer: Row = json.loads(line)
        return answer

    def __enter__(self) -> Side:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._process.kill()
        self._process.communicate()


def _surroundings(tree: Path, scratch: Path) -> dict[str, str]:
    """The environment of a process whose code and methods are those of a tree."""
    project = tomllib.loads((tree / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    info = scratch / "installed" / "adr_opt.dist-info"
    info.mkdir(parents=True, exist_ok=True)
    named = f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n"
    (info / "METADATA").write_text(named, encoding="utf-8")
    groups = (
        f"[{group}]\n" + "".join(f"{name} = {where}\n" for name, where in entries.items())
        for group, entries in project["entry-points"].items()
    )
    (info / "entry_points.txt").write_text("\n".join(groups), encoding="utf-8")
    kernels = str(scratch / "kernels")
    return {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(info.parent), str(tree)]),
        "ADR_OPT_CACHE_DIR": kernels,
        "NUMBA_CACHE_DIR": kernels,
    }


@contextmanager
def checked_out(revision: str | None, folder: Path) -> Iterator[Path]:
    """Folder with the files of a revision, for as long as needed."""
    if revision is None:
        yield ROOT
        return
    git = ["git", "-C", str(ROOT), "worktree"]
    subprocess.run([*git, "add", "--quiet", "--detach", str(folder), revision], check=True)
    try:
        yield folder
    finally:
        subprocess.run([*git, "remove", "--force", str(folder)], check=True)


@dataclass(frozen=True)
class Spread:
    """Median and quartiles of the ratios of pairs."""

    median: float
    low: float
    high: float

    @classmethod
    def of(cls, old: Sequence[float], new: Sequence[float]) -> Spread:
        """Spread of the times of repeats, in their order."""
        ratios = [n / o for o, n in zip(old, new, strict=True)]
        low, median, high = statistics.quantiles(ratios, n=4, method="inclusive")
        return cls(median, low, high)

    def __str__(self) -> str:
        return f"{self.median:.3f} | {self.low:.3f}–{self.high:.3f}"


def table_row(work: str, old: Sequence[Row], new: Sequence[Row]) -> str:
    """A row of the table."""
    wall, cpu = (
        [[row[name] for row in side] for side in (old, new)] for name in ("wall_s", "cpu_s")
    )
    medians = " | ".join(f"{1e3 * statistics.median(times):.1f} ms" for times in wall)
    same = "yes" if _outcomes(old) == _outcomes(new) else "**no**"
    return f"| {work} | {medians} | {Spread.of(*wall)} | {Spread.of(*cpu)} | {same} |"


def _outcomes(rows: Sequence[Row]) -> list[str]:
    """All that came out, each once, as text."""
    return sorted({json.dumps(row["outcome"], sort_keys=True) for row in rows})


def measured(sides: Sequence[Side], works: Sequence[str], repeats: int) -> list[Rows]:
    """Time of each side for each work, repeat by repeat."""
    taken: list[Rows] = [defaultdict(list) for _ in sides]
    for repeat in range(repeats):
        for work in works:
            for side in (0, 1) if repeat % 2 == 0 else (1, 0):
                taken[side][work].append(sides[side].do(work))
        print(f"repeat {repeat + 1} of {repeats}", file=sys.stderr)
    return taken


def compare(revisions: Mapping[str, str | None], arguments: argparse.Namespace) -> None:
    """Measure both sides and print the table."""
    tiny = ["--tiny"] if arguments.tiny else []
    with ExitStack() as stack:
        scratch = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="paired-commits-")))
        sides, works = [], list(arguments.works)
        for name, revision in revisions.items():
            tree = stack.enter_context(checked_out(revision, scratch / name / "tree"))
            with Side(tree, scratch / name, WORKS, *tiny) as compiling:
                works = works or compiling.works
                if unknown := sorted(set(works) - set(compiling.works)):
                    known = ", ".join(compiling.works)
                    raise SystemExit(f"no such work: {', '.join(unknown)}; there are {known}")
                for work in works:
                    compiling.do(work)
                    print(f"{name}: {work} is compiled", file=sys.stderr)
            sides.append(stack.enter_context(Side(tree, scratch / name, WORKS, *tiny)))
        for side in sides:
            for work in works:
                side.do(work)
        old, new = measured(sides, works, arguments.repeats)
    print(heading())
    told = [f"{name}: {revision or WORKING_TREE}" for name, revision in revisions.items()]
    print(f"{', '.join(told)}; {arguments.repeats} pairs\n")
    print("| work | old | new | new/old | quartiles | of processors | quartiles | same result |")
    print("|---|---|---|---|---|---|---|---|")
    for work in works:
        print(table_row(work, old[work], new[work]))
    for work in works:
        before, after = _outcomes(old[work]), _outcomes(new[work])
        if before != after:
            print(f"\n{work}, old: {'; '.join(before)}\n{work}, new: {'; '.join(after)}")


def commit_of(revision: str | None) -> str | None:
    """The commit that a revision names."""
    if revision is None:
        return None
    asked = ["git", "-C", str(ROOT), "rev-parse", "--short", "--verify", f"{revision}^{{commit}}"]
    return subprocess.run(asked, check=True, capture_output=True, text=True).stdout.strip()


def main() -> None:
    """Compare two commits."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("old", help="a revision")
    parser.add_argument("new", nargs="?", help=f"another one, by default {WORKING_TREE}")
    parser.add_argument("--repeats", type=int, default=12, help="pairs of each work, at least 2")
    parser.add_argument("--works", nargs="+", default=[], help="by default all")
    parser.add_argument("--tiny", action="store_true", help="on tiny fields, as a trial")
    arguments = parser.parse_args()
    if arguments.repeats < 2:
        parser.error("--repeats: quartiles need 2 or more")
    try:
        revisions = {"old": commit_of(arguments.old), "new": commit_of(arguments.new)}
    except subprocess.CalledProcessError as error:
        parser.error(error.stderr.strip())
    compare(revisions, arguments)


if __name__ == "__main__":
    main()
