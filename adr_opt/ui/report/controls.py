"""Controls of the page: leg, phases and displayed time."""

from __future__ import annotations

from ...common.wording import shortened
from ...plan.phases import COLOURS, LABELS
from ...plan.plan import Plan
from ...problem.instance import Instance
from .text import escape

LONGEST_OPTION = 18
"""Length beyond which names are cut in the list of legs, to fit a phone."""

SPEEDS = {
    1: "×1",
    10: "×10",
    60: "1 min/s",
    600: "10 min/s",
    3600: "1 h/s",
    21600: "6 h/s",
    86400: "1 d/s",
    1000000: "×10⁶",
}
"""How fast time may be played: seconds of the mission a second. The page begins with the slowest
that plays all of it within twenty minutes."""


def phases(shown: list[str]) -> str:
    """The legend of all charts: a button per phase that hides and shows it."""
    return "".join(
        f'<button type="button" class="phase" aria-pressed="true" data-phase="{phase}">'
        f'<i style="background:{COLOURS[phase]}"></i>{LABELS[phase]}</button>'
        for phase in shown
    )


def leg_options(plan: Plan) -> str:
    """Entries of the list of legs."""
    legs = plan.legs
    short = shortened((n for leg in legs for n in (leg.origin, leg.destination)), LONGEST_OPTION)
    options = "".join(
        f'<option value="{at}">{at}: {escape(short[leg.origin])} → '
        f"{escape(short[leg.destination])}</option>"
        for at, leg in enumerate(legs, start=1)
    )
    return f'<option value="0">the whole mission</option>{options}'


def views(instance: Instance) -> str:
    """Choice of a chaser that the view of the orbits follows."""
    options = "".join(
        f'<option value="{at}">follow {escape(chaser.name)}</option>'
        for at, chaser in enumerate(instance.chasers)
    )
    return (
        '<div class="controls views"><label>View <select id="view">'
        f'<option value="">all orbits</option>{options}</select></label>'
        "<span>Drag or arrow keys turn it; pinch, scroll or + and − come nearer.</span></div>\n"
    )


def timebar() -> str:
    """The time that is shown: a slider, a button that plays it, how fast, and what it comes to."""
    speeds = "".join(f'<option value="{speed}">{said}</option>' for speed, said in SPEEDS.items())
    return (
        '<div class="timebar" role="group" aria-label="Time">'
        '<button type="button" id="play" aria-label="play">▶</button>'
        '<input type="range" id="time" min="0" max="1" step="any" value="0" '
        'aria-label="time since the epoch" aria-keyshortcuts="Space + -">'
        f'<select id="speed" aria-label="how fast time is played, a second">{speeds}</select>'
        # An output speaks whenever it changes, which it does many times a second.
        '<output for="time" aria-live="off"><b id="now"></b> <span id="then"></span> '
        '<span id="doing"></span></output><p class="unseen" id="spoken" role="status"></p></div>'
    )
