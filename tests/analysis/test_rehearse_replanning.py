"""What policies that plan expect of a mission, and the connections that they take."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
import towed_fields
from random_rules import drifting_mission

import adr_opt
from adr_opt.analysis.rehearse.expectation import Expectation
from adr_opt.analysis.rehearse.flight import Situation
from adr_opt.analysis.rehearse.flying_chasers import beginning, refused
from adr_opt.analysis.rehearse.intended import Intended, PlannedHop
from adr_opt.analysis.rehearse.mission_facts import MissionFacts, hop_of
from adr_opt.analysis.rehearse.replanning import AtDeviations
from adr_opt.analysis.rehearse.sampling import rehearse
from adr_opt.plan.leg_kinds import leg_kinds
from adr_opt.problem.uncertainty import Uncertainty

CAPTURES = Uncertainty(capture={"success": 0.8, "tries": 2}, gone=0.05)


def test_stays_are_expected_as_long_as_they_are_on_average() -> None:
    """1.2 tries at targets of which 5 % are gone take 1.14 times as long as one try."""
    facts = MissionFacts(adr_opt.generate("tiny", 0))
    expectation = Expectation(facts, Intended(None, ((),), (0,)), CAPTURES)
    assert expectation.time_share == pytest.approx(0.95 * 1.2)
    assert expectation.differs
    planned = facts.instance.mission.service_revolutions
    slower = expectation.expected(facts.instance, cautious=True).mission.service_revolutions
    assert slower == pytest.approx(1.14 * planned)
    assert expectation.expected(facts.instance, cautious=False) == facts.instance


def test_services_in_seconds_are_expected_longer_as_well() -> None:
    """With the mean of a delay where missions state seconds, not revolutions."""
    instance = adr_opt.generate("tiny", 0)
    mission = instance.mission.replace(service_revolutions=None, service_s=5000.0)
    facts = MissionFacts(instance.replace(mission=mission))
    late = Uncertainty(service_s={"added": {"chance": 0.5, "mean_s": 2000.0}})
    expectation = Expectation(facts, Intended(None, ((),), (0,)), late)
    slower = expectation.expected(facts.instance, cautious=True).mission.service_s
    assert slower == pytest.approx(6000.0)


def test_stays_before_tows_are_expected_as_planned() -> None:
    """An object that has still to be towed has a window for just its service."""
    facts = MissionFacts(towed_fields.field())
    expectation = Expectation(facts, Intended(None, ((),), (0,)), CAPTURES)
    assert expectation.time_share == 1.0


def test_an_earlier_connection_of_no_more_delta_v_is_flown() -> None:
    """Of all connections to the planned body that take no more, the one that arrives first."""
    facts = MissionFacts(adr_opt.generate("tiny", 0))
    start, better = facts.chasers[0].start, 0
    for j in range(facts.first_target, len(facts.names)):
        rows = facts.rows(start, j, towed=False)
        for row in np.linspace(0, rows.departure.size // 2, 6).astype(int):
            planned = hop_of(j, rows, int(row))
            craft = beginning(facts, 0, 0, 0.0, 1.0)
            if refused(facts, craft, planned):
                continue
            intended = Intended(None, ((PlannedHop(start, False, planned),),), (0,))
            policy = AtDeviations(facts, intended, Uncertainty())
            flown = policy.next_leg(Situation(facts, craft, (craft,), set()))
            no_dearer = rows.delta_v <= planned.delta_v
            assert flown.destination == j
            assert flown.delta_v <= planned.delta_v
            assert flown.arrival == rows.arrival[no_dearer].min()
            better += flown.arrival < planned.arrival
    assert better


def test_shorter_stays_are_expected_as_planned() -> None:
    """Targets that may be gone save time, but legs begin only if planned services fit."""
    facts = MissionFacts(adr_opt.generate("tiny", 0))
    expectation = Expectation(facts, Intended(None, ((),), (0,)), Uncertainty(gone=0.4))
    assert expectation.time_share == 1.0
    mission = expectation.expected(facts.instance, cautious=True).mission
    assert mission == facts.instance.mission


def test_a_chaser_leaves_also_where_longer_stays_do_not_fit() -> None:
    """Where only one service fits, and none as long as on average, it is tried, not forgone."""
    instance = adr_opt.generate("tiny", 0)
    service_s = 20000.0
    mission = instance.mission.replace(
        service_revolutions=None, service_s=service_s, duration_s=service_s + 20000.0
    )
    instance = instance.replace(mission=mission)
    uncertainty = Uncertainty(capture={"success": 0.6, "tries": 3})
    plan = adr_opt.solve(instance, method="greedy").plan
    flown = rehearse(instance, plan, uncertainty, policy="replan", samples=8)
    assert max(row.prize for row in flown.outcomes) > 0.0


def test_an_earlier_connection_is_no_less_certain() -> None:
    """A leg of a kind whose factor has a larger spread does not take the place of a planned one."""
    uncertain = Uncertainty(legs={"kinds": {"drift": {"lognormal_sigma": 0.4}}})
    drift = [kind.name for kind in leg_kinds()].index("drift")
    kept = 0
    for seed in range(6):
        facts = MissionFacts(drifting_mission(seed))
        for origin, j in permutations(range(facts.first_target, len(facts.names)), 2):
            rows = facts.rows(origin, j, towed=False)
            craft = beginning(facts, 0, 0, 0.0, 1.0)
            craft.body = origin
            for row in range(0, rows.departure.size, max(rows.departure.size // 40, 1)):
                planned = hop_of(j, rows, row)
                intended = Intended(None, ((PlannedHop(origin, False, planned),),), (0,))
                found, certain = (
                    AtDeviations(facts, intended, each)._earlier(craft, planned)
                    for each in (uncertain, Uncertainty())
                )
                if planned.family != drift:
                    assert found.family != drift
                kept += found != certain
    assert kept
