"""Frames per second of the report while time is played, in a headless Chromium.

    python bench/report_frames.py
    python bench/report_frames.py --seconds 5 --width 390 --options=--disable-3d-apis

Plays a mission with the globe in the window, with the map, and with a chaser followed, and counts
for each the pictures that are drawn, the frames of the browser, and the longest time between two
of these. Without a graphics card WebGL runs on the processor, and pictures are drawn as often as
leaves the page time to answer.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from machine import heading

import adr_opt
from adr_opt.ui.report import write_report

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/oracles"))

from browser import Browser

COUNTED = """new Promise((done) => {{
  const chart = document.getElementById('{chart}');
  let [drawn, frames, longest, before] = [0, 0, 0, performance.now()];
  const began = before;
  const one = () => {{ drawn += 1; }};
  chart.on('{event}', one);
  document.getElementById('play').click();
  const frame = () => {{
    const now = performance.now();
    frames += 1;
    longest = Math.max(longest, now - before);
    before = now;
    if (now - began < {ms}) {{ requestAnimationFrame(frame); return; }}
    document.getElementById('play').click();
    chart.removeListener('{event}', one);
    const seconds = (now - began) / 1000;
    done([drawn / seconds, frames / seconds, longest]);
  }};
  requestAnimationFrame(frame);
}})"""

VIEWS = (
    ("globe", "orbits", "plotly_update", ""),
    ("globe, followed", "orbits", "plotly_update", "0"),
    ("map", "ground", "plotly_react", ""),
)
"""Name, chart, event of a picture that is drawn, and what is chosen as view."""


def main() -> None:
    """Measure and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seconds", type=float, default=10.0, help="of play for each view")
    parser.add_argument("--width", type=int, default=1280, help="of the window [px]")
    parser.add_argument("--speed", type=int, default=600, help="seconds of the mission a second")
    parser.add_argument("--options", nargs="*", default=[], help="of Chromium")
    given = parser.parse_args()
    instance = adr_opt.generate("nominal", 0)
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    print(heading())
    print(f"{instance.name}, {len(plan.legs)} legs, {given.width} px, {given.seconds:g} s each")
    print(f"{'':16s} {'pictures/s':>10s} {'frames/s':>9s} {'longest ms':>11s}")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mission.html"
        write_report(instance, plan, path)
        options = tuple(given.options)
        with Browser(Path(folder) / "profile", width=given.width, options=options) as tab:
            tab.open_report(path)
            tab.evaluate(
                f"((list) => {{ list.value = '{given.speed}';"
                " list.dispatchEvent(new Event('change')); })(document.getElementById('speed'))"
            )
            for name, chart, event, view in VIEWS:
                tab.evaluate(f"document.getElementById('{chart}').scrollIntoView()")
                tab.wait_for(f"Boolean(document.getElementById('{chart}').on)")
                tab.evaluate(
                    f"((list) => {{ list.value = '{view}';"
                    " list.dispatchEvent(new Event('change')); })(document.getElementById('view'))"
                )
                script = COUNTED.format(chart=chart, event=event, ms=1000.0 * given.seconds)
                pictures, frames, longest_ms = tab.evaluate(script)
                print(f"{name:16s} {pictures:10.1f} {frames:9.1f} {longest_ms:11.0f}")


if __name__ == "__main__":
    main()
