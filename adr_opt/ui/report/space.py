"""Sections of the page that show space, where known: orbits, altitude, nodes, planes."""

from __future__ import annotations

from ...common.wording import shortened
from ...plan.phases import COLOURS, LABELS, PHASES
from ...plan.plan import Plan
from ...plan.routes import routes_of, several
from ...problem.instance import Instance
from .tables import table
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
"""Playback speeds: seconds of the mission per second. The page begins with the slowest that plays
all of it within twenty minutes."""


def phases(shown: list[str]) -> str:
    """The legend of all charts: a button per phase that hides and shows it."""
    return "".join(
        f'<button type="button" class="phase" aria-pressed="true" data-phase="{phase}">'
        f'<i style="background-color:{COLOURS[phase]}" data-pattern="{PHASES[phase].pattern}"></i>'
        f"{LABELS[phase]}</button>"
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
        f'<option value="">all orbits</option>'
        f'<option value="legs">from leg to leg</option>{options}</select></label>'
        '<button type="button" class="file" id="film" hidden>Film</button></div>\n'
    )


def timebar(plan: Plan) -> str:
    """The bar of time and leg: a slider, a play button, speeds, legs, and what is shown."""
    speeds = "".join(f'<option value="{speed}">{said}</option>' for speed, said in SPEEDS.items())
    return (
        '<div class="timebar" role="group" aria-label="Time">'
        '<button type="button" id="play" aria-label="play">▶</button>'
        '<input type="range" id="time" min="0" max="1" step="any" value="0" '
        'aria-label="time since the epoch" aria-keyshortcuts="Space + -">'
        f'<select id="speed" aria-label="how fast time is played, a second">{speeds}</select>'
        f'<select id="leg" aria-label="leg shown">{leg_options(plan)}</select>'
        # An output speaks whenever it changes, which it does many times a second.
        '<output for="time" aria-live="off"><b id="now"></b> <span id="then"></span> '
        '<span id="doing"></span></output><p class="unseen" id="spoken" role="status"></p></div>'
    )


def path_of(instance: Instance) -> str:
    """Name of the path."""
    return "the chasers’ paths" if several(instance) else "the chaser’s path"


def globe(instance: Instance) -> str:
    """The section with the orbits and the path of the chaser; none where there is no path."""
    if instance.has_low_thrust:
        others = any(chaser.thrust_n is None for chaser in instance.chasers)
        said = (
            "visited and unvisited targets, drift orbits and tows, of each at most one revolution, "
            "and along arcs of thrust the windows in which it is on, shadow or not, as they turn "
            "with the node." + (" Chasers without low thrust are left out." if others else "")
        )
    elif instance.has_trajectories:
        flies = "the chasers fly" if several(instance) else "the chaser flies"
        bodies = f"{'station, ' if instance.stations else ''}visited and unvisited targets"
        said = f"{bodies}, and the arcs that {flies}, at most one revolution of each."
    else:
        return ""
    return (
        f'<section>\n<div class="heading"><h2>Orbits and {path_of(instance)}</h2>\n'
        f'{views(instance)}</div>\n<div class="chart tall" id="orbits"><canvas></canvas>'
        '<div class="tip" hidden></div></div>\n'
        "<details><summary>What is shown</summary><p>To scale, in the inertial frame of the "
        f"elements: {said} Marks and the Earth are as they are at the time of the slider, with day "
        "and night; once time goes on, what lies ahead is faint. Drag or arrow keys turn it; "
        "pinch, + and −, or the wheel with Ctrl come nearer; a click on an arc or a target "
        "chooses its leg.</p></details>\n</section>"
    )


def flight(instance: Instance, plan: Plan) -> str:
    """Other sections with the path of the chaser."""
    if not (instance.has_low_thrust or instance.has_trajectories):
        return ""
    said, closeup = "", _closeup(instance) + "\n"
    if instance.has_low_thrust:
        said, closeup = "Between its arcs of thrust a leg is on its drift orbit. ", ""
    return (
        f"{_ground(instance, plan)}\n{closeup}"
        f"<section>\n<h2>Altitude</h2>\n<p>{said}{_altitude_note(instance)}</p>\n"
        '<div class="chart" id="altitude"></div>\n</section>'
    )


def mass(instance: Instance) -> str:
    """The section with the chart of masses, if some chaser has low thrust."""
    if not instance.has_low_thrust:
        return ""
    return (
        "<section><h2>Mass</h2><p>With propellant and kits. It falls along arcs of thrust and "
        'tows.</p><div class="chart" id="mass"></div></section>'
    )


def _ground(instance: Instance, plan: Plan) -> str:
    """Ground tracks, and positions of the chasers."""
    who = "each chaser" if several(instance) else "the chaser"
    rows = (
        f'<tr data-chaser="{at}"><td><b>{escape(flown.chaser.name)}</b></td>'
        + "<td></td>" * 2
        + "<td class=n></td>" * 4
        + "<td></td>"
        + "</tr>"
        for at, flown in enumerate(routes_of(instance, plan))
    )
    headings = (
        ("chaser", ""),
        ("leg", ""),
        ("phase", ""),
        ("altitude km", "n"),
        ("latitude °", "n"),
        ("longitude °", "n"),
        ("from its target", "n"),
        ("Sun", ""),
    )
    return (
        f"<section>\n<h2>Over the ground</h2>\n<p>Where {who} is above the turning Earth at the "
        "time of the slider, with the way of the revolution before it and, dotted, of the next. "
        "The map is darker where it is night, and a star marks where the Sun is overhead. "
        f"{_places(instance)}Latitudes are those of a sphere. {_longitudes(instance)} "
        "Coastlines are those of Natural "
        'Earth.</p>\n<div class="chart map" id="ground"></div>\n'
        + table("Where chasers are at the time of the slider", headings, rows)
        + "\n</section>"
    )


def _places(instance: Instance) -> str:
    """Note on thick parts of the ground track, and on the accuracy of places."""
    if not instance.has_low_thrust:
        return ""
    return (
        "The way is thick where thrust is on. The plan states orbits; places on them are such that "
        "each leg begins at its origin and ends at its target. "
    )


def _longitudes(instance: Instance) -> str:
    """Note on the origin of longitudes."""
    if instance.frame is not None:
        return f"Longitudes are those of elements in {instance.frame}."
    return (
        "Longitudes take the elements to count from the equinox of date, as those of TLEs do; from "
        "that of J2000 they would be some tenths of a degree further east."
    )


def _closeup(instance: Instance) -> str:
    """The leg as seen from its target."""
    kept = instance.transfer.kept_out_m
    ball = (
        ""
        if kept is None
        else (
            " The approach is a safety ellipse: up to its last half lap, into the target, the "
            f"chaser stays out of the dotted circle of {kept:g} m, whichever burn is missed."
        )
    )
    return (
        '<section>\n<h2>Close-up</h2>\n<p><b id="closeup-leg"></b></p>\n'
        "<p>The chaser as its target sees it: along the track, ahead of the target as it flies; "
        "radial, above it; and across, to the side of its plane. Along the track the arc counts, "
        "laps included; near the target these are the axes of its local frame. It is "
        "the leg that is shown, or else the one that is flown at the time of the slider, of a long "
        f'transfer its last two days.{ball}</p>\n<div class="phases" role="group" '
        'aria-label="What of the leg"><button type="button" class="phase" '
        'data-part="transfer" aria-pressed="true">'
        'transfer</button><button type="button" class="phase" data-part="approach" '
        'aria-pressed="false">final approach</button></div>\n'
        '<div class="pair"><div class="chart" id="closeup"></div>'
        '<div class="chart" id="across"></div></div>\n</section>'
    )


def _altitude_note(instance: Instance) -> str:
    note = "Drag across to look closer, double-click to see all; the times of this chart, "
    note += "the next and the timeline go together."
    zones = len(instance.keep_out_zones)
    if zones:
        note = (
            f"{'Shaded boxes are the' if zones > 1 else 'The shaded box is the'} keep-out "
            f"{'zones' if zones > 1 else 'zone'}, closed to flight while open in time. " + note
        )
    return note


def nodes(instance: Instance) -> str:
    """The section with the chart of nodes, if they drift."""
    if not instance.nodes_drift:
        return ""
    who = (
        "thick ones are the chasers, which cross"
        if several(instance)
        else "the thick one is the chaser, which crosses"
    )
    return (
        f"<section><h2>Nodes</h2><p>How the planes drift: thin lines are bodies, {who} "
        "from one to the next on a drift orbit. The drift that bodies "
        "have in common is taken away, so that what differs shows; double-click to see all of "
        "them.</p>"
        '<div class="chart" id="nodes"></div></section>'
    )


def planes(instance: Instance) -> str:
    """The section with the chart of planes, if all bodies have one."""
    if not instance.has_orbits:
        return ""
    said = "Turning the plane costs most: neighbours here are cheap to reach."
    if instance.transfer.given is not None:
        said = "Costs are given, and need not follow from turning the plane."
    elif instance.nodes_drift:
        said += " Planes are shown as they are at the epoch; how they drift is shown above."
    said += " Numbers are those of the legs that lead there."
    return (
        f"<section>\n<h2>Planes</h2>\n<p>{said}</p>\n"
        '<div class="chart" id="planes"></div>\n</section>'
    )
