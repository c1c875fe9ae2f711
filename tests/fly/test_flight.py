"""Plans flown in two-body motion by boinor."""

from __future__ import annotations

import json
import sys
from dataclasses import replace

import numpy as np
import pytest
from plans import unjudged, with_legs

import adr_opt
from adr_opt.common.constants import MU_M3_S2
from adr_opt.fly.flight import Flight, fly
from adr_opt.plan.plan import Leg, Plan
from adr_opt.problem.instance import Instance

boinor_bodies = pytest.importorskip("boinor.bodies")

WORST_MISS_M = 1e-3
WORST_SPEED_M_S = 1e-6


def solved(instance: Instance, method: str = "greedy-guarded") -> Plan:
    plan = adr_opt.solve(instance, method).plan
    assert plan is not None
    assert plan.legs
    return plan


@pytest.fixture(scope="module")
def tiny() -> Instance:
    return adr_opt.generate("tiny", 0)


@pytest.fixture(scope="module")
def plan(tiny: Instance) -> Plan:
    return solved(tiny)


def with_leg(plan: Plan, number: int, **changes: object) -> Plan:
    legs = list(plan.legs)
    legs[number - 1] = legs[number - 1].replace(**changes)
    return with_legs(plan, tuple(legs))


def with_burn(plan: Plan, number: int, burn: int, **changes: object) -> Plan:
    burns = list(plan.legs[number - 1].burns)
    burns[burn] = burns[burn].replace(**changes)
    return with_leg(plan, number, burns=tuple(burns))


def assert_flies(flight: Flight, legs: tuple[Leg, ...]) -> None:
    assert [leg.leg for leg in flight.legs] == list(range(1, len(legs) + 1))
    assert [leg.destination for leg in flight.legs] == [leg.destination for leg in legs]
    assert flight.worst_miss_m == max(leg.miss_m for leg in flight.legs)
    for flown in flight.legs:
        assert flown.miss_m < WORST_MISS_M, flown
        assert flown.relative_speed_m_s < WORST_SPEED_M_S, flown


def test_the_reference_library_has_the_same_constant() -> None:
    """The reference library has the model's gravitational parameter, else a miss says nothing."""
    from astropy import units

    assert boinor_bodies.Earth.k.to_value(units.m**3 / units.s**2) == pytest.approx(
        MU_M3_S2, rel=1e-15
    )


@pytest.mark.parametrize("method", ["greedy", "greedy-guarded"])
@pytest.mark.parametrize(("family", "seed"), [("tiny", 1), ("nominal", 0), ("reduced-fuel", 2)])
def test_plans_lead_to_the_stand_off(family: str, seed: int, method: str) -> None:
    """Every leg of a plan ends at the stand-off point, at rest relative to it."""
    instance = adr_opt.generate(family, seed)
    plan = solved(instance, method)
    flight = fly(instance, plan)
    assert_flies(flight, plan.legs)
    # Clohessy–Wiltshire is linear in L = 1 km: what it leaves out is about 0.39 L²/r.
    assert max(leg.arrival_miss_m for leg in flight.legs) < 0.06


def test_detours_around_zones_fly() -> None:
    """Keep-out zones change which sequence is chosen, not that it arrives."""
    instance = adr_opt.generate("tiny", 1, zones=4)
    plan = solved(instance)
    free = solved(instance.replace(keep_out_zones=()))
    assert plan.legs[0] != free.legs[0]
    assert_flies(fly(instance, plan), plan.legs)


def test_the_approach_does_not_hide_in_the_arrival(tiny: Instance, plan: Plan) -> None:
    """Without its first impulse the approach stays where it begins, L behind the target."""
    leg = plan.legs[0]
    approach = next(index for index, burn in enumerate(leg.burns) if burn.phase == "approach")
    flight = fly(tiny, unjudged(tiny, with_burn(plan, 1, approach, delta_v_m_s=(0.0, 0.0, 0.0))))
    assert flight.legs[0].miss_m < WORST_MISS_M
    assert flight.legs[0].arrival_miss_m == pytest.approx(tiny.transfer.standoff_m, rel=1e-3)


def test_an_empty_plan_misses_nothing(tiny: Instance, plan: Plan) -> None:
    """A plan without legs has no worst miss but zero."""
    flight = fly(tiny, unjudged(tiny, with_legs(plan, ())))
    assert replace(flight, violations=()) == Flight(0.0, ())


def test_a_tampered_burn_misses(tiny: Instance, plan: Plan) -> None:
    """A centimetre per second more in any one burn is seen, in the leg it belongs to alone."""
    honest = fly(tiny, plan)
    before = [burn for burn in plan.legs[1].burns if burn.phase != "approach"]
    for number, burn in enumerate(before):
        vector = np.array(burn.delta_v_m_s)
        longer = vector + 0.01 * vector / np.linalg.norm(vector)
        flight = fly(
            tiny, unjudged(tiny, with_burn(plan, 2, number, delta_v_m_s=tuple(longer.tolist())))
        )
        last = number == len(before) - 1  # it acts at the stand-off itself
        assert last or flight.legs[1].miss_m > 5.0, burn
        assert flight.legs[1].relative_speed_m_s > 1e-3, burn
        assert flight.legs[1].arrival_miss_m > 5.0, burn
        assert flight.legs[0] == honest.legs[0]


def test_a_tampered_time_misses(tiny: Instance, plan: Plan) -> None:
    """Burning a second late ends metres away, and not by less."""
    late = tuple(burn.replace(time_s=burn.time_s + 1.0) for burn in plan.legs[0].burns)
    tampered = with_leg(plan, 1, burns=late, arrival_s=plan.legs[0].arrival_s + 1.0)
    assert fly(tiny, unjudged(tiny, tampered)).worst_miss_m > 10.0


def test_a_docked_chaser_stays(tiny: Instance, plan: Plan) -> None:
    """After the last burn the chaser moves as the target does: an hour later it is still there."""
    flight = fly(tiny, unjudged(tiny, with_leg(plan, 1, arrival_s=plan.legs[0].arrival_s + 3600.0)))
    assert flight.legs[0].arrival_miss_m < 1.0


def test_flight_as_plain_data(tiny: Instance, plan: Plan) -> None:
    """``to_dict`` is JSON with the worst miss and one entry for each leg."""
    flight = fly(tiny, plan)
    told = json.loads(json.dumps(flight.to_dict(), allow_nan=False))
    assert told["worst_miss_m"] == flight.worst_miss_m
    assert len(told["legs"]) == len(plan.legs)
    assert set(told["legs"][0]) == {
        "leg",
        "origin",
        "destination",
        "kind",
        "planned_delta_v_m_s",
        "burns_delta_v_m_s",
        "miss_m",
        "relative_speed_m_s",
        "arrival_miss_m",
    }


@pytest.mark.parametrize("end", ["origin", "destination"])
def test_an_unknown_body_is_refused(tiny: Instance, plan: Plan, end: str) -> None:
    """A leg from or to a body that the instance has not is named."""
    with pytest.raises(adr_opt.InputError, match="leg 2: 'nowhere' is not a body"):
        fly(tiny, unjudged(tiny, with_leg(plan, 2, **{end: "nowhere"})))


def test_burns_that_cannot_be_flown_are_refused(tiny: Instance, plan: Plan) -> None:
    """Burns out of order, after the arrival or missing are named, not guessed at."""
    burns = plan.legs[0].burns
    with pytest.raises(adr_opt.InputError, match=r"leg 1: .*time order"):
        fly(tiny, unjudged(tiny, with_leg(plan, 1, burns=burns[::-1])))
    for missing in ((), burns[:-2]):
        with pytest.raises(adr_opt.InputError, match=r"leg 1: .*approach"):
            fly(tiny, unjudged(tiny, with_leg(plan, 1, burns=missing)))
    with pytest.raises(adr_opt.InputError, match=r"leg 1: arrival_s = .* before the last burn"):
        fly(tiny, unjudged(tiny, with_leg(plan, 1, arrival_s=plan.legs[0].arrival_s - 1.0)))


@pytest.mark.parametrize(
    "change",
    [{"delta_v_m_s": (1e5, 0.0, 0.0)}, {"delta_v_m_s": (1e9, -1e9, 1e9)}, {"time_s": -1e12}],
)
def test_burns_that_lead_nowhere_are_refused(
    tiny: Instance, plan: Plan, change: dict[str, object]
) -> None:
    """An escape, an overflow or an absurd time ends in one sentence, and ends."""
    with pytest.raises(adr_opt.InputError, match="leg 1: cannot be flown"):
        fly(tiny, unjudged(tiny, with_burn(plan, 1, 0, **change)))


def test_without_boinor_the_extra_is_named(
    tiny: Instance, plan: Plan, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A missing boinor is an error that says how to install it."""
    monkeypatch.setitem(sys.modules, "boinor.bodies", None)
    with pytest.raises(adr_opt.MissingExtra, match=r"boinor.*\[astro\]"):
        fly(tiny, plan)
