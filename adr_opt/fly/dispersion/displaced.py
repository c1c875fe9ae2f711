"""Bodies displaced from their planned orbits, by errors drawn at the time of their covariance.

An error keeps to a body through the mission: it is carried from that time by the state-transition
matrix of its motion in the field of the plan, and the decay by its parabola. It is told in
equinoctial elements in the frame of the planned state, where it stays nearly linear for hundreds of
kilometres along the track.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from ...common.constants import DAY_S, MU_M3_S2
from ...common.errors import InputError
from ...kernels.orbits import coast, equinoctial
from ...kernels.orbits.gravity import FIELDS
from ...kernels.orbits.short_periods import Array, mean_elements, osculating
from ...plan.refined_plan import RefinedPlan
from ...problem.instance import Instance
from ...sources.uncertainty import TargetError
from ..refine.bodies import moved, state_of

STEPS = 10.0, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6
"""Steps of the derivative of osculating by mean elements [m], [1], [rad]."""

MOST_RAD = 0.5
"""Largest along-track error: beyond it, flights are no longer linear [m]."""


class DisplacedBodies:
    """Errors of bodies in many flights.

    Parameters
    ----------
    instance : Instance
    refined : RefinedPlan
    errors : mapping
        Body → its error; bodies without one, or with none at all, are where they are planned.
    flights, seed : int
    """

    def __init__(
        self,
        instance: Instance,
        refined: RefinedPlan,
        errors: Mapping[str, TargetError],
        flights: int,
        seed: int,
    ) -> None:
        self._flights = flights
        self._errors, self._gravity = errors, refined.gravity
        self._zonals, self._states = FIELDS[refined.gravity], dict[str, Array]()
        self._drawn, self._known = dict[str, Array](), dict[tuple[str, float], Array]()
        for number, name in enumerate(instance.names):
            if errors.get(name):
                # Of its own, so that the draws of legs are the same with errors of bodies.
                rng = np.random.default_rng([seed, number, len(instance.names)])
                normal = rng.standard_normal((7, flights))
                self._drawn[name] = errors[name].factor() @ normal
        for body in refined.bodies:
            self._states[body.name] = state_of(body)

    @property
    def names(self) -> tuple[str, ...]:
        """Bodies that legs meet and that have an error."""
        return tuple(name for name in self._drawn if name in self._states)

    def __contains__(self, name: str) -> bool:
        """Whether a body has an error."""
        return name in self._drawn

    def follow(self, name: str, times_s: Iterable[float]) -> None:
        """Find the errors of a body at times, in one pass through the mission.

        Raises
        ------
        InputError
            They are too large to be flown.
        """
        if name not in self._drawn:
            return
        drawn, since_s = self._drawn[name], self._errors[name].since_s
        state, matrix = moved(self._states[name], since_s, self._gravity), np.eye(6)
        begin = self._begin(name, state) @ drawn[:6]
        now_s = since_s
        for time_s in sorted(set(times_s)):
            coast.coast(state, time_s - now_s, self._zonals, matrix)
            now_s = time_s
            frame = equinoctial.own_frame(state)
            found = equinoctial.jacobian(state, frame) @ (matrix @ begin)
            found += np.outer(self._decayed(state, frame, time_s - since_s), drawn[6])
            if not np.abs(found[5]).max() < MOST_RAD:  # NaN, too
                far = np.abs(found[5]).max() * float(np.linalg.norm(state[:3])) / 1e3
                raise InputError(
                    f"{name!r} is {far:,.0f} km along its track from where it is planned in one of "
                    "the flights, too far for linear flights; give smaller errors"
                )
            self._known[name, time_s] = found

    def at(self, name: str, time_s: float) -> Array:
        """Errors of a body at one of the times of :meth:`follow`, shape (6, flights).

        In equinoctial elements in the frame of its planned state; zeros for one without errors.
        """
        if name not in self._drawn:
            return np.zeros((6, self._flights))
        return self._known[name, time_s]

    def _begin(self, name: str, state: Array) -> Array:
        """Derivative of the state by the coordinates of the error, shape (6, 6)."""
        coordinates = self._errors[name].coordinates
        if coordinates == "inertial":
            return np.eye(6)
        frame = equinoctial.own_frame(state)
        if coordinates == "rtn":
            return np.kron(np.eye(2), frame.T)
        elements = equinoctial.elements(state, frame)
        lengths = np.array([1.0, *([1.0 / elements[0]] * 5)])
        lengths[3:5] *= 0.5  # h and k are tangents of half the angle
        by_mean = self._by_mean(state, frame) * lengths
        found: Array = np.linalg.inv(equinoctial.jacobian(state, frame)) @ by_mean
        return found

    def _decayed(self, state: Array, frame: Array, span_s: float) -> Array:
        """Change of elements after a time by each metre a day of decay, shape (6,)."""
        axis = equinoctial.elements(state, frame)[0]
        motion, days = np.sqrt(MU_M3_S2 / axis**3) * DAY_S, span_s / DAY_S
        mean = np.array([-days, 0.0, 0.0, 0.0, 0.0, 0.75 * motion / axis * days**2])
        found: Array = self._by_mean(state, frame) @ mean
        return found

    def _by_mean(self, state: Array, frame: Array) -> Array:
        """Derivative of osculating by mean elements, shape (6, 6).

        What moves a body along its track moves its mean longitude; at the same osculating axis that
        would be another mean one, which runs away.
        """
        mean = mean_elements(state, frame, self._zonals)
        found = np.empty((6, 6))
        for column, step in enumerate(STEPS):
            ends = []
            for sign in (1.0, -1.0):
                near = mean.copy()
                near[column] += sign * step
                ends.append(equinoctial.elements(osculating(near, frame, self._zonals), frame))
            found[:, column] = (ends[0] - ends[1]) / (2.0 * step)
        return found
