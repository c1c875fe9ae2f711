"""Check of legs of registered families, which recompute them."""

from __future__ import annotations

from collections.abc import Generator

from ...common.constants import SLACK_S
from ...common.errors import InputError
from ...legs.families.ends import AllEnds
from ...legs.families.family import StatedLeg
from ...legs.families.registry import registered_of
from ...plan.plan import Leg
from ...problem.instance import Instance
from .figures import check_burns, check_costs
from .violation import TIME_TOLERANCE_S, Violation


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
