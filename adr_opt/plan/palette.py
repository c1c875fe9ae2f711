"""Colours of everything but phases: chasers, stations, zones and targets."""

from __future__ import annotations

from ..problem.instance import Instance
from .phases import COLOURS
from .routes import several

CHASERS = ("#6d5fe0", "#d9681d", "#1791b5", "#8a8f1e", "#c542c0", "#2f9a5d", "#d4486a", "#5f7d95")
"""Colours of several chasers, in the order of the instance; none is that of a phase."""

ZONE = "#d4553f"
STATION = COLOURS["refuelling"]
VISITED = COLOURS["service"]
UNVISITED = COLOURS["wait"]

REASONS = {
    "no-transfer": "no leg reaches it from the end of the plan, even with larger limits",
    "several": "one more leg to it would exceed several limits at once",
    "duration": "one more leg to it would end too late for the mission, or for its window",
    "delta-v": "one more leg to it, in time, would need more ΔV than is left",
    "kits": "one more leg would reach it, but its chaser has no kit left for it",
    "capacity": "one more leg would reach it, but its chaser services as many targets as allowed",
    "not-worth-it": "it could still be added at the end, but the plan leaves it out",
    "not-considered": "not considered: time or memory ran out",
}
"""Meaning of the reasons for unvisited targets."""

REASON_TITLES = {reason: reason.replace("-", " ") for reason in REASONS} | {
    "several": "several limits",
    "delta-v": "ΔV",
}


def chaser_colours(instance: Instance) -> dict[str, str]:
    """Colour of each chaser; an only chaser has that of phasing."""
    if not several(instance):
        return {instance.chasers[0].name: COLOURS["phasing"]}
    return {chaser.name: CHASERS[at % len(CHASERS)] for at, chaser in enumerate(instance.chasers)}
