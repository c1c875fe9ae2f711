"""Free burns, safety ellipses, releases, launches, captures and reserves, against enumeration."""

from __future__ import annotations

from collections.abc import Callable

from against_enumeration import held, held_costs
from random_rules import (
    captured_campaign,
    disposing_campaign,
    disposing_mission,
    free_mission,
    full_mission,
    launched_mission,
    reserving_campaign,
    reserving_mission,
    rounding_mission,
)
from seeds import over_kinds

from adr_opt.mission.problem import Problem
from adr_opt.problem.instance import Instance

Draw = Callable[[int], Instance]


@over_kinds(
    "draw, seeds",
    full=(full_mission, range(300), 3),
    free=(free_mission, range(300), 2),
    launched=(launched_mission, range(300), 4),
    captured=(captured_campaign, range(200), 2),
    rounding=(rounding_mission, range(300), 2),
    disposing=(disposing_mission, range(300), 2),
    reserving=(reserving_mission, range(300), 5),
)
def test_enumeration_knows_no_better_plans(draw: Draw, seeds: range) -> None:
    """What is planned passes `check`, and nothing above what is proven can be flown."""
    found = held((Problem(draw(seed)) for seed in seeds), "auto")
    flown = sum(len(result.plan.legs) for _, result in found if result.plan)
    assert len(seeds) < 20 or flown > len(seeds)


@over_kinds(
    "draw, seeds",
    disposing=(disposing_campaign, range(300), 2),
    reserving=(reserving_campaign, range(300), 4),
    full=(full_mission, range(100), 3),
)
def test_costs_are_those_of_enumeration(draw: Draw, seeds: range) -> None:
    """The same of the cost that is proven least, of several chasers and with kits too."""
    held_costs(Problem(draw(seed)) for seed in seeds)
