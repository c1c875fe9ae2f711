"""Check a plan against its instance, from the instance alone.

Shares nothing with the planners but the physics of one transfer (`kernels.orbits`,
`kernels.transfer`, `kernels.burns`) and the slack of the model (`kernels.constants`): departure
events, the choice of the entry and the mission rules are stated here a second time, on purpose, and
plainly; so are the keep-out zones, in `keep_out`, from the burns alone.

The mission is followed by a clock and a tank of its own, and the rules are asked about those, with
the slack and nothing more. The figures of the plan only have to agree with them, to the tolerances
below; so no plan gains anything by rounding its figures in its own favour, leg after leg, and what
is accepted here is what is proven about.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .chasers import AtStation
from .errors import InputError
from .formats_1 import is_of
from .instance import Instance
from .keep_out import crossed
from .kernels import burns as burn_kernels
from .kernels import orbits, transfer
from .kernels.constants import SLACK_M_S, SLACK_S
from .plan import Leg, Plan
from .support import refuse_unsupported

TIME_TOLERANCE_S = 1e-3
DELTA_V_TOLERANCE_M_S = 1e-4
"""What figures of a plan may differ by from what they state."""

OBJECTIVE_TOLERANCE = 1e-6
"""The same for objective and bound, relative; for the gap, which is a share, as it is."""


@dataclass(frozen=True)
class Violation:
    """One thing that is wrong with a plan.

    Attributes
    ----------
    leg : int or None
        Number of the leg, from 1; None if it concerns the plan as a whole.
    rule : str
        Short name of the rule that is broken.
    message : str
        What is stated and what is true.
    """

    leg: int | None
    rule: str
    message: str

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return asdict(self)

    def __str__(self) -> str:
        where = "plan" if self.leg is None else f"leg {self.leg}"
        return f"{where}: {self.rule}: {self.message}"


class _Physics(NamedTuple):
    """What the transfers of an instance follow from, worked out once for all legs."""

    elements: npt.NDArray[np.float64]
    extra: npt.NDArray[np.float64]
    rule: transfer.TransferRule


def check(instance: Instance, plan: Plan) -> tuple[Violation, ...]:
    """All violations of a plan; none means that it may be flown.

    Parameters
    ----------
    instance : Instance
    plan : Plan

    Raises
    ------
    InputError
        The plan belongs to another instance, or nothing can plan this one yet.
    """
    if not is_of(plan.instance, instance):
        raise InputError(
            f"the plan belongs to the instance {plan.instance.name!r} "
            f"(sha256 {plan.instance.sha256[:12]}…), not to {instance.name!r} "
            f"(sha256 {instance.sha256[:12]}…); give the instance it was made for"
        )
    refuse_unsupported(instance)
    return (
        *_check_routes(instance, plan),
        *_check_legs(instance, plan),
        *_check_totals(instance, plan),
        *_check_cost(instance, plan),
    )


def _check_routes(instance: Instance, plan: Plan) -> Iterator[Violation]:
    """Each route is that of a chaser of the instance, and each chaser has one at most."""
    known = [chaser.name for chaser in instance.chasers]
    stated = [route.chaser for route in plan.routes]
    for name in sorted(set(stated) - set(known)):
        yield Violation(None, "chaser", f"{name!r} is not a chaser of the instance")
    for name in sorted({name for name in stated if stated.count(name) > 1}):
        yield Violation(None, "chaser", f"{name!r} has more than one route")


def _check_legs(instance: Instance, plan: Plan) -> Iterator[Violation]:
    """Follow the mission leg by leg: order, times, ΔV, burns."""
    index = {name: number for number, name in enumerate(instance.names)}
    chaser, stations = instance.chasers[0], {station.name for station in instance.stations}
    windows = {target.name: target.window_s for target in instance.targets}
    budget = chaser.tank.delta_v_m_s
    physics = _Physics(instance.orbits(), instance.eccentricity_delta_v(), instance.transfer_rule())
    where, free, left = chaser.start_name, chaser.available_s[0], budget
    visited: set[str] = set()
    serviced = 0
    for number, leg in enumerate(plan.legs, start=1):
        unknown = [name for name in (leg.origin, leg.destination) if name not in index]
        if unknown:
            # Nothing after this leg has a state to be checked against.
            yield Violation(number, "body", f"{unknown[0]!r} is not a body of the instance")
            return
        if leg.origin != where:
            yield Violation(
                number, "chain", f"starts at {leg.origin!r}, but the chaser is at {where!r}"
            )
        if leg.destination == leg.origin:
            yield Violation(number, "order", f"goes from {leg.origin!r} to itself")
            return
        if leg.destination in stations:
            if serviced == 0:
                yield Violation(
                    number, "refuelling", "no target was visited since the last refuelling"
                )
        elif leg.destination not in windows:
            yield Violation(number, "order", f"{leg.destination!r} is no target and no station")
        elif leg.destination in visited:
            yield Violation(number, "order", f"{leg.destination!r} was visited before")
        if abs(leg.ready_s - free) > TIME_TOLERANCE_S:
            yield Violation(
                number, "ready", f"ready_s = {leg.ready_s!r}, but the chaser is free at {free!r}"
            )
        i, j = index[leg.origin], index[leg.destination]
        arrival, delta_v = yield from _check_transfer(instance, physics, number, leg, i, j, free)
        for which in crossed(instance, leg):
            zone = instance.keep_out_zones[which]
            yield Violation(
                number,
                "zone",
                f"crosses keep_out_zones[{which}], {zone.min_altitude_m:.0f}–"
                f"{zone.max_altitude_m:.0f} m, while it is closed from {zone.start_s:.0f} s "
                f"to {zone.end_s:.0f} s",
            )

        at_station = leg.destination in stations
        opens, closes = windows.get(leg.destination, (0.0, None))
        end = max(arrival, opens) + _service_s(instance, physics.elements[j], at_station)
        if abs(leg.end_s - end) > TIME_TOLERANCE_S:
            yield Violation(number, "service", f"end_s = {leg.end_s!r}, but it ends at {end!r}")
        for rule, last in (
            ("duration", instance.mission.duration_s),
            ("availability", chaser.available_s[1]),
            ("window", closes),
        ):
            if last is not None and end > last + SLACK_S:
                yield Violation(number, rule, f"ends at {end!r} s, after {last!r} s")
        if delta_v > left + SLACK_M_S:
            yield Violation(number, "delta-v", f"needs {delta_v!r} m/s, but only {left!r} are left")
        left = budget if at_station else left - delta_v
        if abs(leg.delta_v_left_m_s - left) > DELTA_V_TOLERANCE_M_S:
            yield Violation(
                number,
                "delta-v-left",
                f"delta_v_left_m_s = {leg.delta_v_left_m_s!r}, but {left!r} are left",
            )
        serviced = 0 if at_station else serviced + 1
        if not at_station:
            visited.add(leg.destination)
        where, free = leg.destination, float(end)
    if chaser.max_targets is not None and len(visited) > chaser.max_targets:
        yield Violation(
            None, "targets", f"{len(visited)} targets are visited, and {chaser.max_targets} may be"
        )
    is_plan = plan.status in ("optimal", "feasible")
    if isinstance(chaser.end, AtStation) and is_plan and where != chaser.end.station:
        yield Violation(
            None, "end", f"ends at {where!r}, but the chaser has to end at {chaser.end.station!r}"
        )
    for target in instance.targets:
        if target.required and is_plan and target.name not in visited:
            yield Violation(None, "required", f"{target.name!r} is required, but not visited")


def _service_s(instance: Instance, elements: npt.NDArray[np.float64], at_station: bool) -> float:
    """How long a chaser stays at the body on an orbit [s]."""
    mission = instance.mission
    if not at_station and mission.service_s is not None:
        return mission.service_s
    revolutions = mission.refuel_revolutions if at_station else mission.service_revolutions
    assert revolutions is not None
    return revolutions * float(orbits.period(elements[orbits.RADIUS]))


def _check_transfer(
    instance: Instance, physics: _Physics, number: int, leg: Leg, i: int, j: int, free: float
) -> Generator[Violation, None, tuple[float, float]]:
    """The leg departs at a crossing of the line of nodes, and its sequence can be flown from there.

    Returns when the chaser arrives and the ΔV, to go on from: recomputed, but as stated where the
    plan is wrong about them, so that one mistake is reported once.
    """
    as_stated = leg.arrival_s, leg.delta_v_m_s
    elements, rule = physics.elements, physics.rule
    extra = float(physics.extra[i, j])
    pair = transfer.prepare(elements[i], elements[j], extra, rule)

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
        return as_stated
    if departure < free - SLACK_S:
        yield Violation(number, "departure", "leaves before the chaser is ready")
        return as_stated
    if not 0 <= leg.phasing_revolutions <= rule.max_phasing_revolutions:
        yield Violation(
            number,
            "phasing",
            f"phasing_revolutions = {leg.phasing_revolutions}, which is not from 0 to "
            f"{rule.max_phasing_revolutions}",
        )
        return as_stated
    # The target's lead decides when the chaser may arrive: whole turns of it apart.
    lead = math.fmod(pair.phase_j + pair.rate_j * departure - math.pi * half_turns, 2.0 * math.pi)
    lap = 2.0 * math.pi / pair.rate_j
    approach = rule.approach_revolutions * lap
    met = (
        departure + (3.0 * math.pi - lead + rule.standoff / pair.radius_j) / pair.rate_j + approach
    )
    arrival = float(met + round((leg.arrival_s - met) / lap) * lap)
    flight, laps = arrival - approach - departure, leg.phasing_revolutions
    low = pair.shortest + laps * pair.shortest_lap
    high = pair.longest + laps * pair.longest_lap
    if not low <= flight <= high:
        yield Violation(
            number,
            "phasing",
            f"with {laps} phasing revolutions between the altitude limits it cannot arrive at "
            f"{arrival!r}: the flight would take {flight!r} s, and may take {low!r} to {high!r} s",
        )
        return as_stated
    radius = transfer.phasing_radius(pair, rule, laps, flight)
    delta_v = float(transfer.sequence_delta_v(pair, rule, laps, radius))
    if abs(leg.arrival_s - arrival) > TIME_TOLERANCE_S:
        yield Violation(
            number, "arrival", f"arrival_s = {leg.arrival_s!r}, but it arrives at {arrival!r}"
        )
        arrival = leg.arrival_s
    if abs(leg.delta_v_m_s - delta_v) > DELTA_V_TOLERANCE_M_S:
        yield Violation(
            number, "cost", f"delta_v_m_s = {leg.delta_v_m_s!r}, but it costs {delta_v!r}"
        )
        delta_v = leg.delta_v_m_s
    if abs(leg.eccentricity_delta_v_m_s - extra) > DELTA_V_TOLERANCE_M_S:
        yield Violation(
            number,
            "eccentricity",
            f"eccentricity_delta_v_m_s = {leg.eccentricity_delta_v_m_s!r}, but it is {extra!r}",
        )
    if transfer.is_blocked(pair, rule, laps, radius, departure) and not any(
        True for _ in crossed(instance, leg)
    ):
        yield Violation(
            number,
            "zone",
            "touches the edge of a keep-out zone while that is closed; edges belong to zones",
        )
    times, vectors, phases = burn_kernels.burns(
        elements[i], elements[j], pair, rule, departure, laps, radius
    )
    stated_phases = [burn.phase for burn in leg.burns]
    expected_phases = [burn_kernels.PHASES[phase] for phase in phases]
    if stated_phases != expected_phases:
        yield Violation(
            number, "burns", f"phases are {stated_phases}, but should be {expected_phases}"
        )
        return arrival, delta_v
    for which, burn in enumerate(leg.burns):
        late = abs(burn.time_s - times[which])
        off = float(np.linalg.norm(np.array(burn.delta_v_m_s) - vectors[which]))
        if late > TIME_TOLERANCE_S or off > DELTA_V_TOLERANCE_M_S:
            yield Violation(
                number,
                "burns",
                f"burn {which + 1} ({burn.phase}) is off by {late:.3g} s and {off:.3g} m/s",
            )
    return arrival, delta_v


def _check_totals(instance: Instance, plan: Plan) -> Iterator[Violation]:
    """Objective, certificate and the list of unvisited targets."""
    prize = {target.name: target.prize for target in instance.targets}
    visited = {leg.destination for leg in plan.legs} & set(prize)
    objective = sum(prize[name] for name in sorted(visited))
    if abs(plan.objective - objective) > OBJECTIVE_TOLERANCE * objective:
        yield Violation(
            None,
            "objective",
            f"objective = {plan.objective!r}, but the prizes sum to {objective!r}",
        )
    least = sum(sorted(prize.values(), reverse=True)[: instance.chasers[0].max_targets])
    if plan.upper_bound is not None:
        least = min(least, plan.upper_bound)
        if plan.objective > plan.upper_bound + OBJECTIVE_TOLERANCE * abs(plan.upper_bound):
            yield Violation(
                None, "bound", f"objective {plan.objective!r} exceeds bound {plan.upper_bound!r}"
            )
        gap = 0.0
        if plan.upper_bound > 0.0:
            gap = (plan.upper_bound - plan.objective) / plan.upper_bound
        if plan.gap is None or abs(plan.gap - gap) > OBJECTIVE_TOLERANCE:
            yield Violation(None, "gap", f"gap = {plan.gap!r}, but it is {gap!r}")
    elif plan.gap is not None:
        yield Violation(None, "gap", "a gap is stated without an upper bound")
    # Nothing can be worth more than all prizes, whether a bound is stated or not.
    met = plan.objective >= least - OBJECTIVE_TOLERANCE * abs(least)
    if plan.status == "optimal" and not met:
        yield Violation(None, "status", f"optimal is stated, but the bound is {least!r}, not met")
    elif plan.status == "feasible" and met:
        yield Violation(
            None, "status", f"feasible is stated, but the bound of {least!r} is met: it is optimal"
        )
    elif plan.status in ("infeasible", "unknown") and plan.legs:
        yield Violation(None, "status", f"{plan.status} is stated, but the plan has legs")
    stated = [entry.target for entry in plan.unvisited]
    for name in sorted(set(prize) - visited - set(stated)):
        yield Violation(None, "unvisited", f"{name!r} is neither visited nor listed")
    for name in sorted({name for name in stated if stated.count(name) > 1}):
        yield Violation(None, "unvisited", f"{name!r} is listed more than once")
    for name in sorted(set(stated) & visited):
        yield Violation(None, "unvisited", f"{name!r} is listed, but the plan visits it")
    for name in sorted(set(stated) - set(prize)):
        yield Violation(None, "unvisited", f"{name!r} is not a target of the instance")


def _check_cost(instance: Instance, plan: Plan) -> Iterator[Violation]:
    """The cost, as the instance counts it, and what is said to be proven of it."""
    if instance.objective.cost == "duration":
        cost, slack = max([0.0, *(leg.end_s for leg in plan.legs)]), TIME_TOLERANCE_S
    else:
        cost = sum(leg.delta_v_m_s for leg in plan.legs)
        slack = DELTA_V_TOLERANCE_M_S * len(plan.legs)
    if abs(plan.cost - cost) > slack:
        yield Violation(None, "cost", f"cost = {plan.cost!r}, but it is {cost!r}")
    bound = plan.cost_bound
    if bound is not None:
        if plan.cost < bound - OBJECTIVE_TOLERANCE * abs(bound):
            yield Violation(
                None, "cost-bound", f"cost {plan.cost!r} is less than the bound {bound!r}"
            )
        gap = (plan.cost - bound) / plan.cost if plan.cost > 0.0 else 0.0
        if plan.cost_gap is None or abs(plan.cost_gap - gap) > OBJECTIVE_TOLERANCE:
            yield Violation(None, "cost-gap", f"cost_gap = {plan.cost_gap!r}, but it is {gap!r}")
        if plan.cost_status is None:
            yield Violation(None, "cost-status", "a bound of the cost is stated without a status")
    elif plan.cost_gap is not None:
        yield Violation(None, "cost-gap", "a gap of the cost is stated without a bound")
    # Nothing costs less than nothing, whether a bound is stated or not.
    most = max(0.0, bound or 0.0)
    met = plan.cost <= most + OBJECTIVE_TOLERANCE * most
    if plan.cost_status == "optimal" and not met:
        yield Violation(
            None, "cost-status", f"optimal is stated, but the bound is {most!r}, not met"
        )
    elif plan.cost_status == "feasible" and met:
        yield Violation(
            None,
            "cost-status",
            f"feasible is stated, but the bound of {most!r} is met: it is optimal",
        )
    elif plan.cost_status in ("infeasible", "unknown") and plan.legs:
        yield Violation(None, "cost-status", f"{plan.cost_status} is stated, but the plan has legs")
