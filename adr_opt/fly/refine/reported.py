"""Bodies of a plan's legs by their ephemerides, and the ΔV of holding beside them.

A leg begins at the position and velocity that is reported of its origin and ends at those reported
of its destination. Between them it is a trajectory in the field; the bodies are on none, since
their ephemerides know of other forces, and those of SGP4 have velocities that are not the
derivatives of their positions.

So a chaser let go on a state by SGP4 is some hundreds of metres off after a revolution. The ΔV of
holding is estimated and not flown: beside the body, impulses lead from each reported position to
the next, :data:`PER_REVOLUTION` times a revolution; the first begins with the reported velocity,
and a last one ends with it. For shorter intervals the sum tends to that of continuous thrust.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from ...common.constants import MU_M3_S2
from ...kernels.orbits import coast
from ...kernels.orbits.gravity import FIELDS
from ...kernels.orbits.short_periods import Array
from ...plan.plan import Leg
from ...problem.instance import Instance
from ...problem.rules import Follower
from ...problem.support import refuse
from ...sources.ephemerides import Ephemerides, ephemerides_of
from ..flight.flyable import REFINED
from .bodies import Gravity, TrueBodies

DEFAULT_GRAVITY: Gravity = "j4"
"""Field of legs between ephemerides: SGP4 has these harmonics, too."""


class ReportedBodies:
    """States of bodies at the times of legs, as :class:`.bodies.MovingBodies`.

    They are read once, so that threads and workers share nothing but numbers. A body without an
    ephemeris, which a station may be, moves in the field as :class:`.bodies.TrueBodies` has it.

    Parameters
    ----------
    instance : Instance
    known : Ephemerides
        Of the instance.
    gravity : {"two-body", "j2", "j3", "j4"}
    legs : iterable of Leg
        With burns, the last of them those of the approach.
    tows : iterable of (str, float)
        Objects that are towed, and when their tows begin [s].

    Raises
    ------
    InputError
        An ephemeris cannot be read, or the orbit of a body without one decays.
    """

    def __init__(
        self,
        instance: Instance,
        known: Ephemerides,
        gravity: Gravity,
        legs: Iterable[Leg],
        tows: Iterable[tuple[str, float]] = (),
    ) -> None:
        legs = tuple(legs)
        names = dict.fromkeys(name for leg in legs for name in (leg.origin, leg.destination))
        others = [name for name in names if name not in known.bodies]
        self.gravity, self._others = gravity, TrueBodies(instance, gravity, others)
        reported = {name: known.of(name) for name in names if name in known.bodies}
        self.epoch_states = {
            name: reported[name].state(0.0) if name in reported else self._others.epoch_states[name]
            for name in names
        }
        self._states: dict[tuple[str, float], Array] = {}
        self._behind: dict[tuple[str, float, float], Array] = {}
        for name, tow_s in tows:
            if name in reported:
                self._states[name, tow_s] = reported[name].state(tow_s)
        length_m = instance.transfer.standoff_m
        for leg in legs:
            start_s, standoff_s, docked_s = times_of(leg)
            if leg.origin in reported:
                self._states[leg.origin, start_s] = reported[leg.origin].state(start_s)
            if leg.destination in reported:
                ephemeris = reported[leg.destination]
                self._states[leg.destination, docked_s] = ephemeris.state(docked_s)
                now = ephemeris.state(standoff_s)
                self._behind[leg.destination, standoff_s, length_m] = ephemeris.state(
                    standoff_s - delay_s(now, length_m)
                )

    def state(self, name: str, time_s: float) -> Array:
        """State of a body by its ephemeris at its time in a leg, shape (6,) [m, m/s]."""
        if name in self._others.epoch_states:
            return self._others.state(name, time_s)
        return self._states[name, time_s].copy()

    def following(self, name: str, time_s: float, length_m: float) -> Array:
        """State of a body by its ephemeris, delayed by the time for a distance, shape (6,)."""
        if name in self._others.epoch_states:
            return self._others.following(name, time_s, length_m)
        return self._behind[name, time_s, length_m].copy()


def times_of(leg: Leg) -> tuple[float, float, float]:
    """Times of a leg's first burn, its stand-off and its docking [s]."""
    assert leg.standoff_s is not None
    return leg.leaves_s, leg.standoff_s, leg.docked_s


def delay_s(state: Array, length_m: float) -> float:
    """Time that a distance takes at the speed of a state [s]."""
    return length_m / math.sqrt(float(state[3:] @ state[3:]))


ONTO_EPHEMERIDES = Follower(
    "refinement onto ephemerides", REFINED.follows - {"low thrust"}, "refine without --ephemerides"
)


def opened(instance: Instance) -> Ephemerides:
    """Ephemerides of an instance that legs are to be refined onto.

    Raises
    ------
    InputError
        There are none, they are others than the instance says, or it has low thrust.
    """
    known = ephemerides_of(instance)
    refuse(instance, ONTO_EPHEMERIDES)
    return known


PER_REVOLUTION = 24
"""Number of impulses per revolution; 60 of them would take 5 % more ΔV."""


def holding_m_s(known: Ephemerides, gravity: Gravity, leg: Leg, *, led: bool = False) -> float:
    """ΔV of a leg's wait at its origin and its service at its destination [m/s].

    Parameters
    ----------
    known : Ephemerides
        A body without one takes nothing.
    gravity : {"two-body", "j2", "j3", "j4"}
    leg : Leg
        With burns; where it ends in a tow, the chaser is held until that begins.
    led : bool
        It begins where a tow has led, and is held nowhere.
    """
    start_s, _, docked_s = times_of(leg)
    ready_s = start_s if led else leg.ready_s
    until_s = leg.removal_burns[0].time_s if leg.removal_burns else leg.end_s
    spans = (leg.origin, ready_s, start_s), (leg.destination, docked_s, until_s)
    return math.fsum(
        _beside(known, gravity, name, begin_s, end_s)
        for name, begin_s, end_s in spans
        if name in known.bodies and end_s > begin_s
    )


def _beside(known: Ephemerides, gravity: Gravity, name: str, begin_s: float, end_s: float) -> float:
    ephemeris = known.of(name)
    radius_m = math.hypot(*ephemeris.state(begin_s)[:3])
    step_s = math.tau * math.sqrt(radius_m**3 / MU_M3_S2) / PER_REVOLUTION
    times = np.linspace(begin_s, end_s, max(1, math.ceil((end_s - begin_s) / step_s)) + 1)
    return following_m_s(ephemeris.state(times), times, gravity)


def following_m_s(states: Array, times_s: Array, gravity: Gravity) -> float:
    """ΔV of impulses that follow a sequence of positions [m/s].

    The misses of a few metres are closed to first order.

    Parameters
    ----------
    states : (n, 6) float64
        Reported [m, m/s].
    times_s : (n,) float64
        Theirs, at most a fraction of a revolution apart.
    gravity : {"two-body", "j2", "j3", "j4"}
    """
    total, velocity = 0.0, states[0, 3:]
    for at, span_s in enumerate(np.diff(times_s)):
        now, matrix = states[at].copy(), np.eye(6)
        coast.coast(now, float(span_s), FIELDS[gravity], matrix)
        change = np.linalg.solve(matrix[:3, 3:], states[at + 1, :3] - now[:3])
        total += math.dist(states[at, 3:] + change, velocity)
        velocity = now[3:] + matrix[3:, 3:] @ change
    return total + math.dist(states[-1, 3:], velocity)
