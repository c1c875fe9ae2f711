"""Refined plans with all forces: agreement, time, misses and corrections."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any
from unittest.mock import patch

import numpy as np
from fields import planned
from tables import head, row, timed

import adr_opt
from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, MU_M3_S2
from adr_opt.common.processors import usable_cores
from adr_opt.fly.flight.refined import planned_legs
from adr_opt.fly.forces import Forces, fly_forced, library
from adr_opt.fly.forces.flown import fly_leg, plan_field
from adr_opt.fly.forces.library import Moving, World
from adr_opt.fly.forces.settings import WEATHER
from adr_opt.plan.refined_plan import Missing, RefinedPlan
from adr_opt.problem.instance import Instance

WEEK_S = 7.0 * DAY_S

Field = tuple[Instance, RefinedPlan]


def refined(instance: Instance) -> RefinedPlan:
    """A plan of a field, refined with its own burns."""
    plan = planned(instance)
    return adr_opt.refine(instance, plan, freedom="planned", jobs=usable_cores())


def week_fields(count: int) -> Iterator[Field]:
    """Fields with the legs of a week of their plans, until there are enough."""
    seed = 0
    while count > 0:
        field = adr_opt.generate("sso", seed)
        grid = {"drift_step_s": WEEK_S, "max_drift_s": WEEK_S, "departure_spacing_s": DAY_S}
        instance = field.replace(transfer=field.transfer.replace(**grid))
        plan = refined(instance)
        long = (leg for leg in plan.legs if leg.standoff_s - leg.states[0].time_s > 0.9 * WEEK_S)
        legs = tuple(long)[:count]
        others = sorted({leg.leg for leg in plan.legs} - {leg.leg for leg in legs})
        missing = (*plan.missing, *(Missing(leg=leg, reason="short") for leg in others))
        yield instance, plan.replace(legs=legs, missing=missing, status="incomplete")
        count, seed = count - len(legs), seed + 1


def forces(legs: int = 30) -> None:
    """Refined plans with all forces: agreement, time, misses and corrections.

    Fields of the family ``sso``, on a grid of weeks, are planned and refined with the plans' own
    burns. Of their legs those that last a week are flown, and the short ones of a nominal field.
    First with all forces off, by which the integrator of the library is compared with that of
    ``fly``; then with all forces, by the activity of the Sun, with time and processor time. Then
    what the settings of the library leave out over a week.
    """
    nominal = adr_opt.generate("nominal", 0).replace(dynamics="j2")
    cases = {"a week": list(week_fields(legs)), "hours": [(nominal, refined(nominal))]}
    head("legs of", "legs", "median apart", "worst apart", "m")
    for name, fields in cases.items():
        _agreement(name, fields)
    head(
        *("legs of", "activity", "legs", "burns", "off plan: median, worst", "corrections"),
        *("in all", "off body: median, worst", "corrections", "in all", "no correction, lost"),
        *("tanks broken", "time", "processor time"),
    )
    for name, fields in cases.items():
        for activity in WEATHER:
            _forced(name, fields, activity)
    _settings()


def _agreement(name: str, fields: list[Field]) -> None:
    """Print how far legs are from their stand-offs with all forces off."""
    apart = []
    for instance, plan in fields:
        world, field = plan_field(instance, plan.gravity)
        for leg in planned_legs(instance, plan):
            off = fly_leg(world, field, leg, instance.transfer.standoff_m).planned_body
            apart += [] if off is None else [off.distance_m]
    listed = ", ".join(f"{one:.2f}" for one in apart[:30])
    row(name, len(apart), f"{np.median(apart):.3f} m", f"{max(apart):.3f} m", listed)


def _forced(name: str, fields: list[Field], activity: str) -> None:
    """Print misses and corrections at an activity of the Sun."""
    flights, wall, cpu = timed(
        lambda: [fly_forced(*field, Forces(activity=activity)) for field in fields]
    )
    legs = [leg for flight in flights for leg in flight.legs]
    cells = list[str]()
    for kind in ("planned_body", "flown_body"):
        offs = [off for leg in legs if (off := getattr(leg, kind)) is not None]
        far = [1e-3 * off.distance_m for off in offs]
        costs = [off.correction_m_s for off in offs if off.correction_m_s is not None]
        cells += [
            f"{np.median(far):.2f}, {max(far):.1f} km",
            f"{np.median(costs):.2f}, {max(costs):.2f} m/s",
            f"{math.fsum(costs):.1f} m/s",
        ]
    none = [f"{leg.leg}" + (" lost" if leg.lost else "") for leg in legs if not leg.is_corrected]
    row(
        name,
        activity,
        len(legs),
        f"{math.fsum(flight.flown_delta_v_m_s for flight in flights):.0f} m/s",
        *cells,
        ", ".join(none) or "none",
        sum(len(flight.broken_tanks) for flight in flights),
        f"{wall:.1f} s",
        f"{cpu:.1f} s",
    )


class Order12(World):
    """Motion by the library's method of order 12, in steps of its choice."""

    def integration(self, step_s: float) -> Any:
        """Method and tolerances."""
        import brahe

        return brahe.NumericalPropagationConfig(
            brahe.IntegrationMethod.RKN1210,
            brahe.IntegratorConfig(abs_tol=1e-6, rel_tol=1e-13),
            brahe.VariationalConfig(),
        )


def week(settings: Forces, kind: type[World] = World, steps: int = library.STEPS) -> Any:
    """State after a week with all forces on a circle."""
    instance = adr_opt.generate("nominal", 0)
    radius = EARTH_RADIUS_M + 780e3
    speed = math.sqrt(MU_M3_S2 / radius)
    angle = math.radians(86.4)
    state = np.array([radius, 0, 0, 0, speed * math.cos(angle), speed * math.sin(angle)])
    world = kind.of(instance)
    forces = world.all_forces(settings, settings.area_mass_m2_kg)
    return world.coast([Moving(state, forces, steps=steps)], 0.0, WEEK_S)[0]


def _settings() -> None:
    """Print what a week differs by with other settings, and with single forces off."""
    head("a week at 780 km with", "ends off by")
    usual, _, taken = timed(lambda: week(Forces()))
    fine = 2 * library.STEPS
    with patch.object(library, "DEGREE", 50):
        degree = week(Forces())
    for name, flown in (
        ("steps of half the length", week(Forces(), steps=fine)),
        ("the method of order 12", week(Forces(), Order12)),
        ("gravity to 50 × 50", degree),
        ("no drag", week(Forces(drag=0.0))),
        ("no radiation pressure", week(Forces(reflection=0.0))),
        ("low activity", week(Forces(activity="low"))),
        ("high activity", week(Forces(activity="high"))),
    ):
        row(name, f"{math.dist(usual[:3], flown[:3]):.3g} m")
    twice, other = week(Forces(drag=0.0), steps=fine), week(Forces(drag=0.0), Order12)
    apart = math.dist(twice[:3], other[:3])
    row("no drag, steps of half the length against the method of order 12", f"{apart:.3g} m")
    print(f"\na day takes {taken / 7.0:.3f} s of processor time")
