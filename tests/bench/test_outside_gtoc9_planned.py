"""Campaigns of made-up debris by the rules of GTOC9: planned, bounded and flown."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from from_outside import BENCH, arrived
from outside.gtoc9.campaign import Removals, Stop, read_campaign
from outside.gtoc9.debris import read_debris
from outside.gtoc9.ephemeris import read_ephemeris
from outside.gtoc9.estimate import LIMITS_M
from outside.gtoc9.flights import report_flights
from outside.gtoc9.flown import Flight, FlownMission, read_flown
from outside.gtoc9.flying import CLOSE_M, CLOSE_M_S, MOST_IMPULSES, flown_leg
from outside.gtoc9.instance import contest
from outside.gtoc9.judging import judged, judged_leg
from outside.gtoc9.phases import latitude_of, phased_cost
from outside.gtoc9.polishing import sensitive
from outside.gtoc9.scoring import score

import adr_opt
from adr_opt.common.constants import DAY_S, OBLATENESS_M2
from adr_opt.common.errors import InputError
from adr_opt.fly.refine.leg import LegEnds
from adr_opt.kernels.legs import drift_linear as drift
from adr_opt.mission.problem import Problem
from solvers.tours.least_expense import LeastExpense

assert BENCH.is_dir()


def made_up(path, count, spread_deg=6.0, epoch=22000.0, seed=4):
    """A file of debris whose planes are near at an epoch, in the form of the contest's."""
    random = np.random.default_rng(seed)
    lines = []
    for number in range(count):
        plane = math.radians(100.0 + random.uniform(-spread_deg, spread_deg))
        elements = [
            epoch + random.uniform(0.0, 1.0),
            7.1e6 + random.uniform(-5e4, 5e4),
            random.uniform(0.0, 0.01),
            math.radians(98.0 + spread_deg * random.uniform(-0.1, 0.1)),
            plane,
            random.uniform(0.0, math.tau),
            random.uniform(0.0, math.tau),
        ]
        lines.append(" ".join(repr(value) for value in (float(number), *elements)))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def field(tmp_path_factory):
    return made_up(tmp_path_factory.mktemp("gtoc9") / "debris_data.txt", 7)


@pytest.fixture(scope="module")
def close(tmp_path_factory):
    return made_up(tmp_path_factory.mktemp("near") / "debris_data.txt", 4, 0.5, 23599.0)


@pytest.mark.slow
def test_a_plan_is_legal_and_above_the_bound(field, tmp_path):
    """A campaign of solve keeps all rules of the contest, and J is no less than the bound."""
    rows = read_debris(field)
    result = adr_opt.solve(contest(rows, 0.5), seed=1, iterations=2, time_limit=math.inf)
    result.plan.save(tmp_path / "ours.json")
    missions = read_campaign(tmp_path / "ours.json")
    judged_so = score(missions, [mission.flown_m_s for mission in missions], len(rows))
    assert judged_so.violations == ()
    assert judged_so.total_meur == pytest.approx(result.plan.cost, rel=1e-9)
    below = LeastExpense(Problem(contest(rows, 0.5)))
    below.advance(math.inf)
    assert 30.0 < below.value <= judged_so.total_meur


@pytest.fixture(scope="module")
def leg(close):
    """A leg of four days between two debris, and both."""
    one, other = read_ephemeris(close)[:2]
    return one, other, flown_leg(one, other, 23600.0, 23604.0)


def test_a_flown_leg_arrives_in_other_propagations(leg):
    """Impulses lead from one debris to the other also where SciPy, and the judge, fly them."""
    one, other, found = leg
    assert found.impulses <= MOST_IMPULSES
    assert found.delta_v_m_s == pytest.approx(np.linalg.norm(found.impulses_m_s, axis=1).sum())
    flight = Flight(found.times_s - 23600.0 * DAY_S, found.impulses_m_s)
    off = arrived(one, other, 23600.0, 23604.0, *flight)
    assert off[0] < CLOSE_M
    assert off[1] < CLOSE_M_S
    again = judged_leg(one, other, 23600.0, 23604.0, flight)
    assert again.miss_m < 1.0
    assert again.miss_m_s < 1e-3
    assert again.delta_v_m_s == pytest.approx(found.delta_v_m_s)


def test_the_estimate_with_a_phase_is_near_the_flight(close, leg):
    """A leg of four days costs within a tenth of what the estimate with a phase says, or less."""
    rows = read_debris(close)
    one, other, found = leg
    pair = drift.prepare(rows[0], rows[1], *LIMITS_M, OBLATENESS_M2, 0.0)
    times = 23600.0 * DAY_S, 23604.0 * DAY_S
    phased = phased_cost(pair, latitude_of(one), latitude_of(other), *times)
    assert phased >= drift.delta_v(pair, *times) - 1e-9
    assert 0.7 * phased < found.delta_v_m_s < 1.1 * phased


def test_polishing_knows_its_derivatives(leg):
    """What a miss gains by times and components of impulses is what differences say."""
    one, other, found = leg
    start, end = 23600.0 * DAY_S, 23604.0 * DAY_S
    course = LegEnds(one.state(start), other.state(end), start, end, 0.0, "j2")
    _, derivatives = sensitive(course, found.times_s, found.impulses_m_s)
    count = len(found.times_s)
    for column, step in [(1, 0.1), (count - 2, 0.1), (count + 4, 1e-4), (4 * count - 1, 1e-4)]:
        ends = []
        for sign in (-1.0, 1.0):
            times, impulses = found.times_s.copy(), found.impulses_m_s.copy()
            if column < count:
                times[column] += sign * step
            else:
                impulses.flat[column - count] += sign * step
            ends.append(sensitive(course, times, impulses)[0])
        slope = (ends[1] - ends[0]) / (2.0 * step)
        assert slope == pytest.approx(derivatives[:, column], rel=1e-4, abs=1e-12)


def spoilt(flight, change):
    times, impulses = flight.times_s.copy(), flight.impulses_m_s.copy()
    return Flight(*change(times, impulses))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda times, impulses: (times, 1.01 * impulses), "off on arrival"),
        (lambda times, impulses: (times[::-1], impulses[::-1]), "out of order"),
        (lambda times, impulses: (times + 5.0 * DAY_S, impulses), "outside of the leg"),
        (lambda times, impulses: (np.repeat(times, 2), np.repeat(0.5 * impulses, 2, 0)), "0 imp"),
        (lambda times, impulses: (times[:1], np.array([[0.0, -900.0, 900.0]])), "a perigee of"),
    ],
)
def test_flown_legs_that_break_a_rule_are_named(leg, change, said):
    """A leg with other impulses than lead to its debris, or with too many, is told."""
    one, other, found = leg
    flight = Flight(found.times_s - 23600.0 * DAY_S, found.impulses_m_s)
    stops = Stop(0, 23595.0, 23600.0), Stop(1, 23604.0, 23609.0)
    good = judged([FlownMission(Removals(stops), (flight,))], (one, other))
    assert good.violations == ()
    bad = judged([FlownMission(Removals(stops), (spoilt(flight, change),))], (one, other))
    assert any(said in sentence for sentence in bad.violations), bad.violations


def test_missions_are_flown_written_and_judged_again(close, tmp_path):
    """A campaign of a file is flown and written, and its impulses arrive once more."""
    mission = {"debris": [2, 3], "stay_d": [5.0, 5.0], "transfer_d": [3.0], "dv_m_s": [0.0]}
    path, flown = tmp_path / "campaign.json", tmp_path / "flown.json"
    path.write_text(json.dumps({"start_mjd2000": [23600.0], "missions": [mission]}))
    rows, debris = read_debris(close), read_ephemeris(close)
    text = "\n".join(report_flights(close, path, rows, None, flown))
    assert "1 legs. J is" in text
    again = judged(read_flown(flown, len(debris)), debris)
    assert again.legs[0][0].miss_m < CLOSE_M
    assert [said for said in again.violations if "removed 0" not in said] == []
    assert "| 2 | 3 |" in "\n".join(report_flights(close, path, rows, 0, None))
    with pytest.raises(InputError, match="missions 0 to 0"):
        next(report_flights(close, path, rows, 1, None))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("missions", "campaign", "no list 'missions'"),
        ("[[2, ", "[[2.5, ", "whole numbers"),
        ("[2, ", "[99, ", "from 0 to 3"),
        ('"legs": [', '"legs": [[], ', "2 legs between 2 stops"),
        ('"legs": [\n   [[', '"legs": [\n   [[true, ', "5 values"),
    ],
)
def test_broken_flown_campaigns_are_refused(tmp_path, old, new, said):
    """A file of impulses that is not what it should be is refused with the place and the reason."""
    text = (
        '{"missions": [{"stops": [[2, 23595.0, 23600.0], [3, 23604.0, 23609.0]],\n'
        '  "legs": [\n   [[0.0, 1.0, 2.0, 3.0]]]}]}'
    )
    path = tmp_path / "flown.json"
    path.write_text(text)
    assert read_flown(path, 4)[0].flights[0].impulses_m_s.tolist() == [[1.0, 2.0, 3.0]]
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match=said):
        read_flown(path, 4)
