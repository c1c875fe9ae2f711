"""The table of engines: its page, and the first row that serves."""

from __future__ import annotations

from pathlib import Path

import pytest
from hand_made import hand_made
from random_rules import random_campaign
from timed_fields import timed_mission
from tour_fields import launched
from toy_roads import order_of_all

import adr_opt
from adr_opt.mission.problem import Problem
from adr_opt.problem.instance import Instance
from solvers.planners import label_setting, many_routes, one_route, timed_routes, tours
from solvers.planners.engines import ENGINES, PlanCall, engine_for, page_table

PAGE = Path(__file__).parents[2] / "docs" / "which-planner.md"


def test_the_page_has_the_table() -> None:
    """What the page on planners says of engines is what the table of engines says."""
    assert page_table() in PAGE.read_text(encoding="utf-8")


def test_every_engine_says_what_it_proves() -> None:
    """A method that has a function of an engine has a word on its proof, and no other method."""
    for each in ENGINES:
        assert each.plans
        assert each.plans.keys() == each.proves.keys() <= {"auto", "exact"}
    assert ENGINES[-1].plans.keys() == {"auto", "exact"}


@pytest.mark.parametrize(
    ("instance", "auto", "exact"),
    [
        (launched(0), tours.search, tours.prove),
        (timed_mission(0), timed_routes.plan, timed_routes.plan),
        (order_of_all(), timed_routes.plan, label_setting.plan),
        (hand_made(), one_route.plan, label_setting.plan),
        (random_campaign(0), many_routes.plan, many_routes.plan),
        (adr_opt.generate("removal", 0, targets=3), many_routes.plan, many_routes.plan),
    ],
)
def test_the_first_engine_that_serves_plans(
    instance: Instance, auto: PlanCall, exact: PlanCall
) -> None:
    """What is special comes before what is general, and every problem is served."""
    problem = Problem(instance)
    assert engine_for("auto", problem).plans["auto"] is auto
    assert engine_for("exact", problem).plans["exact"] is exact
