"""Impulses in everything that lists or flies them: never two of one chaser at one instant."""

from __future__ import annotations

import math
import re
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from drifting_plans import drifting_instance, drifting_plan

import adr_opt
from adr_opt.export.flights import FlightFile, write_plan
from adr_opt.export.flights.refined_oem import write_refined
from adr_opt.fly.flight.mean_flight import fly_mean
from adr_opt.judge.admit import admit
from adr_opt.plan.impulses import SAME_INSTANT_S
from adr_opt.plan.plan import Plan
from adr_opt.plan.refined_plan import RefinedPlan
from adr_opt.problem.instance import Instance
from adr_opt.ui.plot.strands import tracks
from adr_opt.ui.report import burns

FORMER = Path(__file__).parents[1] / "fields" / "written_before"


@cache
def mission(kind: str) -> tuple[Instance, Plan, RefinedPlan]:
    """An instance, its plan, and that refined."""
    if kind == "former":
        return (
            Instance.load(FORMER / "tiny.json"),
            adr_opt.load_plan(FORMER / "tiny.plan.json"),
            RefinedPlan.load(FORMER / "tiny.refined.json"),
        )
    if kind == "drift":
        instance, plan = drifting_instance(), drifting_plan()
        return instance, plan, adr_opt.refine(instance, plan, freedom="planned")
    field = adr_opt.generate("tiny", 0, targets=5)
    instance = field.replace(dynamics="j2", transfer=field.transfer.replace(approach=kind))
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    return instance, plan, adr_opt.refine(instance, plan, gravity="j2")


KINDS = pytest.mark.parametrize("kind", ["half-lap", "safety-ellipse", "drift", "former"])


def listed(path: Path) -> int:
    """Manoeuvres in a file; those of one instant as one fail."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".script":
        steps = re.findall(r"^(Maneuver|Propagate|GMAT Chaser\.\S+ = \w+\.)", text, re.MULTILINE)
        assert ("Maneuver", "Maneuver") not in list(pairwise(steps))
        return steps.count("Maneuver")
    pattern = r"^MAN_EPOCH_IGNITION = (\S+)" if path.suffix == ".opm" else r"^(\d\S*) 0\.0* .*$"
    tables = (
        text if path.suffix == ".opm" else "".join(re.findall(r"MAN_START.*?MAN_STOP", text, re.S))
    )
    times = re.findall(pattern, tables, re.MULTILINE)
    assert len(times) == len(set(times))
    return len(times)


@KINDS
def test_no_two_impulses_at_one_instant(kind: str, tmp_path: Path) -> None:
    """Messages, scripts and pages list as many impulses as there are instants, all apart."""
    instance, plan, refined = mission(kind)
    for legs, write, one, suffixes in (
        (plan.legs, write_plan, plan, ("opm", "script")),
        (
            refined.legs,
            write_refined,
            admit(instance, refined, refined_from=plan),
            ("opm", "script", "ocm"),
        ),
    ):
        instants = sum(len({burn.time_s for burn in leg.burns}) for leg in legs)
        assert instants == sum(len(leg.impulses) for leg in legs)
        for suffix in suffixes:
            write(instance, one, tmp_path / f"a.{suffix}", file=FlightFile(suffix))
            assert listed(tmp_path / f"a.{suffix}") == instants
    told = burns.impulses(plan, tracks(instance, plan), refined)
    for one, after in pairwise(told):
        if (one.of, one.leg) == (after.of, after.leg):
            assert after.time_s - one.time_s > SAME_INSTANT_S


@KINDS
def test_flights_make_one_vector(kind: str) -> None:
    """Refined legs state none twice, and flights count the sum of vectors, not of their parts."""
    instance, plan, refined = mission(kind)
    if kind != "former":
        for leg in refined.legs:
            assert leg.impulses == leg.burns
            assert leg.approach_m_s is not None
    flown = fly_mean(instance, plan)
    assert flown is not None
    for number, leg in enumerate(plan.legs, start=1):
        parts = [np.array(burn.delta_v_m_s) for burn in leg.burns]
        at = [burn.time_s for burn in leg.burns].index(leg.standoff_s)
        apart = [part for number, part in enumerate(parts) if number not in (at, at + 1)]
        one = math.fsum(float(np.linalg.norm(part)) for part in (*apart, parts[at] + parts[at + 1]))
        assert leg.burns_delta_v_m_s == pytest.approx(one, abs=1e-9)
        assert leg.at_once_m_s > 0.0
        assert flown.flown[number] == pytest.approx(one + leg.eccentricity_delta_v_m_s, abs=1e-6)
