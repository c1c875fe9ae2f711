"""One timetable for all variants of a field that it serves."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hand_made import hand_made

import adr_opt
from adr_opt.mission.problem import Problem
from adr_opt.problem.chasers import Tank
from adr_opt.problem.instance import Instance
from adr_opt.run.reused_timetable import Reused, serves


def tables_agree(reused: Problem, built: Problem) -> bool:
    """Whether two timetables say the same of all pairs at many times."""
    times = np.linspace(0.0, built.instance.mission.duration_s, 40)
    return all(
        np.array_equal(one.timetable.matrices(times).delta_v, two.timetable.matrices(times).delta_v)
        and np.array_equal(
            one.timetable.matrices(times).duration, two.timetable.matrices(times).duration
        )
        for one, two in zip(reused.missions, built.missions, strict=True)
    )


def edited(instance: Instance, leave_out: int = 2, **target: Any) -> Instance:
    """A variant: the first target changed, and some others left out."""
    first, *others = instance.targets
    others = others[: len(others) - leave_out // 2] if leave_out else others
    others = others[leave_out - leave_out // 2 :]
    return instance.replace(targets=(first.replace(**target), *others))


@pytest.fixture(scope="module")
def fields() -> dict[str, Instance]:
    """One chaser, several, and planes that drift."""
    drifting = adr_opt.generate("sso", 0, targets=6)
    return {
        "one": adr_opt.generate("tiny", 0),
        "several": adr_opt.generate("campaign", 0, targets=6),
        "drifting": drifting.with_limits(duration_s=min(3.0e6, drifting.mission.duration_s)),
    }


@pytest.mark.parametrize(
    "which", ["one", "drifting", pytest.param("several", marks=pytest.mark.slow)]
)
def test_a_variant_is_planned_on_the_timetable_that_is_there(fields, which: str) -> None:
    """Prizes, requirements and exclusions build no timetable, and the table is that of the variant.

    So plans are the same, too.
    """
    instance, reuse = fields[which], Reused()
    first = reuse.problem(instance)
    assert not first.has_timetable
    for mission in first.missions:
        assert mission.timetable.is_whole
    for variant in (
        edited(instance, leave_out=0, prize=5.0),
        edited(instance, prize=2.0, required=True),
    ):
        made, alone = reuse.problem(variant), Reused().problem(variant)
        assert made.has_timetable
        assert made.instance == variant
        assert tables_agree(made, alone)
        on_it, anew = (
            adr_opt.solve(each, "greedy-guarded", time_limit=60.0) for each in (made, alone)
        )
        assert on_it.plan is not None
        assert anew.plan is not None
        clocked = {"runtime_s": 0.0, "course": None}
        assert on_it.plan.replace(**clocked) == anew.plan.replace(**clocked)


def test_what_makes_other_connections_is_built_anew(fields) -> None:
    """Another duration, window or order of targets is served by no timetable that is there."""
    instance = fields["one"]
    longer = instance.with_limits(duration_s=instance.mission.duration_s * 1.5)
    opened = edited(instance, leave_out=0, window_s=(100.0, None))
    turned = instance.replace(targets=instance.targets[::-1])
    for other in (longer, opened, turned):
        assert not serves(instance, other)
    reuse = Reused()
    _ = reuse.problem(instance).missions[0].timetable
    assert not reuse.problem(longer).has_timetable
    fewer = edited(instance)
    assert serves(instance, fewer)
    assert not serves(fewer, instance)


def test_tanks_share_a_timetable_unless_connections_depend_on_them(fields) -> None:
    """In two-body motion other tanks plan on the same table; under J2 on one of their own."""
    for which, shared in (("one", True), ("several", True), ("drifting", False)):
        instance = fields[which]
        chasers = tuple(each.replace(tank=Tank(delta_v_m_s=900.0)) for each in instance.chasers)
        assert serves(instance, instance.replace(chasers=chasers)) is shared


def test_a_shorter_mission_takes_listed_connections_over(fields) -> None:
    """Under J2 a shorter mission of fewer targets works out no connection that is known."""
    instance, reuse = fields["drifting"], Reused()
    for mission in reuse.problem(instance).missions:
        assert mission.timetable.is_whole
    shorter = edited(instance).with_limits(duration_s=0.6 * instance.mission.duration_s)
    made, alone = reuse.problem(shorter), Reused().problem(shorter)
    assert not made.has_timetable
    known = made.connecting._longer
    assert known is not None
    before = len(known.kept)
    assert tables_agree(made, alone)
    assert len(known.kept) == before
    again = reuse.problem(edited(shorter, leave_out=0, prize=3.0))
    assert again.has_timetable
    longer = reuse.problem(instance)
    assert longer.has_timetable


def test_optimal_plans_of_edited_fields_are_those_of_fields_read_anew() -> None:
    """On one chain of edits, `exact` proves the same on the reused timetable as on its own."""
    reuse, instance = Reused(), hand_made()
    for change in ({"prize": 1.0}, {"prize": 4.0}, {"prize": 4.0, "required": True}):
        for leave_out in (0, 1):
            variant = edited(instance, leave_out, **change)
            made = adr_opt.solve(reuse.problem(variant), "exact", time_limit=60.0)
            alone = adr_opt.solve(variant, "exact", time_limit=60.0)
            assert (made.objective, made.status) == (alone.objective, "optimal")
    # Beams of "auto" have timetables of other choices, which are shared as well.
    for prize in (2.0, 3.0):
        variant = edited(instance, 0, prize=prize)
        made = adr_opt.solve(reuse.problem(variant), "auto", time_limit=60.0)
        assert (made.objective, made.status) == (2.0 + prize, "optimal")
    assert reuse.problem(instance).alone is not None
