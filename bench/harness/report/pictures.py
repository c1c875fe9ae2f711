"""The same two figures as PNG files, for papers and slides."""

from __future__ import annotations

from pathlib import Path

from .charts import SYMBOLS, colour, with_visits
from .model import Section
from .statistics import field_means

MARKERS = dict(zip(SYMBOLS, "osD^PX*p", strict=True))


def draw(section: Section, labels: dict[str, str], folder: Path) -> list[Path]:
    """Write ``visits-…png`` and ``time-…png``; their paths."""
    from matplotlib.figure import Figure

    written = []
    for kind, title in (("visits", "targets visited"), ("time", "planning time [s]")):
        # Not pyplot: no window system, no global state.
        figure = Figure(figsize=(8.0, 4.5), layout="constrained")
        axes = figure.add_subplot()
        for number, method in enumerate(section.rows):
            values = section.visits(method) if kind == "visits" else section.seconds(method)
            means = field_means(values)
            axes.plot(
                list(means),
                list(means.values()),
                color=colour(number),
                markersize=4,
                marker=MARKERS[SYMBOLS[number % len(SYMBOLS)]],
                linewidth=0.7,
                label=labels[method] if kind == "visits" else with_visits(section, method, labels),
            )
        if kind == "visits" and section.bounds:
            means = field_means({(f, i, 0): bound for (f, i), bound in section.bounds.items()})
            axes.plot(list(means), list(means.values()), "k:", linewidth=1.2, label="proven bound")
        if kind == "time":
            axes.set_yscale("log")
        axes.set(xlabel="test case (field)", ylabel=title, title=section.title)
        axes.grid(color="#e5e7eb")
        axes.legend(fontsize=8, ncols=2, framealpha=0.8)
        path = folder / f"{kind}-{section.stem}.png"
        figure.savefig(path, dpi=150)
        written.append(path)
    return written
