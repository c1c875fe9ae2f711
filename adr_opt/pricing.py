"""From a sequence of bodies to a plan: legs, burns, and a reason for every target left out."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from .errors import InputError
from .kernels import burns as burn_kernels
from .kernels.constants import SLACK_M_S
from .mission import Mission
from .plan import Burn, Leg, Reason, Unvisited

APPROXIMATE = (
    "some orbits are eccentric: the burns fly between circles of the same semi-major axes, and "
    "delta_v_m_s includes the cost of matching the eccentricity vectors; this is an approximation"
)


def legs(mission: Mission, sequence: Iterable[int]) -> tuple[Leg, ...]:
    """Price a sequence of bodies leg by leg.

    Raises
    ------
    InputError
        A move is illegal; the sentence says which.
    """
    moves = [int(j) for j in sequence]
    timing = mission.time(moves)
    if timing.made < len(moves):
        raise InputError(
            f"move {timing.made + 1} of the sequence, to {mission.names[moves[timing.made]]!r}, "
            "breaks the mission rules"
        )
    orbits, extra, rule = mission.transfer_inputs
    priced = []
    i, ready = mission.rules.start, mission.rules.ready
    for at, j in enumerate(moves):
        departure, arrival = timing.departures[at], timing.arrivals[at]
        delta_v, revolutions = timing.delta_vs[at], timing.revolutions[at]
        end, left = timing.ends[at], timing.lefts[at]
        times, vectors, phases = burn_kernels.burns_between(
            orbits[i], orbits[j], extra[i, j], rule, departure, arrival, revolutions
        )
        priced.append(
            Leg(
                origin=mission.names[i],
                destination=mission.names[j],
                ready_s=float(ready),
                departure_s=float(departure),
                arrival_s=float(arrival),
                end_s=float(end),
                delta_v_m_s=float(delta_v),
                delta_v_left_m_s=float(left - SLACK_M_S) + mission.reserve_m_s,
                phasing_revolutions=int(revolutions),
                eccentricity_delta_v_m_s=float(extra[i, j]),
                burns=tuple(
                    Burn(
                        time_s=float(time),
                        delta_v_m_s=(float(vector[0]), float(vector[1]), float(vector[2])),
                        phase=burn_kernels.PHASES[phase],  # type: ignore[arg-type]
                    )
                    for time, vector, phase in zip(times, vectors, phases, strict=True)
                ),
            )
        )
        i, ready = j, end
    return tuple(priced)


def unvisited(mission: Mission, sequence: Iterable[int]) -> tuple[Unvisited, ...]:
    """The targets that a sequence leaves out, each with its reason (see :class:`Unvisited`)."""
    moves = [int(j) for j in sequence]
    timing = mission.time(moves)
    rules = mission.rules
    body = moves[-1] if moves else rules.start
    time = float(timing.ends[-1]) if moves else rules.ready
    left = float(timing.lefts[-1]) if moves else rules.budget
    missing = []
    for j in sorted(set(range(rules.first_target, len(mission.names))) - set(moves)):
        reason: Reason
        found = mission.schedules.connections(body, j).after(time)
        ends = np.maximum(found.arrival, rules.opens[j]) + rules.service[j]
        in_time = ends <= rules.closes[j]
        if not mission.has_transfer[j]:
            reason = "no-transfer"
        elif not in_time.any():
            reason = "duration"
        elif found.delta_v[in_time].min() > left:
            reason = "delta-v"
        else:
            reason = "not-worth-it"
        missing.append(Unvisited(target=mission.names[j], reason=reason))
    return tuple(missing)
