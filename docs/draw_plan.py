"""Draw the plan that moves, of README.md and index.md: an SVG file animated by its own style.

    python docs/draw_plan.py              # into docs/pictures
    python docs/draw_plan.py --out DIR

The instance and its plan are those of the library, so that the picture is the same wherever it is
drawn. Targets lie by their orbital planes: a distance in the picture is the angle of a turn.
Without animation, or where less motion is preferred, the finished plan is shown.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable, Sequence
from pathlib import Path

import adr_opt
from adr_opt.common.constants import DAY_S

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "docs/pictures"
NAME = "nominal-000"
LOOP_S, HOLD_S = 21.0, 3.0
WIDTH, HEIGHT = 720, 400
LEFT, MIDDLE, SCALE = 215.0, 200.0, 165.0
"""Where the station lies, and pixels a degree."""
INK, FAINT, TRACK, DONE = "#26313d", "#c3cad2", "#3f7fc4", "#e2722b"
GROUND = "#fcfcfa"
TANK = (640.0, 110.0, 34.0, 230.0)
"""Left, top, width and height of the tank."""


def frames(name: str, steps: Iterable[tuple[float, str]]) -> str:
    """Keyframes from (share of the loop, declaration), in order."""
    return f"@keyframes {name}{{" + "".join(f"{100 * at:.2f}%{{{do}}}" for at, do in steps) + "}"


def counter(name: str, at: tuple[float, float], labels: Sequence[str], times: list[float]) -> str:
    """Text that changes at each of the times: a column of labels, moved behind a window."""
    steps = [(time, f"transform:translateY({-40 * k}px)") for k, time in enumerate(times)]
    steps.append((1.0, f"transform:translateY({-40 * (len(labels) - 1)}px)"))
    column = "".join(f'<text y="{40 * k + 30}">{label}</text>' for k, label in enumerate(labels))
    last = f"transform:translateY({-40 * (len(labels) - 1)}px)"
    shown = f"{last};animation:{name} {LOOP_S}s step-end infinite"
    return (
        f"<style>{frames(name, steps)}.{name}{{{shown}}}</style>"
        f'<svg x="{at[0]}" y="{at[1]}" width="180" height="40" font-size="22" font-weight="600">'
        f'<g class="{name}">{column}</g></svg>'
    )


def draw(folder: Path) -> Path:
    """Draw the plan into a folder; returns the file."""
    instance = adr_opt.load(ROOT / f"instances/nominal/{NAME}.json")
    plan = adr_opt.load_plan(ROOT / f"instances/best-known/{NAME}.json")
    station = instance.stations[0]
    tank = instance.chasers[0].tank.delta_v_m_s
    assert tank is not None
    end = instance.mission.duration_s
    shown = 1.0 - HOLD_S / LOOP_S

    def share(seconds: float) -> float:
        return shown * seconds / end

    def place(name: str) -> tuple[float, float]:
        orbit = station.orbit if name == station.name else targets[name].orbit
        assert orbit is not None
        assert station.orbit is not None
        turn = (orbit.raan_deg - station.orbit.raan_deg + 180.0) % 360.0 - 180.0
        x = turn * math.sin(math.radians(orbit.inclination_deg))
        y = orbit.inclination_deg - station.orbit.inclination_deg
        return round(LEFT + SCALE * x, 1), round(MIDDLE - SCALE * y, 1)

    targets = {target.name: target for target in instance.targets}
    styles, marks, tracks = [], [], []
    x, y = place(station.name)
    moves = [(0.0, f"transform:translate({x}px,{y}px)")]
    level, visits, times = [(0.0, "transform:scaleY(1)")], 0, [0.0]
    left = tank
    for k, leg in enumerate(plan.legs):
        begun, there = share(leg.departure_s), share(leg.arrival_s)
        (x, y), (to_x, to_y) = place(leg.origin), place(leg.destination)
        length = math.hypot(to_x - x, to_y - y)
        hidden, seen = f"stroke-dashoffset:{length:.1f}", "stroke-dashoffset:0"
        styles.append(
            frames(f"t{k}", [(0.0, hidden), (begun, hidden), (there, seen), (1.0, seen)])
            + f".t{k}{{stroke-dasharray:{length:.1f};animation:t{k} {LOOP_S}s linear infinite}}"
        )
        tracks.append(f'<path class="t t{k}" d="M{x} {y}L{to_x} {to_y}"/>')
        moves += [
            (begun, f"transform:translate({x}px,{y}px)"),
            (there, f"transform:translate({to_x}px,{to_y}px)"),
        ]
        level.append((begun, f"transform:scaleY({left / tank:.4f})"))
        left -= leg.delta_v_m_s
        level.append((there, f"transform:scaleY({left / tank:.4f})"))
        left = leg.delta_v_left_m_s
        level.append((share(leg.end_s), f"transform:scaleY({left / tank:.4f})"))
        if leg.destination in targets:
            visits += 1
            times.append(share(leg.end_s))
            styles.append(
                frames(
                    f"d{k}",
                    [
                        (0.0, f"fill:{FAINT}"),
                        (times[-1], f"fill:{FAINT}"),
                        (times[-1] + 0.004, f"fill:{DONE}"),
                        (1.0, f"fill:{DONE}"),
                    ],
                )
                + f".d{k}{{fill:{DONE};animation:d{k} {LOOP_S}s linear infinite}}"
            )
            marks.append(f'<circle class="d{k}" cx="{to_x}" cy="{to_y}" r="5"/>')
    for name in targets.keys() - {leg.destination for leg in plan.legs}:
        x, y = place(name)
        marks.append(f'<circle fill="{FAINT}" cx="{x}" cy="{y}" r="5"/>')
    marks.sort()
    moves.append((1.0, moves[-1][1]))
    level.append((1.0, level[-1][1]))
    styles += [
        frames("chaser", moves),
        f".chaser{{{moves[-1][1]};animation:chaser {LOOP_S}s linear infinite}}",
        frames("level", level),
        f".level{{transform-box:fill-box;transform-origin:bottom;{level[-1][1]};"
        f"animation:level {LOOP_S}s linear infinite}}",
        f".t{{stroke:{TRACK};stroke-width:1.6;fill:none}}",
        "@media(prefers-reduced-motion:reduce){*{animation:none!important}}",
    ]
    x, y = place(station.name)
    days = [k / 4 for k in range(round(4 * end / DAY_S) + 1)]
    ticks = [share(day * DAY_S) for day in days]
    bar_x, bar_y, wide, high = TANK
    text = f"""<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" \
width="{WIDTH}" height="{HEIGHT}" font-family="Helvetica,Arial,sans-serif" fill="{INK}">
<title>A chaser services {visits} of {len(targets)} targets in {end / DAY_S:g} days</title>
<style>{"".join(styles)}</style>
<rect width="{WIDTH}" height="{HEIGHT}" fill="{GROUND}"/>
<g font-size="13" fill="#5b6773"><text x="20" y="22">inclination ↑</text>
<text x="{2 * LEFT - 5:g}" y="390" text-anchor="end">node →</text></g>
{"".join(tracks)}
{"".join(marks)}
<path d="M{x} {y - 9}l9 9l-9 9l-9 -9z" fill="{INK}"/>
<circle class="chaser" r="7" fill="{TRACK}" stroke="{GROUND}" stroke-width="2"/>
{counter("day", (450, 40), [f"day {day:.2f}" for day in days], ticks)}
{counter("visits", (450, 84), [f"{k} visit" + "s" * (k != 1) for k in range(visits + 1)], times)}
<rect x="{bar_x}" y="{bar_y}" width="{wide}" height="{high}" fill="none" stroke="{FAINT}"/>
<rect class="level" x="{bar_x}" y="{bar_y}" width="{wide}" height="{high}" fill="{TRACK}"/>
<g font-size="13"><text x="{bar_x + wide / 2}" y="{bar_y - 10}" text-anchor="middle">ΔV left</text>
<path d="M456 164l7 7l-7 7l-7 -7z"/><text x="474" y="176">station (refuels)</text>
<circle cx="456" cy="201" r="6" fill="{TRACK}"/><text x="474" y="206">chaser</text>
<circle cx="456" cy="231" r="5" fill="{DONE}"/><text x="474" y="236">serviced target</text>
<circle cx="456" cy="261" r="5" fill="{FAINT}"/><text x="474" y="266">target</text>
<text x="450" y="306">A distance is an angle</text>
<text x="450" y="324">between orbital planes.</text></g>
</svg>
"""
    path = folder / "plan.svg"
    path.write_text(text, encoding="utf-8")
    return path


def main() -> None:
    """Read the options and draw."""
    parser = argparse.ArgumentParser(description="Draw the plan that moves.")
    parser.add_argument("--out", type=Path, default=FOLDER, help="folder to write to")
    print(draw(parser.parse_args().out))


if __name__ == "__main__":
    main()
