"""Bodies in true dynamics: from mean elements to osculating states, propagated numerically.

An instance keeps mean elements. They are a fit to the truth, and the secular rates of docs/model.md
section 1 are of first order: an orbit that begins at osculating elements of first order leaves
them by kilometres a day along the track, because its mean motion differs in the second order. So
the mean elements at the epoch are corrected, the semi-major axis by some ten metres, until the
body keeps up with its mean model over the mission; what is left along the track is periodic.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Literal, Protocol

import numpy as np

from ...common.constants import MU_M3_S2, OBLATENESS_M2
from ...common.errors import InputError
from ...kernels.orbits import coast, elements, equinoctial
from ...kernels.orbits.gravity import FIELDS
from ...kernels.orbits.short_periods import Array, osculating
from ...problem.instance import Instance
from ...problem.orbit import Orbit

Gravity = Literal["two-body", "j2", "j3", "j4"]

SAMPLES = 48
"""Number of times in the mission at which a body is compared with its mean model."""

CORRECTIONS = 3
"""Number of correction rounds; the second one changes centimetres."""

NO_MATRIX = np.empty((0, 0))


def moved(state: Array, duration_s: float, gravity: Gravity) -> Array:
    """State after a coast, shape (6,) [m, m/s].

    Raises
    ------
    ArithmeticError
        The orbit is not closed.
    """
    now = state.copy()
    coast.coast(now, float(duration_s), FIELDS[gravity], NO_MATRIX)
    if not math.isfinite(now[0]):
        raise ArithmeticError("the orbit leads away from the Earth or into its centre")
    return now


class MovingBodies(Protocol):
    """Where the bodies of legs are.

    Attributes
    ----------
    gravity : {"two-body", "j2", "j3", "j4"}
        That a chaser flies in.
    epoch_states : dict
        Body → inertial state at the epoch, shape (6,) [m, m/s].
    """

    gravity: Gravity
    epoch_states: dict[str, Array]

    def state(self, name: str, time_s: float) -> Array:
        """Inertial state of a body at a time since the epoch, shape (6,) [m, m/s]."""
        ...

    def following(self, name: str, time_s: float, length_m: float) -> Array:
        """State of the point that follows a body on its orbit at a distance, shape (6,)."""
        ...


class TrueBodies:
    """States of an instance's bodies in true dynamics.

    Parameters
    ----------
    instance : Instance
    gravity : {"two-body", "j2", "j3", "j4"}
    names : iterable of str
        The bodies that are wanted.
    corrected : bool
        Whether mean motions are corrected; without it bodies leave their mean model by kilometres
        a day.

    Raises
    ------
    InputError
        An orbit decays.
    """

    def __init__(
        self, instance: Instance, gravity: Gravity, names: Iterable[str], *, corrected: bool = True
    ) -> None:
        names = tuple(dict.fromkeys(names))
        for name in names:
            if instance.decay_of(name):
                raise InputError(
                    f"the orbit of {name!r} decays, and flights in true dynamics are without drag; "
                    "refine onto ephemerides with --ephemerides, or leave decay_m_per_day out of "
                    "the instance"
                )
        self.gravity = gravity
        every = dict(zip(instance.names, instance.body_orbits, strict=True))
        span = instance.mission.duration_s if corrected else 0.0
        self.epoch_states = {name: state_at_epoch(every[name], gravity, span) for name in names}

    def state(self, name: str, time_s: float) -> Array:
        """Inertial state of a body at a time since the epoch, shape (6,) [m, m/s]."""
        return moved(self.epoch_states[name], time_s, self.gravity)

    def following(self, name: str, time_s: float, length_m: float) -> Array:
        """State of the point that follows a body on its orbit at a distance, shape (6,).

        It is where the body was the time ago that the distance takes: free motion too, since the
        field does not change with time.
        """
        now = self.state(name, time_s)
        speed = math.sqrt(float(now[3:] @ now[3:]))
        return moved(now, -length_m / speed, self.gravity)


def state_at_epoch(orbit: Orbit, gravity: Gravity, span_s: float) -> Array:
    """Osculating state of mean elements at the epoch, shape (6,) [m, m/s].

    Parameters
    ----------
    orbit : Orbit
        Mean elements; in two-body motion they are the osculating ones.
    gravity : {"two-body", "j2", "j3", "j4"}
    span_s : float
        The semi-major axis and the longitude are corrected such that the body keeps up with its
        mean model over this time; 0 for no correction.
    """
    zonals = FIELDS[gravity]
    mean, frame = mean_at(orbit, gravity, 0.0)
    if gravity == "two-body":
        return np.asarray(equinoctial.state_of(mean, frame))
    start = mean.copy()
    state = osculating(start, frame, zonals)
    if not span_s > 0.0:
        return state
    times = np.linspace(0.0, span_s, SAMPLES + 1)
    models = [mean_at(orbit, gravity, time) for time in times]
    wanted = [osculating(*model, zonals) for model in models]
    motion = math.sqrt(MU_M3_S2 / start[0] ** 3)
    for _ in range(CORRECTIONS):
        ahead, now = np.empty(times.size), state
        for at, time in enumerate(times):
            now = moved(now, time - times[at - 1], gravity) if at else state
            ahead[at] = _ahead(now, wanted[at])
        slope, offset = np.polyfit(times, np.unwrap(ahead), 1)
        start[0] += 2.0 / 3.0 * start[0] * slope / motion
        start[5] -= offset
        state = osculating(start, frame, zonals)
    return state


def mean_at(orbit: Orbit, gravity: Gravity, time_s: float) -> tuple[Array, Array]:
    """Mean equinoctial elements of a body at a time, and the frame of its mean plane."""
    row = np.array(orbit.row(0.0 if gravity == "two-body" else OBLATENESS_M2))
    return elements.equinoctial_at(row, time_s)


def _ahead(state: Array, other: Array) -> float:
    """Lead of the first state over the second in mean longitude [rad]."""
    frame = equinoctial.own_frame(other)
    first, second = (equinoctial.elements(one, frame)[5] for one in (state, other))
    return math.remainder(first - second, math.tau)
