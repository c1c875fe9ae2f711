"""Adapter of boinor, in metres and seconds since the epoch.

boinor is the maintained continuation of poliastro, whose last release, 0.17, itself refuses
Python ≥ 3.11 and NumPy 2.

Of its propagators the one in universal variables (Vallado) is used, through its core function and
in metres. The others go through classical elements, which lose digits where burns lead: on orbits
that are all but circular or all but equatorial they are wrong by up to decimetres. Vallado's
iteration ends at a step of 1e-7 √length: in metres that is under 0.3 mm of way for any low orbit,
in kilometres, the unit of boinor's ``Orbit``, it would be 8 mm.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ...common.errors import MissingExtra
from ...kernels.core.compile import keep
from ...plan.plan import Leg
from ...problem.orbit import Orbit
from .result import EccentricFlight

PARTS = 16
"""Number of times along the last arc at which a correction is tried."""


def fly_eccentric(
    two_body: TwoBody, origin: State, destination: State, leg: Leg, standoff_m: float
) -> EccentricFlight:
    """Fly a leg on the true orbits of its bodies, and solve for a last arc that reaches the goal.

    Parameters
    ----------
    two_body : TwoBody
    origin, destination : (position, velocity)
        States of the bodies at the epoch, on their true orbits.
    leg : Leg
        Its burns are flown as they are.
    standoff_m : float
        L, along the destination's orbit [m].
    """
    approach = next(i for i, burn in enumerate(leg.burns) if burn.phase == "approach")
    before = leg.burns[:approach]
    # The last arc is the terminal one; a plan may have been tampered with, so it is looked for.
    first = next((i for i, burn in enumerate(before) if burn.phase == "terminal"), approach)
    last_arc_delta_v = sum(math.hypot(*burn.delta_v_m_s) for burn in before[first:])
    arrival = leg.burns[approach].time_s

    miss = speed = whole = least = when = None
    try:
        now = leg.burns[0].time_s
        chaser = two_body.coast(origin, now)
        begin = None
        for number, burn in enumerate(before):
            position, velocity = two_body.coast(chaser, burn.time_s - now)
            now = burn.time_s
            if number == first:
                begin = now, (position, velocity)
            chaser = position, velocity + np.array(burn.delta_v_m_s)
        chaser = two_body.coast(chaser, arrival - now)
        goal = _behind(two_body, destination, arrival, standoff_m)
        miss, speed = distance(chaser[0], goal[0]), distance(chaser[1], goal[1])
        if begin is not None:
            burned = np.array(before[first].delta_v_m_s)
            costs = _corrections(two_body, *begin, burned, goal, arrival)
            whole = costs.get(begin[0])
            if costs:
                when = min(costs, key=costs.__getitem__)
                least = costs[when] - last_arc_delta_v
    except ArithmeticError:
        pass  # what is known by then is told, the rest is None
    return EccentricFlight(
        true_miss_m=miss,
        true_relative_speed_m_s=speed,
        last_arc_delta_v_m_s=last_arc_delta_v,
        lambert_delta_v_m_s=whole,
        correction_delta_v_m_s=least,
        correction_time_s=when,
        eccentricity_delta_v_m_s=leg.eccentricity_delta_v_m_s,
    )


def _corrections(
    two_body: TwoBody, begin: float, state: State, planned: np.ndarray, goal: State, arrival: float
) -> dict[float, float]:
    """ΔV of the last arc by the time at which a Lambert arc begins: time [s] → [m/s].

    At the beginning it replaces the planned burn, later it follows upon it.
    """
    normal = np.cross(*goal)
    costs = {}
    for part in range(PARTS):
        time = begin + (arrival - begin) * part / PARTS
        try:
            position, velocity, spent = *state, 0.0
            if part > 0:
                spent = math.hypot(*planned)
                position, velocity = two_body.coast((position, velocity + planned), time - begin)
            leaving, arriving = two_body.lambert(position, goal[0], arrival - time, normal)
        except ArithmeticError:
            continue
        costs[time] = spent + distance(leaving, velocity) + distance(goal[1], arriving)
    return costs


def _behind(two_body: TwoBody, body: State, time: float, length: float) -> State:
    """The point that follows a body on its orbit, delayed by the time to travel L."""
    speed = math.hypot(*two_body.coast(body, time)[1])
    return two_body.coast(body, time - length / speed)


Vector = npt.NDArray[np.float64]
State = tuple[Vector, Vector]

MOST_ITERATIONS = 100
"""Maximum number of Newton steps of the propagator; near-circular arcs take three or four."""

MOST_RADIANS = 1e6
"""Longest coast: beyond some hundred thousand revolutions the phase loses too many digits."""

LAMBERT_TOLERANCE = 1e-10
"""Last step of Izzo's iteration, in its dimensionless variable."""

LAMBERT_MISS_M = 1.0
"""Tolerance on the end of a Lambert arc when flown; measured: millimetres."""


class TwoBody:
    """Orbits, coasts and Lambert arcs about the Earth."""

    def __init__(self) -> None:
        try:
            from astropy import units
            from boinor.bodies import Earth
            from boinor.core import angles, elements, iod, propagation
            from boinor.twobody import Orbit as Conic
        except ImportError:
            raise MissingExtra("flying a plan", "boinor", "astro") from None
        for slowly_compiled in (elements.coe2rv, propagation.vallado, iod.izzo):
            keep(slowly_compiled)
        self._units, self._earth, self._conic = units, Earth, Conic
        self._angles, self._vallado, self._izzo = angles, propagation.vallado, iod.izzo
        self._mu = float(Earth.k.to_value(units.m**3 / units.s**2))

    def circle_at_epoch(self, orbit: Orbit) -> State:
        """Position [m] and velocity [m/s] at the epoch, on the planning circle.

        The circle has r = a, and its argument of latitude is that of the mean body: argument of
        perigee + mean anomaly.
        """
        e = orbit.eccentricity
        mean = self._angles.E_to_M(self._angles.nu_to_E(_true_anomaly(orbit), e), e)
        return self._state(orbit, 0.0, 0.0, math.radians(orbit.argument_of_perigee_deg) + mean)

    def body(self, orbit: Orbit, time_s: float) -> State:
        """Position [m] and velocity [m/s] of a body at a time, on its planning circle."""
        return self.coast(self.circle_at_epoch(orbit), time_s)

    def true_at_epoch(self, orbit: Orbit) -> State:
        """Position [m] and velocity [m/s] at the epoch, on the true Kepler orbit."""
        perigee = math.radians(orbit.argument_of_perigee_deg)
        return self._state(orbit, orbit.eccentricity, perigee, _true_anomaly(orbit))

    def _state(self, orbit: Orbit, eccentricity: float, perigee: float, anomaly: float) -> State:
        u = self._units
        anomaly = math.remainder(anomaly, math.tau)
        conic = self._conic.from_classical(
            self._earth,
            orbit.semi_major_axis_m * u.m,
            eccentricity * u.one,
            orbit.inclination_deg * u.deg,
            orbit.raan_deg * u.deg,
            perigee * u.rad,
            (anomaly if anomaly < math.pi else -math.pi) * u.rad,
        )
        position, velocity = conic.rv()
        return position.to_value(u.m), velocity.to_value(u.m / u.s)

    def coast(self, state: State, time_s: float) -> State:
        """State after a coast.

        Raises
        ------
        ArithmeticError
            The orbit is not closed, or the propagator finds no answer.
        """
        if time_s == 0.0:
            return state
        position, velocity = state
        # Asked before and not after: the propagator never returns from a NaN or an overflow.
        speed = math.hypot(*velocity)
        inverse_axis = 2.0 / math.hypot(*position) - speed * speed / self._mu
        if not inverse_axis > 0.0:
            raise ArithmeticError(f"at {speed:.6g} m/s the chaser leaves the Earth")
        if not abs(time_s) * math.sqrt(self._mu * inverse_axis) * inverse_axis < MOST_RADIANS:
            raise ArithmeticError(f"{time_s:.6g} s is too long a coast")
        try:
            f, g, f_dot, g_dot = self._vallado(
                self._mu, position, velocity, time_s, MOST_ITERATIONS
            )
        except RuntimeError:
            raise ArithmeticError("the propagator finds no answer") from None
        # The Lagrange coefficients are a solution only where their determinant is one.
        if not abs(f * g_dot - f_dot * g - 1.0) < 1e-6:
            raise ArithmeticError("the answer of the propagator is not consistent")
        return f * position + g * velocity, f_dot * position + g_dot * velocity

    def lambert(self, start: Vector, end: Vector, time_s: float, normal: Vector) -> State:
        """Velocities at both ends of an arc of less than one revolution between two points.

        Parameters
        ----------
        start, end : (3,) float64
            [m].
        time_s : float
            Time of flight [s].
        normal : (3,) float64
            The sense of rotation: the arc's angular momentum is on this side.

        Raises
        ------
        ArithmeticError
            No answer is found, or the answer, flown, does not lead to the end.

        Notes
        -----
        D. Izzo, Revisiting Lambert's problem, Celestial Mechanics and Dynamical Astronomy 121
        (2015), as boinor has it.
        """
        # boinor tells the sense of rotation by the z of the arc's normal. Targets are in polar
        # orbits, where that says little: so the problem is turned until the given normal is z.
        z = normal / math.hypot(*normal)
        x = start - (start @ z) * z
        x = x / math.hypot(*x)
        axes = np.array([x, np.cross(z, x), z])
        try:
            leaving, arriving = self._izzo(
                self._mu,
                axes @ start,
                axes @ end,
                time_s,
                0,
                True,
                True,
                MOST_ITERATIONS,
                LAMBERT_TOLERANCE,
            )
        except (ValueError, RuntimeError, AssertionError, ZeroDivisionError) as error:
            raise ArithmeticError(f"no Lambert arc: {error}") from None
        leaving, arriving = axes.T @ leaving, axes.T @ arriving
        reached = self.coast((start, leaving), time_s)[0]
        if not distance(reached, end) < LAMBERT_MISS_M:
            raise ArithmeticError("the Lambert arc does not lead to its end")
        return leaving, arriving


def distance(a: Vector, b: Vector) -> float:
    """Euclidean distance."""
    return math.sqrt((a - b) @ (a - b))


def _true_anomaly(orbit: Orbit) -> float:
    return math.remainder(math.radians(orbit.true_anomaly_deg), math.tau)
