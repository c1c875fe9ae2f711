"""Settings of the search, and its two presets.

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
planes and phases are spread (docs/model.md section 7).
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

from adr_opt.common.options import Options, option

FROM_PRESET = -1
"""Option value that leaves a number to the preset; for a text option, ``"preset"``."""

TO_THE_END = 1_000_000_000
"""Rollout depth, or number of missions, without a limit."""

ITS_OWN = "the value of the preset"


@dataclass(frozen=True)
class MctsOptions(Options, method="mcts"):
    """Options of the planner ``mcts``, and the settings of a search."""

    preset: str = option(
        "published", "Supplies all options left at −1 or `preset`.", choices=("published", "tuned")
    )
    simulations: int = option(
        FROM_PRESET, "Number of simulations per step.", least=1, most=1_000_000, unset=ITS_OWN
    )
    depth: int = option(
        FROM_PRESET, "Maximum length of a rollout, in moves.", least=1, unset=ITS_OWN
    )
    c: float = option(
        float(FROM_PRESET), "Exploration constant: Q + c √(ln N / n).", above=0.0, unset=ITS_OWN
    )
    rollout: str = option(
        "preset",
        "`uniform`: legal moves with equal probability. `guarded`: targets from which the station "
        "can still be reached, cheaper ones with higher probability, or else the station.",
        choices=("uniform", "guarded", "preset"),
    )
    moves: str = option(
        "preset",
        "Branches of the tree. `legal`: all legal moves in random order. `guarded`: the cheapest "
        "targets from which the station can still be reached, in order of cost, and the station.",
        choices=("legal", "guarded", "preset"),
    )
    width: int = option(
        FROM_PRESET, "Maximum number of targets among guarded moves.", least=1, unset=ITS_OWN
    )
    time_value_m_s_per_h: float = option(
        float(FROM_PRESET),
        "Value of time: a guarded move costs ΔV + value · (time to the end of service).",
        unit="m/s per h",
        above=0.0,
        unset=ITS_OWN,
    )
    temperature_m_s: float = option(
        float(FROM_PRESET),
        "Temperature of guarded rollouts: moves have the weight exp(−cost / temperature).",
        unit="m/s",
        above=0.0,
        unset=ITS_OWN,
    )
    scale: str = option(
        "preset",
        "`none`: returns in prizes. `range`: returns over their range in the mission, so that c "
        "is independent of the size of prizes.",
        choices=("none", "range", "preset"),
    )
    best_share: float = option(
        float(FROM_PRESET),
        "Share of the best return in Q; the rest is the mean return.",
        least=0.0,
        most=1.0,
        unset=ITS_OWN,
    )
    play: str = option(
        "preset",
        "Child to play: most `visits`, or highest Q (`value`).",
        choices=("visits", "value", "preset"),
    )
    tree: str = option(
        "preset",
        "Tree at each step: `new`, or `kept` from below the child played.",
        choices=("new", "kept", "preset"),
    )
    missions: int = option(
        FROM_PRESET, "Maximum number of missions played.", least=1, unset=ITS_OWN
    )
    answer: str = option(
        "preset",
        "Plan returned: the best mission `played`, or the `best` sequence of any simulation (ties: "
        "least ΔV).",
        choices=("played", "best", "preset"),
    )
    polish: int = option(
        0,
        "Maximum number of open-loop polishing steps at the end: each keeps the plan up to a "
        "random move and builds a new end with a narrow beam. Not part of the published method.",
        least=0,
    )
    policy: str = option(
        "",
        "A learned policy as prior, `policy` or a file written by `train`: moves are "
        "tried in its order, and every step begins a new tree.",
    )


PUBLISHED = MctsOptions(
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

TUNED = MctsOptions(
    preset="tuned",
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
"""Guarded rollouts on a narrow tree, repeated until the stopping criterion is met."""

PRESETS = {"published": PUBLISHED, "tuned": TUNED}


def settings_of(options: MctsOptions) -> MctsOptions:
    """The options with values of their preset where left open."""
    given = {
        each.name: value
        for each in fields(options)
        if (value := getattr(options, each.name)) != each.default
    }
    return replace(PRESETS[options.preset], **given)
