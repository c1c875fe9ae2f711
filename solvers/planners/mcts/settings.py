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
planes and phases are spread (docs/model.md section 7).
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

from adr_opt.common.options import Options, option

FROM_PRESET = -1
"""Option value that leaves a number to the preset; a text option says ``"preset"``."""

TO_THE_END = 1_000_000_000
"""Rollout depth, or number of missions, without a limit."""

ITS_OWN = "the value of the preset"


@dataclass(frozen=True)
class MctsOptions(Options, method="mcts"):
    """Options of the planner ``mcts``, and the settings of a search."""

    preset: str = option(
        "published",
        "Sets every option that is left at −1 or `preset`.",
        choices=("published", "tuned"),
    )
    simulations: int = option(
        FROM_PRESET, "Simulations per step.", least=1, most=1_000_000, unset=ITS_OWN
    )
    depth: int = option(FROM_PRESET, "Most moves of a rollout.", least=1, unset=ITS_OWN)
    c: float = option(
        float(FROM_PRESET), "Exploration constant: Q + c √(ln N / n).", above=0.0, unset=ITS_OWN
    )
    rollout: str = option(
        "preset",
        "`uniform`: any legal move with equal probability. `guarded`: a target from which the "
        "station can still be reached, the cheaper the likelier, and the station when there is "
        "none.",
        choices=("uniform", "guarded", "preset"),
    )
    moves: str = option(
        "preset",
        "Branches of the tree. `legal`: every legal move in random order. `guarded`: the cheapest "
        "targets that pass the same guard, cheapest first, and the station.",
        choices=("legal", "guarded", "preset"),
    )
    width: int = option(
        FROM_PRESET, "Most targets among the guarded moves.", least=1, unset=ITS_OWN
    )
    time_value_m_s_per_h: float = option(
        float(FROM_PRESET),
        "Cost of a guarded move: ΔV + this · (time to the end of service).",
        unit="m/s per h",
        above=0.0,
        unset=ITS_OWN,
    )
    temperature_m_s: float = option(
        float(FROM_PRESET),
        "Scale of the weight exp(−cost / temperature) of a guarded move in rollouts.",
        unit="m/s",
        above=0.0,
        unset=ITS_OWN,
    )
    scale: str = option(
        "preset",
        "`none`: returns as they are, in prizes. `range`: divided by the range of returns of the "
        "mission, so that c means the same at every size of prize.",
        choices=("none", "range", "preset"),
    )
    best_share: float = option(
        float(FROM_PRESET),
        "Q is the mean return plus this share of the way to the best.",
        least=0.0,
        most=1.0,
        unset=ITS_OWN,
    )
    play: str = option(
        "preset",
        "The child with most visits, or with the highest Q.",
        choices=("visits", "value", "preset"),
    )
    tree: str = option(
        "preset",
        "Every step begins a `new` tree, or goes on with the one `kept` below the child played.",
        choices=("new", "kept", "preset"),
    )
    missions: int = option(FROM_PRESET, "Most missions to play.", least=1, unset=ITS_OWN)
    answer: str = option(
        "preset",
        "The best mission `played`, or the `best` sequence of any simulation (ties: less ΔV).",
        choices=("played", "best", "preset"),
    )
    polish: int = option(
        0,
        "Open-loop polish at the end, as long as there is time: so often, keep the beginning of "
        "the plan up to a random move and build a new end by a narrow beam. Not part of the "
        "published method.",
        least=0,
    )
    policy: str = option(
        "",
        "A learned policy as prior, `set` or a file that `train` wrote (extra `[ppo]`): the moves "
        "that it likes are tried first, and every step begins a new tree.",
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
"""Guarded rollouts on a narrow tree, again and again until the stopping criterion says enough."""

PRESETS = {"published": PUBLISHED, "tuned": TUNED}


def settings_of(options: MctsOptions) -> MctsOptions:
    """The options with the values of their preset in place of those that are left to it."""
    given = {
        each.name: value
        for each in fields(options)
        if (value := getattr(options, each.name)) != each.default
    }
    return replace(PRESETS[options.preset], **given)
