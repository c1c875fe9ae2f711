"""The sections of the page that show space: orbits, altitude, nodes, planes, where it is known."""

from __future__ import annotations

from ..instance import Instance
from ..routes import several


def path_of(instance: Instance) -> str:
    """What the path is called."""
    return "the chasers’ paths" if several(instance) else "the chaser’s path"


def flight(instance: Instance) -> str:
    """The sections with the path of the chaser."""
    if instance.transfer.given is not None:
        return ""
    flies = "the chasers fly" if several(instance) else "the chaser flies"
    return (
        f"<section>\n<h2>Orbits and {path_of(instance)}</h2>\n"
        "<p>To scale, in the inertial frame of the elements: station, visited and unvisited "
        f"targets, and\nthe arcs that {flies}, at most one revolution of each. Drag to turn, pinch "
        'or scroll to\ncome nearer.</p>\n<div class="chart tall" id="orbits"></div>\n</section>\n'
        f"<section>\n<h2>Altitude</h2>\n<p>{_altitude_note(instance)}</p>\n"
        '<div class="chart" id="altitude"></div>\n</section>'
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
    """The section with the chart of nodes, where they drift."""
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
    """The section with the chart of planes, where all bodies have one."""
    if not instance.has_orbits:
        return ""
    said = "Turning the plane is what costs most: near neighbours here are cheap to reach."
    if instance.transfer.given is not None:
        said = "Costs are given: they need not be those of turning the plane."
    elif instance.nodes_drift:
        said += " Planes are shown as they are at the epoch; how they drift is shown above."
    return (
        f"<section>\n<h2>Planes</h2>\n<p>{said}</p>\n"
        '<div class="chart" id="planes"></div>\n</section>'
    )
