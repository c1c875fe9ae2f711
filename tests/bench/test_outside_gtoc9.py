"""The closed form of long transfers against legs that others flew, and the rules of GTOC9."""

from __future__ import annotations

import numpy as np
import pytest
from from_outside import BENCH, DATA, arrived, external
from outside.gtoc9.campaign import Removals, Stop, read_campaign
from outside.gtoc9.debris import read_debris
from outside.gtoc9.ephemeris import read_ephemeris
from outside.gtoc9.estimate import legs_m_s
from outside.gtoc9.expense import expense_meur, launched_kg, propellant_kg
from outside.gtoc9.flown import Flight, FlownMission, read_flown
from outside.gtoc9.judging import CLOSE_M, CLOSE_M_S, judged
from outside.gtoc9.legs import read_legs
from outside.gtoc9.scoring import score

from adr_opt.common.constants import DAY_S

FOLDER = DATA / "gtoc9"
DEBRIS, WINNER = FOLDER / "debris_data.txt", FOLDER / "jpl_solution.json"

pytestmark = external("gtoc9")


@pytest.fixture(scope="module")
def rows():
    return read_debris(DEBRIS)


@pytest.fixture(scope="module")
def winner():
    return read_campaign(WINNER)


def test_the_winning_legs_cost_what_the_closed_form_says():
    """Legs of more than three days are met within 2 % in total and 4 % in the mean.

    Shorter ones are published to 0.01 d only, most of a revolution, so that their phase is unknown.
    """
    legs = read_legs(FOLDER)
    assert len(legs) == 113
    long = [leg for leg in legs if leg.days > 3.0]
    assert len(long) == 94
    flown = np.array([leg.flown for leg in long])
    planned = np.array([leg.closed_form for leg in long])
    assert abs(planned.sum() / flown.sum() - 1.0) <= 0.02
    assert np.abs(planned / flown - 1.0).mean() <= 0.04


def test_the_winner_has_its_published_cost(rows, winner):
    """With the ΔV as flown J is the published 731.28, which paid a little less for each launch."""
    found = score(winner, [mission.flown_m_s for mission in winner], len(rows), slack_d=0.2)
    assert found.total_meur == pytest.approx(731.2756, abs=0.25)
    assert found.violations == ()


def test_the_estimate_of_the_winner_is_near_its_cost(rows, winner):
    """By the estimate at its own times the winner has J of 728, with all rules kept."""
    found = score(winner, [legs_m_s(mission, rows) for mission in winner], len(rows), slack_d=0.2)
    assert found.total_meur == pytest.approx(728.0, abs=1.0)
    assert found.violations == ()


def test_our_best_campaign_keeps_all_rules(rows):
    """The campaign that is kept removes all debris by the rules, for a J by the estimate of 619."""
    ours = read_campaign(BENCH / "outside" / "gtoc9" / "best.json")
    found = score(ours, [legs_m_s(mission, rows) for mission in ours], len(rows))
    assert found.total_meur == pytest.approx(618.946, abs=0.01)
    assert found.violations == ()


@pytest.fixture(scope="module")
def flown(rows):
    return read_flown(BENCH / "outside" / "gtoc9" / "flown.json", len(rows))


def test_our_flown_campaign_keeps_all_rules(flown):
    """All impulses of the campaign that is kept lead to their debris by the rules; J is 620.5."""
    found = judged(flown, read_ephemeris(DEBRIS))
    assert found.violations == ()
    assert found.score.total_meur == pytest.approx(620.46, abs=0.01)
    assert max(leg.miss_m for legs in found.legs for leg in legs) < 1.0


def test_a_leg_of_our_flown_campaign_arrives_by_scipy(flown):
    """The first leg of one to four days ends at its debris also where SciPy flies it."""
    debris = read_ephemeris(DEBRIS)
    for mission in flown:
        stops = mission.removals.stops
        for one, other, flight in zip(stops[:-1], stops[1:], mission.flights, strict=True):
            if 1.0 <= other.arrival_d - one.departure_d < 4.0:
                ends = debris[one.debris], debris[other.debris]
                off = arrived(*ends, one.departure_d, other.arrival_d, *flight)
                assert off[0] < CLOSE_M
                assert off[1] < CLOSE_M_S
                return
    raise AssertionError("no such leg")


def test_mass_is_counted_backwards():
    """One leg of a kilometre a second and two kits weigh what the rocket equation says."""
    grown = 2030.0 * np.exp(1000.0 / (340.0 * 9.80665))
    assert launched_kg([1000.0]) == pytest.approx(grown + 30.0)
    assert propellant_kg([1000.0]) == pytest.approx(grown - 2030.0)
    assert launched_kg([]) == 2030.0
    assert expense_meur(2100.0) == pytest.approx(55.0 + 2e-6 * 100.0**2)


def shifted(stops, days):
    return tuple(Stop(stop.debris, stop[1] + days, stop[2] + days) for stop in stops)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda stops: stops[:-1], "removed 0 times"),
        (lambda stops: (Stop(23, 23557.18, 23561.58), *stops[1:]), "4.4"),
        (lambda stops: (Stop(23, 23548.18, 23562.18), *stops[1:]), "38.8"),
        (lambda stops: tuple(stop._replace(debris=0) for stop in stops), "debris 0: removed"),
        (lambda stops: shifted(stops, 9.0), "the one before"),
        (lambda stops: shifted(stops, -99.0), "from 23458"),
    ],
)
def test_broken_rules_are_named(rows, winner, change, said):
    """A first mission that breaks a rule is told by a sentence about that rule."""
    stops = change(winner[0].stops)
    spoilt = (Removals(stops), *winner[1:])
    found = score(spoilt, [legs_m_s(mission, rows) for mission in spoilt], len(rows), slack_d=0.2)
    assert any(said in sentence for sentence in found.violations), found.violations


def test_too_much_propellant_is_named(rows, winner):
    """A mission whose legs need more than 5000 kg is told."""
    dear = [tuple(9.0 * leg for leg in mission.flown_m_s) for mission in winner]
    found = score(winner, dear, len(rows), slack_d=0.2)
    assert any("kg of propellant" in said for said in found.violations)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda times, impulses: (times, 1.01 * impulses), "off on arrival"),
        (lambda times, impulses: (times[::-1], impulses[::-1]), "out of order"),
        (lambda times, impulses: (times + 30.0 * DAY_S, impulses), "outside of the leg"),
        (lambda times, impulses: (np.repeat(times, 2), np.repeat(0.5 * impulses, 2, 0)), "0 imp"),
        (lambda times, impulses: (times[:1], np.full((1, 3), 9e3)), "a perigee of"),
    ],
)
def test_flown_legs_that_break_a_rule_are_named(flown, change, said):
    """A leg with other impulses than lead to its debris, or with too many, is told."""
    debris = read_ephemeris(DEBRIS)
    stops, flights = flown[0].removals.stops, flown[0].flights
    at = next(at for at, flight in enumerate(flights) if len(flight.times_s) == 5)
    two, flight = Removals(stops[at : at + 2]), flights[at]

    def told(one: Flight) -> list[str]:
        found = judged([FlownMission(two, (one,))], debris)
        return [sentence for sentence in found.violations if "removed 0" not in sentence]

    assert told(flight) == []
    bad = told(Flight(*change(flight.times_s.copy(), flight.impulses_m_s.copy())))
    assert any(said in sentence for sentence in bad), bad
