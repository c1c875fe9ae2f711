"""Beam search, the planner: one deterministic search of a given width."""

from __future__ import annotations

import math
import time

from adr_opt.errors import InputError
from adr_opt.mission import Mission
from adr_opt.planner import Progress
from adr_opt.result import Result, certify
from adr_opt.stop import Stop

from .beams import BeamSettings, beam_search
from .completion import guide as make_guide
from .recreate import HOUR_WORTH, KILOMETRE_WORTH, mean_prize


def beam(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    width: int = 3000,
    time_weight: float = HOUR_WORTH,
    delta_v_weight: float = KILOMETRE_WORTH,
    crowding: float = 1.7,
    noise: float = 0.0,
    guided: bool = False,
) -> Result:
    """Level by level over visits, keeping the best partial plans of each level.

    Deterministic. Ends by itself: it asks ``stop`` only before it begins.

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
    sequence, states = [], 0
    if not stop(-math.inf, math.inf):
        guide = make_guide(mission) if guided and mission.instance.targets else None
        found, value, _, states = beam_search(mission, settings, guide=guide, seed=seed)
        sequence = [int(j) for j in found]
        progress(value, math.inf)
    return certify(
        mission,
        "beam",
        sequence,
        seed=seed,
        runtime_s=time.perf_counter() - began,
        counters={"width": width, "states": states},
    )
