"""The approach, from the stand-off to the target, as burns in the target's own frame.

In the linear relative motion of Clohessy and Wiltshire, docs/model.md section 2.2. A safety ellipse
is a radial and a cross-track oscillation of the same amplitude ρ, a quarter turn apart: the chaser
is never nearer than ρ to the target's track. It is set up at the stand-off, drifts round the target
and is left on the track, 2 ρ behind, for half a lap into the target.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..common.constants import EARTH_RADIUS_M, OBLATENESS_M2
from .settings import SequenceSettings

LAPS_AFTER = 8.0
"""Revolutions after a missed burn in which the target is kept clear."""

LEAST_IN_STEP = 0.5
"""Smallest share of ρ that J2 may leave of the distance from the track."""


class Approach(NamedTuple):
    """Burns of an approach.

    Attributes
    ----------
    burns : (burns, 5) float64
        Each: its time, in revolutions of the target; ΔV outward, ahead and along the normal over
        the mean motion [m]; and how far behind the target it is [m].
    oscillation_m, lower_m : float
        ρ, and by how much the semi-major axis is lowered for the drift; 0 for half a lap.
    """

    burns: npt.NDArray[np.float64]
    oscillation_m: float
    lower_m: float

    @property
    def revolutions(self) -> float:
        """Duration of the approach in revolutions of the target."""
        return float(self.burns[-1, 0])

    @property
    def length_m(self) -> float:
        """ΔV of the approach, divided by the mean motion of the target."""
        return math.fsum(np.sqrt(np.sum(self.burns[:, 1:4] ** 2, axis=1)))


def in_step(revolutions: float, radius_m: float) -> float:
    """Least distance from the track over ρ, after J2 has detuned the two oscillations (2.7d)."""
    turned = 6.0 * math.pi * OBLATENESS_M2 / radius_m**2 * revolutions
    return math.sqrt(1.0 - math.sin(min(turned, 0.5 * math.pi)))


def approach_of(settings: SequenceSettings) -> Approach:
    """The approach of an instance's transfers.

    Raises
    ------
    ValueError
        The oscillations would be out of step before the ellipse is left.
    """
    length = settings.standoff_m
    if settings.approach == "half-lap":
        half = np.array([[0.0, -length / 4, 0.0, 0.0, length], [0.5, -length / 4, 0.0, 0.0, 0.0]])
        return Approach(half, 0.0, 0.0)
    laps, inspecting = settings.approach_revolutions, settings.inspection_revolutions
    drift = 3.0 * math.pi * (laps + 0.25)
    radius = EARTH_RADIUS_M + settings.min_altitude_m
    passing = in_step(2 * laps + 1.75, radius) - 2.0 / drift
    staying = in_step(laps + 1.75 + inspecting + LAPS_AFTER, radius)
    if min(passing, staying) < LEAST_IN_STEP:
        raise ValueError(
            f"field transfer.approach_revolutions = {laps}, inspection_revolutions = {inspecting}: "
            "J2 turns the oscillations of the safety ellipse out of step by then; give fewer"
        )
    rho = max((settings.keep_out_m + length / drift) / passing, settings.keep_out_m / staying)
    lower = (length + 2.0 * rho) / drift
    left = laps + 1.75 + inspecting
    kicks = [
        (0.0, 0.0, 0.0, rho),
        (0.25, rho, 0.0, 0.0),
        (1.0, 0.0, -0.25 * lower, 0.0),
        (1.5, 0.0, -0.25 * lower, 0.0),
        (laps + 1.25, 0.0, 0.25 * lower, 0.0),
        (laps + 1.75, 0.0, 0.25 * lower, 0.0),
        (left, rho, 0.0, 0.0),  # at rest on the track, 2 rho behind
        (left + 0.25, -0.5 * rho, 0.0, -rho),  # in the plane, and on the way
        (left + 0.75, -0.5 * rho, 0.0, 0.0),
    ]
    if not inspecting:  # two impulses at one instant are one vector
        kicks[5:7] = [(left, rho, 0.25 * lower, 0.0)]
    return Approach(_with_places(np.array(kicks), length), rho, lower)


def _with_places(burns: npt.NDArray[np.float64], length: float) -> npt.NDArray[np.float64]:
    """The burns, each with its distance behind the target, starting at rest at the stand-off."""
    state, now, behind = np.array([0.0, -length, 0.0, 0.0]), 0.0, []
    for time, outward, ahead, _ in burns:
        state, now = relative(state, 2.0 * math.pi * (time - now)), time
        behind.append(-state[1])
        state = state + np.array([0.0, 0.0, outward, ahead])
    return np.column_stack([burns, behind])


def relative(state: npt.NDArray[np.float64], angle: float) -> npt.NDArray[np.float64]:
    """Motion in the target's plane by the equations of Clohessy and Wiltshire.

    Parameters
    ----------
    state : (4,) float64
        Outward and ahead of the target, and their rates over the mean motion [m].
    angle : float
        By which the target goes on [rad].
    """
    s, c = math.sin(angle), math.cos(angle)
    moved = np.array(
        [
            [4.0 - 3.0 * c, 0.0, s, 2.0 * (1.0 - c)],
            [6.0 * (s - angle), 1.0, -2.0 * (1.0 - c), 4.0 * s - 3.0 * angle],
            [3.0 * s, 0.0, c, 2.0 * s],
            [-6.0 * (1.0 - c), 0.0, -2.0 * s, 4.0 * c - 3.0],
        ]
    )
    return np.asarray(moved @ state)
