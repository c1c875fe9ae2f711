"""Phases of a mission: their order, labels and colours.

See docs/model.md section 2. The colours are middle tones: each has at least three to one of
contrast to white and to the dark background of the report. Where bars are filled alike, they can be
told apart by readers who lack one kind of cone.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Phase:
    r"""A phase of a leg.

    Attributes
    ----------
    name : str
        What files call it.
    label : str
        What people call it.
    colour : str
        As ``#rrggbb``.
    begun_by : {"burn", "refined", ""}
        Whether burns of plans begin it, those of refined plans alone, or none.
    pattern : {"", "/", "\\", "x", "-", "."}
        What its bars are hatched with.
    """

    name: str
    label: str
    colour: str
    begun_by: str = "burn"
    pattern: str = ""


_known = [
    Phase("wait", "wait", "#9e9184", ""),
    Phase("hohmann-1", "first Hohmann", "#d61340"),
    # An arc of low thrust.
    Phase("thrust", "thrust", "#e0641e", "", "/"),
    Phase("drift", "drift orbit", "#9c6b4a", pattern="-"),
    Phase("phasing", "phasing", "#009ac3"),
    Phase("co-elliptic", "to co-elliptic", "#5f6e74"),
    Phase("terminal", "terminal Hohmann", "#de6612"),
    Phase("approach", "approach", "#a26eff"),
    # All of a leg that has no burns, or of the refined burns that the plan has none for.
    Phase("transfer", "transfer", "#5a78d8", "refined", "\\"),
    Phase("service", "service", "#227b45", ""),
    Phase("refuelling", "refuelling", "#f01aa6", ""),
    # The way of an object down to the disposal orbit.
    Phase("tow", "tow", "#6a6fb5", pattern="x"),
    # The way back of a chaser that has let an object go below its own least altitude.
    Phase("return", "return", "#a06a35", pattern="."),
]

PHASES: dict[str, Phase] = {phase.name: phase for phase in _known}
"""Phases of burns by name, with the wait before and the service after them."""

LABELS = {phase.name: phase.label for phase in _known}
COLOURS = {phase.name: phase.colour for phase in _known}


def refuse_known_phase(phase: Phase) -> None:
    """Raise :class:`ValueError` if the name of a phase is taken."""
    if phase.name in PHASES:
        raise ValueError(f"a phase {phase.name!r} is registered already")


def add_phase(phase: Phase) -> None:
    """Register a phase, which burns of plans may then begin."""
    PHASES[phase.name] = phase
    LABELS[phase.name], COLOURS[phase.name] = phase.label, phase.colour


def drop_phase(phase: Phase) -> None:
    """Remove a registered phase."""
    for table in (PHASES, LABELS, COLOURS):
        del table[phase.name]


def burn_phases() -> tuple[str, ...]:
    """Phases begun by burns of plans."""
    return tuple(phase.name for phase in PHASES.values() if phase.begun_by == "burn")


def refined_phases() -> tuple[str, ...]:
    """Phases begun by burns of refined plans."""
    return tuple(phase.name for phase in PHASES.values() if phase.begun_by)
