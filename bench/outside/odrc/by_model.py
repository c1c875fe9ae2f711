"""`odrc` with legs of low thrust of the model, flown; and the published plan by the model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import NamedTuple

import numpy as np

import adr_opt
from adr_opt.fly.flight import fly_refined
from adr_opt.kernels.legs import low_thrust, low_thrust_windows
from adr_opt.kernels.legs.low_thrust_arcs import Thrust
from adr_opt.problem.bodies import Target
from adr_opt.problem.chasers import Chaser, InOrbit, TankByMass
from adr_opt.problem.drives import since_j2000_s
from adr_opt.problem.instance import Instance
from adr_opt.problem.orbit import Orbit
from adr_opt.problem.settings import MissionSettings, TransferSettings

from ..reading import FloatArray
from .estimate import THRUST_M_S2, matrices
from .ours import NAME
from .scoring import LOAD, LONGEST_S, MOST_M_S, Route

EPOCH = datetime(2026, 1, 1, tzinfo=UTC)
"""Of the data nothing is known; it only decides where the Sun is."""

STEPS = 73
"""Number of steps of the year."""

DRY_KG, ISP_S = 500.0, 1e5
"""A specific impulse with which the mass hardly changes: the source's acceleration is constant."""


class PlannedLeg(NamedTuple):
    """A leg of a plan on legs of the model.

    Attributes
    ----------
    origin, destination : str
    estimate_m_s, planned_m_s, flown_m_s : float
        By the source's estimate, the closed form, and integrated; NaN if it was not refined.
    missed_m : float
        Larger miss at the stand-off and the arrival, as the second integrator finds it.
    """

    origin: str
    destination: str
    estimate_m_s: float
    planned_m_s: float
    flown_m_s: float
    missed_m: float


class ByModel(NamedTuple):
    """A plan on legs of the model.

    Attributes
    ----------
    total_m_s : float
        Its cost, with the time that decides between equals.
    legs : list of PlannedLeg
    violations : int
        Found by ``check``.
    """

    total_m_s: float
    legs: list[PlannedLeg]
    violations: int


def orbit_of(row: FloatArray) -> Orbit:
    """The orbit of a body as read."""
    axis, eccentricity, *angles = (float(value) for value in row)
    inclination, raan, perigee, anomaly = (math.degrees(angle) for angle in angles)
    return Orbit(
        semi_major_axis_m=axis,
        eccentricity=eccentricity,
        inclination_deg=inclination,
        raan_deg=raan % 360.0,
        argument_of_perigee_deg=perigee % 360.0,
        true_anomaly_deg=anomaly % 360.0,
    )


def instance_of(bodies: FloatArray, chasers: int, steps: int = STEPS) -> Instance:
    """The campaign: all debris within the year, from the centroid, at the source's acceleration."""
    propellant_kg = DRY_KG * math.expm1(MOST_M_S / (ISP_S * 9.80665))
    tank = TankByMass(dry_mass_kg=DRY_KG, propellant_kg=propellant_kg, isp_s=ISP_S)
    step_s = LONGEST_S / steps
    return Instance(
        name=NAME,
        epoch=EPOCH,
        dynamics="j2",
        stations=(),
        targets=tuple(
            Target(name=f"debris-{number:02d}", orbit=orbit_of(row), required=True)
            for number, row in enumerate(bodies[1:])
        ),
        chasers=tuple(
            Chaser(
                name=f"chaser-{number + 1}",
                start=InOrbit(orbit=orbit_of(bodies[0])),
                tank=tank,
                max_targets=LOAD,
                thrust_n=THRUST_M_S2 * (DRY_KG + propellant_kg),
            )
            for number in range(chasers)
        ),
        mission=MissionSettings(duration_s=LONGEST_S, service_s=0.0, refuel_revolutions=0.0),
        transfer=TransferSettings(
            max_drift_s=LONGEST_S,
            drift_step_s=step_s,
            departure_spacing_s=step_s,
            delta_v_resolution_m_s=20.0,
        ),
    )


def plan(bodies: FloatArray, chasers: int, time_limit_s: float, steps: int = STEPS) -> ByModel:
    """Plan with legs of the model, check the plan, refine its legs, and fly them."""
    instance = instance_of(bodies, chasers, steps)
    made = adr_opt.solve(instance, time_limit=time_limit_s).plan
    if made is None:
        return ByModel(math.nan, [], 0)
    refined = adr_opt.refine(instance, made)
    flown = {leg.leg: leg for leg in fly_refined(instance, refined).legs}
    _, estimates = matrices(bodies, np.array([leg.departure_s for leg in made.legs]))
    row = {target.name: body for body, target in enumerate(instance.targets, start=1)}
    legs = []
    for number, leg in enumerate(made.legs, 1):
        found = flown.get(number)
        legs.append(
            PlannedLeg(
                leg.origin,
                leg.destination,
                float(estimates[number - 1, row.get(leg.origin, 0), row[leg.destination]]),
                leg.delta_v_m_s,
                math.nan if found is None else found.flown_delta_v_m_s,
                math.nan if found is None else max(found.standoff_miss_m, found.arrival_miss_m),
            )
        )
    return ByModel(made.cost, legs, len(adr_opt.check(instance, made)))


def priced(bodies: FloatArray, routes: Sequence[Route]) -> list[tuple[float, float]]:
    """Legs of routes by the source's estimate, and by the model [m/s].

    By the model they may take until the next departure, or the end of the year; infinite where it
    has no leg in that time.
    """
    instance = instance_of(bodies, 1)
    rows = np.array([orbit_of(row).row(instance.oblateness_m2) for row in bodies])
    rule, thrust = instance.transfer_rule(), Thrust(THRUST_M_S2, ISP_S * 9.80665)
    found = []
    for route in routes:
        _, delta_v = matrices(bodies, np.array(route.departures_s))
        here, ends = 0, (*route.departures_s[1:], LONGEST_S)
        for leg, (one, departure) in enumerate(zip(*route, strict=True)):
            there = one + 1
            pair = low_thrust_windows.prepare(
                rows[here], rows[there], rule, since_j2000_s(EPOCH), 0.0
            )
            cost = float(low_thrust.delta_v(pair, thrust, departure, ends[leg]))
            found.append((float(delta_v[leg, here, there]), cost))
            here = there
    return found
