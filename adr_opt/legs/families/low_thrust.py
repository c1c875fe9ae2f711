"""Legs of low thrust: thrust, drift, thrust, by class of mass (docs/model.md section 11)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from ...common.constants import DAY_S, SLACK_M_S, TURN_RAD
from ...common.errors import InputError
from ...common.records import LARGEST_DURATION_S
from ...kernels.legs import low_thrust, low_thrust_windows
from ...kernels.legs.drift_grid import LongTransfers
from ...kernels.legs.drift_pair import DriftPair
from ...kernels.legs.found import ConnectionArrays
from ...kernels.legs.low_thrust import LowThrustLeg
from ...kernels.legs.low_thrust_arcs import Thrust
from ...kernels.orbits.ephemeris import EPOCH_S
from ...plan.leg_kinds import LOW_THRUST
from ...problem.drives import Drive, drive_of, since_j2000_s
from ...problem.instance import Instance
from ..connections import Connections
from .ends import AllEnds
from .family import FloatArray, FlownLeg, LegFamily, PairEnds, StatedLeg, ThrustArc
from .merging import merged, of_family

FINER = 0.2
"""Resolution of lower bounds as a share of that of costs."""


class LowThrustLegs(LegFamily):
    """Legs of chasers with low thrust, between times of a grid."""

    kind = LOW_THRUST

    def applies(self, instance: Instance) -> bool:
        return any(chaser.thrust_n is not None for chaser in instance.chasers)

    def serves(self, drive: Drive | None) -> bool:
        return drive is not None

    def connections(
        self, ends: PairEnds, found: ConnectionArrays | None, resolution_m_s: float
    ) -> ConnectionArrays:
        assert ends.drive is not None
        assert ends.times is not None
        drive, step = ends.drive, ends.times.step
        since = since_j2000_s(ends.instance.epoch)
        pair = low_thrust_windows.prepare(ends.leaving, ends.arriving, ends.rule, since, EPOCH_S)
        pushed = drive.largest_acceleration if ends.relaxed else drive.least_acceleration
        thrust = Thrust(pushed, drive.exhaust_m_s)
        if ends.relaxed:
            resolution_m_s *= FINER
        legs = low_thrust.of_pair(
            pair,
            thrust,
            ends.times,
            ends.latest_s,
            resolution_m_s,
            ends.relaxed,
            low_thrust.NONE_KNOWN,
        )
        delta_v = legs.delta_v
        if ends.relaxed:  # also of the legs that are left out, as they save no more than that
            delta_v = np.maximum(delta_v - resolution_m_s, 0.0)
        made = self._arrays(legs, step, delta_v)
        return merged(found, made, ends.latest_s, 0.0 if ends.relaxed else resolution_m_s)

    def of_class(
        self, ends: PairEnds, heavier: ConnectionArrays, resolution_m_s: float
    ) -> ConnectionArrays:
        assert ends.drive is not None
        assert ends.times is not None
        since, step = since_j2000_s(ends.instance.epoch), ends.times.step
        pair = low_thrust_windows.prepare(ends.leaving, ends.arriving, ends.rule, since, EPOCH_S)
        drive = ends.drive
        thrust = Thrust(drive.least_acceleration, drive.exhaust_m_s)
        holds = drive.exhaust_m_s * math.log(drive.heaviest_kg / drive.lightest_kg) + SLACK_M_S
        times = ends.times._replace(most=min(ends.times.most, holds))
        known = heavier.departure / step, heavier.arrival / step
        leaves, lands = (np.rint(each).astype(np.int32) for each in known)
        legs = low_thrust.of_pair(
            pair,
            thrust,
            times,
            ends.latest_s,
            resolution_m_s,
            False,
            (leaves, lands, heavier.delta_v),
        )
        return self._arrays(legs, step, legs.delta_v)

    def _arrays(self, legs: LongTransfers, step: float, delta_v: FloatArray) -> ConnectionArrays:
        """Legs on the grid as connections."""
        return of_family(
            self.number,
            legs.departure * step,
            legs.arrival * step,
            delta_v,
            np.full(legs.departure.size, -1, dtype=np.int8),
        )

    def flown(self, ends: PairEnds, stated: StatedLeg) -> FlownLeg:
        return self._flown(ends, stated, None)

    def flown_at(self, ends: PairEnds, stated: StatedLeg, delta_v_m_s: float) -> FlownLeg:
        return self._flown(ends, stated, delta_v_m_s)

    def _flown(self, ends: PairEnds, stated: StatedLeg, delta_v_m_s: float | None) -> FlownLeg:
        assert ends.drive is not None
        if ends.relaxed:  # no leg has to be as cheap
            return FlownLeg(stated.departure)
        since = since_j2000_s(ends.instance.epoch)
        pair = low_thrust_windows.prepare(ends.leaving, ends.arriving, ends.rule, since, EPOCH_S)
        thrust = Thrust(ends.drive.least_acceleration, ends.drive.exhaust_m_s)
        times = stated.departure, stated.arrival
        if delta_v_m_s is None:
            leg = low_thrust.leg_between(pair, thrust, *times)
        else:
            leg = low_thrust.leg_stated(pair, thrust, *times, delta_v_m_s)
        if not math.isfinite(leg.split.delta_v):
            raise InputError("no low-thrust leg exists between these times")
        return FlownLeg(stated.departure, arcs=_arcs(pair.drift, leg, stated))


def _arcs(drift: DriftPair, leg: LowThrustLeg, stated: StatedLeg) -> tuple[ThrustArc, ThrustArc]:
    """Both arcs of a leg."""
    split, turn, linear = leg.split, leg.turn, drift.linear
    rest, left = drift.climb - split.climb, turn * linear.tilt - split.tilt
    one, other = math.hypot(split.climb, split.tilt), math.hypot(rest, left)
    share = one / (one + other) if one + other > 0.0 else 0.5
    met = stated.arrival - drift.approach
    times = (
        (stated.departure, stated.departure + split.times.first),
        (met - split.times.second, met),
    )
    made = []
    for (start, end), delta_v, climb, tilt, along in (
        (times[0], split.first, split.climb, split.tilt, share * split.node),
        (times[1], split.delta_v - split.first, rest, left, split.node - share * split.node),
    ):
        place = math.atan2(along, tilt) % TURN_RAD
        by_node = turn * linear.speed * linear.sine
        made.append(
            ThrustArc(
                start,
                end,
                delta_v,
                leg.window,
                place,
                climb,
                tilt / (turn * linear.speed),
                along / by_node if by_node > 0.0 else 0.0,
            )
        )
    return made[0], made[1]


def of_mass(ends: PairEnds, mass_kg: float | None) -> PairEnds:
    """The ends of a pair for chasers of a class with a largest mass [kg]; None for the heaviest."""
    if ends.drive is None or mass_kg is None:
        return ends
    return ends._replace(drive=ends.drive._replace(heaviest_kg=mass_kg))


def lighter(
    family: LegFamily,
    ends: PairEnds,
    heaviest: ConnectionArrays,
    classes_kg: Sequence[float],
    resolution_m_s: float,
) -> Iterator[tuple[float, ConnectionArrays]]:
    """The connections of a pair by class of mass, without those that heavier classes dominate.

    Parameters
    ----------
    family : LegFamily
        That knows of masses.
    ends : PairEnds
    heaviest : ConnectionArrays
        Those of the heaviest class.
    classes_kg : sequence of float
        Largest mass of each lighter class, the heaviest first [kg].
    resolution_m_s : float
        A connection that saves no more than this is dominated [m/s].
    """
    known = ConnectionArrays(*(column[heaviest.family == family.number] for column in heaviest))
    for mass_kg in classes_kg:
        found = family.of_class(of_mass(ends, mass_kg), known, resolution_m_s)
        yield mass_kg, found
        known = _joined((known, found))


def by_departure(classes: Iterable[tuple[float, ConnectionArrays]]) -> Connections:
    """Connections of several classes together, from their largest masses [kg], +inf for any."""
    masses_kg, parts = zip(*classes, strict=True)
    mass_kg = np.repeat(masses_kg, [part.departure.size for part in parts])
    found = ConnectionArrays(*map(np.concatenate, zip(*parts, strict=True)))
    order = np.lexsort((found.arrival, found.departure))
    found = ConnectionArrays(*(column[order] for column in found))
    return Connections(
        found.departure,
        found.arrival,
        found.delta_v,
        found.revolutions,
        found.family,
        mass_kg[order],
    )


def _joined(parts: tuple[ConnectionArrays, ConnectionArrays]) -> ConnectionArrays:
    """Connections in order of departure."""
    found = ConnectionArrays(*map(np.concatenate, zip(*parts, strict=True)))
    order = np.argsort(found.departure, kind="stable")
    return ConnectionArrays(*(column[order] for column in found))


LONGER = 1.1
"""Ratio of the durations that are tried."""


def too_weak(instance: Instance) -> str | None:
    """A sentence if no first leg of a chaser ends within the mission; else None.

    Parameters
    ----------
    instance : Instance
        All of whose chasers have low thrust; of any other nothing is said.
    """
    soonest, quickest, between = math.inf, math.inf, ("", "")
    first, names = instance.first_target, instance.names
    for number, chaser in enumerate(instance.chasers):
        drive = drive_of(chaser, instance.targets)
        if drive is None or chaser.is_launched:
            return None
        ends, start = AllEnds(instance, drive), instance.starts[number]
        thrust = Thrust(drive.least_acceleration, drive.exhaust_m_s)
        since = since_j2000_s(instance.epoch)
        begin = instance.available_s[number][0]
        for j in range(first, len(names)):
            pair = low_thrust_windows.prepare(
                ends.of(start, j).leaving, ends.arriving[j], ends.rule, since, EPOCH_S
            )
            span = instance.transfer.drift_step_s
            while span < min(quickest, LARGEST_DURATION_S):
                cost = low_thrust.delta_v(pair, thrust, begin, begin + span)
                if cost <= chaser.usable.delta_v_m_s:
                    quickest, between = span, (names[start], names[j])
                    soonest = min(soonest, begin + span)
                    break
                span *= LONGER
    if soonest <= instance.mission.duration_s or math.isinf(quickest):
        return None
    return (
        f"the thrust is too low for any leg in the mission of {instance.mission.duration_s:g} s: "
        f"the quickest, from {between[0]!r} to {between[1]!r}, takes some {quickest / DAY_S:.0f} d"
    )
