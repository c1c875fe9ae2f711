"""Lower bound on the cost of a short leg between eccentric orbits, restated."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import MU_M3_S2
from ...kernels.legs import burns as burn_kernels
from ...kernels.legs import co_elliptic
from ...kernels.orbits import ephemeris

SMALLEST = 1e-12
"""Threshold below which planes count as opposite, with no shortest way between them."""


class StatedSequence(NamedTuple):
    """The co-elliptic sequence stated by a leg, recomputed.

    Attributes
    ----------
    departure, arrival : float
        [s].
    laps : int
        Phasing revolutions.
    radius : float
        Of the phasing orbit [m].
    theta : float
        Angle that is turned [rad].
    """

    departure: float
    arrival: float
    laps: int
    radius: float
    theta: float


def matching_cost(
    origin: npt.NDArray[np.float64],
    destination: npt.NDArray[np.float64],
    rule: co_elliptic.TransferRule,
    departure: float,
    sequence: StatedSequence,
) -> float:
    """Lower bound on the ΔV of a short leg between eccentric orbits, approach included [m/s].

    Written out once more, with vectors where :mod:`adr_opt.kernels.orbits.eccentricity` has angles;
    0 for circles. Perigees and nodes are those at the departure [s].
    """
    shapes = [float(ephemeris.eccentricity_at(orbit, departure)) for orbit in (origin, destination)]
    if shapes == [0.0, 0.0]:
        return 0.0
    vectors, normals = [], []
    for orbit, shape in zip((origin, destination), shapes, strict=True):
        node, ahead, normal = ephemeris.frame(
            ephemeris.inclination_at(orbit, departure), ephemeris.node_at(orbit, departure)
        )
        perigee = float(ephemeris.perigee_at(orbit, departure))
        vector = math.cos(perigee) * node + math.sin(perigee) * ahead
        vectors.append(shape * vector)
        normals.append(normal)
    # The destination's vector, its plane turned into the origin's about their line of nodes.
    axis = np.cross(normals[1], normals[0])
    once = np.cross(axis, vectors[1])
    along = max(1.0 + float(normals[0] @ normals[1]), SMALLEST)
    turned = vectors[1] + once + np.cross(axis, once) / along
    ri, rj = (float(ephemeris.radius_at(orbit, departure)) for orbit in (origin, destination))
    r = sequence.radius
    corner = r + rule.first_leg_fraction * (rj - r)
    comes = burn_kernels.half_ellipse_speeds(ri, r)[1]
    leaves = (
        math.sqrt(MU_M3_S2 / r) if sequence.laps else burn_kernels.half_ellipse_speeds(r, corner)[0]
    )
    speed = math.sqrt(MU_M3_S2 / math.sqrt(ri * rj))
    alone = 0.5 * speed * float(np.linalg.norm(turned - vectors[0]))
    turning = 2.0 * math.sqrt(comes * leaves) * math.sin(0.5 * sequence.theta)
    approach = math.sqrt(MU_M3_S2 / rj) / rj * rule.approach_length
    return float(math.hypot(alone, turning) + approach)
