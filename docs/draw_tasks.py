"""Draw the pictures of docs/tasks/ of the files that the commands of these pages have written.

    python docs/draw_tasks.py --files DIR              # into docs/pictures
    python docs/draw_tasks.py --files DIR --out DIR

``DIR`` is where somebody has followed the pages. Needs the extra ``[viz]``.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import json
import re
import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import adr_opt
from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M
from adr_opt.fly.trajectory import sample
from adr_opt.learning import load_policy
from adr_opt.problem.settings import KeepOutZone
from adr_opt.ui import plot

DOCS = Path(__file__).parent
MODEL = runpy.run_path(str(DOCS / "draw_model.py"))
WIDTH_IN, INK, FAINT, ZONE, STYLE = (
    MODEL[name] for name in ("WIDTH_IN", "INK", "FAINT", "ZONE", "STYLE")
)
HOUR_S = 3600.0
STEP_S = 300.0
"""Time between two points of an arc: pictures stay small, and arcs are nearly level."""

NEWS_D = 2.5
"""Day on which the zone becomes known in docs/tasks/cloud.md."""


def load(files: Path, name: str, plan: str) -> tuple[adr_opt.Instance, adr_opt.Plan]:
    """A mission and a plan of it, as the commands have written them."""
    return adr_opt.load(files / f"{name}.json"), adr_opt.load_plan(files / f"{plan}.json")


def cloud(files: Path) -> Any:
    """A week in a cloud: altitude and ΔV left."""
    instance, plan = load(files, "cloud", "cloud-plan")
    figure, (above, below) = plt.subplots(
        2, 1, figsize=(WIDTH_IN, 5.0), sharex=True, height_ratios=(3, 2)
    )
    _flown(above, instance, plan)
    plot.delta_v_left(below, instance, plan)
    above.set(ylabel="altitude [km]", xlim=(0.0, 7.0))
    below.set_ylim(0.0, None)
    figure.legend(*_phases(above), ncols=3, loc="lower center", handlelength=1.2)
    figure.tight_layout(rect=(0.0, 0.14, 1.0, 1.0))
    return figure


def _flown(
    ax: Any, instance: adr_opt.Instance, plan: adr_opt.Plan, begin: float = 0.0, end: float = 1e9
) -> None:
    """Altitude [km] against days, one colour a phase, from one time to another [s]."""
    pieces: dict[str, list[Any]] = {}
    for _, arc in sample(instance, plan, STEP_S).arcs():
        altitudes = (np.linalg.norm(arc.positions_m, axis=1) - EARTH_RADIUS_M) / 1000.0
        rows = np.column_stack([arc.times_s / DAY_S, altitudes])
        rows = rows[(arc.times_s >= begin) & (arc.times_s <= end)]
        if rows.size:
            pieces.setdefault(arc.phase, []).extend([rows, [[np.nan, np.nan]]])
    for phase in plot.PHASES:
        if phase in pieces:
            rows = np.vstack(pieces[phase])
            ax.plot(
                rows[:, 0], rows[:, 1], color=plot.COLOURS[phase], lw=2.2, label=plot.LABELS[phase]
            )


def _phases(ax: Any) -> tuple[list[Any], list[str]]:
    """Lines and names for a legend, each once."""
    found = dict(zip(*reversed(ax.get_legend_handles_labels()), strict=True))
    return list(found.values()), list(found)


def _zone(title: str) -> tuple[Any, Any]:
    """A chart of days and altitudes with the zone of the page, and when one learned of it."""
    figure, ax = plt.subplots(figsize=(5.0, 4.4))
    (described,) = json.loads((DOCS.parent / "examples/catalogue/zone.json").read_text("utf-8"))
    zone = KeepOutZone(**described)
    ax.fill_between(
        [zone.start_s / DAY_S, zone.end_s / DAY_S],
        zone.min_altitude_m / 1000.0,
        zone.max_altitude_m / 1000.0,
        color=ZONE,
        alpha=0.28,
        lw=0.0,
        label="keep-out zone",
    )
    ax.axvline(NEWS_D, color=INK, lw=1.0, ls=(0, (3, 2)), label="the news")
    ax.set(title=title, xlabel="days since the epoch", ylabel="altitude [km]", xlim=(2.2, 4.8))
    ax.set_ylim(450.0, 1250.0)
    return figure, ax


def zone_before(files: Path) -> Any:
    """The former plan, and the zone that falls into it."""
    figure, ax = _zone("the plan that was made before")
    _flown(ax, *load(files, "cloud", "cloud-plan"))
    return _with_legend(figure, ax)


def zone_after(files: Path) -> Any:
    """Legs begun by then, and the replanned rest."""
    figure, ax = _zone("the rest, planned anew")
    rest, plan = load(files, "rest-instance", "rest")
    free_s = rest.chasers[0].available_s[0]
    _flown(ax, *load(files, "cloud", "cloud-plan"), end=free_s)
    _flown(ax, rest, plan, begin=free_s)
    return _with_legend(figure, ax)


def _with_legend(figure: Any, ax: Any) -> Any:
    ax.legend(
        *_phases(ax),
        ncols=3,
        loc="upper center",
        bbox_to_anchor=(0.46, -0.15),
        handlelength=1.2,
        columnspacing=1.0,
        fontsize=10,
    )
    return figure


def rocket_bodies(files: Path) -> Any:
    """A year among rocket bodies: nodes against time."""
    instance, plan = load(files, "bodies", "bodies-plan")
    figure, ax = plt.subplots(figsize=(WIDTH_IN, 4.6))
    plot.nodes(ax, instance, plan)
    ax.set_xlim(0.0, instance.mission.duration_s / DAY_S)
    ax.legend(
        *_phases(ax), ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.14), handlelength=1.4
    )
    return figure


def campaign(files: Path) -> Any:
    """Four years of three chasers: a row for each leg, and the deadline of two of them."""
    instance, plan = load(files, "removal", "removal-plan")
    figure, ax = plt.subplots(figsize=(WIDTH_IN, 4.6))
    plot.gantt(ax, instance, plan)
    deadlines = {target.window_s[1] for target in instance.targets if target.required}
    for deadline_s in sorted(each for each in deadlines if each is not None):
        ax.axvline(deadline_s / DAY_S, color=INK, lw=1.0, ls=(0, (3, 2)), label="deadline")
    ax.set_xlim(0.0, instance.mission.duration_s / DAY_S)
    ax.tick_params(axis="y", labelsize=9.5)
    ax.set_ylabel("")
    ax.legend(
        *_phases(ax), ncols=3, loc="upper center", bbox_to_anchor=(0.25, -0.14), handlelength=1.4
    )
    return figure


def chemical_or_electric(files: Path) -> Any:
    """Altitude of a chaser that thrusts, and its mass beside that of one that burns."""
    instance, plan = load(files, "electric", "electric-plan")
    figure, (above, below) = plt.subplots(
        2, 1, figsize=(WIDTH_IN, 5.0), sharex=True, height_ratios=(3, 2)
    )
    plot.altitude(above, instance, plan)
    plot.mass(below, instance, plan)
    plot.mass(below, *load(files, "chemical", "chemical-plan"))
    for line, colour, name in zip(
        below.lines,
        (plot.COLOURS["thrust"], plot.COLOURS["phasing"]),
        ("thrusts", "burns"),
        strict=True,
    ):
        line.set(color=colour, label=name)
    below.legend(loc="upper right", handlelength=1.2)
    above.set(xlabel="", xlim=(0.0, instance.mission.duration_s / DAY_S))
    figure.legend(*_phases(above), ncols=3, loc="lower center", handlelength=1.2)
    figure.tight_layout(rect=(0.0, 0.14, 1.0, 1.0))
    return figure


def own_cost(files: Path) -> Any:
    """The round of the van on its map, and how long a road takes by the time of departure."""
    text = (DOCS / "tasks/own-cost.md").read_text(encoding="utf-8")
    code = re.search(r"```python\n(.*?)```", text, re.DOTALL)
    assert code is not None
    names: dict[str, Any] = {}
    with contextlib.redirect_stdout(None):
        exec(code[1], names)
    km, places, legs = names["km"], list(names["places"]), names["result"].plan.legs
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(WIDTH_IN * 1.2, 3.7), width_ratios=(1.15, 1)
    )
    for number, leg in enumerate(legs, 1):
        (x, y), (u, v) = km[places.index(leg.origin)], km[places.index(leg.destination)]
        left.annotate(
            "",
            (u, v),
            (x, y),
            arrowprops={
                "arrowstyle": "-|>",
                "color": plot.COLOURS["phasing"],
                "lw": 2.2,
                "shrinkA": 7,
                "shrinkB": 7,
            },
        )
        clock = f"{6 + int(leg.arrival_s // HOUR_S)}:{int(leg.arrival_s % HOUR_S) // 60:02d}"
        left.annotate(
            f"{leg.destination} {clock}" if number < len(legs) else f"{leg.destination}\n{clock}",
            (u, v),
            (0, 9) if v >= 0 else (0, -17),
            textcoords="offset points",
            ha="left" if leg.destination == "mill" else "center",
            fontsize=10.5,
        )
    left.plot(*km[1:].T, "o", color=plot.COLOURS["service"], ms=9, zorder=5)
    left.plot(*km[0], "s", color=plot.COLOURS["refuelling"], ms=10, zorder=5)
    left.set(xlim=(-19, 22), ylim=(-16, 20), xlabel="km", aspect="equal")
    hours = np.arange(0.0, 5.0, 1.0 / 60.0)
    quay = [places.index("quay")]
    found = [names["road"](0, quay, HOUR_S * hour) for hour in hours]
    right.plot(
        6 + hours,
        [float(took[0]) / 60 for took, _ in found],
        color=plot.COLOURS["hohmann-1"],
        lw=2.4,
        label="minutes",
    )
    right.plot(
        6 + hours,
        [10 * float(cost[0]) for _, cost in found],
        color=plot.COLOURS["co-elliptic"],
        lw=2.4,
        label="tenths of a kWh",
    )
    right.set(xlabel="depot to quay, leaving at [h]", ylim=(0, 60))
    right.legend(loc="upper right", handlelength=1.2)
    figure.tight_layout()
    return figure


def own_policy(files: Path) -> Any:
    """Visits on held fields against steps, of two rollouts and of the policy of the package."""
    figure, ax = plt.subplots(figsize=(WIDTH_IN, 3.8))
    for path, dashes, width, label in (
        (files / "runs/mine/last.npz", "-", 3.0, "this page"),
        ("policy", (0, (2, 1)), 1.8, "the package"),
    ):
        card = load_policy(path).card
        for at, (name, phase) in enumerate(
            zip(card["families"], ("phasing", "co-elliptic", "terminal"), strict=True), start=2
        ):
            ax.plot(
                [max(row[0], 8000.0) for row in card["curve"]],
                [row[at] for row in card["curve"]],
                color=plot.COLOURS[phase],
                lw=width,
                ls=dashes,
                label=f"{name}, {label}",
            )
    ax.set(xscale="log", xlabel="steps (those at the left edge: none)", ylabel="visits")
    ax.set_ylim(0.0, 31.0)
    ax.legend(ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.2), handlelength=1.8)
    return figure


def policy_curve(files: Path) -> Any:
    """Training of the package's policy and of the published one, beside planners and optima."""
    figure, axes = plt.subplots(1, 3, figsize=(WIDTH_IN, 3.6))
    card = load_policy().card
    curves = DOCS.parent / "bench" / "curves"
    published = np.genfromtxt(curves / "published.csv", delimiter=",", skip_header=1)
    with (curves / "rivals.csv").open(newline="", encoding="utf-8") as lines:
        rivals = list(csv.DictReader(lines))
    learned = np.array(card["curve"])
    for at, (ax, family) in enumerate(zip(axes, card["families"], strict=True), start=2):
        for found, phase, label in (
            (learned, "co-elliptic", "the package"),
            (published, "phasing", "the published study"),
        ):
            steps = np.maximum(found[:, 0], 1e4)
            ax.plot(steps, found[:, at], color=plot.COLOURS[phase], lw=2.4, label=label)
        levels = {"untrained": card["families"][family]["untrained"]} | {
            row["what"]: float(row["visits"]) for row in rivals if row["family"] == family
        }
        for (name, level), dashes in zip(levels.items(), (":", "-.", "--", "-"), strict=False):
            ax.axhline(level, color=INK, lw=1.0, ls=dashes, label=name)
        ax.set(xscale="log", xlabel="steps", title=family, ylim=(0.0, 1.05 * max(levels.values())))
    axes[0].set_ylabel("visits")
    figure.legend(*axes[-1].get_legend_handles_labels(), ncols=3, loc="lower center")
    figure.tight_layout(rect=(0.0, 0.18, 1.0, 1.0))
    return figure


PICTURES: dict[str, Callable[[Path], Any]] = {
    "task-cloud": cloud,
    "task-zone-before": zone_before,
    "task-zone-after": zone_after,
    "task-rocket-bodies": rocket_bodies,
    "task-campaign": campaign,
    "task-chemical-or-electric": chemical_or_electric,
    "task-own-cost": own_cost,
    "task-own-policy": own_policy,
    "task-policy-curve": policy_curve,
}


def draw(files: Path, folder: Path) -> list[Path]:
    """Draw all pictures into a folder; returns their paths."""
    return MODEL["save"]({name: lambda p=p: p(files) for name, p in PICTURES.items()}, folder)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Draw the pictures of the pages about tasks.")
    parser.add_argument("--files", type=Path, required=True, metavar="DIR")
    parser.add_argument("--out", type=Path, default=DOCS / "pictures", metavar="DIR")
    typed = parser.parse_args()
    for written in draw(typed.files, typed.out):
        print(f"{written}: {written.stat().st_size / 1000:.0f} kB")
