"""The course of a run: what is kept of it, how it stands in plan files, and how it is drawn."""

from __future__ import annotations

import json
import math
from collections.abc import Callable

import pytest
from pydantic import ValidationError

from adr_opt import Plan, Result, solve
from adr_opt.run.course import MOST_HEARD, MOST_WRITTEN, RunCourse
from adr_opt.ui.plot.course import course_chart
from adr_opt.ui.report.charts import drawn
from tests.fields.hand_made import hand_made

BROKEN = ([[1, 2, 3], [0, 2, 3]], [[1, 2]], [[-1, 2, 3]], [["0", 1, 2]], [[0, True, None]], "none")


@pytest.fixture(scope="module")
def proven() -> Plan:
    """A plan of the hand-made field by a planner that proves it."""
    result = solve(hand_made(), "beam", bound="exact", iterations=1000, time_limit=60.0)
    assert result.plan is not None
    return result.plan


def test_a_plan_keeps_the_course_of_its_run(proven: Plan) -> None:
    """It ends with what the plan states, its bounds fall, and it is read as it was written."""
    course = proven.course
    assert course
    assert course[-1][1:] == (proven.objective, proven.upper_bound)
    bounds = [bound for _, _, bound in course if bound is not None]
    assert bounds == sorted(bounds, reverse=True) != []
    assert Plan.from_json(proven.to_json()) == proven


def test_no_course_without_reports() -> None:
    """Of a method that reports nothing before its end, a plan file keeps none."""
    plan = solve(hand_made(), "greedy").plan
    assert plan is not None
    assert "course" not in json.loads(plan.to_json())


@pytest.mark.parametrize("course", BROKEN, ids=str)
def test_broken_courses_are_refused(proven: Plan, course: object) -> None:
    """Times that decrease or are negative, short points and other types are no course."""
    with pytest.raises(ValidationError):
        Plan.from_json(json.dumps({**proven.to_dict(), "course": course}))


def test_a_long_course_is_thinned(proven: Plan) -> None:
    """A file keeps a few points, the first and the last of them."""
    course = RunCourse()
    for number in range(2 * MOST_HEARD):
        course(float(number), math.inf)
    assert len(course.points) <= MOST_HEARD
    plan = proven.replace(objective=1e4, upper_bound=None, course=None)
    kept = course.kept(Result("many", plan=plan)).plan
    assert kept is not None
    assert kept.course is not None
    assert len(kept.course) == MOST_WRITTEN
    assert [kept.course[at][1:] for at in (0, -1)] == [(0.0, None), (1e4, None)]


def test_without_a_stated_bound_the_course_states_none(proven: Plan) -> None:
    """With a margin bounds hold for fewer plans than those of the instance, so none is kept."""
    course = RunCourse()
    course(1.0, 9.0)
    course(2.0, 8.0)
    plan = proven.replace(objective=2.0, upper_bound=None, course=None)
    kept = course.kept(Result("with a margin", plan=plan)).plan
    assert kept is not None
    assert [point[1:] for point in kept.course or ()] == [(1.0, None), (2.0, None)]


def test_plans_are_passed_on() -> None:
    """Who follows a run is told of incumbents, bounds and plans as without a course."""
    told: list[object] = []

    class Told:
        found: Callable[[object], None] = staticmethod(told.append)

        def __call__(self, incumbent: float, bound: float) -> None:
            told.append((incumbent, bound))

    course = RunCourse(Told())
    course.found(((1, 2),))
    course(2.0, 3.0)
    course(1.0, 4.0)
    assert told == [((1, 2),), (2.0, 3.0), (1.0, 4.0)]


def test_the_chart_says_how_the_gap_fell() -> None:
    """Values hold until the next one and the last until the end; the band between is the gap."""
    chart = course_chart([(1.0, None, 8.0), (2.0, 4.0, 8.0), (3.0, 5.0, 5.0)], 4.0)
    gap, bound, best = chart.series
    assert gap.name == "gap: 50 % → 0 %"
    assert list(zip(best.x, best.y, strict=True)) == [(2, 4), (3, 4), (3, 5), (4, 5)]
    assert list(zip(bound.x, bound.y, strict=True)) == [
        (1, 8),
        (2, 8),
        (2, 8),
        (3, 8),
        (3, 5),
        (4, 5),
    ]
    picture = drawn(chart, "run", from_zero=False)
    assert picture.count("<polyline") == 2
    assert picture.count("<polygon") == 1
    assert "style=" not in picture, "the live page allows no styles within"
