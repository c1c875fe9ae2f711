"""The arcs of a refined plan in the axes of SGP4, with states at any time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...common.errors import InputError
from ...fly.flight.tanks import refined_routes
from ...fly.refine.bodies import Whereabouts
from ...fly.refine.ephemeris import tracks
from ...plan.refined_plan import RefinedPlan
from ...problem.instance import Instance
from ...sources.ephemerides.ephemeris import TurningAxes

Array = npt.NDArray[np.float64]

STEP_S = 20.0
"""Largest interval between states of an arc; cubics between them are accurate to 5 mm [s]."""


@dataclass(frozen=True)
class FlownArc:
    """An arc of a chaser in TEME of date.

    Attributes
    ----------
    chaser : str or None
        As the refined plan names it.
    leg : int
        By its number in the plan.
    phase : str
    beside : frozenset of str
        Bodies that the chaser leaves or meets on its leg.
    times_s : (n,) float64
        Evenly spaced, both ends included [s].
    states : (n, 6) float64
        Positions [m] and their rates [m/s].
    """

    chaser: str
    leg: int
    phase: str
    beside: frozenset[str]
    times_s: Array
    states: Array

    def at(self, times_s: Array) -> Array:
        """States at times within the arc, shape (times, 6), by cubics."""
        step = float(self.times_s[1] - self.times_s[0])
        places = (times_s - self.times_s[0]) / step
        left = np.clip(places.astype(np.int64), 0, self.times_s.size - 2)
        s = (places - left)[:, None]
        one, other = self.states[left], self.states[left + 1]
        p, q = one[:, :3], other[:, :3]
        u, v = step * one[:, 3:], step * other[:, 3:]
        square, cube = 3.0 * (q - p) - 2.0 * u - v, 2.0 * (p - q) + u + v
        positions = p + s * (u + s * (square + s * cube))
        rates = (u + s * (2.0 * square + 3.0 * s * cube)) / step
        return np.hstack([positions, rates])


def flown_arcs(instance: Instance, refined: RefinedPlan) -> Iterator[FlownArc]:
    """All arcs of all chasers.

    Raises
    ------
    InputError
        The instance does not say what its axes are, or ephemerides are missing.
    MissingExtra
        astropy is not installed.
    """
    frame = instance.frame
    if frame is None:
        raise InputError(
            f"{instance.name!r} has no frame, so that objects of a catalogue cannot be placed; "
            "make it with import"
        )
    bodies, axes = Whereabouts.of(instance, refined), TurningAxes(instance.epoch, frame)
    legs = {leg.leg: leg for leg in refined.legs}
    for route, of_route in refined_routes(instance, refined):
        for leg in of_route:
            for track in tracks(refined, step_s=STEP_S, leg=leg.leg, bodies=bodies):
                arc = track.arc
                states = np.hstack([arc.positions_m, arc.rates_m_s])
                beside = frozenset({legs[leg.leg].origin, legs[leg.leg].destination})
                turned = _of_date(axes, arc.times_s, states)
                yield FlownArc(route.name, leg.leg, arc.phase, beside, arc.times_s, turned)


def _of_date(axes: TurningAxes, times_s: Array, states: Array) -> Array:
    """States in TEME of date, whose axes turn by an arcsecond a week."""
    matrices = np.empty((times_s.size, 3, 3))
    for column, unit in enumerate(np.eye(3)):
        matrices[:, :, column] = axes.turned(np.tile(unit, (times_s.size, 2)), times_s)[:, :3]
    pairs = states.reshape(-1, 2, 3)
    turned: Array = np.einsum("tji,tkj->tki", matrices, pairs).reshape(-1, 6)
    return turned
