"""The beam-search planner: one deterministic search of a given width."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from adr_opt.common.clock import now_s
from adr_opt.common.options import Options, option
from adr_opt.common.processors import usable_cores
from adr_opt.common.progress import Progress, tell_plan
from adr_opt.common.stop import Stop
from adr_opt.learning.decoding import Field
from adr_opt.learning.policy import load_policy
from adr_opt.learning.policy_beam import PolicyBeamSettings as PolicyBeam
from adr_opt.learning.policy_beam import beam as beam_by_policy
from adr_opt.mission.certified import certify
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result

from ..beams.beams import USUAL, BeamSettings, with_time_value
from ..beams.exchange_rates import worth_of
from ..beams.timely_beams import Beams, pilots
from ..progress.incumbent import Incumbent


@dataclass(frozen=True)
class BeamOptions(Options, method="beam"):
    """Options of the planner ``beam``."""

    width: int = option(
        2000,
        "Partial plans kept per level; time and memory are proportional to it.",
        least=1,
        most=1_000_000,
    )
    time_value_m_s_per_h: float = option(
        USUAL,
        "Value of time: of all connections to a target, the one of least ΔV + value · (arrival − "
        "ready) is considered; the plan is then flown at its best schedule over all. Below 0: "
        "110, and less where planes drift.",
        unit="m/s per h",
    )
    time_weight: float = option(
        1.0,
        "Worth of an hour left when partial plans are compared, as a multiple of the estimate for "
        "the mission.",
        least=0.0,
    )
    delta_v_weight: float = option(
        1.0,
        "Worth of a km/s left when partial plans are compared, as a multiple of the estimate for "
        "the mission.",
        least=0.0,
    )
    crowding: float = option(
        1.7,
        "Maximum number of partial plans per body, as a multiple of an equal share.",
        least=1.0,
        most=math.inf,
    )
    noise: float = option(
        0.0,
        "Random part in comparing partial plans, drawn with the seed.",
        unit="mean prizes",
        least=0.0,
    )
    policy: str = option(
        "",
        "A learned policy as prior, `policy` or a file written by `train`: partial "
        "plans are also compared by the probability of their moves, so that a width of some "
        "hundred is enough. Crowding and noise are then ignored.",
    )
    prior_weight: float = option(
        0.05,
        "Worth of a unit of log-probability of the policy when partial plans are compared.",
        unit="mean prizes",
        least=0.0,
    )


def beam(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    options: BeamOptions = BeamOptions(),
) -> Result:
    """Beam search, level by level over visits, keeping the best partial plans of each level.

    Deterministic as long as the time allows the whole width. A narrow search first tells how much
    it does allow; one that is late all the same is hurried to its end.
    """
    began = now_s()
    mission = with_time_value(mission, options.time_value_m_s_per_h)
    best = Incumbent(mission)
    states, notes = 0, tuple[str, ...]()
    if options.policy:
        states, notes = _by_policy(mission, best, options, stop)
    elif not stop(-math.inf, math.inf):
        worth = worth_of(mission)
        settings = BeamSettings(
            width=options.width,
            time_weight=options.time_weight * worth.hour,
            delta_v_weight=options.delta_v_weight * worth.kilometre_per_s,
            crowding=options.crowding,
            noise=options.noise * worth.prize,
        )
        beams = Beams(mission, stop)
        for each in sorted(
            {min(width, options.width) for width in (*pilots(mission), options.width)}
        ):
            if best.offer(beams.search(replace(settings, width=each), seed=seed)):
                tell_plan(progress, best.objective, best.sequence or ())
        states = beams.states
    return certify(
        mission,
        "beam",
        best.sequence or (),
        seed=seed,
        runtime_s=now_s() - began,
        counters={"width": options.width, "states": states},
        notes=notes,
    )


def _by_policy(
    mission: Mission, best: Incumbent, options: BeamOptions, stop: Stop
) -> tuple[int, tuple[str, ...]]:
    """Offer the best plan of a beam guided by a learned policy.

    Returns
    -------
    states : int
        States judged.
    notes : tuple of str
        What to say of the policy.
    """
    threads = usable_cores()
    learned = load_policy(options.policy)
    if not mission.instance.targets:
        return 0, ()
    worth = worth_of(mission)
    quick = Incumbent(mission, by_choice=True)
    states = beam_by_policy(
        Field(mission, learned, threads),
        PolicyBeam(
            options.width,
            options.prior_weight,
            options.time_weight * worth.hour,
            options.delta_v_weight * worth.kilometre_per_s,
        ),
        quick.offer,
        lambda: bool(stop(-math.inf, math.inf)),
    )
    best.offer(quick.sequence or ())
    return states, learned.notes(mission)
