"""Flight of a whole plan in mean motion on true orbits: ΔV per leg, and the remainder of each tank.

What `solve` says of its plan when it ends. Legs between circles fly the plan's burns, and are asked
whether they arrive; the burns of the others are aimed anew (:mod:`.retargeted`). Nothing optional
is needed, and a leg takes some hundredths of a second, however long it drifts.

`fly` restates the mean dynamics of J2 (docs/model.md sections 1 and 2) in :class:`MeanDynamics`
with nothing of :mod:`adr_opt.kernels` but constants: elements are moved by their rates in boinor's
terms, and coasts by its propagator, so that an error in one of the two shows.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ...common.constants import EARTH_RADIUS_M, J2, MU_M3_S2
from ...judge.admit import AnyPlan, admit
from ...plan.launched import as_launched
from ...plan.leg_kinds import flown_kind_names
from ...plan.plan import Burn, Leg, Plan
from ...plan.plan_flight import TOW, FamilyFlight, PlanFlight, TankLeft
from ...problem.instance import Instance
from ...problem.orbit import Orbit
from ..trajectory.bodies import body_states, leaving_state
from ..trajectory.kepler import drift
from .flights import TankFlight, whole_sum
from .flyable import refuse_what_cannot_be_flown
from .retargeted import Aim
from .tanks import burnt_m_s, plan_tanks
from .two_body import State, TwoBody


class MeanDynamics(TwoBody):
    """Orbits with drifting nodes, and coasts on arcs with drifting planes.

    A coast between burns is Kepler motion within its plane, at the pace at which the mean argument
    of latitude of a circle of its semi-major axis advances; the plane turns with the node. Its
    apsides stay where they are from the node.
    """

    def body(self, orbit: Orbit, time_s: float) -> State:
        """Position [m] and velocity [m/s] of a body at a time, on its planning circle."""
        a, e = orbit.semi_major_axis_m, orbit.eccentricity
        inclination = math.radians(orbit.inclination_deg)
        n, half = self._pull(a, a * (1.0 - e * e))
        square = math.cos(inclination) ** 2
        perigee_rate = half * (5.0 * square - 1.0)
        anomaly_rate = n + half * math.sqrt(1.0 - e * e) * (3.0 * square - 1.0)
        position, velocity = self.circle_at_epoch(orbit)
        # From the epoch on along the circle: by the mean latitude, not by the time.
        gone = math.remainder((perigee_rate + anomaly_rate) * time_s, math.tau)
        position, velocity = super().coast((position, velocity), gone / n)
        node = -2.0 * half * math.cos(inclination) * time_s
        return _turned(position, node), _turned(velocity, node)

    def coast(self, state: State, time_s: float) -> State:
        """State after a coast.

        Raises
        ------
        ArithmeticError
            The orbit is not closed, or the propagator finds no answer.
        """
        position, velocity = state
        inverse_axis = 2.0 / math.hypot(*position) - float(velocity @ velocity) / self._mu
        if not inverse_axis > 0.0:
            raise ArithmeticError(f"at {math.hypot(*velocity):.6g} m/s the chaser leaves the Earth")
        axis = 1.0 / inverse_axis
        momentum = np.cross(position, velocity)
        cosine = momentum[2] / math.hypot(*momentum)
        n, half = self._pull(axis, axis)
        pace = 1.0 + half / n * (8.0 * cosine * cosine - 2.0)
        position, velocity = super().coast(state, pace * time_s)
        node = -2.0 * half * cosine * time_s
        return _turned(position, node), _turned(velocity, node)

    def _pull(self, axis: float, parameter: float) -> tuple[float, float]:
        """Mean motion, and the common factor ¾ J2 n (R/p)² of all rates [rad/s]."""
        n = math.sqrt(self._mu / axis**3)
        return n, 0.75 * J2 * n * (EARTH_RADIUS_M / parameter) ** 2


def _turned(vector: np.ndarray, angle: float) -> np.ndarray:
    """A vector rotated about the axis of the Earth."""
    c, s = math.cos(angle), math.sin(angle)
    x, y, z = vector
    return np.array([c * x - s * y, s * x + c * y, z])


MOST_MISS_M = 10.0
"""Largest miss of the stand-off by a leg between circles; burns of a plan miss by decimetres at
most [m]."""


@dataclass(frozen=True)
class MeanFlight:
    """Result of flying a plan in mean motion.

    Attributes
    ----------
    plan : Plan
    gravity : {"two-body", "j2"}
    flown : mapping
        What each leg takes by its number from 1, tows apart; None where it does not arrive [m/s].
    problems : mapping
        Why those do not arrive, by their numbers.
    tanks : tuple of TankFlight
    """

    plan: Plan
    gravity: str
    flown: Mapping[int, float | None]
    problems: Mapping[int, str]
    tanks: tuple[TankFlight, ...]

    @property
    def holds(self) -> bool:
        """Whether every tank suffices."""
        return all(tank.holds for tank in self.tanks)

    @property
    def record(self) -> PlanFlight:
        """The record for a plan file."""
        return PlanFlight.model_validate(
            {
                "how": "mean",
                "gravity": self.gravity,
                "legs_sha256": self.plan.legs_sha256,
                "holds": self.holds,
                "families": families_of(self.plan.legs, self.flown),
                "tanks": tanks_left(self.tanks),
            }
        )

    def __str__(self) -> str:
        broken = [str(tank) for tank in self.tanks if not tank.holds]
        # A leg that does not arrive is why a tank is unknown.
        why = [f"leg {number}: {problem}" for number, problem in self.problems.items()]
        return "; ".join([str(self.record), *broken, *why])


def fly_mean(
    instance: Instance, plan: AnyPlan, enough: Callable[[], bool] = lambda: False
) -> MeanFlight | None:
    """Fly a plan in the mean motion of its instance, on the true orbits of its bodies.

    Parameters
    ----------
    instance : Instance
    plan : Plan or Admitted
    enough : callable
        Called between legs; once it returns True, the flight is abandoned, and None returned.

    Raises
    ------
    InputError
        As of :func:`.fly`.
    """
    plan = admit(instance, plan).plan
    refuse_what_cannot_be_flown(instance, plan)
    instance = as_launched(instance, plan)
    orbits = dict(zip(instance.names, instance.body_orbits, strict=True))
    lead_ins = plan.lead_ins
    flown: dict[int, float | None] = {}
    problems: dict[int, str] = {}
    for number, leg in enumerate(plan.legs, start=1):
        if enough():
            return None
        try:
            flown[number] = true_delta_v_m_s(instance, orbits, leg, lead_ins.get(number, ()))
        except (ArithmeticError, ValueError) as error:  # burns of no sense lead to no numbers
            flown[number], problems[number] = None, str(error)
    return MeanFlight(plan, instance.dynamics, flown, problems, plan_tanks(instance, plan, flown))


def is_between_circles(orbits: Mapping[str, Orbit], leg: Leg) -> bool:
    """Whether the true orbits of a leg are its planning circles."""
    ends = (leg.origin, leg.destination)
    return not leg.traits.has_burns or all(orbits[name].eccentricity == 0.0 for name in ends)


def true_delta_v_m_s(
    instance: Instance, orbits: Mapping[str, Orbit], leg: Leg, lead_in: tuple[Burn, ...]
) -> float:
    """ΔV of a leg on the true orbits of its bodies, tows excluded [m/s].

    Parameters
    ----------
    instance : Instance
    orbits : mapping
        Of its bodies by name.
    leg : Leg
    lead_in : tuple of Burn
        Those that lead to its beginning from the orbit of its origin.

    Raises
    ------
    ArithmeticError
        It does not arrive.
    """
    if not leg.traits.has_burns:
        return 0.0
    if not is_between_circles(orbits, leg):
        return Aim(instance, orbits, leg, lead_in).delta_v_m_s()
    miss = _miss_m(instance, leg, lead_in)
    if not miss <= MOST_MISS_M:
        raise ArithmeticError(f"its burns miss the stand-off by {miss:.3g} m")
    return burnt_m_s(leg)


def _miss_m(instance: Instance, leg: Leg, lead_in: tuple[Burn, ...]) -> float:
    """Distance from the stand-off after the burns of a leg between circles [m]."""
    now, oblateness = leg.burns[0].time_s, instance.oblateness_m2
    position, velocity = leaving_state(instance, leg, lead_in)
    for burn in leg.burns:
        position, velocity = _moved(position, velocity, burn.time_s - now, oblateness)
        now = burn.time_s
        if burn.phase == "approach":
            break
        velocity = velocity + np.array(burn.delta_v_m_s)
    target, ahead = (each[0] for each in body_states(instance, leg.destination, now))
    radius = math.hypot(*target)
    angle = instance.transfer.standoff_m / radius
    behind = math.cos(angle) * target - math.sin(angle) * radius * ahead / math.sqrt(
        MU_M3_S2 / radius
    )
    return math.dist(position, behind)


def _moved(
    position: np.ndarray, velocity: np.ndarray, span_s: float, oblateness_m2: float
) -> tuple[np.ndarray, np.ndarray]:
    positions, velocities = drift(position, velocity, span_s, oblateness_m2)
    return positions[0], velocities[0]


def families_of(
    legs: tuple[Leg, ...], flown: Mapping[int, float | None]
) -> tuple[FamilyFlight, ...]:
    """Planned and flown cost of legs by family, without empty families.

    Tows take what they are planned with: nothing is met at their end.
    """
    found = [
        _family(
            kind,
            [(leg.delta_v_m_s, flown[at]) for at, leg in enumerate(legs, 1) if leg.kind == kind],
        )
        for kind in flown_kind_names()
    ]
    tows = [leg.tow.delta_v_m_s for leg in legs if leg.tow is not None]
    found.append(_family(TOW, [(tow, tow) for tow in tows]))
    return tuple(family for family in found if family.legs)


def _family(family: str, legs: list[tuple[float, float | None]]) -> FamilyFlight:
    return FamilyFlight(
        family=family,
        legs=len(legs),
        planned_delta_v_m_s=math.fsum(planned for planned, _ in legs),
        flown_delta_v_m_s=whole_sum(flown for _, flown in legs),
    )


def tanks_left(tanks: tuple[TankFlight, ...]) -> tuple[TankLeft, ...]:
    """Remainder of each tank, as stated in plan files."""
    return tuple(
        TankLeft(
            chaser=tank.chaser,
            tank=tank.tank,
            left_m_s=None if tank.over_m_s is None else -tank.over_m_s,
        )
        for tank in tanks
    )
