"""A leg of low thrust as a task: a chaser flies from one state to another by two arcs."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...common.constants import MU_M3_S2
from ...kernels.orbits import mean_thrusting, primer, thrusting
from ...kernels.orbits.gravity import FIELDS
from ...kernels.orbits.short_periods import Array
from ...kernels.orbits.thrusting import Push, ThrustArcs
from ...plan.plan import Plan
from ...plan.routes import routes_of
from ...problem.drives import Drive, drive_of, since_j2000_s
from ...problem.instance import Instance
from .bodies import Gravity, near_circle


@dataclass(frozen=True)
class Propelled:
    """A chaser with low thrust at the beginning of a leg.

    Attributes
    ----------
    drive : Drive
    mass_kg : float
    since_j2000_s : float
        The epoch of the mission.
    class_kg : float
        Largest mass of its class, by which the leg is planned.
    """

    drive: Drive
    mass_kg: float
    since_j2000_s: float
    class_kg: float

    def towing(self, object_kg: float) -> Push:
        """The full thrust of the chaser, with an object attached."""
        drive = self.drive
        both = self.mass_kg + object_kg
        return Push(drive.thrust_n, drive.exhaust_m_s, both, self.since_j2000_s)

    def pushes(self) -> tuple[Push, ...]:
        """The thrust of the chaser: for the acceleration of its class, as planned, or in full."""
        drive = self.drive
        shares = dict.fromkeys((min(1.0, self.mass_kg / self.class_kg), 1.0))
        return tuple(
            Push(share * drive.thrust_n, drive.exhaust_m_s, self.mass_kg, self.since_j2000_s)
            for share in shares
        )


def propelled_by_leg(instance: Instance, plan: Plan) -> dict[int, Propelled]:
    """The chaser of each leg of low thrust, by number of the leg, as heavy as planned."""
    return {number: before for number, (before, _) in _propelled(instance, plan).items()}


def towing_by_leg(instance: Instance, plan: Plan) -> dict[int, Propelled]:
    """The chaser after the service of each leg, before a tow that follows."""
    return {number: after for number, (_, after) in _propelled(instance, plan).items()}


def _propelled(instance: Instance, plan: Plan) -> dict[int, tuple[Propelled, Propelled]]:
    since, found = since_j2000_s(instance.epoch), {}
    for flown in routes_of(instance, plan):
        drive = drive_of(flown.chaser, instance.targets)
        if drive is None:
            continue

        def of(mass: float, class_kg: float | None, drive: Drive = drive) -> Propelled:
            most = drive.heaviest_kg if class_kg is None else class_kg
            return Propelled(drive, max(mass, drive.lightest_kg), since, most)

        stages = flown.aboard(instance)[1:]
        for (number, leg), begins_kg, after in zip(
            flown.legs, flown.departing_kg(instance), stages, strict=False
        ):
            ends_kg = (after.mass_kg or 0.0) + after.removal_kg
            found[number] = of(begins_kg, leg.mass_class_kg), of(ends_kg, None)
    return found


NO_WINDOWS = np.empty((0, 3))


@dataclass(frozen=True)
class Programme:
    """The thrust of both arcs.

    Attributes
    ----------
    steered : (10,) float64
        For each arc its law, as long as its ΔV [m/s].
    thresholds : (2,) float64
        Shortest primer vector with which thrust is on, as a share of the longest.
    second_s : float
        Beginning of the second arc [s].
    """

    steered: Array
    thresholds: Array
    second_s: float

    @property
    def costs_m_s(self) -> Array:
        """ΔV of each arc, shape (2,) [m/s]."""
        sizes: Array = np.linalg.norm(self.steered.reshape(2, 5), axis=1)
        return sizes

    @property
    def laws(self) -> Array:
        """Laws of unit length, shape (2, 5)."""
        laws: Array = self.steered.reshape(2, 5) / np.maximum(self.costs_m_s, 1e-12)[:, None]
        return laws

    def steered_by(self, steered: Array) -> Programme:
        """A programme with other laws."""
        return Programme(steered, self.thresholds, self.second_s)


class Prediction(NamedTuple):
    """Averaged flight of a programme.

    Attributes
    ----------
    mean : (6,) float64
        Elements near a circle at the end, with revolutions.
    ends_s : (2,) float64
        Ends of both arcs.
    left_s : float
        Time of thrust that remains undone.
    """

    mean: Array
    ends_s: Array
    left_s: float


class Integration(NamedTuple):
    """Integrated flight of a programme.

    Attributes
    ----------
    end : (6,) float64
        State at the end [m, m/s].
    turned : float
        Longitude that was run through [rad].
    windows : (windows, 3) float64
        Beginning [s], end [s] and arc of each window of thrust; none unless asked for.
    mass_kg : float
    left_s : float
    """

    end: Array
    turned: float
    windows: Array
    mass_kg: float
    left_s: float


@dataclass(frozen=True)
class ThrustTask:
    """Start and goal of a leg of low thrust.

    Attributes
    ----------
    start, goal : (6,) float64
        Inertial states [m, m/s].
    start_s, end_s : float
        Their times since the epoch [s].
    push : Push
    gravity : {"two-body", "j2", "j3", "j4"}
    bias : (6,) float64
        What integrated flights differ by from averaged ones at the end, in mean elements.
    """

    start: Array
    goal: Array
    start_s: float
    end_s: float
    push: Push
    gravity: Gravity
    bias: Array = field(default_factory=lambda: np.zeros(6))

    @cached_property
    def origin(self) -> Array:
        """Mean elements of the start."""
        return near_circle(self.start, FIELDS[self.gravity])

    @cached_property
    def target(self) -> Array:
        """Mean elements of the goal."""
        return near_circle(self.goal, FIELDS[self.gravity])

    @cached_property
    def speed(self) -> float:
        """Circular speed at the goal [m/s]."""
        return math.sqrt(MU_M3_S2 / self.target[0])

    @cached_property
    def _scale(self) -> Array:
        # What each element costs to change [m/s]; the longitude by a change at the beginning.
        v, a = self.speed, self.target[0]
        span = self.end_s - self.start_s
        sine = math.sin(self.target[3])
        return np.array([0.5 * v / a, 0.5 * v, 0.5 * v, v, v * sine, a / (3.0 * span)])

    def arcs(self, programme: Programme) -> ThrustArcs:
        """The programme's arcs as kernels take them."""
        laws, costs, push = programme.laws, programme.costs_m_s, self.push
        least = [s * primer.peak(law) for s, law in zip(programme.thresholds, laws, strict=True)]
        mass = push.mass * np.exp(-np.array([0.0, costs[0]]) / push.exhaust)
        spans = mass * push.exhaust / push.force * -np.expm1(-costs / push.exhaust)
        return ThrustArcs(
            laws, np.array(least), np.array([self.start_s, programme.second_s]), spans
        )

    def predict(self, programme: Programme) -> Prediction:
        """Averaged flight."""
        mean, ends_s, left_s = mean_thrusting.fly(
            self.origin, self.start_s, self.end_s, self.push, self.arcs(programme)
        )
        return Prediction(mean + self.bias, ends_s, left_s)

    def learnt(self, programme: Programme) -> ThrustTask:
        """The task, with predictions corrected by the integrated flight of a programme.

        Averaged rates are of first order. In a drift of months the node is a tenth of a degree off
        them, which takes another number of laps.
        """
        told, flown = self.predict(programme).mean, self.integrate(programme)
        off = near_circle(flown.end, FIELDS[self.gravity]) - told
        turned = flown.turned - float(told[4] + told[5] - self.origin[4] - self.origin[5])
        off[4], off[5] = (math.remainder(angle, math.tau) for angle in off[4:])
        off[5] += math.tau * round((turned - off[4] - off[5]) / math.tau)
        if not np.isfinite(off).all():
            return self
        return replace(self, bias=self.bias + off)

    def integrate(self, programme: Programme, room: Array = NO_WINDOWS) -> Integration:
        """Integrated flight, with up to a maximum number of windows."""
        now = thrusting.elements_of(self.start, self.start_s)
        began = now[6]
        count, mass, left = thrusting.fly(
            now, self.end_s, self.push, self.arcs(programme), FIELDS[self.gravity], room
        )
        return Integration(thrusting.state_of(now), now[6] - began, room[:count], mass, left)

    def off(self, mean: Array, laps: float) -> Array:
        """Miss of mean elements with revolutions, of which ``laps`` are wanted, shape (6,) [m/s].

        Each of them is counted as what it costs to change.
        """
        miss = mean - self.target
        miss[4] = math.remainder(miss[4], math.tau)
        miss[5] += math.cos(self.target[3]) * miss[4] - math.tau * laps
        scaled: Array = miss * self._scale
        return scaled

    def laps_to(self, mean: Array) -> float:
        """Laps by which a flight with these mean elements is on time, not a whole number."""
        return float(self.off(mean, 0.0)[5] / self._scale[5] / math.tau)

    def off_integrated(self, flown: Integration, turned: float) -> Array:
        """Miss of an integrated flight that should turn by an angle, as of :meth:`off` [m/s]."""
        mean = near_circle(flown.end, FIELDS[self.gravity])
        laps = round((flown.turned - turned) / math.tau - self.laps_to(mean))
        return self.off(mean, -float(laps))
