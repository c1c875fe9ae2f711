"""Ruin and recreate: keep the beginning of a plan and build a new end."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from adr_opt.common.stop import Stop
from adr_opt.mission.mission import Mission

from .beams import BeamSettings, beam_search
from .exchange_rates import worth_of


def recreate(
    mission: Mission,
    sequence: Sequence[int],
    width: int,
    rng: np.random.Generator,
    stop: Stop | None = None,
) -> npt.NDArray[np.int64]:
    """Cut a plan at a random move and rebuild its end by a narrow noisy beam.

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
    worth = worth_of(mission)
    settings = BeamSettings(
        width=width,
        time_weight=worth.hour,
        delta_v_weight=worth.kilometre_per_s * rng.uniform(0.6, 1.6),
        crowding=rng.uniform(1.2, 2.5),
        noise=rng.uniform(0.0, 0.5) * worth.prize,
    )
    prefix = tuple(int(j) for j in sequence[:keep])
    seed = int(rng.integers(2**31))
    return beam_search(mission, settings, prefix=prefix, seed=seed, stop=stop)[0]
