"""Price of a short leg between eccentric orbits, restated."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import MU_M3_S2
from ...kernels.legs import burns as burn_kernels
from ...kernels.legs import co_elliptic, free_burns
from ...kernels.orbits import ephemeris

SMALLEST = 1e-12
"""Threshold below which planes count as opposite, with no shortest way between them."""

HALVINGS = 60
"""Number of halvings of a range of semi-major axes."""


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


def short_cost(
    ends: tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]],
    rule: co_elliptic.TransferRule,
    departure: float,
    sequence: StatedSequence,
    circles: float,
) -> float:
    """ΔV of a short leg by the instance's transfer rule, approach included [m/s].

    Written out once more, with vectors where the kernels have angles. Perigees and nodes are those
    at the departure.

    Parameters
    ----------
    ends : tuple of (columns,) float64
        Rows of the origin and the destination.
    rule : TransferRule
    departure : float
        [s].
    sequence : StatedSequence
    circles : float
        What its burns between circles take [m/s].
    """
    ri, rj = (float(ephemeris.radius_at(orbit, departure)) for orbit in ends)
    speed = math.sqrt(MU_M3_S2 / math.sqrt(ri * rj))
    approach = math.sqrt(MU_M3_S2 / rj) / rj * rule.approach_length
    if rule.free:
        return _free(ends, rule, departure, sequence, speed) + approach
    if _are_circles(ends, departure):
        return circles
    r = sequence.radius
    corner = r + rule.first_leg_fraction * (rj - r)
    comes = burn_kernels.half_ellipse_speeds(ri, r)[1]
    leaves = (
        math.sqrt(MU_M3_S2 / r) if sequence.laps else burn_kernels.half_ellipse_speeds(r, corner)[0]
    )
    alone = 0.5 * speed * float(np.linalg.norm(_difference(ends, departure)))
    turning = 2.0 * math.sqrt(comes * leaves) * math.sin(0.5 * sequence.theta)
    return max(circles, float(math.hypot(alone, turning) + approach))


def _are_circles(
    ends: tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]], time: float
) -> bool:
    return all(float(ephemeris.eccentricity_at(orbit, time)) == 0.0 for orbit in ends)


def _difference(
    ends: tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]], time: float
) -> npt.NDArray[np.float64]:
    """Δe, once the plane of the destination is turned into that of the origin, shape (3,)."""
    vectors, normals = [], []
    for orbit in ends:
        node, ahead, normal = ephemeris.frame(
            ephemeris.inclination_at(orbit, time), ephemeris.node_at(orbit, time)
        )
        perigee = float(ephemeris.perigee_at(orbit, time))
        vector = math.cos(perigee) * node + math.sin(perigee) * ahead
        vectors.append(float(ephemeris.eccentricity_at(orbit, time)) * vector)
        normals.append(normal)
    axis = np.cross(normals[1], normals[0])
    once = np.cross(axis, vectors[1])
    along = max(1.0 + float(normals[0] @ normals[1]), SMALLEST)
    turned: npt.NDArray[np.float64] = vectors[1] + once + np.cross(axis, once) / along - vectors[0]
    return turned


def _free(
    ends: tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]],
    rule: co_elliptic.TransferRule,
    departure: float,
    sequence: StatedSequence,
    speed: float,
) -> float:
    """Price of free burns without the approach (docs/model.md section 2.7) [m/s]."""
    origin, destination = ends
    ri, rj = (float(ephemeris.radius_at(orbit, ephemeris.EPOCH_S)) for orbit in ends)
    inclinations = [float(ephemeris.inclination_at(orbit, departure)) for orbit in ends]
    # The chaser is on the line of nodes: it leaves at the latitude of the origin.
    node, ahead, _ = ephemeris.frame(inclinations[0], ephemeris.node_at(origin, departure))
    latitude = float(ephemeris.latitude_at(origin, departure))
    line = math.cos(latitude) * node + math.sin(latitude) * ahead
    beside = math.cos(latitude) * ahead - math.sin(latitude) * node
    difference = _difference(ends, departure)
    changes = np.array([(rj - ri), 0.0, 0.0, 0.0]) / (0.5 * (ri + rj))
    changes[2:] = float(difference @ line), float(difference @ beside)
    # The circle on which as much is swept in the time between, by bisection.
    met = sequence.arrival - rule.approach_revolutions * math.tau / float(
        ephemeris.latitude_rate_at(destination, ephemeris.EPOCH_S)
    )
    pace = (2 * sequence.laps + 3) * math.pi / (met - sequence.departure)
    strength = (
        0.75 * rule.oblateness * sum(4.0 * math.cos(each) ** 2 - 1.0 for each in inclinations)
    )
    low, high = 0.25 * min(ri, rj), 4.0 * max(ri, rj)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        rate = math.sqrt(MU_M3_S2 / middle**3) * (1.0 + strength / middle**2)
        low, high = (middle, high) if rate > pace else (low, middle)
    changes[1] = (2.0 * low - ri - rj) / (0.5 * (ri + rj))
    climb, _, along, across = np.abs(changes)
    planar = max(0.5 * climb, 0.5 * math.hypot(along, across))
    for dual in free_burns.DUALS[sequence.laps]:
        for sign in (-1.0, 1.0):
            planar = max(planar, abs(float((dual * [sign, 1.0, 1.0, sign]) @ changes)))
    turn = 2.0 * math.sin(0.5 * sequence.theta)
    shared = math.hypot(across, turn)
    if across > turn / math.sqrt(3.0):
        shared = math.sin(math.pi / 6.0) * across + math.cos(math.pi / 6.0) * turn
    ridden = shared**2 - (0.5 * across) ** 2 - turn**2
    share = 0.5 * across / planar if planar > 0.0 else 0.0
    return free_burns.MARGIN * speed * math.sqrt(planar**2 + turn**2 + share * ridden)
