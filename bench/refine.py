"""Refined plans: planned against flown ΔV, misses in another integrator, and times.

    python bench/refine.py

Nominal fields under J2 are planned, refined with the plan's own burns and with free ones, and flown
by `fly`. Then how far bodies part from the mean model that was planned with, with the correction of
their mean motions and without, and what propagation takes beside that of `fly`.
"""

from __future__ import annotations

import argparse
import math
import time

import numpy as np
from machine import heading

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.fly.flight import fly_refined
from adr_opt.fly.refine.bodies import mean_at, moved, state_at_epoch
from adr_opt.judge.refined.world import FreeMotion
from adr_opt.kernels.orbits import equinoctial
from adr_opt.kernels.orbits.gravity import FIELDS
from adr_opt.kernels.orbits.short_periods import osculating

SAMPLES = 200
"""Number of times at which a body is compared with its mean model."""


def print_plans(family: str, seeds: int, method: str, jobs: int) -> None:
    """Print what plans cost when planned and when flown, and how well they arrive."""
    print(f"\n{family} fields under J2, planned by {method}, gravity j2\n")
    print(
        "| field | legs | planned m/s | own burns | free | worst miss | at | "
        "refined in, wall | for 30 legs | flown in, CPU |"
    )
    print("|---" * 10 + "|")
    totals = np.zeros(3)
    for seed in range(seeds):
        instance = adr_opt.generate(family, seed).replace(dynamics="j2")
        plan = adr_opt.solve(instance, method, time_limit=100.0, seed=0).plan
        assert plan is not None
        adr_opt.refine(instance, plan.replace(routes=()), jobs=1)  # kernels are loaded
        own = adr_opt.refine(instance, plan, freedom="planned", jobs=jobs)
        free = adr_opt.refine(instance, plan, freedom="free", jobs=jobs)
        began = time.process_time()
        flights = [fly_refined(instance, one) for one in (own, free)]
        taken = 0.5 * (time.process_time() - began)
        planned = own.planned_delta_v_m_s
        totals += planned, own.flown_delta_v_m_s, free.flown_delta_v_m_s
        legs = len(plan.legs)
        assert own.status == free.status == "complete"
        print(
            f"| {instance.name} | {legs} | {planned:.1f} | "
            f"{own.flown_delta_v_m_s / planned - 1.0:+.2%} | "
            f"{free.flown_delta_v_m_s / planned - 1.0:+.2%} | "
            f"{1e3 * max(flight.worst_miss_m for flight in flights):.2g} mm | "
            f"{1e6 * max(flight.worst_miss_m_s for flight in flights):.2g} µm/s | "
            f"{free.runtime_s:.1f} s | {30.0 / legs * free.runtime_s:.1f} s | {taken:.1f} s |"
        )
    shares = totals[1:] / totals[0] - 1.0
    print(f"| all | | {totals[0]:.1f} | {shares[0]:+.2%} | {shares[1]:+.2%} | | | | | |")


def print_bodies(family: str, days: float, bodies: int) -> None:
    """Print how far bodies part from their mean model, corrected and not."""
    instance = adr_opt.generate(family, 0)
    worst = {True: np.zeros(3), False: np.zeros(3)}
    for orbit in instance.body_orbits[1 : 1 + bodies]:
        for corrected in (True, False):
            state = state_at_epoch(orbit, "j2", days * DAY_S if corrected else 0.0)
            now = 0.0
            for when in np.linspace(0.0, days * DAY_S, SAMPLES):
                state, now = moved(state, when - now, "j2"), when
                model = osculating(*mean_at(orbit, "j2", when), FIELDS["j2"])
                frame = equinoctial.own_frame(model)
                apart = frame @ (state[:3] - model[:3])
                angle = math.atan2(frame[1] @ state[:3], frame[0] @ state[:3])
                radius = math.hypot(*model[:3])
                found = [math.hypot(*state[:3]) - radius, angle * radius, apart[2]]
                worst[corrected] = np.maximum(worst[corrected], np.abs(found))
    for corrected, name in ((True, "corrected"), (False, "as they are")):
        radial, along, across = worst[corrected]
        print(
            f"| {family}, {days:g} days, {name} | {radial:.0f} m | {along:.0f} m | {across:.0f} m |"
        )


def print_propagation(days: float) -> None:
    """Print what propagation takes, and how far two integrators part."""
    orbit = adr_opt.generate("nominal", 0).body_orbits[1]
    state = state_at_epoch(orbit, "j4", 0.0)
    world = FreeMotion("j4")
    moved(state, DAY_S, "j4")
    world.coast(state[:, None], 0.0, DAY_S)
    began = time.process_time()
    there = moved(state, days * DAY_S, "j4")
    own = time.process_time() - began
    began = time.process_time()
    other = world.coast(state[:, None], 0.0, days * DAY_S)[:, 0]
    judge = time.process_time() - began
    apart = 1e3 * math.dist(there[:3], other[:3])
    print(f"| {days:g} days | {1e3 * own:.1f} ms | {1e3 * judge:.1f} ms | {apart:.2g} mm |")


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--family", default="nominal")
    parser.add_argument("--seeds", type=int, default=4, help="fields, by seed from 0")
    parser.add_argument("--method", default="greedy-guarded")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--bodies", type=int, default=10, help="that are compared with the model")
    arguments = parser.parse_args()
    print(heading())
    print_plans(arguments.family, arguments.seeds, arguments.method, arguments.jobs)
    print("\n| bodies against their mean model, worst | radially | along | across |")
    print("|---|---|---|---|")
    print_bodies("nominal", 7.0, arguments.bodies)
    print_bodies("rocket-bodies", 365.0, arguments.bodies)
    print("\n| one body in the field J4 | collocation | `fly` | apart |\n|---|---|---|---|")
    for days in (7.0, 60.0, 730.0):
        print_propagation(days)


if __name__ == "__main__":
    main()
