"""Draw the rooms of the code as storeys, each on those that it imports.

    python docs/draw_house.py

Storeys are worked out from the imports (``bench/house.py``): a room is one above the highest one
that it opens onto. Arrows that others imply are left out.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import networkx

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "bench"))

import house  # noqa: E402

COLOURS = {"adr_opt": "#3f7fc4", "solvers": "#c07f12"}
INK = "#53606e"
WIDTH, HEIGHT, SPREAD = 1.56, 0.5, 1.8


def storeys(graph: networkx.DiGraph) -> dict[str, int]:
    """Storey of each room, from 1."""
    found: dict[str, int] = {}
    for room in reversed(list(networkx.topological_sort(graph))):
        found[room] = 1 + max((found[below] for below in graph[room]), default=0)
    return found


def main() -> None:
    """Draw and save the picture."""
    rooms = house.by_room(house.imports())
    rooms.pop("adr_opt.__main__", None)
    graph = networkx.DiGraph([(room, below) for room in rooms for below in rooms[room]])
    level = storeys(graph)
    arrows = networkx.transitive_reduction(graph).edges
    place: dict[str, tuple[float, float]] = {}
    for storey in range(1, max(level.values()) + 1):
        here = sorted(room for room in level if level[room] == storey)

        def middle(room: str) -> float:
            below = [place[other][0] for other in graph[room]]
            return sum(below) / len(below) if below else 0.0

        here.sort(key=lambda room: (room.split(".")[0], middle(room)))
        for number, room in enumerate(here):
            place[room] = (SPREAD * (number - 0.5 * (len(here) - 1)), float(storey))
    figure, ax = plt.subplots(figsize=(10.0, 9.0))
    for above, below in arrows:
        (x, y), (to_x, to_y) = place[above], place[below]
        ax.annotate(
            "",
            (to_x, to_y + 0.5 * HEIGHT),
            (x, y - 0.5 * HEIGHT),
            arrowprops={"arrowstyle": "-|>", "color": INK, "alpha": 0.45, "linewidth": 0.9},
        )
    for room, (x, y) in place.items():
        package, name = room.split(".")
        ax.add_patch(
            plt.Rectangle(
                (x - 0.5 * WIDTH, y - 0.5 * HEIGHT), WIDTH, HEIGHT, color=COLOURS[package], zorder=2
            )
        )
        ax.text(x, y, name, color="white", ha="center", va="center", fontsize=10, zorder=3)
    for package, colour in COLOURS.items():
        ax.plot([], [], "s", color=colour, label=package)
    ax.legend(loc="lower right", frameon=False, labelcolor=INK)
    ax.set_axis_off()
    ax.autoscale_view()
    plt.rcParams["svg.hashsalt"] = "house"
    figure.savefig(
        ROOT / "docs/pictures/house.svg",
        bbox_inches="tight",
        metadata={"Date": None},
        transparent=True,
    )


if __name__ == "__main__":
    main()
