"""Burns of a drift leg between two times (docs/model.md section 3).

The closed form of :mod:`adr_opt.kernels.legs.drift` says what a drift costs and which orbit it
waits on. Here its burns are found. The chaser leaves its body at the line of nodes of its own plane
and that of the drift orbit, by a Hohmann transfer whose two burns share the turn; it drifts; and it
leaves the drift orbit at the line of nodes with the plane that the remaining arcs carry onto the
target's, by two half ellipses, to the co-elliptic orbit and to the stand-off, whose three burns
share the turn. The approach is that of a short transfer.

It may leave a while after the time of departure and arrive a while before that of arrival. So there
are many pairs of crossings to choose from, and for each, numbers of revolutions on the drift orbit:
the radius follows from them. Of those whose closed form costs least the few best are worked out
exactly, and the one with the cheapest burns is flown.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import DAY_S, MU_M3_S2, TURN_RAD
from ...common.errors import InputError
from ...kernels.legs import co_elliptic, drift, drift_arcs, drift_pair
from ...kernels.legs.burns import (
    APPROACH,
    CO_ELLIPTIC,
    DRIFT,
    HOHMANN_1,
    PHASES,
    TERMINAL,
    approach_burns,
    half_ellipse_speeds,
)
from ...kernels.legs.co_elliptic import TransferRule
from ...kernels.legs.drift import Split
from ...kernels.orbits import ephemeris
from ...kernels.orbits.body_rows import with_orbit
from ...plan.planes import Arcs, Plane, Turn, ahead, between, outward, turn_between, turned

FloatArray = npt.NDArray[np.float64]

TRIED = 12
"""Number of pairs of crossings solved exactly, repeatedly until one succeeds: a target's last
crossings may turn out to be minutes too late."""

CLOSE_M, FARTHEST_M, MOST_STEPS = 1e-6, 5e3, 40
"""Tolerance of a radius [m], its largest step [m], and the maximum number of steps."""

LEAST_CLIMB_M_S = 1e-3
"""Cost of leaving the drift orbit below which two burns share the turn [m/s]."""

FREEDOM_S = (0.5 * DAY_S, DAY_S, 2.0 * DAY_S)
"""Delays of departure and advances of arrival to try; the first that suffices is used [s]."""


class DriftBurns(NamedTuple):
    """Burns of a drift leg in time order: times (burns,) [s], inertial vectors (burns, 3) [m/s]."""

    times: FloatArray
    vectors: FloatArray

    @property
    def delta_v(self) -> float:
        """Sum of the burns [m/s]."""
        return float(np.linalg.norm(self.vectors, axis=1).sum())


def phases(rule: TransferRule) -> tuple[str, ...]:
    """Phases begun by the burns of a drift leg; the second terminal burn ends its own."""
    begun = (HOHMANN_1, DRIFT, CO_ELLIPTIC, TERMINAL, TERMINAL)
    return tuple(PHASES[phase] for phase in (*begun, *[APPROACH] * len(rule.approach)))


def flown(
    orbit_i: FloatArray, orbit_j: FloatArray, rule: TransferRule, departure: float, arrival: float
) -> DriftBurns:
    """The burns of a drift leg.

    Parameters
    ----------
    orbit_i, orbit_j : (columns,) float64
        Rows of :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`.
    rule : TransferRule
    departure, arrival : float
        Of the connection [s].

    Raises
    ------
    InputError
        The phase is not met in any way that was tried.
    """
    # Within the altitudes that zones were judged for, if there are burns that stay there.
    for keeps_altitudes in (True, False) if rule.zones.size else (False,):
        for freedom in FREEDOM_S:
            if 2.0 * freedom > arrival - departure and freedom > FREEDOM_S[0]:
                break
            way = Drifting(
                orbit_i, orbit_j, rule, departure, arrival, freedom, keeps_altitudes=keeps_altitudes
            )
            found = way.flight()
            if found is not None:
                return found
    raise InputError(
        f"no burns were found that drift from {departure:.0f} s to {arrival:.0f} s and meet the "
        "target; raise drift_step_s"
    )


def shape_m_s(
    orbit_i: FloatArray, orbit_j: FloatArray, rule: TransferRule, departure: float, arrival: float
) -> float:
    """ΔV that the eccentricity vectors add to a drift leg [m/s]."""
    pair = drift_pair.prepare(orbit_i, orbit_j, rule, ephemeris.EPOCH_S)
    return float(drift.shape_share(pair, departure, arrival))


class CrossingPair(NamedTuple):
    """A pair of crossings for departure and arrival, with the split of the closed form.

    Attributes
    ----------
    start, met : float
        First burn, and arrival at the stand-off [s].
    parity, other : int
        Whether the chaser, and the target, cross the line of nodes upwards (0) or downwards (1).
    split : Split
    """

    start: float
    met: float
    parity: int
    other: int
    split: Split


class Drifting:
    """The drift leg of a pair between two times.

    Parameters
    ----------
    orbit_i, orbit_j : (columns,) float64
        Rows of :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`.
    rule : TransferRule
    departure, arrival : float
        Of the connection: first and last moment of the transfer, approach included [s].
    freedom : float
        Largest delay of the departure, and advance of the arrival [s].
    keeps_altitudes : bool
        Whether the drift orbit stays within the altitudes that zones were judged for.
    """

    def __init__(
        self,
        orbit_i: FloatArray,
        orbit_j: FloatArray,
        rule: TransferRule,
        departure: float,
        arrival: float,
        freedom: float,
        *,
        keeps_altitudes: bool = False,
    ) -> None:
        self._i, self._j, self._rule = orbit_i, orbit_j, rule
        self._departure, self._arrival, self._freedom = departure, arrival, freedom
        self._keeps_altitudes = keeps_altitudes
        self._arcs = Arcs(rule.oblateness)
        # Burns lead from circle to circle; what eccentricity adds is stated beside them.
        circles = (with_orbit(orbit, eccentricity=0.0) for orbit in (orbit_i, orbit_j))
        self._pair = drift_pair.prepare(*circles, rule, ephemeris.EPOCH_S)
        self._ri = float(ephemeris.radius_at(orbit_i, departure))
        self._rj = float(ephemeris.radius_at(orbit_j, arrival))
        self._inclination_i = float(ephemeris.inclination_at(orbit_i, departure))
        self._inclination_j = float(ephemeris.inclination_at(orbit_j, arrival))
        self._rate_j = float(ephemeris.latitude_rate_at(orbit_j, ephemeris.EPOCH_S))
        self._approach = rule.approach_revolutions * TURN_RAD / self._rate_j
        self._planned = self._radius(drift.best_split(self._pair, departure, arrival).climb)

    def flight(self) -> DriftBurns | None:
        """The cheapest burns found; None if no attempt meets the phase."""
        best: DriftBurns | None = None
        for number, way in enumerate(self._ways()):
            if best is not None and number % TRIED == 0:
                break
            found = self._flown(way)
            if found is not None and (best is None or found.delta_v < best.delta_v):
                best = found
        return best

    def _ways(self) -> list[CrossingPair]:
        """Pairs of crossings for departure and arrival, cheapest in closed form first."""
        planned = drift.best_split(self._pair, self._departure, self._arrival)
        if not math.isfinite(planned.delta_v):
            return []
        drifting, first = self._leaving(planned)
        stand_off = self._arrival - self._approach
        last = self._closing(drifting, self._radius(planned.climb), self._departure, stand_off)
        starts = self._departures(first, self._departure, self._freedom)
        mets = self._arrivals(last)
        found = drift.splits(
            self._pair,
            np.array([start for start, _ in starts]),
            np.array([met + self._approach for met, _ in mets]),
        )
        ways = [
            CrossingPair(start, met, parity, other, Split(*(float(value) for value in found[s, m])))
            for s, (start, parity) in enumerate(starts)
            for m, (met, other) in enumerate(mets)
            if math.isfinite(found[s, m, 0]) and self._allowed(self._radius(found[s, m, 1]))
        ]
        ways.sort(key=lambda way: way.split.delta_v)
        return ways

    def _allowed(self, radius: float) -> bool:
        """Whether a radius is allowed for the drift orbit: with zones, only one already checked."""
        if self._keeps_altitudes:
            margin = drift_pair.margin(self._planned - self._ri)
            if abs(radius - self._planned) > margin:
                return False
        return bool(self._rule.min_radius <= radius <= self._rule.max_radius)

    def _radius(self, climb: float) -> float:
        """Radius of the drift orbit reached by a change b_y [m]."""
        return float(drift_pair.radius_of(self._pair, climb))

    def _leaving(self, split: Split) -> tuple[Plane, Turn]:
        """Plane of the drift orbit, its node relative to the origin's, and the way there."""
        linear = self._pair.linear
        inclination = self._inclination_i
        shift = split.along / (linear.speed * linear.sine) if linear.sine > 0.0 else 0.0
        plane = Plane(inclination + split.tilt / linear.speed, shift)
        return plane, turn_between(Plane(inclination, 0.0), plane)

    def _closing(self, drifting: Plane, radius: float, start: float, stand_off: float) -> Turn:
        """Approximate turn out of the drift orbit, whose remaining arcs are short."""
        gone = self._arcs.node_rate(radius, drifting.inclination) * (stand_off - start)
        return turn_between(
            Plane(drifting.inclination, self._node(self._i, start) + drifting.raan + gone),
            Plane(self._inclination_j, self._node(self._j, stand_off)),
        )

    def _half_turns(self, way: CrossingPair, drifting: Plane, begun: float, last: Turn) -> int:
        """Half turns between the lines of nodes where the drift begins and ends."""
        radius, span = self._radius(way.split.climb), way.met + self._approach - way.start
        coasting = float(drift_arcs.coast(self._pair, span, radius).drift)
        gained = self._arcs.latitude_rate(radius, drifting.inclination) * coasting
        pairs = 0.5 * ((begun + gained - last.before) / math.pi - way.other)
        return 2 * round(pairs) + way.other

    @staticmethod
    def _node(orbit: FloatArray, time: float) -> float:
        return float(ephemeris.node_at(orbit, time))

    @staticmethod
    def _crossing(orbit: FloatArray, latitude: float, near: float) -> float:
        """Time at which a body is at an argument of latitude, nearest to a given time [s]."""
        acceleration = float(ephemeris.latitude_acceleration_at(orbit, near))
        about = ephemeris.EPOCH_S if acceleration == 0.0 else near
        then, rate = ephemeris.latitude_tangent(orbit, about)
        behind = latitude - then - rate * near
        behind -= TURN_RAD * round(behind / TURN_RAD)
        return float(near + co_elliptic.time_at(0.0, rate, acceleration, behind))

    def _departures(self, first: Turn, begin: float, freedom: float) -> list[tuple[float, int]]:
        """The chaser's crossings of the line of nodes in a time span, with parity."""
        period = float(ephemeris.revolution_at(self._i, begin))
        found = []
        for parity in (0, 1):
            time = self._crossing(self._i, first.before + math.pi * parity, begin)
            time += period * math.ceil((begin - time) / period)
            while time <= begin + freedom:
                found.append((time, parity))
                time += period
        return found

    def _arrivals(self, last: Turn) -> list[tuple[float, int]]:
        """Stand-off times allowed by the target's crossings of the line, with parity."""
        lead = self._rule.standoff / self._rj
        end = self._arrival - self._approach
        found = []
        for parity in (0, 1):
            time = self._crossing(self._j, last.after + math.pi * parity + lead, end)
            time -= TURN_RAD / self._rate_j * math.ceil((time - end) * self._rate_j / TURN_RAD)
            while time >= end - self._freedom:
                found.append((time, parity))
                time -= TURN_RAD / self._rate_j
        return found

    def _flown(self, way: CrossingPair) -> DriftBurns | None:
        """Burns that leave near a time, drift for whole half turns and meet the target."""
        arcs, rule, rj = self._arcs, self._rule, self._rj
        ri, inclination_j = self._ri, self._inclination_j
        lead = rule.standoff / rj
        radius, met, parity = self._radius(way.split.climb), way.met, way.parity
        drifting, first = self._leaving(way.split)
        start = self._crossing(self._i, first.before + math.pi * parity, way.start)
        begun = first.after + math.pi * (1 + parity)
        last = self._closing(drifting, radius, start, met)
        half_turns = self._half_turns(way, drifting, begun, last)
        where, missed, slope = radius, 0.0, 1.0
        half_1 = half_2 = Plane(inclination_j, 0.0)
        for step in range(MOST_STEPS):
            rc = radius + rule.first_leg_fraction * (rj - radius)
            out, out_shift = arcs.half(ri, radius, first.middle.inclination)
            turned_by = _turned_by(radius, rc, rj)
            drift_rate = arcs.node_rate(radius, drifting.inclination)
            for _ in range(MOST_STEPS):
                back, back_shift = arcs.half(radius, rc, half_1.inclination)
                end, end_shift = arcs.half(rc, rj, half_2.inclination)
                left = met - end - back
                if left <= start + out:
                    return None
                gone = drift_rate * (left - start - out)
                at_left = drifting.carried(self._node(self._i, start) + out_shift + gone)
                there = Plane(inclination_j, self._node(self._j, met) - end_shift - back_shift)
                before, last = last.before, turn_between(at_left, there)
                # The line of nodes does not jump by a turn between two steps.
                last = last._replace(before=before + math.remainder(last.before - before, TURN_RAD))
                half_1, half_2 = (between(at_left, there, last.angle, by) for by in turned_by)
                new = self._crossing(self._j, last.after + math.pi * half_turns + lead, met)
                moved, met = abs(new - met), new
                if moved < CLOSE_M / self._pair.linear.speed:
                    break
            rate = (last.before + math.pi * half_turns - begun) / (left - start - out)
            if rate <= 0.0:
                return None
            miss = arcs.radius_of(rate, drifting.inclination) - radius
            if abs(miss) < CLOSE_M:
                break
            # The secant: where nodes drift far, the line moves with the radius as the phase does.
            if step > 0 and radius != where:
                slope = (missed - miss) / (radius - where)
            where, missed = radius, miss
            radius += min(max(miss / slope if slope else miss, -FARTHEST_M), FARTHEST_M)
            if not self._allowed(radius):
                return None
        else:
            return None
        if start < self._departure or met + self._approach > self._arrival:
            return None
        home = Plane(self._inclination_i, self._node(self._i, start))
        return self._burns(
            (ri, radius, rc, rj),
            (start, start + out, left, left + back, met),
            (
                home,
                first.middle.carried(home.raan),
                drifting.carried(home.raan),
                at_left,
                half_1,
                half_2,
                there,
            ),
            (first.before + math.pi * parity, last.before + math.pi * half_turns),
            (out_shift, back_shift, end_shift),
        )

    def _burns(
        self,
        radii: tuple[float, float, float, float],
        times: tuple[float, float, float, float, float],
        planes: tuple[Plane, Plane, Plane, Plane, Plane, Plane, Plane],
        latitudes: tuple[float, float],
        shifts: tuple[float, float, float],
    ) -> DriftBurns:
        """Burns as vectors.

        Parameters
        ----------
        radii : (4,)
            Of the origin, the drift orbit, the co-elliptic orbit and the destination [m].
        times : (5,)
            Of the first five burns [s].
        planes : (7,)
            The origin's, the first half ellipse's and the drift orbit's as they are at departure;
            the drift orbit's, those of the half ellipses after it and the destination's as if the
            nodes stood still from the third burn on.
        latitudes : (2,)
            Arguments of latitude of the first burn and of the third, in the planes that they leave
            [rad].
        shifts : (3,)
            Of the nodes on the half ellipses [rad].
        """
        ri, r, rc, rj = radii
        home, out, drifting, at_left, back, end, there = planes
        v1, v1_end = half_ellipse_speeds(ri, r)
        v2, v2_end = half_ellipse_speeds(r, rc)
        v3, v3_end = half_ellipse_speeds(rc, rj)
        circle, speed = math.sqrt(MU_M3_S2 / r), math.sqrt(MU_M3_S2 / rj)
        line = outward(home, latitudes[0])
        second = -turned(line, shifts[0])
        third = outward(at_left, latitudes[1])
        fourth = -turned(third, shifts[1])
        fifth = -turned(fourth, shifts[2])
        moved = shifts[1], shifts[1] + shifts[2]
        period = TURN_RAD / self._rate_j
        last_times, last = approach_burns(self._j, self._rule, times[-1], period)
        vectors = [
            v1 * ahead(out, line) - math.sqrt(MU_M3_S2 / ri) * ahead(home, line),
            circle * ahead(drifting.carried(shifts[0]), second)
            - v1_end * ahead(out.carried(shifts[0]), second),
            v2 * ahead(back, third) - circle * ahead(at_left, third),
            v3 * ahead(end.carried(moved[0]), fourth)
            - v2_end * ahead(back.carried(moved[0]), fourth),
            speed * ahead(there.carried(moved[1]), fifth)
            - v3_end * ahead(end.carried(moved[1]), fifth),
        ]
        return DriftBurns(np.array([*times, *last_times]), np.vstack([vectors, last]))


def _turned_by(radius: float, co_elliptic: float, target: float) -> tuple[float, float]:
    """Shares of the turn out of the drift orbit made after its first and second burn.

    In proportion to what the three burns change of the speed, which makes their sum least.
    """
    v2, v2_end = half_ellipse_speeds(radius, co_elliptic)
    v3, v3_end = half_ellipse_speeds(co_elliptic, target)
    sizes = (
        abs(v2 - math.sqrt(MU_M3_S2 / radius)),
        abs(v3 - v2_end),
        abs(math.sqrt(MU_M3_S2 / target) - v3_end),
    )
    whole = sum(sizes)
    if whole < LEAST_CLIMB_M_S:
        return 0.5, 1.0
    return sizes[0] / whole, (sizes[0] + sizes[1]) / whole
