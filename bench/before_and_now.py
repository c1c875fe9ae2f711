"""What `auto` collects in how much time: an older commit beside this one, six kinds of missions.

    python bench/before_and_now.py OLD --fields 3 --limits 1 3 10

Each commit plans in a process of its own, with tables of its own that count, by processor time and
on one core. Prizes are shares of the best that either found of a field. Prints the table and draws
docs/pictures/before-and-now.svg.
"""

from __future__ import annotations

import contextlib
import json
import sys
import tempfile
from contextlib import ExitStack
from pathlib import Path
from statistics import fmean
from typing import Any

import adr_opt

HERE = Path(__file__)
PICTURE = HERE.parents[1] / "docs" / "pictures" / "before-and-now.svg"

KINDS: dict[str, dict[str, int]] = {
    "nominal": {},
    "reduced-fuel": {},
    "sso": {},
    "rocket-bodies": {"targets": 30},
    "campaign": {"targets": 40},
    "cloud": {"targets": 40},
}
"""Families, with sizes where their own are others."""

FIRST_SEED = 4400


def answer() -> None:
    """Plan what lines of standard input ask for: family, seed, limit [s], and method."""
    from adr_opt.common.clock import count_processor_time

    count_processor_time()
    answers = sys.stdout
    with contextlib.redirect_stdout(sys.stderr):
        greeting = {"code": adr_opt.__file__, "works": []}
        print(json.dumps(greeting), file=answers, flush=True)
        for line in sys.stdin:
            family, seed, limit, method = line.split()
            instance = adr_opt.generate(family, int(seed), **KINDS[family])
            made = adr_opt.solve(instance, method, time_limit=float(limit), jobs=1)
            legal = made.plan is not None and not adr_opt.check(instance, made.plan)
            print(json.dumps({"prize": made.objective if legal else 0}), file=answers, flush=True)


def compared(
    old: str,
    fields: int = 3,
    limits: tuple[float, ...] = (1.0, 3.0, 10.0),
    method: str = "auto",
    picture: Path = PICTURE,
) -> None:
    """Prizes by kind, commit and limit."""
    from paired_commits import Side, checked_out, commit_of
    from tables import head, row

    seeds = range(FIRST_SEED, FIRST_SEED + fields)
    shares: dict[str, dict[str, list[float]]] = {}
    with ExitStack() as stack:
        scratch = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="before-and-now-")))
        sides = {}
        for name, revision in ((old, commit_of(old)), ("now", None)):
            tree = stack.enter_context(checked_out(revision, scratch / name / "tree"))
            side = stack.enter_context(Side(tree, scratch / name, HERE, "--answer"))
            for kind in KINDS:  # kernels are compiled, which counts as processor time
                side.do(f"{kind} {FIRST_SEED - 1} {max(limits)} {method}")
            sides[name] = side
        head("kind", "fields", "commit", *(f"{limit:g} s" for limit in limits))
        for kind in KINDS:
            found: dict[tuple[str, float], list[float]] = {
                (name, limit): [
                    side.do(f"{kind} {seed} {limit} {method}")["prize"] for seed in seeds
                ]
                for limit in limits
                for name, side in sides.items()
            }
            best = [max(of) for of in zip(*found.values(), strict=True)]
            shares[kind] = {
                name: [
                    fmean(each / most for each, most in zip(found[name, limit], best, strict=True))
                    for limit in limits
                ]
                for name in sides
            }
            for name, told in shares[kind].items():
                row(kind, fields, name, *(f"{100.0 * share:.1f} %" for share in told))
    drawn(shares, limits, picture)


def drawn(shares: dict[str, dict[str, list[float]]], limits: Any, picture: Path) -> None:
    """Draw a panel for each kind."""
    import matplotlib as mpl

    mpl.use("svg")
    from harness.report.quality import FAINT, INK, STYLE
    from matplotlib import pyplot as plt

    with mpl.rc_context(STYLE):
        figure, panels = plt.subplots(2, 3, figsize=(7.4, 4.4), sharex=True, sharey=True)
        for panel, (kind, lines) in zip(panels.flat, shares.items(), strict=True):
            for (name, told), (colour, style) in zip(
                lines.items(), ((FAINT, "s--"), (INK, "o-")), strict=True
            ):
                shown = [100.0 * share for share in told]
                panel.plot(limits, shown, style, color=colour, label=name, ms=4.0)
            panel.set(xscale="log", title=kind)
            panel.set_xticks(limits, [f"{limit:g}" for limit in limits], minor=False)
            panel.minorticks_off()
        for panel in panels[:, 0]:
            panel.set_ylabel("% of the best")
        for panel in panels[1]:
            panel.set_xlabel("processor time [s]")
        panels[0, 0].legend(loc="lower right")
        figure.tight_layout()
        figure.savefig(picture, metadata={"Date": None})
        plt.close(figure)


if __name__ == "__main__":
    if sys.argv[1:] == ["--answer"]:
        answer()
    else:
        from tables import experiment

        sys.exit(experiment(__doc__, compared))
