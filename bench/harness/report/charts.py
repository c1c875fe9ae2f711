"""The two published figures as Plotly specifications (plain data, no Plotly needed)."""

from __future__ import annotations

from typing import Any

from .model import Section
from .published import PUBLISHED
from .statistics import Mission, field_means

# Okabe and Ito's colours, which colour-blind readers can tell apart; black is for the bound.
COLOURS = ("#E69F00", "#56B4E9", "#009E73", "#CC79A7", "#0072B2", "#D55E00", "#8C6D1F", "#7F7F7F")
SYMBOLS = ("circle", "square", "diamond", "triangle-up", "cross", "x", "star", "pentagon")
LONGEST_LINE = 40
"""Fields up to which points are joined; beyond, lines would hide each other."""

Spec = dict[str, Any]


def colour(number: int) -> str:
    """Colour of the method of a number."""
    return COLOURS[number % len(COLOURS)]


def visits(section: Section, labels: dict[str, str]) -> Spec:
    """Visits per test case by method, means over iterations, with the mean proven bound."""
    traces = [
        _trace(number, labels[method], section.visits(method), "%{y:.2f} visits", ".4g")
        for number, method in enumerate(section.rows)
    ]
    if section.bounds:
        means = field_means({(f, i, 0): bound for (f, i), bound in section.bounds.items()})
        traces.append(
            {
                "type": "scatter",
                "mode": "lines",
                "name": "proven bound",
                "x": list(means),
                "y": list(means.values()),
                "line": {"color": "#000000", "dash": "dot", "width": 1.5},
                "hovertemplate": "at most %{y:.2f}<extra>proven bound</extra>",
            }
        )
    bands = [
        _band(text.visits, f"published {text.planner}", section, text.method)
        for text in PUBLISHED.get(section.suite, ())
    ]
    return {"data": traces, "layout": _layout("targets visited", bands)}


def seconds(section: Section, labels: dict[str, str]) -> Spec:
    """Planning time per test case by method, logarithmic, means over iterations."""
    traces = [
        _trace(
            number,
            with_visits(section, method, labels),
            section.seconds(method),
            "%{y:.3g} s",
            ".3g",
        )
        for number, method in enumerate(section.rows)
    ]
    bands: dict[tuple[float, float], Spec] = {}
    for text in PUBLISHED.get(section.suite, ()):
        if text.seconds is not None:
            name = f"published {text.planner}"
            if text.seconds in bands:
                label = bands[text.seconds]["label"]
                label["text"] = f"{label['text']}, {text.planner}"
            else:
                bands[text.seconds] = _band(text.seconds, name, section, None)
    layout = _layout("planning time [s]", list(bands.values()))
    layout["yaxis"] |= {"type": "log", "exponentformat": "power", "dtick": 1}
    return {"data": traces, "layout": layout}


def with_visits(section: Section, method: str, labels: dict[str, str]) -> str:
    """The name of a method with its mean visits: no time stands alone."""
    return f"{labels[method]}, {section.means(method).visits_mean:.2f} visits"


def _trace(number: int, name: str, values: dict[Mission, float], hover: str, form: str) -> Spec:
    means = field_means(values)
    spread: dict[int, list[float]] = {}
    for (field, _, _), value in values.items():
        spread.setdefault(field, []).append(value)
    ranges = [f"{min(spread[f]):{form}}–{max(spread[f]):{form}}" for f in means]
    return {
        "type": "scatter",
        "mode": "lines+markers" if len(means) <= LONGEST_LINE else "markers",
        "name": name,
        "x": list(means),
        "y": list(means.values()),
        "text": ranges,
        "line": {"color": colour(number), "width": 1},
        "marker": {
            "color": colour(number),
            "symbol": SYMBOLS[number % len(SYMBOLS)],
            "size": 6,
            "opacity": 0.85,
        },
        "hovertemplate": f"field %{{x}}: {hover} (%{{text}})<extra>{name}</extra>",
    }


def _band(limits: tuple[float, float], name: str, section: Section, method: str | None) -> Spec:
    names = [key.partition("@")[0] for key in section.rows]
    fill = colour(names.index(method)) if method in names else "#888888"
    return {
        "type": "rect" if limits[1] > limits[0] else "line",
        "xref": "paper",
        "x0": 0,
        "x1": 1,
        "y0": limits[0],
        "y1": limits[1],
        "layer": "below",
        "fillcolor": fill,
        "opacity": 0.18 if limits[1] > limits[0] else 0.6,
        "line": {"width": 0 if limits[1] > limits[0] else 1.5, "color": fill, "dash": "dash"},
        "label": {
            "text": name,
            "textposition": "top right" if limits[1] > limits[0] else "end",
            "font": {"size": 10, "color": "#333333"},
        },
    }


def _layout(title: str, shapes: list[Spec]) -> Spec:
    axis = {"gridcolor": "#e5e7eb", "zeroline": False, "linecolor": "#9ca3af", "automargin": True}
    return {
        "font": {"family": "system-ui, sans-serif", "size": 12, "color": "#1f2937"},
        "margin": {"l": 48, "r": 12, "t": 30, "b": 40},
        "xaxis": {"title": {"text": "test case (field)"}, **axis},
        "yaxis": {"title": {"text": title}, **axis},
        "legend": {"orientation": "h", "y": -0.22, "yanchor": "top", "x": 0},
        "hovermode": "closest",
        "plot_bgcolor": "#ffffff",
        "paper_bgcolor": "#ffffff",
        "shapes": shapes,
    }
