"""A leg on the true orbits of its bodies in mean motion, with the plan's burns retargeted.

A plan's burns lead from circle to circle. Where an orbit is eccentric they arrive elsewhere: by a
few kilometres after some hours, and after weeks anywhere round the orbit, because a burn that is
made ten kilometres higher than planned leads to another pace. A chaser knows where it is and where
it is to be, and burns accordingly. So the burns keep the plan's times and are changed such that the
chaser leaves the origin's true orbit and is at the stand-off of the target's; of all that do so
those are flown that are cheap and near what was planned (:mod:`adr_opt.fly.refine.own_burns`).
`refine` does the same in integrated motion, where an arc of months takes a thousand times as long.

Motion is that of mean elements with their secular rates
(:mod:`adr_opt.kernels.orbits.mean_motion`), or Kepler's where nothing drifts. Nothing optional is
needed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ...common.constants import EARTH_RADIUS_M
from ...kernels.orbits import elements, equinoctial, mean_motion
from ...plan.plan import Burn, Leg
from ...problem.instance import Instance
from ...problem.orbit import Orbit
from ..refine.leg import FlownImpulses, LegEnds, NoWay, cheapen, close
from ..refine.one_leg import aim, docked, first_of_approach, parted, planned_angles
from ..refine.own_burns import cheapest_near
from ..refine.tow import along

Array = npt.NDArray[np.float64]

GROWN, LEAST_GROWTH = 4, 1.0 / 64.0
"""Steps in which eccentricities grow where burns cannot be closed at once: the reciprocal of the
largest share, and the smallest share."""


@dataclass(frozen=True)
class MeanCourse(LegEnds):
    """Start and goal of a leg in mean motion.

    Attributes
    ----------
    oblateness_m2 : float
        J2 R², 0 for two bodies.
    """

    oblateness_m2: float = 0.0

    def move(self, times: Array, impulses: Array) -> tuple[Array, Array, float]:
        """Fly impulses from the start by the kernel of mean motion."""
        found: tuple[Array, Array, float] = mean_motion.fly(
            self.start, times, impulses, self.end_s, self.oblateness_m2
        )
        return found


def true_state(
    orbit: Orbit, oblateness_m2: float, time_s: float, decay_m_per_day: float = 0.0
) -> Array:
    """Mean state of a body at a time on its true orbit, shape (6,) [m, m/s].

    Parameters
    ----------
    orbit : Orbit
        Mean elements at the epoch.
    oblateness_m2 : float
        J2 R², 0 for two bodies.
    time_s : float
        Since the epoch.
    decay_m_per_day : float
        By what its semi-major axis shrinks.
    """
    row = np.array(orbit.row(oblateness_m2, decay_m_per_day))
    mean, frame = elements.equinoctial_at(row, time_s)
    state: Array = equinoctial.state_of(mean, frame)
    return state


def following(
    orbit: Orbit, oblateness_m2: float, time_s: float, length_m: float, decay_m_per_day: float = 0.0
) -> Array:
    """State of the point that follows a body on its orbit, slightly delayed, (6,).

    Parameters
    ----------
    orbit : Orbit
    oblateness_m2 : float
        J2 R² of the instance's dynamics, 0 in two-body motion [m²].
    time_s : float
        Since the epoch [s].
    length_m : float
        By which the point is behind, along the orbit [m].
    decay_m_per_day : float
    """
    speed = math.hypot(*true_state(orbit, oblateness_m2, time_s, decay_m_per_day)[3:])
    return true_state(orbit, oblateness_m2, time_s - length_m / speed, decay_m_per_day)


class Aim:
    """A leg to be retargeted.

    Parameters
    ----------
    instance : Instance
    orbit_of : mapping
        The orbits of its bodies by name.
    leg : Leg
        With burns in time order, the last of them those of the approach.
    lead_in : tuple of Burn
        Those that lead to its beginning from the orbit of its origin, all against the motion.

    Raises
    ------
    ArithmeticError, ValueError
        Its burns lead away from the Earth, or there are none.
    """

    def __init__(
        self,
        instance: Instance,
        orbit_of: Mapping[str, Orbit],
        leg: Leg,
        lead_in: tuple[Burn, ...] = (),
    ) -> None:
        self._burns, self._approach = parted(leg)
        if not self._approach or self._burns[0].phase == "approach":
            raise NoWay("no burn comes before the approach, or none begins it")
        self._origin, self._target = orbit_of[leg.origin], orbit_of[leg.destination]
        self._decays = instance.decay_of(leg.origin), instance.decay_of(leg.destination)
        self._instance, self._lead_in = instance, lead_in
        self._angles = planned_angles(instance, leg, lead_in)
        self._is_free = instance.transfer.burns == "free"

    def delta_v_m_s(self) -> float:
        """ΔV of retargeted burns, or of free ones if legs are priced so; tows excluded [m/s].

        Raises
        ------
        ArithmeticError
            No burns at the plan's times do.
        """
        last = self._last()
        begins = first_of_approach(last, self._instance.transfer, self._approach)
        whole = self._course(1.0, begins)
        times = np.array([burn.time_s for burn in self._burns])
        planned = np.array([burn.delta_v_m_s for burn in self._burns])
        try:
            flown = cheapest_near(whole, self._closed(times, planned, begins), planned)
        except NoWay:
            flown = aim(whole, self._burns)  # with a few burns more
        if self._is_free:
            flown = cheapen(whole, flown)
        rest = docked(
            replace(last, start=flown.states[-1]), self._instance.transfer, self._approach
        )
        return flown.delta_v_m_s + rest.delta_v_m_s

    def _closed(self, times: Array, planned: Array, begins: Array) -> FlownImpulses:
        """Burns that reach the goal, at any cost.

        After months of drift a change of a burn by some metres per second is round the orbit by
        laps, and Newton's steps get lost. Then the eccentricities grow, from circles on, between
        which the plan's burns arrive.
        """
        try:
            return close(self._course(1.0, begins), times, planned)
        except NoWay:
            pass
        share, step, burns = 0.0, 1.0 / GROWN, planned
        while share < 1.0:
            try:
                closed = close(self._course(min(share + step, 1.0), begins), times, burns)
            except NoWay:
                step *= 0.5
                if step < LEAST_GROWTH:
                    raise
                continue
            share, burns = share + step, closed.impulses
        return closed

    def _course(self, share: float, begins: Array) -> MeanCourse:
        """Start and goal with a share of all eccentricities; the goal is on the approach."""
        origin, target = (
            orbit.replace(eccentricity=share * orbit.eccentricity)
            for orbit in (self._origin, self._target)
        )
        origin = self._origin if self._lead_in else origin  # whose burns are of its own size
        rule, start_s = self._instance.transfer, self._burns[0].time_s
        standoff_s, oblateness = self._approach[0].time_s, self._instance.oblateness_m2
        start = _led(origin, self._lead_in, start_s, oblateness, self._decays[0])
        goal = following(target, oblateness, standoff_s, rule.standoff_m, self._decays[1])
        return MeanCourse(
            start=start,
            goal=goal + np.r_[np.zeros(3), begins],
            start_s=start_s,
            end_s=standoff_s,
            angle=self._angles[0],
            gravity=self._instance.dynamics,
            lowest_m=EARTH_RADIUS_M + rule.min_altitude_m,
            highest_m=EARTH_RADIUS_M + rule.max_altitude_m,
            oblateness_m2=oblateness,
        )

    def _last(self) -> MeanCourse:
        """The approach, from rest at the stand-off to the target."""
        begin, end = self._approach[0].time_s, self._approach[-1].time_s
        rule, oblateness = self._instance.transfer, self._instance.oblateness_m2
        return MeanCourse(
            start=following(self._target, oblateness, begin, rule.standoff_m, self._decays[1]),
            goal=true_state(self._target, oblateness, end, self._decays[1]),
            start_s=begin,
            end_s=end,
            angle=self._angles[1],
            gravity=self._instance.dynamics,
            oblateness_m2=oblateness,
        )


def _led(
    orbit: Orbit,
    lead_in: tuple[Burn, ...],
    time_s: float,
    oblateness_m2: float,
    decay_m_per_day: float,
) -> Array:
    """State after lead-in burns: as large as the plan's, along the actual motion."""
    if not lead_in:
        return true_state(orbit, oblateness_m2, time_s, decay_m_per_day)
    now = lead_in[0].time_s
    state = true_state(orbit, oblateness_m2, now, decay_m_per_day)
    for burn in lead_in:
        mean_motion.coast(state, burn.time_s - now, oblateness_m2)
        now = burn.time_s
        state[3:] += along(burn, state[3:])
    mean_motion.coast(state, time_s - now, oblateness_m2)
    return state


def practise(instance: Instance, leg: Leg) -> None:
    """Compile the kernels of a flight by flying a leg with slightly eccentric orbits."""
    orbit_of = {
        name: orbit.replace(eccentricity=1e-3)
        for name, orbit in zip(instance.names, instance.body_orbits, strict=True)
    }
    Aim(instance, orbit_of, leg).delta_v_m_s()
