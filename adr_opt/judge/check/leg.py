"""Check that a leg can be flown as stated: departure, phasing, ΔV, burns.

Registered families recompute their legs.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import SLACK_S
from ...common.errors import InputError
from ...kernels.legs import burns as burn_kernels
from ...kernels.legs import co_elliptic, precession, zones
from ...kernels.orbits import ephemeris
from ...kernels.orbits.body_rows import as_left
from ...legs.families.ends import AllEnds
from ...legs.families.family import StatedLeg
from ...legs.families.registry import registered_of
from ...plan.leg_kinds import DRIFT, GIVEN, LAUNCH, LOW_THRUST, SHORT
from ...plan.plan import Leg
from ...problem.chasers import Chaser
from ...problem.drives import Drive, drive_of
from ...problem.given import Given
from ...problem.instance import Instance
from .drift import check_drift
from .eccentric import StatedSequence, short_cost
from .figures import check_burns, check_costs
from .given import check_given
from .low_thrust import check_low_thrust
from .towed import Towed, towed_bodies
from .violation import DELTA_V_TOLERANCE_M_S, TIME_TOLERANCE_S, Violation
from .zone_crossings import crossed


def check_registered(
    instance: Instance, number: int, leg: Leg, ends: tuple[int, int], free: float
) -> Generator[Violation, None, tuple[float, float]]:
    """Check that a leg belongs to its family and leaves no earlier than the chaser is free.

    Returns when the chaser arrives and the ΔV, to go on from: recomputed, but as stated where the
    plan is wrong about them.
    """
    as_stated = leg.arrival_s, leg.delta_v_m_s
    families = {family.kind.name: family for family in registered_of(instance)}
    family = families.get(leg.kind)
    if family is None:
        yield Violation(number, "kind", f"is {leg.kind!r}, not a kind of leg of the instance")
        return as_stated
    if leg.departure_s < free - SLACK_S:
        yield Violation(number, "departure", "leaves before the chaser is ready")
        return as_stated
    stated = StatedLeg(leg.departure_s, leg.arrival_s, leg.phasing_revolutions)
    try:
        found = family.recomputed(AllEnds(instance).of(*ends), stated)
    except InputError as error:
        yield Violation(number, "kind", str(error))
        return as_stated
    for name, told, true in (
        ("departure", leg.departure_s, found.departure),
        ("arrival", leg.arrival_s, found.arrival),
    ):
        if abs(told - true) > TIME_TOLERANCE_S:
            yield Violation(number, name, f"{name}_s = {told!r}, but the nearest is {true!r}")
            return as_stated
    yield from check_costs(found.delta_v, found.eccentricity_m_s, number, leg)
    yield from check_burns(number, leg, *found.manoeuvres)
    return found.arrival, found.delta_v


class Physics(NamedTuple):
    """Data that determine the transfers of an instance, computed once for all legs.

    Attributes
    ----------
    elements : (bodies, columns) float64
        Of bodies as they are arrived at.
    left : (bodies, columns + 1) float64
        Of bodies as they are left, and the rate of the node after that, see :mod:`.tow` [rad/s];
        where a tow begins at an apogee, ask :meth:`leaving`.
    rule : TransferRule
    given : Given or None
    towed : dict of str to Towed
        The targets that are towed, by name.
    pieced : dict of int to Towed
        Those whose tow begins at an apogee, by number of the body.
    """

    elements: npt.NDArray[np.float64]
    left: npt.NDArray[np.float64]
    rule: co_elliptic.TransferRule
    given: Given | None
    towed: dict[str, Towed]
    pieced: dict[int, Towed]

    def leaving(self, i: int, time_s: float) -> npt.NDArray[np.float64]:
        """Row of a body as a chaser leaves it at a time, shape (columns + 1,)."""
        row: npt.NDArray[np.float64] = self.left[i]
        return self.pieced[i].left_at(time_s) if i in self.pieced else row

    @classmethod
    def of(cls, instance: Instance, drive: Drive | None) -> Physics:
        """The data of an instance, for chasers with a drive or with impulses."""
        elements = instance.orbits()
        left = as_left(elements)
        towed, pieced = towed_bodies(instance, elements, drive), dict[int, Towed]()
        for body, name in enumerate(instance.names):
            if name in towed:
                left[body] = towed[name].left
                if towed[name].period_s:
                    pieced[body] = towed[name]
        return cls(elements, left, instance.transfer_rule(), instance.given, towed, pieced)


def check_transfer(
    instance: Instance,
    physics: Physics,
    chaser: Chaser,
    number: int,
    leg: Leg,
    ends: tuple[int, int],
    free: float,
) -> Generator[Violation, None, tuple[float, float]]:
    """Check that a leg departs at a crossing of the line of nodes with a flyable sequence.

    Returns when the chaser arrives and the ΔV, to go on from: recomputed, but as stated where the
    plan is wrong about them, so that one mistake is reported once.
    """
    i, j = ends
    if leg.kind == LAUNCH.name or i in instance.launches:
        return (yield from _check_launch(number, leg, i in instance.launches, free))
    if physics.given is not None:
        return (yield from check_given(physics.given, number, leg, free))
    if leg.kind == GIVEN.name:
        yield Violation(number, "given", "is given, but the instance has connections of the model")
        return leg.arrival_s, leg.delta_v_m_s
    between = physics.leaving(i, leg.departure_s), physics.elements[j]
    drive = drive_of(chaser, instance.targets)
    if leg.kind == LOW_THRUST.name:
        return (
            yield from check_low_thrust(instance, between, physics.rule, drive, number, leg, free)
        )
    if drive is not None and leg.kind in (SHORT.name, DRIFT.name):
        yield Violation(number, "kind", f"is {leg.kind!r}, but the thrust of its chaser is low")
        return leg.arrival_s, leg.delta_v_m_s
    if leg.kind == DRIFT.name:
        return (yield from check_drift(instance, between, physics.rule, number, leg, free))
    if leg.kind != SHORT.name:
        return (yield from check_registered(instance, number, leg, ends, free))
    origin, destination, rule = *between, physics.rule
    pair = co_elliptic.prepare(origin, destination, 0.0, rule, ephemeris.EPOCH_S)
    if instance.dynamics == "j2":
        sequence = yield from _check_drifting_planes(
            pair, rule, (origin, destination), number, leg, free
        )
    else:
        sequence = yield from _check_sequence(pair, rule, number, leg, free)
    if sequence is None:
        return leg.arrival_s, leg.delta_v_m_s
    turn = 4.0 * math.sin(0.5 * sequence.theta) ** 2
    circles = float(
        co_elliptic.turned_delta_v(pair, rule, sequence.laps, sequence.radius, turn, 0.0)
    )
    delta_v = short_cost((origin, destination), rule, leg.departure_s, sequence, circles)
    yield from _check_figures(sequence, delta_v, delta_v - circles, number, leg)
    if zones.is_blocked(pair, rule, sequence.laps, sequence.radius, sequence.departure) and not any(
        True for _ in crossed(instance, leg)
    ):
        yield Violation(
            number,
            "zone",
            "touches the edge of a keep-out zone while the zone is closed; edges belong to zones",
        )
    times, vectors, phases = burn_kernels.burns(
        origin, destination, pair, rule, sequence.departure, sequence.laps, sequence.radius
    )
    names = [burn_kernels.PHASES[phase] for phase in phases]
    yield from check_burns(number, leg, times, vectors, names)
    arrives_as_stated = abs(leg.arrival_s - sequence.arrival) <= TIME_TOLERANCE_S
    costs_as_stated = abs(leg.delta_v_m_s - delta_v) <= DELTA_V_TOLERANCE_M_S
    return (
        sequence.arrival if arrives_as_stated else leg.arrival_s,
        delta_v if costs_as_stated else leg.delta_v_m_s,
    )


def _check_launch(
    number: int, leg: Leg, is_first: bool, free: float
) -> Generator[Violation, None, tuple[float, float]]:
    """Check a chaser without a start orbit: its first leg, and no other leg, is a launch."""
    if not is_first:
        yield Violation(number, "launch", f"launched at {leg.origin!r}, where no launch starts")
    elif leg.kind != LAUNCH.name:
        yield Violation(
            number, "launch", f"is {leg.kind!r}, but {leg.origin!r} is not in orbit yet"
        )
    if leg.departure_s < free - SLACK_S:
        yield Violation(number, "departure", "leaves before the chaser is ready")
    for name, stated, true in (
        ("arrival_s", leg.arrival_s, leg.departure_s),
        ("delta_v_m_s", leg.delta_v_m_s, 0.0),
        ("burns", len(leg.burns), 0),
        ("phasing_revolutions", leg.phasing_revolutions, 0),
        ("eccentricity_delta_v_m_s", leg.eccentricity_delta_v_m_s, 0.0),
    ):
        if stated != true:
            yield Violation(number, "launch", f"{name}: {stated!r}, but a launch has {true!r}")
    return leg.departure_s, 0.0


def _check_sequence(
    pair: co_elliptic.Pair, rule: co_elliptic.TransferRule, number: int, leg: Leg, free: float
) -> Generator[Violation, None, StatedSequence | None]:
    """Check departure and phasing; returns the sequence, or None if they are infeasible."""
    # Angle of the chaser past the line of nodes, in half turns: whole at a departure event.
    past = (pair.phase_i + pair.rate_i * leg.departure_s) / math.pi
    half_turns = round(past)
    departure = leg.departure_s + (half_turns - past) * math.pi / pair.rate_i
    if abs(departure - leg.departure_s) > TIME_TOLERANCE_S:
        yield Violation(
            number,
            "departure",
            f"departure_s = {leg.departure_s!r} is not a crossing of the line of nodes; "
            f"the nearest is at {departure!r}",
        )
        return None
    if departure < free - SLACK_S:
        yield Violation(number, "departure", "leaves before the chaser is ready")
        return None
    laps = leg.phasing_revolutions
    if not 0 <= laps <= rule.max_phasing_revolutions:
        yield Violation(
            number,
            "phasing",
            f"phasing_revolutions = {laps}, which is not from 0 to {rule.max_phasing_revolutions}",
        )
        return None
    # The target's lead decides when the chaser may arrive: whole turns of it apart.
    lead = math.fmod(pair.phase_j + pair.rate_j * departure - math.pi * half_turns, 2.0 * math.pi)
    lap = 2.0 * math.pi / pair.rate_j
    approach = rule.approach_revolutions * lap
    met = (
        departure + (3.0 * math.pi - lead + rule.standoff / pair.radius_j) / pair.rate_j + approach
    )
    arrival = float(met + round((leg.arrival_s - met) / lap) * lap)
    flight = arrival - approach - departure
    low = pair.shortest + laps * pair.shortest_lap
    high = pair.longest + laps * pair.longest_lap
    if not low <= flight <= high:
        yield Violation(
            number,
            "phasing",
            f"with {laps} phasing revolutions between the altitude limits it cannot arrive at "
            f"{arrival!r}: the flight would take {flight!r} s, and may take {low!r} to {high!r} s",
        )
        return None
    radius = co_elliptic.phasing_radius(pair, rule, laps, flight)
    return StatedSequence(departure, arrival, laps, radius, pair.theta)


def _check_drifting_planes(
    pair: co_elliptic.Pair,
    rule: co_elliptic.TransferRule,
    bodies: tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]],
    number: int,
    leg: Leg,
    free: float,
) -> Generator[Violation, None, StatedSequence | None]:
    """Check a leg between drifting planes: its turn is at the line of nodes of its departure."""
    laps, departure = leg.phasing_revolutions, leg.departure_s
    stand_off = leg.arrival_s - rule.approach_revolutions * 2.0 * math.pi / pair.rate_j
    flight = stand_off - departure
    low = pair.shortest + laps * pair.shortest_lap
    high = pair.longest + laps * pair.longest_lap
    if not 0 <= laps <= rule.max_phasing_revolutions or not low <= flight <= high:
        yield Violation(
            number,
            "phasing",
            f"with {laps} phasing revolutions of at most {rule.max_phasing_revolutions}, between "
            f"the altitude limits, a flight takes {low!r} to {high!r} s, and not {flight!r}",
        )
        return None
    if departure < free - SLACK_S:
        yield Violation(number, "departure", "leaves before the chaser is ready")
        return None
    radius = co_elliptic.phasing_radius(pair, rule, laps, flight)
    apart = pair.lag + pair.lag_rate * departure
    apart += precession.carried(pair, rule, laps, radius, flight)
    alpha_i, alpha_j, theta = ephemeris.relative_node(
        pair.inclination_i, 0.0, pair.inclination_j, apart
    )
    # A decaying orbit turns at another rate at each time.
    past = (float(ephemeris.latitude_at(bodies[0], departure)) - alpha_i) / math.pi
    half_turns = round(past)
    rate_i = float(ephemeris.latitude_rate_at(bodies[0], departure))
    crossing = departure + (half_turns - past) * math.pi / rate_i
    if abs(crossing - departure) > TIME_TOLERANCE_S:
        yield Violation(
            number,
            "departure",
            f"departure_s = {departure!r} is not a crossing of the line of nodes; the nearest is "
            f"at {crossing!r}",
        )
        return None
    behind = alpha_j + math.pi * (half_turns + 1) + rule.standoff / pair.radius_j
    behind -= float(ephemeris.latitude_at(bodies[1], stand_off))
    rate_j = float(ephemeris.latitude_rate_at(bodies[1], stand_off))
    late = math.remainder(behind, 2.0 * math.pi) / rate_j
    return StatedSequence(departure, leg.arrival_s + late, laps, radius, theta)


def _check_figures(
    sequence: StatedSequence, delta_v: float, extra: float, number: int, leg: Leg
) -> Iterator[Violation]:
    """Check arrival and ΔV against the sequence."""
    if abs(leg.arrival_s - sequence.arrival) > TIME_TOLERANCE_S:
        yield Violation(
            number,
            "arrival",
            f"arrival_s = {leg.arrival_s!r}, but it arrives at {sequence.arrival!r}",
        )
    yield from check_costs(delta_v, extra, number, leg)
