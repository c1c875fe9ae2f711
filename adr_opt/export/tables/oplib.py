"""``.oplib``: an orienteering problem in OPLib's format (TYPE OP, COST_LIMIT, scores).

OPLib (https://github.com/bcamath-ds/OPLib) extends TSPLIB 95 by COST_LIMIT, the most that a cycle
through the depot may cost, and NODE_SCORE_SECTION. All its numbers are integers. Its own instances
are symmetric, and explicit ones are written as a triangle; transfers are not symmetric, so the
weights here are a FULL_MATRIX.

What of a mission the format can say, at one departure:

- ΔV: the cycle is one fuel load, from the station and back; there is no clock.
- duration: the cycle is the mission, with the service in the weight of the way to each target,
  because the format has no other place for it; no fuel. Unlike a plan it has to return.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ...common.constants import STATION
from ...common.errors import InputError
from ...legs.matrices import Matrices
from ...mission.mission import Mission
from .weights import LARGEST, comment, edges, slug, whole_weights

FINEST_SCORES = 1000.0


def scores(prizes: list[float]) -> tuple[list[int], float]:
    """Integer scores of prizes, and the score of a unit prize.

    Whole prizes are written as they are; others times the largest power of ten up to 1000 that
    fits, rounded.

    Raises
    ------
    InputError
        The prizes do not fit into 31 bits.
    """
    scale = 1.0 if all(prize.is_integer() for prize in prizes) else FINEST_SCORES
    while scale * sum(prizes) > LARGEST and scale > 1.0:
        scale /= 10.0
    if scale * sum(prizes) > LARGEST:
        raise InputError(f"prizes up to {max(prizes)!r} do not fit the 31 bits of a .oplib file")
    return [round(scale * prize) for prize in prizes], scale


def write(
    path: Path, mission: Mission, matrices: Matrices, quantity: str, scale: float | None
) -> None:
    """Write one quantity at one departure.

    Raises
    ------
    InputError
        The prizes or the weights do not fit into 31 bits.
    """
    instance = mission.instance
    is_duration = quantity == "duration"
    limit = instance.mission.duration_s if is_duration else instance.chaser.tank.delta_v_m_s
    service = np.array(mission.rules.service) if is_duration else None
    if service is not None:
        service[STATION] = 0.0  # the cycle ends there
    weights = whole_weights(matrices, quantity, scale, limit, service)
    values, unit = scores([target.prize for target in instance.targets])
    lines = [
        f"NAME : {slug(instance)}",
        f"COMMENT : {comment(instance, weights)}; {unit:g} = a prize of one",
        "TYPE : OP",
        f"DIMENSION : {len(matrices.names)}",
        f"COST_LIMIT : {math.floor(weights.scale * limit)}",
        *edges(weights),
        "NODE_SCORE_SECTION",
        *(f"{node} {score}" for node, score in enumerate([0, *values], start=1)),
        "DEPOT_SECTION",
        "1",
        "-1",
        "EOF",
    ]
    path.write_text("\n".join(lines) + "\n", encoding="ascii", newline="\n")
