"""Beams with settings varied around the usual ones: for other plans, and for new ends of one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.common.stop import Stop
from adr_opt.mission.mission import Mission

from .beams import BeamSettings, beam_search
from .exchange_rates import worth_of

TIME_VALUES_M_S_PER_H = (60.0, 75.0, 90.0, 110.0, 130.0, 160.0, 200.0)
"""Values of an hour that choose the connections to move on."""

LEAST_UNGUARDED = 1000
"""Width below which beams are guarded, as they would strand themselves."""


class Varied(NamedTuple):
    """A beam to search: choice of connections, settings and noise."""

    mission: Mission
    settings: BeamSettings
    seed: int


def varied(mission: Mission, width: int, rng: np.random.Generator) -> Varied:
    """A beam with random settings; always the same number of draws."""
    value = float(rng.choice(TIME_VALUES_M_S_PER_H)) * mission.instance.hurry
    factor, crowding = rng.uniform(0.6, 1.6), rng.uniform(1.2, 2.5)
    noise, unguarded = rng.uniform(0.0, 0.4), rng.random() < 0.3
    seed = int(rng.integers(2**31))
    with_time_value = mission.with_time_value(value)
    worth = worth_of(with_time_value)
    settings = BeamSettings(
        width=width,
        time_weight=worth.hour,
        delta_v_weight=factor * worth.kilometre_per_s,
        crowding=crowding,
        noise=noise * worth.prize,
        guarded=width < LEAST_UNGUARDED or not unguarded,
    )
    return Varied(with_time_value, settings, seed)


def recreate(
    mission: Mission,
    sequence: Sequence[int],
    width: int,
    rng: np.random.Generator,
    stop: Stop | None = None,
) -> npt.NDArray[np.int64]:
    """Ruin and recreate: cut a plan at a random move and rebuild its end by a narrow beam.

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
