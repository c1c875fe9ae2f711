"""Plans in mean motion on the true orbits: what legs take there, and what tanks have left."""

from __future__ import annotations

import math
import sys
import time

import numpy as np
import pytest
from drifting_plans import drifting_instance, drifting_plan
from fields import eccentric
from plans import solved, unjudged, with_legs
from towed_fields import field

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M, J2, MU_M3_S2, OBLATENESS_M2
from adr_opt.fly.flight import fly
from adr_opt.fly.flight.mean_flight import fly_mean
from adr_opt.fly.flight.retargeted import true_state
from adr_opt.fly.refine import refine
from adr_opt.fly.trajectory import body_states
from adr_opt.kernels.orbits import mean_motion
from adr_opt.plan.plan import Plan
from adr_opt.problem.instance import Instance
from adr_opt.problem.orbit import Orbit

DAY_S = 86400.0

ELEMENTS = [
    (7.1e6, 0.0, 71.0),
    (7.2e6, 0.01, 86.4),
    (7.4e6, 0.08, 98.0),
    (9.0e6, 0.2, 20.0),
    (7.0e6, 0.02, 150.0),
    (7.1e6, 0.003, 0.0),
]


def orbit(a: float, e: float, i: float) -> Orbit:
    """An orbit of these elements and angles of no meaning."""
    return Orbit(
        semi_major_axis_m=a,
        eccentricity=e,
        inclination_deg=i,
        raan_deg=30.0,
        argument_of_perigee_deg=200.0,
        true_anomaly_deg=70.0,
    )


def averaged(a: float, e: float, inclination: float) -> tuple[float, float, float]:
    """Rates of node, perigee and mean anomaly: Lagrange's equations with J2 averaged numerically.

    The disturbing function is averaged over a revolution by quadrature and differentiated by
    differences, so that no closed form of a rate is used.
    """

    def potential(a: float, e: float, i: float) -> float:
        mean = np.linspace(0.0, math.tau, 512, endpoint=False)
        anomaly = mean.copy()
        for _ in range(60):
            anomaly -= (anomaly - e * np.sin(anomaly) - mean) / (1.0 - e * np.cos(anomaly))
        r = a * (1.0 - e * np.cos(anomaly))
        true = 2.0 * np.arctan2(
            math.sqrt(1.0 + e) * np.sin(anomaly / 2.0), math.sqrt(1.0 - e) * np.cos(anomaly / 2.0)
        )
        s = math.sin(i) * np.sin(true + 0.7)
        swing = -MU_M3_S2 / r * J2 * (EARTH_RADIUS_M / r) ** 2 * 0.5 * (3.0 * s * s - 1.0)
        return float(swing.mean())

    def slope(of: int) -> float:
        at, step = [a, e, inclination], (1e-5 * a, 1e-5, 1e-5)[of]
        ends = []
        for sign in (1.0, -1.0):
            moved = list(at)
            moved[of] += sign * step
            ends.append(potential(*moved))
        return (ends[0] - ends[1]) / (2.0 * step)

    n, root = math.sqrt(MU_M3_S2 / a**3), math.sqrt(1.0 - e * e)
    by_i = slope(2)
    node = by_i / (n * a * a * root * math.sin(inclination))
    perigee = root / (n * a * a * e) * slope(1) - node * math.cos(inclination)
    anomaly = n - root * root / (n * a * a * e) * slope(1) - 2.0 / (n * a) * slope(0)
    return node, perigee, anomaly


def angles(state: np.ndarray) -> tuple[float, float, float]:
    """RAAN, argument of perigee and mean anomaly of a state [rad]."""
    r, v = state[:3], state[3:]
    h = np.cross(r, v)
    node = math.atan2(h[0], -h[1])
    towards = np.array([math.cos(node), math.sin(node), 0.0])
    ahead = np.cross(h / np.linalg.norm(h), towards)
    vector = np.cross(v, h) / MU_M3_S2 - r / np.linalg.norm(r)
    perigee = math.atan2(vector @ ahead, vector @ towards)
    e = np.linalg.norm(vector)
    true = math.atan2(r @ ahead, r @ towards) - perigee
    anomaly = 2.0 * math.atan2(
        math.sqrt(1.0 - e) * math.sin(true / 2.0), math.sqrt(1.0 + e) * math.cos(true / 2.0)
    )
    return node, perigee, anomaly - e * math.sin(anomaly)


@pytest.mark.parametrize("elements", [each for each in ELEMENTS if each[1] > 0.0 and each[2] > 0.0])
def test_coasts_have_the_rates_of_the_averaged_potential(elements: tuple[float, ...]) -> None:
    """In ten days node, perigee and anomaly advance as the potential averaged by sums has them."""
    state, span = true_state(orbit(*elements), OBLATENESS_M2, 0.0), 10.0 * DAY_S
    before = angles(state)
    mean_motion.coast(state, span, OBLATENESS_M2)
    rates = averaged(elements[0], elements[1], math.radians(elements[2]))
    for old, new, rate in zip(before, angles(state), rates, strict=True):
        assert math.remainder(new - old - rate * span, math.tau) == pytest.approx(0.0, abs=2e-5)


@pytest.mark.parametrize("elements", ELEMENTS)
@pytest.mark.parametrize("oblateness", [0.0, OBLATENESS_M2])
def test_a_body_left_to_itself_stays_where_it_is_said_to_be(
    elements: tuple[float, ...], oblateness: float
) -> None:
    """A coast of a year from a body's mean state ends at the body, to a centimetre."""
    its = orbit(*elements)
    state = true_state(its, oblateness, 0.0)
    mean_motion.coast(state, 365.0 * DAY_S, oblateness)
    assert math.dist(state[:3], true_state(its, oblateness, 365.0 * DAY_S)[:3]) < 0.01


def test_bodies_are_where_exports_have_them() -> None:
    """True states are those that export writes of the same bodies, by another formula."""
    instance = eccentric(adr_opt.generate("rocket-bodies", 0, targets=4), 0.1, 3)
    for target in instance.targets:
        for time_s in (0.0, 1e6, 3e7):
            states = body_states(instance, target.name, time_s, true_orbits=True)
            state = true_state(target.orbit, instance.oblateness_m2, time_s)
            assert math.dist(state[:3], states[0][0]) < 0.05
            assert math.dist(state[3:], states[1][0]) < 5e-5


CIRCLES = ("two-body", "j2", "towed", "drifting")


def circular(which: str) -> tuple[Instance, Plan]:
    """A plan between circles."""
    if which == "drifting":
        return drifting_instance(), drifting_plan()
    instance = field("j2", 1) if which == "towed" else adr_opt.generate("tiny", 0)
    instance = instance if which == "towed" else instance.replace(dynamics=which)
    return instance, solved(instance)


@pytest.mark.parametrize("which", CIRCLES)
def test_between_circles_it_is_the_flight_of_the_independent_library(which: str) -> None:
    """Where no orbit is eccentric tanks have what `fly` says: the burns of the plan."""
    pytest.importorskip("boinor")
    instance, plan = circular(which)
    found = fly_mean(instance, plan)
    assert found is not None
    assert found.tanks == fly(instance, plan).tanks
    drifts = [leg for leg in plan.legs if leg.kind == "drift"]
    for number, leg in enumerate(plan.legs, start=1):
        assert found.flown[number] == pytest.approx(leg.burns_delta_v_m_s, abs=1e-6)
    assert (which == "drifting") == bool(drifts)


def test_nearly_circles_take_nearly_the_same() -> None:
    """As eccentricities vanish legs take what they take between circles, to decimetres a second."""
    instance, plan = drifting_instance(), drifting_plan()
    nearly = instance.replace(
        targets=tuple(
            target.replace(orbit=target.orbit.replace(eccentricity=1e-9))
            for target in instance.targets
        )
    )
    same = plan.replace(instance=plan.instance.replace(sha256=nearly.sha256))
    circles, found = fly_mean(instance, plan), fly_mean(nearly, same)
    assert circles is not None
    assert found is not None
    for number in circles.flown:
        assert found.flown[number] != circles.flown[number]
        assert found.flown[number] == pytest.approx(circles.flown[number], abs=0.5)


ECCENTRIC = ("two-body", "j2", "towed two-body", "towed j2", "drifting")


def uneven(which: str) -> tuple[Instance, Plan]:
    """A plan between eccentric orbits."""
    if which == "drifting":
        return drifting_instance(0.003), drifting_plan(0.003)
    dynamics = which.split()[-1]
    instance = field(dynamics, 1) if "towed" in which else adr_opt.generate("tiny", 4)
    instance = eccentric(instance.replace(dynamics=dynamics), 0.012, 3)
    return instance, solved(instance)


@pytest.mark.parametrize("which", ECCENTRIC)
def test_legs_take_what_they_take_in_integrated_motion(which: str) -> None:
    """The plan's burns take what `refine` finds for them in the field itself, leg by leg.

    In two-body motion that is the same motion, integrated; under J2 its short periods come in.
    """
    instance, plan = uneven(which)
    assert len(plan.legs) >= 2
    found, refined = fly_mean(instance, plan), refine(instance, plan, freedom="planned", jobs=1)
    assert found is not None
    assert not found.problems
    assert refined.status == "complete"
    apart = [
        abs(found.flown[leg.leg] - leg.flown_delta_v_m_s) / max(leg.flown_delta_v_m_s, 50.0)
        for leg in refined.legs
    ]
    assert max(apart) < (1e-5 if instance.dynamics == "two-body" else 0.02)
    total = sum(flown or 0.0 for flown in found.flown.values())
    burnt = sum(leg.flown_delta_v_m_s for leg in refined.legs)
    assert total == pytest.approx(burnt, rel=1e-5 if instance.dynamics == "two-body" else 3e-3)
    assert total != pytest.approx(sum(leg.delta_v_m_s for leg in plan.legs), rel=1e-4)


def test_months_of_drift_between_eccentric_orbits_are_flown_in_a_moment() -> None:
    """A year among rocket bodies on eccentric orbits: every leg arrives, in some 0.1 s or less."""
    instance = eccentric(adr_opt.generate("rocket-bodies", 0), 0.015, seed=1)
    plan = solved(instance)
    assert sum(leg.kind == "drift" for leg in plan.legs) >= 5
    fly_mean(instance, plan)  # compiles
    began = time.process_time()
    found = fly_mean(instance, plan)
    assert time.process_time() - began < 0.2 * len(plan.legs)
    assert found is not None
    assert not found.problems
    total = sum(flown or 0.0 for flown in found.flown.values())
    assert total == pytest.approx(sum(leg.delta_v_m_s for leg in plan.legs), rel=0.05)


def test_a_leg_that_does_not_arrive_leaves_its_tank_unknown() -> None:
    """A burn that is off by a hundredth of a per cent is found out between circles, and said."""
    instance, plan = drifting_instance(), drifting_plan()
    short, drift = plan.legs
    vector = tuple(1.0001 * part for part in drift.burns[0].delta_v_m_s)
    burns = (drift.burns[0].replace(delta_v_m_s=vector), *drift.burns[1:])
    found = fly_mean(
        instance, unjudged(instance, with_legs(plan, (short, drift.replace(burns=burns))))
    )
    assert found is not None
    assert found.flown[1] is not None
    assert found.flown[2] is None
    assert not found.holds
    assert "leg 2: its burns miss the stand-off by" in str(found)
    assert "left in the tank: unknown" in str(found)


def test_the_families_add_up() -> None:
    """Short legs, drifts and tows are told apart, and together they are what the tanks gave."""
    for instance, plan in (uneven("towed j2"), uneven("drifting")):
        found = fly_mean(instance, plan)
        assert found is not None
        families = {family.family: family for family in found.record.families}
        tows = [leg.tow for leg in plan.legs if leg.tow is not None]
        kinds = [leg.kind for leg in plan.legs]
        assert families.keys() == {*kinds, *(["tow"] if tows else [])}
        assert [families[kind].legs for kind in dict.fromkeys(kinds)] == [
            kinds.count(kind) for kind in dict.fromkeys(kinds)
        ]
        flown = sum(family.flown_delta_v_m_s for family in families.values())
        assert flown == pytest.approx(sum(tank.flown_delta_v_m_s for tank in found.tanks))
        planned = sum(family.planned_delta_v_m_s for family in families.values())
        assert planned == pytest.approx(plan.delta_v_m_s)
        left = [tank.left_m_s for tank in found.record.tanks]
        assert left == [-tank.over_m_s for tank in found.tanks]


def test_it_asks_for_no_optional_package(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without boinor and astropy `fly` cannot, and the flight in mean motion goes on."""
    for name in ("boinor", "boinor.bodies", "astropy", "sgp4"):
        monkeypatch.setitem(sys.modules, name, None)
    instance, plan = uneven("drifting")
    with pytest.raises(adr_opt.InputError, match="boinor"):
        fly(instance, plan)
    found = fly_mean(instance, plan)
    assert found is not None
    assert not found.problems


def test_it_can_be_stopped_between_legs() -> None:
    """A flight that is interrupted gives no result, rather than half of one."""
    instance, plan = uneven("drifting")
    asked: list[bool] = []

    def enough() -> bool:
        asked.append(True)
        return len(asked) > 1

    assert fly_mean(instance, plan, enough) is None
    assert len(asked) == 2


@pytest.mark.parametrize("elements", ELEMENTS)
def test_derivatives_are_good_for_years(elements: tuple[float, ...]) -> None:
    """A later beginning means a later end: in the derivative of a coast of years, too.

    Of what a change of place and one of velocity do to the phase by then, all but a hundred
    thousandth cancels.
    """
    span = 730.0 * DAY_S
    start = true_state(orbit(*elements), OBLATENESS_M2, 0.0)

    def rate(state: np.ndarray) -> np.ndarray:
        ends = []
        for moment in (0.05, -0.05):
            moved = state.copy()
            mean_motion.coast(moved, moment, OBLATENESS_M2)
            ends.append(moved)
        return (ends[0] - ends[1]) / 0.1

    end = start.copy()
    mean_motion.coast(end, span, OBLATENESS_M2)
    carried = mean_motion.derivative(start, span, OBLATENESS_M2) @ rate(start)
    off = carried - rate(end)
    assert np.linalg.norm(off[:3]) < 0.02 * np.linalg.norm(end[3:])


@pytest.mark.parametrize("which", ["two-body", "j2"])
def test_burns_of_no_sense_are_said_and_nothing_breaks(which: str) -> None:
    """With a burn away from the Earth, or an approach alone, a leg is said not to arrive."""
    instance, plan = uneven(which)
    leg = plan.legs[0]
    away = leg.burns[0].replace(delta_v_m_s=(2e4, 2e4, 2e4))
    approach = tuple(burn for burn in leg.burns if burn.phase == "approach")
    for burns in ((away, *leg.burns[1:]), approach):
        found = fly_mean(
            instance,
            unjudged(instance, with_legs(plan, (leg.replace(burns=burns), *plan.legs[1:]))),
        )
        assert found is not None
        assert found.flown[1] is None
        assert found.problems[1]
        assert found.flown[2] is not None
        assert not found.holds


def test_a_plan_without_legs_uses_no_tank() -> None:
    """Nothing is flown, and that is said."""
    instance, plan = drifting_instance(), drifting_plan()
    found = fly_mean(instance, unjudged(instance, with_legs(plan, ())))
    assert found is not None
    assert found.holds
    assert str(found) == "flown in mean motion under J2: no legs; no tank is used"
