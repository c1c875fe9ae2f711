"""Time against quality: what each method collects in what time, the timetable included.

A method that is given more (a wider beam, more simulations, a later limit) is another point of the
same curve; other choices (`preset=tuned`) are another curve of the same colour. Times are those of
processors, so that other work on the machine does not move points to the right; where rows do not
know them, those of the clock.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from adr_opt.common.files import write_text

from .charts import COLOURS, SYMBOLS, Spec, colour
from .model import Section

AMOUNTS = ("width", "simulations", "samples", "beams")
"""Options that say how much is tried, and not what."""

INK, FAINT, PAPER = "#26313d", "#9aa5b1", "#fcfcfa"

# The same bytes for the same drawing.
STYLE = {
    "svg.hashsalt": "adr-opt",
    "svg.fonttype": "path",
    "figure.facecolor": PAPER,
    "savefig.facecolor": PAPER,
    "axes.facecolor": PAPER,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
}


@dataclass(frozen=True)
class Spot:
    """A method with its settings: a point of the chart, and a row of its table.

    Attributes
    ----------
    method : str
        As it was asked for.
    fields : int
    visits, half_width : float
        Mean over fields, and its 95 % interval (NaN of one field).
    proven : int
        Missions whose plan was proven to be optimal, by this method itself.
    seconds : float
        Median over missions: timetable and planning, time of processors [s].
    wall_s : float
        The same by the clock [s].
    bound : float
        Mean over the fields of what is proven that no plan exceeds, NaN where nothing is.
    """

    method: str
    fields: int
    visits: float
    half_width: float
    proven: int
    seconds: float
    wall_s: float
    bound: float

    @property
    def planner(self) -> str:
        """The planner, which has a colour."""
        return self.method.partition("@")[0].partition(":")[0]

    @property
    def options(self) -> dict[str, str]:
        """Its options as text."""
        listed = self.method.rpartition("@")[0].partition(":")[2]
        return dict(pair.split("=", 1) for pair in listed.split(",") if pair)

    @property
    def curve(self) -> str:
        """The planner and what is chosen otherwise than by its amount: the points of one curve."""
        chosen = [f"{name}={text}" for name, text in self.options.items() if name not in AMOUNTS]
        return " ".join([self.planner, *chosen])

    @property
    def amount(self) -> str:
        """Amount of work: widths and numbers, or else its time limit."""
        amounts = [text for name, text in self.options.items() if name in AMOUNTS]
        return ", ".join(amounts) or f"{self.method.rpartition('@')[2]} s"


def spots(section: Section) -> list[Spot]:
    """The points of a section, curve by curve, each in order of time."""
    found = []
    bounds = list(section.bounds.values())
    whole = len(bounds) == len(
        {(row["field"], row["iteration"]) for rows in section.rows.values() for row in rows}
    )
    bound = math.fsum(bounds) / len(bounds) if bounds and whole else math.nan
    for method, rows in section.rows.items():
        means = section.means(method)
        cpu = means.with_timetable_cpu_s
        found.append(
            Spot(
                method,
                means.fields,
                means.visits_mean,
                means.visits_half_width,
                sum(row["status"] == "optimal" for row in rows if row["outcome"] == "legal"),
                cpu if math.isfinite(cpu) else means.with_timetable_median_s,
                means.with_timetable_median_s,
                bound,
            )
        )
    return [spot for curve in curves(found).values() for spot in curve]


def curves(found: Iterable[Spot]) -> dict[str, list[Spot]]:
    """The points of each curve, in order of time; those without a time are left out."""
    by_curve: dict[str, list[Spot]] = {}
    for spot in found:
        if math.isfinite(spot.seconds):
            by_curve.setdefault(spot.curve, []).append(spot)
    return {name: sorted(curve, key=lambda s: s.seconds) for name, curve in by_curve.items()}


def words(curve: list[Spot]) -> list[str]:
    """Labels beside the points of a curve: their differences, and the curve by its end."""
    chosen = curve[0].curve.partition(" ")[2]
    texts = [""] * len(curve)
    if len(curve) > 1:
        default = all(spot.options for spot in curve) or not any(spot.options for spot in curve)
        texts = [spot.amount if spot.options or default else "as it is" for spot in curve]
    if chosen:
        texts[-1] = ", ".join(filter(None, (chosen, texts[-1])))
    return texts


def chart(section: Section, labels: Mapping[str, str]) -> Spec:
    """Visits against time as a Plotly specification."""
    traces: list[Spec] = []
    found = curves(spots(section))
    numbers = _numbers(found)
    for name, curve in found.items():
        number = numbers[curve[0].planner]
        symbol = SYMBOLS[number % len(SYMBOLS)]
        traces.append(
            {
                "type": "scatter",
                "mode": "lines+markers",
                "name": name,
                "x": [spot.seconds for spot in curve],
                "y": [spot.visits for spot in curve],
                "text": [labels.get(spot.method, spot.method) for spot in curve],
                "line": {"color": _ink(number), "width": 1},
                "marker": {"color": _ink(number), "symbol": symbol, "size": 8},
                "hovertemplate": "%{text}: %{y:.2f} visits in %{x:.3g} s<extra></extra>",
            }
        )
    axis: dict[str, Any] = {"gridcolor": "#e5e7eb", "zeroline": False, "automargin": True}
    return {
        "data": traces,
        "layout": {
            "font": {"family": "system-ui, sans-serif", "size": 12, "color": "#1f2937"},
            "margin": {"l": 48, "r": 12, "t": 30, "b": 40},
            "xaxis": {"title": {"text": AXIS}, "type": "log", **axis},
            "yaxis": {"title": {"text": "visits, mean"}, **axis},
            "legend": {"orientation": "h", "y": -0.22, "yanchor": "top", "x": 0},
            "hovermode": "closest",
            "plot_bgcolor": "#ffffff",
            "paper_bgcolor": "#ffffff",
        },
    }


def _numbers(found: Mapping[str, list[Spot]]) -> dict[str, int]:
    """A number for each planner, by which it is coloured."""
    return {
        planner: number
        for number, planner in enumerate(dict.fromkeys(c[0].planner for c in found.values()))
    }


def _ink(number: int) -> str:
    """Colour of a planner; one beyond the palette is dark."""
    return colour(number) if number < len(COLOURS) else INK


AXIS = "time of processors, timetable included [s]"


def draw(found: list[Spot], path: Path, title: str) -> None:
    """Visits against time as a picture; the suffix of the path says of which kind."""
    import matplotlib as mpl
    from matplotlib.figure import Figure
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    from .pictures import MARKERS

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.0, 5.6), layout="constrained")
        axes = figure.add_subplot()
        drawn = curves(found)
        numbers, named = _numbers(drawn), set[str]()
        for curve in drawn.values():
            planner = curve[0].planner
            number = numbers[planner]
            beyond = number >= len(COLOURS)
            axes.plot(
                [spot.seconds for spot in curve],
                [spot.visits for spot in curve],
                label=planner if planner not in named else None,
                color=_ink(number),
                linewidth=1.0,
                marker="v" if beyond else MARKERS[SYMBOLS[number]],
                markersize=5,
            )
            named.add(planner)
            for spot, text in zip(curve, words(curve), strict=True):
                axes.annotate(
                    text,
                    (spot.seconds, spot.visits),
                    xytext=(4, -9),
                    fontsize=7,
                    textcoords="offset points",
                    color=_ink(number),
                )
        bounds = {spot.bound for spot in found if math.isfinite(spot.bound)}
        for bound in sorted(bounds)[:1]:
            axes.axhline(bound, color=INK, linestyle=":", linewidth=1.0)
            axes.annotate(
                f"no plan has more: {bound:.2f}",
                (0.0, bound),
                xytext=(4, 4),
                fontsize=8,
                xycoords=("axes fraction", "data"),
                textcoords="offset points",
            )
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.set(xlabel=AXIS, ylabel="visits, mean", title=title)
        axes.grid(color="#e5e7eb", which="major")
        axes.legend(fontsize=8, loc="lower right", ncols=2)
        figure.savefig(path, dpi=150, metadata={"Date": None} if path.suffix == ".svg" else None)


def write_table(found: list[Spot], path: Path) -> None:
    """The points as CSV."""
    text = io.StringIO()
    table = csv.DictWriter(text, [field.name for field in fields(Spot)], lineterminator="\n")
    table.writeheader()
    for spot in found:
        row = {
            name: f"{value:.6g}" if isinstance(value, float) else value
            for name, value in asdict(spot).items()
        }
        table.writerow(row)
    write_text(path, text.getvalue())


def read_table(path: Path) -> list[Spot]:
    """The points of such a file."""
    kinds = {"str": str, "int": int, "float": float}
    with path.open(encoding="utf-8", newline="") as lines:
        return [
            Spot(**{field.name: kinds[str(field.type)](row[field.name]) for field in fields(Spot)})
            for row in csv.DictReader(lines)
        ]
