"""Ruin and recreate: keep the beginning of a plan and build a new end."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from adr_opt.mission import Mission
from adr_opt.stop import Stop

from .beams import BeamSettings, beam_search

HOUR_WORTH, KILOMETRE_WORTH = 0.17, 0.38
"""Worth of an hour and of a km/s in beams, found by experiment on nominal fields [mean prizes]."""


def mean_prize(mission: Mission) -> float:
    """Mean prize of the targets that have one; 1 if there is none."""
    prizes = mission.rules.prize[mission.rules.prize > 0.0]
    return float(prizes.mean()) if prizes.size else 1.0


def recreate(
    mission: Mission,
    sequence: Sequence[int],
    width: int,
    rng: np.random.Generator,
    stop: Stop | None = None,
) -> npt.NDArray[np.int64]:
    """Cut a plan at a random move and build a new end by a narrow noisy beam.

    Parameters
    ----------
    mission : Mission
    sequence : sequence of int
        A plan: bodies in order.
    width : int
        Of the beam.
    rng : numpy.random.Generator
        Draws the cut and the settings of the beam.
    stop : Stop, optional
        Hurries the beam when no time is left.

    Returns
    -------
    (moves,) int64
        A legal plan, better or worse.
    """
    keep = int(rng.integers(0, len(sequence))) if len(sequence) else 0
    prize = mean_prize(mission)
    settings = BeamSettings(
        width=width,
        time_weight=HOUR_WORTH * prize,
        delta_v_weight=KILOMETRE_WORTH * rng.uniform(0.6, 1.6) * prize,
        crowding=rng.uniform(1.2, 2.5),
        noise=rng.uniform(0.0, 0.5) * prize,
    )
    prefix = np.array(sequence[:keep], dtype=np.int64)
    seed = int(rng.integers(2**31))
    return beam_search(mission, settings, prefix=prefix, seed=seed, stop=stop)[0]
