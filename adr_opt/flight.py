"""Fly a plan: propagate its burns in two-body motion and measure where they lead.

The second opinion on the physics. Nothing here comes from :mod:`adr_opt.kernels`: elements are
read from the instance, and boinor (extra ``[astro]``) turns them into states and propagates them.
boinor is the maintained continuation of poliastro, whose last release, 0.17, itself refuses
Python ≥ 3.11 and NumPy 2.

Of boinor's propagators the one in universal variables (Vallado) is used, through its core
function and in metres. The others go through classical elements, which lose digits where burns
lead: on orbits that are all but circular or all but equatorial they are wrong by up to
decimetres. Vallado's iteration ends at a step of 1e-7 √length: in metres that is under 0.3 mm of
way for any low orbit, in kilometres, the unit of boinor's ``Orbit``, it would be 8 mm.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import InputError, MissingExtra
from .instance import Instance, Orbit
from .plan import Leg, Plan

Vector = npt.NDArray[np.float64]
State = tuple[Vector, Vector]

MOST_ITERATIONS = 100
"""Newton steps of the propagator; near-circular arcs take three or four."""

TIME_TOLERANCE_S = 1e-3
"""How far the last burn may lie behind the stated arrival."""

MOST_RADIANS = 1e6
"""Longest coast: beyond some hundred thousand revolutions too few digits of the phase are left."""


@dataclass(frozen=True)
class LegFlight:
    """Where the burns of one leg lead.

    Attributes
    ----------
    leg : int
        Number of the leg, from 1.
    origin, destination : str
    miss_m : float
        Distance from the stand-off point, the point L behind the destination on its orbit, when
        the approach begins [m].
    relative_speed_m_s : float
        Speed relative to that point, before the first impulse of the approach [m/s].
    arrival_miss_m : float
        Distance from the destination at the end of the approach [m]. Some centimetres at
        L = 1 km: the approach is a solution of the Clohessy–Wiltshire equations, which are linear
        in the distance, so this miss grows with L².
    """

    leg: int
    origin: str
    destination: str
    miss_m: float
    relative_speed_m_s: float
    arrival_miss_m: float


@dataclass(frozen=True)
class Flight:
    """What came of flying a plan.

    Attributes
    ----------
    worst_miss_m : float
        Largest stand-off miss of all legs; 0 for a plan without legs [m].
    legs : tuple of LegFlight
    """

    worst_miss_m: float
    legs: tuple[LegFlight, ...]

    def to_dict(self) -> dict[str, Any]:
        """As plain data: what ``fly --json`` prints."""
        return {"worst_miss_m": self.worst_miss_m, "legs": [asdict(leg) for leg in self.legs]}


def fly(instance: Instance, plan: Plan) -> Flight:
    """Fly the burns of a plan in two-body motion.

    Each leg begins on the origin's own orbit; the burns are taken from the plan as they are.
    Bodies move on the circles that the model plans with (MODEL section 1), so eccentric orbits
    are as approximate here as in the plan.

    Parameters
    ----------
    instance : Instance
    plan : Plan
        Need not be free of violations; :func:`adr_opt.check` judges that.

    Raises
    ------
    InputError
        The plan belongs to another instance, names an unknown body, or has burns that cannot be
        flown: out of time order, after the arrival, without an approach, or leading to no orbit.
    MissingExtra
        boinor is not installed.
    """
    if plan.instance.name != instance.name or plan.instance.sha256 != instance.sha256:
        raise InputError(
            f"the plan belongs to the instance {plan.instance.name!r} "
            f"(sha256 {plan.instance.sha256[:12]}…), not to {instance.name!r} "
            f"(sha256 {instance.sha256[:12]}…); give the instance it was made for"
        )
    bodies = {target.name: target.orbit for target in instance.targets}
    bodies[instance.station.name] = instance.station.orbit
    for number, leg in enumerate(plan.legs, start=1):
        _refuse_what_cannot_be_flown(number, leg, bodies)
    two_body = _TwoBody()
    states = {name: two_body.state_at_epoch(orbit) for name, orbit in bodies.items()}
    flown = tuple(
        _fly_leg(instance, two_body, states, number, leg)
        for number, leg in enumerate(plan.legs, start=1)
    )
    return Flight(max((leg.miss_m for leg in flown), default=0.0), flown)


def _refuse_what_cannot_be_flown(number: int, leg: Leg, bodies: dict[str, Orbit]) -> None:
    for name in (leg.origin, leg.destination):
        if name not in bodies:
            raise InputError(f"leg {number}: {name!r} is not a body of the instance")
    times = [burn.time_s for burn in leg.burns]
    if times != sorted(times):
        raise InputError(f"leg {number}: the burns are not in time order; sort them by time_s")
    if all(burn.phase != "approach" for burn in leg.burns):
        raise InputError(f"leg {number}: no burn begins the approach; add the approach burns")
    if leg.arrival_s < times[-1] - TIME_TOLERANCE_S:
        raise InputError(
            f"leg {number}: arrival_s = {leg.arrival_s!r} is before the last burn at "
            f"{times[-1]!r}; it must be the end of the approach"
        )


def _fly_leg(
    instance: Instance, two_body: _TwoBody, states: dict[str, State], number: int, leg: Leg
) -> LegFlight:
    target = states[leg.destination]
    standoff = None
    try:
        now = leg.burns[0].time_s
        chaser = two_body.coast(states[leg.origin], now)
        for burn in leg.burns:
            position, velocity = two_body.coast(chaser, burn.time_s - now)
            now = burn.time_s
            if standoff is None and burn.phase == "approach":
                behind = _behind(two_body.coast(target, now), instance.transfer.standoff_m)
                standoff = (_distance(position, behind[0]), _distance(velocity, behind[1]))
            chaser = position, velocity + np.array(burn.delta_v_m_s)
        at_arrival = two_body.coast(chaser, leg.arrival_s - now)
        goal = two_body.coast(target, leg.arrival_s)
    except ArithmeticError as error:
        raise InputError(f"leg {number}: cannot be flown: {error}; correct its burns") from None
    assert standoff is not None  # every leg has an approach, see above
    return LegFlight(
        leg=number,
        origin=leg.origin,
        destination=leg.destination,
        miss_m=standoff[0],
        relative_speed_m_s=standoff[1],
        arrival_miss_m=_distance(at_arrival[0], goal[0]),
    )


def _behind(state: State, distance: float) -> State:
    """State of a point that follows on a circular orbit at a distance, measured along it."""
    position, velocity = state
    radius, speed = math.sqrt(position @ position), math.sqrt(velocity @ velocity)
    cosine, sine = math.cos(distance / radius), math.sin(distance / radius)
    outward, ahead = position / radius, velocity / speed
    return (
        radius * (cosine * outward - sine * ahead),
        speed * (cosine * ahead + sine * outward),
    )


def _distance(a: Vector, b: Vector) -> float:
    return math.sqrt((a - b) @ (a - b))


class _TwoBody:
    """boinor, in metres and seconds since the epoch."""

    def __init__(self) -> None:
        try:
            from astropy import units
            from boinor.bodies import Earth
            from boinor.core import angles, propagation
            from boinor.twobody import Orbit as Conic
        except ImportError:
            raise MissingExtra("flying a plan", "boinor", "astro") from None
        self._units, self._earth, self._conic = units, Earth, Conic
        self._angles, self._vallado = angles, propagation.vallado
        self._mu = float(Earth.k.to_value(units.m**3 / units.s**2))

    def state_at_epoch(self, orbit: Orbit) -> State:
        """Position [m] and velocity [m/s] at the epoch, on the circle that is planned with.

        The circle has r = a, and its argument of latitude is that of the mean body: argument of
        perigee + mean anomaly.
        """
        u, e = self._units, orbit.eccentricity
        true = math.remainder(math.radians(orbit.true_anomaly_deg), math.tau)
        mean = self._angles.E_to_M(self._angles.nu_to_E(true, e), e)
        latitude = math.remainder(math.radians(orbit.argument_of_perigee_deg) + mean, math.tau)
        conic = self._conic.from_classical(
            self._earth,
            orbit.semi_major_axis_m * u.m,
            0.0 * u.one,
            orbit.inclination_deg * u.deg,
            orbit.raan_deg * u.deg,
            0.0 * u.rad,
            (latitude if latitude < math.pi else -math.pi) * u.rad,
        )
        position, velocity = conic.rv()
        return position.to_value(u.m), velocity.to_value(u.m / u.s)

    def coast(self, state: State, time_s: float) -> State:
        """State after some time without burns.

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
