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
from ...problem.orbit import Orbit

Vector = npt.NDArray[np.float64]
State = tuple[Vector, Vector]

MOST_ITERATIONS = 100
"""Maximum number of Newton steps of the propagator; near-circular arcs take three or four."""

MOST_RADIANS = 1e6
"""Longest coast: beyond some hundred thousand revolutions the phase loses too many digits."""


class TwoBody:
    """Orbits and coasts about the Earth."""

    def __init__(self) -> None:
        try:
            from astropy import units
            from boinor.bodies import Earth
            from boinor.core import angles, elements, propagation
            from boinor.twobody import Orbit as Conic
        except ImportError:
            raise MissingExtra("flying a plan", "boinor", "astro") from None
        for slowly_compiled in (elements.coe2rv, propagation.vallado):
            keep(slowly_compiled)
        self._units, self._earth, self._conic = units, Earth, Conic
        self._angles, self._vallado = angles, propagation.vallado
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
            The orbit is not closed, or the propagator did not converge.
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
            raise ArithmeticError("the propagator did not converge") from None
        # The Lagrange coefficients are a solution only where their determinant is one.
        if not abs(f * g_dot - f_dot * g - 1.0) < 1e-6:
            raise ArithmeticError("the result of the propagator is inconsistent")
        return f * position + g * velocity, f_dot * position + g_dot * velocity


def distance(a: Vector, b: Vector) -> float:
    """Euclidean distance."""
    return math.sqrt((a - b) @ (a - b))


def _true_anomaly(orbit: Orbit) -> float:
    return math.remainder(math.radians(orbit.true_anomaly_deg), math.tau)
