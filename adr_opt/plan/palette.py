"""The phases of a mission: their order, what people call them, and one colour for each.

The colours are middle tones: each has at least three to one of contrast to white and to the dark
background of the report.
"""

from __future__ import annotations

from ..problem.instance import Instance
from .routes import several

PHASES = (
    "wait", "hohmann-1", "drift", "phasing", "co-elliptic", "terminal", "approach", "transfer",
    "service", "refuelling", "tow",
)  # fmt: skip
"""The phases of burns, with the wait before them and the service after them.

See docs/model.md section 2.

"transfer" is all of a leg that has no burns, because its costs are given; "tow" is the way of an
object down to the disposal orbit.
"""

LABELS = {
    "wait": "wait",
    "hohmann-1": "first Hohmann",
    "drift": "drift orbit",
    "phasing": "phasing",
    "co-elliptic": "to co-elliptic",
    "terminal": "terminal Hohmann",
    "approach": "approach",
    "transfer": "transfer",
    "service": "service",
    "refuelling": "refuelling",
    "tow": "tow",
}

COLOURS = {
    "wait": "#8490a0",
    "hohmann-1": "#d4553f",
    "drift": "#9c6b4a",
    "phasing": "#3f7fc4",
    "co-elliptic": "#1f9687",
    "terminal": "#c07f12",
    "approach": "#a765b8",
    "transfer": "#5a78d8",
    "service": "#5f9438",
    "refuelling": "#d2508f",
    "tow": "#6a6fb5",
}

CHASERS = ("#6d5fe0", "#d9681d", "#1791b5", "#8a8f1e", "#c542c0", "#2f9a5d", "#d4486a", "#5f7d95")
"""Where there are several chasers, each has one of these, in the order of the instance; none is
that of a phase."""

ZONE = "#d4553f"
STATION = COLOURS["refuelling"]
VISITED = COLOURS["service"]
UNVISITED = COLOURS["wait"]

REASONS = {
    "no-transfer": "no body has a transfer to it that leaves time for service",
    "duration": "one more leg to it would end too late for the mission, or for its window",
    "delta-v": "one more leg to it, in time, would need more ΔV than is left",
    "capacity": "its chaser has no kit left for it, or services as many as it may",
    "not-worth-it": "it could still be added at the end, and the plan does not",
    "not-considered": "nobody looked for a way: the time or the memory did not allow it",
}
"""What the reasons of a plan's unvisited targets mean."""


def chaser_colours(instance: Instance) -> dict[str, str]:
    """The colour of each chaser; of the only one that of phasing."""
    if not several(instance):
        return {instance.chasers[0].name: COLOURS["phasing"]}
    return {chaser.name: CHASERS[at % len(CHASERS)] for at, chaser in enumerate(instance.chasers)}
