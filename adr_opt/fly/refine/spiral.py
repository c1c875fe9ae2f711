"""Tows by spirals in true dynamics: against the motion, in sunlight, to a circle.

A shadow leaves thrust on one side of the orbit, so that thrust against the motion alone makes it
eccentric. Each arc of a spiral has a law (docs/model.md section 11.6) that changes the eccentricity
as little as leads to a circle at the release. That takes longer than thrust against the motion
alone: where it takes longer than the plan has, the tow begins earlier, while the chaser waits in
the plan; where that is not enough, as much eccentricity is left as there is no time to undo.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...common.constants import EARTH_RADIUS_M
from ...kernels.orbits import mean_thrusting, primer, thrusting
from ...kernels.orbits.gravity import FIELDS
from ...kernels.orbits.short_periods import Array
from ...kernels.orbits.thrusting import Push, ThrustArcs
from ...plan.plan import Plan
from ...plan.refined_plan import RefinedTow
from ...plan.refined_thrust import RefinedThrust
from ...plan.routes import routes_of
from ...problem.instance import Instance
from .bodies import TrueBodies, near_circle, recorded
from .thrust_guess import LEAST_THRESHOLD
from .thrust_record import steered_arcs
from .thrust_task import towing_by_leg

ARC_S = 6.0 * 86400.0
"""Approximate duration of arcs, in which the shadow moves some degrees against the perigee [s]."""

MOST_ARCS = 40

CLOSED_M, CLOSED_E = 0.01, 1e-8
"""Tolerances of the mean semi-major axis [m] and eccentricity at the release."""

GOOD_M, GOOD_E = 10.0, 1e-5
"""Misses that are good enough if no step makes them smaller."""

PREDICTED = 3e-5
"""Tolerance of predictions, relative to the semi-major axis, and of the eccentricity."""

ROUND = 1e-4
"""Predicted eccentricity below which an orbit counts as a circle."""

MOST_STEPS, MOST_STARTS, ROUNDINGS = 12, 12, 10
"""Maximum numbers of Newton steps and of starting times, and number of steps from the eccentricity
left by thrust against the motion to zero."""

AGAIN = 1.1
"""Least factor on the planned duration of a tow after no spiral was found."""

LONGER = 1.06
"""Factor on the duration of a tow from one attempt to the next."""

STEP = 1e-3
"""Step of finite differences: of laws, and of the force as a share of itself."""

SPARE = 0.003
"""Share of the force reserved for correcting the integrated flight."""

FREE = 100.0
"""Weight of the laws relative to the force, so large that the force is nearly free."""

LARGEST = 1.5
"""Largest ratio in a law of the part for eccentricity to the part for size."""

LARGEST_GROWTH = 0.3
"""Largest change of the force in a step, as a share."""

MOST_WINDOWS = 40000
NO_WINDOWS = np.empty((0, 3))


class SpiralTow(NamedTuple):
    """A spiral to be flown.

    Attributes
    ----------
    name : str
        Of the object.
    ready_s, start_s, end_s : float
        From when on it may begin, and the plan's times of its beginning and end [s].
    radius_m : float
        Of the disposal orbit.
    delta_v_m_s : float
        As planned.
    push : Push
        With all of the thrust, and the mass of chaser and object.
    """

    name: str
    ready_s: float
    start_s: float
    end_s: float
    radius_m: float
    delta_v_m_s: float
    push: Push


def spirals_by_leg(instance: Instance, plan: Plan) -> dict[int, SpiralTow]:
    """The spiral after each leg that is followed by one, by number of the leg.

    Masses are as planned. A spiral ends when the next leg leaves, as the plan has it up to
    rounding.
    """
    towing, found = towing_by_leg(instance, plan), {}
    masses = {target.name: float(target.mass_kg or 0.0) for target in instance.targets}
    for flown in routes_of(instance, plan):
        if not flown.legs:
            continue
        leaves = [leg.departure_s for _, leg in flown.legs[1:]]
        for (number, leg), leaves_s in zip(flown.legs, [*leaves, math.inf], strict=True):
            if number not in towing or leg.tow is None:
                continue
            found[number] = SpiralTow(
                leg.destination,
                leg.end_s,
                leg.tow.start_s,
                min(leg.tow.end_s, leaves_s),
                EARTH_RADIUS_M + instance.circle_m(leg.destination),
                leg.tow.delta_v_m_s,
                towing[number].towing(masses[leg.destination]),
            )
    return found


class _Spiral(NamedTuple):
    """Thrust of a spiral: from a time on, with a share of the force, and a law for each arc."""

    start_s: float
    force: float
    shapes: Array

    def moved(self, step: Array) -> _Spiral:
        """The spiral after a step of the force, as a share of it, and of the shapes."""
        shapes = np.clip(self.shapes + step[1:].reshape(-1, 2), -LARGEST, LARGEST)
        grown = min(max(float(step[0]), -LARGEST_GROWTH), LARGEST_GROWTH)
        return _Spiral(self.start_s, self.force * math.exp(grown), shapes)


class NoSpiral(ArithmeticError):
    """No spiral tows an object in the available time.

    Parameters
    ----------
    reason : str
    name : str
        Of the object.
    """

    def __init__(self, reason: str, name: str = "") -> None:
        super().__init__(reason)
        self.name = name


def towed_by_spiral(bodies: TrueBodies, tow: SpiralTow) -> RefinedTow:
    """Tow an object by a spiral in true dynamics.

    Parameters
    ----------
    bodies : TrueBodies
        With the object.
    tow : SpiralTow

    Raises
    ------
    NoSpiral
        The thrust does not suffice in the time that there is.
    """
    try:
        return _towed(bodies, tow)
    except ArithmeticError as error:
        raise NoSpiral(str(error), tow.name) from error


def _towed(bodies: TrueBodies, tow: SpiralTow) -> RefinedTow:
    earliest_s = max(tow.ready_s, tow.end_s - AGAIN * (tow.end_s - tow.start_s))
    task = _Task(bodies, tow)
    try:
        spiral = task.closed(task.predicted())
    except ArithmeticError:
        if earliest_s >= tow.start_s:
            raise
        task = _Task(bodies, tow._replace(start_s=earliest_s))
        spiral = task.closed(task.predicted())
    windows = np.empty((MOST_WINDOWS, 3))
    end, windows, mass = task.integrate(spiral, windows)
    push = task.push(spiral)
    thrust = RefinedThrust(
        force_n=push.force,
        exhaust_m_s=push.exhaust,
        mass_kg=push.mass,
        propellant_kg=push.mass - mass,
        arcs=tuple(arc for arc in steered_arcs(push, task.laws(spiral), windows) if arc.windows_s),
    )
    return RefinedTow(
        burns=(),
        released=recorded("release", tow.end_s, end),
        thrust=thrust,
        planned_delta_v_m_s=tow.delta_v_m_s,
    )


class _Task:
    """A spiral from the orbit of the object to the circle of its release."""

    def __init__(self, bodies: TrueBodies, tow: SpiralTow) -> None:
        self._bodies, self._tow = bodies, tow
        self._zonals = FIELDS[bodies.gravity]
        self._states: dict[float, Array] = {}

    def push(self, spiral: _Spiral) -> Push:
        """The thrust, with the share of its force."""
        return self._tow.push._replace(force=spiral.force * self._tow.push.force)

    def laws(self, spiral: _Spiral) -> Array:
        """Law of each arc, shape (arcs, 5)."""
        laws = np.zeros((len(spiral.shapes), 5))
        laws[:, :2] = spiral.shapes
        laws[:, 2] = -1.0
        return laws

    def _arcs(self, spiral: _Spiral) -> ThrustArcs:
        count, lasts = len(spiral.shapes), self._tow.end_s - spiral.start_s
        starts = spiral.start_s + lasts * np.arange(count) / count
        # All of the time to the next arc: what is left of a span is not made up for.
        spans = np.full(count, lasts)
        laws = self.laws(spiral)
        # Where the primer vector is short it turns faster than any integrator steps.
        least = np.array([LEAST_THRESHOLD * primer.peak(law) for law in laws])
        return ThrustArcs(laws, least, starts, spans)

    def _state(self, time_s: float) -> Array:
        if time_s not in self._states:
            self._states[time_s] = self._bodies.state(self._tow.name, time_s)
        return self._states[time_s]

    def predict(self, spiral: _Spiral) -> Array:
        """Mean elements at the release, by averaged motion."""
        begins = near_circle(self._state(spiral.start_s), self._zonals)
        mean, _, _ = mean_thrusting.fly(
            begins, spiral.start_s, self._tow.end_s, self.push(spiral), self._arcs(spiral)
        )
        found: Array = mean
        return found

    def integrate(self, spiral: _Spiral, room: Array = NO_WINDOWS) -> tuple[Array, Array, float]:
        """State at the release, windows and mass, by integrated motion."""
        now = thrusting.elements_of(self._state(spiral.start_s), spiral.start_s)
        count, mass, _ = thrusting.fly(
            now, self._tow.end_s, self.push(spiral), self._arcs(spiral), self._zonals, room
        )
        windows = np.minimum(room[:count], [self._tow.end_s, self._tow.end_s, math.inf])
        return thrusting.state_of(now), windows, mass

    def _off(self, mean: Array, left: Array) -> Array:
        """Miss of the relative semi-major axis and the eccentricity vector."""
        size = mean[0] / self._tow.radius_m - 1.0
        return np.array([size, mean[1] - left[0], mean[2] - left[1]])

    def _slope(
        self, spiral: _Spiral, off: Array, left: Array, motion: Callable[[_Spiral], Array]
    ) -> Array:
        """Derivatives of the miss by force and laws, in averaged or integrated motion."""
        count = 1 + spiral.shapes.size
        slope = np.empty((3, count))
        for column, step in enumerate(STEP * np.eye(count)):
            slope[:, column] = (self._off(motion(spiral.moved(step)), left) - off) / STEP
        return slope

    def _led(self, spiral: _Spiral, left: Array) -> _Spiral | None:
        """The spiral to a given final eccentricity, by averaged motion, from a nearby spiral."""
        for _ in range(MOST_STEPS):
            off = self._off(self.predict(spiral), left)
            if float(np.abs(off).max()) < PREDICTED:
                return spiral
            slope = self._slope(spiral, off, left, self.predict)
            spiral = spiral.moved(_least_step(slope, off))
        return None

    def predicted(self) -> _Spiral:
        """The spiral that leads to the release by averaged motion, within the available force.

        Raises
        ------
        ArithmeticError
            Even against the motion alone there is no time.
        """
        tow = self._tow
        start_s = tow.start_s
        for _ in range(MOST_STARTS):
            found, is_circle = self._rounded(start_s)
            if is_circle or start_s <= tow.ready_s:
                break
            start_s = max(tow.ready_s, tow.end_s - LONGER * (tow.end_s - start_s))
        if found.force > 1.0:
            raise ArithmeticError("the thrust does not suffice for the tow in its time")
        return found

    def _rounded(self, start_s: float) -> tuple[_Spiral, bool]:
        """The spiral from a starting time to the least eccentricity, and whether that is a circle.

        From thrust against the motion alone, step by step to less eccentricity.
        """
        best = self._straight(start_s)
        left = self.predict(best)[1:3]
        if best.force > 1.0 - SPARE:
            return best, False
        for share in np.linspace(1.0, 0.0, ROUNDINGS + 1)[1:]:
            found = self._led(best, share * left)
            if found is None or found.force > 1.0 - SPARE:
                return best, False
            best = found
        return best, True

    def _straight(self, start_s: float) -> _Spiral:
        """Against the motion alone, to the radius of the release."""
        count = min(max(1, math.ceil((self._tow.end_s - start_s) / ARC_S)), MOST_ARCS)
        spiral = _Spiral(start_s, 1.0, np.zeros((count, 2)))
        began = near_circle(self._state(start_s), self._zonals)[0]
        for _ in range(MOST_STEPS):
            done = began - self.predict(spiral)[0]
            spiral = spiral._replace(force=spiral.force * (began - self._tow.radius_m) / done)
        return spiral

    def closed(self, spiral: _Spiral) -> _Spiral:
        """A spiral near a predicted one whose integrated flight leads to the release.

        Raises
        ------
        ArithmeticError
            None does.
        """
        left = self.predict(spiral)[1:3]
        if math.hypot(*left) < ROUND:
            left = np.zeros(2)
        slope = self._slope(spiral, self._off(self.predict(spiral), left), left, self.predict)
        now = spiral
        off = self._off(self._flown(now), left)
        share = 1.0
        for _ in range(2 * MOST_STEPS):
            if self._misses(off, CLOSED_M, CLOSED_E):
                break
            tried = now.moved(share * _least_step(slope, off))
            found = self._off(self._flown(tried), left)
            before, after = float(np.linalg.norm(off)), float(np.linalg.norm(found))
            share = 1.0 if after < before else 0.5 * share
            if after < before:
                now, off = tried, found
            if after > 0.5 * before:
                # Where windows begin to part, predictions do not know how flights change.
                slope = self._slope(now, off, left, self._flown)
        if not self._misses(off, GOOD_M, GOOD_E) or now.force > 1.0:
            raise ArithmeticError("no spiral was found that leads to the disposal orbit in time")
        return now

    def _flown(self, spiral: _Spiral) -> Array:
        return near_circle(self.integrate(spiral)[0], self._zonals)

    def _misses(self, off: Array, most_m: float, most_e: float) -> bool:
        return abs(off[0]) * self._tow.radius_m < most_m and math.hypot(*off[1:]) < most_e


def _least_step(slope: Array, off: Array) -> Array:
    """The step with the least change of laws that removes a miss; the force is free."""
    weights = np.ones(slope.shape[1])
    weights[0] = FREE
    step: Array = weights * np.linalg.lstsq(slope * weights, -off, rcond=1e-9)[0]
    return step
