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

from ..incumbent import Incumbent
from ..learned import load_policy
from ..learned.decoding import Field, best_of
from ..learned.policy_beam import BeamSettings as PolicyBeam
from ..learned.policy_beam import beam as beam_by_policy
from ..search.beams import TIME_VALUE_M_S_PER_H, BeamSettings
from ..search.timely_beams import PILOT_WIDTH, Beams
from ..search.worth import worth_of


@at_most(width=1_000_000)
def beam(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    width: int = 2000,
    time_value_m_s_per_h: float = TIME_VALUE_M_S_PER_H,
    time_weight: float = 1.0,
    delta_v_weight: float = 1.0,
    crowding: float = 1.7,
    noise: float = 0.0,
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
    time_value_m_s_per_h : float
        Of all connections to a target, the one with the least ΔV + value · (arrival − ready) is
        looked at; the plan found is flown at its best schedule over all of them.
    time_weight, delta_v_weight : float
        Worth of an hour and of a km/s left when partial plans are compared, as multiples of what
        :func:`solvers.search.worth.worth_of` estimates for the mission.
    crowding : float
        Most partial plans at one body, as a multiple of an equal share.
    noise : float
        Random part of the comparison, by ``seed`` [mean prizes].
    policy : str
        A learned policy as prior, ``set`` or a file that ``train`` wrote (extra ``[ppo]``): partial
        plans are also compared by how likely the policy would have made their moves, so a width
        of some hundred is enough. ``crowding`` and ``noise`` do not count then.
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
    mission = mission.with_time_value(time_value_m_s_per_h)
    best = Incumbent(mission)
    states = 0
    if policy:
        states = _by_policy(
            mission, best, policy, width, prior_weight, time_weight, delta_v_weight, stop
        )
    elif not stop(-math.inf, math.inf):
        worth = worth_of(mission)
        settings = BeamSettings(
            width=width,
            time_weight=time_weight * worth.hour,
            delta_v_weight=delta_v_weight * worth.kilometre_per_s,
            crowding=crowding,
            noise=noise * worth.prize,
        )
        beams = Beams(mission, stop)
        for each in sorted({min(PILOT_WIDTH, width), width}):
            if best.offer(beams.search(replace(settings, width=each), seed=seed)):
                progress(best.objective, math.inf)
        states = beams.states
    return certify(
        mission,
        "beam",
        best.sequence or (),
        seed=seed,
        runtime_s=time.perf_counter() - began,
        counters={"width": width, "states": states},
    )


def _by_policy(
    mission: Mission,
    best: Incumbent,
    policy: str,
    width: int,
    prior_weight: float,
    time_weight: float,
    delta_v_weight: float,
    stop: Stop,
) -> int:
    """Offer the best of a beam whose partial plans a learned policy judges; returns its states."""
    threads = os.cpu_count() or 1
    learned = load_policy(policy, threads)
    learned.check_size(len(mission.names) - 1)
    if not mission.instance.targets:
        return 0
    worth = worth_of(mission)
    found, kept = best_of(mission)
    states = beam_by_policy(
        Field(mission, learned, threads),
        PolicyBeam(
            width, prior_weight, time_weight * worth.hour, delta_v_weight * worth.kilometre_per_s
        ),
        found,
        lambda: bool(stop(-math.inf, math.inf)),
    )
    best.offer(kept()[0])
    return states
