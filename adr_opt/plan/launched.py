"""Launches into orbits as a plan makes them (docs/model.md section 5.5).

A chaser is launched when its first leg leaves, into the plane that has the target's node then.
From there on it is one that starts in an orbit of its own, and is flown, shown and exported so.
"""

from __future__ import annotations

import math

from ..kernels.orbits import ephemeris
from ..kernels.orbits.ephemeris import EPOCH_S
from ..problem.chasers import Chaser, InOrbit, LaunchedInto, TankByMass
from ..problem.instance import Instance
from .cargo import kits_of
from .plan import Leg, Plan


def as_launched(instance: Instance, plan: Plan | None) -> Instance:
    """An instance whose chasers start in the orbits that a plan has them launched into.

    It keeps its SHA-256, so that its plans are still those of it. Without launches into orbits, or
    a plan, it is the instance itself.
    """
    routes = {} if plan is None else {route.chaser: route.legs for route in plan.routes}
    chasers = tuple(
        _launched(instance, each, routes.get(each.name, ())) for each in instance.chasers
    )
    return instance if chasers == instance.chasers else instance.known_as(chasers)


def _launched(instance: Instance, chaser: Chaser, legs: tuple[Leg, ...]) -> Chaser:
    start = chaser.start
    if not isinstance(start, LaunchedInto) or not legs or legs[0].destination not in instance.names:
        return chaser
    rows, names = instance.orbits(), instance.names
    own, target = rows[names.index(chaser.name)], rows[names.index(legs[0].destination)]
    launch_s = legs[0].leaves_s
    node = float(ephemeris.node_at(target, launch_s))
    node -= float(ephemeris.node_rate_at(own, launch_s)) * launch_s
    latitude = float(ephemeris.latitude_at(target, EPOCH_S)) + math.pi
    orbit = start.orbit.replace(
        raan_deg=math.degrees(node) % 360.0, true_anomaly_deg=math.degrees(latitude) % 360.0
    )
    tank = chaser.tank
    if isinstance(tank, TankByMass) and chaser.most_kg < math.inf:
        kits_kg = chaser.kit_mass_kg * kits_of(instance, (leg.destination for leg in legs))
        first_kg = max(0.0, tank.first_kg(kits_kg, chaser.most_kg))
        tank = tank.replace(initial_propellant_kg=first_kg)
    return chaser.replace(start=InOrbit(orbit=orbit), tank=tank)
