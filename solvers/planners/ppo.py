"""The learned planner: a trained policy, decoded."""

from __future__ import annotations

import math
import os
import time

import numpy as np

from adr_opt.errors import InputError
from adr_opt.mission import Mission
from adr_opt.planner import Progress, at_most
from adr_opt.result import Result, certify
from adr_opt.stop import Stop

from ..learned import SHIPPED, load_policy
from ..learned.decoding import Field, best_of, chunks, gumbel, play
from ..learned.policy_beam import BeamSettings, beam

DECODE = ("greedy", "sample", "beam")
PUNCTUAL = 0.9
"""Share of the time left that a beam may be planned to take."""
PRIOR_WEIGHT, PRIOR_WEIGHT_BESIDE_CHAINS = 0.05, 0.005
"""Worth of a unit of log-probability in a beam [targets]. Where the policy sees chains, what they
promise says most of it already."""

BATCH = 64
"""Samples played side by side."""


@at_most(samples=10_000_000, width=1_000_000, beams=1000)
def ppo(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    policy: str = "",
    decode: str = "greedy",
    samples: int = 512,
    temperature: float = 1.5,
    width: int = 100,
    beams: int = 2,
    jobs: int = 0,
) -> Result:
    """A policy trained by masked PPO.

    Runs without PyTorch (extra ``[ppo]``). The policies of the package do not see
    prizes; of the plans that they lead to, the one that collects most is kept.

    Parameters
    ----------
    policy : str
        A policy of the package or a file that ``train`` wrote; ``set`` if empty.
    decode : str
        ``greedy``: the move with the best score again and again, some milliseconds. ``sample``:
        the best of many plans drawn from the policy, by ``seed``, the greedy one among them.
        ``beam``: beams over moves that the policy has judged, the greedy plan besides.
    samples : int
        Plans drawn by ``sample``, unless ``stop`` says enough before.
    temperature : float
        Below 1, samples keep closer to the best move.
    width : int
        Partial plans kept by the second beam; fewer where that would take more time than is
        left. The first is a fifth as wide, so that there is a plan early.
    beams : int
        Beams, unless ``stop`` says enough before; from the third on, each is twice as wide as the
        one before, or as wide as the time left allows.
    jobs : int
        Threads; 0 for all cores. The plan does not depend on it.

    Raises
    ------
    InputError
        An option out of range, a file that is no policy, or more targets than the policy takes.
    MissingExtra
        ONNX Runtime is not installed.
    """
    if decode not in DECODE:
        raise InputError(
            f"option decode = {decode!r} of method 'ppo': use one of: {', '.join(DECODE)}"
        )
    for name, value in (("samples", samples), ("width", width), ("beams", beams)):
        if value < 1:
            raise InputError(f"option {name} = {value} of method 'ppo': must be at least 1")
    if not (math.isfinite(temperature) and temperature > 0.0):
        raise InputError(f"option temperature = {temperature!r} of method 'ppo': must be positive")
    if jobs < 0:
        raise InputError(f"option jobs = {jobs} of method 'ppo': must be at least 0")
    threads = jobs or os.cpu_count() or 1
    learned = load_policy(policy or SHIPPED, threads)
    learned.check_size(len(mission.names) - 1)
    instance = mission.instance
    budget, duration = instance.chaser.tank.delta_v_m_s, instance.mission.duration_s
    began = time.perf_counter()
    counters = {"plans": 0, "states": 0}
    found, kept = best_of(mission)
    if instance.targets and budget > 0.0 and duration > 0.0:
        field = Field(mission, learned, threads)
        play(field, 1, None, 1.0, found)
        counters["plans"] = 1
        progress(kept()[1], math.inf)
        if decode == "sample":
            noise = gumbel(np.random.default_rng(np.random.SeedSequence([seed, 5])))
            for count in chunks(samples - 1, BATCH):
                if stop(kept()[1], math.inf):
                    break
                play(field, count, noise, temperature, found)
                counters["plans"] += count
                progress(kept()[1], math.inf)
        elif decode == "beam":
            weight = PRIOR_WEIGHT_BESIDE_CHAINS if field.sees_chains else PRIOR_WEIGHT
            pace_s, widest = 0.0, 0  # of a beam, per unit of width; of all of them
            for number in range(beams):
                if stop(kept()[1], math.inf):
                    break
                wide = width * 2 ** (number - 1) if number else max(1, width // 5)
                remaining = PUNCTUAL * stop.remaining_s()
                if number and pace_s * wide > remaining:
                    # A beam that is cut off is worth less than a narrower one that ends.
                    wide = int(remaining / pace_s)
                if wide <= widest:
                    break
                widest = wide
                settings = BeamSettings(wide, weight)
                since = time.perf_counter()
                counters["states"] += beam(
                    field, settings, found, lambda: bool(stop(kept()[1], math.inf))
                )
                pace_s = (time.perf_counter() - since) / wide
                counters["plans"] += 1
                progress(kept()[1], math.inf)
    return certify(
        mission,
        "ppo",
        mission.closed(kept()[0]),
        seed=seed,
        runtime_s=time.perf_counter() - began,
        counters=counters,
        notes=(f"policy {learned.name!r}, decoded by {decode}",),
    )
