"""Draw the diagrams of which-planner.md, campaigns.md and certificates.md.

    python docs/draw_diagrams.py              # into docs/pictures
    python docs/draw_diagrams.py --out DIR

Nothing in them is computed: `choice` is the choice of a planner, `chaser` the states of a chaser,
`relaxation` how a bound counts time and ΔV. Needs the extra ``[viz]``.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from draw_model import FAINT, INK, STYLE, ZONE
from matplotlib.patches import FancyBboxPatch, Rectangle

FOLDER = Path(__file__).with_name("pictures")
BLUE, ORANGE, PALE, WARM, SOFT = "#3f7fc4", "#c07f12", "#e8eff7", "#fdf0e2", "#3d4656"


def sheet(width: float, height: float) -> tuple[Any, Any]:
    """An empty sheet, one unit an inch."""
    figure, ax = plt.subplots(figsize=(width, height))
    figure.subplots_adjust(left=0, right=1, bottom=0, top=1)
    ax.set(xlim=(0, width), ylim=(0, height), aspect="equal")
    ax.axis("off")
    return figure, ax


def box(ax: Any, x: float, y: float, text: str, wide: float = 1.5, fill: str = PALE) -> None:
    """A box about a point, with its text."""
    high = 0.30 + 0.19 * text.count("\n") + 0.12
    ax.add_patch(
        FancyBboxPatch(
            (x - wide / 2, y - high / 2),
            wide,
            high,
            boxstyle="round,pad=0,rounding_size=0.08",
            facecolor=fill,
            edgecolor=INK,
            linewidth=1.0,
            zorder=2,
        )
    )
    ax.text(x, y, text, ha="center", va="center", fontsize=10.5, zorder=3, linespacing=1.25)


def arrow(
    ax: Any,
    start: tuple[float, float],
    end: tuple[float, float],
    text: str = "",
    at: tuple[float, float] = (0.0, 0.0),
    align: str = "center",
    bend: float = 0.0,
) -> None:
    """An arrow with a text near its middle, moved by `at`."""
    ax.annotate(
        "",
        end,
        start,
        arrowprops={
            "arrowstyle": "-|>",
            "color": INK,
            "linewidth": 1.1,
            "shrinkA": 0,
            "shrinkB": 0,
            "connectionstyle": f"arc3,rad={bend}",
        },
    )
    x, y = (start[0] + end[0]) / 2 + at[0], (start[1] + end[1]) / 2 + at[1]
    ax.text(x, y, text, ha=align, va="center", fontsize=9.5, color=SOFT, linespacing=1.2)


def choice() -> Any:
    """Which planner: questions from top to bottom, answers to the right."""
    questions = [
        ("more than one chaser?", "auto"),
        ("thousands of fields?", "greedy-guarded, ppo,\nor a narrow beam"),
        ("a plan in under a second,\nno proof?", "beam"),
        ("a plan to improve?", "local-search --start"),
        ("a proof, whatever it takes?", "auto, then\nexact --start"),
    ]
    figure, ax = sheet(6.2, 4.7)
    y = 4.3
    for number, (question, answer) in enumerate(questions):
        box(ax, 1.8, y, question, 2.7)
        box(ax, 5.0, y, answer, 1.9, WARM)
        arrow(ax, (3.15, y), (4.05, y), "yes", at=(0, 0.11))
        below = y - 0.8
        high = 0.21 + 0.095 * question.count("\n")
        next_high = 0.21 + 0.095 * (
            questions[number + 1][0].count("\n") if number + 1 < len(questions) else 0
        )
        arrow(ax, (1.8, y - high), (1.8, below + next_high), "no", at=(0.2, 0))
        y = below
    box(ax, 1.8, y, "auto", 1.2, WARM)
    return figure


def elbow(ax: Any, points: list[tuple[float, float]], text: str, at: tuple[float, float]) -> None:
    """An arrow along a line with corners, and its text."""
    ax.plot(*zip(*points[:-1], strict=True), color=INK, lw=1.1, zorder=1, solid_joinstyle="miter")
    arrow(ax, points[-2], points[-1])
    ax.text(*at, text, ha="center", va="center", fontsize=9.5, color=SOFT, linespacing=1.2)


def chaser() -> Any:
    """The states of a chaser between its start and its end."""
    figure, ax = sheet(6.2, 5.1)
    box(ax, 0.95, 3.3, "not yet\navailable", 1.3)
    box(ax, 3.1, 3.3, "ready\nat a body", 1.3, WARM)
    box(ax, 5.2, 3.3, "on a leg", 1.3)
    box(ax, 5.2, 4.7, "refuels\nat a station", 1.4)
    box(ax, 5.2, 1.9, "waits for\nthe window", 1.3)
    box(ax, 3.1, 1.9, "services\na target", 1.3)
    box(ax, 3.1, 0.5, "tows it to the\ndisposal orbit", 1.5)
    box(ax, 0.95, 1.9, "done", 1.1)
    arrow(ax, (1.6, 3.4), (2.45, 3.4), "start or\nlaunch", at=(0, 0.24))
    arrow(ax, (3.75, 3.3), (4.55, 3.3), "departs", at=(0, 0.12))
    arrow(ax, (2.6, 3.61), (2.85, 3.61), "waits", at=(-0.4, 0.34), bend=-2.2)
    arrow(
        ax, (5.2, 3.51), (5.2, 4.39), "earned by a target\nsince the last time", (-0.1, 0), "right"
    )
    elbow(ax, [(4.5, 4.7), (3.1, 4.7), (3.1, 3.61)], "tank full", (3.8, 4.84))
    arrow(ax, (4.75, 3.09), (3.6, 2.21), "to a target", (-0.17, 0.12), "right")
    arrow(ax, (5.2, 3.09), (5.2, 2.21), "arrives\nearly", (0.08, 0), "left")
    arrow(ax, (4.55, 1.9), (3.75, 1.9), "opens", (0, 0.12))
    arrow(ax, (2.95, 2.21), (2.95, 2.99), "prize\ncollected", (-0.08, 0), "right")
    arrow(ax, (3.1, 1.59), (3.1, 0.81), "if it is towed", (0.08, 0), "left")
    elbow(
        ax, [(3.85, 0.5), (6.0, 0.5), (6.0, 3.3), (5.85, 3.3)], "the next leg departs", (4.9, 0.64)
    )
    elbow(ax, [(2.35, 0.5), (0.95, 0.5), (0.95, 1.69)], "no further leg", (1.6, 0.64))
    elbow(ax, [(2.45, 3.15), (1.95, 3.15), (1.95, 1.9), (1.5, 1.9)], "no further\nleg", (1.5, 2.5))
    return figure


def relaxation() -> Any:
    """Rows of bodies, buckets of time and slots of ΔV: how walks are counted."""
    figure, ax = sheet(6.2, 4.3)
    left, right, low = 1.15, 6.0, 2.05
    rows = ("station", "debris-1", "debris-2", "debris-3")
    for number, name in enumerate(rows):
        y = low + 0.55 * (3 - number)
        ax.plot([left, right], [y, y], color=FAINT, lw=1.0, zorder=1)
        ax.text(left - 0.08, y, name, ha="right", va="center", fontsize=9.5)
    for k in range(9):
        x = left + k * (right - left) / 8
        ax.plot([x, x], [low - 0.22, low + 1.87], color=FAINT, lw=0.8, ls=(0, (2, 2)), zorder=0)
    ax.text(
        (left + right) / 2,
        low + 2.02,
        "time in buckets: ready at the beginning of a bucket",
        ha="center",
        fontsize=9.5,
    )
    height = {name: low + 0.55 * (3 - number) for number, name in enumerate(rows)}
    walk = [
        ("station", 1.25, "debris-2", 2.2),
        ("debris-2", 2.75, "debris-1", 3.65),
        ("debris-1", 4.05, "debris-2", 5.1),
    ]
    for number, (origin, leaves, destination, arrives) in enumerate(walk):
        again = number == 2
        ax.annotate(
            "",
            (arrives, height[destination]),
            (leaves, height[origin]),
            arrowprops={
                "arrowstyle": "-|>",
                "color": ZONE if again else BLUE,
                "lw": 2.0,
                "ls": "--" if again else "-",
                "shrinkA": 0,
                "shrinkB": 0,
            },
        )
    for name, begin, end in (("debris-2", 2.2, 2.75), ("debris-1", 3.65, 4.05)):
        ax.plot([begin, end], [height[name]] * 2, color=ORANGE, lw=4.0, zorder=2)
    ax.text(
        5.16,
        height["debris-2"] + 0.12,
        "comes back:\npays again",
        fontsize=9.5,
        color=ZONE,
        va="bottom",
    )
    ax.text(
        2.5, height["debris-2"] - 0.18, "stay", fontsize=9.5, color=ORANGE, ha="center", va="center"
    )
    wide, high, y = 0.38, 0.34, 0.75
    slots = [BLUE] * 3 + ["#86b1de"] * 4 + ["#c3cad2"] * 5
    for k, colour in enumerate(slots):
        ax.add_patch(Rectangle((left + k * wide, y), wide - 0.04, high, color=colour))
    ax.text(left - 0.08, y + high / 2, "tank", ha="right", va="center", fontsize=9.5)
    for text, begin, count in (
        ("⌊ΔV of leg 1⌋", 0, 3),
        ("⌊ΔV of leg 2⌋", 3, 4),
        ("left for later legs", 7, 5),
    ):
        ax.text(left + (begin + count / 2) * wide, y - 0.18, text, ha="center", fontsize=9.5)
    ax.text(
        left + 6 * wide,
        y + high + 0.14,
        "ΔV in slots: each leg rounded down",
        ha="center",
        fontsize=9.5,
    )
    legend = "row: a body · bucket: a step of time · slot: a unit of ΔV"
    ax.text(3.1, 0.2, legend, ha="center", fontsize=9.5, color=SOFT)
    return figure


DIAGRAMS = {"choice": choice, "chaser": chaser, "relaxation": relaxation}


def draw(folder: Path) -> list[Path]:
    """Draw all diagrams into a folder; returns the files."""
    files = []
    with plt.rc_context(STYLE):
        for name, make in DIAGRAMS.items():
            figure = make()
            files.append(folder / f"{name}.svg")
            figure.savefig(files[-1], metadata={"Date": None})
            plt.close(figure)
    return files


def main() -> None:
    """Read the options and draw."""
    parser = argparse.ArgumentParser(description="Draw the diagrams of the documentation.")
    parser.add_argument("--out", type=Path, default=FOLDER, help="folder to write to")
    for path in draw(parser.parse_args().out):
        print(path)


if __name__ == "__main__":
    main()
