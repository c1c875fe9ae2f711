"""The learned planner: decoding of a trained policy."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from adr_opt.common.clock import now_s
from adr_opt.common.errors import InputError
from adr_opt.common.options import MOST_JOBS, Options, option
from adr_opt.common.processors import usable_cores
from adr_opt.common.progress import Progress, tell_plan
from adr_opt.common.stop import Stop
from adr_opt.learning.decoding import Field, play
from adr_opt.learning.policy import SHIPPED, load_policy
from adr_opt.learning.policy_beam import PolicyBeamSettings, beam
from adr_opt.mission.certified import certify
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result

from ..progress.incumbent import Incumbent

PUNCTUAL = 0.9
"""Share of the remaining time that a beam may be expected to take."""
PRIOR_WEIGHT = 0.05
"""Worth of a unit of log-probability in a beam [targets]."""

BATCH = 64
"""Number of samples played concurrently."""


@dataclass(frozen=True)
class PpoOptions(Options, method="ppo"):
    """Options of the planner ``ppo``."""

    policy: str = option("", "A file written by `train`; the policy of the package if empty.")
    decode: str = option(
        "greedy",
        "`greedy`: the best-scored move at each step, within milliseconds. `sample`: the best of "
        "many plans drawn from the policy with the seed, the greedy plan included. `beam`: beams "
        "over moves scored by the policy, the greedy plan included.",
        choices=("greedy", "sample", "beam"),
    )
    samples: int = option(
        512, "Maximum number of plans drawn by `sample`.", least=1, most=10_000_000
    )
    temperature: float = option(
        1.0, "Temperature of samples; lower values keep closer to the best move.", above=0.0
    )
    width: int = option(
        100,
        "Partial plans kept by the second beam, fewer if time is short. The first beam is a "
        "fifth as wide, to give an early plan.",
        least=1,
        most=1_000_000,
    )
    beams: int = option(
        2,
        "Maximum number of beams; from the third on, each is twice as wide as the one before, as "
        "far as time allows.",
        least=1,
        most=1000,
    )
    jobs: int = option(
        0, "Number of threads, 0 for all cores. No effect on the plan.", least=0, most=MOST_JOBS
    )


def ppo(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    options: PpoOptions = PpoOptions(),
) -> Result:
    """A policy trained by masked PPO.

    Runs in NumPy, without PyTorch. Of the plans that it leads to, the one that collects most is
    kept.

    Raises
    ------
    InputError
        A file that is no policy, or too many bodies for the timetable of all pairs.
    """
    threads = options.jobs or usable_cores()
    learned = load_policy(options.policy or SHIPPED)
    if mission.timetable.pairs.near.shape[1] < len(mission.names) - 1:
        raise InputError(
            f"ppo needs the timetable of all pairs, for which {len(mission.names)} bodies are too "
            "many; take fewer targets, or another method"
        )
    instance = mission.instance
    budget, duration = instance.chaser.tank.delta_v_m_s, instance.mission.duration_s
    began = now_s()
    counters = {"plans": 0, "states": 0}
    best = Incumbent(mission, by_choice=True)
    if instance.targets and budget > 0.0 and duration > 0.0:
        field = Field(mission, learned, threads)
        play(field, 1, best.offer)
        counters["plans"] = 1
        tell_plan(progress, best.objective, best.sequence or ())
        if options.decode == "sample":
            rng = np.random.default_rng(np.random.SeedSequence([seed, 5]))
            for drawn in range(1, options.samples, BATCH):
                if stop(best.objective, math.inf):
                    break
                count = min(BATCH, options.samples - drawn)
                play(field, count, best.offer, rng, options.temperature)
                counters["plans"] += count
                tell_plan(progress, best.objective, best.sequence or ())
        elif options.decode == "beam":
            pace_s, widest = 0.0, 0  # of a beam, per unit of width; of all of them
            for number in range(options.beams):
                if stop(best.objective, math.inf):
                    break
                wide = max(1, options.width // 5)
                if number:
                    wide = options.width * 2 ** (number - 1)
                remaining = PUNCTUAL * stop.remaining_s()
                if number and pace_s * wide > remaining:
                    # A beam that is cut off is worth less than a narrower one that ends.
                    wide = int(remaining / pace_s)
                if wide <= widest:
                    break
                widest = wide
                settings = PolicyBeamSettings(wide, PRIOR_WEIGHT)
                since = now_s()
                counters["states"] += beam(
                    field, settings, best.offer, lambda: bool(stop(best.objective, math.inf))
                )
                pace_s = (now_s() - since) / wide
                counters["plans"] += 1
                tell_plan(progress, best.objective, best.sequence or ())
    return certify(
        mission,
        "ppo",
        best.sequence or (),
        seed=seed,
        runtime_s=now_s() - began,
        counters=counters,
        notes=(f"policy {learned.name!r}, decoded by {options.decode}", *learned.notes(mission)),
    )
