"""Draw the pictures of docs/model.md, waiting.md, drift.md, refining.md and index.md.

    python docs/draw_model.py              # into docs/pictures
    python docs/draw_model.py --out DIR

`sequence` is a sketch with exaggerated radii; everything else is computed from a generated
instance, so that the pictures show what the model does. Needs the extra ``[viz]``.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import adr_opt
from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, OBLATENESS_M2
from adr_opt.judge.check.missed import CAPTURE_REVOLUTIONS, begun, flights, rule_of
from adr_opt.kernels.legs import co_elliptic as transfer
from adr_opt.kernels.legs import drift_linear as drifts
from adr_opt.kernels.legs import sequences
from adr_opt.kernels.orbits import ephemeris
from adr_opt.kernels.tables import timetable as kernels
from adr_opt.mission.certified import certify
from adr_opt.problem.agreement import ROUNDEST
from adr_opt.problem.approach import LAPS_AFTER, approach_of
from adr_opt.problem.settings import KeepOutZone, TransferSettings
from adr_opt.ui import plot

FOLDER = Path(__file__).with_name("pictures")
WIDTH_IN = 6.2
PRICED = {
    "Cosmos 2251-like 0": "like Cosmos 2251",
    "SL-8-like 0": "like SL-8",
    "celestrak_2025-04_iridium-33-debris part 1": "Iridium 33, 2025-04",
}
"""Fields of bench/curves/free-burns.csv, and their titles."""

INK = "#26313d"
FAINT = "#9aa5b1"
ZONE = "#d4553f"

DRIFTED_DAYS = (7, 30, 90)
"""After which docs/drift.md says what a change of node costs."""

# The same bytes for the same drawing, and a background, so that a dark page does not swallow ink.
STYLE = {
    "svg.hashsalt": "adr-opt",
    "svg.fonttype": "path",
    "figure.facecolor": "#fcfcfa",
    "savefig.facecolor": "#fcfcfa",
    "axes.facecolor": "#fcfcfa",
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "font.size": 12.0,
    "legend.frameon": False,
    "legend.fontsize": 11.0,
}


def sequence() -> Any:
    """The co-elliptic sequence, seen along the orbits' normal; radii are exaggerated."""
    origin, phasing, target, fraction = 1.0, 0.72, 1.5, 0.75
    co_elliptic = phasing + fraction * (target - phasing)
    behind = 0.22  # angle of the stand-off, exaggerated
    figure, ax = plt.subplots(figsize=(WIDTH_IN, WIDTH_IN * 0.86))
    ax.add_patch(plt.Circle((0.0, 0.0), 0.5, facecolor="#dfe7ee", edgecolor=FAINT))
    ax.text(0.0, 0.0, "Earth", ha="center", va="center")
    around = np.linspace(0.0, 2.0 * np.pi, 241)
    for radius, dashes in ((origin, (0, (5, 3))), (target, (0, (1, 2)))):
        ax.plot(radius * np.cos(around), radius * np.sin(around), color=FAINT, lw=1.2, ls=dashes)
    ax.plot([-1.75, 1.85], [0.0, 0.0], color=FAINT, lw=0.8)
    ax.text(1.85, 0.05, "line of nodes", fontsize=10.5, ha="right", color=INK)

    def half(first: float, last: float, start: float, phase: str, shown: float = math.pi) -> None:
        """Half an ellipse from one apsis to the other."""
        swept = np.linspace(0.0, shown, 181)
        semi_latus = 2.0 * first * last / (first + last)
        eccentricity = (last - first) / (last + first)
        radius = semi_latus / (1.0 + eccentricity * np.cos(swept))
        x, y = radius * np.cos(start + swept), radius * np.sin(start + swept)
        ax.plot(x, y, color=plot.COLOURS[phase], lw=2.6, label=plot.LABELS[phase])

    def burn(number: str, radius: float, angle: float, dx: float, dy: float) -> None:
        x, y = radius * math.cos(angle), radius * math.sin(angle)
        ax.plot([x], [y], "o", color=INK, ms=6, zorder=5)
        ax.annotate(number, (x, y), (x + dx, y + dy), ha="center", va="center", weight="bold")

    half(origin, phasing, 0.0, "hohmann-1")
    swept = np.linspace(math.pi, 3.0 * math.pi, 361)
    ax.plot(
        phasing * np.cos(swept),
        phasing * np.sin(swept),
        color=plot.COLOURS["phasing"],
        lw=2.6,
        label=plot.LABELS["phasing"],
    )
    half(phasing, co_elliptic, math.pi, "co-elliptic")
    half(co_elliptic, target, 2.0 * math.pi, "terminal", math.pi)
    end = math.pi
    swept = np.linspace(end, end + behind, 31)
    bow = target - 0.07 * np.sin(np.linspace(0.0, math.pi, 31))
    ax.plot(
        bow * np.cos(swept),
        bow * np.sin(swept),
        color=plot.COLOURS["approach"],
        lw=2.6,
        label=plot.LABELS["approach"],
    )
    x, y = target * math.cos(end + behind), target * math.sin(end + behind)
    ax.plot([x], [y], "s", color=plot.COLOURS["service"], ms=9, zorder=6)
    ax.annotate("target", (x, y), (x - 0.08, y - 0.17), ha="center")
    burn("1", origin, 0.0, -0.09, -0.1)
    burn("2, 3", phasing, math.pi, 0.1, 0.12)
    burn("4", co_elliptic, 0.0, 0.09, -0.11)
    burn("5, 6", target, math.pi, -0.17, 0.13)
    burn("7", target, end + behind, 0.15, -0.03)
    ax.text(0.30, -1.12, "origin's orbit", fontsize=10.5, rotation=15)
    ax.text(0.56, -1.56, "target's orbit", fontsize=10.5, rotation=20)
    ax.set(xlim=(-1.95, 1.85), ylim=(-1.62, 1.62), aspect="equal")
    ax.axis("off")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, 0.02), ncols=3, handlelength=1.4)
    return figure


def _leg(instance: adr_opt.Instance, target: int) -> tuple[adr_opt.Instance, adr_opt.Plan]:
    """A mission from the station to one target, by the connection that is chosen at the epoch.

    Of a whole week the cheapest leg is flown, which waits for days. Of a mission that ends with the
    leg that the usual value of time chooses, it is that leg.
    """
    mission = adr_opt.Mission(instance)
    _, arrival = mission.timetable.lookup(0, target, 0.0)
    short = instance.with_limits(duration_s=float(arrival + mission.rules.service[target]))
    result = certify(adr_opt.Mission(short), "drawn", (target,), seed=0, runtime_s=0.0)
    assert result.plan is not None
    return short, result.plan


def _heights(instance: adr_opt.Instance, plan: adr_opt.Plan) -> Iterator[tuple[str, Any, Any]]:
    """Phase, hours and altitude [km] of the arcs of a plan."""
    from adr_opt.fly.trajectory import sample

    for _, arc in sample(instance, plan, 60.0).arcs():
        altitudes = np.linalg.norm(arc.positions_m, axis=1) - EARTH_RADIUS_M
        yield arc.phase, arc.times_s / 3600.0, altitudes / 1000.0


def approach() -> Any:
    """A safety ellipse as flown under J2, with each burn up to the capture missed."""
    settings = TransferSettings(approach="safety-ellipse")
    rows, keep_m = approach_of(settings).burns, settings.keep_out_m
    judged = int(np.sum(rows[:, 0] <= rows[-1, 0] - CAPTURE_REVOLUTIONS))
    orbit = EARTH_RADIUS_M + 800e3, ROUNDEST, *np.radians([70.0, 40.0, 30.0, 110.0])
    target, chaser, motion = begun(np.array([orbit]), settings.standoff_m)
    revolution = math.tau / motion[:, 0]
    times = rows[:, :1] * revolution
    ends = times[:, 0] + LAPS_AFTER * revolution
    tracks: list[list[Any]] = [[] for _ in range(judged + 1)]
    burn, last = rule_of(rows, motion), ends[judged - 1 : judged]
    for step, (now, there, flown) in enumerate(flights(target, chaser, times, burn, last)):
        outward = there[0, :3] / np.linalg.norm(there[0, :3])
        across = np.cross(there[0, :3], there[0, 3:])
        across /= np.linalg.norm(across)
        seen = (flown[:, 0, :3] - there[0, :3]) @ np.stack(
            [np.cross(across, outward), outward, across], axis=1
        )
        for number in range(judged):
            falls = times[number, 0] <= now[0] <= ends[number]
            if falls and (step % 6 == 0 or not tracks[number]):
                tracks[number].append(seen[number])
        if now[0] <= times[-1, 0] and step % 2 == 0:
            tracks[judged].append(seen[-1])
    figure, (side, front) = plt.subplots(
        2, 1, figsize=(WIDTH_IN, 6.6), height_ratios=(4, 5), gridspec_kw={"hspace": 0.35}
    )
    paths = [np.array(each) for each in tracks]
    for ax, first, second in ((side, 0, 1), (front, 2, 1)):
        for number, path in enumerate(paths[:-1]):
            ax.plot(
                path[:, first],
                path[:, second],
                color=FAINT,
                lw=0.7,
                zorder=1,
                label=None if number else "after a missed burn, 8 revolutions",
            )
        ax.plot(
            paths[-1][:, first],
            paths[-1][:, second],
            color=plot.COLOURS["approach"],
            lw=2.0,
            label="with all burns",
            zorder=3,
        )
        ax.add_patch(
            plt.Circle(
                (0.0, 0.0),
                keep_m,
                facecolor=ZONE,
                alpha=0.25,
                zorder=2,
                label=f"kept out of, {keep_m:g} m",
            )
        )
        ax.plot([0.0], [0.0], "s", color=plot.COLOURS["service"], ms=6, zorder=5)
        for number, path in enumerate(paths[:-1], start=1):
            place = path[0, first], path[0, second]
            ax.plot(*place, "o", color=INK, ms=4, zorder=6)
            ax.annotate(str(number), place, xytext=(5, 5), textcoords="offset points", fontsize=10)
        ax.set_ylabel("radial [m]")
        ax.set_aspect("equal")
    side.set(xlim=(-2300, 900), ylim=(-520, 520), xlabel="along the track [m]")
    front.set(xlim=(-520, 520), ylim=(-460, 460), xlabel="across the track [m]")
    front.legend(loc="center left", bbox_to_anchor=(1.02, 0.5))
    return figure


def leg() -> Any:
    """Altitude of a real leg against time."""
    instance, plan = _leg(adr_opt.generate("nominal", 0), 5)
    figure, ax = plt.subplots(figsize=(WIDTH_IN, 3.5))
    for phase, hours, altitudes in _heights(instance, plan):
        label = plot.LABELS[phase]
        ax.plot(hours, altitudes, color=plot.COLOURS[phase], lw=2.4, label=label)
    for burn in plan.legs[0].burns:
        ax.axvline(burn.time_s / 3600.0, color=FAINT, lw=0.7, zorder=0)
    ax.set(xlabel="hours since the epoch", ylabel="altitude [km]")
    ax.legend(ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.22), handlelength=1.4)
    return figure


def timetable() -> Any:
    """ΔV and duration of one pair at every ready time of its first hours."""
    instance = adr_opt.generate("nominal", 0)
    table = adr_opt.Timetable(instance, threads=1)
    origin, destination, end = 0, 5, 16.0 * 3600.0
    ready = np.arange(0.0, end, 20.0)
    found = np.array([table.lookup(origin, destination, t) for t in ready])
    # Where a chaser that is ready later arrives later, another connection is chosen.
    changes = np.flatnonzero(np.diff(found[:, 1])) + 1
    events = [event / 3600.0 for event in _events(table, origin, destination) if event < end]
    hours = ready / 3600.0
    figure, (above, below) = plt.subplots(2, 1, figsize=(WIDTH_IN, 4.6), sharex=True)
    for begin, stop in zip([0, *changes], [*changes, len(ready)], strict=True):
        piece = slice(begin, stop)
        above.plot(hours[piece], found[piece, 0], color=plot.COLOURS["phasing"], lw=2.6)
        waited = (found[piece, 1] - ready[piece]) / 3600.0
        below.plot(hours[piece], waited, color=plot.COLOURS["terminal"], lw=2.6)
    for ax in (above, below):
        for event in events:
            ax.axvline(event, color=FAINT, lw=0.8, ls=(0, (2, 2)), zorder=0)
        ax.set_ylim(0.0, 1.12 * ax.get_ylim()[1])
    above.set_ylabel("ΔV [m/s]")
    below.set(xlabel="ready at the station [h]", ylabel="until arrival [h]", xlim=(0.0, 16.0))
    figure.tight_layout()
    return figure


def _events(table: adr_opt.Timetable, origin: int, destination: int) -> list[float]:
    """The departure events of a pair [s]."""
    total = kernels.events(table.table, origin, destination)
    return [kernels.departure_at(table.table, origin, destination, m) for m in range(total)]


def _is_blocked(
    instance: adr_opt.Instance, origin: int, destination: int, event: int, departure: float
) -> bool:
    """Whether keep-out zones leave no sequence at all at a departure event."""
    rows, rule = instance.orbits(), instance.transfer_rule()
    pair = transfer.prepare(rows[origin], rows[destination], 0.0, rule, 0.0)
    _, half_turns = transfer.first_departure(pair)
    lead = transfer.target_lead(pair, departure, half_turns + event)
    found = sequences.best_sequence(pair, rule, departure, lead, -math.inf, math.inf)
    return not math.isfinite(found.delta_v)


def connections() -> Any:
    """The connections of a pair, and what three choices take of them at every ready time."""
    instance = adr_opt.generate("nominal", 0)
    table = adr_opt.Timetable(instance, threads=1)
    origin, destination, end, dearest = 0, 5, 36.0 * 3600.0, 600.0
    found = table.connections(origin, destination)
    figure, ax = plt.subplots(figsize=(WIDTH_IN, 3.7))
    shown = (found.departure < end) & (found.delta_v < dearest)
    ax.plot(
        found.departure[shown] / 3600.0,
        found.delta_v[shown],
        ls="none",
        marker=".",
        ms=3.5,
        color=FAINT,
        label="connections",
    )
    ready = np.arange(0.0, end, 600.0)
    for choose, phase, label in (
        ("earliest", "hohmann-1", "the earliest"),
        (75.0, "phasing", "75 m/s per hour"),
        ("cheapest", "terminal", "the cheapest"),
    ):
        chosen = table.matrices(ready, choose=choose).delta_v[:, origin, destination]
        ax.step(
            ready / 3600.0, chosen, where="post", color=plot.COLOURS[phase], lw=1.8, label=label
        )
    ax.set(xlabel="ready, or departing [h]", ylabel="ΔV [m/s]", xlim=(0.0, end / 3600.0))
    ax.set_ylim(0.0, dearest)
    ax.legend(ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.2), handlelength=1.4)
    return figure


def waiting() -> Any:
    """A zone that is waited out: every departure is blocked until it opens, the next is taken."""
    free = adr_opt.generate("nominal", 0)
    zone = KeepOutZone(min_altitude_m=685e3, max_altitude_m=715e3, start_s=0.0, end_s=2.2e4)
    closed = free.replace(keep_out_zones=(zone,))
    target = 5
    figure, ax = plt.subplots(figsize=(WIDTH_IN, 3.9))
    flown = []
    for instance, colour, label in (
        (free, FAINT, "without the zone"),
        (closed, plot.COLOURS["phasing"], "with it"),
    ):
        short, plan = _leg(instance, target)
        leg = plan.legs[0]
        flown.append(leg)
        label = f"{label}: {leg.delta_v_m_s:.0f} m/s, arrives after {leg.arrival_s / 3600:.1f} h"
        pieces = [piece for piece in _heights(short, plan) if piece[0] not in ("wait", "service")]
        hours = np.concatenate([piece[1] for piece in pieces])
        altitudes = np.concatenate([piece[2] for piece in pieces])
        ax.plot(hours, altitudes, color=colour, lw=2.4, label=label)
    home = (free.body_orbits[0].semi_major_axis_m - EARTH_RADIUS_M) / 1000.0
    taken = flown[1].departure_s / 3600.0
    ax.plot([0.0, taken], [home, home], color=plot.COLOURS["wait"], lw=2.4, label="wait")
    events = _events(adr_opt.Timetable(closed, threads=1), 0, target)
    blocked = [
        departure / 3600.0
        for event, departure in enumerate(events)
        if departure < flown[1].departure_s and _is_blocked(closed, 0, target, event, departure)
    ]
    ax.plot(
        blocked,
        [home] * len(blocked),
        "x",
        color=ZONE,
        ms=8,
        mew=2.2,
        zorder=6,
        label=f"{len(blocked)} departures that it blocks",
    )
    ax.plot([taken], [home], "o", color=INK, ms=7, zorder=6, label="the departure that is taken")
    ax.fill_between(
        [zone.start_s / 3600.0, zone.end_s / 3600.0],
        zone.min_altitude_m / 1000.0,
        zone.max_altitude_m / 1000.0,
        color=ZONE,
        alpha=0.25,
        lw=0.0,
        label="keep-out zone",
    )
    ax.set(xlabel="hours since the epoch", ylabel="altitude [km]")
    ax.legend(ncols=2, loc="upper center", bbox_to_anchor=(0.46, -0.2), handlelength=1.2)
    return figure


def detour() -> Any:
    """The altitude of a leg without and with a keep-out zone in its way."""
    free = adr_opt.generate("nominal", 0)
    zone = KeepOutZone(min_altitude_m=715e3, max_altitude_m=770e3, start_s=2.4e4, end_s=4.2e4)
    closed = free.replace(keep_out_zones=(zone,))
    figure, ax = plt.subplots(figsize=(WIDTH_IN, 3.7))
    for instance, colour, label in (
        (free, FAINT, "without the zone"),
        (closed, plot.COLOURS["phasing"], "with it"),
    ):
        short, plan = _leg(instance, 5)
        leg = plan.legs[0]
        label = f"{label}: {leg.delta_v_m_s:.0f} m/s, arrives after {leg.arrival_s / 3600:.1f} h"
        pieces = [piece for piece in _heights(short, plan) if piece[0] != "service"]
        hours = np.concatenate([piece[1] for piece in pieces])
        altitudes = np.concatenate([piece[2] for piece in pieces])
        ax.plot(hours, altitudes, color=colour, lw=2.4, label=label)
    ax.fill_between(
        [zone.start_s / 3600.0, zone.end_s / 3600.0],
        zone.min_altitude_m / 1000.0,
        zone.max_altitude_m / 1000.0,
        color=ZONE,
        alpha=0.3,
        lw=0.0,
        label="keep-out zone",
    )
    ax.set(xlabel="hours since the epoch", ylabel="altitude [km]")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), handlelength=1.4)
    return figure


def drift() -> Any:
    """Cost of a change of the node alone after drifting, and the drift orbit used."""
    days = np.geomspace(1.0, 365.0, 200)
    asked = math.radians(5.0)
    figure, (above, below) = plt.subplots(2, 1, figsize=(WIDTH_IN, 5.2), sharex=True)
    for altitude, inclination, phase in ((750e3, 96.0, "phasing"), (840e3, 71.0, "terminal")):
        radius, angle = EARTH_RADIUS_M + altitude, math.radians(inclination)
        node_rate = ephemeris.node_rate(radius, angle, OBLATENESS_M2)
        rate = ephemeris.latitude_rate(radius, angle, OBLATENESS_M2)
        here, there = (
            np.array([radius, angle, node, 0.0, node_rate, rate, 0.0, 0.0, 0.0, 0.0])
            for node in (0.0, asked)
        )
        pair = drifts.prepare(
            here, there, EARTH_RADIUS_M + 300e3, EARTH_RADIUS_M + 2000e3, OBLATENESS_M2, 0.0
        )
        direct = pair.speed * pair.sine * asked
        shares, heights = [], []
        for day in [*days, *DRIFTED_DAYS]:
            climb = drifts.climb_of(pair, day * DAY_S, drifts.node_left(pair, 0.0))
            shares.append(drifts.delta_v(pair, -day * DAY_S, 0.0) / direct)
            heights.append((altitude + 2.0 * radius * climb / pair.speed) / 1000.0)
        colour, label = plot.COLOURS[phase], f"{altitude / 1000:.0f} km, {inclination:g}°"
        above.plot(days, shares[: days.size], color=colour, lw=2.4, label=label)
        below.plot(days, heights[: days.size], color=colour, lw=2.4)
        for day, share in zip(DRIFTED_DAYS, shares[days.size :], strict=True):
            above.plot([day], [share], "o", color=colour, ms=6)
            above.annotate(
                f"{share:.3f}",
                (day, share),
                (4, 5) if altitude < 8e5 else (-5, -11),
                textcoords="offset points",
                ha="left" if altitude < 8e5 else "right",
                fontsize=10.5,
            )
        below.axhline(altitude / 1000.0, color=colour, lw=0.9, ls=(0, (2, 2)))
    above.set(ylabel="ΔV / direct turn", ylim=(-0.08, 1.1), xscale="log")
    below.set(xlabel="days from departure to arrival", ylabel="drifts at [km], for 5°")
    below.set_xticks([1, 3, *DRIFTED_DAYS, 365], [1, 3, *DRIFTED_DAYS, 365])
    below.minorticks_off()
    above.legend(loc="upper right", handlelength=1.4)
    figure.tight_layout()
    return figure


def refined_cloud() -> tuple[adr_opt.RefinedPlan, adr_opt.RefinedPlan]:
    """A plan of an eccentric cloud, refined with its own burns and with free ones."""
    instance = adr_opt.generate("cloud", 0).replace(dynamics="j2")
    plan = adr_opt.solve(instance, method="greedy-guarded").plan
    assert plan is not None
    own = adr_opt.refine(instance, plan, freedom="planned")
    return own, adr_opt.refine(instance, plan, freedom="free")


def flown() -> Any:
    """Planned against flown ΔV of each leg of a plan."""
    own, free = refined_cloud()
    numbers = [leg.leg for leg in free.legs]
    figure, ax = plt.subplots(figsize=(WIDTH_IN, 3.6))
    planned = [leg.planned_delta_v_m_s for leg in free.legs]
    ax.bar(numbers, planned, 0.86, color="#d5dbe1", label="planned")
    ax.bar(
        numbers,
        [leg.flown_delta_v_m_s for leg in free.legs],
        0.5,
        color=plot.COLOURS["phasing"],
        label="flown, free burns",
    )
    ax.plot(
        numbers,
        [leg.flown_delta_v_m_s for leg in own.legs],
        "_",
        color=INK,
        ms=9,
        mew=1.8,
        label="flown, the plan's own burns",
    )
    ax.set(xlabel="leg", ylabel="ΔV [m/s]", xlim=(0.2, len(numbers) + 0.8))
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, handlelength=1.2)
    figure.tight_layout()
    return figure


def priced() -> Any:
    """Said against flown ΔV of the legs of three fields, by both prices."""
    legs = np.genfromtxt(
        FOLDER.parents[1] / "bench/curves/free-burns.csv",
        delimiter=",",
        names=True,
        dtype=None,
        encoding="utf-8",
    )
    figure, panels = plt.subplots(1, len(PRICED), figsize=(WIDTH_IN, 3.0), sharey=True)
    for ax, (name, title) in zip(panels, PRICED.items(), strict=True):
        for price, colour, mark, label in (
            ("sequence", FAINT, "o", "by the sequence"),
            ("free", plot.COLOURS["phasing"], "x", "by free burns"),
        ):
            some = legs[(legs["field"] == name) & (legs["priced_by"] == price)]
            said = some["said_m_s"].sum() / some["flown_m_s"].sum() - 1.0
            shares = some["said_m_s"] / some["flown_m_s"]
            told = f"{label}: {100.0 * said:+.1f} %"
            ax.plot(some["flown_m_s"], shares, mark, color=colour, ms=4, label=told)
        ax.axhspan(0.9, 1.1, color=FAINT, alpha=0.15, lw=0)
        ax.set(xlabel="flown ΔV [m/s]")
        ax.set_title(title, fontsize=9)
        ax.legend(loc="upper right", fontsize=6, handlelength=1.0)
    panels[0].set(ylabel="said over flown", ylim=(0.85, 1.75))
    figure.tight_layout()
    return figure


def mission() -> Any:
    """A whole small mission: altitude against time, phases coloured."""
    instance = adr_opt.generate("tiny", 0).with_limits(delta_v_m_s=400.0)
    plan = adr_opt.solve(instance, method="greedy-guarded").plan
    assert plan is not None
    figure, (above, below) = plt.subplots(
        2, 1, figsize=(WIDTH_IN, 4.8), sharex=True, height_ratios=(3, 2)
    )
    plot.altitude(above, instance, plan)
    plot.delta_v_left(below, instance, plan)
    above.set_xlabel("")
    handles, labels = above.get_legend_handles_labels()
    figure.legend(handles, labels, ncols=3, loc="lower center", handlelength=1.2)
    figure.tight_layout(rect=(0.0, 0.17, 1.0, 1.0))
    return figure


PICTURES: dict[str, Callable[[], Any]] = {
    "sequence": sequence,
    "leg": leg,
    "timetable": timetable,
    "detour": detour,
    "connections": connections,
    "waiting": waiting,
    "drift": drift,
    "flown": flown,
    "priced": priced,
    "mission": mission,
    "approach": approach,
}


def draw(folder: Path) -> list[Path]:
    """Draw all pictures into a folder; returns their paths."""
    return save(PICTURES, folder)


def save(pictures: Mapping[str, Callable[[], Any]], folder: Path) -> list[Path]:
    """Save each picture as an SVG file of its name, all in one style; returns their paths."""
    paths = []
    folder.mkdir(parents=True, exist_ok=True)
    with plt.rc_context(STYLE):
        for name, picture in pictures.items():
            figure = picture()
            path = folder / f"{name}.svg"
            # Without the date two runs give the same bytes.
            figure.savefig(path, bbox_inches="tight", pad_inches=0.12, metadata={"Date": None})
            plt.close(figure)
            paths.append(path)
    return paths


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Draw the pictures of the documentation.")
    parser.add_argument("--out", type=Path, default=FOLDER, metavar="DIR")
    for written in draw(parser.parse_args().out):
        print(f"{written}: {written.stat().st_size / 1000:.0f} kB")
