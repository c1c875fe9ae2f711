"""A small campaign for the tests of the shell: two chasers of two kinds on a tiny field."""

from __future__ import annotations

from functools import cache

import adr_opt
from adr_opt.plan.plan import Plan
from adr_opt.problem.chasers import AtStation, Chaser, InOrbit, Tank
from adr_opt.problem.instance import Instance

HOME, OWN = "tender", "kicker"
"""One starts at the station; the other in an orbit of its own, later, with a smaller tank."""


def campaign(dynamics: str = "two-body", eccentricity: float = 0.0) -> Instance:
    """A tiny field with the two."""
    field = adr_opt.generate("tiny", 2, targets=8)
    station, first = field.stations[0], field.targets[0].orbit
    own = station.orbit.replace(raan_deg=first.raan_deg + 0.2)
    return field.replace(
        dynamics=dynamics,
        targets=tuple(
            target.replace(orbit=target.orbit.replace(eccentricity=eccentricity))
            for target in field.targets
        ),
        chasers=(
            Chaser(name=HOME, start=AtStation(station=station.name), tank=Tank(delta_v_m_s=500.0)),
            Chaser(
                name=OWN,
                start=InOrbit(orbit=own),
                available_s=(7200.0, None),
                max_targets=3,
                tank=Tank(delta_v_m_s=400.0),
            ),
        ),
    )


@cache
def planned(dynamics: str = "two-body", eccentricity: float = 0.0) -> Plan:
    """A plan of it in which each of them flies, and the second one refuels."""
    plan = adr_opt.solve(campaign(dynamics, eccentricity), "exact", time_limit=60.0).plan
    assert plan is not None
    assert [route.chaser for route in plan.routes] == [HOME, OWN]
    assert all(route.legs for route in plan.routes)
    return plan
