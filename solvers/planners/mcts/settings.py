"""What can be set in the search, and the two presets.

The published study states three numbers, c = 1.5, 200 simulations per step, rollouts 15 moves deep,
and that the rollouts are random (sections "Monte Carlo Tree Search" and appendix C). Everything
else in :data:`PUBLISHED` is the plain reading: the return of a simulation is the number of targets
(the prizes) from the present state to the end of its rollout, unscaled; rollouts draw from all
legal moves, the station included; every step begins a new tree; the most visited move is played.

On the reference scenario this visits far fewer targets than the study reports, and no other
reading of the text closes the gap. Those that are options (``play=value``, longer rollouts, many
more simulations) are in docs/benchmarks.md. Prototypes of others, not kept, made no more of it:
the return of the rollout without the path to it, depth counted from the root, −1 for a rollout
that cannot move, refuelling only when nothing else is legal.

So the difference is hardly in the search. What is left is the field: the study does not say how
planes and phases are spread (MODEL section 7).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import Any

from adr_opt.errors import InputError

FROM_PRESET = -1
"""Option value that leaves a number to the preset; a text option says ``"preset"``."""

TO_THE_END = 1_000_000_000
"""Rollout depth, or number of missions, without a limit."""

CHOICES = {
    "rollout": ("uniform", "guarded"),
    "moves": ("legal", "guarded"),
    "play": ("visits", "value"),
    "scale": ("none", "range"),
    "tree": ("new", "kept"),
    "answer": ("played", "best"),
}
"""What the text options may say."""


@dataclass(frozen=True)
class Settings:
    """The settings of a search; see :func:`solvers.planners.mcts.mcts` for what each does."""

    simulations: int
    depth: int
    c: float
    rollout: str
    moves: str
    width: int
    time_value_m_s_per_h: float
    temperature_m_s: float
    scale: str
    best_share: float
    play: str
    tree: str
    missions: int
    answer: str


PUBLISHED = Settings(
    simulations=200,
    depth=15,
    c=1.5,
    rollout="uniform",
    moves="legal",
    width=TO_THE_END,
    time_value_m_s_per_h=1000.0,
    temperature_m_s=50.0,
    scale="none",
    best_share=0.0,
    play="visits",
    tree="new",
    missions=1,
    answer="played",
)
"""UCT as published; ``width`` and the two guarded weights are not used."""

TUNED = Settings(
    simulations=1000,
    depth=TO_THE_END,
    c=0.25,
    rollout="guarded",
    moves="guarded",
    width=4,
    time_value_m_s_per_h=1000.0,
    temperature_m_s=50.0,
    scale="range",
    best_share=0.5,
    play="visits",
    tree="kept",
    missions=TO_THE_END,
    answer="best",
)
"""Guarded rollouts on a narrow tree, again and again until the stopping criterion says enough."""

PRESETS = {"published": PUBLISHED, "tuned": TUNED}


def choose(preset: str, options: dict[str, Any]) -> Settings:
    """The settings of a preset with the options that were given in place of its own.

    Raises
    ------
    InputError
        Unknown preset or word, or a number that is not positive.
    """
    if preset not in PRESETS:
        raise InputError(
            f"option preset = {preset!r} of method 'mcts': use one of {', '.join(PRESETS)}"
        )
    given: dict[str, Any] = {}
    for field in fields(Settings):
        name, value = field.name, options[field.name]
        if name in CHOICES:
            if value == "preset":
                continue
            if value not in CHOICES[name]:
                known = ", ".join(CHOICES[name])
                raise InputError(
                    f"option {name} = {value!r} of method 'mcts': use one of {known}, preset"
                )
        else:
            if value == FROM_PRESET:
                continue
            if name == "best_share":
                if not 0.0 <= value <= 1.0:
                    raise InputError(
                        f"option {name} = {value!r} of method 'mcts': must be between 0 and 1"
                    )
            elif not value > 0 or not math.isfinite(value):
                raise InputError(
                    f"option {name} = {value!r} of method 'mcts': must be positive and finite, "
                    f"or {FROM_PRESET} for the value of the preset"
                )
        given[name] = value
    return replace(PRESETS[preset], **given)
