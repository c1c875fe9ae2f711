"""Planning around conjunctions: the legs that a screening forbids."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from ...common.errors import InputError
from ...fly.refine.lessons import Unsafe
from ...plan.refined_plan import RefinedPlan
from ...problem.instance import Instance
from ...sources.catalogue.records import ElementSet
from .approaches import DISTANCE_M, Screening
from .position_errors import PositionErrors

AVOID_M = 1_000.0
"""Miss within which an approach is avoided by default."""


def avoiding(
    instance: Instance,
    records: Sequence[ElementSet],
    *,
    avoid_m: float = AVOID_M,
    most_probability: float = math.inf,
    errors: Mapping[str, PositionErrors] | None = None,
    within_m: float = DISTANCE_M,
) -> Callable[[RefinedPlan], tuple[Unsafe, ...]]:
    """Close approaches of catalogued objects, for :func:`adr_opt.solve_refined` to avoid.

    Parameters
    ----------
    instance : Instance
        With a frame.
    records : sequence of ElementSet
    avoid_m : float
        Misses up to this are avoided, but for bodies that are visited [m].
    most_probability : float
        Probability of a collision from which an approach is avoided whatever its miss.
    errors : dict of str to PositionErrors, optional
        As of :func:`.screen`.
    within_m : float
        Miss up to which probabilities are looked at [m].

    Raises
    ------
    InputError
        There is no frame, the distance is no positive number, or a probability is to be held
        without errors.
    """
    if instance.frame is None:
        raise InputError(f"{instance.name!r} has no frame; make it with import")
    if math.isfinite(most_probability) and not errors:
        raise InputError("a probability of collision needs position errors; give them")
    asked_m = max(avoid_m, within_m) if errors else avoid_m
    screening = Screening(instance, records, asked_m, errors or {})

    def unsafe(refined: RefinedPlan) -> tuple[Unsafe, ...]:
        return tuple(
            Unsafe(
                each.leg,
                each.time_s,
                f"leg {each.leg} ({each.phase}) passes {each.object!r} by {each.miss_m:.0f} m at "
                f"{each.epoch}",
            )
            for each in screening.approaches(refined)
            if not each.own
            and (each.miss_m <= avoid_m or (each.probability or 0.0) >= most_probability)
        )

    return unsafe
