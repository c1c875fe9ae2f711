"""Small missions under J2 with one short leg and one that drifts, planned within a second."""

from __future__ import annotations

from datetime import UTC, datetime
from functools import cache

from plans import with_legs

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M
from adr_opt.plan.plan import Plan
from adr_opt.problem.bodies import Target
from adr_opt.problem.chasers import Chaser, InOrbit, Tank
from adr_opt.problem.instance import Instance
from adr_opt.problem.orbit import Orbit
from adr_opt.problem.settings import MissionSettings, TransferSettings

DAY_S = 86400.0


def orbit(altitude_km: float, inclination_deg: float, raan_deg: float, **more: float) -> Orbit:
    """An orbit of these elements, a circle unless told otherwise."""
    angles = {"argument_of_perigee_deg": 0.0, "true_anomaly_deg": 0.0}
    return Orbit(
        semi_major_axis_m=EARTH_RADIUS_M + 1e3 * altitude_km,
        inclination_deg=inclination_deg,
        raan_deg=raan_deg,
        **({"eccentricity": 0.0} | angles | more),
    )


@cache
def drifting_instance(eccentricity: float = 0.0) -> Instance:
    """Sixty days at 71°: a neighbour that closes soon, one to drift to, and one out of reach."""
    near = orbit(840, 71.0, 10.5, eccentricity=eccentricity, argument_of_perigee_deg=20.0)
    far = orbit(760, 71.05, 18.0, eccentricity=eccentricity, true_anomaly_deg=200.0)
    return Instance(
        name="drifting",
        epoch=datetime(2026, 1, 1, tzinfo=UTC),
        dynamics="j2",
        stations=(),
        targets=(
            Target(name="near", orbit=near, window_s=(0.0, 3.0 * DAY_S)),
            Target(name="far", orbit=far),
            Target(name="away", orbit=orbit(845, 70.95, 170.0)),
        ),
        chasers=(
            Chaser(
                name="chaser",
                start=InOrbit(orbit=orbit(838, 71.0, 10.0)),
                tank=Tank(delta_v_m_s=600.0),
            ),
        ),
        mission=MissionSettings(duration_s=60.0 * DAY_S, service_s=DAY_S),
        transfer=TransferSettings(
            departure_spacing_s=DAY_S,
            drift_step_s=5.0 * DAY_S,
            max_drift_s=60.0 * DAY_S,
            delta_v_resolution_m_s=2.0,
        ),
    )


@cache
def drifting_plan(eccentricity: float = 0.0) -> Plan:
    """A plan of that mission: a short leg to the neighbour, then a drift of weeks."""
    instance = drifting_instance(eccentricity)
    plan = adr_opt.solve(instance, "beam", width=200, time_value_m_s_per_h=0.2).plan
    assert plan is not None
    assert adr_opt.check(instance, plan) == ()
    assert [(leg.kind, leg.destination) for leg in plan.legs] == [
        ("short", "near"),
        ("drift", "far"),
    ]
    return plan


@cache
def with_a_tight_tank() -> tuple[Instance, Plan]:
    """The mission and its plan with a tank between what the plan counts with and what it burns."""
    instance, plan = drifting_instance(), drifting_plan()
    burned = sum(leg.burns_delta_v_m_s for leg in plan.legs)
    assert burned > plan.delta_v_m_s + 0.05
    tight = instance.with_limits(delta_v_m_s=0.5 * (plan.delta_v_m_s + burned))
    less = instance.chaser.tank.delta_v_m_s - tight.chaser.tank.delta_v_m_s
    legs = [leg.replace(delta_v_left_m_s=leg.delta_v_left_m_s - less) for leg in plan.legs]
    plan = with_legs(plan, legs, instance=plan.instance.replace(sha256=tight.sha256))
    assert adr_opt.check(tight, plan) == ()
    return tight, plan
