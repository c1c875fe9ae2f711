"""Beam search, the planner: one deterministic search of a given width."""

from __future__ import annotations

import math
import os
import time
from dataclasses import replace

from adr_opt.errors import InputError
from adr_opt.mission import Mission
from adr_opt.planner import Progress, at_most
from adr_opt.result import Result, certify
from adr_opt.stop import Stop

from .beams import BeamSettings
from .completion import guide as make_guide
from .learned import load_policy
from .learned.decoding import Field, best_of, without_last_refuelling
from .learned.policy_beam import BeamSettings as PolicyBeam
from .learned.policy_beam import beam as beam_by_policy
from .recreate import HOUR_WORTH, KILOMETRE_WORTH, mean_prize
from .timely_beams import PILOT_WIDTH, Beams


@at_most(width=1_000_000)
def beam(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    width: int = 8000,
    time_weight: float = HOUR_WORTH,
    delta_v_weight: float = KILOMETRE_WORTH,
    crowding: float = 1.7,
    noise: float = 0.0,
    guided: bool = False,
    policy: str = "",
    prior_weight: float = 0.05,
) -> Result:
    """Level by level over visits, keeping the best partial plans of each level.

    Deterministic as long as the time allows the whole width. A narrow search first tells how much
    it does allow; one that is late all the same is hurried to its end.

    Parameters
    ----------
    width : int
        Partial plans kept on each level; time and memory are proportional to it.
    time_weight, delta_v_weight : float
        Worth of an hour [prizes per h] and of a km/s left [prizes per km/s] when partial plans are
        compared; they scale with the mean prize.
    crowding : float
        Most partial plans at one body, as a multiple of an equal share.
    noise : float
        Random part of the comparison, by ``seed`` [mean prizes].
    guided : bool
        Also compare by the upper bound on what can still be collected. The table for it takes
        about a second on nominal instances.
    policy : str
        A learned policy as prior, ``set`` or a file that ``train`` wrote (extra ``[ppo]``): partial
        plans are also compared by how likely the policy would have made their moves, so a width
        of some hundred is enough. ``crowding``, ``noise`` and ``guided`` do not count then.
    prior_weight : float
        Worth of a unit of log-probability of that policy [mean prizes].

    Raises
    ------
    InputError
        An option is out of range.
    """
    if width < 1:
        raise InputError(f"option width = {width} of method 'beam': must be at least 1")
    for name, value in (
        ("time_weight", time_weight),
        ("delta_v_weight", delta_v_weight),
        ("noise", noise),
        ("prior_weight", prior_weight),
    ):
        if not (math.isfinite(value) and value >= 0.0):
            raise InputError(f"option {name} = {value!r} of method 'beam': must be ≥ 0")
    if not crowding >= 1.0:
        raise InputError(f"option crowding = {crowding!r} of method 'beam': must be at least 1")
    began = time.perf_counter()
    prize = mean_prize(mission)
    settings = BeamSettings(
        width=width,
        time_weight=time_weight * prize,
        delta_v_weight=delta_v_weight * prize,
        crowding=crowding,
        noise=noise * prize,
    )
    sequence: list[int] = []
    states = 0
    if policy:
        sequence, states = _by_policy(
            mission, policy, width, prior_weight, time_weight, delta_v_weight, stop
        )
    elif not stop(-math.inf, math.inf):
        guide = make_guide(mission) if guided and mission.instance.targets else None
        beams, best = Beams(mission, stop), (-math.inf, 0.0)
        for each in sorted({min(PILOT_WIDTH, width), width}):
            found = beams.search(replace(settings, width=each), guide=guide, seed=seed)
            timing = mission.time(found)
            if (timing.objective, -timing.delta_v) > best:
                best, sequence = (timing.objective, -timing.delta_v), found.tolist()
                progress(timing.objective, math.inf)
        states = beams.states
    return certify(
        mission,
        "beam",
        sequence,
        seed=seed,
        runtime_s=time.perf_counter() - began,
        counters={"width": width, "states": states},
    )


def _by_policy(
    mission: Mission,
    policy: str,
    width: int,
    prior_weight: float,
    time_weight: float,
    delta_v_weight: float,
    stop: Stop,
) -> tuple[list[int], int]:
    """A beam whose partial plans a learned policy has judged; sequence and states."""
    threads = os.cpu_count() or 1
    learned = load_policy(policy, threads)
    learned.check_size(len(mission.names) - 1)
    if not mission.instance.targets:
        return [], 0
    found, kept = best_of(mission)
    states = beam_by_policy(
        Field(mission, learned, threads),
        PolicyBeam(width, prior_weight, time_weight, delta_v_weight),
        found,
        lambda: bool(stop(-math.inf, math.inf)),
    )
    return without_last_refuelling(kept()[0]), states
