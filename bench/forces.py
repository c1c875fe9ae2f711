"""Refined plans with all forces: agreement, time, misses and corrections.

    python bench/forces.py
    python bench/forces.py --peer

Fields of the family `sso`, on a grid of weeks, are planned and refined with the plans' own burns.
Of their legs those that last a week are flown, and the short ones of a nominal field. First with
all forces off, by which the integrator of the library is compared with that of `fly`; then with all
forces, by the activity of the Sun, with time and processor time. Then what the settings of the
library leave out over a week. ``--peer`` measures heyoka, if it is installed, on a day.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from machine import heading

import adr_opt
from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, MU_M3_S2
from adr_opt.common.processors import usable_cores
from adr_opt.fly.flight.refined import planned_legs
from adr_opt.fly.forces import Forces, fly_forced, library
from adr_opt.fly.forces.flown import fly_leg, plan_field
from adr_opt.fly.forces.library import Moving, World
from adr_opt.fly.forces.settings import WEATHER
from adr_opt.plan.refined_plan import RefinedLeg, RefinedPlan
from adr_opt.problem.instance import Instance

WEEK_S = 7.0 * DAY_S

Field = tuple[Instance, RefinedPlan]


def span_s(leg: RefinedLeg) -> float:
    """Duration of a leg up to its stand-off [s]."""
    return leg.standoff_s - leg.states[0].time_s


def refined(instance: Instance) -> RefinedPlan:
    """A plan of a field, refined with its own burns."""
    plan = adr_opt.solve(instance, "greedy-guarded", time_limit=100.0).plan
    assert plan is not None
    return adr_opt.refine(instance, plan, freedom="planned", jobs=usable_cores())


def week_fields(count: int) -> Iterator[Field]:
    """Fields with the legs of a week of their plans, until there are enough."""
    seed = 0
    while count > 0:
        field = adr_opt.generate("sso", seed)
        grid = {"drift_step_s": WEEK_S, "max_drift_s": WEEK_S, "departure_spacing_s": DAY_S}
        instance = field.replace(transfer=field.transfer.replace(**grid))
        plan = refined(instance)
        legs = tuple(leg for leg in plan.legs if span_s(leg) > 0.9 * WEEK_S)[:count]
        yield instance, plan.replace(legs=legs)
        count, seed = count - len(legs), seed + 1


def short_fields() -> Iterator[Field]:
    """A nominal field under J2."""
    instance = adr_opt.generate("nominal", 0).replace(dynamics="j2")
    yield instance, refined(instance)


def print_agreement(name: str, fields: list[Field]) -> None:
    """Print how far legs are from their stand-offs with all forces off."""
    apart = []
    for instance, plan in fields:
        world, field = plan_field(instance, plan.gravity)
        flown = [
            fly_leg(world, field, leg, instance.transfer.standoff_m)
            for leg in planned_legs(instance, plan)
        ]
        apart += [leg.planned_body.distance_m for leg in flown if leg.planned_body is not None]
    print(
        f"| {name} | {len(apart)} | {np.median(apart):.3f} m | {max(apart):.3f} m | "
        + ", ".join(f"{one:.2f}" for one in apart[:30])
        + " |"
    )


def print_forces(name: str, fields: list[Field]) -> None:
    """Print misses and corrections by the activity of the Sun."""
    for activity in WEATHER:
        began, began_cpu = time.perf_counter(), time.process_time()
        flights = [fly_forced(*field, Forces(activity=activity)) for field in fields]
        wall, cpu = time.perf_counter() - began, time.process_time() - began_cpu
        legs = [leg for flight in flights for leg in flight.legs]
        burns = math.fsum(flight.flown_delta_v_m_s for flight in flights)
        cells = [name, activity, str(len(legs)), f"{burns:.0f} m/s"]
        for kind in ("planned_body", "flown_body"):
            offs = [off for leg in legs if (off := getattr(leg, kind)) is not None]
            far = [1e-3 * off.distance_m for off in offs]
            costs = [off.correction_m_s for off in offs if off.correction_m_s is not None]
            cells += [
                f"{np.median(far):.2f}, {max(far):.1f} km",
                f"{np.median(costs):.2f}, {max(costs):.2f} m/s",
                f"{math.fsum(costs):.1f} m/s",
            ]
        none = [
            f"{leg.leg}" + (" lost" if leg.lost else "") for leg in legs if not leg.is_corrected
        ]
        cells.append(", ".join(none) or "none")
        broken = sum(len(flight.broken_tanks) for flight in flights)
        print(f"| {' | '.join(cells)} | {broken} | {wall:.1f} s | {cpu:.1f} s |", flush=True)


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


def finer(degree: int) -> Any:
    """The same with a gravity field of higher degree."""
    before = library.DEGREE
    library.DEGREE = degree
    try:
        return week(Forces())
    finally:
        library.DEGREE = before


def print_settings() -> None:
    """Print what a week differs by with other settings, and with single forces off."""
    began = time.process_time()
    usual = week(Forces())
    day = (time.process_time() - began) / 7.0
    calm = week(Forces(drag=0.0))
    twice = week(Forces(drag=0.0), steps=2 * library.STEPS)
    rows: list[tuple[str, Callable[[], Any]]] = [
        ("steps of half the length", lambda: week(Forces(), steps=2 * library.STEPS)),
        ("the method of order 12", lambda: week(Forces(), Order12)),
        ("gravity to 50 × 50", lambda: finer(50)),
        ("no drag", lambda: calm),
        ("no radiation pressure", lambda: week(Forces(reflection=0.0))),
        ("low activity", lambda: week(Forces(activity="low"))),
        ("high activity", lambda: week(Forces(activity="high"))),
    ]
    for name, flown in rows:
        print(f"| {name} | {math.dist(usual[:3], flown()[:3]):.3g} m |")
    apart = math.dist(twice[:3], week(Forces(drag=0.0), Order12)[:3])
    print(f"| no drag, steps of half the length against the method of order 12 | {apart:.3g} m |")
    print(f"\na day takes {day:.3f} s of processor time")


def print_peer() -> None:
    """Print what heyoka takes to compile and to fly a day, drag by its network of NRLMSISE-00."""
    import heyoka
    from heyoka import model

    began = time.process_time()
    motion = model.eo_dynamics(
        max_geo_degree=20,
        max_geo_order=20,
        Cb=heyoka.expression(0.022),
        elp2000_thresh=1e-5,
        vsop2013_thresh=1e-7,
    )
    start = 26.0 * 365.25 * DAY_S
    flown = heyoka.taylor_adaptive(
        motion, [7158.0, 0.0, 0.0, 0.0, 0.47, 7.45], time=start, compact_mode=True, tol=1e-12
    )
    compiled = time.process_time() - began
    began = time.process_time()
    flown.propagate_until(start + DAY_S)
    day = time.process_time() - began
    print(f"\nheyoka {heyoka.__version__}: compiled in {compiled:.1f} s, a day in {day:.2f} s")


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--legs", type=int, default=30, help="legs of a week")
    parser.add_argument("--peer", action="store_true", help="measure heyoka as well")
    arguments = parser.parse_args()
    print(heading())
    cases = {"a week": list(week_fields(arguments.legs)), "hours": list(short_fields())}
    print("\n| legs of | legs | median apart | worst apart | m |\n|---|---|---|---|---|")
    for name, fields in cases.items():
        print_agreement(name, fields)
    print(
        "\n| legs of | activity | legs | burns | off plan: median, worst | corrections | in all | "
        "off body: median, worst | corrections | in all | no correction, lost | tanks broken | "
        "time | processor time |"
    )
    print("|---" * 14 + "|")
    for name, fields in cases.items():
        print_forces(name, fields)
    print("\n| a week at 780 km with | ends off by |\n|---|---|")
    print_settings()
    if arguments.peer:
        print_peer()


if __name__ == "__main__":
    main()
