"""Whether one leg can be flown as it is stated: departure, phasing, ΔV, burns."""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..instance import Instance
from ..keep_out import crossed
from ..kernels import burns as burn_kernels
from ..kernels import transfer
from ..kernels.constants import SLACK_S
from ..plan import Leg
from .violation import DELTA_V_TOLERANCE_M_S, TIME_TOLERANCE_S, Violation


class Physics(NamedTuple):
    """What the transfers of an instance follow from, worked out once for all legs."""

    elements: npt.NDArray[np.float64]
    extra: npt.NDArray[np.float64]
    rule: transfer.TransferRule

    @classmethod
    def of(cls, instance: Instance) -> Physics:
        """That of an instance."""
        return cls(instance.orbits(), instance.eccentricity_delta_v(), instance.transfer_rule())


class _Sequence(NamedTuple):
    """The co-elliptic sequence that a leg states, recomputed.

    Attributes
    ----------
    departure, arrival : float
        [s].
    delta_v : float
        [m/s].
    laps : int
        Phasing revolutions.
    radius : float
        Of the phasing orbit [m].
    """

    departure: float
    arrival: float
    delta_v: float
    laps: int
    radius: float


def check_transfer(
    instance: Instance, physics: Physics, number: int, leg: Leg, i: int, j: int, free: float
) -> Generator[Violation, None, tuple[float, float]]:
    """The leg departs at a crossing of the line of nodes, and its sequence can be flown from there.

    Returns when the chaser arrives and the ΔV, to go on from: recomputed, but as stated where the
    plan is wrong about them, so that one mistake is reported once.
    """
    elements, rule, extra = physics.elements, physics.rule, float(physics.extra[i, j])
    pair = transfer.prepare(elements[i], elements[j], extra, rule)
    sequence = yield from _check_sequence(pair, rule, number, leg, free)
    if sequence is None:
        return leg.arrival_s, leg.delta_v_m_s
    yield from _check_figures(sequence, extra, number, leg)
    if transfer.is_blocked(
        pair, rule, sequence.laps, sequence.radius, sequence.departure
    ) and not any(True for _ in crossed(instance, leg)):
        yield Violation(
            number,
            "zone",
            "touches the edge of a keep-out zone while that is closed; edges belong to zones",
        )
    yield from _check_burns(
        number,
        leg,
        *burn_kernels.burns(
            elements[i], elements[j], pair, rule, sequence.departure, sequence.laps, sequence.radius
        ),
    )
    arrives_as_stated = abs(leg.arrival_s - sequence.arrival) <= TIME_TOLERANCE_S
    costs_as_stated = abs(leg.delta_v_m_s - sequence.delta_v) <= DELTA_V_TOLERANCE_M_S
    return (
        sequence.arrival if arrives_as_stated else leg.arrival_s,
        sequence.delta_v if costs_as_stated else leg.delta_v_m_s,
    )


def _check_sequence(
    pair: transfer.Pair, rule: transfer.TransferRule, number: int, leg: Leg, free: float
) -> Generator[Violation, None, _Sequence | None]:
    """Departure and phasing are possible; returns the sequence, or None if they are not."""
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
    radius = transfer.phasing_radius(pair, rule, laps, flight)
    delta_v = float(transfer.sequence_delta_v(pair, rule, laps, radius))
    return _Sequence(departure, arrival, delta_v, laps, radius)


def _check_figures(sequence: _Sequence, extra: float, number: int, leg: Leg) -> Iterator[Violation]:
    """Arrival and ΔV are those of the sequence."""
    if abs(leg.arrival_s - sequence.arrival) > TIME_TOLERANCE_S:
        yield Violation(
            number,
            "arrival",
            f"arrival_s = {leg.arrival_s!r}, but it arrives at {sequence.arrival!r}",
        )
    if abs(leg.delta_v_m_s - sequence.delta_v) > DELTA_V_TOLERANCE_M_S:
        yield Violation(
            number, "cost", f"delta_v_m_s = {leg.delta_v_m_s!r}, but it costs {sequence.delta_v!r}"
        )
    if abs(leg.eccentricity_delta_v_m_s - extra) > DELTA_V_TOLERANCE_M_S:
        yield Violation(
            number,
            "eccentricity",
            f"eccentricity_delta_v_m_s = {leg.eccentricity_delta_v_m_s!r}, but it is {extra!r}",
        )


def _check_burns(
    number: int,
    leg: Leg,
    times: npt.NDArray[np.float64],
    vectors: npt.NDArray[np.float64],
    phases: npt.NDArray[np.int64],
) -> Iterator[Violation]:
    """The burns are those of the sequence: their phases, times [s] and vectors [m/s]."""
    stated_phases = [burn.phase for burn in leg.burns]
    expected_phases = [burn_kernels.PHASES[phase] for phase in phases]
    if stated_phases != expected_phases:
        yield Violation(
            number, "burns", f"phases are {stated_phases}, but should be {expected_phases}"
        )
        return
    for which, burn in enumerate(leg.burns):
        late = abs(burn.time_s - times[which])
        off = float(np.linalg.norm(np.array(burn.delta_v_m_s) - vectors[which]))
        if late > TIME_TOLERANCE_S or off > DELTA_V_TOLERANCE_M_S:
            yield Violation(
                number,
                "burns",
                f"burn {which + 1} ({burn.phase}) is off by {late:.3g} s and {off:.3g} m/s",
            )
