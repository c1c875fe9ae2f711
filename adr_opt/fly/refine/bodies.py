"""Bodies in true dynamics: from mean elements to osculating states, propagated numerically.

An instance keeps mean elements. They are a fit to the truth, and the secular rates of docs/model.md
section 1 are of first order: an orbit that begins at osculating elements of first order leaves
them by kilometres a day along the track, because its mean motion differs in the second order. So
the mean elements at the epoch are corrected, the semi-major axis by some ten metres, until the
body keeps up with its mean model over the mission; what is left along the track is periodic.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Literal, Protocol, Self

import numpy as np

from ...common.constants import MU_M3_S2, OBLATENESS_M2
from ...common.errors import InputError
from ...kernels.orbits import coast, elements, equinoctial
from ...kernels.orbits.gravity import FIELDS
from ...kernels.orbits.short_periods import Array, mean_elements, osculating
from ...plan.refined_plan import BodyState, RefinedPlan, RefinedState
from ...problem.instance import Instance
from ...problem.orbit import Orbit
from ...sources.ephemerides import Ephemeris, ephemerides_of


def near_circle(state: Array, zonals: Array) -> Array:
    """Mean semi-major axis, eccentricity vector, inclination, node and argument of latitude.

    Parameters
    ----------
    state : (6,) float64
        Osculating and inertial [m, m/s].
    zonals : (3,) float64
        One of :data:`adr_opt.kernels.orbits.gravity.FIELDS`.

    Returns
    -------
    (6,) float64
        a [m], e cos ω, e sin ω, i, Ω, ω + M [rad].
    """
    frame = equinoctial.own_frame(state)
    mean = equinoctial.state_of(mean_elements(state, frame, zonals), frame)
    normal = np.cross(mean[:3], mean[3:])
    normal /= np.linalg.norm(normal)
    node = math.atan2(normal[0], -normal[1])
    to_node = np.array([math.cos(node), math.sin(node), 0.0])
    axes = np.array([to_node, np.cross(normal, to_node), normal])
    of = equinoctial.elements(mean, axes)
    inclination = math.acos(min(max(float(normal[2]), -1.0), 1.0))
    return np.array([of[0], of[1], of[2], inclination, node, of[5]])


def recorded(event: str, time_s: float, state: Array) -> RefinedState:
    """A state of shape (6,) at an event, in the form of refined plans."""
    values = state.tolist()
    return RefinedState.model_validate(
        {
            "event": event,
            "time_s": float(time_s),
            "position_m": tuple(values[:3]),
            "velocity_m_s": tuple(values[3:]),
        }
    )


def state_of(known: RefinedState | BodyState) -> Array:
    """A state as an array, shape (6,) [m, m/s]."""
    return np.array([*known.position_m, *known.velocity_m_s])


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
                    f"the orbit of {name!r} decays, but flights in true dynamics have no drag; "
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


class Whereabouts:
    """States of bodies: as their ephemerides report, or moved freely from the epoch.

    Parameters
    ----------
    refined : RefinedPlan
    reported : mapping
        Ephemerides of bodies that have one, if it was refined onto them.
    """

    def __init__(self, refined: RefinedPlan, reported: Mapping[str, Ephemeris]) -> None:
        self.gravity: Gravity = refined.gravity
        self._at_epoch = {body.name: state_of(body) for body in refined.bodies}
        self._reported = reported

    @classmethod
    def of(cls, instance: Instance, refined: RefinedPlan) -> Self:
        """The states of a refined plan's bodies.

        Raises
        ------
        InputError
            It was refined onto ephemerides that are missing, or others than the instance says.
        """
        if refined.ephemerides is None:
            return cls(refined, {})
        known = ephemerides_of(instance)
        names = [body.name for body in refined.bodies if body.name in known.bodies]
        return cls(refined, {name: known.of(name) for name in names})

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies."""
        return tuple(self._at_epoch)

    def is_reported(self, name: str) -> bool:
        """Whether the states of a body are those of its ephemeris."""
        return name in self._reported

    def source_of(self, name: str) -> str:
        """Source of the states of a body, in words."""
        return "as its ephemeris says" if self.is_reported(name) else "from the state at the epoch"

    def state(self, name: str, time_s: float) -> Array:
        """State of a body at a time since the epoch, shape (6,) [m, m/s]."""
        if name in self._reported:
            return self._reported[name].state(time_s)
        return moved(self._at_epoch[name], time_s, self.gravity)

    def along(self, name: str, times_s: Array) -> Array:
        """States of a body at times in order, shape (times, 6) [m, m/s]."""
        if name in self._reported:
            return self._reported[name].state(times_s)
        found = np.empty((times_s.size, 6))
        now, before_s = self._at_epoch[name], 0.0
        for at, time_s in enumerate(times_s.tolist()):
            now = moved(now, time_s - before_s, self.gravity)
            found[at], before_s = now, time_s
        return found
